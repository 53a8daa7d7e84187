"""Where a flight comes from: the dialogs of the File menu, and recorders found running."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtGui import QCursor
from PySide6.QtWidgets import QMenu, QWidget

from calibration import shipped_certificate_sets
from gsapp.decoding.channel_map import shipped_channel_maps
from gsapp.flight.flight_loader import load_flight
from gsapp.telemetry.recorder_folder import next_free_folder, record_state
from ui.background_job import BackgroundJob
from ui.commands import shortcut_text
from ui.dialogs.connect import ConnectDialog, connection_options
from ui.dialogs.file_dialogs import ask_flight_folder, ask_open_file
from ui.dialogs.file_fields import FlightFolderField, RecordingDialog
from ui.dialogs.flight_dialogs import (
    CertificatesDialog,
    ChannelMapDialog,
    ExportDialog,
    ask_append,
    ask_stop,
)
from ui.dialogs.flight_requests import ConnectRequest
from ui.dialogs.virtual_flight import VirtualFlightDialog, virtual_flight_options
from ui.display_style import DisplayStyle
from ui.flight_controller import FlightController
from ui.number_format import clock_text
from ui.recorder_controller import PendingFlight, RunningRecorder
from ui.settings import SettingsStore, initial_dialog_folder, recording_folder
from ui.sharing_menu import SharingMenu
from ui.translation import tr
from ui.web_page.page_controller import WebPageController
from ui.window_frame.banners import Banner, BannerStack
from ui.window_frame.job_banner import JobBannerController


class FileMenuController(QObject):
    """Asks, and hands what was chosen to the flight controller."""

    review_requested = Signal(object)  # A flight has ended and is to be reviewed: its folder.

    def __init__(
        self,
        window: QWidget,
        controller: FlightController,
        style: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        page: WebPageController,
    ) -> None:
        super().__init__(window)
        self._window = window
        self._controller = controller
        self._style = style
        self._store = store
        self._banners = banners
        self._found: tuple[RunningRecorder, ...] = ()
        self._offer: Banner | None = None
        self._of_flight: list[Banner] = []
        self._landed: Banner | None = None
        self._problem: Banner | None = None
        self._review_when_ended = False
        self._unproven: ConnectRequest | None = None  # over its link nothing has come yet
        self.sharing = SharingMenu(window, controller, style, store, banners, page)
        self.jobs = JobBannerController(banners, self)  # Shows background jobs.
        controller.job_started.connect(self.jobs.show_job)
        controller.message_posted.connect(banners.show_banner)
        controller.flight_message_posted.connect(
            lambda *said: self.remove_with_flight(banners.show_banner(*said))
        )
        controller.problem_changed.connect(self._show_problem)
        controller.changed.connect(self._forget_former)
        controller.channel_map_requested.connect(self.offer_channel_map)
        controller.landed.connect(self.offer_end)
        controller.recording_ended.connect(self.offer_replay)
        controller.refreshed.connect(self._remember_link)
        self._chosen: Path | None = None  # flight in a folder chosen for this and those to come
        controller.flight_opener.flight_opened.connect(self._recording_began)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "connect": self.connect_aircraft,
            "open_file": self.open_file,
            "open_folder": self.open_folder,
            "virtual": self.fly_virtual,
            "attach": self.attach,
            "recorders": self.select_recorder,
            "end_flight": self.end_flight,
            "export": self.export,
            "certificates": self.reload_with_certificates,
            "stop_recording": self.stop_recording,
            "close_flight": self._controller.close_flight,
        }

    @property
    def _flights(self) -> Path:
        return recording_folder(self._store.current)

    def _show_problem(self, problem: str) -> None:
        """Say why the flight cannot be followed, for as long as that is so."""
        if self._problem is not None:
            self._banners.remove(self._problem)
            self._problem = None
        if problem:
            self._problem = self._banners.show_banner("caution", problem)
            self.remove_with_flight(self._problem)

    def remove_with_flight(self, banner: Banner) -> None:
        """Take a banner away when another flight opens, of which it says nothing."""
        self._of_flight.append(banner)

    def _forget_former(self) -> None:
        self._review_when_ended = False
        if self._controller.is_open:
            for banner in self._of_flight:
                self._banners.remove(banner)
            self._of_flight.clear()

    # A flight to come

    def connect_link(self, link: str) -> None:
        """Record a link used before; where that fails, say why in the dialog that asks for it."""
        self._controller.flight_opener.connect_link(
            link,
            refused=lambda error: QTimer.singleShot(
                0, self, lambda: self.connect_aircraft((link, error))
            ),
        )

    def connect_aircraft(self, failed: tuple[str, Exception] | None = None) -> None:
        """Ask for link and files, and record.

        `failed`: a link that was tried, and why it failed: what the dialog begins with.
        """
        dialog = ConnectDialog(
            self._store.current, self._style, connection_options(), self._flights,
            self._window, own_folder=self._store.path.parent,
        )  # fmt: skip
        if failed is not None:
            dialog.link.text.setEditText(failed[0])
            dialog.show_error(failed[1])
        dialog.submitted.connect(lambda: self._connect(dialog))
        if not self._ask(dialog):
            return
        request = dialog.request
        self._store.change(
            aircraft=request.aircraft,
            channel_map=request.channel_map,
            calibration=request.calibration,
            listen_only=request.listen_only,
            signing_key=request.signing_key,
        )

    def _ask(self, dialog: RecordingDialog) -> bool:
        """Show a dialog until its recording has begun; return whether it has."""

        def accept() -> None:
            if dialog.is_connecting:
                dialog.accept()

        opener = self._controller.flight_opener
        opener.flight_opened.connect(accept)
        done = dialog.exec()
        opener.flight_opened.disconnect(accept)
        if not done and dialog.is_connecting:
            opener.cancel()
        return bool(done)

    def _connect(self, dialog: ConnectDialog) -> None:
        """Record what the dialog asks for; the dialog stays where that is refused."""
        if (place := self._choose_recording_folder(dialog)) is not None:
            self._unproven = dialog.request.with_changes(folder=place[0], append=place[1])
            self._controller.flight_opener.connect_aircraft(
                self._unproven, refused=dialog.show_error
            )

    def _remember_link(self) -> None:
        """Keep a link among the recent ones once something came over it."""
        request, session = self._unproven, self._controller.session
        if request is None or session is None or session.equipment is None:
            return
        if session.path == request.folder.absolute() and session.equipment.link.age is not None:
            self._unproven = None
            self._store.replace(self._store.current.with_link(request.link))

    def _choose_recording_folder(self, dialog: RecordingDialog) -> tuple[Path, bool] | None:
        """Return the folder, and whether to append to its flight; None if neither is wanted."""
        folder, append = dialog.folder_field.folder, False
        if record_state(folder) == "finished":
            new = next_free_folder(folder)
            answer = ask_append(dialog, folder.name, new.name)
            if answer is None:
                dialog.cancel_submission()
                return None
            folder, append = (folder if answer else new), answer
        self._remember_folder(folder, dialog.folder_field)
        return folder, append

    def fly_virtual(self) -> None:
        """Ask how, and let the virtual aircraft fly."""
        dialog = VirtualFlightDialog(
            self._style, virtual_flight_options(), self._flights, self._window
        )
        dialog.submitted.connect(lambda: self._fly(dialog))
        self._ask(dialog)

    def _fly(self, dialog: VirtualFlightDialog) -> None:
        """Fly what the dialog asks for; the dialog stays where that is refused."""
        if (place := self._choose_recording_folder(dialog)) is not None:
            request = dialog.request.with_changes(folder=place[0], append=place[1])
            self._controller.flight_opener.fly_virtual(request, refused=dialog.show_error)

    def _remember_folder(self, flight: Path, place: FlightFolderField) -> None:
        """Record into the folder that was chosen from now on, once a recording began there."""
        self._chosen = flight if flight.parent != place.proposed_parent else None

    def _recording_began(self, begun: PendingFlight, _back_to: float | None) -> None:
        chosen, self._chosen = self._chosen, None
        if chosen is not None and begun.session is not None and begun.session.path == chosen:
            self._store.change(flights=str(chosen.parent))

    def offer_recorders(self) -> None:
        """Offer to attach to recorders that are running, one of them with one key."""
        self._found = tuple(self._controller.recorders.poll())
        if not self._found:
            return
        newest = self._found[0]
        others = (
            tr(" ({count} more)").format(count=len(self._found) - 1) if len(self._found) > 1 else ""
        )
        self._offer = self._banners.show_banner(
            "note",
            tr("{name} is being recorded from {link}{others}. {keys} attaches.").format(
                name=newest.name, link=newest.link, others=others, keys=shortcut_text("Ctrl+R")
            ),
            (tr("Attach"), self.attach),
        )

    def attach(self) -> None:
        """Attach to the newest recorder that is running."""
        self._found = tuple(self._controller.recorders.poll())
        if self._offer is not None:
            self._banners.remove(self._offer)
            self._offer = None
        if not self._found:
            self._banners.show_banner(
                "note",
                tr("No recorder is running. {keys} connects an aircraft.").format(
                    keys=shortcut_text("Ctrl+L")
                ),
            )
            return
        self._controller.flight_opener.attach(self._found[0])

    def select_recorder(self) -> None:
        """Attach to the only recorder at once; list several, or those beside an open flight.

        Whom a flight is shared with is chosen here, too.
        """
        others = self._controller.recorders.others
        if len(others) == 1 and not self._controller.is_open:
            self._controller.flight_opener.attach(others[0])
            return
        menu = QMenu(self._window)
        menu.setObjectName("recorders")
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for found in others:
            menu.addAction(
                tr("Attach to {name} ({link})").format(name=found.name, link=found.link),
                partial(self._controller.flight_opener.attach, found),
            )
        if not others:
            menu.addAction(tr("No other recorder is running")).setEnabled(False)
        if self._controller.is_open or self.sharing.page.link:
            self.sharing.add_actions(menu)
        menu.popup(QCursor.pos())

    def offer_end(self, landed_at: float | None) -> None:
        """Say that the flight has landed, and offer to end it; take that back at a take-off."""
        if self._landed is not None:
            self._banners.remove(self._landed)
            self._landed = None
        if landed_at is not None:
            at = clock_text(landed_at, decimals=1)
            self._landed = self._banners.show_banner(
                "note",
                tr("{name} landed at {at}. Still recording.").format(
                    name=self._controller.name, at=at
                ),
                (tr("End flight and review"), self.end_flight),
            )
            self.remove_with_flight(self._landed)

    def end_flight(self) -> None:
        """End the recording, and review the flight once it is complete; ask before a landing."""
        if self._landed is None and not self._may_stop():
            return
        if self._landed is not None and (caution := self._controller.stop_caution):
            self._banners.show_banner("note", caution)
        self._review_when_ended = True
        self._controller.recorders.stop_recording()

    def stop_recording(self) -> None:
        """Ask, and end the recording."""
        if self._may_stop():
            self._controller.recorders.stop_recording()

    def _may_stop(self) -> bool:
        """Ask whether to stop the recording, and say what the end of its heartbeats may do."""
        name = self._controller.name or tr("this flight")
        return ask_stop(self._window, name, self._controller.stop_caution)

    # A flight that was

    def open_file(self) -> None:
        if path := ask_open_file(self._window, self._store.current):
            self.open_path(path)

    def open_folder(self) -> None:
        if path := ask_flight_folder(self._window, tr("Open a flight folder"), self._store.current):
            self.open_path(path)

    def open_path(self, path: Path) -> None:
        self._store.change(folder=str(path.parent))
        self._controller.flight_opener.open_flight(path)

    def open_dropped(self, paths: Sequence[Path]) -> None:
        """Open a flight that was dropped on the window, which has room for one."""
        if len(paths) == 1:
            self.open_path(paths[0])
        else:
            self._banners.show_banner(
                "note",
                tr(
                    "One flight opens at a time, and {count} were dropped; use Review "
                    "({keys}) for several."
                ).format(count=len(paths), keys=shortcut_text("F4")),
            )

    def offer_channel_map(self, path: Path, why: str) -> None:
        """Say that a file needs a channel map, and offer to choose one."""
        self.remove_with_flight(
            self._banners.show_banner(
                "caution", why, (tr("Choose a channel map…"), lambda: self._ask_map(path))
            )
        )

    def _ask_map(self, path: Path) -> None:
        maps, current = shipped_channel_maps(), self._store.current.channel_map
        dialog = ChannelMapDialog(self._style, path, maps, current, self._window)
        if dialog.exec():
            self._controller.flight_opener.open_flight(path, channel_map=dialog.channel_map.value)

    def reload_with_certificates(self) -> None:
        """Ask for other certificates, and read the replay that is open anew with them."""
        calibration = self._controller.calibration
        if calibration is None:
            return
        dialog = CertificatesDialog(
            self._style, calibration, shipped_certificate_sets(), self._window
        )
        if dialog.exec():
            self._controller.reload_with_certificates(dialog.certificates.value or None)

    def offer_replay(self, folder: Path) -> None:
        """Say that a recording ended, and offer to replay it.

        It is read once now, so that it opens in a moment when the crew reviews it. What may be
        wrong with it is said then.
        """
        BackgroundJob(
            tr("Reading {name}").format(name=folder.name),
            lambda _progress: load_flight(folder),
            self,
        ).start()
        self.offer_end(None)
        if self._review_when_ended:
            self._review_when_ended = False
            self.review_requested.emit(folder)
            return
        self.remove_with_flight(
            self._banners.show_banner(
                "note",
                tr("The recording of {name} has ended.").format(name=folder.name),
                (tr("Review it"), lambda: self.review_requested.emit(folder)),
                (tr("Replay it"), lambda: self._controller.flight_opener.open_flight(folder)),
            )
        )

    def export(self) -> None:
        """Ask for format and file, and write in the background."""
        day = datetime.now().astimezone().date().isoformat()
        folder = initial_dialog_folder(self._store.current)
        dialog = ExportDialog(
            self._style, folder / f"{self._controller.name or day}.csv", self._window
        )
        if dialog.exec():
            kind, path = dialog.request
            work = BackgroundJob(
                tr("Exporting to {name}").format(name=path.name),
                lambda progress: self._controller.export(kind, path, progress),
                self,
            )
            work.failed.connect(self._controller.error_reporter.report)
            self.jobs.show_job(work, tr("Exported to {path}.").format(path=path))
            work.start()
