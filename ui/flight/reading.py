"""From the session to what the window shows: pictures and facts, made anew only when needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from gsapp.decoding.derived import missed_without
from gsapp.decoding.pipeline import ChannelSource
from gsapp.flight.certificates import covered_behind, uncalibrated
from gsapp.flight.events import Event
from gsapp.session import Bands, Session, SessionSnapshot, Severity
from gsapp.session.alarms import Episode
from ui.flight.estimates_panel import state_words
from ui.flight.lines import (
    alarm_lines,
    alarm_sentence,
    chart_alarms,
    chart_marks,
    chart_spans,
    mark_lines,
    message_lines,
)
from ui.flight.picture import FlightPicture, Origin, ReplayPicture
from ui.flight.tables import Line
from ui.frame.bar_model import AlarmFacts, BarFacts
from ui.strips.furniture import AlarmSpan, Source

if TYPE_CHECKING:
    from gsapp.session.estimating.picture import EstimateRow

_NO_BANDS = Bands()
_HEARD = ("ok", "weak", "silent")
"""What is said of a link over which something that can be read has come."""
_DUMB = ("silent", "no data", "no aircraft", "unreadable", "not read", "lost")
_MESSAGES_EVERY = 5
_ESTIMATES_EVERY = 10
_FIRST_SECONDS = 3.0
"""Seconds of a live flight after which channels without a sample are taken for absent."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Message:
    """A message of the aircraft for the panel."""

    time: float | None
    text: str
    severity: int | None


