"""Painting lowest and highest values into an array of pixels, column by column. No Qt.

The pixels are a ring: column c lies at ``c % width``. A frame paints only the columns that are
new or have changed; what has been painted scrolls by being shown elsewhere. Every column is a
function of the samples around it and of nothing else, so the picture after any number of
frames is, bit for bit, the picture painted at once.

Lines are thickened here, with a round brush and edges smoothed over a sixteenth of a pixel:
wide pens are many times slower in the painter.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gsapp.quantities import FloatArray
from ui.strips.pixel_columns import ColumnScale, SampleSource, column_extremes

Pixels = npt.NDArray[np.uint32]
Color = tuple[int, int, int]

_LEVELS = 16  # parts of a pixel, and shades of an edge
_SHADES = _LEVELS + 1
_NO_TINT, _SPAN, _EVENT = range(3)
_NO_LINE, _TICK, _EDGE, _MARK = range(4)
_LINES = 4
_CLASSES = 3 * _LINES
_CHUNK = 96  # columns painted at once, so that the work fits into the processor's cache


@dataclass(frozen=True, slots=True, kw_only=True)
class TracePaint:
    """One line of a chart: its channel, its color, the columns of a dash (0 = solid)."""

    channel: str
    color: Color
    dash: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class BandPaint:
    """An area between two values (SI): its color, and that of its border."""

    low: float
    high: float
    fill: Color
    border: Color


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartPaint:
    """One chart: rows, range, and what stands behind the lines."""

    # Rows of pixels.
    top: int
    height: int
    # Values (SI) at the bottom and at the top.
    low: float
    high: float
    traces: tuple[TracePaint, ...]  # From the back to the front.
    bands: tuple[BandPaint, ...] = ()  # Limits.
    grid: tuple[float, ...] = ()  # Values (SI) of the grid lines.


@dataclass(frozen=True, slots=True, kw_only=True)
class SpanPaint:
    """An area from time to time (s) across all charts; `stop` may be infinite."""

    start: float
    stop: float
    event: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Backdrop:
    """What stands behind all charts alike."""

    # Between charts; within; grid lines; areas of maneuvers and of other spans; their borders and
    # marks.
    background: Color
    plot: Color
    grid: Color
    span: Color
    event: Color
    edge: Color
    tick: float  # Seconds between grid lines.
    spans: tuple[SpanPaint, ...] = ()  # Areas across all charts.
    marks: tuple[float, ...] = ()  # Times (s) marked by a line.


def create_brush(thickness: float) -> tuple[tuple[int, float], ...]:
    """Return the round brush of a line: pairs of (columns aside, half height in pixels).

    An even width in whole pixels lies half a pixel aside, towards what is older.
    """
    width = max(round(thickness), 1)
    radius = max(thickness, 1.0) / 2.0
    first = -(width // 2) if width % 2 else -(width // 2 - 1)
    center = 0.0 if width % 2 else 0.5
    # A brush of two columns would be too flat without stretching it to the full height.
    full = math.sqrt(radius**2 - center**2) / radius if radius > center else 1.0
    pairs = []
    for aside in range(first, first + width):
        distance = min(abs(aside - center), radius)
        pairs.append((aside, math.sqrt(radius**2 - distance**2) / full))
    return tuple(pairs)


def value_row_transform(chart: ChartPaint, pad: float) -> tuple[float, float]:
    """Return (offset, gain): a value v (SI) lies ``offset - gain * v`` rows below the top."""
    gain = (chart.height - 2.0 * pad) / (chart.high - chart.low)
    return pad + gain * chart.high, gain


class _RowKinds:
    """What a chart's rows look like: a kind for each row, and the shades of each kind."""

    __slots__ = ("kinds", "shades")

    def __init__(
        self, chart: ChartPaint, backdrop: Backdrop, pad: float, line: int, color: Color
    ) -> None:
        offset, gain = value_row_transform(chart, pad)
        rows = np.empty((chart.height, 3))
        rows[:] = backdrop.plot
        plain = np.ones(chart.height, dtype=bool)
        middles = np.arange(chart.height) + 0.5
        for band in chart.bands:
            inside = (middles >= offset - gain * band.high) & (middles < offset - gain * band.low)
            rows[inside] = band.fill
            plain[inside] = False
        for value in chart.grid:
            self._line(rows, offset - gain * value, line, backdrop.grid, plain)
        for band in chart.bands:
            for value in (band.low, band.high):
                if math.isfinite(value):
                    self._line(rows, offset - gain * value, line, band.border, plain)
        # One number for all that makes a row what it is; numpy is slow to compare rows.
        keys = rows @ np.array([65536.0, 256.0, 1.0]) + plain * 16777216.0
        _, example, self.kinds = np.unique(keys, return_index=True, return_inverse=True)
        self.shades = _compute_shades(rows[example], plain[example], backdrop, color)

    @staticmethod
    def _line(
        rows: FloatArray, at: float, width: int, color: Color, plain: npt.NDArray[np.bool_]
    ) -> None:
        first = round(at - width / 2.0)
        begin, end = max(first, 0), min(first + width, len(rows))
        if begin < end:
            rows[begin:end] = color
            plain[begin:end] = False


