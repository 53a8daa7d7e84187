"""One chart as it is shown now: its channels, colors, range, limits and current values."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from gsapp.quantities import (
    CIRCULAR_CHANNELS,
    TRACE_COLORS,
    ChannelSpec,
    base_id,
    channel,
    trace_color,
)
from gsapp.session.limits import LimitBands
from ui.number_format import DASH, number_text
from ui.strips.axis_ticks import AutoRange, value_ticks
from ui.strips.chart_annotations import ChannelOrigin, DisplayFormat, LimitState, find_limit_state
from ui.strips.chart_geometry import PixelBox
from ui.strips.pixel_columns import SampleSource
from ui.strips.raster import BandPaint, ChartPaint, Color, TracePaint
from ui.strips.strip_layout import Strip
from ui.theme import Theme
from ui.translation import QT_TR_NOOP

BEYOND_CALIBRATION_MARK, BEYOND_CALIBRATION_TEXT = "*", QT_TR_NOOP("beyond cal")
"""How a value is marked that an instrument gave beyond what it was calibrated for, and called."""
_DASH = 5  # logical pixels of a third of a dash with its gap
_MIN_TICK_SPACING = 13.5  # logical pixels between labels of the y axis
_MOST_TICKS = 7


@dataclass(slots=True)
class ChartState:
    """One chart."""

    strip: Strip  # Its place in the layout.
    # For each line: channel, how its values are shown, ``#rrggbb`` of the line and of its text,
    # whether it is dashed.
    specs: tuple[ChannelSpec, ...]
    displays: tuple[DisplayFormat, ...]
    colors: tuple[str, ...]
    text_colors: tuple[str, ...]
    dashed: tuple[bool, ...]
    limits: LimitBands | None  # Of the first channel.
    auto_range: AutoRange  # The automatic range.
    # The range in force, displayed units.
    low: float
    high: float
    ticks: list[float] = field(default_factory=list)  # Labels of the y axis, displayed units.


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayedValue:
    """A current value as it is shown."""

    text: str  # The number, or a dash.
    stale: bool = False  # Nothing came lately, or ever: hatched.
    # Beyond a limit, and on which side.
    state: LimitState = ""
    state_text: str = ""
    # Said beside the value.
    estimated: bool = False
    uncalibrated: bool = False
    extrapolated: bool = False


def scale_range(chart: ChartState, factor: float, about: float) -> tuple[float, float]:
    """Return a chart's range (displayed units) times a factor; one value stays where it is."""
    return about + factor * (chart.low - about), about + factor * (chart.high - about)


def parse_rgb(color: str) -> Color:
    """Return red, green and blue of ``#rrggbb``."""
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def line_width(theme: Theme, ratio: float) -> float:
    """Return the width of the lines in pixels."""
    return max(theme.line_width * ratio, 1.0)


def assign_trace_colors(
    channels: Sequence[str], asked: Sequence[str | None] = ()
) -> tuple[str, ...]:
    """Return the trace colors of channels that share a chart.

    Each has its own color (`trace_color`) unless it asks for another or the color is taken: then
    it gets the next free one.
    """
    asked = (*asked, *(None,) * (len(channels) - len(asked)))
    used = {name for name in asked if name is not None}
    colors = []
    for channel_id, wanted in zip(channels, asked, strict=True):
        color = wanted
        if color is None:
            order = (trace_color(channel_id), *TRACE_COLORS)
            color = next((name for name in order if name not in used), order[0])
            used.add(color)
        colors.append(color)
    return tuple(colors)


def create_chart(strip: Strip, theme: Theme, system: str, limits: LimitBands | None) -> ChartState:
    """Return a chart of the layout, in ``US`` or ``SI`` units, with nothing measured yet."""
    names = assign_trace_colors(
        [trace.channel for trace in strip.traces], [trace.color for trace in strip.traces]
    )
    colors = [
        theme.previous if trace.style == "previous" else theme.trace(name)
        for trace, name in zip(strip.traces, names, strict=True)
    ]
    specs = tuple(channel(trace.channel) for trace in strip.traces)
    displays = tuple(DisplayFormat.for_channel(spec, system) for spec in specs)
    steady = AutoRange(displays[0].min_span)
    low, high = steady.target_range(displays[0].to_display(0.0), displays[0].to_display(0.0))
    chart = ChartState(
        strip=strip,
        specs=specs,
        displays=displays,
        colors=tuple(colors),
        # The gray of previous lines is too faint to be read.
        text_colors=tuple(theme.muted if color == theme.previous else color for color in colors),
        dashed=tuple(trace.style == "computed" for trace in strip.traces),
        limits=limits,
        auto_range=steady,
        low=low,
        high=high,
    )
    if strip.range == "fixed" and strip.low is not None and strip.high is not None:
        chart.low, chart.high = (
            displays[0].to_display(strip.low),
            displays[0].to_display(strip.high),
        )
    elif strip.range == "limits":
        ends = _range_of_limits(specs[0], limits)
        chart.low, chart.high = displays[0].to_display(ends[0]), displays[0].to_display(ends[1])
    return chart


