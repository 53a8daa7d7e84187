"""Figures of a run: where points are drawn, what they are called, colors, numbers, files."""

import csv
import io
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from gsapp.foundation import GroundStationError
from gsapp.identification import equation_error, ftr
from gsapp.identification.ftr import EstimateHistory
from gsapp.identification.runs.run_execution import exclude_maneuvers
from gsapp.identification.summary import summarize_campaign
from gsapp.identification.summary.mode_uncertainty import propagate_mode_uncertainty
from gsapp.quantities import TRACE_COLORS
from gsapp.report.document import DocumentFigure, figure_style, render_png
from gsapp.report.document_writer import export_figure
from gsapp.report.fit_diagnostic_figures import bounds_figure, correlated_pairs, correlation_figure
from gsapp.report.fit_figures import autocorrelation, fit_figure, residual_figure
from gsapp.report.mode_figures import modes_figure, modes_table
from gsapp.report.online_figures import online_estimates_figure
from gsapp.report.palette import PRINT_PALETTE, Palette
from gsapp.report.plot_elements import DERIVATIVE_PREFIX, point_names
from gsapp.report.residual_text import residual_summaries
from gsapp.report.value_figures import value_figure
from tests.report.campaign_kit import WILD, outcome

NIGHT = Palette(
    background="#000000", ink="#ffffff", secondary_ink="#dddddd", faint="#222222",
    previous="#9a9a9a", band="#112233", excluded="#777777", line_scale=2.0,
    traces=dict(zip(TRACE_COLORS, ("#8ac6ff", "#ffa3d6", "#ffa875", "#ffffff", "#a8e0ff",
                                   "#fff04d"), strict=True)),
)  # fmt: skip


def drawn(picture: DocumentFigure, palette: Palette = PRINT_PALETTE) -> Figure:
    with figure_style(palette):
        figure = Figure(figsize=(7.1, picture.height), dpi=100)
        FigureCanvasAgg(figure)
        picture.draw(figure)
    return figure


def points_in(figure: Figure, name: str) -> dict[str, tuple[float, float, str]]:
    chart = next(one for one in figure.axes if one.get_gid() == DERIVATIVE_PREFIX + name)
    return {
        maneuver: (float(x), float(y), to_hex(line.get_color()))
        for line in chart.lines
        for maneuver, x, y in zip(point_names(line), *line.get_data(), strict=False)
    }


