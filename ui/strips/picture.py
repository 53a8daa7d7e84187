"""What is painted of the charts, kept up with the history frame by frame. No Qt."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ui.strips.charts import Chart, chart_paint, rgb, set_ticks, thickness
from ui.strips.columns import Samples
from ui.strips.furniture import Mark, Span
from ui.strips.geometry import Geometry
from ui.strips.raster import Backdrop, ChartPaint, Raster, SpanPaint
from ui.strips.view import StripView
from ui.theme import Theme


@dataclass(frozen=True, slots=True)
class Changes:
    """What a frame changed.

    Attributes
    ----------
    moved : bool
        Whether another stretch of time is in sight, so that every pixel is elsewhere.
    first, last : int
        Columns painted, ``first <= c < last``; none if equal.
    """

    moved: bool = False
    first: int = 0
    last: int = 0


class Picture:
    """The raster of the charts in sight, and how far it has followed the history.

    Parameters
    ----------
    charts : mapping of int to Chart
        All charts by number.
    geometry : Geometry
        Where those in sight stand.
    theme : Theme
        Colors and line weight.
    tick : float
        Seconds between grid lines.
    spans, marks : sequence
        What stands across all charts.

    Attributes
    ----------
    raster : Raster
        The pixels.
    """

    def __init__(
        self,
        charts: Mapping[int, Chart],
        geometry: Geometry,
        theme: Theme,
        tick: float,
        spans: Sequence[Span] = (),
        marks: Sequence[Mark] = (),
    ) -> None:
        self._charts = [charts[number] for number in geometry.numbers]
        self._geometry = geometry
        self._theme = theme
        self._painted: tuple[int, int] | None = None
        self._seen: dict[str, float] = {}
        self._revision: int | None = None
        width = thickness(theme, geometry.ratio)
        self._free = width / 2.0 + 1.0
        for chart, box in zip(self._charts, geometry.charts, strict=True):
            set_ticks(chart, box, self._free, geometry.ratio)
        self.raster = Raster(
            geometry.plot.width,
            geometry.plot.height,
            [self._paint_of(place) for place in range(len(self._charts))],
            backdrop(theme, tick, spans, marks),
            thickness=width,
            line=max(round(geometry.ratio), 1),
        )

    @property
    def free(self) -> float:
        """Return the rows that charts leave free at either end."""
        return self._free

    def _paint_of(self, place: int) -> ChartPaint:
        box, geometry = self._geometry.charts[place], self._geometry
        return chart_paint(
            self._charts[place], box.y - geometry.plot.y, box.height, self._theme, geometry.ratio
        )

    def advance(self, history: Samples, view: StripView) -> Changes:
        """Paint what came into sight and what arrived since the last call."""
        if history.revision != self._revision:
            self._revision = history.revision
            self._painted = None
            self._seen.clear()
        first, last = view.columns
        before = self._painted
        changed = self._arrived(history, view)
        self._painted = (first, last)
        if before is None or first >= before[1] or last <= before[0]:
            before = None
        self._load(history, view, before, changed)
        if before is None:
            self.raster.paint(view.scale, first, last)
            return Changes(moved=True, first=first, last=last)
        self.raster.paint(view.scale, first, min(before[0], last))
        oldest = self._paint_arrived(view, max(min(before[1], last), first), changed)
        if before != (first, last):
            return Changes(moved=True, first=first, last=last)
        return Changes(first=oldest, last=last)

    def _load(
        self,
        history: Samples,
        view: StripView,
        before: tuple[int, int] | None,
        changed: Mapping[tuple[int, int], Sequence[int]],
    ) -> None:
        """Take the values of columns that came into reach, and of those that changed."""
        raster, scale, margin = self.raster, view.scale, self.raster.margin
        first, last = view.columns[0] - margin, view.columns[1] + margin
        end = history.end
        # Nothing lies beyond the newest sample, so nobody needs to look.
        stop = last if end is None else min(last, scale.column(end) + 1)
        if before is None:
            raster.clear(first, last)
            raster.load(history, scale, first, stop)
            return
        known_first, known_last = before[0] - margin, before[1] + margin
        raster.load(history, scale, first, min(known_first, stop))
        raster.clear(max(known_last, first), last)
        raster.load(history, scale, max(known_last, first), stop)
        for (begin, stretch_end), charts in changed.items():
            raster.load(history, scale, max(begin, first), min(stretch_end, last), charts)

    def _paint_arrived(
        self,
        view: StripView,
        new: int,
        changed: Mapping[tuple[int, int], Sequence[int]],
    ) -> int:
        """Paint columns from `new` on, and those before in which samples arrived.

        Returns the oldest column painted.
        """
        first, last = view.columns
        reach = self.raster.reach
        stretches = [
            (max(begin - reach, first), min(end + reach, last), charts)
            for (begin, end), charts in changed.items()
        ]
        # Most channels arrive together: one stroke for all, from the oldest of them on.
        for begin, end, charts in stretches:
            if 2 * len(charts) > len(self._charts) and end >= new:
                new = min(new, begin)
        for begin, end, charts in stretches:
            self.raster.paint(view.scale, begin, min(end, new), charts)
        self.raster.paint(view.scale, new, last)
        return min([new, *(begin for begin, end, _ in stretches if begin < end)])

    def _arrived(self, history: Samples, view: StripView) -> dict[tuple[int, int], list[int]]:
        """Return the columns in which samples arrived since the last call, with their charts."""
        known = history.channels
        stretches: dict[str, tuple[int, int] | None] = {}
        # Most channels are in step; their columns need to be found only once.
        same: dict[tuple[float | None, float], tuple[int, int]] = {}
        found: dict[tuple[int, int], list[int]] = {}
        for place, chart in enumerate(self._charts):
            begin, end = math.inf, -math.inf
            for spec in chart.specs:
                name = spec.id
                if name not in stretches:
                    latest = history.last(name) if name in known else None
                    stretches[name] = self._new_stretch(name, latest, view, same)
                stretch = stretches[name]
                if stretch is not None:
                    begin, end = min(begin, stretch[0]), max(end, stretch[1])
            if begin < end:
                found.setdefault((int(begin), int(end)), []).append(place)
        return found

    def _new_stretch(
        self,
        channel_id: str,
        latest: tuple[float, float] | None,
        view: StripView,
        same: dict[tuple[float | None, float], tuple[int, int]],
    ) -> tuple[int, int] | None:
        if latest is None:
            return None
        key = (self._seen.get(channel_id), latest[0])
        seen, arrived = key
        if seen == arrived:
            return None
        self._seen[channel_id] = arrived
        if key not in same:
            # Before the first sample seen, anything may have come with it.
            unseen = view.columns[0] - self.raster.margin
            begin = view.scale.column(seen) if seen is not None else unseen
            same[key] = (begin, view.scale.column(arrived) + 1)
        return same[key]

    def follow_ranges(self, view: StripView, *, at_once: bool) -> bool:
        """Let automatic y axes follow what is in sight; return whether one changed."""
        raster = self.raster
        if not raster.low.size:
            return False
        lows = np.fmin.reduce(raster.low, axis=1)
        highs = np.fmax.reduce(raster.high, axis=1)
        changed = []
        for place, chart in enumerate(self._charts):
            if chart.strip.range != "auto":
                continue
            rows = [raster.trace_number(place, index) for index in range(len(chart.specs))]
            shown = chart.displays[0].shown
            low, high = float(np.fmin.reduce(lows[rows])), float(np.fmax.reduce(highs[rows]))
            if chart.steady.update(shown(low), shown(high), view.now or 0.0, at_once=at_once):
                chart.low, chart.high = chart.steady.low, chart.steady.high
                set_ticks(chart, self._geometry.charts[place], self._free, self._geometry.ratio)
                raster.set_chart(place, self._paint_of(place))
                changed.append(place)
        if changed:
            first, last = view.columns
            raster.paint(view.scale, first, last, changed)
        return bool(changed)


def backdrop(theme: Theme, tick: float, spans: Sequence[Span], marks: Sequence[Mark]) -> Backdrop:
    """Return what stands behind all charts."""
    return Backdrop(
        background=rgb(theme.background),
        plot=rgb(theme.plot),
        grid=rgb(theme.grid),
        span=rgb(theme.span),
        event=rgb(theme.event),
        edge=rgb(theme.span_edge),
        tick=tick,
        spans=tuple(
            SpanPaint(
                start=span.start,
                stop=math.inf if span.stop is None else span.stop,
                event=span.kind == "event",
            )
            for span in spans
        ),
        marks=tuple(mark.time for mark in marks),
    )
