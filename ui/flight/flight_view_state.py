"""What the Flight place shows at one moment, taken from the session. No Qt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ui.strips.chart_annotations import AlarmSpan, ChannelLimits, ChartMark, ChartSpan, OriginInfo
from ui.translation import tr
from ui.widgets.row_model import TableRow

if TYPE_CHECKING:
    from gsapp.session.live_estimation.estimate_table import EstimateRow


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayState:
    """Where a replay is and how it runs; times in s."""

    time: float
    first: float
    last: float
    playing: bool
    speed: float
    complete: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightViewState:
    """Everything beside the samples."""

    available: tuple[str, ...] = ()  # Channels that the flight can have.
    present: frozenset[str] = frozenset()  # Those that had a sample so far.
    # Those that want a certificate and have none: volts, or nothing at all.
    uncalibrated: frozenset[str] = frozenset()
    # Whether `present` can be trusted: every message had time to come.
    channels_known: bool = False
    sources: Mapping[str, OriginInfo] = field(default_factory=dict)  # Where each comes from.
    # What is drawn behind the traces.
    limits: Mapping[str, ChannelLimits] = field(default_factory=dict)
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
    replay: ReplayState | None = None  # None while live.
    now: float | None = None  # Flight time, s.
    empty_text: str = ""  # What the charts say while there is no sample at all.
    recording: bool = False  # Whether the flight is being recorded.
    # Whether the newest sample is of now, or of the playhead: else the record is being read.
    present_shown: bool = True
    # How much of the flight so far was looked through for alarms, 0 to 1.
    monitored_fraction: float = 1.0


@dataclass(frozen=True, slots=True)
class ChannelOrigin:
    """Where a channel comes from, as charts show it: an `OriginInfo`.

    A value that the aircraft sends in engineering units wants no certificate of ours: only what
    should have one and has none is called uncalibrated.
    """

    kind: str  # ``measured``, ``estimated`` or ``derived``.
    calibrated: bool  # Whether what should have a certificate has one.
    # What the instruments behind it were calibrated for, SI; beyond it their curves go on straight.
    calibrated_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def origin_note(source: OriginInfo) -> str:
    """Return what is to be said of a channel's origin; empty if it is measured and calibrated."""
    words = []
    if source.kind != "measured":
        words.append(source.kind)
    if not source.calibrated:
        words.append(tr("uncalibrated"))
    return ", ".join(words)