class PictureTaker:
    """Takes pictures of a session.

    Parameters
    ----------
    session : Session
        The open flight.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._available: tuple[str, ...] = ()
        self._known = 0
        self._sources: Mapping[str, Source] = {}
        self._limits: Mapping[str, Bands] = {}
        self._limits_revision = -1
        self._patience: Mapping[str, float] = {}
        self._messages: tuple[Line, ...] = ()
        self._estimates: tuple[EstimateRow, ...] = ()
        self._estimates_state = ""
        self._alarms: tuple[Episode, ...] = ()
        self._alarm_spans: tuple[AlarmSpan, ...] = ()
        self._alarm_lines: tuple[Line, ...] = ()
        self._alarms_shown: tuple[int, str, float | None] | None = None
        self._count = 0
        self._first: float | None = None

    def take(self, snapshot: SessionSnapshot, units: str) -> FlightPicture:
        """Return what is beside the samples now."""
        session = self._session
        self._look_at_channels()
        if self._count % _MESSAGES_EVERY == 0:
            self._messages = message_lines(_spoken(session.messages()))
            self._patience = session.patience(self._available)
        if self._count % _ESTIMATES_EVERY == 0:
            self._look_at_estimates()
        self._look_at_alarms(snapshot, units)
        self._count += 1
        marks = session.marks
        playhead = snapshot.playhead
        return FlightPicture(
            available=self._available,
            present=frozenset(session.history.filled),
            uncalibrated=frozenset(
                name for name, source in self._sources.items() if not source.calibrated
            ),
            settled=self._settled(snapshot),
            sources=self._sources,
            limits=self._limits,
            patience=self._patience,
            marks=chart_marks(marks),
            spans=chart_spans(marks),
            mark_lines=mark_lines(marks),
            alarms=self._alarm_spans,
            alarm_lines=self._alarm_lines,
            message_lines=self._messages,
            waiting=snapshot.waiting,
            estimates=self._estimates,
            estimates_state=self._estimates_state,
            replay=None
            if playhead is None
            else ReplayPicture(
                time=playhead.time,
                first=playhead.start,
                last=playhead.end,
                playing=playhead.playing,
                speed=playhead.speed,
                complete=playhead.complete,
            ),
            now=snapshot.now,
            empty=self._empty(snapshot),
            recording=session.recorder is not None,
            present_shown=snapshot.present,
            watched=snapshot.watched,
        )

    def _empty(self, snapshot: SessionSnapshot) -> str:
        """Return what the charts say without a sample; more may come to a live flight alone."""
        replay = self._session.replaying
        if replay is not None:
            return "This flight holds no samples" if replay.complete else ""
        heard = snapshot.link.words
        if snapshot.link.problem:
            return snapshot.link.problem
        if heard == "unreadable":
            return "What arrives cannot be read"
        if heard in _HEARD and snapshot.channel_map:
            return f"Nothing of what has arrived is in the channel map {snapshot.channel_map}"
        return "Nothing has arrived yet"

    def _look_at_alarms(self, snapshot: SessionSnapshot, units: str) -> None:
        log, playhead = self._session.alarm_log, snapshot.playhead
        last = snapshot.now if playhead is None else playhead.end
        # While one is active its duration grows: twice a second is quick enough to read.
        grows = any(not one.over for one in self._alarms) and last is not None
        shown = (log.revision, units, round(2.0 * last) / 2.0 if grows and last else None)
        if shown == self._alarms_shown:
            return
        self._alarms_shown = shown
        self._alarms = log.episodes
        self._alarm_spans = chart_alarms(self._alarms)
        self._alarm_lines = alarm_lines(self._alarms, units, last, live=playhead is None)

    def _look_at_estimates(self) -> None:
        estimates = self._session.estimates
        if estimates is None:
            return
        fits = estimates.fits
        self._estimates = estimates.rows()
        self._estimates_state = estimates.complaint or state_words(
            len(estimates.result.results), fits.pending, fits.failures
        )

    def _settled(self, snapshot: SessionSnapshot) -> bool:
        if snapshot.playhead is not None:
            return snapshot.playhead.complete
        history = self._session.history
        if history.end is None or not snapshot.present:
            return False
        self._first = history.end if self._first is None else self._first
        return history.end - self._first >= _FIRST_SECONDS

    def _look_at_channels(self) -> None:
        session = self._session
        sources = session.sources
        known = origins(sources)
        available = tuple(dict.fromkeys((*known, *session.history.channels)))
        limits = session.limits
        if available != self._available or limits.revision != self._limits_revision:
            self._limits_revision = limits.revision
            bands = {name: limits.bands(name) for name in available}
            self._limits = {name: band for name, band in bands.items() if band != _NO_BANDS}
        if available != self._available or len(sources) != self._known:
            self._available, self._known = available, len(sources)
            self._sources = origins(sources, covered_behind(session.calibration, sources))


def origins(
    sources: Mapping[str, ChannelSource],
    covered: Mapping[str, Mapping[str, tuple[float, float]]] = MappingProxyType({}),
) -> dict[str, Source]:
    """Return where every channel comes from, those among them that only a certificate would give.

    Instruments without one, and what would be derived from them, are there to be shown: hatched,
    and called uncalibrated, rather than not at all.

    Parameters
    ----------
    sources : mapping of str to ChannelSource
    covered : mapping of str to mapping
        From `gsapp.flight.certificates.covered_behind`.
    """
    lacking = [name for name in uncalibrated(sources) if name not in sources]
    return {
        **{
            name: Origin(each.kind, not each.uncalibrated, covered.get(name, {}))
            for name, each in sources.items()
        },
        **{name: Origin("measured", False) for name in lacking},
        **{name: Origin("derived", False) for name in missed_without(sources, lacking)},
    }


def _spoken(events: Sequence[Event]) -> tuple[_Message, ...]:
    return tuple(
        _Message(time=event.time, text=event.text, severity=event.data.get("severity"))
        for event in events
    )


def bar_facts(session: Session, snapshot: SessionSnapshot, units: str, *, muted: bool) -> BarFacts:
    """Return what the bar tells of a session."""
    waiting = [alarm for alarm in snapshot.alarms if not alarm.acknowledged]
    replay = snapshot.mode == "replay"
    return BarFacts(
        name=snapshot.name,
        time=snapshot.now,
        stale=not replay and snapshot.link.words in _DUMB,
        replay=replay,
        link=snapshot.link,
        recorder=None if replay else snapshot.recorder,
        disk=snapshot.disk,
        aircraft=snapshot.aircraft,
        calibration=str(len(snapshot.calibration)) if snapshot.calibration else "",
        other_calibration=Path(session.calibration.given).name,
        calibration_status=snapshot.calibration_status,
        alarms=AlarmFacts(
            sentences=tuple(alarm_sentence(alarm, units) for alarm in waiting),
            severe=any(alarm.severity is Severity.WARNING for alarm in waiting),
            standing=len(snapshot.alarms),
        ),
        muted=muted,
        read=1.0 if snapshot.present else snapshot.progress,
        watched=snapshot.watched,
    )
