"""What is painted of the charts, kept up with the history frame by frame. No Qt."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ui.strips.chart_annotations import ChartMark, ChartSpan
from ui.strips.chart_geometry import ChartGeometry
from ui.strips.chart_state import (
    ChartState,
    create_chart_paint,
    line_width,
    parse_rgb,
    update_ticks,
)
from ui.strips.pixel_columns import SampleSource
from ui.strips.raster import Backdrop, ChartPaint, Raster, SpanPaint
from ui.strips.strip_view import StripView
from ui.theme import Theme

_MAX_INCREMENT = 4096  # new samples that are looked at one by one; more of them as columns


@dataclass(frozen=True, slots=True)
class FrameChanges:
    """What a frame changed."""

    # Whether another stretch of time is in sight, so that every pixel is elsewhere.
    scrolled: bool = False
    # Columns painted, ``first <= c < last``; none if equal.
    first: int = 0
    last: int = 0


@dataclass(frozen=True, slots=True)
class NewSamples:
    """Samples that arrived since the last frame, of channels that are in step."""

    # Their absolute indices, first and one past the last; None if not all that came before is known
    # to be loaded.
    samples: tuple[int, int] | None
    # Columns in which they lie, or begin to be seen; ``first <= c < last``.
    first: int
    last: int
    channels: tuple[str, ...]  # Of which channels.
    charts: list[int]  # The charts that show these, by place.


class ChartRaster:
    """The raster of the charts in sight, and how far it has followed the history.

    `tick`: seconds between grid lines.
    """

    def __init__(
        self,
        charts: Mapping[int, ChartState],
        geometry: ChartGeometry,
        theme: Theme,
        tick: float,
        spans: Sequence[ChartSpan] = (),
        marks: Sequence[ChartMark] = (),
    ) -> None:
        self._charts = [charts[number] for number in geometry.numbers]
        self._geometry = geometry
        self._theme = theme
        self._places: dict[str, list[int]] = {}
        for place, chart in enumerate(self._charts):
            for name in dict.fromkeys(spec.id for spec in chart.specs):
                self._places.setdefault(name, []).append(place)
        self._painted: tuple[int, int] | None = None
        self._end: float | None = None  # of the history, at the last frame
        self._seen: dict[str, float] = {}
        self._revision: int | None = None
        width = line_width(theme, geometry.ratio)
        self._free = width / 2.0 + 1.0
        for chart, box in zip(self._charts, geometry.charts, strict=True):
            update_ticks(chart, box, self._free, geometry.ratio)
        self.raster = Raster(
            geometry.plot.width,
            geometry.plot.height,
            [self._paint_of(place) for place in range(len(self._charts))],
            create_backdrop(theme, tick, spans, marks),
            thickness=width,
            line=max(round(geometry.ratio), 1),
        )

    @property
    def free_rows(self) -> float:
        """Return the rows that charts leave free at either end."""
        return self._free

    def _paint_of(self, place: int) -> ChartPaint:
        box, geometry = self._geometry.charts[place], self._geometry
        return create_chart_paint(
            self._charts[place], box.y - geometry.plot.y, box.height, self._theme, geometry.ratio
        )

    def advance(self, history: SampleSource, view: StripView) -> FrameChanges:
        if history.revision != self._revision:
            self._revision = history.revision
            self._painted = None
            self._seen.clear()
        first, last = view.columns
        before = self._painted
        arrived = self._arrived(history, view)
        self._painted = (first, last)
        if before is None or first >= before[1] or last <= before[0]:
            before = None
        self._load(history, view, before, arrived)
        self._end = history.end
        if before is None:
            self.raster.paint(view.scale, first, last)
            return FrameChanges(scrolled=True, first=first, last=last)
        self.raster.paint(view.scale, first, min(before[0], last))
        oldest = self._paint_arrived(view, max(min(before[1], last), first), arrived)
        if before != (first, last):
            return FrameChanges(scrolled=True, first=first, last=last)
        return FrameChanges(first=oldest, last=last)

    def _load(
        self,
        history: SampleSource,
        view: StripView,
        before: tuple[int, int] | None,
        arrived: Sequence[NewSamples],
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
        if self._end is not None and max(known_last, first) <= scale.column(self._end):
            # Else these columns hold only what has just arrived, which is taken below.
            raster.load(history, scale, max(known_last, first), stop)
        for some in arrived:
            within = first <= some.first and some.last <= last
            if within and some.samples is not None and scale.holds_samples:
                raster.extend(history, scale, *some.samples, some.channels)
            else:
                begin, stop = max(some.first, first), min(some.last, last)
                raster.load(history, scale, begin, stop, some.channels)

    def _paint_arrived(self, view: StripView, new: int, arrived: Sequence[NewSamples]) -> int:
        """Paint columns from `new` on, and those before in which samples arrived.

        Returns the oldest column painted.
        """
        first, last = view.columns
        reach = self.raster.reach
        stretches = [
            (max(some.first - reach, first), min(some.last + reach, last), some.charts)
            for some in arrived
        ]
        # Most channels arrive together: one stroke for all, from the oldest of them on.
        for begin, end, charts in stretches:
            if 2 * len(charts) > len(self._charts) and end >= new:
                new = min(new, begin)
        for begin, end, charts in stretches:
            self.raster.paint(view.scale, begin, min(end, new), charts)
        self.raster.paint(view.scale, new, last)
        return min([new, *(begin for begin, end, _ in stretches if begin < end)])

    def _arrived(self, history: SampleSource, view: StripView) -> list[NewSamples]:
        seen, last = self._seen, history.last
        known = set(history.channels)
        # Most channels are in step: what arrived is told by few pairs of times.
        together: dict[tuple[float | None, float], list[str]] = {}
        for name in self._places:
            latest = last(name) if name in known else None
            if latest is None:
                continue
            before, time = seen.get(name), latest[0]
            if time != before:
                seen[name] = time
                together.setdefault((before, time), []).append(name)
        return [self._arrival(view, *times, names) for times, names in together.items()]

    def _arrival(
        self, view: StripView, before: float | None, time: float, names: Sequence[str]
    ) -> NewSamples:
        scale = view.scale
        places = dict.fromkeys(place for name in names for place in self._places[name])
        samples = None
        # Before the first sample seen, anything may have come with it.
        first = view.columns[0] - self.raster.margin
        if before is not None:
            first = scale.column(before)
            samples = (round(before * scale.rate) + 1, round(time * scale.rate) + 1)
            if samples[1] - samples[0] > _MAX_INCREMENT:
                samples = None
        return NewSamples(samples, first, scale.column(time) + 1, tuple(names), list(places))

    def update_auto_ranges(self, view: StripView, *, at_once: bool) -> bool:
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
            shown = chart.displays[0].to_display
            low, high = float(np.fmin.reduce(lows[rows])), float(np.fmax.reduce(highs[rows]))
            if chart.auto_range.update(shown(low), shown(high), view.now or 0.0, at_once=at_once):
                chart.low, chart.high = chart.auto_range.low, chart.auto_range.high
                update_ticks(chart, self._geometry.charts[place], self._free, self._geometry.ratio)
                raster.set_chart(place, self._paint_of(place))
                changed.append(place)
        if changed:
            first, last = view.columns
            raster.paint(view.scale, first, last, changed)
        return bool(changed)


def create_backdrop(
    theme: Theme, tick: float, spans: Sequence[ChartSpan], marks: Sequence[ChartMark]
) -> Backdrop:
    """Return what stands behind all charts."""
    return Backdrop(
        background=parse_rgb(theme.background),
        plot=parse_rgb(theme.plot),
        grid=parse_rgb(theme.grid),
        span=parse_rgb(theme.span),
        event=parse_rgb(theme.event),
        edge=parse_rgb(theme.span_edge),
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
