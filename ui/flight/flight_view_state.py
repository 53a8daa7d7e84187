"""What the Flight page shows at one moment, made anew from the session when needed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from gsapp.decoding.derived_channels import underivable_channels
from gsapp.decoding.pipeline import ChannelSource
from gsapp.flight.certificates import calibrated_ranges, uncalibrated_channels
from gsapp.session import LimitBands, Session, SessionSnapshot
from gsapp.session.alarms import AlarmEpisode
from gsapp.session.snapshot import Playhead
from ui.display_limits import DISPLAY
from ui.flight.estimates_panel import fit_status_text
from ui.flight.evidence_panel import search_status_text
from ui.flight.panel_rows import (
    build_alarm_rows,
    build_chart_alarms,
    build_chart_marks,
    build_chart_spans,
    build_mark_rows,
    build_message_rows,
)
from ui.strips.chart_annotations import AlarmSpan, ChannelOrigin, ChartMark, ChartSpan
from ui.translation import tr
from ui.widgets.row_model import TableRow

if TYPE_CHECKING:
    from gsapp.session.live_estimation.estimate_table import EstimateRow
    from gsapp.session.live_estimation.live_search import LiveSearchResult


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightViewState:
    """Everything beside the samples."""

    available: tuple[str, ...] = ()  # Channels that the flight can have.
    present: frozenset[str] = frozenset()  # Those that had a sample so far.
    # Those that want a certificate and have none: volts, or nothing at all.
    uncalibrated: frozenset[str] = frozenset()
    # Whether `present` can be trusted: every message had time to come.
    channels_known: bool = False
    sources: Mapping[str, ChannelOrigin] = field(default_factory=dict)  # Where each comes from.
    limits: Mapping[str, LimitBands] = field(default_factory=dict)
    # Age (s) at which the value of each is stale.
    stale_ages: Mapping[str, float] = field(default_factory=dict)
    marks: tuple[ChartMark, ...] = ()  # On the time axis.
    spans: tuple[ChartSpan, ...] = ()  # Maneuvers, and marks that last.
    # For the panels.
    mark_rows: tuple[TableRow, ...] = ()
    alarm_rows: tuple[TableRow, ...] = ()
    message_rows: tuple[TableRow, ...] = ()
    alarms: tuple[AlarmSpan, ...] = ()  # On the time axis.
    unacknowledged_count: int = 0  # Alarms that nobody has acknowledged.
    estimates: tuple[EstimateRow, ...] = ()  # Derivatives as they form.
    estimates_state: str = ""  # How the fits of the maneuvers stand.
    has_search: bool = False  # Whether a missing effect can be searched for in flight.
    search_enabled: bool = False
    search_steps: tuple[LiveSearchResult, ...] = ()
    search_state: str = ""  # How the search stands.
    replay: Playhead | None = None  # None while live.
    now: float | None = None  # Flight time, s.
    empty_text: str = ""  # What the charts say while there is no sample at all.
    recording: bool = False  # Whether the flight is being recorded.
    # Whether the newest sample is of now, or of the playhead: else the record is being read.
    present_shown: bool = True
    # How much of the flight so far was looked through for alarms, 0 to 1.
    monitored_fraction: float = 1.0


def origin_note(source: ChannelOrigin) -> str:
    """Return what is to be said of a channel's origin; empty if it is measured and calibrated."""
    words = []
    if source.kind != "measured":
        words.append(source.kind)
    if not source.calibrated:
        words.append(tr("uncalibrated"))
    return ", ".join(words)


_NO_BANDS = LimitBands()
_RECEIVED_STATES = ("ok", "weak", "silent")
"""What is said of a link over which something that can be read has come."""
_MESSAGES_INTERVAL = 5
_ESTIMATES_INTERVAL = 10


