"""Strip charts on paper show what the block holds, gaps as gaps, in the units asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.image import imread

from gsapp.quantities import Block
from gsapp.report.strip_figure import minutes, strip_figure


def block() -> Block:
    times = np.arange(0.0, 60.0, 0.01)
    alpha = np.where(times < 30.0, 0.05, np.nan)
    return Block(
        channels=("alpha", "q"), times=times, values=np.column_stack([alpha, np.sin(times)])
    )


def traces(path: Path) -> np.ndarray:
    """Return where the picture is as blue as traces are, shape (rows, columns)."""
    picture = imread(path)
    return picture[:, :, 2] - picture[:, :, 0] > 0.25


def test_a_gap_is_left_empty(tmp_path: Path) -> None:
    path = strip_figure(block(), ["alpha", "q", "absent"], tmp_path / "charts.png", title="Flight")
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
    assert strip_figure(block(), ["q"], tmp_path / "a.svg").read_bytes().startswith(b"<?xml")
    assert strip_figure(block(), ["q"], tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")


def test_time_is_read_in_minutes() -> None:
    assert [minutes(time) for time in (0.0, 59.9, 61.0, -5.0)] == ["0:00", "0:59", "1:01", "-0:05"]
