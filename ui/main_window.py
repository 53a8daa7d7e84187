"""The main window: puts rail, bar, banners and pages together and binds the commands."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from PySide6.QtCore import QByteArray, QEvent, QObject, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QActionGroup, QCloseEvent, QDropEvent, QResizeEvent
from PySide6.QtWidgets import (
    QApplication,
    QHBoxLayout,
    QMainWindow,
    QMenu,
    QVBoxLayout,
    QWidget,
)

from gsapp.decoding.sender_filter import host_of
from gsapp.session.user_limit_store import UserLimitStore
from ui.appearance_controller import AppearanceController
from ui.commands import CommandRequirement, CommandSet
from ui.dialogs.flight_dialogs import ask_closing
from ui.dialogs.mavlink_inspector import MavlinkInspector, describe_rejected, describe_vehicle
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReport, ErrorReporter
from ui.file_menu_controller import FileMenuController
from ui.flight.chart_layouts import LayoutStore
from ui.flight.flight_page_controller import FlightPage, FlightPageController
from ui.flight.flight_view import FlightView
from ui.flight_controller import FlightController
from ui.focus_controller import FocusController
from ui.gap.gap_page import GapPage
from ui.help_menu import HelpMenuController
from ui.pilot.pilot_page import PilotPage
from ui.preflight.preflight_page import PreflightPage
from ui.review.review_page import ReviewPage
from ui.settings import SettingsStore, layouts_path, limits_path
from ui.shortcut_filter import ShortcutOverrideFilter
from ui.start_page import RecentFlights, StartPage
from ui.translation import tr
from ui.voice.voice import Voice
from ui.web_page.page_controller import WebPageController
from ui.widgets.action_button import ActionButton
from ui.widgets.flow_layout import arrange
from ui.widgets.layout_widgets import PageScrollArea, PageStack
from ui.window_frame.banners import BannerStack
from ui.window_frame.navigation_rail import PAGES, NavigationRail
from ui.window_frame.status_bar import StatusBar
from ui.window_frame.status_bar_model import StatusItem, session_status_items
from ui.window_frame.step_page import WindowPage


def create_system_menu(
    controller: FlightController, link_action: QAction, parent: QWidget
) -> QMenu | None:
    """Return the menu, deleted when it closes; None without a flight."""
    session = controller.session
    if session is None:
        return None
    report = session.link_report()
    menu = QMenu(tr("Flown system"), parent)
    menu.setObjectName("flown_system")
    menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    group = QActionGroup(menu)
    for vehicle in () if report is None else report.vehicles:
        action = menu.addAction(
            describe_vehicle(vehicle, live=not controller.is_replay),
            partial(controller.select_system, vehicle.system, host_of(vehicle.address)),
        )
        action.setCheckable(True)
        action.setChecked(report is not None and vehicle.system == report.system)
        group.addAction(action)
    for other in () if report is None else report.rejected_vehicles:
        action = menu.addAction(
            describe_rejected(other), partial(controller.select_system, other.system, other.address)
        )
        action.setCheckable(True)
        group.addAction(action)
    if menu.isEmpty():
        menu.addAction(tr("No aircraft found")).setEnabled(False)
    menu.addSeparator()
    menu.addAction(link_action)
    return menu


_DRAGS = (QEvent.Type.DragEnter, QEvent.Type.DragMove)


class FileDropFilter(QObject):
    """Takes what is dropped on a widget, or on what lies in it and takes nothing itself."""

    dropped = Signal(object)  # Paths, a tuple, once the file manager was answered.
    _taken = Signal(object)

    def __init__(self, target: QWidget) -> None:
        super().__init__(target)
        # A question asked within the event would hold up the file manager.
        self._taken.connect(self.dropped, Qt.ConnectionType.QueuedConnection)
        target.setAcceptDrops(True)
        target.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if isinstance(event, QDropEvent) and (paths := _dropped_paths(event)):
            # Whatever was proposed: moved, the flight would be taken away where it lay.
            event.setDropAction(Qt.DropAction.CopyAction)
            event.accept()
            if event.type() not in _DRAGS:
                self._taken.emit(paths)
            return True
        return super().eventFilter(watched, event)


def _dropped_paths(event: QDropEvent) -> tuple[Path, ...]:
    urls = event.mimeData().urls()
    return tuple(Path(url.toLocalFile()) for url in urls if url.isLocalFile())


log = logging.getLogger(__name__)

_FIRST_SIZE = QSize(1280, 800)


class MainWindow(QMainWindow):
    """The ground station window."""

    def __init__(
        self, store: SettingsStore, error_reporter: ErrorReporter, *, offer_recorders: bool = True
    ) -> None:
        super().__init__()
        settings = store.current
        self.setWindowTitle(tr("Ground station"))
        self.store = store
        self.error_reporter = error_reporter
        self.display_style = DisplayStyle(settings.theme, settings.scale, settings.units)
        self.appearance = AppearanceController(self.display_style, store, self)
        self.commands = CommandSet(self)
        self.banners = BannerStack(self.display_style)
        self.flight_controller = FlightController(error_reporter, store, self)  # The open flight.
        self.recent_flights = RecentFlights(self.flight_controller, store)
        layouts = LayoutStore(layouts_path(store.path))
        self.view = FlightView(self.commands.actions, self.display_style, store, layouts)
        self.flight_page = FlightPage(StartPage(self.display_style), self.view)
        self.web_page = WebPageController(
            lambda: self.flight_controller.session,
            lambda: self.view.charts.strip_layout.strips,
            lambda: self.display_style.units,
            error_reporter,
            self,
        )
        self.file_menu = FileMenuController(
            self, self.flight_controller, self.display_style, store, self.banners, self.web_page
        )
        self.help_menu = HelpMenuController(
            self, self.display_style, store, self.banners, error_reporter
        )
        limits = UserLimitStore(limits_path(store.path))
        self.voice = Voice(self, muted=settings.muted)  # What is heard, with its mute.
        self.crew = FlightPageController(
            self, self.flight_controller, self.view, self.display_style, store, limits, self.voice
        )
        stop = ActionButton(self.commands.actions["stop_recording"], tr("Stop"), self.display_style)
        self.status_bar = StatusBar(self.display_style, {"record": stop})
        self.navigation_rail = NavigationRail(self.display_style)
        self.gap_page = GapPage(
            self.commands.actions, self.display_style, store, self.banners, error_reporter
        )
        self.preflight_page = PreflightPage(
            self.commands.actions,
            self.display_style,
            store,
            self.banners,
            error_reporter,
            self.flight_controller,
            self.voice,
        )
        self.pilot_page = PilotPage(
            self.commands.actions,
            self.display_style,
            store,
            error_reporter,
            self.flight_controller,
            self.voice,
        )
        self.review_page = ReviewPage(
            self.commands.actions, self.display_style, store, self.banners, error_reporter
        )
        self.pages = PageStack()
        self._page_ids = [place.id for place in PAGES]
        self._confirms_close = True
        self._built_pages: Mapping[
            str, FlightPage | GapPage | PilotPage | PreflightPage | ReviewPage
        ] = {
            "preflight": self.preflight_page, "flight": self.flight_page,
            "pilot": self.pilot_page, "review": self.review_page, "gap": self.gap_page,
        }  # fmt: skip
        for place in PAGES:
            self.pages.addWidget(self._built_pages[place.id])
        self._arrange()
        # Once, when everything is in its place: Qt styles anew whatever moves.
        self.appearance.apply()
        self._bind()
        self._shortcut_filter = ShortcutOverrideFilter(self)
        self._shortcut_filter.install()
        self._focus_controller = FocusController(self)
        application = QApplication.instance()
        if isinstance(application, QApplication):
            # Windows, and desktops that remember sessions, tell so before they close windows.
            application.commitDataRequest.connect(self.disable_close_questions)
        self._restore_geometry(settings.geometry)
        self.show_page("flight")
        store.on_write_error = lambda sentence: self.banners.show_banner("caution", sentence)
        for complaint in (store.error_text, limits.error_text, *layouts.read_errors):
            if complaint:
                self.banners.show_banner("caution", complaint)
        self._flight_changed()
        if settings.pilot_window:
            # When the main window has its screen.
            QTimer.singleShot(0, self.pilot_page.own_window, self.pilot_page.own_window.open)
        if offer_recorders:
            self.file_menu.offer_recorders()

    def _arrange(self) -> None:
        body = QWidget()
        body.setObjectName("frame")
        row = arrange(QHBoxLayout(body), 0)
        row.addWidget(self.navigation_rail)
        column = QVBoxLayout()
        column.setSpacing(0)
        column.addWidget(self.status_bar)
        column.addWidget(PageScrollArea(self.pages), 1)
        column.addWidget(self.banners)
        row.addLayout(column, 1)
        self.setCentralWidget(body)
        self.setMinimumSize(512, 320)  # A screen of 1280 x 800 at 250 %.

    def _bind(self) -> None:
        commands = self.commands
        commands.fill_menu_bar(self.menuBar())
        commands.bind(
            self.handlers, self.appearance.handlers, self.file_menu.handlers,
            self.help_menu.handlers, self.crew.handlers, self.view.handlers,
            self.gap_page.handlers, self.preflight_page.handlers,
            self.pilot_page.handlers, self.review_page.handlers,
        )  # fmt: skip
        actions = commands.actions
        self.navigation_rail.page_selected.connect(lambda name: actions[f"place_{name}"].trigger())
        self.flight_page.start.chosen.connect(lambda name: actions[name].trigger())
        start = self.flight_page.start
        start.link_chosen.connect(self.file_menu.connect_link)
        start.flight_chosen.connect(lambda path: self.file_menu.open_path(Path(path)))
        start.flight_removed.connect(self._remove_recent_flight)
        self.status_bar.pressed.connect(self._bar_pressed)
        self.banners.list_requested.connect(actions["messages"].trigger)
        self.error_reporter.error_reported.connect(self._show_fault)
        self.display_style.changed.connect(self._fit)
        self.appearance.connect_window(commands, self.banners)
        self.appearance.saved.connect(self.pilot_page.refresh)
        self.appearance.layout_reset.connect(self.view.apply_settings)
        self.flight_controller.changed.connect(self._flight_changed)
        self.flight_controller.about_to_close.connect(self.view.marks.view.finish_edit)
        self.view.show_requested.connect(lambda: self.show_page("flight"))
        self.flight_controller.frame_requested.connect(self.view.advance)
        self.flight_controller.refreshed.connect(self._refresh)
        self.web_page.changed.connect(self._refresh)
        self.gap_page.show_requested.connect(lambda: self.show_page("gap"))
        self.gap_page.changed.connect(self._enable)
        for page in (self.gap_page, self.view.estimates.search):
            page.cards_requested.connect(self.preflight_page.add_cards)
        self.review_page.show_requested.connect(lambda: self.show_page("review"))
        self.review_page.changed.connect(self._enable)
        self.preflight_page.changed.connect(self._enable)
        self.pilot_page.changed.connect(self._enable)
        self.pilot_page.show_requested.connect(lambda: self.show_page("pilot"))
        self.pilot_page.debrief.time_requested.connect(self._show_time)
        self.file_menu.review_requested.connect(self._review)
        self.preflight_page.flight_started.connect(lambda: self.show_page("flight"))
        FileDropFilter(self).dropped.connect(self.file_menu.open_dropped)
        FileDropFilter(self.review_page).dropped.connect(self.review_page.add_flights)
        FileDropFilter(self.gap_page).dropped.connect(self.gap_page.add_flights)
        commands.check("mute", self.store.current.muted)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        places = {
            f"place_{name}": lambda name=name: self.show_page(name) for name in self._page_ids
        }
        return {
            **places,
            "full_screen": self.toggle_full_screen,
            "link": self.show_link,
            "undo": self.undo,
            "redo": self.redo,
            "dismiss": self.banners.dismiss,
            "quit": self.close,
        }

    # Places

    def show_page(self, place_id: str) -> None:
        self.pages.setCurrentIndex(self._page_ids.index(place_id))
        self.navigation_rail.show_page(place_id)
        self._enable()
        self._built_pages[place_id].set_initial_focus()

    def _show_time(self, at: float) -> None:
        self.show_page("flight")
        self.crew.go_to_time(at)

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
        link_action = self.commands.actions["link"]
        menu = create_system_menu(self.flight_controller, link_action, self)
        if menu is not None:
            tile = self.status_bar.item_widgets["link"]
            menu.popup(tile.mapToGlobal(tile.rect().bottomLeft()))

    def _review(self, folder: Path) -> None:
        self.show_page("review")
        self.review_page.add_flights([folder])

    def show_link(self) -> None:
        """Show what comes over the link, by sender and by message, for as long as one looks."""
        session = self.flight_controller.session
        if session is not None:
            live = session.replay_feed is None
            dialog = MavlinkInspector(
                self.display_style, session.link_report, live=live, parent=self
            )
            self.flight_controller.refreshed.connect(dialog.refresh)
            dialog.fields_requested.connect(self._chart_fields)
            dialog.exec()

    def _chart_fields(self, message: str) -> None:
        self.flight_controller.keep_fields(message)
        self.view.show_panel(0)
        self.view.channels.search.setText(f"{message}.")

    # What happens

    def _flight_changed(self) -> None:
        self.flight_page.show_flight(self.flight_controller.is_open)
        self.flight_page.start.show_links(self.store.current.links)
        if not self.flight_controller.is_open:
            self.flight_page.start.show_flights(self.store.current.recent_flights)
        self.view.show_history(self.flight_controller.history)
        path = (
            self.flight_controller.session.path
            if self.flight_controller.session is not None
            else None
        )
        self.gap_page.set_open_flight(path)
        self.review_page.set_open_flight(path)
        self._enable()
        name = self.flight_controller.name
        self.setWindowTitle(
            tr("{name} – Ground station").format(name=name) if name else tr("Ground station")
        )
        self._refresh()

    def _remove_recent_flight(self, path: str) -> None:
        self.recent_flights.remove(path)
        self.flight_page.start.show_flights(self.store.current.recent_flights)

    def _status_items(self) -> tuple[StatusItem, ...]:
        controller, units = self.flight_controller, self.display_style.units
        others = tuple(found.name for found in controller.recorders.others)
        state = (controller.session, controller.snapshot, others, units)
        return session_status_items(
            *state, muted=self.store.current.muted, page_url=self.web_page.url
        )

    def _refresh(self) -> None:
        if self.flight_controller.is_open:
            self.view.show_state(self.crew.view_state())
        controller = self.flight_controller
        self.navigation_rail.attitude.show_flight(controller.history, controller.time)
        self.status_bar.show_items(self._status_items())
        self._enable()
        self.crew.sound_alarms()

    def _enable(self) -> None:
        found: list[CommandRequirement] = [
            *self.flight_controller.present, *self.gap_page.present, *self.preflight_page.present,
            *self.pilot_page.present,
            *self.review_page.present,
        ]  # fmt: skip
        if "search" in found and "review_busy" in found:
            # One key stops both: it means the one on screen.
            found.remove("search" if self.review_page.shown else "review_busy")
        found += self._undo_requirements()
        if self.flight_controller.is_open and self.pages.currentWidget() is self.flight_page:
            found.append("charts")
        self.commands.update_enabled(found)

    @property
    def _shown_page(self) -> WindowPage | None:
        """Return the page on screen whose changes can be undone; None for the charts."""
        pages = (self.gap_page, self.preflight_page, self.review_page)
        return next((page for page in pages if page.shown), None)

    def _undo_requirements(self) -> list[CommandRequirement]:
        page = self._shown_page
        history = None if page is None else page.undo_history
        undo_text = "" if history is None else history.undoText()
        redo_text = "" if history is None else history.redoText()
        self.commands.actions["undo"].setText(tr("Undo {text}").format(text=undo_text).rstrip())
        self.commands.actions["redo"].setText(tr("Redo {text}").format(text=redo_text).rstrip())
        if page is None:
            return ["change"] if self.flight_controller.is_open else []
        found: list[CommandRequirement] = []
        if history is not None and history.canUndo():
            found.append("change")
        if history is not None and history.canRedo():
            found.append("undone_change")
        return found

    def undo(self) -> None:
        page = self._shown_page
        (self.flight_controller.undo_mark if page is None else page.undo)()
        # The stack knows only afterwards what can be undone and redone.
        self._enable()

    def redo(self) -> None:
        page = self._shown_page
        if page is not None:
            page.redo()
            self._enable()

    def _show_fault(self, fault: ErrorReport) -> None:
        copy = (tr("Copy details"), self.help_menu.copy_details)
        choices = () if fault.is_expected else (copy,)
        banner = self.banners.show_banner("warning", fault.message, *choices)
        if fault.is_opening_error:
            self.file_menu.remove_with_flight(banner)

    # Beginning and end

    def _restore_geometry(self, saved: str) -> None:
        self.resize(_FIRST_SIZE)
        if saved:
            self.restoreGeometry(QByteArray.fromHex(saved.encode("ascii")))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        self.navigation_rail.fit(self.width())
        self.status_bar.fit(self.height())
        self.banners.fit(self.height())

    def close_without_asking(self) -> None:
        """Close without a question, dialogs included; what is recorded goes on.

        For a session that ends, or a terminal that is closed: nobody may be there to answer, and
        who waits too long is ended.
        """
        self.disable_close_questions()
        while (dialog := QApplication.activeModalWidget()) is not None and dialog.close():
            pass
        self.close()
        QApplication.quit()

    def disable_close_questions(self) -> None:
        """Close without a question from here on: the user's session ends."""
        self._confirms_close = False

    def closeEvent(self, event: QCloseEvent) -> None:
        for_trial = self.pilot_page.training.running or self.preflight_page.is_practice
        elsewhere = self.flight_controller.recorders.left_running
        names = [recorder.name for recorder in elsewhere]
        if self.flight_controller.is_recording and not for_trial:
            names.insert(0, self.flight_controller.name or tr("The flight"))
        works = (
            *self.file_menu.jobs.unfinished_jobs,
            *self.review_page.unfinished_work_title,
            *self.gap_page.unfinished_work_title,
        )
        asks = self._confirms_close and (names or works)
        caution = self.flight_controller.closing_caution(elsewhere)
        ask = partial(ask_closing, caution=caution) if caution else ask_closing
        answer = ask(self, names, works) if asks else "leave"
        if answer == "stay" and self._confirms_close:
            event.ignore()
            return
        if for_trial or answer == "stop":
            self.flight_controller.recorders.stop_recording_and_wait()
        if answer == "stop":
            self.flight_controller.recorders.stop_and_wait(
                *(recorder.handle for recorder in elsewhere)
            )
        geometry = bytes(self.saveGeometry().toHex().data()).decode("ascii")
        self.store.change(geometry=geometry)
        self.file_menu.jobs.stop_jobs()
        self.web_page.stop()
        self.gap_page.close_search()
        self.review_page.close_work()
        self.preflight_page.flush()
        self.preflight_page.close_calibration()
        self.pilot_page.own_window.close_with_main()
        self.pilot_page.training.stop()
        self.flight_controller.close()
        self._shortcut_filter.remove()
        event.accept()