def _gap_shades(backdrop: Backdrop) -> Pixels:
    """Return the shades of the rows between charts."""
    rows = np.array([backdrop.background], dtype=np.float64)
    return _compute_shades(rows, np.array([True]), backdrop, backdrop.background, lines=False)


def _compute_shades(
    rows: FloatArray,
    plain: npt.NDArray[np.bool_],
    backdrop: Backdrop,
    color: Color,
    *,
    lines: bool = True,
) -> Pixels:
    behind = np.empty((len(rows), _CLASSES, 3))
    behind[:] = rows[:, None, :]
    for tint, tinted in ((_SPAN, backdrop.span), (_EVENT, backdrop.event)):
        chosen = slice(tint * _LINES, (tint + 1) * _LINES)
        # A limit stays visible below a maneuver.
        behind[plain, chosen] = tinted
        behind[~plain, chosen] += 0.35 * (np.array(tinted) - behind[~plain, chosen])
    for tint in range(3):
        if lines:
            behind[plain, tint * _LINES + _TICK] = backdrop.grid
        behind[:, tint * _LINES + _EDGE] = backdrop.edge
        behind[:, tint * _LINES + _MARK] = backdrop.edge
    share = (np.arange(_SHADES) / _LEVELS)[:, None]
    mixed = behind[:, :, None, :] + (np.array(color) - behind[:, :, None, :]) * share
    parts = np.rint(mixed).astype(np.uint32)
    red, green, blue = parts[..., 0], parts[..., 1], parts[..., 2]
    packed: Pixels = np.uint32(0xFF000000) | (red << np.uint32(16)) | (green << np.uint32(8)) | blue
    return packed


