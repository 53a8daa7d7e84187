"""Strip charts on paper show what the block holds, gaps as gaps, in the units asked for."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.image import imread

from gsapp.quantities import Block
from gsapp.report.plot_elements import format_clock_axis
from gsapp.report.strip_figure import write_strip_figure


def block() -> Block:
    times = np.arange(0.0, 60.0, 0.01)
    alpha = np.where(times < 30.0, 0.05, np.nan)
    return Block(
        channels=("alpha", "q"), times=times, values=np.column_stack([alpha, np.sin(times)])
    )


def traces(path: Path) -> np.ndarray:
    picture = imread(path)
    return picture[:, :, 2] - picture[:, :, 0] > 0.25


def test_a_gap_is_left_empty(tmp_path: Path) -> None:
    path = write_strip_figure(
        block(), ["alpha", "q", "absent"], tmp_path / "charts.png", title="Flight"
    )
    drawn = traces(path)
    rows = np.flatnonzero(drawn.any(axis=1))
    # alpha is one level line, the first trace from above; q fills the chart below it.
    columns = np.flatnonzero(drawn.any(axis=0))
    half = (int(columns[0]) + int(columns[-1])) // 2
    upper, lower = drawn[: rows[0] + 4], drawn[rows[0] + 4 :]
    assert upper[:, :half].sum() > 100
    # alpha ends at half time, q goes on to the end
    assert upper[:, half + 5 :].sum() == 0
    assert lower[:, half + 5 :].sum() > 100


def test_svg_and_pdf_are_written_too(tmp_path: Path) -> None:
    assert write_strip_figure(block(), ["q"], tmp_path / "a.svg").read_bytes().startswith(b"<?xml")
    assert write_strip_figure(block(), ["q"], tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(("units", "unit"), [("US", "ft/s"), ("SI", "m/s")])
def test_values_are_drawn_in_the_units_asked_for(tmp_path: Path, units: str, unit: str) -> None:
    speeds = Block(channels=("V",), times=np.arange(100.0), values=np.full((100, 1), 30.48))
    with rc_context({"svg.fonttype": "none"}):
        page = write_strip_figure(speeds, ["V"], tmp_path / "v.svg", units=units).read_text()
    assert unit in page
    assert {"m/s": "ft/s", "ft/s": "m/s"}[unit] not in page


def test_time_axes_are_clocks_with_ticks_at_round_times() -> None:
    figure = Figure()
    chart = figure.subplots()
    format_clock_axis(chart)
    ticks = {}
    for low, high in ((0.0, 600.0), (96.2, 101.4), (96.20, 96.35)):
        chart.set_xlim(low, high)
        ticks[low, high] = chart.xaxis.get_major_formatter().format_ticks(chart.get_xticks())
    figure.canvas.draw()
    assert ticks[0.0, 600.0] == [f"{minute:02d}:00.0" for minute in range(0, 11, 2)]
    assert ticks[96.2, 101.4] == ["01:38.0", "01:40.0"]
    shown = [label.get_text() for label in chart.get_xticklabels()]
    assert shown == ["01:36.20", "01:36.25", "01:36.30", "01:36.35"]
