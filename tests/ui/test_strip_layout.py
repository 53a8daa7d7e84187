"""Layouts: what they hold, what their files say, what is wrong with a file."""

import json
import math

import pytest

from gsapp.foundation import FileProblemsError
from gsapp.quantities import channel
from gsapp.session.limits import LimitBands
from ui.strips.chart_state import create_chart, create_chart_paint, parse_rgb
from ui.strips.strip_layout import (
    Strip,
    StripGroup,
    StripLayout,
    Trace,
    default_layout,
    load_layout,
    save_layout,
)
from ui.theme import THEMES, contrast

LAYOUT = StripLayout(
    name="Stalls",
    window=120.0,
    groups=(
        StripGroup(
            name="Pitch",
            strips=(
                Strip(
                    traces=(
                        Trace(channel="elevator_left"),
                        Trace(channel="elevator_right", style="computed", color="rust"),
                    ),
                    height=2.0,
                ),
                Strip(
                    traces=(Trace(channel="alpha"),),
                    range="fixed",
                    low=math.radians(-5.0),
                    high=math.radians(20.0),
                ),
            ),
        ),
        StripGroup(
            name="Air",
            strips=(
                Strip(traces=(Trace(channel="V"),), range="limits"),
                Strip(traces=(Trace(channel="temperature"),), range="fixed", low=270.0, high=300.0),
            ),
        ),
    ),
)


def test_a_layout_survives_its_file(tmp_path):
    path = save_layout(tmp_path / "stalls.toml", LAYOUT)
    text = path.read_text(encoding="utf-8")
    assert 'low = "-5 deg"' in text
    read = load_layout(path)
    again = StripLayout.model_validate(json.loads(json.dumps(LAYOUT.to_dict())))
    for found in (read, again):
        assert found.channels == LAYOUT.channels
        for one, other in zip(found.strips, LAYOUT.strips, strict=True):
            assert one.traces == other.traces
            assert (one.range, one.height) == (other.range, other.height)
            if other.low is not None:
                assert one.low == pytest.approx(other.low)
                assert one.high == pytest.approx(other.high)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[[groups]]\n[[groups.strips]]\nchannel = "alfa"\n', "alpha"),
        ('[[groups]]\n[[groups.strips]]\nchannel = "q"\nrange = "fixed"\n', "low and high"),
        (
            '[[groups]]\n[[groups.strips]]\nchannel = "q"\nrange = "fixed"\n'
            'low = "1 ft"\nhigh = "2 ft"\n',
            "unit of angular rate",
        ),
        ('[[groups]]\n[[groups.strips]]\nchannel = "q"\ncolor = "green"\n', "trace color"),
        (
            '[[groups]]\n[[groups.strips]]\ntraces = [{channel = "q"}, {channel = "alpha"}]\n',
            "own chart",
        ),
        ("[[groups]]\nstripes = []\n", "strips"),
    ],
)
def test_a_mistake_in_a_file_is_named(tmp_path, text, words):
    path = tmp_path / "bad.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileProblemsError, match=words):
        load_layout(path)


def test_charts_move_within_groups_and_across_them():
    moved = LAYOUT.with_strip_moved(0, 1)
    assert [strip.channel for strip in moved.groups[0].strips] == ["alpha", "elevator_left"]
    crossed = LAYOUT.with_strip_moved(1, 1)
    assert [strip.channel for strip in crossed.groups[1].strips] == ["alpha", "V", "temperature"]
    back = crossed.with_strip_moved(1, -1)
    assert back == LAYOUT
    assert LAYOUT.with_strip_moved(0, -1) == LAYOUT
    assert LAYOUT.with_strip_moved(3, 1) == LAYOUT


