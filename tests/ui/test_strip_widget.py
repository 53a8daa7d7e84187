"""The strip charts as a widget: keys pressed, pixels read back."""

import math
import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QWheelEvent

from gsapp.quantities import Block, channel
from gsapp.session.limits import LimitBands
from gsapp.session.sample_history import SampleHistory
from ui.flight.panel_rows import build_cursor_value_rows
from ui.strips import chart_painter
from ui.strips.chart_annotations import AlarmSpan, ChannelOrigin, ChartMark, ChartSpan
from ui.strips.chart_keys import ACTION_BY_KEY, KEY_ACTIONS
from ui.strips.strip_chart import StripChart
from ui.strips.strip_layout import Strip, StripGroup, StripLayout, Trace, default_layout
from ui.theme import DARK, DAYLIGHT, THEMES

RATE = 100.0
CHANNELS = ("de", "alpha", "q", "V")
LAYOUT = StripLayout(
    name="Test",
    window=10.0,
    groups=(
        StripGroup(
            name="Pitch",
            strips=tuple(Strip(traces=(Trace(channel=name),)) for name in CHANNELS[:3]),
        ),
        StripGroup(name="Air", strips=(Strip(traces=(Trace(channel="V"),)),)),
    ),
)


def rows(start, count):
    t = start + np.arange(count) / RATE
    values = np.column_stack(
        (0.1 * np.sign(np.sin(t)), 0.05 * np.sin(t), 0.2 * np.cos(t), 40.0 + np.sin(0.3 * t))
    )
    return Block(channels=CHANNELS, times=t, values=values)


@pytest.fixture
def history():
    found = SampleHistory(CHANNELS, RATE)
    found.append(rows(0.0, 6000))
    yield found
    found.close()


@pytest.fixture
def strips(qtbot, history):
    widget = StripChart(timed=False)
    qtbot.addWidget(widget)
    widget.resize(900, 500)
    widget.set_layout(LAYOUT)
    widget.show()
    widget.set_history(history)
    widget.setFocus()
    settle(qtbot, widget)
    return widget


def settle(qtbot, widget):
    widget.advance()
    qtbot.wait(1)
    widget.advance()
    qtbot.wait(1)


def image_of(widget):
    return widget.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)


