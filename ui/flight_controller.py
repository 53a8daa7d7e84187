"""The open flight: opened, driven by a precise timer, and asked for what the window shows."""

from __future__ import annotations

import time
from pathlib import Path
from threading import Thread

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from gsapp.flight.certificates import AppliedCertificates
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError
from gsapp.session import UNLIMITED_SPEED, Alarm, SampleHistory, Session, SessionSnapshot
from gsapp.telemetry.recorder_control import RecorderHandle
from gsapp.virtual.downlink.aircraft_process import AircraftProcess
from ui.background_job import BackgroundJob, JobProgress
from ui.commands import CommandRequirement, shortcut_text
from ui.error_reporter import ErrorReporter
from ui.flight_opener import FlightOpener
from ui.frame_rate import (
    MIN_LIVE_FRAME_SECONDS,
    MIN_REPLAY_FRAME_SECONDS,
    POLL_INTERVAL_MS,
    FrameRateLimiter,
)
from ui.module_preloader import preload_maneuver_modules
from ui.number_format import join_sentences
from ui.recording_setup import PendingFlight, RecorderMonitor, RunningRecorder
from ui.settings import SettingsStore

_UPDATE_SECONDS = 0.006
_BACKGROUND_UPDATE_SECONDS = 0.02
_CATCH_UP_UPDATE_SECONDS = 0.04
"""Seconds of a tick for new samples; more while alarms and cues are behind the charts, and most
while what was recorded before is read, or while nothing moves."""
_REFRESH_SECONDS = 0.1
_IDLE_PAINT_SECONDS = 0.25
_DATA_TIMEOUT = 1.0
"""Seconds without a sample after which the charts move on without one."""
_RETRY_MS = 1000
"""After a fault until the flight is gone on with: two milliseconds later it would be the same."""
_RECORDER_STOP_SECONDS = 11.0
"""For a recorder to end as the window closes; it is given 10 s to write what came."""
_SETTLING_MS = 500
"""From the opening of a flight until its charts stand."""