def test_lines_of_one_chart_differ_and_previous_ones_can_still_be_read():
    traces = (
        Trace(channel="q"),
        Trace(channel="r", style="computed"),
        Trace(channel="p", style="previous"),
    )
    for theme in THEMES.values():
        chart = create_chart(Strip(traces=traces), theme, "SI", None)
        assert len(set(chart.colors)) == 3
        assert chart.dashed == (False, True, False)
        assert chart.colors[2] == theme.previous
        assert all(contrast(ink, theme.background) >= 7.0 for ink in chart.text_colors[2:])
        dashes = [
            [one.dash for one in create_chart_paint(chart, 0, 9, theme, x).traces] for x in (1, 2)
        ]
        assert dashes[0][::2] == dashes[1][::2] == [0, 0]
        assert dashes[1][1] == 2 * dashes[0][1] > 0


def test_a_line_has_the_color_of_its_channel_unless_it_asks_for_another():
    theme = THEMES["daylight"]

    def colors(names, *asked):
        traces = tuple(
            Trace(channel=name, color=color) for name, color in zip(names, asked, strict=True)
        )
        return create_chart(Strip(traces=traces), theme, "SI", None).colors

    assert colors("r", "blue") == (theme.trace("blue"),)
    assert colors("pqr", None, None, None) == tuple(map(theme.trace, ("purple", "blue", "rust")))
    # Nobody else has a color that was asked for, and two lines of one family differ.
    assert theme.trace("blue") not in colors("qrp", None, "blue", None)[::2]
    assert len(set(colors(("elevator_left", "elevator_right"), None, None))) == 2


def test_the_range_of_an_axis_is_the_one_asked_for():
    theme = THEMES["daylight"]

    def ends(mode, limits=None):
        strip = Strip(traces=(Trace(channel="alpha"),), range=mode, low=-0.1, high=0.2)
        chart = create_chart(strip, theme, "SI", limits)
        return [math.radians(chart.low), math.radians(chart.high)]

    assert ends("fixed") == pytest.approx([-0.1, 0.2])
    assert ends("auto") != pytest.approx([-0.1, 0.2])
    bands = LimitBands(caution_low=-0.1, caution_high=0.2, warning_high=0.3)
    assert ends("limits", bands) == pytest.approx([-0.1 - 0.15 * 0.4, 0.3 + 0.15 * 0.4])
    assert ends("limits") == pytest.approx(list(channel("alpha").limits))
    # No farther than anything can be.
    low, high = channel("alpha").limits
    wide = LimitBands(caution_low=low, caution_high=0.2, warning_high=high)
    assert ends("limits", wide) == pytest.approx([low, high])
    # One limit alone makes no range.
    assert ends("limits", LimitBands(caution_high=0.2)) == ends("limits")


def test_every_limit_is_a_band_from_itself_outward():
    theme = THEMES["dark"]

    def bands(**limits):
        chart = create_chart(Strip(traces=(Trace(channel="q"),)), theme, "SI", LimitBands(**limits))
        return {
            (band.low, band.high, band.fill)
            for band in create_chart_paint(chart, 0, 50, theme, 1).bands
        }

    caution, warning = parse_rgb(theme.caution_band), parse_rgb(theme.warning_band)
    assert bands(warning_low=-4.0, caution_low=-3.0, caution_high=1.0, warning_high=2.0) == {
        (-4.0, -3.0, caution), (1.0, 2.0, caution),
        (-math.inf, -4.0, warning), (2.0, math.inf, warning),
    }  # fmt: skip
    assert bands(caution_low=-3.0, caution_high=1.0) == {
        (-math.inf, -3.0, caution), (1.0, math.inf, caution)
    }  # fmt: skip
    assert bands(warning_low=-4.0) == {(-math.inf, -4.0, warning)}
    assert bands(warning_high=2.0) == {(2.0, math.inf, warning)}
    assert bands() == set()


def test_sixteen_charts_by_default_for_what_the_flight_has():
    assert len(default_layout().strips) == 16
    thin = default_layout(("elevator_left", "alpha", "q", "qbar", "throttle", "alpha_volts"))
    shown = {strip.channel for strip in thin.strips}
    assert shown == {"elevator_left", "alpha", "q", "qbar", "throttle"}
    volts = default_layout(("alpha_volts", "q_volts"))
    assert {strip.channel for strip in volts.strips} == {"alpha_volts", "q_volts"}
