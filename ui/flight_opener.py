"""How a flight is opened: from a record, from a recorder that runs, or by beginning to record."""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from threading import Lock, Thread

from PySide6.QtCore import QObject, Signal

from calibration.certificate_store import CertificateStore
from gsapp.decoding.channel_map import ChannelMap
from gsapp.flight.events import EventLog, events_path, vehicle_event
from gsapp.flight.folder_setup import apply_draft, reset_draft
from gsapp.foundation import GroundStationError, UnmappedError
from gsapp.session import Session
from gsapp.session.live_estimation.fit_workers import ProcessFitWorker
from gsapp.session.session_flight import SessionOptions
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.recorder_control import find_recorder, start_recorder
from gsapp.telemetry.recorder_folder import check_not_finished, record_state
from gsapp.virtual.downlink.aircraft_process import find_free_udp_port
from ui.background_job import BackgroundJob, JobCanceledError, JobProgress
from ui.dialogs.flight_requests import ConnectRequest, VirtualFlightRequest, next_flight_name
from ui.disk_checks import path_kind
from ui.error_reporter import ErrorReporter
from ui.recorder_controller import (
    PendingFlight,
    RunningRecorder,
    launch_virtual_aircraft,
)
from ui.settings import (
    SettingsStore,
    calibrations_path,
    next_flight_path,
    recording_folder,
    writable_folder,
)
from ui.translation import tr

log = logging.getLogger(__name__)


