"""One flight being watched, live or in a replay: everything a window or a command needs of it.

`Session.update` is called by a timer, does what fits into a few milliseconds, and goes on in the
next call. No threads, no Qt: what the session holds changes in `update` and in the user's own
actions only.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from calibration import Certificate
from gsapp.aircraft import Aircraft
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.pipeline import ChannelSource
from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.speaking import Spoken
from gsapp.flight.cards import CardSet
from gsapp.flight.certificates import CertificatesUsed, calibration_remarks, uncalibrated
from gsapp.flight.events import Event, EventLog, event_of, events_path, in_order
from gsapp.flight.flight import Flight, FrameCounts
from gsapp.flight.folder import FlightFolder
from gsapp.flight.loading import damaged_events, load_flight
from gsapp.flight.raw import RawDamage
from gsapp.flight.uniform import union
from gsapp.foundation import FileProblemsError
from gsapp.quantities import Block
from gsapp.session.alarm_log import AlarmLog
from gsapp.session.alarm_watch import AlarmWatch
from gsapp.session.alarms import AlarmBoard
from gsapp.session.cue_watch import CueWatch
from gsapp.session.equipment import (
    DiskView,
    EquipmentMonitor,
    LinkView,
    RecorderView,
    link_view,
)
from gsapp.session.feeds import MAX_SPEED, LiveFeed, ReplayFeed
from gsapp.session.history import History
from gsapp.session.limits import Bands, LimitSet
from gsapp.session.marks import Mark, MarkBook, MarkKind
from gsapp.session.readers import FlightReader, RecordReader, folder_reader, tlog_reader
from gsapp.session.setting import Options, SessionSetting, setting_for
from gsapp.session.snapshot import Mode, Playhead, SessionSnapshot
from gsapp.session.states import (
    USUAL_PATIENCE,
    ChannelState,
    channel_state,
    come_together,
    message_of,
    patience_by_message,
)
from gsapp.telemetry.recorder_control import RecorderHandle

if TYPE_CHECKING:
    from gsapp.excitation.debrief import Debrief
    from gsapp.excitation.doublets.verdict import Verdict
    from gsapp.flight.info import FlightInfo
    from gsapp.session.estimating.watch import EstimateWatch
    from gsapp.session.estimating.workers import Workers
    from gsapp.session.feeds import Consumer

_EVENTS_EVERY = 0.25
_RELAX_EVERY = 10.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Opened:
    """A flight that was opened, and where its samples come from.

    Attributes
    ----------
    reader : RecordReader or FlightReader
        Gives its blocks.
    setting : SessionSetting
        What it is read and watched with.
    rate : float
        Of the grid, Hz.
    whole : Flight or None
        A flight that was read whole.
    damage : callable
        Returns what was lost of the record.
    has_grown : callable
        Returns whether the record may hold something new.
    """

    path: Path
    reader: RecordReader | FlightReader
    setting: SessionSetting
    rate: float
    whole: Flight | None = None
    damage: Callable[[], Sequence[RawDamage]] = tuple
    has_grown: Callable[[], bool] = lambda: True


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
    history : History
        All samples so far; in a replay up to the playhead.
    board : AlarmBoard
        The alarms.
    limits : LimitSet
        The limits in force.
    book : MarkBook
        Marks and notes.
    aircraft : Aircraft or None
        From the flight folder, or as given.
    cue_watch : CueWatch or None
        Judges trim, inputs and dangers; None where the options switch it off.
    estimates : EstimateWatch or None
        Derivatives as they form; None without workers or an aircraft.
    feed : LiveFeed or ReplayFeed
        What drives it. A window plays, pauses and jumps through `replaying`.
    """

    def __init__(
        self,
        opened: _Opened,
        options: Options,
        *,
        mode: Mode,
        speed: float = 1.0,
        playing: bool = True,
    ) -> None:
        path, setting = opened.path, opened.setting
        clock = options.get("clock", time.monotonic)
        wall_us = options.get("wall_us", _wall_us)
        self.path = path
        self.name = FlightFolder(path=path).name if path.is_dir() else path.stem
        self.mode: Mode = mode
        self.aircraft: Aircraft | None = setting.aircraft
        self.limits = LimitSet(setting.aircraft, setting.limits)
        self.board = AlarmBoard()
        self.history = History((), opened.rate)
        self.book = MarkBook(EventLog(events_path(path)), wall_us)
        self._reader = opened.reader
        self._setting = setting
        self._flight = opened.whole
        self._damage = opened.damage
        self._has_grown = opened.has_grown
        self._clock = clock
        self._wall_us = wall_us
        self._messages: dict[str, str | None] = {}
        self._next_events = self._next_relax = -math.inf
        self._alarm_log = AlarmLog(self.board, self.book, wall_us, self._take_in)
        self._watch = AlarmWatch(
            self.board, self.limits, self.history.rate, self._carrier, self._come_together
        )
        self.cue_watch: CueWatch | None = None
        if options.get("cues", True):
            self.cue_watch = self._make_cues(options.get("system", "US"))
        self.estimates: EstimateWatch | None = None
        workers = options.get("workers")
        if workers is not None and self.aircraft is not None:
            self.estimates = self._make_estimates(self.aircraft, workers)
        every: tuple[Consumer | None, ...] = (self._watch, self.cue_watch, self.estimates)
        watches = [one for one in every if one is not None]
        everyone = (*watches, *options.get("consumers", ()))
        self.equipment: EquipmentMonitor | None = None
        self.feed: LiveFeed | ReplayFeed
        if mode == "live":
            self.equipment = EquipmentMonitor(path, self.board, clock, wall_us)
            self.feed = LiveFeed(opened.reader, self.history, everyone, clock)
        else:
            self.feed = ReplayFeed(
                opened.reader, self.history, everyone, clock, speed=speed, playing=playing
            )

        # What the crew chose in an earlier window counts from when it was chosen.
        self._alarm_log.read()

    # Making one

    @classmethod
    def follow(cls, folder: Path | str, **options: Unpack[Options]) -> Session:
        """Watch a flight that is being recorded, from its beginning.

        Parameters
        ----------
        folder : Path or str
            The flight folder, made by the recorder; it finds the recorder that runs there.
        **options
            See `gsapp.session.setting.Options`.

        Raises
        ------
        FlightError
            If it is no flight folder.
        FileProblemsError, UnknownNameError
            If a file holds mistakes or a name does not exist.
        """
        path = FlightFolder.open(folder).path
        return cls(_open_record(path, setting_for(path, options), grows=True), options, mode="live")

    @classmethod
    def replay(
        cls,
        flight: Path | str,
        *,
        speed: float = 1.0,
        playing: bool = True,
        **options: Unpack[Options],
    ) -> Session:
        """Play a flight that was recorded: a folder, or any file that `load_flight` opens.

        Raw records go the road of a live flight, through the decoder; other files are read
        whole and then released by the playhead.

        Parameters
        ----------
        flight : Path or str
            The flight.
        speed : float
            0.1 to 50 times real time, or `gsapp.session.feeds.MAX_SPEED`.
        playing : bool
            Whether it plays at once.
        **options
            See `gsapp.session.setting.Options`.

        Raises
        ------
        FlightError
            If it cannot be read.
        FileProblemsError, UnknownNameError
            If a file holds mistakes or a name does not exist.
        """
        path = Path(flight)
        setting = setting_for(path, options)
        if path.is_dir() and FlightFolder.open(path).records:
            opened = _open_record(path, setting, grows=False)
        elif path.is_file() and path.suffix.casefold() == ".tlog":
            reader, stepped_over = tlog_reader(path, setting)
            opened = _Opened(
                path=path,
                reader=reader,
                setting=setting,
                rate=setting.grid_rate,
                damage=lambda: (stepped_over,) if stepped_over else (),
            )
        else:
            opened = _open_whole(path, setting, options)
        return cls(opened, options, mode="replay", speed=speed, playing=playing)

    # The timer

    def update(self, budget: float = 0.008) -> None:
        """Take in what came, as far as it fits into `budget` seconds; the rest comes next time."""
        now = self._clock()
        self.feed.advance(now + budget)
        if now >= self._next_events:
            self._next_events = now + _EVENTS_EVERY
            self._alarm_log.read()
        if self.estimates is not None:
            self.estimates.look(self.now)
        if now >= self._next_relax:
            self._next_relax = now + _RELAX_EVERY
            self.history.relax()
        if self.equipment is not None:
            decoder = self.decoder
            health = None if decoder is None else decoder.health
            if self.equipment.look(health, self.now, caught_up=self.feed.caught_up):
                self._alarm_log.write_equipment()
                if self.cue_watch is not None:
                    self.cue_watch.look_at_equipment()

    @property
    def has_news(self) -> bool:
        """Return whether `update` would find anything to take in.

        Live this looks at the sizes of the files alone, and may be asked every few milliseconds.
        A replay goes on by itself: always.
        """
        return self.mode == "replay" or not self.feed.caught_up or self._has_grown()

    def finish(self) -> None:
        """Take in the very last rows of a flight that is over, and judge them."""
        if isinstance(self.feed, LiveFeed):
            self.feed.finish()
        if self.cue_watch is not None:
            self.cue_watch.finish()
        if self.estimates is not None:
            self.estimates.finish()

    def close(self) -> None:
        """Give back what the session holds. Recorder and record go on."""
        if self.estimates is not None:
            self.estimates.close()
        self.history.close()

    # What it shows

    @property
    def now(self) -> float | None:
        """Return the flight time: of the newest sample, or of the playhead; s."""
        return self.feed.now

    @property
    def replaying(self) -> ReplayFeed | None:
        """Return the playhead's controls; None while live."""
        return self.feed if isinstance(self.feed, ReplayFeed) else None

    @property
    def recorder(self) -> RecorderHandle | None:
        """Return the recorder that runs for this flight, as of the last look."""
        return None if self.equipment is None else self.equipment.handle

    @property
    def decoder(self) -> Decoder | None:
        """Return the decoder; None before a map was found, and for flights read whole."""
        return self._reader.decoder if isinstance(self._reader, RecordReader) else None

    @property
    def sources(self) -> Mapping[str, ChannelSource]:
        """Return every channel that the flight can have, and from where."""
        return self._reader.sources

    @property
    def certificates(self) -> Mapping[str, Certificate]:
        """Return the certificates in force, by channel."""
        if isinstance(self._reader, RecordReader):
            return self._reader.certificates
        return self._setting.certificates or {}

    @property
    def calibration(self) -> CertificatesUsed:
        """Return which certificates are in force, and whether in place of the flight's own."""
        if self._flight is not None:
            return self._flight.certificates
        setting = self._setting
        return CertificatesUsed(used=self.certificates, given=setting.given, own=setting.own)

    @property
    def uncalibrated(self) -> tuple[str, ...]:
        """Return the channels whose instruments give volts only, for want of a certificate."""
        return uncalibrated(self.sources)

    @property
    def cues(self) -> CueSnapshot | None:
        """Return what the crew is to be told now; None where cues are switched off."""
        watch = self.cue_watch
        return None if watch is None else watch.snapshot(self.uncalibrated)

    @property
    def spoken(self) -> Sequence[Spoken]:
        """Return all that is to be heard so far; it shrinks only when a replay goes back."""
        return () if self.cue_watch is None else self.cue_watch.spoken

    @property
    def cards(self) -> CardSet | None:
        """Return the test cards."""
        return None if self.cue_watch is None else self.cue_watch.cueing.cards

    def debrief(self) -> Debrief | None:
        """Return every input judged so far, and the score by card; None without cues."""
        watch = self.cue_watch
        if watch is None:
            return None
        from gsapp.excitation.debrief import debrief_of

        return debrief_of(self.name, watch.cueing)

    @property
    def marks(self) -> tuple[Mark, ...]:
        """Return marks and notes, by flight time."""
        return self.book.marks

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return what was lost or left out on reading, in words."""
        return self._remarks()

    def _remarks(self, block: Block | None = None) -> tuple[str, ...]:
        """Return them with what is to be said of the whole flight, if it is given."""
        whole = () if self._flight is None else self._flight.remarks
        decoder = self.decoder
        said = () if decoder is None else decoder.health.sentences()
        lost = [damage.sentence() for damage in self._damage()]
        if self.book.damaged and self._flight is None:
            lost.append(damaged_events(self.book.damaged))
        # What was read whole has said so itself.
        read = (
            calibration_remarks(self.calibration, self.sources, block)
            if self._flight is None
            else ()
        )
        return (*lost, *read, *self._setting.remarks, *whole, *said)

    def messages(self) -> tuple[Event, ...]:
        """Return what the vehicle said, and what was noticed about it, up to now, by time."""
        decoder = self.decoder
        if decoder is not None:
            said = [event_of(notice) for notice in (*decoder.messages, *decoder.notices)]
        else:
            said = (
                []
                if self._flight is None
                else [event for event in self._flight.events if event.kind == "status"]
            )
        limit = self.now if self.replaying is not None else None
        return tuple(
            sorted(
                (
                    event
                    for event in said
                    if limit is None or event.time is None or event.time <= limit
                ),
                key=lambda event: (event.time is not None, event.time or 0.0),
            )
        )

    def snapshot(self) -> SessionSnapshot:
        """Return what the bar shows."""
        decoder = self.decoder
        equipment = self.equipment
        standing = self.board.standing
        problem = self._reader.problem if isinstance(self._reader, RecordReader) else ""
        return SessionSnapshot(
            name=self.name,
            path=self.path,
            mode=self.mode,
            now=self.now,
            caught_up=self.feed.caught_up,
            progress=self.feed.progress,
            link=self._replayed_link() if equipment is None else equipment.link,
            recorder=RecorderView(words="none") if equipment is None else equipment.recorder,
            disk=DiskView() if equipment is None else equipment.disk,
            aircraft="" if self.aircraft is None else self.aircraft.name,
            channel_map="" if decoder is None else decoder.channel_map.name,
            calibration=tuple(sorted(self.certificates)),
            uncalibrated=self.uncalibrated,
            alarms=standing,
            waiting=sum(not alarm.acknowledged for alarm in standing),
            playhead=self._playhead(),
            problem=problem,
            marks_revision=self.book.revision,
            alarms_revision=self.board.revision,
        )

    def states(self, channel_ids: Sequence[str] | None = None) -> dict[str, ChannelState]:
        """Return what can be said of each channel now; by default of all that there can be."""
        names = channel_ids
        if names is None:
            names = list(dict.fromkeys((*self.sources, *self.history.channels)))
        decoder = self.decoder
        late = patience_by_message(None if decoder is None else decoder.health.report())
        now = self._present()

        def patience(channel_id: str) -> float:
            message = self._carrier(channel_id) or ""
            return late.get(message.partition("[")[0], USUAL_PATIENCE)

        return {
            name: channel_state(
                name,
                history=self.history,
                sources=self.sources,
                limits=self.limits,
                board=self.board,
                now=now,
                patience=patience,
            )
            for name in names
        }

    def flight(self) -> Flight:
        """Return everything up to now as one flight, as `load_flight` would.

        Returns
        -------
        Flight
            Its block holds the whole history in memory.
        """
        if self._flight is not None:
            return self._flight
        decoder = self.decoder
        health = None if decoder is None else decoder.health
        damage = list(self._damage())
        block = union(self.history.blocks(), self.history.rate)
        info = FlightFolder(path=self.path).info() if self.path.is_dir() else None
        log = () if info is None or not info.onboard_log else (_beside(info.onboard_log),)
        # A log of another ground station has its damage in the file, not in a residue.
        torn = sum(each.places for each in damage) if self.path.is_file() else 0
        decoder = self.decoder
        counted = self.sources if decoder is None else decoder.counted_sources()
        return Flight(
            name=self.name,
            path=self.path,
            block=block,
            sources={name: counted[name] for name in block.channels},
            info=info,
            frames=None
            if health is None
            else FrameCounts(
                good=health.good,
                damaged=health.damaged + torn,
                unknown=health.unknown,
                lost=health.lost,
            ),
            events=in_order((*self.book.events, *self.messages())),
            remarks=(*log, *self._remarks(block)),
            certificates=self.calibration,
        )

    # What the user does

    def mark(
        self,
        text: str = "",
        *,
        at: float | None = None,
        end: float | None = None,
        kind: MarkKind = "mark",
    ) -> Mark:
        """Make a mark or note, by default at the present flight time.

        Raises
        ------
        FlightError
            If it cannot be written.
        """
        return self.book.add(self.now if at is None else at, text, end=end, kind=kind)

    def type_limits(self, channel_id: str, bands: Bands | None) -> None:
        """Let other limits count for a channel from now on; None for those of the flight."""
        self.limits.set_typed(channel_id, bands)
        self._watch.renew(channel_id)

    def choose_card(self, card_id: str) -> None:
        """Let a test card be the next until it is flown; an empty id lets the program pick.

        A live flight keeps the choice among its events, so that a replay tells the same.

        Raises
        ------
        UnknownNameError
            If there is no such card.
        FlightError
            If it cannot be written.
        """
        if self.cue_watch is not None:
            self.cue_watch.choose(card_id)

    def use_units(self, system: str) -> None:
        """Give cues in these units, ``US`` or ``SI``, from now on."""
        if self.cue_watch is not None:
            self.cue_watch.cueing.use_units(system)

    def use_cards(self, cards: CardSet) -> None:
        """Take other test cards; a live flight without any keeps them in its folder.

        Raises
        ------
        FlightError
            If they cannot be written; they count in this window.
        """
        if self.cue_watch is None:
            return
        self.cue_watch.cueing.use_cards(cards)
        folder = FlightFolder(path=self.path)
        if self.mode == "live" and not folder.cards_file.exists():
            folder.keep_cards(cards)

    def acknowledge(self, key: str | None = None) -> bool:
        """Take note of an alarm, by default of the newest that waits; return whether there was one.

        It is written to the flight's events, so that other windows know.
        """
        alarm = self.board.get(key) if key is not None else next(iter(self.board.waiting), None)
        if alarm is None or alarm.acknowledged:
            return False
        self._alarm_log.acknowledge(alarm, self.now)
        return True

    def acknowledge_all(self) -> int:
        """Take note of all alarms that wait; return how many there were."""
        return sum(self.acknowledge(alarm.key) for alarm in self.board.waiting)

    # Inside

    def _make_cues(self, system: str) -> CueWatch:
        from gsapp.excitation.cueing import Cueing  # the window starts without it

        setting = self._setting
        cueing = Cueing(
            self.aircraft,
            setting.model,
            self.history.rate,
            cards=setting.cards,
            fence=setting.fence,
            system=system,
        )
        live = self.mode == "live"
        return CueWatch(cueing, self.board, self.book, self._alarm_log.read, live=live)

    def _make_estimates(self, aircraft: Aircraft, workers: Workers) -> EstimateWatch:
        from gsapp.session.estimating.watch import EstimateWatch  # the window starts without it

        return EstimateWatch(
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
        if self._flight is not None:
            return self._flight.info
        try:
            return FlightFolder(path=self.path).info() if self.path.is_dir() else None
        except FileProblemsError:
            return None

    def _verdicts(self) -> Sequence[Verdict]:
        return () if self.cue_watch is None else self.cue_watch.cueing.verdicts

    def _take_in(self, event: Event) -> None:
        """Take in an event of the flight that is no acknowledgment."""
        if self.cue_watch is not None:
            self.cue_watch.take_in(event)

    def _present(self) -> float | None:
        """Return the flight time at this moment, from which ages count."""
        now = self.now
        decoder = self.decoder
        if now is None or self.mode == "replay" or decoder is None:
            return now
        heard = decoder.health.last_stamp
        silent = 0.0 if heard is None else max(self._wall_us() - heard, 0) / 1e6
        return now + silent

    def _carrier(self, channel_id: str) -> str | None:
        """Return the message that carries a channel."""
        if channel_id not in self._messages:
            self._messages[channel_id] = message_of(self.sources.get(channel_id))
        return self._messages[channel_id]

    def _come_together(self, one: str, other: str) -> bool:
        """Return whether two channels come in the same blocks."""
        if isinstance(self._reader, FlightReader):
            return True
        return come_together(one, other, self.sources)

    def _playhead(self) -> Playhead | None:
        feed = self.replaying
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

    def _replayed_link(self) -> LinkView:
        decoder = self.decoder
        if decoder is not None:
            return link_view(decoder.health.report(), words="replay")
        return LinkView(words="replay")


def _beside(log: str) -> str:
    return (
        f"this is the live record; the on-board log {log} holds more: 'gsapp export' joins the "
        "two, and the log can be replayed by itself"
    )


def run_through(session: Session, tell: Callable[[float], None] = lambda _: None) -> None:
    """Play a replay to its end, as fast as it goes or at its speed.

    Parameters
    ----------
    session : Session
        A replay that plays.
    tell : callable
        Called with the share done, 0 to 1.
    """
    feed = session.replaying
    if feed is None:
        raise ValueError("only a replay has an end to run to")
    while True:
        session.update(0.1)
        if feed.complete and (feed.now is None or (feed.at_end and feed.caught_up)):
            break
        tell(_share(feed))
        if feed.speed != MAX_SPEED:
            time.sleep(0.01)
    session.finish()
    tell(1.0)


def _share(feed: ReplayFeed) -> float:
    """Return the share done: of reading ahead, and of the playhead's way."""
    if feed.now is None or feed.start is None or feed.end is None or feed.end <= feed.start:
        return 0.5 * feed.progress
    return 0.5 * feed.progress + 0.5 * (feed.now - feed.start) / (feed.end - feed.start) * (
        feed.progress
    )


def _open_record(path: Path, setting: SessionSetting, *, grows: bool) -> _Opened:
    reader, tail = folder_reader(path, setting, grows=grows)
    return _Opened(
        path=path,
        reader=reader,
        setting=setting,
        rate=setting.grid_rate,
        damage=lambda: tail.lost,
        has_grown=tail.has_grown if grows else lambda: True,
    )


def _open_whole(path: Path, setting: SessionSetting, options: Options) -> _Opened:
    whole = load_flight(
        path,
        channel_map=setting.channel_map,
        rate=options.get("rate"),
        certificates=options.get("certificates"),
        aircraft=setting.aircraft,
    )
    return _Opened(
        path=path,
        reader=FlightReader(whole),
        setting=setting,
        rate=whole.rate if math.isfinite(whole.rate) else setting.grid_rate,
        whole=whole,
    )


def _wall_us() -> int:
    return time.time_ns() // 1000
