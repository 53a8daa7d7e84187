"""One flight being watched, live or in a replay: everything a window or a command needs of it.

`Session.update` is called by a timer, does what fits into a few milliseconds, and goes on in the
next call. No Qt: what the session holds changes in `update` and in the user's own actions only. Its
files may be read and written in a thread (`gsapp.session.file_worker`).
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Unpack

from calibration.validity import CalibrationInForce
from gsapp.aircraft import Aircraft
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.health import LinkReport
from gsapp.decoding.pipeline import ChannelSource
from gsapp.excitation.cues import CueSnapshot
from gsapp.flight.certificates import (
    AppliedCertificates,
)
from gsapp.flight.events import Event, EventLog, events_path
from gsapp.flight.flight import Flight
from gsapp.flight.folder import FlightFolder
from gsapp.session.alarm_log import AlarmLog
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.channel_states import ChannelState, ChannelStates
from gsapp.session.cue_monitor import CrewCues
from gsapp.session.equipment_monitor import (
    STUCK_DISK_TEXT,
    DiskSummary,
    EquipmentMonitor,
    RecorderProbe,
    RecorderSummary,
    build_link_summary,
)
from gsapp.session.failure_guard import RetriedSteps
from gsapp.session.feeds import LiveFeed, ReplayFeed
from gsapp.session.file_worker import BackgroundEventLog
from gsapp.session.flight_metadata import FlightMetadata
from gsapp.session.limits import LimitBands, LimitSet
from gsapp.session.marks import FlightMark, MarkKind, MarkStore, SystemSelection
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.sample_history import SampleHistory
from gsapp.session.session_flight import (
    SessionFlight,
    SessionOptions,
    open_live_flight,
    open_recorded_flight,
)
from gsapp.session.session_monitors import SessionMonitors
from gsapp.session.snapshot import SessionMode, SessionSnapshot
from gsapp.telemetry.recorder_control import RecorderHandle

log = logging.getLogger(__name__)


class Session:
    """A flight being watched. Made by `Session.follow` or `Session.replay`.

    Attributes
    ----------
    history : SampleHistory
        All samples so far; in a replay up to the playhead.
    cue_monitor : CueMonitor or None
        Judges trim, inputs and dangers; None where the options switch it off.
    estimates : EstimateMonitor or None
        Live derivatives; None without workers or an aircraft.
    landing : LandingMonitor
        Tells when a live flight has landed.
    metadata : FlightMetadata
        Sources, certificates and losses of the record.
    failed_checks : mapping of str to datetime
        Channels whose last check failed, with the stamp of their certificate; set by the owner of
        the certificates of the aircraft.
    alarm_log : AlarmLog
        All alarms of the flight; in a replay of the whole flight.
    feed : LiveFeed or ReplayFeed
        What drives it. A window plays, pauses and jumps through `replay_feed`.
    """

    def __init__(
        self,
        opened: SessionFlight,
        options: SessionOptions,
        *,
        mode: SessionMode,
        speed: float = 1.0,
        playing: bool = True,
    ) -> None:
        path, setting = opened.path, opened.setting
        clock = options.get("clock", time.monotonic)
        wall_us = options.get("wall_us", _wall_us)
        self.path = path
        self.name = FlightFolder(path=path).name if path.is_dir() else path.stem
        self.mode: SessionMode = mode
        self.failed_checks: Mapping[str, datetime] = {}
        self.aircraft: Aircraft | None = setting.aircraft
        self.limits = LimitSet(setting.aircraft, setting.limits)
        self.alarm_registry = AlarmRegistry()
        self.history = SampleHistory((), opened.rate)
        self._worker = worker = opened.worker
        self.system_selection = SystemSelection(
            setting.system, setting.address, lambda: self.decoder
        )
        events = events_path(path)
        self.mark_store = MarkStore(
            EventLog(events) if worker is None else BackgroundEventLog(events, worker),
            wall_us,
            self.system_selection.time_of,
        )
        self.metadata = FlightMetadata(opened, self.name, self.history, self.mark_store)
        info = self.metadata.info() if mode == "replay" else None
        self._date = None if info is None else info.date
        self._has_grown = opened.has_grown
        self._clock = clock
        self._next_events = self._next_relax = -math.inf
        ahead = AlarmRegistry() if mode == "replay" else None
        self.alarm_log = AlarmLog(
            self.alarm_registry, self.mark_store, wall_us, self._apply_event, ahead
        )
        self._channel_states = ChannelStates(
            self.metadata, self.history, self.limits, self.alarm_registry
        )
        self._monitors = monitors = SessionMonitors(
            self.name,
            setting,
            options,
            self._channel_states,
            self.mark_store,
            live=mode == "live",
            alarms_ahead=ahead,
            now=lambda: self.now,
            info=self.metadata.info,
            read_events=lambda: self.alarm_log.read(refreshed=True),
            on_ground=self._reported_on_ground,
        )
        self.cue_monitor = monitors.cues
        folder = FlightFolder(path=path) if mode == "live" else None
        self.crew_cues = CrewCues(monitors.cues, self.metadata, folder, worker)
        self.estimates = monitors.estimates
        self.landing = monitors.landing
        self._steps = RetriedSteps()
        self.equipment: EquipmentMonitor | None = None
        self.feed: LiveFeed | ReplayFeed
        if mode == "live":
            facts = opened.poll(RecorderProbe(path).read, MONITORS.recorder_interval)
            self.equipment = EquipmentMonitor(path, self.alarm_registry, clock, wall_us, facts)
            self.feed = LiveFeed(opened.reader, self.history, monitors.consumers, clock)
        else:
            self.feed = ReplayFeed(
                opened.reader, self.history, monitors.consumers, clock, speed=speed,
                playing=playing,
                ahead=() if monitors.alarms_ahead is None else (monitors.alarms_ahead,),
            )  # fmt: skip

        # What the crew chose in an earlier window counts from when it was chosen.
        self.alarm_log.read()
        if worker is not None:
            worker.start()

    # Making one

    @classmethod
    def follow(cls, folder: Path | str, **options: Unpack[SessionOptions]) -> Session:
        """Watch a flight that is being recorded, from its beginning.

        The options are those of `gsapp.session.session_flight.SessionOptions`.
        """
        return cls(open_live_flight(folder, options), options, mode="live")

    @classmethod
    def replay(
        cls,
        flight: Path | str,
        *,
        speed: float = 1.0,
        playing: bool = True,
        **options: Unpack[SessionOptions],
    ) -> Session:
        """Play a flight that was recorded: a folder, or any file that `load_flight` opens.

        Raw records go the road of a live flight, through the decoder; other files are read
        whole and then released by the playhead.

        `speed` is 0.1 to 50 times real time, or `gsapp.session.feeds.UNLIMITED_SPEED`. The other
        options are those of `gsapp.session.session_flight.SessionOptions`.
        """
        opened = open_recorded_flight(Path(flight), options)
        return cls(opened, options, mode="replay", speed=speed, playing=playing)

    # The timer

    def update(self, budget: float = 0.008) -> None:
        """Take in what came, as far as it fits into `budget` seconds; the rest comes next time.

        A live flight goes on whatever fails: what is wrong with its record stands in `problem` of
        the snapshot, and link, recorder and disk are looked after all the same.
        """
        now = self._clock()
        is_outdated = self._worker is not None and self._worker.check_update_gap()
        if self.equipment is None:
            self.feed.advance(now + budget)
            self._run_periodic_tasks(now)
            return
        self._steps.attempt("record", lambda: self.feed.advance(now + budget), now)
        self._steps.attempt("beside", lambda: self._run_periodic_tasks(now), now)
        if not is_outdated:
            self._check_equipment(self.equipment)

    def _run_periodic_tasks(self, now: float) -> None:
        """See what there is beside the samples: estimates, and what all windows wrote."""
        if self.estimates is not None:
            self.estimates.update(self.now)
        if now >= self._next_relax:
            self._next_relax = now + MONITORS.memory_interval
            self.history.release_memory()
        if now >= self._next_events:
            self._next_events = now + MONITORS.events_interval
            self.alarm_log.read()

    def _check_equipment(self, equipment: EquipmentMonitor) -> None:
        decoder = self.decoder
        health = None if decoder is None else decoder.health
        unread = "record" in self._steps.failures
        stuck = self.disk_stuck
        equipment.landed = self.landing.landed_at is not None
        if equipment.update(
            health, self.now, caught_up=self.feed.is_up_to_date, unread=unread, stuck=stuck
        ):
            self.alarm_log.write_equipment(self.now)
            if self.cue_monitor is not None:
                self.cue_monitor.check_equipment()
            if equipment.ended and self.feed.caught_up:
                self.alarm_registry.end_all(self.now)

    @property
    def disk_stuck(self) -> bool:
        """Return whether the disk of the flight has not responded for a while."""
        return self._worker is not None and self._worker.seconds_waiting > MONITORS.disk_timeout

    @property
    def has_new_data(self) -> bool:
        """Return whether `update` would find anything to take in.

        Live this looks at the sizes of the files alone, and may be asked every few milliseconds.
        A replay goes on by itself: always.
        """
        return self.mode == "replay" or not self.feed.caught_up or self._has_grown()

    def finish(self, *, wait: bool = True) -> None:
        """Take in the very last rows of a flight that is over, and judge them.

        Without `wait`, `update` takes in the last fits as they come.
        """
        if isinstance(self.feed, LiveFeed):
            self.feed.finish()
        self._monitors.finish(wait=wait)

    def close(self) -> None:
        """Give back what the session holds. Recorder and record go on."""
        if self.estimates is not None:
            self.estimates.close()
        self.history.close()
        if self._worker is not None:
            self._worker.close()

    # What it shows

    @property
    def now(self) -> float | None:
        """Return the flight time: of the newest sample, or of the playhead; s."""
        return self.feed.now

    @property
    def replay_feed(self) -> ReplayFeed | None:
        return self.feed if isinstance(self.feed, ReplayFeed) else None

    @property
    def recorder(self) -> RecorderHandle | None:
        return None if self.equipment is None else self.equipment.handle

    @property
    def decoder(self) -> Decoder | None:
        return self.metadata.decoder

    @property
    def sources(self) -> Mapping[str, ChannelSource]:
        return self.metadata.sources

    @property
    def calibration(self) -> AppliedCertificates:
        return self.metadata.calibration

    @property
    def calibration_in_force(self) -> CalibrationInForce:
        """Return the certificates with what decides whether they count for this flight."""
        return CalibrationInForce(
            certificates=self.metadata.certificates,
            flight_date=self._date if self.mode == "replay" else datetime.now().astimezone(),
            missing=self.metadata.uncalibrated,
            failed_checks=self.failed_checks,
        )

    @property
    def cues(self) -> CueSnapshot | None:
        return self.crew_cues.snapshot()

    @property
    def monitored_fraction(self) -> float:
        """Return how much of the flight so far was looked through for alarms and cues, 0 to 1.

        It is below 1 after a jump in a replay, and in a window that was opened late.
        """
        return min(self.feed.monitored_fraction(one) for one in self._monitors.urgent)

    @property
    def marks(self) -> tuple[FlightMark, ...]:
        return self.mark_store.marks

    @property
    def remarks(self) -> tuple[str, ...]:
        return self.metadata.remarks()

    def messages(self) -> tuple[Event, ...]:
        """Return what the vehicle said, and what was noticed about it, up to now, by time."""
        return self.metadata.messages(self._replay_time)

    def snapshot(self) -> SessionSnapshot:
        """Return what the bar shows."""
        decoder = self.decoder
        equipment = self.equipment
        standing = self.alarm_registry.current_alarms
        return SessionSnapshot(
            name=self.name,
            path=self.path,
            mode=self.mode,
            now=self.now,
            is_up_to_date=self.feed.is_up_to_date,
            monitored_fraction=self.monitored_fraction,
            progress=self.feed.progress,
            link=build_link_summary(self.link_report(), words="replay")
            if equipment is None
            else equipment.link,
            recorder=RecorderSummary(state="none") if equipment is None else equipment.recorder,
            disk=DiskSummary() if equipment is None else equipment.disk,
            aircraft="" if self.aircraft is None else self.aircraft.name,
            channel_map="" if decoder is None else decoder.channel_map.name,
            calibration=tuple(sorted(self.metadata.certificates)),
            uncalibrated=self.metadata.uncalibrated,
            calibration_status=self.calibration_in_force.evaluate(),
            alarms=standing,
            unacknowledged_count=sum(not alarm.acknowledged for alarm in standing),
            playhead=None if self.replay_feed is None else self.replay_feed.playhead,
            problem=self._problem(),
        )

    def _problem(self) -> str:
        if self.disk_stuck:
            return f"{self.name}: {STUCK_DISK_TEXT}"
        return next(iter(self._steps.failures.values()), self.metadata.problem)

    def states(self, channel_ids: Sequence[str] | None = None) -> dict[str, ChannelState]:
        """Return what can be said of each channel now; by default of all that there can be."""
        return self._channel_states.states(channel_ids, self._present())

    def stale_timeouts(self, channel_ids: Sequence[str]) -> dict[str, float]:
        """Return after how many seconds without a sample each channel is stale."""
        return self._channel_states.stale_timeouts(channel_ids)

    def flight(self) -> Flight:
        """Return everything up to now as one flight, as `load_flight` would."""
        return self.metadata.flight(self._replay_time)

    # What the user does

    def select_system(self, system: int, address: str = "") -> None:
        """Make a system the flown one, of the whole flight, for all windows and replays.

        With a network address, HOST or HOST:PORT, only what comes from there is that system's.

        Raises
        ------
        FlightError
            If it cannot be written.
        """
        self.system_selection.select(system, address, self.mark_store)
        self.alarm_log.read()

    def mark(
        self,
        text: str = "",
        *,
        at: float | None = None,
        end: float | None = None,
        kind: MarkKind = "mark",
    ) -> FlightMark:
        """Make a mark or note, by default at the present flight time.

        Raises
        ------
        FlightError
            If it cannot be written.
        """
        return self.mark_store.add(self.now if at is None else at, text, end=end, kind=kind)

    def set_user_limits(self, channel_id: str, bands: LimitBands | None) -> None:
        """Let other limits count for a channel from now on; None for those of the flight."""
        self.limits.set_user_limits(channel_id, bands)
        self._monitors.reload_limits(channel_id)
        if self.replay_feed is not None:
            self.replay_feed.restart_read_ahead()

    def acknowledge(self, key: str | None = None, by: str = "crew") -> bool:
        """Take note of an alarm, by default of the newest that waits; return whether there was one.

        It is written to the flight's events, so that other windows know, with who has seen it.
        """
        return self.alarm_log.acknowledge_next(key, self.now, by)

    def acknowledge_all(self, by: str = "crew") -> int:
        """Take note of all alarms that wait; return how many there were."""
        return sum(self.acknowledge(alarm.key, by) for alarm in self.alarm_registry.unacknowledged)

    # Inside

    def _apply_event(self, event: Event) -> None:
        self.system_selection.apply_event(event)
        if self.cue_monitor is not None:
            self.cue_monitor.apply_event(event)

    @property
    def _replay_time(self) -> float | None:
        return self.now if self.replay_feed is not None else None

    def _reported_on_ground(self, time: float) -> bool | None:
        return None if self.decoder is None else self.decoder.landed_state.on_ground(time)

    def _present(self) -> float | None:
        """Return the flight time at this moment, from which ages count."""
        now = self.now
        decoder = self.decoder
        if now is None or self.equipment is None or decoder is None:
            return now
        heard = decoder.data_stamp
        silent = 0.0 if heard is None else max(self.equipment.host_us() - heard, 0) / 1e6
        return now + silent

    def link_report(self) -> LinkReport | None:
        """Return what came over the link, by sender and by message; None where it was no link.

        Ages count from now in a flight that goes on, else from the end of the record.
        """
        if self.decoder is None:
            return None
        now = None if self.equipment is None else self.equipment.host_us()
        return self.decoder.health.report(now)


def _wall_us() -> int:
    return time.time_ns() // 1000
