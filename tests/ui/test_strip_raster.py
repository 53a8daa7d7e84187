"""Pixels: lines where they belong, gaps left empty, and every frame equal to a full one."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.quantities import Block
from gsapp.session.limits import LimitBands
from gsapp.session.sample_history import SampleHistory
from ui.strips.chart_annotations import ChartMark, ChartSpan
from ui.strips.chart_geometry import ColumnWidths, compute_geometry
from ui.strips.chart_raster import ChartRaster
from ui.strips.chart_state import create_chart, parse_rgb
from ui.strips.raster import create_brush
from ui.strips.strip_layout import Strip, Trace
from ui.strips.strip_view import StripView
from ui.theme import DAYLIGHT

RATE = 100.0
COLUMNS = ColumnWidths(gutter=0, names=0, ticks=0, values=0, units=0, cursor=0)


def fixed(*channels, **options):
    traces = tuple(Trace(channel=name, **options) for name in channels)
    return Strip(traces=traces, range="fixed", low=-1.0, high=1.0)


STRIPS = (
    fixed("alpha"),
    fixed("beta", style="computed"),
    Strip(
        traces=(
            Trace(channel="q"),
            Trace(channel="r", style="computed"),
            Trace(channel="p", style="previous"),
        ),
        range="fixed",
        low=-1.0,
        high=1.0,
        height=1.5,
    ),
)
CHANNELS = ("alpha", "beta", "q", "r", "p")
SPANS = (
    ChartSpan(label="one", start=3.0, stop=5.0),
    ChartSpan(label="two", start=8.0, kind="event"),
)
MARKS = (ChartMark(label="here", time=6.5),)


def picture_of(view, strips=STRIPS, height=120, ratio=1.0, limits=None, **across):
    """Return a picture of charts one above the other, as wide as the view."""
    charts = {
        index: create_chart(strip, DAYLIGHT, "SI", limits) for index, strip in enumerate(strips)
    }
    geometry = compute_geometry(
        view.width,
        height + round(46 * ratio) + round(26 * ratio),
        ratio,
        COLUMNS,
        [("", [strip.height for strip in strips])],
        0,
        0,
        False,
    )
    assert geometry.plot.width == view.width
    return ChartRaster(charts, geometry, DAYLIGHT, 1.0, **across), geometry


def seen(picture, view):
    seam = view.columns[0] % picture.raster.width
    return np.concatenate(
        (picture.raster.pixels[:, seam:], picture.raster.pixels[:, :seam]), axis=1
    )


def color(text):
    red, green, blue = parse_rgb(text)
    return 0xFF000000 | red << 16 | green << 8 | blue


def history_of(values, channels=("alpha",), rate=RATE, first=0):
    history = SampleHistory(channels, rate)
    values = np.asarray(values, dtype=float)
    if values.ndim == 1:
        values = np.repeat(values[:, None], len(channels), axis=1)
    times = (first + np.arange(len(values))) / rate
    history.append(Block(channels=channels, times=times, values=values))
    return history


def view_of(history, width=300, window=3.0):
    view = StripView(width=width, rate=history.rate, window=window)
    view.start, view.now = 0.0, history.end
    return view


def rows_of_line(pixels, box, plot, x):
    line = color(DAYLIGHT.trace("blue"))
    column = pixels[box.y - plot.y : box.bottom - plot.y, x]
    return np.flatnonzero(column == line)


@pytest.mark.parametrize("window", [1.0, 3.0, 30.0])
def test_a_step_appears_in_its_own_column(window):
    values = np.where(np.arange(4000) < 3950, -0.8, 0.8)
    history = history_of(values)
    view = view_of(history, width=300, window=window)
    picture, geometry = picture_of(view, (fixed("alpha"),), height=60)
    picture.advance(history, view)
    pixels, box = seen(picture, view), geometry.charts[0]
    filled = [len(rows_of_line(pixels, box, geometry.plot, x)) for x in range(view.width)]
    step = view.x(39.5)
    if view.scale.stretch == 1:
        tall = np.flatnonzero(np.array(filled) > 40)
        # The brush of a line two pixels wide covers the column and the one before.
        assert tall.tolist() == [step - 1, step]
        assert max(filled) == filled[step]
    else:
        # Samples are several columns apart: the slope ends where the new value begins.
        middles = [rows_of_line(pixels, box, geometry.plot, x).mean() for x in (step - 9, step + 4)]
        assert middles[0] > 50
        assert middles[1] < 10


def test_all_charts_share_their_columns_exactly():
    values = np.zeros(2000)
    values[1850] = 0.9
    history = history_of(values, CHANNELS)
    strips = tuple(fixed(name) for name in CHANNELS)
    for window in (3.0, 20.0):
        view = view_of(history, width=250, window=window)
        picture, geometry = picture_of(view, strips, height=200)
        picture.advance(history, view)
        pixels = seen(picture, view)
        at = []
        for box in geometry.charts:
            high = pixels[box.y - geometry.plot.y + 4]
            lines = [color(trace) for trace in DAYLIGHT.traces.values()]
            at.append(tuple(np.flatnonzero(np.isin(high, lines)).tolist()))
        assert len(set(at)) == 1
        assert view.x(18.5) in at[0]


def test_a_value_lies_at_its_row():
    for value in (-1.0, -0.5, 0.0, 0.37, 1.0):
        history = history_of(np.full(400, value))
        view = view_of(history)
        picture, geometry = picture_of(view, (fixed("alpha"),), height=101)
        picture.advance(history, view)
        box = geometry.charts[0]
        rows = rows_of_line(seen(picture, view), box, geometry.plot, 200)
        free = picture.free_rows
        expected = free + (box.height - 2 * free) * (1.0 - value) / 2.0
        assert rows.mean() + 0.5 == pytest.approx(expected, abs=0.6)


@pytest.mark.parametrize("window", [1.0, 3.0, 12.0])
def test_a_gap_stays_empty(window):
    values = np.where((np.arange(1200) > 1120) & (np.arange(1200) < 1160), np.nan, 0.5)
    values[1160:] = -0.5
    history = history_of(values)
    view = view_of(history, width=300, window=window)
    for ratio in (1.0, 3.0):
        picture, geometry = picture_of(
            view, (fixed("alpha"),), height=round(80 * ratio), ratio=ratio
        )
        picture.advance(history, view)
        box = geometry.charts[0]
        part = seen(picture, view)[box.y - geometry.plot.y : box.bottom - geometry.plot.y]
        first, last = view.x(11.20) + 1, view.x(11.60)
        behind = {color(DAYLIGHT.plot), color(DAYLIGHT.grid)}
        for x in range(first, last):
            assert set(np.unique(part[:, x]).tolist()) <= behind
        assert color(DAYLIGHT.trace("blue")) in part[:, first - 1 - view.scale.stretch]
        assert color(DAYLIGHT.trace("blue")) in part[:, last]


def test_limits_are_bands_at_their_rows():
    history = history_of(np.full(400, -0.9))
    view = view_of(history)
    limits = LimitBands(caution_high=0.2, warning_high=0.6, warning_low=-0.7)
    picture, geometry = picture_of(view, (fixed("alpha"),), height=200, limits=limits)
    picture.advance(history, view)
    box = geometry.charts[0]
    column = seen(picture, view)[box.y - geometry.plot.y :, 40]

    def row(value):
        free = picture.free_rows
        return free + (box.height - 2 * free) * (1.0 - value) / 2.0

    caution = np.flatnonzero(column == color(DAYLIGHT.caution_band))
    warning = np.flatnonzero(column == color(DAYLIGHT.warning_band))
    assert caution.min() == pytest.approx(row(0.6), abs=1.6)
    assert caution.max() == pytest.approx(row(0.2), abs=1.6)
    assert warning.min() <= 1
    assert warning[warning < 100].max() == pytest.approx(row(0.6), abs=1.6)
    assert warning[warning > 100].min() == pytest.approx(row(-0.7), abs=1.6)
    border = np.flatnonzero(column == color(DAYLIGHT.caution_fill))
    assert any(abs(place + 0.5 - row(0.2)) <= 1.0 for place in border)


@pytest.mark.parametrize(("thickness", "ratio"), [(2, 1.0), (4, 2.0), (5, 2.5), (6, 3.0)])
def test_lines_are_as_thick_as_they_should_be(thickness, ratio):
    values = np.where(np.arange(600) < 500, -0.5, 0.5)
    history = history_of(values)
    view = view_of(history, width=300)
    picture, geometry = picture_of(view, (fixed("alpha"),), height=round(100 * ratio), ratio=ratio)
    picture.advance(history, view)
    pixels = seen(picture, view)
    box = geometry.charts[0]
    line, behind = parse_rgb(DAYLIGHT.trace("blue")), parse_rgb(DAYLIGHT.plot)
    column = pixels[box.y - geometry.plot.y : box.bottom - geometry.plot.y, 100]
    red = (column >> 16) & 0xFF
    inked = red[column != color(DAYLIGHT.grid)].astype(float)
    covered = ((behind[0] - inked) / (behind[0] - line[0])).sum()
    assert covered == pytest.approx(thickness, abs=0.35)
    middle = pixels[(box.y - geometry.plot.y) + box.height // 2 + 6]
    step = view.x(5.0)
    near = middle[step - 12 : step + 13]
    assert (near == color(DAYLIGHT.trace("blue"))).sum() == thickness


def test_the_brush_is_round_and_symmetric():
    for width in (1, 2, 3, 4, 5, 8, 15):
        pairs = create_brush(float(width))
        assert len(pairs) == width
        halves = [half for _, half in pairs]
        assert max(halves) == pytest.approx(width / 2.0)
        assert halves == pytest.approx(halves[::-1])


def test_a_computed_trace_is_dashed_where_the_samples_are():
    history = history_of(np.zeros(2000))
    view = view_of(history, width=300, window=3.0)
    picture, geometry = picture_of(view, (fixed("alpha", style="computed"),), height=61)
    picture.advance(history, view)
    (trace,) = picture.raster.charts[0].traces
    box, plot = geometry.charts[0], geometry.plot
    row = seen(picture, view)[box.y - plot.y + 30]
    red, green, blue = trace.color
    drawn = row == (0xFF000000 | red << 16 | green << 8 | blue)
    places = np.arange(drawn.size) + view.columns[0]
    assert drawn.tolist() == ((places // trace.dash) % 3 != 2).tolist()


def test_a_value_off_the_scale_stays_visible_at_the_edge():
    history = history_of(np.full(400, 7.0))
    view = view_of(history)
    picture, geometry = picture_of(view, (fixed("alpha"),), height=60)
    picture.advance(history, view)
    box = geometry.charts[0]
    top = seen(picture, view)[box.y - geometry.plot.y]
    assert (top == color(DAYLIGHT.trace("blue"))).all()


def test_spans_and_marks_cross_all_charts_at_their_columns():
    history = history_of(np.full(1000, np.nan), CHANNELS)
    history.append(Block(channels=("alpha",), times=np.array([9.99]), values=np.array([[0.0]])))
    view = view_of(history, width=500, window=10.0)
    picture, _ = picture_of(view, spans=SPANS, marks=MARKS)
    picture.advance(history, view)
    pixels = seen(picture, view)
    edge = color(DAYLIGHT.span_edge)
    for time in (3.0, 5.0, 6.5, 8.0):
        assert (pixels[:, view.x(time)] == edge).all()
    assert (pixels[0, view.x(3.0) + 1 : view.x(5.0)] == color(DAYLIGHT.span)).sum() > 40
    assert (pixels[10] == color(DAYLIGHT.event)).sum() > 40


appends = st.tuples(
    st.just("append"),
    st.integers(0, len(CHANNELS)),
    st.integers(1, 70),
    st.sampled_from(["noise", "steps", "gaps"]),
)
moves = st.tuples(st.just("scroll"), st.floats(-4.0, 4.0))
others = st.tuples(st.sampled_from(["pause", "live", "frame"]))


@given(
    operations=st.lists(st.one_of(appends, appends, moves, others), min_size=5, max_size=30),
    window=st.sampled_from([0.7, 2.0, 9.0]),
    ratio=st.sampled_from([1.0, 1.5, 3.0]),
    seed=st.integers(0, 1000),
)
@settings(max_examples=50, deadline=None)
def test_any_number_of_frames_gives_the_full_picture_bit_for_bit(operations, window, ratio, seed):
    rng = np.random.default_rng(seed)
    history = SampleHistory(CHANNELS, RATE)
    ends = dict.fromkeys(CHANNELS, 0)

    def append(which, count, kind):
        # One channel alone, so that some are ahead of others; the last choice is all at once.
        names = CHANNELS if which == len(CHANNELS) else (CHANNELS[which],)
        first = max(ends[name] for name in names)
        values = rng.normal(0.0, 0.4, (count, len(names)))
        if kind == "steps":
            values = np.round(values)
        elif kind == "gaps":
            values[rng.random(count) < 0.4] = np.nan
        times = (first + np.arange(count)) / RATE
        history.append(Block(channels=names, times=times, values=values))
        for name in names:
            ends[name] = first + count

    append(len(CHANNELS), 300, "noise")
    view = view_of(history, width=97, window=window)
    across = {"spans": SPANS, "marks": MARKS}
    picture, _ = picture_of(view, height=90, ratio=ratio, **across)
    picture.advance(history, view)
    for operation, *arguments in operations:
        if operation == "append":
            append(*arguments)
            view.now = history.end
        elif operation == "scroll":
            view.scroll(arguments[0])
        elif operation == "pause":
            view.pause()
        elif operation == "live":
            view.go_live()
        picture.advance(history, view)
        fresh, _ = picture_of(view, height=90, ratio=ratio, **across)
        fresh.advance(history, view)
        assert np.array_equal(seen(picture, view), seen(fresh, view))


def test_what_was_rewritten_is_painted_anew():
    history = history_of(np.zeros(600))
    view = view_of(history)
    picture, _ = picture_of(view, (fixed("alpha"),), height=60)
    picture.advance(history, view)
    before = seen(picture, view).copy()
    history.append(
        Block(channels=("alpha",), times=np.arange(400, 450) / RATE, values=np.full((50, 1), 0.9))
    )
    picture.advance(history, view)
    fresh, _ = picture_of(view, (fixed("alpha"),), height=60)
    fresh.advance(history, view)
    assert not np.array_equal(seen(picture, view), before)
    assert np.array_equal(seen(picture, view), seen(fresh, view))


@pytest.mark.parametrize("window", [0.8, 3.0, 20.0])
def test_a_replay_shows_what_a_live_flight_would(window):
    rng = np.random.default_rng(3)
    history = history_of(rng.normal(0.0, 0.3, (3000, len(CHANNELS))), CHANNELS)
    history.horizon = 10.0
    view = view_of(history, width=150, window=window)
    picture, _ = picture_of(view)
    for horizon in (10.0, 10.02, 10.03, 10.5, 11.0, 4.0, 4.02, 4.1, 25.0, 25.01, 9.0):
        history.horizon = horizon
        view.set_now(history.end)
        picture.advance(history, view)
        fresh, _ = picture_of(view)
        fresh.advance(history, view)
        assert np.array_equal(seen(picture, view), seen(fresh, view))
        assert view.x(horizon) == view.width - 1


class CountingHistory:
    """A history that counts how many columns and samples it is asked for."""

    def __init__(self, history):
        self._history = history
        self.columns = self.asked = 0

    def __getattr__(self, name):
        return getattr(self._history, name)

    def extremes(self, channel_id, first, last, size):
        self.columns += max(last - first, 0)
        return self._history.extremes(channel_id, first, last, size)

    def samples(self, channel_id, first, last):
        self.asked += max(last - first, 0)
        return self._history.samples(channel_id, first, last)


def test_a_frame_asks_for_new_samples_only():
    history = CountingHistory(history_of(np.zeros(60_000), CHANNELS))
    view = view_of(history, width=800, window=100.0)
    picture, _ = picture_of(view)
    picture.advance(history, view)
    assert history.asked >= 10_000 * len(CHANNELS)
    for frame in range(20):
        history.columns = history.asked = 0
        start = 600.0 + frame * 0.02
        history.append(
            Block(
                channels=CHANNELS,
                times=np.array([start, start + 0.01]),
                values=np.zeros((2, len(CHANNELS))),
            )
        )
        view.now = history.end
        picture.advance(history, view)
        assert history.columns == 0
        assert history.asked == 2 * len(CHANNELS)
    history.columns = history.asked = 0
    still = picture.advance(history, view)
    assert not still.scrolled
    assert still.first == still.last
    assert history.columns == history.asked == 0


def test_after_a_long_silence_of_the_window_columns_are_asked_for():
    history = CountingHistory(history_of(np.zeros(60_000), CHANNELS))
    view = view_of(history, width=800, window=400.0)
    picture, _ = picture_of(view)
    picture.advance(history, view)
    history.asked = 0
    times = 600.0 + np.arange(20_000) / RATE
    history.append(
        Block(channels=CHANNELS, times=times, values=np.full((20_000, len(CHANNELS)), 0.5))
    )
    view.now = history.end
    picture.advance(history, view)
    fresh, _ = picture_of(view)
    fresh.advance(history, view)
    assert history.asked == 0
    assert np.array_equal(seen(picture, view), seen(fresh, view))


def test_an_axis_follows_what_is_in_sight():
    t = np.arange(3000) / RATE
    history = history_of(0.3 * np.sin(t), ("alpha",))
    view = view_of(history, window=20.0)
    strip = Strip(traces=(Trace(channel="alpha"),))
    limits = LimitBands(caution_low=-0.25, caution_high=0.1, warning_high=0.2)
    chart = create_chart(strip, DAYLIGHT, "US", limits)
    geometry = compute_geometry(300, 300, 1.0, COLUMNS, [("", [1.0])], 0, 0, False)
    picture = ChartRaster({0: chart}, geometry, DAYLIGHT, 1.0)
    picture.advance(history, view)
    assert picture.update_auto_ranges(view, at_once=True)
    assert chart.low <= math.degrees(-0.3)
    assert chart.high >= math.degrees(0.3)
    assert chart.high - chart.low < 2.2 * math.degrees(0.6)
    assert all(chart.low <= tick <= chart.high for tick in chart.ticks)
    assert not picture.update_auto_ranges(view, at_once=False)
    picture.advance(history, view)
    fresh = ChartRaster({0: chart}, geometry, DAYLIGHT, 1.0)
    fresh.advance(history, view)
    assert np.array_equal(seen(picture, view), seen(fresh, view))