class FlightOpener(QObject):
    """Sets flights going in threads of their own, one at a time; the window goes on meanwhile."""

    # A flight is there: `PendingFlight`, and the flight time (s) to go back to, or None.
    flight_opened = Signal(object, object)
    # A `BackgroundJob` begins; what to say when it is done, empty for nothing.
    job_started = Signal(object, str)
    message_posted = Signal(str, str)  # Level and sentence of a banner.
    channel_map_requested = Signal(object, str)  # A file needs a channel map: path, and why.

    def __init__(
        self,
        store: SettingsStore,
        error_reporter: ErrorReporter,
        open_here: Callable[[], Path | None],
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._store = store
        self._error_reporter = error_reporter
        self._open_here = open_here
        self._job: BackgroundJob | None = None
        self._records: Path | None = None  # where that begins to record
        self._recording = Lock()

    def open_flight(
        self,
        path: Path,
        *,
        channel_map: str | None = None,
        calibration: str | None = None,
        speed: float = 1.0,
        playing: bool = True,
    ) -> None:
        """Open a flight: live if it is being recorded, as a replay otherwise.

        `calibration`: certificates that a replay is read with in place of its own: a folder, or a
        shipped set.
        """
        place = Path(path).expanduser()

        def make() -> Session:
            if place.is_dir() and find_recorder(place) is not None:
                return self._followed(place, channel_map)
            return self._replayed(place, channel_map, calibration, speed, playing)

        self._open_session(make, place.name, None if channel_map or calibration else place)

    def reload(self, session: Session, calibration: str | None, raw: str = "") -> None:
        """Open a flight again, as it is read now: a replay where it stands.

        `calibration`: of a replay: a folder, or a shipped set; None for the flight's own. `raw`:
        fields of messages that are kept as channels too, ``ATTITUDE.*``.
        """
        path, feed, decoder = session.path, session.replay_feed, session.decoder
        channel_map = None if decoder is None else decoder.channel_map
        if channel_map is not None and raw and raw not in channel_map.raw:
            channel_map = replace(channel_map, raw=(*channel_map.raw, raw))
        if feed is None:
            self._open_session(lambda: self._followed(path, channel_map), path.name)
            return
        speed, playing = feed.speed, feed.playing
        self._open_session(
            lambda: self._replayed(path, channel_map, calibration, speed, playing),
            path.name,
            back_to=feed.now,
        )

    def attach(self, found: RunningRecorder) -> None:
        folder = found.handle.folder
        self._open_session(lambda: self._followed(folder), folder.name)

    def connect_aircraft(
        self,
        request: ConnectRequest,
        *,
        trial: bool = False,
        refused: Callable[[Exception], None] | None = None,
    ) -> None:
        """Record a link in a process of its own, and follow it.

        A flight for trial gets a copy of what waits for the next one. Errors go to `refused`, or
        else to a banner.
        """

        def begin(begun: PendingFlight, progress: JobProgress) -> None:
            # A second connection to the same flight joins what is recorded already.
            if not request.folder.is_dir() or find_recorder(request.folder) is None:
                self._record(request, begun, progress, trial=trial)
            begun.session = self._followed(request.folder)

        self._open(begin, request.folder.name, records=request.folder, refused=refused)

    def _followed(self, folder: Path, channel_map: ChannelMap | str | None = None) -> Session:
        return Session.follow(folder, **self._options(channel_map))

    def _replayed(
        self,
        path: Path,
        channel_map: ChannelMap | str | None,
        calibration: str | None,
        speed: float,
        playing: bool,
    ) -> Session:
        options: SessionOptions = {**self._options(channel_map), "certificates": calibration}
        return Session.replay(path, speed=speed, playing=playing, **options)

    def _options(self, channel_map: ChannelMap | str | None) -> SessionOptions:
        """Return how every flight is watched in a window."""
        from gsapp.session.live_estimation.live_search import run_search_request

        return {
            "channel_map": channel_map,
            "cues": True,
            "system": self._store.current.units,
            "workers": ProcessFitWorker(),
            "search_worker": ProcessFitWorker(run_search_request),
            "in_background": True,
        }

    def _record(
        self,
        request: ConnectRequest,
        begun: PendingFlight,
        progress: JobProgress,
        *,
        trial: bool = False,
    ) -> None:
        """Make the flight folder, with what waits for the next flight in it, and record into it.

        It waits on until that is not cancelled any more; where a flight is for trial, even then.
        A card that cannot be read holds up no recording.
        """
        if not request.append:
            check_not_finished(request.folder, tr("choose a new name"))
        if record_state(request.folder) == "interrupted":
            text = tr("The recorder of {name} ended unexpectedly; continuing it.").format(
                name=request.folder.name
            )
            self.message_posted.emit("note", text)
        if not request.folder.exists():
            begun.folder = request.folder
        folder = request.prepare_folder(
            request.folder, request.link, name=request.title, prefers_shared=True
        )
        try:
            handed_over = apply_draft(
                next_flight_path(self._store.path), folder, keep=True, named=not trial
            )
            begun.has_next_flight_data = handed_over and not trial
        except GroundStationError as error:
            self._error_reporter.report(error)
        if request.system is not None:
            chosen = vehicle_event(request.system, request.address)
            EventLog(events_path(folder.path)).append(chosen)
        progress(None, tr("starting the recorder"))
        begun.recorder = start_recorder(
            request.link, request.folder, heartbeat=request.heartbeat,
            listen_only=request.listen_only, signing_key=request.signing_key,
        )  # fmt: skip

    def connect_link(
        self,
        link: str,
        *,
        channel_map: str | None = None,
        aircraft: str | None = None,
        refused: Callable[[Exception], None] | None = None,
    ) -> None:
        """Record a LINK with the files used last, into the next flight of the day.

        Errors go to `refused`, or else to a banner.
        """
        address = parse_link(link)
        if address.kind == "flight":
            self.open_flight(Path(address.path), channel_map=channel_map)
            return
        settings = self._store.current
        self.connect_aircraft(
            ConnectRequest(
                link=link,
                folder=self.next_flight_folder(),
                channel_map=channel_map or kind_of(address).channel_map or settings.channel_map,
                aircraft=aircraft or settings.aircraft,
                calibration=settings.calibration,
                listen_only=settings.listen_only,
                signing_key=settings.signing_key,
            ),
            refused=refused,
        )

    def next_flight_folder(self, kind: str = "") -> Path:
        """Return the folder of the next flight of the day.

        It lies in the usual folder, and that is said, where the one of the settings is not
        writable.
        """
        parent, why_other = writable_folder(recording_folder(self._store.current))
        if why_other:
            self.message_posted.emit("caution", why_other)
        return parent / next_flight_name(parent, datetime.now().astimezone().date(), kind)

    def fly_virtual(
        self, request: VirtualFlightRequest, *, refused: Callable[[Exception], None] | None = None
    ) -> None:
        """Let the virtual aircraft fly over a link of this machine, record and follow it.

        Errors go to `refused`, or else to a banner.
        """
        port = find_free_udp_port()
        connect = ConnectRequest(
            link=f"udpin:127.0.0.1:{port}",
            folder=request.folder,
            channel_map="b777-thin" if request.thin else "b777",
            aircraft="b777",
            calibration="b777",
            append=request.append,
        )

        def begin(begun: PendingFlight, progress: JobProgress) -> None:
            self._record(connect, begun, progress, trial=True)
            begun.session = self._followed(connect.folder)
            begun.aircraft = launch_virtual_aircraft(request, port)

        self._open(begin, request.folder.name, records=request.folder, refused=refused)

    def _open_session(
        self,
        make: Callable[[], Session],
        name: str,
        wants_map: Path | None = None,
        back_to: float | None = None,
    ) -> None:
        def begin(begun: PendingFlight, _progress: JobProgress) -> None:
            begun.session = make()

        self._open(begin, name, wants_map, back_to)

    def _open(
        self,
        begin: Callable[[PendingFlight, JobProgress], None],
        name: str,
        wants_map: Path | None = None,
        back_to: float | None = None,
        records: Path | None = None,
        refused: Callable[[Exception], None] | None = None,
    ) -> None:
        """Set a flight going in a thread; the window goes on meanwhile.

        What a work that is cancelled or fails has set going is undone. One that begins to record
        waits for that, lest it meet the recorder of the one before.
        """

        def run(progress: JobProgress) -> PendingFlight:
            begun = PendingFlight()
            with self._recording if records is not None else nullcontext():
                try:
                    if not progress.is_canceled:
                        begin(begun, progress)
                        self._read_failed_checks(begun.session)
                    if progress.is_canceled:
                        raise JobCanceledError
                except BaseException:
                    # What failed is undone, too: no window shows the recorder it has started, and
                    # that would hold the link against the next attempt.
                    self._undo(begun, tr("cancelled") if progress.is_canceled else tr("given up"))
                    if not progress.is_canceled and begun.has_flight_folder:
                        self._start_next(begun)
                    raise
            return begun

        self.cancel()
        work = BackgroundJob(tr("Opening {name}").format(name=name), run, self, may_hang=True)
        self._job, self._records = work, records
        work.done.connect(lambda begun: self._finish_opening(begun, back_to))
        work.discarded.connect(self._drop)
        work.failed.connect(refused or (lambda error: self._failed(error, wants_map)))
        self.job_started.emit(work, "")
        work.start()

    def _read_failed_checks(self, session: Session | None) -> None:
        """Let a flight know which of its certificates failed their last check."""
        if session is None or session.aircraft is None:
            return
        folder = calibrations_path(self._store.path)
        try:
            session.failed_checks = CertificateStore(folder, session.aircraft.name).failed_checks()
        except (GroundStationError, OSError) as error:
            log.warning("checks not read: %s", error)

    def _drop(self, begun: PendingFlight) -> None:
        """Undo what was set going in the very moment in which it was cancelled."""
        here = self._open_here()
        wanted = [] if here is None else [here]
        if self._records is not None and self._job is not None and self._job.is_running:
            wanted.append(self._records)
        if begun.recorder is not None and begun.recorder.folder in map(Path.absolute, wanted):
            begun.recorder = begun.folder = None  # another connection has joined it
        Thread(target=self._undo, args=(begun, tr("cancelled")), name="undoing").start()

    def _undo(self, begun: PendingFlight, why: str) -> None:
        if begun.undo() and begun.folder is not None:
            text = tr("Data received before the flight was {why} is in {folder}.").format(
                why=why, folder=begun.folder
            )
            self.message_posted.emit("note", text)

    def _finish_opening(self, begun: PendingFlight, back_to: float | None) -> None:
        self._start_next(begun)
        self.flight_opened.emit(begun, back_to)

    def cancel(self) -> None:
        if self._job is not None and self._job.is_running:
            self._job.cancel()

    def _start_next(self, begun: PendingFlight) -> None:
        """Let nothing wait any more of what this flight was given."""
        if begun.has_next_flight_data:
            try:
                reset_draft(next_flight_path(self._store.path))
            except GroundStationError as error:
                self._error_reporter.report(error)

    def _failed(self, error: Exception, wants_map: Path | None) -> None:
        is_unmapped = isinstance(error, UnmappedError)
        if wants_map is not None and is_unmapped and path_kind(wants_map) == "file":
            self.channel_map_requested.emit(wants_map, str(error))
        else:
            self._error_reporter.report(error, opening=True)