def pixels_of(image):
    array = np.frombuffer(image.constBits(), dtype=np.uint32)
    return array.reshape(image.height(), image.bytesPerLine() // 4)[:, : image.width()].copy()


def raster_of(widget):
    geometry = widget.geometry_in_pixels
    raster = widget.raster.raster
    seam = widget.view.columns[0] % raster.width
    shown = np.concatenate((raster.pixels[:, seam:], raster.pixels[:, :seam]), axis=1)
    return shown, geometry.plot


def count(pixels, color):
    return int((pixels == (QColor(color).rgb() & 0xFFFFFFFF)).sum())


def press(qtbot, widget, key, modifier=Qt.KeyboardModifier.NoModifier):
    qtbot.keyClick(widget, key, modifier)
    settle(qtbot, widget)


def test_the_screen_shows_the_raster_to_the_pixel(qtbot, strips):
    for second in range(7):
        strips.model.history.append(rows(60.0 + second, 100))
        settle(qtbot, strips)
        shown, plot = raster_of(strips)
        screen = pixels_of(image_of(strips))
        part = screen[plot.y : plot.bottom, plot.x : plot.right]
        assert np.array_equal(part, shown)


def test_partial_repaints_equal_a_full_repaint(qtbot, strips):
    screen = QImage(strips.size(), QImage.Format.Format_RGB32)
    for second in range(5):
        strips.model.history.append(rows(60.0 + second, 100))
        strips._values_read_at = -math.inf
        settle(qtbot, strips)
    strips.render(screen)
    kept = strips.screen().grabWindow(strips.winId()).toImage()
    if kept.isNull() or kept.size() != screen.size():
        pytest.skip("this platform cannot read its own screen")
    assert kept.convertToFormat(QImage.Format.Format_RGB32) == screen


def test_space_pauses_says_so_and_recording_goes_on(qtbot, strips, history):
    strips.set_recording(True)
    with qtbot.waitSignal(strips.view_changed):
        qtbot.keyClick(strips, Qt.Key.Key_Space)
    settle(qtbot, strips)
    before, _ = raster_of(strips)
    banner = pixels_of(image_of(strips))[:20]
    assert count(banner, DAYLIGHT.banner) > 5000
    history.append(rows(60.0, 250))
    settle(qtbot, strips)
    # The last columns now know what came after them; nothing else may move.
    assert np.array_equal(raster_of(strips)[0][:, :-4], before[:, :-4])
    assert strips.view.seconds_behind == pytest.approx(2.5, abs=0.02)
    assert history.end == pytest.approx(62.49)
    assert not np.array_equal(pixels_of(image_of(strips))[:20], banner)
    press(qtbot, strips, Qt.Key.Key_Home)
    assert not strips.view.paused
    assert count(pixels_of(image_of(strips))[:20], DAYLIGHT.banner) < 500
    assert strips.view.x(history.end) == strips.view.width - 1


def test_a_pause_speaks_of_recording_only_while_there_is_any(qtbot, strips):
    press(qtbot, strips, Qt.Key.Key_Space)
    without = pixels_of(image_of(strips))[:20]
    strips.set_recording(True)
    settle(qtbot, strips)
    told = pixels_of(image_of(strips))[:20]
    assert count(told, DAYLIGHT.banner) < count(without, DAYLIGHT.banner) - 100


def test_arrows_scroll_back_while_the_stream_goes_on(qtbot, strips, history):
    live, _ = raster_of(strips)
    columns = strips.view.columns
    history.append(rows(60.0, 1500))
    settle(qtbot, strips)
    for _ in range(3):
        press(qtbot, strips, Qt.Key.Key_Left)
    press(qtbot, strips, Qt.Key.Key_PageUp)
    assert strips.view.paused
    strips.view.scroll(strips.view.scale.time(columns[1] - strips.view.columns[1]))
    settle(qtbot, strips)
    assert strips.view.columns == columns
    # The ranges are wide enough for what was in sight meanwhile; begin anew with them.
    strips.set_theme(DARK)
    strips.set_theme(DAYLIGHT)
    settle(qtbot, strips)
    back, _ = raster_of(strips)
    # The last columns now know what came after them.
    assert np.array_equal(back[:, :-4], live[:, :-4])


def test_plus_and_minus_zoom(qtbot, strips):
    seconds = strips.view.seconds
    press(qtbot, strips, Qt.Key.Key_Plus)
    assert strips.view.seconds < seconds
    axis = strips.geometry_in_pixels.axis
    near = pixels_of(image_of(strips))[axis.y :]
    press(qtbot, strips, Qt.Key.Key_Minus)
    press(qtbot, strips, Qt.Key.Key_Minus)
    assert strips.view.seconds > seconds
    assert not np.array_equal(pixels_of(image_of(strips))[axis.y :], near)


def test_the_wheel_zooms_about_the_pointer(qtbot, strips):
    press(qtbot, strips, Qt.Key.Key_PageUp)
    plot = strips.geometry_in_pixels.plot
    x = plot.x + 200
    before = strips.view.time(200)
    wheel(strips, x, plot.y + 50, 120)
    settle(qtbot, strips)
    place = strips.geometry_in_pixels.plot
    assert strips.view.x(before) + place.x == pytest.approx(x, abs=2)


def test_a_touchpad_zooms_by_how_far_the_fingers_move(strips):
    plot = strips.geometry_in_pixels.plot
    x, y = plot.x + 200, plot.y + 50
    seconds = strips.view.seconds
    for _ in range(7):
        wheel(strips, x, y, 15, 5)
    assert strips.view.seconds == seconds
    wheel(strips, x, y, 15, -14)
    nearer = strips.view.seconds
    assert nearer < seconds
    wheel(strips, x, y, 90)
    wheel(strips, x, y, -90)
    wheel(strips, x, y, 90)
    assert strips.view.seconds == nearer
    first = strips.view.columns[0]
    wheel(strips, x, y, 8, 60)
    assert strips.view.columns[0] < first
    assert strips.view.seconds == nearer


def wheel(widget, x, y, turn, sideways=0):
    point = QPointF(x, y)
    widget.wheelEvent(
        QWheelEvent(
            point,
            widget.mapToGlobal(point),
            QPoint(0, 0),
            QPoint(sideways, turn),
            Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        )
    )


def test_the_cursor_stands_in_all_charts_and_reads_every_value(qtbot, strips, history):
    moved = []
    strips.cursor_moved.connect(lambda name, time: moved.append((name, time)))
    press(qtbot, strips, Qt.Key.Key_C)
    time = strips.view.cursors["cursor"]
    assert moved == [("cursor", time)]
    plot = strips.geometry_in_pixels.plot
    x = plot.x + strips.view.x(time)
    screen = pixels_of(image_of(strips))
    column = screen[plot.y : plot.bottom, x]
    assert count(column, DAYLIGHT.cursor) == plot.height
    expected = history.samples("V", round(time * RATE), round(time * RATE) + 1)[0]
    assert strips.model.value_at("V", time) == expected
    texts = strips.model.cursor_texts(3)["cursor"]
    assert texts == [f"{expected / 0.3048:.1f}"]
    press(qtbot, strips, Qt.Key.Key_Right, Qt.KeyboardModifier.ControlModifier)
    later = strips.view.cursors["cursor"]
    assert later > time
    assert later - time == pytest.approx(max(strips.view.scale.seconds, 1.0 / RATE), abs=0.5 / RATE)
    press(qtbot, strips, Qt.Key.Key_C)
    assert not strips.view.cursors


def test_a_and_b_give_differences(qtbot, strips):
    press(qtbot, strips, Qt.Key.Key_C)
    press(qtbot, strips, Qt.Key.Key_A)
    for _ in range(3):
        press(
            qtbot,
            strips,
            Qt.Key.Key_Right,
            Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier,
        )
    press(qtbot, strips, Qt.Key.Key_B)
    a, b = strips.view.cursors["a"], strips.view.cursors["b"]
    assert b > a
    difference = (strips.model.value_at("q", b) - strips.model.value_at("q", a)) * 180.0 / math.pi
    text = strips.model.cursor_texts(2)["delta"][0].replace("\N{MINUS SIGN}", "-")
    assert float(text) == pytest.approx(difference, abs=0.051)
    # A whole line for each of C, A, B and the difference, and still one column.
    assert len(strips.geometry_in_pixels.cursors) == 1
    press(qtbot, strips, Qt.Key.Key_Escape)
    assert not strips.view.cursors
    assert not strips.geometry_in_pixels.cursors


def test_charts_are_chosen_enlarged_and_moved_by_keys(qtbot, strips):
    press(qtbot, strips, Qt.Key.Key_Down)
    press(qtbot, strips, Qt.Key.Key_Down)
    assert strips.view.selected == 2
    assert "Pitch rate" in strips.accessibleDescription()
    press(qtbot, strips, Qt.Key.Key_Return)
    assert strips.geometry_in_pixels.numbers == (2,)
    press(qtbot, strips, Qt.Key.Key_Up)
    assert strips.geometry_in_pixels.numbers == (1,)
    press(qtbot, strips, Qt.Key.Key_Escape)
    assert strips.geometry_in_pixels.numbers == (0, 1, 2, 3)
    with qtbot.waitSignal(strips.layout_changed) as caught:
        qtbot.keyClick(strips, Qt.Key.Key_Down, Qt.KeyboardModifier.AltModifier)
    assert [strip.channel for strip in caught.args[0].strips] == ["de", "q", "alpha", "V"]
    assert strips.view.selected == 2
    with qtbot.waitSignal(strips.layout_changed) as caught:
        qtbot.keyClick(strips, Qt.Key.Key_Y)
    assert caught.args[0].strips[2].range == "limits"


def test_a_heading_differs_by_the_short_way_at_the_chart_and_in_the_table(qtbot):
    """From 175 to -175 degrees is a turn of 10 to the right, and not one of 350 to the left."""
    times = np.arange(200) / RATE
    heading = np.radians(np.where(times < 1.0, 175.0, -175.0))
    history = SampleHistory(("psi", "temperature"), RATE)
    values = np.column_stack((heading, np.where(times < 1.0, 288.15, 298.15)))
    history.append(Block(channels=("psi", "temperature"), times=times, values=values))
    widget = StripChart(timed=False)
    qtbot.addWidget(widget)
    strips = tuple(Strip(traces=(Trace(channel=name),)) for name in history.channels)
    groups = (StripGroup(name="", strips=strips),)
    widget.set_layout(StripLayout(name="Turn", window=10.0, groups=groups))
    widget.set_history(history)
    widget.show()
    settle(qtbot, widget)
    for cursors, said in (((0.5, 1.5), ("10", "18")), ((1.5, 0.5), ("-10", "-18"))):
        for name, time in zip("ab", cursors, strict=True):
            widget.navigator.set_cursor(name, time)
        settle(qtbot, widget)
        charts = [widget.model.cursor_texts(number)["delta"][0] for number in (0, 1)]
        table = [
            line.cells[-1]
            for line in build_cursor_value_rows(
                history, history.channels, widget.view.cursors, "US"
            )
        ]
        for texts in (charts, table):
            numbers = [float(text.replace("\N{MINUS SIGN}", "-")) for text in texts]
            assert numbers == pytest.approx([float(text) for text in said])
    history.close()


def rows_with(pixels, box, color):
    part = pixels[box.y : box.y + box.height, box.x : box.x + box.width]
    there = part == (QColor(color).rgb() & 0xFFFFFFFF)
    found = box.y + np.flatnonzero(there.any(axis=1))
    return found, int(there.sum(axis=1).max(initial=0))


def test_the_chart_that_keys_go_to_is_marked_along_all_its_height(qtbot, strips):
    press(qtbot, strips, Qt.Key.Key_Down)
    geometry = strips.geometry_in_pixels
    gutter = replace(geometry.charts[0], x=0, y=0, width=geometry.columns.gutter)
    gutter = replace(gutter, height=strips.height())
    marked, wide = rows_with(pixels_of(image_of(strips)), gutter, DAYLIGHT.selection)
    chosen = geometry.charts[1]
    assert marked.tolist() == list(range(chosen.y, chosen.y + chosen.height))
    assert wide == 3
    strips.clearFocus()
    settle(qtbot, strips)
    assert not rows_with(pixels_of(image_of(strips)), gutter, DAYLIGHT.selection)[0].size


def test_values_at_a_cursor_stand_beside_their_own_chart_each_in_its_color(qtbot, strips):
    both = Strip(traces=(Trace(channel="de"), Trace(channel="alpha")))
    group = StripGroup(name="", strips=(both, both))
    strips.set_layout(StripLayout(name="Two", window=10.0, groups=(group,)))
    settle(qtbot, strips)
    press(qtbot, strips, Qt.Key.Key_C)
    geometry = strips.geometry_in_pixels
    pixels = pixels_of(image_of(strips))
    (column,) = geometry.cursors
    for number, box in zip(geometry.numbers, geometry.charts, strict=True):
        first, second = (
            rows_with(pixels, replace(column, y=box.y, height=box.height), ink)[0]
            for ink in strips.charts[number].text_colors
        )
        middle = box.y + box.height / 2
        assert first.size
        assert second.size
        assert first[-1] < middle < second[0]


@pytest.mark.parametrize("align", ["left", "center", "right"])
@pytest.mark.parametrize("points", [11, 24])
def test_a_text_stands_where_it_is_asked_for_in_its_size(qapp, align, points):
    image = QImage(400, 80, QImage.Format.Format_RGB32)
    image.fill(QColor("#ffffff"))
    pen = chart_painter.PaintStyle(DAYLIGHT, 1.0)
    pen.painter = QPainter(image)
    pen.painter.setFont(pen.font(40)[0])
    width = pen.text(200.0, 40.0, "HHHHH", "#000000", points, align=align)
    pen.painter.end()
    rows_inked, columns = np.nonzero(pixels_of(image) != 0xFFFFFFFF)
    left = 200.0 - {"left": 0.0, "center": 0.5, "right": 1.0}[align] * width
    assert columns.min() == pytest.approx(left, abs=0.2 * points)
    assert columns.max() == pytest.approx(left + width, abs=0.2 * points)
    assert (rows_inked.min() + rows_inked.max()) / 2 == pytest.approx(40.0, abs=1.5)
    capital = pen.font(points)[1].capHeight()
    assert rows_inked.max() - rows_inked.min() + 1 == pytest.approx(capital, abs=2.0)


def test_m_asks_for_a_mark_at_the_newest_sample_or_at_the_cursor(qtbot, strips, history):
    with qtbot.waitSignal(strips.mark_requested) as caught:
        qtbot.keyClick(strips, Qt.Key.Key_M)
    assert caught.args == [history.end]
    press(qtbot, strips, Qt.Key.Key_PageUp)
    press(qtbot, strips, Qt.Key.Key_C)
    with qtbot.waitSignal(strips.mark_requested) as caught:
        qtbot.keyClick(strips, Qt.Key.Key_M)
    assert caught.args == [strips.view.cursors["cursor"]]


def test_every_key_of_the_table_does_something_known(qtbot, strips):
    keys = [key for action in KEY_ACTIONS for key in action.keys]
    assert len(keys) == len(set(keys))
    for action in KEY_ACTIONS:
        assert action.text
        strips.perform(action.id)
        settle(qtbot, strips)
    assert set(ACTION_BY_KEY.values()) == set(KEY_ACTIONS)


def test_a_stale_value_becomes_a_dash(qtbot, strips, history):
    settle(qtbot, strips)
    assert strips.displayed_values(3)[0].text.startswith("1")
    strips.set_now(history.end + 10.0)
    strips._values_read_at = -math.inf
    settle(qtbot, strips)
    for number in range(4):
        assert strips.displayed_values(number)[0].stale
        assert strips.displayed_values(number)[0].text == "\N{EN DASH}"


def test_a_value_that_comes_seldom_is_left_standing_until_it_is_late(qtbot, strips, history):
    settle(qtbot, strips)
    seldom = strips.strip_layout.strips[1].channel
    strips.set_stale_ages({seldom: 10.0})
    for age, stale in ((2.9, [False] * 4), (9.9, [True, False, True, True]), (10.1, [True] * 4)):
        strips.set_now(history.end + age)
        strips._values_read_at = -math.inf
        settle(qtbot, strips)
        assert [strips.displayed_values(number)[0].stale for number in range(4)] == stale


def test_a_channel_without_data_is_a_dash_from_the_start(qtbot, strips):
    strips.set_layout(default_layout())
    settle(qtbot, strips)
    index = [strip.channel for strip in default_layout().strips].index("beta")
    assert strips.displayed_values(index)[0].stale


def test_estimated_uncalibrated_and_out_of_limits_are_said_beside_the_value(qtbot, strips):
    plain = image_of(strips)
    strips.set_sources(
        {"q": ChannelOrigin("estimated", True), "alpha": ChannelOrigin("measured", False)}
    )
    strips.set_limits({"V": LimitBands(warning_high=30.0, caution_high=20.0)})
    settle(qtbot, strips)
    assert strips.displayed_values(2)[0].estimated
    assert strips.displayed_values(1)[0].uncalibrated
    assert not strips.displayed_values(1)[0].extrapolated
    before = image_of(strips)
    strips.set_sources({"alpha": ChannelOrigin("measured", True, {"alpha": (-1e-6, 1e-6)})})
    settle(qtbot, strips)
    assert strips.displayed_values(1)[0].extrapolated
    assert image_of(strips) != before
    strips.set_sources(
        {"q": ChannelOrigin("estimated", True), "alpha": ChannelOrigin("measured", False)}
    )
    settle(qtbot, strips)
    assert (strips.displayed_values(3)[0].state, strips.displayed_values(3)[0].state_text) == (
        "warning",
        "HIGH",
    )
    box = strips.geometry_in_pixels.charts[3]
    values = strips.geometry_in_pixels.values
    cell = pixels_of(image_of(strips))[box.y : box.bottom, values.x : values.right]
    assert count(cell, DAYLIGHT.warning_fill) > 100
    assert image_of(strips) != plain


def test_values_at_cursors_say_that_they_lie_beyond_what_was_calibrated(qtbot, strips):
    history = strips.model.history
    alpha = history.samples("alpha", 0, round(history.end * history.rate))
    half = float(np.nanmax(alpha)) / 2.0
    covered = {"alpha": (-1.0, half)}
    strips.set_sources(
        {
            "alpha": ChannelOrigin("measured", True, covered),
            "q": ChannelOrigin("derived", True, covered),
        }
    )
    times = np.arange(alpha.size) / history.rate
    for time, beyond in (
        (times[np.nanargmax(alpha)], True),
        (times[np.nanargmin(np.abs(alpha - 0.5 * half))], False),
    ):
        strips.navigator.set_cursor("cursor", float(time))
        settle(qtbot, strips)
        for number, marked in ((1, beyond), (2, beyond), (3, False)):
            (text,) = strips.model.cursor_texts(number)["cursor"]
            assert text.startswith("*") is marked


def test_units_change_the_numbers_and_not_the_line(qtbot, strips):
    us = strips.displayed_values(3)[0].text
    strips.set_units("SI")
    settle(qtbot, strips)
    si = strips.displayed_values(3)[0].text
    assert float(us) == pytest.approx(float(si) / 0.3048, rel=0.01)
    assert strips.charts[3].low < 40.0 < strips.charts[3].high < 60.0


@pytest.mark.parametrize("theme", THEMES.values(), ids=lambda theme: theme.name)
def test_every_theme_paints_its_own_colors(qtbot, strips, theme):
    strips.set_theme(theme)
    settle(qtbot, strips)
    screen = pixels_of(image_of(strips))
    assert count(screen, theme.background) > 10_000
    assert count(screen, theme.plot) > 10_000
    assert count(screen, theme.trace("blue")) > 500
    if theme is not DARK:
        assert count(screen, DARK.plot) < 100


def test_spans_and_marks_are_labeled_across_all_charts(qtbot, strips):
    strips.set_spans([ChartSpan(label="doublet 1", start=55.0, stop=57.0)])
    strips.set_marks([ChartMark(label="gust", time=53.0)])
    settle(qtbot, strips)
    geometry = strips.geometry_in_pixels
    screen = pixels_of(image_of(strips))
    for time in (53.0, 55.0, 57.0):
        column = screen[
            geometry.plot.y : geometry.plot.bottom, geometry.plot.x + strips.view.x(time)
        ]
        # Only the lines themselves lie over it.
        assert count(column, DAYLIGHT.span_edge) > 0.9 * geometry.plot.height
        assert column[0] == column[-1]
    lane = screen[geometry.lane.y : geometry.lane.bottom]
    dark = ((lane >> 16) & 0xFF) < 110
    assert dark[:, geometry.plot.x :].sum() > 60


@pytest.mark.parametrize("from_edge", [1, 300])
def test_marks_of_one_moment_share_their_label(qtbot, strips, from_edge):

    def lane(*labels):
        time = strips.view.time(strips.view.width - from_edge)
        strips.set_marks([ChartMark(label=label, time=time) for label in labels])
        settle(qtbot, strips)
        box = strips.geometry_in_pixels.lane
        return pixels_of(image_of(strips))[box.y : box.bottom]

    settle(qtbot, strips)
    both = lane("Mark 1", "gusty here")
    assert np.array_equal(both, lane("Mark 1, gusty here"))
    assert not np.array_equal(both, lane("Mark 1"))


def test_words_without_room_before_a_mark_are_cut_there(qtbot, strips):
    settle(qtbot, strips)
    geometry = strips.geometry_in_pixels
    latest = strips.view.time(strips.view.width - 1)
    lane = slice(geometry.lane.y, geometry.lane.bottom)

    def shown(label):
        strips.set_marks([ChartMark(label=label, time=latest)])
        settle(qtbot, strips)
        return pixels_of(image_of(strips))[lane, geometry.plot.x :]

    written = (shown("turbulence " * 30) != shown("")).any(axis=0)
    assert written[: geometry.plot.width - 20].sum() > 200


def test_a_mark_just_made_has_its_words_before_it(qtbot, strips):
    settle(qtbot, strips)
    plain = pixels_of(image_of(strips))
    latest = strips.view.time(strips.view.width - 3)
    strips.set_marks([ChartMark(label="gust near the trees", time=latest)])
    settle(qtbot, strips)
    geometry = strips.geometry_in_pixels
    lane = slice(geometry.lane.y, geometry.lane.bottom)
    changed = (pixels_of(image_of(strips)) != plain)[lane].any(axis=0)
    flag = geometry.plot.x + strips.view.x(latest)
    assert changed[flag - 90 : flag - 8].sum() > 40


def test_at_200_percent_everything_is_twice_as_large(qtbot, strips):
    strips.resize(1280, 800)
    settle(qtbot, strips)
    small = strips.geometry_in_pixels
    reach = strips.raster.raster.reach
    strips.set_scale(2.0)
    settle(qtbot, strips)
    large = strips.geometry_in_pixels
    assert large.header.height == 2 * small.header.height
    assert strips.raster.raster.reach > reach
    assert large.numbers == small.numbers


@pytest.mark.parametrize("scale", [1.0, 1.5, 2.5])
def test_nothing_overlaps_at_any_scale(qtbot, strips, scale):
    strips.resize(1280, 800)
    strips.set_layout(default_layout())
    strips.set_scale(scale)
    for name, time in (("cursor", 51.0), ("a", 52.0), ("b", 53.0)):
        strips.navigator.set_cursor(name, time)
    settle(qtbot, strips)
    geometry = strips.geometry_in_pixels
    assert geometry.plot.width > 0.29 * 1280
    for above, below in zip(geometry.charts, geometry.charts[1:], strict=False):
        assert above.bottom < below.y
        assert above.height >= 16
    rights = [geometry.plot.right, *(box.right for box in geometry.cursors)]
    lefts = [*(box.x for box in geometry.cursors), geometry.values.x]
    assert all(right <= left for right, left in zip(rights, lefts, strict=True))
    assert geometry.values.right <= 1280
    assert len(geometry.charts) + geometry.hidden == 16


def test_the_beginning_is_where_the_samples_begin(qtbot, strips):
    late = SampleHistory(CHANNELS, RATE)
    strips.set_history(late)
    late.append(rows(1200.0, 9000))
    settle(qtbot, strips)
    press(qtbot, strips, Qt.Key.Key_Home, Qt.KeyboardModifier.ShiftModifier)
    assert strips.view.time(0) == pytest.approx(1200.0, abs=0.2)
    assert math.isfinite(strips.model.value_at("alpha", strips.view.time(0) + 0.2))
    late.close()


@pytest.mark.parametrize("key", [Qt.Key.Key_C, Qt.Key.Key_Right, Qt.Key.Key_A, Qt.Key.Key_B])
def test_a_new_cursor_stands_where_there_are_samples(qtbot, strips, key):
    young = SampleHistory(CHANNELS, RATE)
    young.append(rows(2.0, 2800))
    strips.set_history(young)
    strips.navigator.set_window(120.0)
    strips.set_now(45.0)
    settle(qtbot, strips)
    moves = key == Qt.Key.Key_Right
    held = Qt.KeyboardModifier.ControlModifier if moves else Qt.KeyboardModifier.NoModifier
    press(qtbot, strips, key, held)
    ((name, time),) = strips.view.cursors.items()
    assert name == {Qt.Key.Key_A: "a", Qt.Key.Key_B: "b"}.get(key, "cursor")
    assert math.isfinite(strips.model.value_at("alpha", time))
    wanted = 16.0 if name == "cursor" else 30.0
    assert time == pytest.approx(wanted, abs=0.5)
    young.close()


@pytest.mark.parametrize("scale", [1.0, 1.5, 2.0, 2.5])
@pytest.mark.parametrize("height", [300, 420, 560])
def test_every_chart_in_sight_has_two_labels_or_more(qtbot, strips, scale, height):
    layout = default_layout()
    strips.set_layout(layout.with_strip(2, layout.strips[2].model_copy(update={"height": 0.25})))
    strips.resize(900, height)
    strips.set_scale(scale)
    settle(qtbot, strips)
    geometry = strips.geometry_in_pixels
    assert len(geometry.numbers) > 1
    assert all(len(strips.charts[number].ticks) >= 2 for number in geometry.numbers)
    assert len(geometry.charts) + geometry.hidden == 16


@pytest.mark.parametrize("past", [0.0, 5.0, 10.0, 3600.0, 3611.0, 3627.0])
@pytest.mark.parametrize("width", [560, 640, 700, 900])
def test_the_time_axis_has_two_labels_or_more(qtbot, monkeypatch, past, width):
    drawn = []
    former = chart_painter.PaintStyle.text

    def watched(pen, x, center, text, *rest, **more):
        taken = former(pen, x, center, text, *rest, **more)
        if more.get("align") == "center" and ":" in text:
            drawn.append((x - taken / 2.0, x + taken / 2.0))
        return taken

    monkeypatch.setattr(chart_painter.PaintStyle, "text", watched)
    found = SampleHistory(("alpha",), 100.0)
    times = past + np.arange(7000) / 100.0
    found.append(Block(channels=("alpha",), times=times, values=np.sin(times)[:, None]))
    widget = StripChart(timed=False)
    qtbot.addWidget(widget)
    widget.resize(width, 400)
    widget.set_layout(LAYOUT)
    widget.set_history(found)
    widget.show()
    settle(qtbot, widget)
    for name in ("a", "b", "cursor"):
        widget.navigator.set_cursor(name, past + 60.0)
    for seconds in (2.0, 10.0, 60.0):
        widget.navigator.set_window(seconds)
        settle(qtbot, widget)
        drawn.clear()
        image_of(widget)
        labels = sorted(set(drawn))
        assert len(labels) >= 2, seconds
        assert all(one[1] + 4 <= other[0] for one, other in pairwise(labels))
        plot = widget.geometry_in_pixels.plot
        assert plot.x <= labels[0][0] + 1
        assert labels[-1][1] <= plot.right + 1
    found.close()


@pytest.fixture
def said(monkeypatch):
    """Return the texts that are painted from now on."""
    texts = []
    former = chart_painter.PaintStyle.text

    def watched(pen, x, center, text, *rest, **more):
        texts.append(text)
        return former(pen, x, center, text, *rest, **more)

    monkeypatch.setattr(chart_painter.PaintStyle, "text", watched)
    return texts


def test_a_pause_says_how_much_time_is_in_sight(qtbot, strips, said):
    press(qtbot, strips, Qt.Key.Key_Space)
    said.clear()
    image_of(strips)
    assert chart_painter.visible_time_text(strips.view) in said
    assert any("Home" in text for text in said)


def test_titles_stand_at_all_charts_of_a_height_or_at_none(qtbot, strips, said):
    layout = default_layout()
    strips.set_layout(layout)
    titles = {channel(strip.channel).title for strip in layout.strips}
    shown = set()
    for height in range(600, 760, 3):
        strips.resize(900, height)
        settle(qtbot, strips)
        said.clear()
        image_of(strips)
        shown.add(len(titles & set(said)))
    assert shown == {0, len(titles)}


def test_a_subscript_of_the_last_chart_is_whole(qtbot, strips):
    lateral = Strip(traces=(Trace(channel="ay"),))
    strips.set_layout(StripLayout(groups=(StripGroup(strips=(lateral, lateral)),)))
    strips.set_scale(2.5)
    inks = set()
    for height in range(250, 350, 5):
        strips.resize(2250, height)
        settle(qtbot, strips)
        geometry = strips.geometry_in_pixels
        below = geometry.charts[-1]
        if below.height >= 34 * 2.5:
            continue  # with its title
        left, right = geometry.columns.gutter, geometry.columns.gutter + geometry.columns.names
        image = pixels_of(image_of(strips))[below.y : below.bottom, left:right]
        inks.add(image.size - count(image, DAYLIGHT.background))
    assert len(inks) == 1
    assert inks.pop() > 100


def test_charts_that_find_no_room_come_into_sight_when_chosen(qtbot, strips):
    strips.set_layout(default_layout())
    strips.resize(700, 200)
    settle(qtbot, strips)
    assert strips.geometry_in_pixels.hidden > 0
    for _ in range(15):
        press(qtbot, strips, Qt.Key.Key_Down)
    assert 15 in strips.geometry_in_pixels.numbers


def test_being_told_the_same_again_costs_nothing(qtbot, strips):
    limits = {"V": LimitBands(warning_high=30.0)}
    spans, marks = [ChartSpan(label="one", start=52.0)], [ChartMark(label="here", time=53.0)]

    def tell():
        strips.set_layout(LAYOUT)
        strips.set_theme(DAYLIGHT)
        strips.set_units("US")
        strips.set_scale(1.0)
        strips.set_limits(dict(limits))
        strips.set_spans(list(spans))
        strips.set_marks(list(marks))
        settle(qtbot, strips)

    tell()
    picture = strips.raster
    tell()
    assert strips.raster is picture


def test_a_widget_never_shown_can_be_pictured(qtbot, history):
    widget = StripChart(timed=False)
    qtbot.addWidget(widget)
    widget.resize(800, 400)
    widget.set_layout(LAYOUT)
    widget.set_history(history)
    screen = pixels_of(image_of(widget))
    assert count(screen, DAYLIGHT.trace("blue")) > 500
    assert widget.displayed_values(3)[0].text.startswith("1")


def test_nothing_yet_is_said(qtbot):
    widget = StripChart(timed=False)
    qtbot.addWidget(widget)
    widget.resize(600, 400)
    widget.show()
    settle(qtbot, widget)
    widget.set_history(SampleHistory(("q",), RATE))
    settle(qtbot, widget)
    assert not widget.view.paused
    for action in KEY_ACTIONS:
        widget.perform(action.id)
    assert not image_of(widget).isNull()


def test_the_widget_follows_by_itself_and_rests_while_hidden(qtbot, history):
    widget = StripChart()
    qtbot.addWidget(widget)
    widget.resize(600, 400)
    widget.set_layout(LAYOUT)
    widget.set_history(history)
    widget.show()
    qtbot.waitUntil(lambda: widget.view.now == history.end, timeout=3000)
    history.append(rows(60.0, 10))
    qtbot.waitUntil(lambda: widget.view.now == history.end, timeout=3000)
    widget.hide()
    history.append(rows(60.1, 10))
    qtbot.wait(60)
    assert widget.view.now == pytest.approx(60.09)
    widget.show()
    qtbot.waitUntil(lambda: widget.view.now == history.end, timeout=3000)


def run_at_density(script, density):
    """Return what a script says that runs in a window system of another density."""
    found = subprocess.run(
        [sys.executable, "-c", script],
        env={
            **os.environ,
            "QT_QPA_PLATFORM": "offscreen",
            "QT_SCALE_FACTOR": str(density),
            "QT_SCALE_FACTOR_ROUNDING_POLICY": "PassThrough",
            "PYTHONPATH": str(Path(__file__).parents[2]),
        },
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert found.returncode == 0, found.stderr
    return found.stdout


PARTS_SCRIPT = """
import math
import numpy as np
from PySide6.QtCore import QEvent, QObject, QPoint
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication
from gsapp.quantities import Block
from gsapp.session.sample_history import SampleHistory
from ui.strips.strip_chart import StripChart
from ui.strips.strip_layout import default_layout

app = QApplication([])
CHANNELS = ("alpha", "q", "an", "beta")

def rows(first, count):
    t = first + np.arange(count) / 100.0
    values = np.column_stack([0.1 * np.sin((1 + k) * t) for k in range(4)])
    return Block(channels=CHANNELS, times=t, values=values)

history = SampleHistory(CHANNELS, 100.0)
history.append(rows(0.0, 3000))
chart = StripChart(timed=False)
chart.resize(1021, 421)
chart.set_layout(default_layout(CHANNELS))
chart.set_recording(True)
chart.show()
chart.set_history(history)
for name, time in (("cursor", 20.0), ("a", 22.0), ("b", 25.0)):
    chart.navigator.set_cursor(name, time)
chart.navigator.set_window(30.0)
chart.advance()
app.processEvents()

class Watch(QObject):
    regions = []
    def eventFilter(self, watched, event):
        if event.type() == QEvent.Type.Paint:
            self.regions.append(event.region())
        return False

watch = Watch()
chart.installEventFilter(watch)
density = chart.devicePixelRatioF()

def image():
    made = QImage(chart.size() * density, QImage.Format.Format_RGB32)
    made.setDevicePixelRatio(density)
    return made

kept = image()
chart.render(kept)
several = 0
for number in range(40):
    history.append(rows(30.0 + 0.05 * number, 5))
    chart._values_read_at = -math.inf if number % 3 == 0 else math.inf
    if number == 30:
        chart.navigator.toggle_pause()
    watch.regions.clear()
    chart.advance()
    app.processEvents()
    for region in list(watch.regions):
        several += region.rectCount() > 1
        chart.render(kept, region.boundingRect().topLeft(), region)
chart._values_read_at = math.inf
anew = image()
chart.render(anew)

def pixels(one):
    found = np.frombuffer(bytes(one.constBits()), dtype=np.uint32)
    return found.reshape(one.height(), -1)[:, : one.width()]

print(density, several, int((pixels(kept) != pixels(anew)).sum()))
"""


@pytest.mark.parametrize("density", [1.0, 1.25, 1.5])
def test_parts_painted_by_turns_equal_the_whole_at_any_density(density):
    """Proves that a frame that paints only what changed leaves every other pixel as it should be.

    Where a pixel of the design is no whole number of pixels of the screen, parts share some.
    """
    found = run_at_density(PARTS_SCRIPT, density)
    shown, several, wrong = found.split()
    assert float(shown) == pytest.approx(density)
    assert int(several) > 10
    assert int(wrong) == 0


DENSITY_SCRIPT = """
import math, sys
import numpy as np
from PySide6.QtWidgets import QApplication, QWidget
from PySide6.QtGui import QImage
from gsapp.quantities import Block
from gsapp.session.sample_history import SampleHistory
from ui.strips.strip_chart import StripChart
from ui.strips.strip_layout import default_layout

app = QApplication([])
t = np.arange(3000) / 100.0
history = SampleHistory(("alpha", "q"), 100.0)
history.append(Block(channels=("alpha", "q"), times=t,
    values=np.column_stack((0.1 * np.sin(t), 0.1 * np.sign(np.sin(3 * t))))))
parent = QWidget()
parent.resize(701, 461)
chart = StripChart(parent, timed=False)
chart.setGeometry(37, 23, 651, 421)
chart.set_layout(default_layout(("alpha", "q")))
parent.show()
chart.set_history(history)
for number in range(4):
    app.processEvents()
    history.append(Block(channels=("alpha", "q"), times=30.0 + 0.1 * number + np.arange(10) / 100.0,
        values=np.full((10, 2), 0.02 * number)))
    chart.advance()
app.processEvents()
image = parent.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
density = chart.devicePixelRatioF()
pixels = np.frombuffer(image.constBits(), dtype=np.uint32)
pixels = pixels.reshape(image.height(), image.bytesPerLine() // 4)[:, : image.width()]
raster, plot = chart.raster.raster, chart.geometry_in_pixels.plot
seam = chart.view.columns[0] % raster.width
shown = np.concatenate((raster.pixels[:, seam:], raster.pixels[:, :seam]), axis=1)
left, top = round(37 * density) + plot.x, round(23 * density) + plot.y
part = pixels[top : top + plot.height, left : left + plot.width]
print(density, raster.width, int((part != shown).sum()), raster.reach)
"""


@pytest.mark.parametrize(("density", "reach"), [(1.25, 1), (2.0, 2), (3.0, 3)])
def test_screens_of_any_density_show_every_pixel_exactly(density, reach):
    found = run_at_density(DENSITY_SCRIPT, density)
    shown, width, wrong, found_reach = found.split()
    assert float(shown) == pytest.approx(density)
    assert int(width) > 300 * density
    assert int(wrong) == 0
    assert int(found_reach) == reach


def test_the_wheel_over_a_value_axis_scales_that_chart_alone(qtbot, strips):
    geometry = strips.geometry_in_pixels
    box = geometry.charts[2]
    x, y = geometry.plot.x - 5, box.y + box.height // 4
    before = {number: (chart.low, chart.high) for number, chart in strips.charts.items()}
    strips._mouse.select_at(QPointF(x, y))
    value, window = strips._mouse.value_at(y), strips.view.seconds
    wheel(strips, x, y, 120)
    settle(qtbot, strips)
    low, high = strips.charts[2].low, strips.charts[2].high
    assert high - low == pytest.approx((before[2][1] - before[2][0]) / 1.25)
    assert strips._mouse.value_at(y) == pytest.approx(value)
    assert strips.view.seconds == window
    for number in (0, 1, 3):
        assert (strips.charts[number].low, strips.charts[number].high) == before[number]
    qtbot.mousePress(strips, Qt.MouseButton.LeftButton, pos=QPoint(x, y))
    qtbot.mouseMove(strips, QPoint(x, y + 10))
    settle(qtbot, strips)
    qtbot.mouseRelease(strips, Qt.MouseButton.LeftButton, pos=QPoint(x, y + 10))
    assert strips.charts[2].low > low
    assert strips.charts[2].high - strips.charts[2].low == pytest.approx(high - low)
    assert "cursor" not in strips.view.cursors
    qtbot.mouseDClick(strips, Qt.MouseButton.LeftButton, pos=QPoint(x, y))
    settle(qtbot, strips)
    assert strips.charts[2].strip.range == "auto"
    assert not strips.view.enlarged


def test_alarms_stand_above_the_charts_and_on_their_own(qtbot, strips):
    strips.set_alarms([AlarmSpan(start=52.0, stop=54.0, state="warning", channel="q")])
    settle(qtbot, strips)
    pixels, geometry = pixels_of(image_of(strips)), strips.geometry_in_pixels
    plot, lane = geometry.plot, geometry.lane
    first, last = (plot.x + strips.view.x(time) for time in (52.0, 54.0))
    fill = int(DAYLIGHT.warning_fill[1:], 16) | 0xFF000000
    for row in (lane.bottom - 1, geometry.charts[2].y):
        line = np.flatnonzero(pixels[row, plot.x : plot.right] == fill)
        assert abs(line[0] + plot.x - first) <= 5
        assert line[-1] + plot.x == last
    other = pixels[geometry.charts[1].y, plot.x : plot.right]
    assert not (other == fill).any()
