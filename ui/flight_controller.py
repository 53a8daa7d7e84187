"""The open flight: opened and closed, marked, acknowledged and replayed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from gsapp.flight.certificates import AppliedCertificates
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError
from gsapp.session import Alarm, SampleHistory, Session, SessionSnapshot
from gsapp.session.equipment_monitor import LinkSummary
from gsapp.session.feeds import ReplayFeed
from gsapp.telemetry.recorder_status import HEARTBEAT_END
from ui.background_job import JobProgress
from ui.commands import CommandRequirement
from ui.error_reporter import ErrorReporter
from ui.flight_opener import FlightOpener
from ui.module_preloader import preload_maneuver_modules
from ui.number_format import join_sentences
from ui.recorder_controller import PendingFlight, RecorderController, RunningRecorder
from ui.session_poller import SessionPoller
from ui.settings import SettingsStore
from ui.translation import tr
from ui.window_frame.status_bar_model import describe_assumed_address

_SETTLING_MS = 500  # From the opening of a flight until its charts stand.


class FlightController(QObject):
    """Holds at most one session."""

    changed = Signal()  # Another flight is open, or none.
    # The open flight is closed next: the last moment to write something into it.
    about_to_close = Signal()
    # Samples came: paint a frame; carries the flight time to paint up to, s or None.
    frame_requested = Signal(object)
    refreshed = Signal()  # Time to show again what stands beside the samples.
    # A `BackgroundJob` begins; what to say when it is done, empty for nothing.
    job_started = Signal(object, str)
    message_posted = Signal(str, str)  # Level and sentence of a banner.
    # The same of the open flight alone, void once another is open.
    flight_message_posted = Signal(str, str)
    # Why the open flight cannot be followed; empty once it can again.
    problem_changed = Signal(str)
    channel_map_requested = Signal(object, str)  # A file needs a channel map: path, and why.
    # The open flight has landed, at a flight time (s); None: it took off again.
    landed = Signal(object)
    recording_ended = Signal(object)  # The recording of the open flight ended; its folder.

    def __init__(
        self, error_reporter: ErrorReporter, store: SettingsStore, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self.error_reporter = error_reporter
        self._store = store
        self.session: Session | None = None
        self._snapshot: SessionSnapshot | None = None
        self._moved_to: Path | None = None
        self._landed_at: float | None = None
        self._system: tuple[int, str] | None = None  # for which the flight is being read again
        self._finished = False
        self._problem = ""
        self._remarked = False
        self._are_notes_announced = False
        self._is_address_announced = False
        self._back_to: float | None = None
        self.recorders = RecorderController(lambda: self.session, error_reporter, self)
        self.recorders.changed.connect(self.refreshed)
        self.recorders.job_started.connect(self.job_started)
        self.recorders.message_posted.connect(self.message_posted)
        self.poller = SessionPoller(self._refresh, error_reporter, self)
        self.poller.frame_requested.connect(self.frame_requested)
        self.flight_opener = FlightOpener(store, error_reporter, self._open_here, self)
        self.flight_opener.flight_opened.connect(self._show)
        self.flight_opener.job_started.connect(self.job_started)
        self.flight_opener.message_posted.connect(self.message_posted)
        self.flight_opener.channel_map_requested.connect(self.channel_map_requested)

    # What is open

    @property
    def is_open(self) -> bool:
        return self.session is not None

    @property
    def is_replay(self) -> bool:
        return self._replay is not None

    @property
    def _replay(self) -> ReplayFeed | None:
        return self.session.replay_feed if self.session is not None else None

    @property
    def is_loaded(self) -> bool:
        return self._replay is not None and self._replay.complete

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
        return self.recorders.current is not None

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
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
        return self.session.name if self.session is not None else ""

    @property
    def history(self) -> SampleHistory | None:
        return self.session.history if self.session is not None else None

    @property
    def calibration(self) -> AppliedCertificates | None:
        """Return which certificates the flight is read with; None without a flight."""
        return self.session.calibration if self.session is not None else None

    @property
    def time(self) -> float | None:
        return self.session.now if self.session is not None else None

    @property
    def stop_caution(self) -> str:
        """Return what the end of the recording may do to an aircraft that flies; empty for nothing.

        It ends the heartbeats, where it sends any.
        """
        equipment = None if self.session is None else self.session.equipment
        return tr(HEARTBEAT_END) if equipment is not None and equipment.recorder.heartbeats else ""

    def closing_caution(self, others: Iterable[RunningRecorder]) -> str:
        """Return the same of the recording of the open flight and others together."""
        speaks = any(other.sends_heartbeats for other in others)
        return tr(HEARTBEAT_END) if speaks else self.stop_caution

    # Opening and closing

    def _open_here(self) -> Path | None:
        return None if self.session is None else self.session.path

    def reload_with_certificates(self, calibration: str | None) -> None:
        """Open the replay anew where it stands, with other certificates.

        `calibration`: a folder, or a shipped set; None for the flight's own.
        """
        if self.session is not None and self.session.replay_feed is not None:
            self.flight_opener.reload(self.session, calibration)

    def select_system(self, system: int, address: str = "") -> None:
        """Make a system of the link the flown one, of the whole flight and for all windows."""
        if self.session is not None:
            self.session.select_system(system, address)
            self._refresh(self.session)

    def keep_fields(self, message: str) -> None:
        """Read the flight again with the fields of a message as channels, until it is closed."""
        if self.session is not None:
            calibration = self.session.calibration.override_source or None
            self.flight_opener.reload(self.session, calibration, f"{message}.*")

    def _follow_choice(self, session: Session) -> None:
        """Read the flight again where the crew chose another system, here or in another window."""
        chosen = session.system_selection.pending
        if chosen is not None and chosen != self._system:
            self._system = chosen
            self.message_posted.emit(
                "note",
                tr("System {chosen} is now the flown system of {name}.").format(
                    chosen=" ".join(map(str, chosen)).strip(), name=session.name
                ),
            )
            self.flight_opener.reload(session, session.calibration.override_source or None)

    def _announce_address(self, link: LinkSummary) -> None:
        """Say once which address on a network is taken for the aircraft without a choice."""
        if self._is_address_announced or link.system is None or not link.assumed_address:
            return
        self._is_address_announced = True
        # On this computer it is the virtual aircraft or a program of the crew; the tile tells it.
        if not link.assumed_address.startswith("127."):
            self.flight_message_posted.emit("note", describe_assumed_address(link))

    def _show(self, begun: PendingFlight, back_to: float | None) -> None:
        session = begun.session
        if session is None:
            return
        former = self.recorders.current
        same_flight = session.path in (self._moved_to, self._open_here())
        aircraft = begun.aircraft or (self.recorders.aircraft if same_flight else None)
        self.close()
        self._back_to = back_to
        self.session = session
        self.recorders.aircraft = aircraft
        self.recorders.is_stop_requested = False
        self._finished = self._remarked = self._is_address_announced = False
        self._are_notes_announced = False
        self._problem = ""
        self._moved_to = self._landed_at = self._system = None
        self.poller.set_session(session)
        self._snapshot = session.snapshot()
        self.changed.emit()
        self.poller.start()
        QTimer.singleShot(_SETTLING_MS, self, preload_maneuver_modules)
        self.recorders.announce_left(former)

    def close_flight(self) -> None:
        """Close the flight; what is recorded goes on being recorded."""
        former = self.recorders.current
        self.close()
        self.changed.emit()
        self.recorders.announce_left(former)

    def close(self) -> None:
        """Give the session back. Recorder and virtual aircraft go on."""
        if self.session is not None:
            self.about_to_close.emit()
        self.poller.set_session(None)
        self.flight_opener.cancel()
        session, self.session = self.session, None
        self._snapshot = self.recorders.aircraft = None
        if session is not None:
            self.recorders.leave(session.recorder)
            session.close()

    def export(self, kind: str, path: Path, progress: JobProgress) -> Path:
        """Write the open flight for other programs; called in the thread of a work."""
        session = self.session
        if session is None:
            raise FlightError(tr("no flight is open; nothing to export"))
        decoder = session.decoder
        progress(None, tr("reading the record"))
        flight = load_flight(
            session.path,
            channel_map=None if decoder is None else decoder.channel_map,
            certificates=session.calibration.override_source or None,
        )
        if not len(flight.block):
            raise FlightError(
                tr("{name} holds no samples yet; nothing to export").format(name=session.name)
            )
        text = tr("writing {count:,} rows").format(count=len(flight.block))
        progress(0.0, text)
        return write_block(
            path, flight.block, kind, self._store.current.units.lower(),
            lambda share: progress(share, text),
        )  # fmt: skip

    def _refresh(self, session: Session) -> None:
        self._snapshot = snapshot = session.snapshot()
        self._follow_choice(session)
        equipment = session.equipment
        if equipment is not None:
            self._announce_address(equipment.link)
            if equipment.recorder.state == "failed":
                self.recorders.restart_failed(session)
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
        if self.recorders.aircraft is not None and (
            complaint := self.recorders.aircraft.take_error()
        ):
            self.flight_message_posted.emit("warning", complaint)
        self.refreshed.emit()

    # What is shown

    @property
    def snapshot(self) -> SessionSnapshot | None:
        """Return the state of the session at the last tick; None without a flight."""
        return self._snapshot

    def unacknowledged_alarms(self) -> tuple[Alarm, ...]:
        return self.session.alarm_registry.unacknowledged if self.session is not None else ()

    # What the crew does

    def mark(self, at: float | None, text: str = "", *, kind: str = "mark") -> str:
        """Mark a flight time (s) and return the key of the mark; empty without a flight."""
        if self.session is None:
            return ""
        made = self.session.mark(text, at=at, kind="note" if kind == "note" else "mark")
        self._refresh(self.session)
        self._announce_notes(self.session)
        return made.id

    def _announce_notes(self, session: Session) -> None:
        """Say once where marks and notes of a flight stay that another computer records."""
        equipment = session.equipment
        sends_notes = None if equipment is None else equipment.recorder.sends_notes
        if self._are_notes_announced or sends_notes is None or sends_notes:
            return
        self._are_notes_announced = True
        self.flight_message_posted.emit(
            "note",
            tr(
                "Marks and notes made here stay on this computer: the computer that records "
                "the flight does not take them."
            ),
        )

    def edit_mark(self, key: str, text: str) -> None:
        if self.session is not None:
            self.session.mark_store.edit(key, text=text)
            self._refresh(self.session)

    def delete_mark(self, key: str) -> None:
        if self.session is not None:
            self.session.mark_store.delete(key)
            self._refresh(self.session)

    def undo_mark(self) -> None:
        """Take back the last change of a mark made here."""
        if self.session is not None:
            self.session.mark_store.undo()
            self._refresh(self.session)

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
            self._refresh(self.session)

    # Replay

    @property
    def speed(self) -> float:
        """Return how fast the replay runs, times real time."""
        return self._replay.speed if self._replay is not None else 1.0

    def set_speed(self, speed: float) -> None:
        """Run the replay faster or slower; infinite is as fast as it can."""
        if self._replay is not None:
            self._replay.speed = speed

    def toggle_play(self) -> None:
        """Pause the replay, or let it go on."""
        if self._replay is not None:
            if self._replay.playing:
                self._replay.pause()
            else:
                self._replay.play()

    def seek(self, at: float) -> None:
        """Go to a flight time, s."""
        if self._replay is not None:
            self._replay.seek(at)

    def step(self, samples: int) -> None:
        """Go forward by samples of the grid, or back if negative."""
        if self._replay is not None:
            self._replay.step(samples)

    @property
    def replay_span(self) -> tuple[float, float] | None:
        """Return first and last flight time of the replay, s."""
        replay = self._replay
        if replay is None or replay.start is None or replay.end is None:
            return None
        return replay.start, replay.end
