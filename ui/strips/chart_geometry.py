"""Where everything stands, in whole pixels of the screen. No Qt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

_MIN_CHART_HEIGHT = 20
"""Logical pixels in which a line of values and the two labels of a scale still stand."""
_MIN_VALUE_HEIGHT = 9  # Logical pixels from one value at a cursor to the next below it, at least.
_CHART_GAP = 3
_GROUP_GAP = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class PixelBox:
    """A rectangle in pixels."""

    x: int
    y: int
    width: int
    height: int

    @property
    def right(self) -> int:
        return self.x + self.width

    @property
    def bottom(self) -> int:
        return self.y + self.height

    @property
    def center(self) -> float:
        return self.y + self.height / 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnWidths:
    """Widths in pixels: what the text beside the plot needs."""

    gutter: int  # Names of the groups.
    names: int  # Symbol, unit and title.
    ticks: int  # Labels of the y axis.
    values: int  # Current values with tag and unit.
    units: int  # The part of `values` that the units take.
    cursor: int  # One column of values at a cursor.


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartGeometry:
    """Everything that has a place."""

    ratio: float  # Pixels to a logical pixel of the design: scale times density of the screen.
    columns: ColumnWidths
    # Line at the top; labels of spans and marks; all charts; time axis; current values, and their
    # units at the right of them.
    header: PixelBox
    lane: PixelBox
    plot: PixelBox
    axis: PixelBox
    values: PixelBox
    units: PixelBox
    # Columns of values at cursors, filled from top to bottom; as a rule one holds them all.
    cursors: tuple[PixelBox, ...]
    charts: tuple[PixelBox, ...]  # The charts shown, in the plot.
    numbers: tuple[int, ...]  # Their numbers in the layout.
    groups: tuple[tuple[str, PixelBox], ...]  # Groups shown, in the gutter.
    hidden: int  # Charts that found no room.

    @property
    def ticks(self) -> PixelBox:
        """Return where the labels of the y axes stand."""
        return replace(self.plot, x=self.plot.x - self.columns.ticks, width=self.columns.ticks)

    def chart_at(self, y: float) -> int | None:
        for index, box in enumerate(self.charts):
            if box.y <= y < box.bottom:
                return index
        return None


def compute_geometry(
    width: int,
    height: int,
    ratio: float,
    columns: ColumnWidths,
    groups: Sequence[tuple[str, Sequence[float]]],
    cursor_values: int,
    selected: int,
    alone: bool,
) -> ChartGeometry:
    """Place everything.

    Parameters
    ----------
    ratio : float
        See `ChartGeometry`.
    columns : ColumnWidths
        Widths of the text beside the plot.
    groups : sequence of (name, heights)
        The groups with the relative heights of their charts.
    cursor_values : int
        Values at cursors that a chart has at most. They stand in as few columns as they can;
        columns that leave too little plot are left out.
    selected : int
        Chart that must be among those shown.
    alone : bool
        Whether it is the only one.
    """

    def px(points: float) -> int:
        return round(points * ratio)

    header_height, lane_height, axis_height = px(26), px(20), px(26)
    left = columns.gutter + columns.names + columns.ticks
    plot = PixelBox(
        x=left,
        y=header_height + lane_height,
        width=max(width - columns.values - left, 1),
        height=max(height - header_height - lane_height - axis_height, 1),
    )
    boxes, numbers, spans, hidden = _stack_charts(plot, ratio, groups, selected, alone)
    lowest = min((box.height for box in boxes), default=1)
    count = math.ceil(cursor_values / max(lowest // px(_MIN_VALUE_HEIGHT), 1))
    while count and plot.width - count * columns.cursor < 0.3 * width:
        count -= 1
    plot = replace(plot, width=max(plot.width - count * columns.cursor, 1))
    boxes = [replace(box, width=plot.width) for box in boxes]
    return ChartGeometry(
        ratio=ratio,
        columns=columns,
        header=PixelBox(x=0, y=0, width=width, height=header_height),
        lane=PixelBox(x=plot.x, y=header_height, width=plot.width, height=lane_height),
        plot=plot,
        axis=PixelBox(x=0, y=plot.bottom, width=width, height=height - plot.bottom),
        values=PixelBox(
            x=width - columns.values, y=plot.y, width=columns.values, height=plot.height
        ),
        units=PixelBox(
            x=width - px(10) - columns.units,
            y=plot.y,
            width=columns.units + px(10),
            height=plot.height,
        ),
        cursors=tuple(
            PixelBox(
                x=plot.right + number * columns.cursor,
                y=plot.y,
                width=columns.cursor,
                height=plot.height,
            )
            for number in range(count)
        ),
        charts=tuple(boxes),
        numbers=tuple(numbers),
        groups=tuple(
            (name, PixelBox(x=0, y=top, width=columns.gutter, height=bottom - top))
            for name, top, bottom in spans
        ),
        hidden=hidden,
    )


def _stack_charts(
    plot: PixelBox,
    ratio: float,
    groups: Sequence[tuple[str, Sequence[float]]],
    selected: int,
    alone: bool,
) -> tuple[list[PixelBox], list[int], list[tuple[str, int, int]], int]:
    flat = [
        (number_of_group, height)
        for number_of_group, (_, heights) in enumerate(groups)
        for height in heights
    ]
    total = len(flat)
    if not total:
        return [], [], [], 0
    chart_gap = max(round(_CHART_GAP * ratio), 1)
    group_gap = max(round(_GROUP_GAP * ratio), 1)

    def gaps_of(some: range) -> list[int]:
        return [
            0 if index == 0 else chart_gap if flat[number][0] == flat[number - 1][0] else group_gap
            for index, number in enumerate(some)
        ]

    shown = range(selected, selected + 1)
    if not alone:
        for fitting in range(total, 0, -1):
            first = min(max(selected - fitting // 2, 0), total - fitting)
            shown = range(first, first + fitting)
            if fitting * _MIN_CHART_HEIGHT * ratio + sum(gaps_of(shown)) <= plot.height:
                break
    gaps = gaps_of(shown)
    free = max(plot.height - sum(gaps), len(shown))
    heights = _heights(free, [flat[number][1] for number in shown], _MIN_CHART_HEIGHT * ratio)
    boxes: list[PixelBox] = []
    spans: list[tuple[str, int, int]] = []
    used = 0.0
    gap_sum = 0
    for gap, height, number in zip(gaps, heights, shown, strict=True):
        gap_sum += gap
        top = plot.y + gap_sum + round(used)
        used += height
        bottom = plot.y + gap_sum + round(used)
        boxes.append(PixelBox(x=plot.x, y=top, width=plot.width, height=max(bottom - top, 1)))
        name = groups[flat[number][0]][0]
        if spans and gap == chart_gap and flat[number][0] == flat[number - 1][0]:
            spans[-1] = (name, spans[-1][1], bottom)
        else:
            spans.append((name, top, bottom))
    return boxes, list(shown), spans, 0 if alone else total - len(boxes)


def _heights(free: float, weights: Sequence[float], least: float) -> list[float]:
    """Share a height by weight, but give nobody less than `least` while there is enough."""
    low: set[int] = set()
    while True:
        rest = free - least * len(low)
        total = sum(weight for index, weight in enumerate(weights) if index not in low)
        heights = [
            least if index in low else rest * weight / total for index, weight in enumerate(weights)
        ]
        short = {index for index, height in enumerate(heights) if height < least - 1e-9}
        if not short or free < least * len(weights):
            return heights
        low |= short
