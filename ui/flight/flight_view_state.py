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
    """Everything beside the samples.

    Attributes
    ----------
    available : tuple of str
        Channels that the flight can have.
    present : frozenset of str
        Those that had a sample so far.
    uncalibrated : frozenset of str
        Those that want a certificate and have none: volts, or nothing at all.
    channels_known : bool
        Whether `present` can be trusted: every message had time to come.
    sources : mapping of str to OriginInfo
        Where each comes from.
    limits : mapping of str to ChannelLimits
        What is drawn behind the traces.
    stale_ages : mapping of str to float
        Age (s) at which the value of each is stale.
    marks : tuple of ChartMark
        On the time axis.
    spans : tuple of ChartSpan
        Maneuvers, and marks that last.
    mark_rows, alarm_rows, message_rows : tuple of TableRow
        For the panels.
    alarms : tuple of AlarmSpan
        On the time axis.
    unacknowledged_count : int
        Alarms that nobody has acknowledged.
    estimates : tuple of EstimateRow
        Derivatives as they form.
    estimates_state : str
        How the fits of the maneuvers stand.
    replay : ReplayState or None
        None while live.
    now : float or None
        Flight time, s.
    empty_text : str
        What the charts say while there is no sample at all.
    recording : bool
        Whether the flight is being recorded.
    present_shown : bool
        Whether the newest sample is of now, or of the playhead: else the record is being read.
    monitored_fraction : float
        How much of the flight so far was looked through for alarms, 0 to 1.
    """

    available: tuple[str, ...] = ()
    present: frozenset[str] = frozenset()
    uncalibrated: frozenset[str] = frozenset()
    channels_known: bool = False
    sources: Mapping[str, OriginInfo] = field(default_factory=dict)
    limits: Mapping[str, ChannelLimits] = field(default_factory=dict)
    stale_ages: Mapping[str, float] = field(default_factory=dict)
    marks: tuple[ChartMark, ...] = ()
    spans: tuple[ChartSpan, ...] = ()
    mark_rows: tuple[TableRow, ...] = ()
    alarm_rows: tuple[TableRow, ...] = ()
    message_rows: tuple[TableRow, ...] = ()
    alarms: tuple[AlarmSpan, ...] = ()
    unacknowledged_count: int = 0
    estimates: tuple[EstimateRow, ...] = ()
    estimates_state: str = ""
    replay: ReplayState | None = None
    now: float | None = None
    empty_text: str = ""
    recording: bool = False
    present_shown: bool = True
    monitored_fraction: float = 1.0


@dataclass(frozen=True, slots=True)
class ChannelOrigin:
    """Where a channel comes from, as charts show it: an `OriginInfo`.

    A value that the aircraft sends in engineering units wants no certificate of ours: only what
    should have one and has none is called uncalibrated.

    Attributes
    ----------
    kind : str
        ``measured``, ``estimated`` or ``derived``.
    calibrated : bool
        Whether what should have a certificate has one.
    calibrated_ranges : mapping of str to (float, float)
        What the instruments behind it were calibrated for, SI; beyond it their curves go on
        straight.
    """

    kind: str
    calibrated: bool
    calibrated_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def origin_note(source: OriginInfo) -> str:
    """Return what is to be said of a channel's origin; empty if it is measured and calibrated."""
    words = []
    if source.kind != "measured":
        words.append(source.kind)
    if not source.calibrated:
        words.append(tr("uncalibrated"))
    return ", ".join(words)