class FlightViewStateBuilder:
    """Takes pictures of a session."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._available: tuple[str, ...] = ()
        self._known = 0
        self._sources: Mapping[str, ChannelOrigin] = {}
        self._limits: Mapping[str, LimitBands] = {}
        self._limits_revision = -1
        self._stale_timeouts: Mapping[str, float] = {}
        self._messages: tuple[TableRow, ...] = ()
        self._estimates: tuple[EstimateRow, ...] = ()
        self._estimates_state = ""
        self._alarms: tuple[AlarmEpisode, ...] = ()
        self._alarm_spans: tuple[AlarmSpan, ...] = ()
        self._alarm_lines: tuple[TableRow, ...] = ()
        self._alarms_key: tuple[int, str, float | None] | None = None
        self._count = 0
        self._first: float | None = None

    def build(self, snapshot: SessionSnapshot, units: str) -> FlightViewState:
        session = self.session
        self._update_channels()
        if self._count % _MESSAGES_INTERVAL == 0:
            self._messages = build_message_rows(session.messages())
            self._stale_timeouts = session.stale_timeouts(self._available)
        if self._count % _ESTIMATES_INTERVAL == 0:
            self._update_estimates()
        self._update_alarms(snapshot, units)
        self._count += 1
        marks = session.marks
        search = None if session.estimates is None else session.estimates.search
        return FlightViewState(
            available=self._available,
            present=frozenset(session.history.channels_with_data),
            uncalibrated=frozenset(
                name for name, source in self._sources.items() if not source.calibrated
            ),
            channels_known=self._settled(snapshot),
            sources=self._sources,
            limits=self._limits,
            stale_ages=self._stale_timeouts,
            marks=build_chart_marks(marks),
            spans=build_chart_spans(marks),
            mark_rows=build_mark_rows(marks),
            alarms=self._alarm_spans,
            alarm_rows=self._alarm_lines,
            message_rows=self._messages,
            unacknowledged_count=snapshot.unacknowledged_count,
            estimates=self._estimates,
            estimates_state=self._estimates_state,
            has_search=search is not None,
            search_enabled=search is not None and search.enabled,
            search_steps=() if search is None else search.steps,
            search_state="" if search is None else search_status_text(search, units),
            replay=snapshot.playhead,
            now=snapshot.now,
            empty_text=self._empty(snapshot),
            recording=session.recorder is not None,
            present_shown=snapshot.is_up_to_date,
            monitored_fraction=snapshot.monitored_fraction,
        )

    def _empty(self, snapshot: SessionSnapshot) -> str:
        """Return what the charts say without a sample; more may come to a live flight alone."""
        replay = self.session.replay_feed
        if replay is not None:
            return tr("This flight holds no samples") if replay.complete else ""
        heard = snapshot.link.state
        if snapshot.link.problem:
            return snapshot.link.problem
        if heard == "unreadable":
            return tr("Received data cannot be read")
        if heard in _RECEIVED_STATES and snapshot.channel_map:
            return tr("No received message is in the channel map {channel_map}").format(
                channel_map=snapshot.channel_map
            )
        return tr("Nothing received yet")

    def _update_alarms(self, snapshot: SessionSnapshot, units: str) -> None:
        log, playhead = self.session.alarm_log, snapshot.playhead
        last = snapshot.now if playhead is None else playhead.end
        # While one is active its duration grows: twice a second is quick enough to read.
        grows = any(not one.is_over for one in self._alarms) and last is not None
        shown = (log.revision, units, round(2.0 * last) / 2.0 if grows and last else None)
        if shown == self._alarms_key:
            return
        self._alarms_key = shown
        self._alarms = log.episodes
        self._alarm_spans = build_chart_alarms(self._alarms)
        self._alarm_lines = build_alarm_rows(self._alarms, units, last, live=playhead is None)

    def _update_estimates(self) -> None:
        estimates = self.session.estimates
        if estimates is None:
            return
        fits = estimates.fits
        self._estimates = estimates.rows()
        self._estimates_state = estimates.error_text or fit_status_text(
            len(estimates.result.results), fits.pending, fits.failures
        )

    def _settled(self, snapshot: SessionSnapshot) -> bool:
        if snapshot.playhead is not None:
            return snapshot.playhead.complete
        history = self.session.history
        if history.end is None or not snapshot.is_up_to_date:
            return False
        self._first = history.end if self._first is None else self._first
        return history.end - self._first >= DISPLAY.channel_wait

    def _update_channels(self) -> None:
        session = self.session
        sources = session.sources
        known = find_channel_origins(sources)
        available = tuple(dict.fromkeys((*known, *session.history.channels)))
        limits = session.limits
        if available != self._available or limits.revision != self._limits_revision:
            self._limits_revision = limits.revision
            bands = {name: limits.bands(name) for name in available}
            self._limits = {name: band for name, band in bands.items() if band != _NO_BANDS}
        if available != self._available or len(sources) != self._known:
            self._available, self._known = available, len(sources)
            self._sources = find_channel_origins(
                sources, calibrated_ranges(session.calibration, sources)
            )


def find_channel_origins(
    sources: Mapping[str, ChannelSource],
    covered: Mapping[str, Mapping[str, tuple[float, float]]] = MappingProxyType({}),
) -> dict[str, ChannelOrigin]:
    """Return where every channel comes from, those among them that only a certificate would give.

    Instruments without one, and what would be derived from them, are there to be shown: hatched,
    and called uncalibrated, rather than not at all.

    `covered`: from `gsapp.flight.certificates.calibrated_ranges`.
    """
    lacking = [name for name in uncalibrated_channels(sources) if name not in sources]
    return {
        **{
            name: ChannelOrigin(each.kind, not each.uncalibrated_channel, covered.get(name, {}))
            for name, each in sources.items()
        },
        **{name: ChannelOrigin("measured", False) for name in lacking},
        **{
            name: ChannelOrigin("derived", False) for name in underivable_channels(sources, lacking)
        },
    }
