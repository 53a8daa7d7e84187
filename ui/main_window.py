"""The main window: puts rail, bar, banners and places together and binds the commands."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from PySide6.QtCore import QByteArray, QSize, Qt, QTimer
from PySide6.QtGui import QActionGroup, QCloseEvent, QGuiApplication, QResizeEvent
from PySide6.QtWidgets import (
    QApplication,
    QHBoxLayout,
    QMainWindow,
    QMenu,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from gsapp.session.user_limit_store import UserLimitStore
from ui.appearance_controller import AppearanceController
from ui.commands import CommandRequirement, CommandSet
from ui.dialogs.about import AboutDialog, about_lines
from ui.dialogs.flight_dialogs import ask_closing
from ui.dialogs.guide import GuideWindow, guide_folder
from ui.dialogs.mavlink_inspector import MavlinkInspector
from ui.dialogs.messages import MessagesDialog
from ui.dialogs.shortcuts import ShortcutsDialog
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReport, ErrorReporter
from ui.file_menu_controller import FileMenuController
from ui.flight.controls import ActionButton
from ui.flight.flight_page import FlightPage
from ui.flight.flight_page_controller import FlightPageController
from ui.flight.flight_view import FlightView
from ui.flight.layout_store import LayoutStore
from ui.flight.link_rows import describe_vehicle
from ui.flight_controller import FlightController
from ui.gap.gap_page import GapPage
from ui.page_registry import PAGES
from ui.pilot.pilot_page import PilotPage
from ui.preflight.preflight_page import PreflightPage
from ui.recent_flights import RecentFlights
from ui.review.review_page import ReviewPage
from ui.settings import SettingsStore, layouts_path, limits_path
from ui.shortcut_filter import ShortcutOverrideFilter
from ui.start_page import StartPage
from ui.voice.voice import Voice
from ui.window_frame.banners import BannerStack
from ui.window_frame.file_drop_filter import FileDropFilter
from ui.window_frame.navigation_rail import NavigationRail
from ui.window_frame.status_bar import StatusBar

log = logging.getLogger(__name__)

_FIRST_SIZE = QSize(1280, 800)


class MainWindow(QMainWindow):
    """The ground station window.

    Parameters
    ----------
    store : SettingsStore
        What is remembered.
    faults : ErrorReporter
        Where errors arrive.
    offer_recorders : bool
        Whether to look for recorders that run and offer to attach to them.

    Attributes
    ----------
    desk : FlightController
        The open flight.
    voice : Voice
        What is heard, with its mute.
    """

    def __init__(
        self, store: SettingsStore, faults: ErrorReporter, *, offer_recorders: bool = True
    ) -> None:
        super().__init__()
        settings = store.current
        self.setWindowTitle("Ground station")
        self.store = store
        self.faults = faults
        self.look = DisplayStyle(settings.theme, settings.scale, settings.units)
        self.appearance = AppearanceController(self.look, store, self)
        self.commands = CommandSet(self)
        self.banners = BannerStack(self.look)
        self.desk = FlightController(faults, store, self)
        self.recent_flights = RecentFlights(self.desk, store)
        layouts = LayoutStore(layouts_path(store.path))
        self.view = FlightView(self.commands.actions, self.look, store, layouts)
        self.flight_place = FlightPage(StartPage(self.look), self.view)
        self.opening = FileMenuController(self, self.desk, self.look, store, self.banners)
        limits = UserLimitStore(limits_path(store.path))
        self.voice = Voice(self, muted=settings.muted)
        self.crew = FlightPageController(
            self, self.desk, self.view, self.look, store, limits, self.voice
        )
        stop = ActionButton(self.commands.actions["stop_recording"], "Stop", self.look)
        self.bar = StatusBar(self.look, {"record": stop})
        self.rail = NavigationRail(self.look)
        self.gap = GapPage(self.commands.actions, self.look, store, self.banners, faults)
        self.preflight = PreflightPage(
            self.commands.actions, self.look, store, self.banners, faults, self.desk, self.voice
        )
        self.pilot = PilotPage(
            self.commands.actions, self.look, store, faults, self.desk, self.voice
        )
        self.review = ReviewPage(self.commands.actions, self.look, store, self.banners, faults)
        self.places = QStackedWidget()
        self._place_ids = [place.id for place in PAGES]
        self._asks = True
        built: dict[str, QWidget] = {
            "preflight": self.preflight,
            "flight": self.flight_place,
            "pilot": self.pilot,
            "review": self.review,
            "gap": self.gap,
        }
        for place in PAGES:
            self.places.addWidget(built[place.id])
        self._arrange()
        # Once, when everything is in its place: Qt styles anew whatever moves.
        self.appearance.apply()
        self._bind()
        self._keeper = ShortcutOverrideFilter(self)
        self._keeper.begin()
        application = QApplication.instance()
        if application is not None:
            # Windows, and desktops that remember sessions, tell so before they close windows.
            application.commitDataRequest.connect(self.ask_nothing)
        self._restore_geometry(settings.geometry)
        self.show_place("flight")
        store.refused = lambda sentence: self.banners.show_banner("caution", sentence)
        for complaint in (store.complaint, limits.complaint, *layouts.complaints):
            if complaint:
                self.banners.show_banner("caution", complaint)
        self._flight_changed()
        if settings.pilot_window:
            # When the main window has its screen.
            QTimer.singleShot(0, self.pilot.own_window, self.pilot.own_window.open)
        if offer_recorders:
            self.opening.look_for_recorders()

    def _arrange(self) -> None:
        body = QWidget()
        body.setObjectName("frame")
        row = QHBoxLayout(body)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        row.addWidget(self.rail)
        column = QVBoxLayout()
        column.setSpacing(0)
        column.addWidget(self.bar)
        column.addWidget(self.places, 1)
        column.addWidget(self.banners)
        row.addLayout(column, 1)
        self.setCentralWidget(body)
        self.setMinimumSize(640, 400)

    def _bind(self) -> None:
        commands = self.commands
        commands.fill(self.menuBar())
        commands.bind(
            self.handlers, self.appearance.handlers, self.opening.handlers, self.crew.handlers,
            self.view.handlers, self.gap.handlers, self.preflight.handlers,
            self.pilot.handlers, self.review.handlers,
        )  # fmt: skip
        actions = commands.actions
        self.rail.chosen.connect(lambda name: actions[f"place_{name}"].trigger())
        self.flight_place.start.chosen.connect(lambda name: actions[name].trigger())
        start = self.flight_place.start
        start.link_chosen.connect(self.opening.connect_link)
        start.flight_chosen.connect(lambda path: self.opening.open_path(Path(path)))
        start.flight_removed.connect(self._forget_flight)
        self.bar.pressed.connect(self._bar_pressed)
        self.banners.listed.connect(actions["messages"].trigger)
        self.faults.raised.connect(self._show_fault)
        self.look.changed.connect(self._fit)
        self.appearance.announce(commands, self.banners)
        self.appearance.saved.connect(self.pilot.refresh)
        self.appearance.layout_reset.connect(self.view.follow_settings)
        self.desk.changed.connect(self._flight_changed)
        self.desk.leaving.connect(self.view.marks.view.finish_edit)
        self.view.wanted.connect(lambda: self.show_place("flight"))
        self.desk.painted.connect(self.view.advance)
        self.desk.told.connect(self._refresh)
        self.gap.wanted.connect(lambda: self.show_place("gap"))
        self.gap.changed.connect(self._enable)
        self.review.wanted.connect(lambda: self.show_place("review"))
        self.review.changed.connect(self._enable)
        self.preflight.changed.connect(self._enable)
        self.pilot.changed.connect(self._enable)
        self.pilot.wanted.connect(lambda: self.show_place("pilot"))
        self.pilot.debrief.asked_for.connect(self._show_time)
        self.opening.review_wanted.connect(self._review)
        self.preflight.started.connect(lambda: self.show_place("flight"))
        FileDropFilter(self).dropped.connect(self.opening.open_dropped)
        FileDropFilter(self.review).dropped.connect(self.review.add)
        FileDropFilter(self.gap).dropped.connect(self.gap.add)
        commands.check("mute", self.store.current.muted)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands of the window itself do."""
        places = {
            f"place_{name}": lambda name=name: self.show_place(name) for name in self._place_ids
        }
        return {
            **places,
            "full_screen": self.toggle_full_screen,
            "keys": lambda: ShortcutsDialog(self.look, self).exec(),
            "link": self.show_link,
            "copy_details": self.copy_details,
            "undo": self.undo,
            "dismiss": self.banners.dismiss,
            "messages": self.show_messages,
            "about": lambda: AboutDialog(self.look, about_lines(self.store), self).exec(),
            "guide": self.show_guide,
            "quit": self.close,
        }

    # Places

    def show_place(self, place_id: str) -> None:
        """Go to a place by its id."""
        self.places.setCurrentIndex(self._place_ids.index(place_id))
        self.rail.show_place(place_id)
        self._enable()
        if place_id == "flight":
            (self.view.charts if self.desk.is_open else self.flight_place.start).setFocus()
            return
        guides = {
            "preflight": self.preflight, "pilot": self.pilot, "review": self.review,
            "gap": self.gap,
        }  # fmt: skip
        guides[place_id].begin()

    def _show_time(self, at: float) -> None:
        """Show a flight time (s) in the charts."""
        self.show_place("flight")
        self.crew.show_time(at)

    def toggle_full_screen(self) -> None:
        """Fill the screen, or come back to the window as it was, maximized or not.

        The menu bar stays: its commands would have no keys without it.
        """
        self.setWindowState(self.windowState() ^ Qt.WindowState.WindowFullScreen)
        self.commands.check("full_screen", self.isFullScreen())

    def _bar_pressed(self, part: str) -> None:
        targets = {
            "alarms": "panel_alarms", "sound": "mute", "flight": "place_flight",
            "record": "recorders",
        }  # fmt: skip
        if part in targets:
            self.commands.actions[targets[part]].trigger()
        elif part == "link":
            self.show_systems()

    def show_systems(self) -> None:
        """Offer the systems heard on the link, of which one is the flown one."""
        session = self.desk.session
        if session is None:
            return
        report = session.link_report()
        menu = QMenu("Flown system", self)
        menu.setObjectName("flown_system")
        group = QActionGroup(menu)
        for vehicle in () if report is None else report.vehicles:
            words = describe_vehicle(vehicle, live=not self.desk.is_replay)
            action = menu.addAction(words, partial(self.desk.choose_system, vehicle.system))
            action.setCheckable(True)
            action.setChecked(report is not None and vehicle.system == report.system)
            group.addAction(action)
        if menu.isEmpty():
            menu.addAction("No aircraft heard").setEnabled(False)
        menu.addSeparator()
        menu.addAction(self.commands.actions["link"])
        tile = self.bar.views["link"]
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(tile.mapToGlobal(tile.rect().bottomLeft()))

    def _review(self, folder: Path) -> None:
        """Review a flight that has ended."""
        self.show_place("review")
        self.review.add([folder])

    def show_link(self) -> None:
        """Show what comes over the link, by sender and by message, for as long as one looks."""
        session = self.desk.session
        if session is not None:
            live = session.replaying is None
            dialog = MavlinkInspector(self.look, session.link_report, live=live, parent=self)
            self.desk.told.connect(dialog.refresh)
            dialog.exec()

    # Help

    def show_guide(self) -> None:
        """Open the user guide in a window of its own."""
        folder = guide_folder()
        if folder is None:
            self.banners.show_banner("caution", "The user guide is not installed.")
            return
        GuideWindow(self.look, folder, self).show()

    def show_messages(self) -> None:
        """Open the list of messages in a window of its own."""
        for former in self.findChildren(MessagesDialog):
            former.close()
        MessagesDialog(self.look, self.banners, self).show()

    # What happens

    def _flight_changed(self) -> None:
        """Another flight is open, or none."""
        self.flight_place.show_flight(self.desk.is_open)
        self.flight_place.start.show_links(self.store.current.links)
        if not self.desk.is_open:
            self.flight_place.start.show_flights(self.store.current.recent_flights)
        self.view.show_history(self.desk.history)
        path = self.desk.session.path if self.desk.session is not None else None
        self.gap.show_open(path)
        self.review.show_open(path)
        self._enable()
        name = self.desk.name
        self.setWindowTitle(f"{name} – Ground station" if name else "Ground station")
        self._refresh()

    def _forget_flight(self, path: str) -> None:
        self.recent_flights.remove(path)
        self.flight_place.start.show_flights(self.store.current.recent_flights)

    def _refresh(self) -> None:
        """Show what the session says now, beside the samples."""
        if self.desk.is_open:
            self.view.show_picture(self.desk.picture(self.look.units))
        self.bar.show_parts(self.desk.bar_parts(self.look.units, muted=self.store.current.muted))
        self._enable()
        self.crew.sound()

    def _enable(self) -> None:
        """Gray the commands that have nothing to act on at this place."""
        undoes = self.desk.is_open
        if self.gap.shown:
            undoes = self.gap.search.can_undo
        elif self.preflight.shown:
            undoes = self.preflight.can_undo
        elif self.review.shown:
            undoes = self.review.can_undo
        found: list[CommandRequirement] = [
            *self.desk.present, *self.gap.present, *self.preflight.present, *self.pilot.present,
            *self.review.present,
        ]  # fmt: skip
        if "search" in found and "review_busy" in found:
            # One key stops both: it means the one on screen.
            found.remove("search" if self.review.shown else "review_busy")
        if undoes:
            found.append("change")
        if self.desk.is_open and self.places.currentWidget() is self.flight_place:
            found.append("charts")
        self.commands.enable(found)

    def undo(self) -> None:
        """Take back the last change of what is on screen."""
        if self.gap.shown:
            self.gap.search.undo()
        elif self.preflight.shown:
            self.preflight.undo()
        elif self.review.shown:
            self.review.undo()
        else:
            self.desk.undo_mark()

    def _show_fault(self, fault: ErrorReport) -> None:
        copy = ("Copy details", self.copy_details)
        choices = () if fault.expected else (copy,)
        banner = self.banners.show_banner("warning", fault.sentence, *choices)
        if fault.opening:
            self.opening.until_next(banner)

    def copy_details(self) -> None:
        """Put the details of the last error on the clipboard."""
        fault = self.faults.last
        if fault is None:
            self.banners.show_banner("note", "There was no error.")
            return
        QGuiApplication.clipboard().setText(fault.details)
        self.banners.show_banner("note", "The details of the last error are on the clipboard.")

    # Beginning and end

    def _restore_geometry(self, saved: str) -> None:
        self.resize(_FIRST_SIZE)
        if saved:
            self.restoreGeometry(QByteArray.fromHex(saved.encode("ascii")))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the rail's room to the charts where the window is narrow."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        self.rail.fit(self.width())
        self.bar.fit(self.height())
        self.banners.fit(self.height())

    def end(self) -> None:
        """Close without a question, dialogs included; what is recorded goes on.

        For a session that ends, or a terminal that is closed: nobody may be there to answer, and
        who waits too long is ended.
        """
        self.ask_nothing()
        while (dialog := QApplication.activeModalWidget()) is not None and dialog.close():
            pass
        self.close()
        QApplication.quit()

    def ask_nothing(self) -> None:
        """Close without a question from here on: the user's session ends."""
        self._asks = False

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about works and recordings, remember the window, and close."""
        for_trial = self.pilot.training.running or self.preflight.practices
        elsewhere = self.desk.recording_elsewhere
        names = [recorder.folder.name for recorder in elsewhere]
        if self.desk.records_here and not for_trial:
            names.insert(0, self.desk.name or "The flight")
        works = (*self.opening.unfinished, *self.review.unfinished, *self.gap.unfinished)
        asks = self._asks and (names or works)
        answer = ask_closing(self, names, works) if asks else "leave"
        if answer == "stay" and self._asks:
            event.ignore()
            return
        if for_trial or answer == "stop":
            self.desk.stop_now()
        if answer == "stop":
            self.desk.stop_recorders(*elsewhere)
        geometry = self.saveGeometry().toHex().data().decode("ascii")
        self.store.change(geometry=geometry)
        self.opening.give_up()
        self.gap.close_search()
        self.review.close_work()
        self.preflight.flush()
        self.preflight.close_calibration()
        self.pilot.own_window.close_with_main()
        self.pilot.training.stop()
        self.desk.close()
        self._keeper.end()
        event.accept()