class Raster:
    """The pixels of all charts.

    Parameters
    ----------
    charts : sequence of ChartPaint
        Charts from top to bottom, which do not overlap.
    thickness : float
        Of the lines, in pixels.
    line : int
        Of grid lines and borders, in pixels.

    Attributes
    ----------
    low, high : ndarray, shape (n_traces, width + 2 margin)
        Values (SI) of the columns loaded, a ring as well; all first traces, chart by chart,
        then all second ones, ...
    """

    def __init__(
        self,
        width: int,
        height: int,
        charts: Sequence[ChartPaint],
        backdrop: Backdrop,
        *,
        thickness: float = 2.0,
        line: int = 1,
    ) -> None:
        self.width = max(int(width), 1)
        self.height = max(int(height), 1)
        self.charts = list(charts)
        self.backdrop = backdrop
        self.line = line
        self._brush = create_brush(thickness)
        self._pad = thickness / 2.0 + 1.0
        self.reach = max(abs(aside) for aside, _ in self._brush)
        # 0xffRRGGBB; column c lies at ``c % width``.
        self.pixels: Pixels = np.zeros((self.height, self.width), dtype=np.uint32)
        self._layers = self._number_traces()
        pairs = [(chart, layer) for layer, them in enumerate(self._layers) for chart in them]
        self._numbers = {pair: row for row, pair in enumerate(pairs)}
        count = len(pairs)
        # Columns on either side of those in sight of which the values matter.
        self.margin = self.reach + 1
        self._loaded = self.width + 2 * self.margin
        self._values = np.full((2, count, self._loaded), np.nan)
        self.high, self.low = self._values
        sizes = np.cumsum([0, *(len(members) for members in self._layers)]).tolist()
        self._layer_rows = [slice(one, other) for one, other in itertools.pairwise(sizes)]
        self._rows_of_channel: dict[str, list[int]] = {}
        for (number, layer), row in self._numbers.items():
            name = self.charts[number].traces[layer].channel
            self._rows_of_channel.setdefault(name, []).append(row)
        self._row_chart = np.full(self.height, len(self.charts), dtype=np.intp)
        self._row_local = np.zeros((self.height, 1), dtype=np.int32)
        for number, chart in enumerate(self.charts):
            rows = slice(chart.top, chart.top + chart.height)
            self._row_chart[rows] = number
            self._row_local[rows, 0] = np.arange(chart.height) * _LEVELS
        tallest = max((chart.height for chart in self.charts), default=1)
        # Half the bytes, half the time; but the sixteenths of a tall chart do not fit.
        self._integer = np.int16 if (tallest + 2) * _LEVELS < 32000 else np.int32
        self._row_local = self._row_local.astype(self._integer)
        self._rows: list[_RowKinds] = [self._make_rows(chart) for chart in self.charts]
        self._placed = np.array(
            [(*value_row_transform(chart, self._pad), chart.height) for chart in self.charts]
        ).reshape(-1, 3)
        self._gather_shades()

    # Set-up

    @property
    def pad(self) -> float:
        """Return the rows that a chart leaves free above its highest value and below."""
        return self._pad

    def trace_number(self, chart: int, trace: int) -> int:
        """Return the row of `low` and `high` in which a trace is kept."""
        return self._numbers[chart, trace]

    def set_chart(self, number: int, chart: ChartPaint) -> None:
        """Change the range, bands, grid or colors of a chart; it then needs to be painted."""
        self.charts[number] = chart
        self._rows[number] = self._make_rows(chart)
        self._placed[number] = (*value_row_transform(chart, self._pad), chart.height)
        self._gather_shades()

    def _number_traces(self) -> list[list[int]]:
        most = max((len(chart.traces) for chart in self.charts), default=0)
        return [
            [index for index, chart in enumerate(self.charts) if len(chart.traces) > layer]
            for layer in range(most)
        ]

    def _make_rows(self, chart: ChartPaint) -> _RowKinds:
        color = chart.traces[0].color if chart.traces else self.backdrop.plot
        return _RowKinds(chart, self.backdrop, self._pad, self.line, color)

    def _gather_shades(self) -> None:
        pieces = [rows.shades.reshape(-1) for rows in self._rows]
        pieces.append(_gap_shades(self.backdrop).reshape(-1))
        self._shades = np.concatenate(pieces)
        starts = np.cumsum([0, *(piece.size for piece in pieces)])
        base = np.full((self.height, 1), starts[-2], dtype=np.int32)
        for chart, rows, start in zip(self.charts, self._rows, starts, strict=False):
            base[chart.top : chart.top + chart.height, 0] = start + rows.kinds * (
                _CLASSES * _SHADES
            )
        self._row_base = base

    # Values

    def load(
        self,
        history: SampleSource,
        scale: ColumnScale,
        first: int,
        last: int,
        channels: Sequence[str] | None = None,
    ) -> None:
        """Take the values of the columns ``first <= c < last`` of all channels, or of some.

        A column needs the values of `margin` columns on either side of it, too.
        """
        if last <= first:
            return
        parts = split_ring(first, last, self._loaded)
        known = set(history.channels)
        for channel_id in self._rows_of_channel if channels is None else channels:
            if channel_id not in known:
                continue
            low, high = column_extremes(history, channel_id, scale, first, last)
            for row in self._rows_of_channel[channel_id]:
                for ring, part in parts:
                    self.low[row, ring] = low[part]
                    self.high[row, ring] = high[part]

    def extend(
        self,
        history: SampleSource,
        scale: ColumnScale,
        first: int,
        last: int,
        channels: Sequence[str],
    ) -> None:
        """Take the samples ``first <= k < last``, which came after all that is loaded.

        Where a column holds many samples, a frame looks at the new ones only, and at those of
        all channels together.

        Parameters
        ----------
        scale : ColumnScale
            How columns lie on the samples; a sample must not be wider than a column.
        first, last : int
            Absolute indices. The columns in which they lie must be loaded.
        """
        rows = [self._rows_of_channel[name] for name in channels]
        samples = np.empty((sum(map(len, rows)), last - first))
        place = 0
        for name, some in zip(channels, rows, strict=True):
            samples[place : place + len(some)] = history.samples(name, first, last)
            place += len(some)
        begin, end = scale.column_of(first), scale.column_of(last - 1)
        cuts = scale.first_samples(begin, end + 1) - first
        cuts[0] = 0
        # Columns across, so that the reduction runs along memory.
        across = np.ascontiguousarray(samples.T)
        where = (
            np.array(list(itertools.chain.from_iterable(rows)), dtype=np.intp)[:, None],
            np.arange(begin, end + 1) % self._loaded,
        )
        self.low[where] = np.fmin(self.low[where], np.fmin.reduceat(across, cuts).T)
        self.high[where] = np.fmax(self.high[where], np.fmax.reduceat(across, cuts).T)

    def clear(self, first: int, last: int) -> None:
        """Note that nothing has been measured yet in these columns."""
        if last > first:
            for ring, _ in split_ring(first, last, self._loaded):
                self._values[:, :, ring] = np.nan

    # Painting

    def paint(
        self, scale: ColumnScale, first: int, last: int, charts: Sequence[int] | None = None
    ) -> None:
        """Paint the columns ``first <= c < last`` of all charts, or of some, as loaded.

        Parameters
        ----------
        first, last : int
            Not more than `width` columns.
        charts : sequence of int or None
            Numbers of charts; None also paints what lies between the charts.
        """
        if last <= first:
            return
        classes = self.column_classes(scale, first, last) * np.int32(_SHADES)
        rows = self._rows_of(charts)
        for layer, members in enumerate(self._layers):
            there = members if charts is None else [one for one in members if one in charts]
            if layer == 0 or there:
                top, bottom = self._edges(first, last, layer, there)
                if layer == 0:
                    self._paint_first(first, there, top, bottom, classes, rows)
                else:
                    self._paint_over(first, layer, there, top, bottom)
        if not self._layers:
            nothing = np.zeros((1, last - first), dtype=self._integer)
            self._paint_first(first, [], nothing, nothing, classes, rows)

    def _rows_of(self, charts: Sequence[int] | None) -> npt.NDArray[np.intp] | None:
        if charts is None:
            return None
        pieces = [
            np.arange(self.charts[n].top, self.charts[n].top + self.charts[n].height)
            for n in charts
        ]
        return np.concatenate(pieces) if pieces else np.empty(0, dtype=np.intp)

    def _edges(
        self, first: int, last: int, layer: int, charts: Sequence[int]
    ) -> tuple[npt.NDArray[np.signedinteger], npt.NDArray[np.signedinteger]]:
        """Return where lines begin and end in each column, in sixteenths of a row.

        One row for each chart, then one that is empty, for the rows between charts.
        """
        margin = self.margin
        rows: slice | npt.NDArray[np.intp] = self._layer_rows[layer]
        placed = self._placed
        if len(charts) < len(self._layers[layer]):
            rows = np.array([self._numbers[number, layer] for number in charts], dtype=np.intp)
        if len(charts) < len(self.charts):
            placed = placed[np.array(charts, dtype=np.intp)]
        offset, gain, heights = placed[:, :1], placed[:, 1:2], placed[:, 2:]
        edges = offset - gain * self._around(rows, first - margin, last + margin)
        # What lies off the scale stays at the edge, where half of its width can be seen.
        np.maximum(edges, 0.0, out=edges)
        np.minimum(edges, heights, out=edges)
        # The lower edge with its sign turned: then both want the least of their neighbors.
        np.negative(edges[1], out=edges[1])
        there = ~np.isnan(edges[0])
        edges = self._thicken(_connect_columns(edges, there), there)[:, :, margin:-margin]
        np.negative(edges[1], out=edges[1])
        np.maximum(edges, -1.0, out=edges)
        np.minimum(edges, heights + 1.0, out=edges)
        edges *= _LEVELS
        np.rint(edges, out=edges)
        drawn = there[:, margin:-margin]
        for row, number in enumerate(charts):
            dash = self.charts[number].traces[layer].dash
            if dash:
                drawn[row] &= (np.arange(first, last) // dash) % 3 != 2
        whole = np.zeros((2, len(charts) + 1, last - first), dtype=self._integer)
        np.copyto(whole[:, :-1], edges, where=drawn, casting="unsafe")
        return whole[0], whole[1]

    def _around(self, rows: slice | npt.NDArray[np.intp], first: int, last: int) -> FloatArray:
        begin = first % self._loaded
        end = begin + last - first
        if end <= self._loaded:
            return self._values[:, rows, begin:end]
        return self._values[:, rows].take(np.arange(begin, end) % self._loaded, axis=2)

    def _thicken(self, edges: FloatArray, there: npt.NDArray[np.bool_]) -> FloatArray:
        """Widen lines by the brush. Nothing reaches into a gap, nor across one."""
        heights = dict(self._brush)
        thick = edges - heights[0]
        for direction in (1, -1):
            chain = there
            distance = 1
            while (half := heights.get(direction * distance)) is not None:
                near, far = slice(None, -distance), slice(distance, None)
                here, beyond = (near, far) if direction > 0 else (far, near)
                # Unbroken from here to there: so far, and the next one, too.
                chain = (chain[:, :-1] if direction > 0 else chain[:, 1:]) & there[:, beyond]
                reached = edges[:, :, beyond] - half
                target = thick[:, :, here]
                np.fmin(target, reached, out=target, where=chain)
                distance += 1
        return thick

    def _paint_first(
        self,
        first: int,
        charts: Sequence[int],
        top: npt.NDArray[np.signedinteger],
        bottom: npt.NDArray[np.signedinteger],
        classes: npt.NDArray[np.int32],
        rows: npt.NDArray[np.intp] | None,
    ) -> None:
        everything: slice | npt.NDArray[np.intp] = slice(None) if rows is None else rows
        source = self._row_chart[everything]
        local, base = self._row_local[everything], self._row_base[everything]
        if len(charts) < len(self.charts):
            places = np.full(len(self.charts) + 1, len(charts), dtype=np.intp)
            places[list(charts)] = np.arange(len(charts))
            source = places[source]
        for ring, part in split_ring(first, first + top.shape[1], self.width):
            for begin in range(part.start, part.stop, _CHUNK):
                end = min(begin + _CHUNK, part.stop)
                index = base + classes[begin:end]
                index += _pixel_coverage(top[:, begin:end], bottom[:, begin:end], source, local)
                shift = ring.start - part.start
                self.pixels[everything, begin + shift : end + shift] = self._shades.take(index)

    def _paint_over(
        self,
        first: int,
        layer: int,
        charts: Sequence[int],
        top: npt.NDArray[np.signedinteger],
        bottom: npt.NDArray[np.signedinteger],
    ) -> None:
        for row, number in enumerate(charts):
            chart = self.charts[number]
            source = np.full(chart.height, row, dtype=np.intp)
            local = self._row_local[chart.top : chart.top + chart.height]
            color = np.array(chart.traces[layer].color, dtype=np.int32)
            for ring, part in split_ring(first, first + top.shape[1], self.width):
                covered = _pixel_coverage(top[:, part], bottom[:, part], source, local)
                block = self.pixels[chart.top : chart.top + chart.height, ring]
                touched = covered > 0
                share = covered[touched].astype(np.int32)
                old = block[touched]
                new = np.full(old.shape, 0xFF000000, dtype=np.uint32)
                for shift, target in zip((16, 8, 0), color, strict=True):
                    part_old = ((old >> np.uint32(shift)) & np.uint32(0xFF)).astype(np.int32)
                    mixed = part_old + ((target - part_old) * share + _LEVELS // 2) // _LEVELS
                    new |= mixed.astype(np.uint32) << np.uint32(shift)
                block[touched] = new

    def column_classes(self, scale: ColumnScale, first: int, last: int) -> npt.NDArray[np.int32]:
        """Return what stands behind each column: area and line, as one number."""
        tint = np.zeros(last - first, dtype=np.int32)
        line = np.zeros(last - first, dtype=np.int32)
        step = self.backdrop.tick
        if step > 0.0:
            begin = math.floor(scale.time(first - self.line) / step)
            end = math.ceil(scale.time(last) / step)
            for number in range(begin, end + 1):
                self._draw_line(line, scale.column(number * step) - first, _TICK)
        for span in self.backdrop.spans:
            begin = scale.column(span.start) - first
            open_ended = math.isinf(span.stop)
            end = last - first if open_ended else scale.column(span.stop) - first
            tint[max(begin, 0) : max(end + 1, 0)] = _EVENT if span.event else _SPAN
            self._draw_line(line, begin, _EDGE)
            if not open_ended:
                self._draw_line(line, end, _EDGE)
        for time in self.backdrop.marks:
            self._draw_line(line, scale.column(time) - first, _MARK)
        return tint * np.int32(_LINES) + line

    def _draw_line(self, line: npt.NDArray[np.int32], at: int, kind: int) -> None:
        begin, end = max(at, 0), max(at + self.line, 0)
        line[begin:end] = kind


def split_ring(first: int, last: int, size: int) -> list[tuple[slice, slice]]:
    """Return pairs of (places in a ring, places in the row of columns)."""
    begin = first % size
    count = last - first
    head = min(count, size - begin)
    pieces = [(slice(begin, begin + head), slice(0, head))]
    if head < count:
        pieces.append((slice(0, count - head), slice(head, count)))
    return pieces


def _connect_columns(edges: FloatArray, there: npt.NDArray[np.bool_]) -> FloatArray:
    """Let every column reach back to the one before it, so that a line is one line."""
    joined = edges.copy()
    # An upper edge reaches to the lower one before it, and the other way round.
    reached = -edges[::-1, :, :-1]
    target = joined[:, :, 1:]
    np.fmin(target, reached, out=target, where=there[:, 1:])
    return joined


def _pixel_coverage(
    top: npt.NDArray[np.signedinteger],
    bottom: npt.NDArray[np.signedinteger],
    source: npt.NDArray[np.intp],
    local: npt.NDArray[np.signedinteger],
) -> npt.NDArray[np.signedinteger]:
    before = top.take(source, axis=0)
    before -= local
    np.maximum(before, 0, out=before)
    np.minimum(before, _LEVELS, out=before)
    covered = bottom.take(source, axis=0)
    covered -= local
    np.maximum(covered, 0, out=covered)
    np.minimum(covered, _LEVELS, out=covered)
    covered -= before
    return covered