class FlightController(QObject):
    """Holds at most one session.

    Parameters
    ----------
    error_reporter : ErrorReporter
        Where errors of works go.
    store : SettingsStore
        Maps and folders used last.

    Attributes
    ----------
    flight_opener : FlightOpener
        Opens flights.
    changed : Signal
        Another flight is open, or none.
    about_to_close : Signal
        The open flight is closed next: the last moment to write something into it.
    frame_requested : Signal(object)
        Samples came: paint a frame; carries the flight time to paint up to, s or None.
    refreshed : Signal
        Time to show again what stands beside the samples.
    job_started : Signal(object, str)
        A `BackgroundJob` begins; what to say when it is done, empty for nothing.
    message_posted : Signal(str, str)
        Level and sentence of a banner.
    flight_message_posted : Signal(str, str)
        The same of the open flight alone, void once another is open.
    problem_changed : Signal(str)
        Why the open flight cannot be followed; empty once it can again.
    channel_map_requested : Signal(object, str)
        A file needs a channel map: path, and why.
    landed : Signal(object)
        The open flight has landed, at a flight time (s); None: it took off again.
    recording_ended : Signal(object)
        The recording of the open flight ended; its folder.
    """

    changed = Signal()
    about_to_close = Signal()
    frame_requested = Signal(object)
    refreshed = Signal()
    job_started = Signal(object, str)
    message_posted = Signal(str, str)
    flight_message_posted = Signal(str, str)
    problem_changed = Signal(str)
    channel_map_requested = Signal(object, str)
    landed = Signal(object)
    recording_ended = Signal(object)

    def __init__(
        self, faults: ErrorReporter, store: SettingsStore, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self.error_reporter = faults
        self._store = store
        self.session: Session | None = None
        self._snapshot: SessionSnapshot | None = None
        self._aircraft: AircraftProcess | None = None
        self._left: list[RecorderHandle] = []
        self._told_at = 0.0
        self._painted_at = 0.0
        self._moved_to: Path | None = None
        self._landed_at: float | None = None
        self._seen: tuple[float | None, int] | None = None
        self._system: int | None = None  # for which the flight is being read again
        self._moved_at = 0.0
        self._finished = False
        self._problem = self._fault = ""
        self._remarked = False
        self._back_to: float | None = None
        self._pace = FrameRateLimiter(MIN_LIVE_FRAME_SECONDS)
        self._recorders = RecorderMonitor(self)
        self._recorders.changed.connect(self.refreshed)
        self.flight_opener = FlightOpener(store, faults, self._open_here, self)
        self.flight_opener.flight_opened.connect(self._show)
        self.flight_opener.job_started.connect(self.job_started)
        self.flight_opener.message_posted.connect(self.message_posted)
        self.flight_opener.channel_map_requested.connect(self.channel_map_requested)
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(POLL_INTERVAL_MS)
        self._timer.timeout.connect(self.tick)

    # What is open

    @property
    def is_open(self) -> bool:
        """Return whether a flight is open."""
        return self.session is not None

    @property
    def is_replay(self) -> bool:
        """Return whether it is a replay."""
        return self.session is not None and self.session.replay_feed is not None

    @property
    def is_loaded(self) -> bool:
        """Return whether the whole record was read."""
        feed = self.session.replay_feed if self.session is not None else None
        return feed is not None and feed.complete

    @property
    def is_up_to_date(self) -> bool:
        """Return whether everything up to the playhead, or to now, was taken in."""
        return self.session is not None and self.session.feed.caught_up

    @property
    def is_catching_up(self) -> bool:
        """Return whether alarms and cues are still those of an earlier time."""
        return self._snapshot is not None and self._snapshot.monitored_fraction < 1.0

    @property
    def is_recording(self) -> bool:
        """Return whether the open flight is being recorded."""
        return self.session is not None and self.session.recorder is not None

    @property
    def other_recordings(self) -> tuple[RecorderHandle, ...]:
        """Return the recorders of flights that were open here, are not now, and still record."""
        running = [found.handle for found in self.running_recorders()]
        return tuple(left for left in self._left if left in running)

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        """Return what commands may act on."""
        found: list[CommandRequirement] = []
        if self.is_open:
            found.append("flight")
        if self.is_replay:
            found.append("replay")
        if self.is_recording:
            found.append("recorder")
        if self.mark_times():
            found.append("marks")
        if self.unacknowledged_alarms():
            found.append("alarms")
        return tuple(found)

    @property
    def name(self) -> str:
        """Return the name of the flight; empty without one."""
        return self.session.name if self.session is not None else ""

    @property
    def history(self) -> SampleHistory | None:
        """Return the samples."""
        return self.session.history if self.session is not None else None

    @property
    def calibration(self) -> AppliedCertificates | None:
        """Return which certificates the flight is read with; None without a flight."""
        return self.session.calibration if self.session is not None else None

    @property
    def time(self) -> float | None:
        """Return the flight time, s."""
        return self.session.now if self.session is not None else None

    # Opening and closing

    def _open_here(self) -> Path | None:
        return None if self.session is None else self.session.path

    def reload_with_certificates(self, calibration: str | None) -> None:
        """Open the replay anew where it stands, with other certificates.

        Parameters
        ----------
        calibration : str or None
            A folder, or a shipped set; None for the flight's own.
        """
        if self.session is not None and self.session.replay_feed is not None:
            self.flight_opener.reload(self.session, calibration)

    def select_system(self, system: int) -> None:
        """Make a system of the link the flown one, of the whole flight and for all windows."""
        if self.session is not None:
            self.session.select_system(system)
            self._tell(self.session)

    def _follow_choice(self, session: Session) -> None:
        """Read the flight again where the crew chose another system, here or in another window."""
        chosen = session.system_selection.pending
        if chosen is not None and chosen != self._system:
            self._system = chosen
            self.message_posted.emit(
                "note", f"System {chosen} is now the flown system of {session.name}."
            )
            self.flight_opener.reload(session, session.calibration.override_source or None)

    def _show(self, begun: PendingFlight, back_to: float | None) -> None:
        session = begun.session
        if session is None:
            return
        former = self.session.recorder if self.session is not None else None
        same_flight = session.path in (self._moved_to, self._open_here())
        aircraft = begun.aircraft or (self._aircraft if same_flight else None)
        self.close()
        self._back_to = back_to
        self.session = session
        self._aircraft = aircraft
        self._finished = self._remarked = False
        self._problem = self._fault = ""
        self._moved_to = self._seen = self._landed_at = self._system = None
        self._pace = FrameRateLimiter(
            MIN_LIVE_FRAME_SECONDS if session.replay_feed is None else MIN_REPLAY_FRAME_SECONDS
        )
        self._moved_at = time.monotonic()
        session.update(_UPDATE_SECONDS)
        self._snapshot = session.snapshot()
        self.changed.emit()
        self._timer.start()
        QTimer.singleShot(_SETTLING_MS, self, preload_maneuver_modules)
        self._tell_of(former)

    def close_flight(self) -> None:
        """Close the flight; what is recorded goes on being recorded."""
        former = self.session.recorder if self.session is not None else None
        self.close()
        self.changed.emit()
        self._tell_of(former)

    def _tell_of(self, former: RecorderHandle | None) -> None:
        """Say that the flight which was open goes on being recorded, if it does."""
        if former is not None and former in self.other_recordings:
            keys = shortcut_text("Ctrl+R")
            words = f"{former.folder.name} goes on being recorded. {keys} attaches again."
            self.message_posted.emit("note", words)

    def release_recorder(self, recorder: RecorderHandle) -> None:
        """Say and ask nothing of a recorder any more: somebody else ends it."""
        self._left = [left for left in self._left if left != recorder]

    def close(self) -> None:
        """Give the session back. Recorder and virtual aircraft go on."""
        if self.session is not None:
            self.about_to_close.emit()
        self._timer.stop()
        self.flight_opener.cancel()
        session, self.session = self.session, None
        self._snapshot = self._aircraft = None
        if session is not None:
            if session.recorder is not None and session.recorder not in self._left:
                self._left.append(session.recorder)
            session.close()

    def stop_recording(self) -> None:
        """End the recording in the background; everything that arrived is written first."""
        recorder = self.session.recorder if self.session is not None else None
        if recorder is None:
            return
        aircraft = self._aircraft

        def end(_progress: JobProgress) -> bool:
            if aircraft is not None:
                aircraft.stop()
            return recorder.stop()

        def tell(ended: bool) -> None:
            if not ended:
                self.message_posted.emit(
                    "warning",
                    f"The recorder (process {recorder.pid}) does not end: it still writes what "
                    "came. Try again in a moment.",
                )

        work = BackgroundJob("Stopping the recording", end, self)
        work.done.connect(tell)
        work.failed.connect(self.error_reporter.report)
        self.job_started.emit(work, "")
        work.start()

    def stop_recording_and_wait(self) -> None:
        """End the recording and wait for it, as the window closes."""
        if self._aircraft is not None:
            self._aircraft.stop()
        if self.session is not None and self.session.recorder is not None:
            self.stop_recorders(self.session.recorder)

    @staticmethod
    def stop_recorders(*recorders: RecorderHandle) -> None:
        """End recorders and wait for them, though not for a disk that hangs."""
        threads = [Thread(target=one.stop, name="stopping", daemon=True) for one in recorders]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(_RECORDER_STOP_SECONDS)

    def running_recorders(self) -> tuple[RunningRecorder, ...]:
        """Return recorders that run, the newest first; not that of the open flight."""
        here = self.session.path.absolute() if self.session is not None else None
        return tuple(found for found in self._recorders.poll() if found.handle.folder != here)

    @property
    def other_recorders(self) -> tuple[RunningRecorder, ...]:
        """Return the recorders that were seen running a moment ago, but that of the open flight."""
        here = self.session.path.absolute() if self.session is not None else None
        return tuple(found for found in self._recorders.running if found.handle.folder != here)

    def export(self, kind: str, path: Path, progress: JobProgress) -> Path:
        """Write the open flight for other programs; called in the thread of a work."""
        session = self.session
        if session is None:
            raise FlightError("no flight is open, so that there is nothing to export")
        decoder = session.decoder
        progress(None, "reading the record")
        flight = load_flight(
            session.path,
            channel_map=None if decoder is None else decoder.channel_map,
            certificates=session.calibration.override_source or None,
        )
        if not len(flight.block):
            raise FlightError(f"{session.name} holds no samples yet; nothing to export")
        words = f"writing {len(flight.block):,} rows"
        progress(0.0, words)
        return write_block(
            path, flight.block, kind, self._store.current.units.lower(),
            lambda share: progress(share, words),
        )  # fmt: skip

    # The timer

    def tick(self) -> None:
        """Take in what came, paint if there is something new, tell the rest ten times a second.

        What fails is said once, and tried again after a while.
        """
        if self.session is None:
            return
        try:
            self._go_on(self.session)
        except Exception as error:
            self._timer.setInterval(_RETRY_MS)
            if repr(error) != self._fault:
                self._fault = repr(error)
                self.error_reporter.report(error)

    def _go_on(self, session: Session) -> None:
        now = time.monotonic()
        tells = now - self._told_at >= _REFRESH_SECONDS
        if self._timer.interval() != POLL_INTERVAL_MS:
            self._timer.setInterval(POLL_INTERVAL_MS)
        paints = self._pace.may_begin_frame(now)
        hurries = self._hurries(session)
        if not (
            tells or hurries or (paints and (session.has_new_data or self._is_behind(session)))
        ):
            return
        session.update(_update_seconds(session))
        if paints and self._is_behind(session):
            self._seen = (session.now, session.history.revision)
            self._moved_at = self._painted_at = now
            self.frame_requested.emit(session.now)
        elif now - self._painted_at >= _IDLE_PAINT_SECONDS:
            self._painted_at = now
            self.frame_requested.emit(self._idle_time(now))
        if paints and (self._painted_at == now or session.replay_feed is not None):
            # A replay always has news; they come with the frames, not with the looks.
            end = time.monotonic()
            self._pace.record_frame(now, end)
            if not hurries:
                # No look can lead to a frame before.
                self._timer.setInterval(
                    max(int(1000 * self._pace.seconds_to_next(end)), POLL_INTERVAL_MS)
                )
        if tells:
            self._told_at = now
            self._tell(session)
        self._fault = ""

    @staticmethod
    def _hurries(session: Session) -> bool:
        """Return whether the flight is taken in as fast as it goes, whatever is painted."""
        replay = session.replay_feed
        if replay is None:
            return not session.feed.caught_up
        if replay.playing:
            return not replay.complete or replay.speed == UNLIMITED_SPEED
        # Nothing moves: all who watch are waited for after a jump.
        return not (replay.complete and replay.caught_up)

    def _is_behind(self, session: Session) -> bool:
        """Return whether the charts do not show yet what the session has taken in."""
        return (session.now, session.history.revision) != self._seen

    def _idle_time(self, now: float) -> float | None:
        """Return the flight time to paint up to while nothing comes.

        It goes on, so that values grow stale and the gap is seen.
        """
        session = self.session
        if session is None or session.now is None:
            return None
        silent = now - self._moved_at
        # While what was recorded is still being read nothing is missing yet.
        live = (
            session.replay_feed is None
            and session.recorder is not None
            and session.feed.is_up_to_date
        )
        return session.now + silent if live and silent > _DATA_TIMEOUT else session.now

    def _tell(self, session: Session) -> None:
        self._snapshot = snapshot = session.snapshot()
        self._follow_choice(session)
        equipment = session.equipment
        if equipment is not None and equipment.moved_to not in (None, self._moved_to):
            self._moved_to = equipment.moved_to
            self.flight_opener.open_flight(self._moved_to)
        if session.recorder is not None and session.landing.landed_at != self._landed_at:
            self._landed_at = session.landing.landed_at
            self.landed.emit(self._landed_at)
        over = equipment is not None and equipment.ended and session.feed.caught_up
        if over and not self._finished:
            self._finished = True
            session.finish(wait=False)  # the event loop waits for nothing
            self.recording_ended.emit(session.path)
        if snapshot.problem != self._problem:
            self._problem = snapshot.problem
            self.problem_changed.emit(snapshot.problem)
        if not self._remarked and self.is_loaded:
            self._remarked = True
            if self._back_to is not None:
                self.seek(self._back_to)
            if session.remarks:
                self.flight_message_posted.emit("note", join_sentences(session.remarks))
        if self._aircraft is not None and (complaint := self._aircraft.take_error()):
            self.flight_message_posted.emit("warning", complaint)
        self.refreshed.emit()

    # What is shown

    @property
    def snapshot(self) -> SessionSnapshot | None:
        """Return the state of the session at the last tick; None without a flight."""
        return self._snapshot

    @property
    def other_recorder_names(self) -> tuple[str, ...]:
        """Return the names of the flights that other recorders write."""
        return tuple(found.name for found in self.other_recorders)

    def unacknowledged_alarms(self) -> tuple[Alarm, ...]:
        """Return the alarms that nobody has acknowledged."""
        return self.session.alarm_registry.unacknowledged if self.session is not None else ()

    # What the crew does

    def mark(self, at: float | None, text: str = "", *, kind: str = "mark") -> str:
        """Mark a flight time (s) and return the key of the mark; empty without a flight."""
        if self.session is None:
            return ""
        made = self.session.mark(text, at=at, kind="note" if kind == "note" else "mark")
        self._tell(self.session)
        return made.id

    def edit_mark(self, key: str, text: str) -> None:
        """Give a mark another text."""
        if self.session is not None:
            self.session.mark_store.edit(key, text=text)
            self._tell(self.session)

    def delete_mark(self, key: str) -> None:
        """Take a mark away."""
        if self.session is not None:
            self.session.mark_store.delete(key)
            self._tell(self.session)

    def undo_mark(self) -> None:
        """Take back the last change of a mark made here."""
        if self.session is not None:
            self.session.mark_store.undo()
            self._tell(self.session)

    def mark_time(self, key: str) -> float | None:
        """Return the flight time of a mark, s."""
        marks = self.session.marks if self.session is not None else ()
        return next((mark.time for mark in marks if mark.id == key), None)

    def mark_times(self) -> tuple[float, ...]:
        """Return the flight times of all marks, s."""
        marks = self.session.marks if self.session is not None else ()
        return tuple(mark.time for mark in marks if mark.time is not None)

    def acknowledge(self, by: str = "crew") -> None:
        """Say that the alarms were seen, and by whom."""
        if self.session is not None:
            self.session.acknowledge_all(by)
            self._tell(self.session)

    # Replay

    @property
    def speed(self) -> float:
        """Return how fast the replay runs, times real time."""
        feed = self.session.replay_feed if self.session is not None else None
        return feed.speed if feed is not None else 1.0

    def set_speed(self, speed: float) -> None:
        """Run the replay faster or slower; infinite is as fast as it can."""
        feed = self.session.replay_feed if self.session is not None else None
        if feed is not None:
            feed.speed = speed

    def toggle_play(self) -> None:
        """Hold the replay, or let it go on."""
        feed = self.session.replay_feed if self.session is not None else None
        if feed is not None:
            if feed.playing:
                feed.pause()
            else:
                feed.play()

    def seek(self, at: float) -> None:
        """Go to a flight time, s."""
        feed = self.session.replay_feed if self.session is not None else None
        if feed is not None:
            feed.seek(at)

    def step(self, samples: int) -> None:
        """Go on by samples of the grid, or back if negative."""
        feed = self.session.replay_feed if self.session is not None else None
        if feed is not None:
            feed.step(samples)

    @property
    def replay_span(self) -> tuple[float, float] | None:
        """Return first and last flight time of the replay, s."""
        feed = self.session.replay_feed if self.session is not None else None
        if feed is None or feed.start is None or feed.end is None:
            return None
        return feed.start, feed.end


def _update_seconds(session: Session) -> float:
    """Return the seconds of a tick for taking in what came."""
    feed, replay = session.feed, session.replay_feed
    if feed.caught_up:
        return _UPDATE_SECONDS
    if replay is None:
        return _BACKGROUND_UPDATE_SECONDS if feed.is_up_to_date else _CATCH_UP_UPDATE_SECONDS
    # A replay that jumped hears all before the playhead again; one that plays goes on.
    return _BACKGROUND_UPDATE_SECONDS if replay.playing else _CATCH_UP_UPDATE_SECONDS
