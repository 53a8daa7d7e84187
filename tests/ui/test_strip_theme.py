"""Themes: readable in the sun, colors kept apart, figures of equal width."""

import pytest

from gsapp.quantities import TRACE_COLORS
from ui.display_style import has_tabular_figures, sans_serif_font
from ui.theme import DARK, DAYLIGHT, HIGH_CONTRAST, THEMES, compute_sizes, contrast

READ = ("text", "muted", "good", "caution", "warning", *(f"traces.{name}" for name in TRACE_COLORS))


def test_contrast_is_that_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#123456", "#123456") == pytest.approx(1.0)
    assert contrast("#767676", "#ffffff") == pytest.approx(4.54, abs=0.01)


@pytest.mark.parametrize("theme", [DAYLIGHT, HIGH_CONTRAST, DARK], ids=lambda theme: theme.name)
def test_text_stands_out_from_its_background(theme):
    colors = dict(theme.colors())
    least = 4.5 if theme is DARK else 7.0
    for name in READ:
        for behind in (theme.background, theme.plot):
            assert contrast(colors[name], behind) >= least, (theme.name, name)
    for state in ("caution", "warning"):
        # As alarms are told in the bar, and errors in banners.
        assert contrast(colors[state], colors[f"{state}_band"]) >= least, (theme.name, state)
        assert contrast(theme.text, colors[f"{state}_band"]) >= least
    assert contrast(theme.banner_text, theme.banner) >= 7.0
    for fill in (theme.good_fill, theme.caution_fill, theme.warning_fill):
        assert contrast(theme.fill_text, fill) >= least


@pytest.mark.parametrize("theme", THEMES.values(), ids=lambda theme: theme.name)
def test_traces_stand_out_from_every_area_behind_them(theme):
    for name in TRACE_COLORS:
        for behind in (theme.caution_band, theme.warning_band, theme.span, theme.event):
            assert contrast(theme.trace(name), behind) >= 4.5, (theme.name, name, behind)


@pytest.mark.parametrize("theme", THEMES.values(), ids=lambda theme: theme.name)
def test_no_trace_takes_the_color_of_a_state(theme):
    states = {theme.good, theme.caution, theme.warning, theme.target, theme.caution_fill}
    traces = list(theme.traces.values())
    assert not states & set(traces)
    assert len(set(traces)) == len(TRACE_COLORS)
    assert theme.trace("previous") == theme.previous


def test_every_theme_names_the_same_colors():
    names = {tuple(name for name, _ in theme.colors()) for theme in THEMES.values()}
    assert len(names) == 1
    for theme in THEMES.values():
        assert all(len(color) == 7 for _, color in theme.colors())


def test_all_sizes_grow_together_and_stay_within_bounds():
    assert (
        compute_sizes(1.0).body,
        compute_sizes(1.0).label,
        compute_sizes(1.0).value,
        compute_sizes(1.0).cue,
    ) == (13, 11, 18, 72)
    assert compute_sizes(2.0).control == 2 * compute_sizes(1.0).control
    assert compute_sizes(9.0).scale == 2.5
    assert compute_sizes(0.1).scale == 1.0


def test_figures_are_equally_wide(qapp):
    for pixels in (11, 18, 36):
        assert has_tabular_figures(sans_serif_font(pixels))
        assert has_tabular_figures(sans_serif_font(pixels, bold=True))
        assert has_tabular_figures(sans_serif_font(pixels, italic=True))
