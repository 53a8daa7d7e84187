"""One flight being watched, live or in a replay: everything a window or a command needs of it.

`Session.update` is called by a timer, does what fits into a few milliseconds, and goes on in the
next call. No Qt: what the session holds changes in `update` and in the user's own actions only. Its
files may be read and written in a thread (`gsapp.session.file_worker`).
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar, Unpack

from calibration import Certificate
from calibration.validity import CalibrationInForce
from gsapp.aircraft import Aircraft
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.health import LinkReport
from gsapp.decoding.pipeline import ChannelSource
from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueSnapshot
from gsapp.flight.cards import CardSet
from gsapp.flight.certificates import (
    AppliedCertificates,
    instruments_out_of_range,
    uncalibrated_channels,
)
from gsapp.flight.events import Event, EventLog, event_system, events_path, vehicle_event
from gsapp.flight.flight import Flight
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import FileProblemsError, GroundStationError
from gsapp.session.alarm_log import AlarmLog
from gsapp.session.alarm_monitor import AlarmMonitor
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.channel_states import (
    DEFAULT_STALE_SECONDS,
    ChannelState,
    build_channel_state,
    share_message,
    source_message,
    stale_timeout_by_message,
)
from gsapp.session.cue_monitor import CueMonitor
from gsapp.session.equipment_monitor import (
    STUCK_DISK_TEXT,
    DiskSummary,
    EquipmentMonitor,
    LinkSummary,
    RecorderProbe,
    RecorderSummary,
    build_link_summary,
)
from gsapp.session.failure_guard import FailureGuard, GuardedConsumer
from gsapp.session.feeds import LiveFeed, ReplayFeed
from gsapp.session.file_worker import BackgroundEventLog
from gsapp.session.flight_metadata import FlightMetadata
from gsapp.session.landing_monitor import LandingMonitor
from gsapp.session.limits import LimitBands, LimitSet, Severity
from gsapp.session.marks import FlightMark, MarkKind, MarkStore
from gsapp.session.readers import FlightReader
from gsapp.session.sample_history import SampleHistory
from gsapp.session.session_flight import SessionFlight, open_live_flight, open_recorded_flight
from gsapp.session.session_setting import SessionOptions
from gsapp.session.snapshot import Playhead, SessionMode, SessionSnapshot
from gsapp.telemetry.recorder_control import RecorderHandle

if TYPE_CHECKING:
    from gsapp.excitation.debrief import Debrief
    from gsapp.excitation.doublets.verdict import InputVerdict
    from gsapp.flight.info import FlightInfo
    from gsapp.session.consumer_scheduler import Consumer
    from gsapp.session.live_estimation.estimate_monitor import EstimateMonitor
    from gsapp.session.live_estimation.fit_workers import FitWorker

_EVENTS_EVERY = 0.25
_RELAX_EVERY = 10.0
_INFO_EVERY = 1.0
_RECORDER_EVERY = 0.25
_STUCK_SECONDS = 2.0
"""After which a disk that does not respond is told."""
_AGAIN = 1.0
"""Seconds after which what failed in a live flight is tried again."""
_LIMITS = "limits and missing messages are watched no more"
_ESTIMATES = "there are no estimates any more"
_LANDING = "the landing is not recognized"
_FURTHER = "not everything that watches the samples works"

T = TypeVar("T")

log = logging.getLogger(__name__)


class Session:
    """A flight being watched. Made by `Session.follow` or `Session.replay`.

    Attributes
    ----------
    name : str
        Of the flight.
    path : Path
        Its folder or file.
    mode : {"live", "replay"}
        Whether it is happening.
    history : SampleHistory
        All samples so far; in a replay up to the playhead.
    alarm_registry : AlarmRegistry
        The alarms.
    limits : LimitSet
        The limits in force.
    mark_store : MarkStore
        Marks and notes.
    aircraft : Aircraft or None
        From the flight folder, or as given.
    cue_monitor : CueMonitor or None
        Judges trim, inputs and dangers; None where the options switch it off.
    estimates : EstimateMonitor or None
        Derivatives as they form; None without workers or an aircraft.
    landing : LandingMonitor
        Tells when a live flight has landed.
    failed_checks : mapping of str to datetime
        Channels whose last check failed, with the stamp of their certificate: for whoever keeps the
        certificates of the aircraft to set.
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
        events = events_path(path)
        self.mark_store = MarkStore(
            EventLog(events) if worker is None else BackgroundEventLog(events, worker),
            wall_us,
            self._clock_at,
        )
        self._account = FlightMetadata(opened, self.name, self.history, self.mark_store)
        self._reader = opened.reader
        self._setting = setting
        self._system_chosen = setting.system
        self._flight = opened.loaded_flight
        self._read_info = self._watched_or_read(self._info_on_disk, _INFO_EVERY)
        info = self._info() if mode == "replay" else None
        self._date = None if info is None else info.date
        self._has_grown = opened.has_grown
        self._clock = clock
        self._messages: dict[str, str | None] = {}
        self._next_events = self._next_relax = -math.inf
        ahead = AlarmRegistry() if mode == "replay" else None
        self._alarm_log = AlarmLog(
            self.alarm_registry, self.mark_store, wall_us, self._take_in, ahead
        )
        self._watch = self._make_watch(self.alarm_registry)
        self._watch_ahead = None if ahead is None else self._make_watch(ahead)
        self.cue_monitor: CueMonitor | None = None
        if options.get("cues", True):
            self.cue_monitor = self._make_cues(options.get("system", "US"))
        self.estimates: EstimateMonitor | None = None
        workers = options.get("workers")
        if workers is not None and self.aircraft is not None:
            self.estimates = self._make_estimates(self.aircraft, workers)
        self.landing = LandingMonitor(self.aircraft, self.history.rate, self._reported_on_ground)
        everyone = self._everyone(options.get("consumers", ()))
        # Who looks for what the crew is told at once.
        self._urgent = everyone[: 1 if self.cue_monitor is None else 2]
        # What fails at present, in words, and when it is tried again.
        self._failures: dict[str, str] = {}
        self._again: dict[str, float] = {}
        self.equipment: EquipmentMonitor | None = None
        self.feed: LiveFeed | ReplayFeed
        if mode == "live":
            facts = self._watched_or_read(RecorderProbe(path).read, _RECORDER_EVERY)
            self.equipment = EquipmentMonitor(path, self.alarm_registry, clock, wall_us, facts)
            self.feed = LiveFeed(opened.reader, self.history, everyone, clock)
        else:
            self.feed = ReplayFeed(
                opened.reader, self.history, everyone, clock, speed=speed, playing=playing,
                ahead=() if self._watch_ahead is None else (self._watch_ahead,),
            )  # fmt: skip

        # What the crew chose in an earlier window counts from when it was chosen.
        self._alarm_log.read()
        if worker is not None:
            worker.start()

    # Making one

    @classmethod
    def follow(cls, folder: Path | str, **options: Unpack[SessionOptions]) -> Session:
        """Watch a flight that is being recorded, from its beginning.

        Parameters
        ----------
        folder : Path or str
            The flight folder, made by the recorder; it finds the recorder that runs there.
        **options
            See `gsapp.session.session_setting.SessionOptions`.

        Raises
        ------
        FlightError
            If it is no flight folder.
        FileProblemsError, UnknownNameError
            If a file holds mistakes or a name does not exist.
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

        Parameters
        ----------
        flight : Path or str
            The flight.
        speed : float
            0.1 to 50 times real time, or `gsapp.session.feeds.UNLIMITED_SPEED`.
        playing : bool
            Whether it plays at once.
        **options
            See `gsapp.session.session_setting.SessionOptions`.

        Raises
        ------
        FlightError
            If it cannot be read.
        FileProblemsError, UnknownNameError
            If a file holds mistakes or a name does not exist.
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
        if self.equipment is None:
            self.feed.advance(now + budget)
            self._look_around(now)
            return
        self._attempt("record", lambda: self.feed.advance(now + budget), now)
        self._attempt("beside", lambda: self._look_around(now), now)
        self._look_at_equipment(self.equipment)

    def _attempt(self, what: str, step: Callable[[], None], now: float) -> None:
        """Do a step of a live flight; keep in words why it fails, and try it again later."""
        if now < self._again.get(what, now):
            return
        try:
            step()
        except Exception as error:
            self._again[what] = now + _AGAIN
            words = str(error)
            if not isinstance(error, GroundStationError):
                words = f"a step of the program failed ({error!r}); the log has more"
            if words != self._failures.get(what):
                self._failures[what] = words
                log.error("a live flight cannot be followed", exc_info=error)
        else:
            self._failures.pop(what, None)

    def _look_around(self, now: float) -> None:
        """See what there is beside the samples: estimates, and what all windows wrote."""
        if self.estimates is not None:
            self.estimates.update(self.now)
        if now >= self._next_relax:
            self._next_relax = now + _RELAX_EVERY
            self.history.release_memory()
        if now >= self._next_events:
            self._next_events = now + _EVENTS_EVERY
            self._alarm_log.read()

    def _look_at_equipment(self, equipment: EquipmentMonitor) -> None:
        decoder = self.decoder
        health = None if decoder is None else decoder.health
        unread = "record" in self._failures
        stuck = self.disk_stuck
        equipment.landed = self.landing.landed_at is not None
        if equipment.update(
            health, self.now, caught_up=self.feed.is_up_to_date, unread=unread, stuck=stuck
        ):
            self._alarm_log.write_equipment(self.now)
            if self.cue_monitor is not None:
                self.cue_monitor.check_equipment()
            if equipment.ended and self.feed.caught_up:
                self.alarm_registry.end_all(self.now)

    @property
    def disk_stuck(self) -> bool:
        """Return whether the disk of the flight has not responded for a while."""
        return self._worker is not None and self._worker.seconds_waiting > _STUCK_SECONDS

    @property
    def has_new_data(self) -> bool:
        """Return whether `update` would find anything to take in.

        Live this looks at the sizes of the files alone, and may be asked every few milliseconds.
        A replay goes on by itself: always.
        """
        return self.mode == "replay" or not self.feed.caught_up or self._has_grown()

    def finish(self, *, wait: bool = True) -> None:
        """Take in the very last rows of a flight that is over, and judge them.

        Parameters
        ----------
        wait : bool
            Whether to wait for the last fits; without it, `update` takes them in as they come.
        """
        if isinstance(self.feed, LiveFeed):
            self.feed.finish()
        if self.cue_monitor is not None:
            self.cue_monitor.finish()
        if self.estimates is not None:
            self.estimates.finish(wait=wait)

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
        """Return the playhead's controls; None while live."""
        return self.feed if isinstance(self.feed, ReplayFeed) else None

    @property
    def recorder(self) -> RecorderHandle | None:
        """Return the recorder that runs for this flight, as of the last look."""
        return None if self.equipment is None else self.equipment.handle

    @property
    def decoder(self) -> Decoder | None:
        """Return the decoder; None before a map was found, and for flights read whole."""
        return self._account.decoder

    @property
    def sources(self) -> Mapping[str, ChannelSource]:
        """Return every channel that the flight can have, and from where."""
        return self._account.sources

    @property
    def certificates(self) -> Mapping[str, Certificate]:
        """Return the certificates in force, by channel."""
        return self._account.certificates

    @property
    def calibration(self) -> AppliedCertificates:
        """Return which certificates are in force, and whether in place of the flight's own."""
        return self._account.calibration

    @property
    def uncalibrated(self) -> tuple[str, ...]:
        """Return the channels whose instruments give volts only, for want of a certificate."""
        return uncalibrated_channels(self.sources)

    @property
    def calibration_in_force(self) -> CalibrationInForce:
        """Return the certificates with what decides whether they count for this flight."""
        return CalibrationInForce(
            certificates=self.certificates,
            flight_date=self._date if self.mode == "replay" else datetime.now().astimezone(),
            missing=self.uncalibrated,
            failed_checks=self.failed_checks,
        )

    @property
    def out_of_calibrated_range(self) -> tuple[str, ...]:
        """Return the instruments that now read beyond what they were calibrated for."""
        return instruments_out_of_range(self.calibration, self.sources, self._reads)

    def _reads(self, name: str) -> float:
        """Return the latest value of a channel, SI; NaN for none."""
        last = self.history.last(name) if name in self.history.channels else None
        return math.nan if last is None else last[1]

    @property
    def cues(self) -> CueSnapshot | None:
        """Return what the crew is to be told now; None where cues are switched off."""
        watch = self.cue_monitor
        return (
            None
            if watch is None
            else watch.snapshot(self.uncalibrated, self.out_of_calibrated_range)
        )

    @property
    def monitored_fraction(self) -> float:
        """Return how much of the flight so far was looked through for alarms and cues, 0 to 1.

        Below 1 the alarms and the cues are those of an earlier time: after a jump in a replay, and
        in a window that was opened late.
        """
        return min(self.feed.monitored_fraction(one) for one in self._urgent)

    @property
    def spoken_cues(self) -> Sequence[Announcement]:
        """Return all that is to be heard so far; it shrinks only when a replay goes back."""
        return () if self.cue_monitor is None else self.cue_monitor.spoken

    @property
    def cards(self) -> CardSet | None:
        """Return the test cards."""
        return None if self.cue_monitor is None else self.cue_monitor.cueing.cards

    def debrief(self) -> Debrief | None:
        """Return every input judged so far, and the score by card; None without cues."""
        watch = self.cue_monitor
        if watch is None:
            return None
        from gsapp.excitation.debrief import create_debrief

        return create_debrief(self.name, watch.cueing)

    @property
    def marks(self) -> tuple[FlightMark, ...]:
        """Return marks and notes, by flight time."""
        return self.mark_store.marks

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return what was lost or left out on reading, in words."""
        return self._account.remarks()

    @property
    def alarm_log(self) -> AlarmLog:
        """Return the log of all alarms of the flight; in a replay of the whole flight."""
        return self._alarm_log

    def messages(self) -> tuple[Event, ...]:
        """Return what the vehicle said, and what was noticed about it, up to now, by time."""
        return self._account.messages(self._heard_until)

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
            link=self._replayed_link() if equipment is None else equipment.link,
            recorder=RecorderSummary(state="none") if equipment is None else equipment.recorder,
            disk=DiskSummary() if equipment is None else equipment.disk,
            aircraft="" if self.aircraft is None else self.aircraft.name,
            channel_map="" if decoder is None else decoder.channel_map.name,
            calibration=tuple(sorted(self.certificates)),
            uncalibrated=self.uncalibrated,
            calibration_status=self.calibration_in_force.evaluate(),
            alarms=standing,
            unacknowledged_count=sum(not alarm.acknowledged for alarm in standing),
            playhead=self._playhead(),
            problem=self._problem(),
        )

    def _problem(self) -> str:
        if self.disk_stuck:
            return f"{self.name}: {STUCK_DISK_TEXT}"
        return next(iter(self._failures.values()), self._account.problem)

    def states(self, channel_ids: Sequence[str] | None = None) -> dict[str, ChannelState]:
        """Return what can be said of each channel now; by default of all that there can be."""
        names = channel_ids
        if names is None:
            names = list(dict.fromkeys((*self.sources, *self.history.channels)))
        now = self._present()
        patience = self.stale_timeouts(names)
        return {
            name: build_channel_state(
                name,
                history=self.history,
                sources=self.sources,
                limits=self.limits,
                board=self.alarm_registry,
                now=now,
                patience=patience[name],
            )
            for name in names
        }

    def stale_timeouts(self, channel_ids: Sequence[str]) -> dict[str, float]:
        """Return after how many seconds without a sample each channel is stale."""
        decoder = self.decoder
        late = stale_timeout_by_message(None if decoder is None else decoder.health.report())
        carriers = {name: self._carrier(name) or "" for name in channel_ids}
        return {
            name: late.get(message.partition("[")[0], DEFAULT_STALE_SECONDS)
            for name, message in carriers.items()
        }

    def flight(self) -> Flight:
        """Return everything up to now as one flight, as `load_flight` would.

        Returns
        -------
        Flight
            Its block holds the whole history in memory.
        """
        return self._account.flight(self._heard_until)

    @property
    def selected_system(self) -> int | None:
        """Return the flown system that the crew has chosen since this session began.

        None where it has not, or chose the one that is decoded: else the flight is to be opened
        again, since all of it is read for the system chosen.
        """
        decoder, chosen = self.decoder, self._system_chosen
        decoded = self._setting.system if decoder is None else decoder.system
        return None if chosen == decoded else chosen

    def _clock_at(self, choice: Event, stamp_us: int) -> float | None:
        """Return the time by the clock of the system chosen; see `MarkStore`."""
        decoder = self.decoder
        if decoder is None or (decoder.health.last_stamp or 0) < stamp_us:
            return None
        time = decoder.flight_time_at(stamp_us)
        return time if decoder.system == event_system(choice) and time is not None else math.nan

    # What the user does

    def select_system(self, system: int) -> None:
        """Make a system the flown one, of the whole flight, for all windows and replays.

        Raises
        ------
        FlightError
            If it cannot be written.
        """
        decoder, time, stamp = self.decoder, None, 0
        if decoder is not None and decoder.system not in (None, system):
            stamp = decoder.health.last_stamp or 0
            time = decoder.flight_time_at(stamp)
        self.mark_store.write(vehicle_event(system, time=time, stamp_us=stamp))
        self._alarm_log.read()

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
        self._watch.reload_limits(channel_id)
        if self._watch_ahead is not None and isinstance(self.feed, ReplayFeed):
            self._watch_ahead.reload_limits(channel_id)
            self.feed.restart_read_ahead()

    def select_card(self, card_id: str) -> None:
        """Let a test card be the next until it is flown; an empty id lets the program pick.

        A live flight keeps the choice among its events, so that a replay tells the same.

        Raises
        ------
        UnknownNameError
            If there is no such card.
        FlightError
            If it cannot be written.
        """
        if self.cue_monitor is not None:
            self.cue_monitor.select_card(card_id)

    def set_units(self, system: str) -> None:
        """Give cues in these units, ``US`` or ``SI``, from now on."""
        if self.cue_monitor is not None:
            self.cue_monitor.cueing.use_units(system)

    def set_cards(self, cards: CardSet) -> None:
        """Take other test cards; a live flight without any keeps them in its folder.

        Raises
        ------
        FlightError
            If they cannot be written; they count in this window.
        """
        if self.cue_monitor is None:
            return
        self.cue_monitor.cueing.use_cards(cards)
        folder = FlightFolder(path=self.path)

        def keep() -> None:
            if not folder.cards_file.exists():
                folder.store_cards(cards)

        if self.mode == "live" and self._worker is None:
            keep()
        elif self.mode == "live" and self._worker is not None:
            self._worker.run_job(keep)

    def acknowledge(self, key: str | None = None, by: str = "crew") -> bool:
        """Take note of an alarm, by default of the newest that waits; return whether there was one.

        It is written to the flight's events, so that other windows know.

        Parameters
        ----------
        key : str, optional
            Of the alarm.
        by : str
            Who has seen it, and how, for the log.
        """
        alarm = (
            self.alarm_registry.get(key)
            if key is not None
            else next(iter(self.alarm_registry.unacknowledged), None)
        )
        if alarm is None or alarm.acknowledged:
            return False
        self._alarm_log.acknowledge(alarm, self.now, by)
        return True

    def acknowledge_all(self, by: str = "crew") -> int:
        """Take note of all alarms that wait; return how many there were."""
        return sum(self.acknowledge(alarm.key, by) for alarm in self.alarm_registry.unacknowledged)

    # Inside

    def _make_watch(self, board: AlarmRegistry) -> AlarmMonitor:
        return AlarmMonitor(
            board, self.limits, self.history.rate, self._carrier, self._come_together
        )

    def _make_cues(self, system: str) -> CueMonitor:
        from gsapp.excitation.cueing import CueGenerator  # the window starts without it

        setting = self._setting
        cueing = CueGenerator(
            self.aircraft,
            setting.model,
            self.history.rate,
            cards=setting.cards,
            fence=setting.fence,
            system=system,
        )
        live = self.mode == "live"
        return CueMonitor(
            cueing,
            self.alarm_registry,
            self.mark_store,
            lambda: self._alarm_log.read(refreshed=True),
            live=live,
        )

    def _everyone(self, further: Sequence[Consumer]) -> Sequence[Consumer]:
        """Return who watches the samples; in a live flight none of them may hold up the others."""
        found = [self._on_guard(self._watch, _LIMITS, Severity.WARNING)]
        if self.cue_monitor is not None:
            found.append(self.cue_monitor)  # on its own guard, in a replay too
        if self.estimates is not None:
            found.append(self._on_guard(self.estimates, _ESTIMATES))
        if self.mode == "live":
            found.append(self._on_guard(self.landing, _LANDING))
        return [*found, *(self._on_guard(one, _FURTHER) for one in further)]

    def _on_guard(
        self, consumer: Consumer, what: str, severity: Severity = Severity.CAUTION
    ) -> Consumer:
        if self.mode != "live":
            return consumer
        key = f"failed:{type(consumer).__name__}"
        return GuardedConsumer(
            consumer, FailureGuard(key, what, severity, self.alarm_registry, lambda: self.now)
        )

    def _make_estimates(self, aircraft: Aircraft, workers: FitWorker) -> EstimateMonitor:
        from gsapp.session.live_estimation.estimate_monitor import (
            EstimateMonitor,
        )  # the window starts without it

        return EstimateMonitor(
            aircraft,
            self._setting.model,
            self.history,
            self._info,
            self.name,
            self._verdicts,
            workers,
        )

    def _info(self) -> FlightInfo | None:
        """Return the flight card as it is now; None without one, or if it holds mistakes."""
        return self._read_info() if self._flight is None else self._flight.info

    def _info_on_disk(self) -> FlightInfo | None:
        try:
            return FlightFolder(path=self.path).info() if self.path.is_dir() else None
        except FileProblemsError:
            return None

    def _watched_or_read(self, read: Callable[[], T], every: float) -> Callable[[], T]:
        """Return what gives the newest of something on the disk, without waiting for it."""
        return read if self._worker is None else self._worker.poll_periodically(read, every)

    def _verdicts(self) -> Sequence[InputVerdict]:
        return () if self.cue_monitor is None else self.cue_monitor.cueing.verdicts

    def _take_in(self, event: Event) -> None:
        """Take in an event of the flight that is no acknowledgment."""
        chosen = event_system(event)
        if chosen is not None:
            self._system_chosen = chosen
            if self.decoder is not None and self.decoder.system == chosen:
                self.decoder.health.chosen = True  # which of several was in question
        if self.cue_monitor is not None:
            self.cue_monitor.apply_event(event)

    @property
    def _heard_until(self) -> float | None:
        """Return up to which flight time the crew has heard the vehicle; None for all."""
        return self.now if self.replay_feed is not None else None

    def _reported_on_ground(self, time: float) -> bool | None:
        """Return whether the autopilot reports ground at a flight time; None if it does not say."""
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

    def _carrier(self, channel_id: str) -> str | None:
        """Return the message that carries a channel."""
        if channel_id not in self._messages:
            self._messages[channel_id] = source_message(self.sources.get(channel_id))
        return self._messages[channel_id]

    def _come_together(self, one: str, other: str) -> bool:
        """Return whether two channels come in the same blocks."""
        if isinstance(self._reader, FlightReader):
            return True
        return share_message(one, other, self.sources)

    def _playhead(self) -> Playhead | None:
        feed = self.replay_feed
        if feed is None or feed.now is None or feed.start is None or feed.end is None:
            return None
        return Playhead(
            time=feed.now,
            start=feed.start,
            end=feed.end,
            playing=feed.playing,
            speed=feed.speed,
            complete=feed.complete,
            at_end=feed.at_end,
        )

    def link_report(self) -> LinkReport | None:
        """Return what came over the link, by sender and by message; None where it was no link.

        Ages count from now in a flight that goes on, else from the end of the record.
        """
        if self.decoder is None:
            return None
        now = None if self.equipment is None else self.equipment.host_us()
        return self.decoder.health.report(now)

    def _replayed_link(self) -> LinkSummary:
        report = self.link_report()
        return (
            LinkSummary(state="replay")
            if report is None
            else build_link_summary(report, words="replay")
        )


def _wall_us() -> int:
    return time.time_ns() // 1000