@pytest.mark.parametrize("over", ["number", "V", "alpha"])
def test_each_point_is_named_and_stands_at_its_value_and_condition(over: str) -> None:
    """Every maneuver once, at the value found, in its flight's color; the wild one gray."""
    summary = outcome().summary
    picture = value_figure(summary, ["Cm_alpha", "Cm_de"], over, units="SI")
    figure = drawn(picture)
    found = points_in(figure, "Cm_alpha")
    one = summary.derivatives["Cm_alpha"]
    assert set(found) == {point.maneuver for point in one.points}
    if over == "number":
        axis, numbers = figure.axes[0].xaxis, [point.number for point in one.points]
        step = -(-len(numbers) // 5)
        np.testing.assert_array_equal(axis.get_majorticklocs(), numbers[::step])
        near = [number for number in numbers if abs(number - numbers[0]) <= 2]
        np.testing.assert_array_equal(
            axis.get_major_locator().tick_values(numbers[0], numbers[0] + 2), near
        )
    for point in one.points:
        if over == "number":
            # The axis calls maneuvers by their ids, as every table does.
            assert figure.axes[0].xaxis.get_major_formatter()(point.number) == point.maneuver
        x, y, color = found[point.maneuver]
        value = point.conditions.get(over, 0.0)
        assert x == pytest.approx(
            {"number": point.number, "V": value, "alpha": np.degrees(value)}[over]
        )
        if point.maneuver == WILD:
            assert color == PRINT_PALETTE.excluded
        else:
            assert y == pytest.approx(point.value)
            assert color == PRINT_PALETTE.flight(0 if point.flight == "A" else 1)


def test_names_of_maneuvers_do_not_lie_upon_one_another() -> None:
    found = outcome().result
    longer = ("1", "short one", "2:11", "a second try with less stick", "6")
    renamed = [
        replace(one, maneuver=replace(one.maneuver, id=name))
        for one, name in zip(found.results, longer, strict=False)
    ]
    summary = summarize_campaign(replace(found, results=tuple(renamed)))
    figure = drawn(value_figure(summary, ["Cm_alpha", "Cm_de", "Cm_q"], "number", units="SI"))
    figure.canvas.draw()
    boxes = [
        label.get_window_extent()
        for chart in figure.axes
        for label in chart.get_xticklabels()
        if label.get_text()
    ]
    assert len(boxes) >= 6
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


def test_a_maneuver_left_out_by_hand_stays_in_sight_and_moves_the_mean() -> None:
    before = outcome()
    after = exclude_maneuvers(before, {"1:M2"})
    figure = drawn(value_figure(after.summary, ["Cm_de"], "number"))
    one = after.summary.derivatives["Cm_de"]
    (point,) = one.excluded
    assert points_in(figure, "Cm_de")["1:M2"] == (
        2.0,
        pytest.approx(point.value),
        PRINT_PALETTE.excluded,
    )
    others = tuple(other for other in before.result.results if other.maneuver.id != "1:M2")
    alone = summarize_campaign(replace(before.result, results=others))
    for name, summary in after.summary.derivatives.items():
        assert summary.value == alone.derivatives[name].value
        assert summary.value != before.summary.derivatives[name].value
    again = exclude_maneuvers(after, ())
    assert again.summary.derivatives["Cm_de"].value == before.summary.derivatives["Cm_de"].value
    assert again.summary.excluded_maneuvers == frozenset()


def test_a_fit_that_did_not_converge_is_gray_and_counts_for_nothing() -> None:
    before = outcome().result
    estimate = before.results[2].estimate
    stopped = replace(before.results[2], estimate=replace(estimate, converged=False))
    rest = (*before.results[:2], *before.results[3:])
    summary = summarize_campaign(
        replace(before, results=(*before.results[:2], stopped, *before.results[3:]))
    )
    one = summary.derivatives["Cm_de"]
    assert one.value == summarize_campaign(replace(before, results=rest)).derivatives["Cm_de"].value
    picture = value_figure(summary, ["Cm_de"], "number")
    x, y, color = points_in(drawn(picture), "Cm_de")["1:M3"]
    assert (x, color) == (3.0, PRINT_PALETTE.excluded)
    assert y == pytest.approx(estimate.derivatives["Cm_de"].value)
    assert picture.numbers is not None
    (row,) = [row for row in picture.numbers().rows if row[1] == "1:M3"]
    assert row[-1] == "did not converge"


def test_pictures_take_every_color_from_the_palette() -> None:
    one = outcome().result.results[0]
    assert one.estimate is not None
    pictures = (
        value_figure(outcome().summary, ["Cm_de"], "V", palette=NIGHT),
        fit_figure(one, palette=NIGHT),
        bounds_figure(one.estimate, "it", palette=NIGHT),
    )
    paper = {
        *PRINT_PALETTE.traces.values(),
        PRINT_PALETTE.ink,
        PRINT_PALETTE.band,
        PRINT_PALETTE.faint,
        "#ffffff",
    }
    for picture in pictures:
        assert picture is not None
        canvas = drawn(picture, NIGHT).canvas
        assert isinstance(canvas, FigureCanvasAgg)
        with figure_style(NIGHT):
            canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[..., :3]
        counts = np.bincount((pixels @ np.array([65536, 256, 1])).ravel())
        shown = {f"#{color:06x}" for color in np.flatnonzero(counts > 40)}
        assert NIGHT.background in shown
        assert not shown & (paper - {NIGHT.ink, *NIGHT.traces.values()})


def test_fit_shows_another_run_in_gray_and_its_numbers_are_those_of_the_history() -> None:
    """Three lines of a response; the table holds measured and computed, in the units asked for."""
    one = outcome().result.results[0]
    picture = fit_figure(one, units="SI", other=one, other_name="before")
    figure = drawn(picture)
    colors = [to_hex(line.get_color()) for line in figure.axes[-1].lines]
    assert sorted(colors) == sorted(
        [PRINT_PALETTE.channel("an"), PRINT_PALETTE.ink, PRINT_PALETTE.previous]
    )
    assert picture.numbers is not None
    table = picture.numbers()
    (history,) = one.estimate.histories
    column = table.columns.index("q [deg/s] computed")
    told = np.array([float(row[column]) for row in table.rows])
    expected = np.degrees(history.computed[:, history.channels.index("q")])
    np.testing.assert_allclose(told, expected, rtol=1e-12)
    left = residual_figure(one, units="SI")
    assert left is not None
    chart = drawn(left).axes[2 * history.channels.index("q")]
    missed = np.degrees((history.measured - history.computed)[:, history.channels.index("q")])
    np.testing.assert_allclose(np.asarray(chart.lines[0].get_ydata()), missed)


@pytest.mark.parametrize("method", ["ee", "ftr"])
def test_methods_without_responses_show_coefficients_and_no_residuals(method: str) -> None:
    one = outcome().result.results[0]
    estimate = {"ee": equation_error, "ftr": ftr}[method].estimate([one.maneuver], "lon")
    fitted = replace(one, estimate=estimate)
    picture = fit_figure(fitted, units="US")
    assert "coefficients" in picture.caption
    lowest = drawn(picture).axes[-1]
    assert lowest.get_ylabel() == "$C_{m}$"
    (history,) = estimate.histories
    np.testing.assert_array_equal(lowest.lines[0].get_ydata(), history.measured[:, -1])
    assert picture.numbers is not None
    assert picture.numbers().columns[-2:] == ("Cm measured", "Cm computed")
    assert residual_figure(fitted) is None
    assert residual_summaries(replace(outcome().result, results=(fitted,))) == ()


def test_autocorrelation_tells_white_noise_from_what_repeats() -> None:
    generator = np.random.default_rng(3)
    _, white, band = autocorrelation(generator.standard_normal(4000), 0.01)
    assert 0.88 < np.mean(np.abs(white[1:]) < band) <= 1.0
    lags, wave, band = autocorrelation(np.sin(2 * np.pi * np.arange(4000) / 10), 0.01)
    assert lags[10] == pytest.approx(0.1)
    assert wave[10] > 0.95
    assert wave[5] < -0.95


def test_histories_carry_the_points_of_the_flight_alone() -> None:
    found = outcome()
    times = np.linspace(0.0, 60.0, 400)
    values = np.where(times > 20.0, -0.33, np.nan)
    history = EstimateHistory(
        name="Cm_alpha", times=times, values=values, stds=np.full(400, 0.01),
        signal_to_noise=np.full(400, 9.0),
    )  # fmt: skip
    unknown = replace(history, name="Cn_beta", values=np.full(400, np.nan))
    picture = online_estimates_figure([history, unknown], found.result, found.summary, "A", 1)
    figure = drawn(picture)
    points = points_in(figure, "Cm_alpha")
    ends = {one.maneuver.id: one.maneuver.t_end for one in found.result.results}
    assert {name: x for name, (x, _, _) in points.items()} == {
        f"1:M{k}": ends[f"1:M{k}"] for k in (1, 2, 3, 4)
    }
    texts = [text.get_text() for text in figure.axes[1].texts]
    assert any("unknown" in text for text in texts)
    low, high = figure.axes[0].get_ylim()
    assert low < -0.33 < high


def test_close_pairs_are_named_and_biases_are_not() -> None:
    estimate = outcome().result.results[0].estimate
    assert estimate is not None
    covariance = np.array([[1.0, -0.95, 0.99], [-0.95, 1.0, -0.2], [0.99, -0.2, 1.0]])
    made = replace(estimate, free=("Cm_q", "Cm_de", "Cm_0"), covariance=covariance)
    assert correlated_pairs(made) == (("Cm_q", "Cm_de", -0.95),)
    picture = correlation_figure(made, "maneuver 1")
    assert "Cm_q and Cm_de (-0.95)" in picture.caption
    assert len(drawn(picture).axes[0].patches) == 2


def test_modes_stray_as_far_as_a_moved_derivative_moves_them() -> None:
    """Short period: a smaller bound of Cm_alpha alone lets its frequency stray less."""
    found = outcome()
    modes = propagate_mode_uncertainty(found.result, found.summary, "lon")
    assert {"short period"} <= {one.mode.name for one in modes}
    short = next(one for one in modes if one.mode.name == "short period")
    assert 0.0 < short.frequency_std < 0.1 * short.mode.frequency
    summaries = dict(found.summary.derivatives)
    for name in ("Cm_alpha", "Cm_q"):
        value = replace(summaries[name].value, std=0.2 * summaries[name].value.std)
        summaries[name] = replace(summaries[name], value=value)
    narrower = propagate_mode_uncertainty(
        found.result, replace(found.summary, derivatives=summaries), "lon"
    )
    other = next(one for one in narrower if one.mode.name == "short period")
    assert other.mode == short.mode
    assert 0.0 < other.frequency_std < 0.5 * short.frequency_std
    table = modes_table({"longitudinal": modes}, "SI")
    assert table.rows[0][2] == "short period"
    assert "±" in table.rows[0][3]
    # Frequencies go with speed: without it they say nothing.
    about = found.models["lon"].operating_point
    assert table.columns[1] == "V [m/s]"
    assert table.rows[0][1] == f"{about.speed:.1f}"
    assert 25.0 < about.speed < 40.0
    grows = replace(short, mode=replace(short.mode, pole=-short.mode.pole))
    still = replace(short, mode=replace(short.mode, pole=complex(1e-6)))
    said = [row[-1] for row in modes_table({"longitudinal": (grows, still)}, "SI").rows]
    assert said == [f"{table.rows[0][-1]} (grows)", "neutral"]
    figure = drawn(modes_figure({"longitudinal": modes}))
    poles = {
        (round(float(line.get_xdata()[0]), 6), round(float(line.get_ydata()[0]), 6))
        for line in figure.axes[0].lines
        if len(line.get_xdata()) == 1
    }
    assert (round(short.mode.pole.real, 6), round(short.mode.pole.imag, 6)) in poles


def test_a_picture_is_saved_the_same_each_time_and_its_numbers_are_read_back() -> None:
    picture = value_figure(outcome().summary, ["Cm_alpha"], "alpha")
    for ending in (".png", ".pdf", ".svg"):
        one, other = (export_figure(picture, ending) for _ in "ab")
        assert one == other
        assert len(one) > 1000
    assert export_figure(picture, ".png") == render_png(picture)
    text = export_figure(picture, ".csv").decode()
    rows = list(csv.DictReader(io.StringIO(text)))
    told = {(row["derivative"], row["maneuver"]): float(row["value"]) for row in rows}
    assert told == {
        ("Cm_alpha", point.maneuver): point.value
        for point in outcome().summary.derivatives["Cm_alpha"].points
    }
    assert {row["maneuver"] for row in rows if row["left out"] == "outlier"} == {WILD}
    assert export_figure(picture, ".tsv").count(b"\t") > len(rows)
    with pytest.raises(GroundStationError, match="ends in"):
        export_figure(picture, ".doc")