def _range_of_limits(spec: ChannelSpec, limits: LimitBands | None) -> tuple[float, float]:
    low, high = spec.limits
    edges = [] if limits is None else [edge for edge in _limit_edges(limits) if edge is not None]
    if len(edges) > 1:
        room = 0.15 * (max(edges) - min(edges))
        low, high = max(low, min(edges) - room), min(high, max(edges) + room)
    return low, high


def _limit_edges(limits: LimitBands) -> tuple[float | None, ...]:
    return limits.warning_low, limits.caution_low, limits.caution_high, limits.warning_high


def update_ticks(chart: ChartState, box: PixelBox, free: float, ratio: float) -> None:
    """Choose the labels of a chart's y axis; `free` rows stay free at either end."""
    chart.ticks = value_ticks(
        chart.low, chart.high, box.height, free, _MIN_TICK_SPACING * ratio, most=_MOST_TICKS
    )


def create_chart_paint(
    chart: ChartState, top: int, height: int, theme: Theme, ratio: float
) -> ChartPaint:
    """Return how the raster paints a chart that begins at row `top`."""
    display = chart.displays[0]
    dash = max(round(_DASH * ratio), 1)
    return ChartPaint(
        top=top,
        height=height,
        low=display.to_si(chart.low),
        high=display.to_si(chart.high),
        traces=tuple(
            TracePaint(channel=spec.id, color=parse_rgb(color), dash=dash if dashed else 0)
            for spec, color, dashed in zip(chart.specs, chart.colors, chart.dashed, strict=True)
        ),
        bands=_create_bands(chart.limits, theme),
        grid=tuple(display.to_si(value) for value in chart.ticks),
    )


def _create_bands(limits: LimitBands | None, theme: Theme) -> tuple[BandPaint, ...]:
    if limits is None:
        return ()
    warning_low, caution_low, caution_high, warning_high = _limit_edges(limits)
    bands: list[tuple[float, float, LimitState]] = []
    if caution_low is not None:
        bands.append((-math.inf if warning_low is None else warning_low, caution_low, "caution"))
    if caution_high is not None:
        bands.append((caution_high, math.inf if warning_high is None else warning_high, "caution"))
    if warning_low is not None:
        bands.append((-math.inf, warning_low, "warning"))
    if warning_high is not None:
        bands.append((warning_high, math.inf, "warning"))
    return tuple(
        BandPaint(
            low=low,
            high=high,
            fill=parse_rgb(theme.caution_band if state == "caution" else theme.warning_band),
            border=parse_rgb(theme.caution_fill if state == "caution" else theme.warning_fill),
        )
        for low, high, state in bands
    )


def find_displayed_value(
    history: SampleSource,
    spec: ChannelSpec,
    display: DisplayFormat,
    now: float | None,
    patience: float,
    limits: LimitBands | None,
    source: ChannelOrigin | None,
) -> DisplayedValue:
    """Return the current value of a channel.

    `patience`: age (s) from which a value is stale.
    """
    estimated = source is not None and source.kind == "estimated"
    uncalibrated = source is not None and not source.calibrated
    latest = history.last(spec.id) if spec.id in history.channels else None
    if latest is None or (now is not None and now - latest[0] > patience):
        return DisplayedValue(text=DASH, stale=True, estimated=estimated, uncalibrated=uncalibrated)
    state, word = find_limit_state(latest[1], limits)
    return DisplayedValue(
        text=number_text(display.to_display(latest[1]), display.decimals),
        state=state,
        state_text=word,
        estimated=estimated,
        uncalibrated=uncalibrated,
        extrapolated=is_beyond_calibration(source, lambda name: _latest_sample(history, name)),
    )


def is_beyond_calibration(source: ChannelOrigin | None, value_of: Callable[[str], float]) -> bool:
    """Return whether a value stands on an instrument beyond what that was calibrated for.

    `value_of`: from the id of an instrument's channel to its value (SI) at the same time; NaN for
    none.
    """
    for name, (low, high) in source.calibrated_ranges.items() if source is not None else ():
        value = value_of(name)
        if value < low or value > high:
            return True
    return False


def channel_difference(spec: ChannelSpec, first: float, second: float) -> float:
    """Return how far the second value of a channel is from the first, both SI.

    Of an angle that begins anew after a turn it is the short way, as between two samples.
    """
    apart = second - first
    return (
        (apart + math.pi) % math.tau - math.pi if base_id(spec.id) in CIRCULAR_CHANNELS else apart
    )


def _latest_sample(history: SampleSource, name: str) -> float:
    last = history.last(name) if name in history.channels else None
    return math.nan if last is None else last[1]
