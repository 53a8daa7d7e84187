"""Which of several sources gives each row, and what the choice keeps in memory."""

from __future__ import annotations

import numpy as np
import pytest

from gsapp.decoding.grid import Grid
from gsapp.decoding.gridder import Gridder
from gsapp.decoding.merging import Merger


def chosen(*told: tuple[float, float], end: float, every: float) -> dict[int, float]:
    """Return the rows that come of sources which tell their number from one time to another (s).

    The better first, each ten times a second; who decides is asked every so many seconds.
    """
    grid = Grid(100.0)
    flags = np.zeros(1, dtype=bool)
    sources = [Gridder(grid, circular=flags, stepwise=flags) for _ in told]
    merger = Merger(grid, sources, 1, 1_000_000)
    found: dict[int, float] = {}

    def ask(now: int, *, final: bool = False) -> None:
        for rows in merger.pull(0, now, final=final):
            assert not set(found) & set(range(rows.first, rows.end)), "told twice"
            found.update(zip(range(rows.first, rows.end), rows.values[:, 0].tolist(), strict=True))

    for tenth in range(round(10 * end)):
        now = 100_000 * tenth
        for number, (begin, until) in enumerate(told):
            if begin <= tenth / 10 <= until:
                fed = sources[number].feed([now], [now], np.array([[float(number)]]))
                merger.push(number, fed)
        if tenth % round(10 * every) == 0:
            ask(now)
    ask(round(1e6 * end), final=True)
    return found


@pytest.mark.parametrize("every", [0.1, 0.7, 100.0])
def test_there_are_no_rows_before_the_first_sample(every: float) -> None:
    """A channel begins where it begins, not with the record and nothing in it."""
    found = chosen((1.5, 4.0), end=4.0, every=every)
    assert sorted(found) == list(range(150, 391))
    assert set(found.values()) == {0.0}


@pytest.mark.parametrize("every", [0.1, 0.7, 100.0])
def test_a_better_source_that_begins_late_leaves_what_stood_before_it(every: float) -> None:
    """However seldom it is asked: what comes of a record depends on nothing but the record."""
    found = chosen((3.0, 6.0), (0.0, 6.0), end=6.0, every=every)
    assert [found[row] for row in range(300)] == [1.0] * 300
    assert [found[row] for row in range(300, 591)] == [0.0] * 291


def test_the_rows_of_a_source_that_nobody_asks_are_not_kept() -> None:
    """Of two sources, the better one always there, only what is undecided is held."""
    grid = Grid(100.0)
    flags = np.zeros(1, dtype=bool)
    sources = [Gridder(grid, circular=flags, stepwise=flags) for _ in range(2)]
    merger = Merger(grid, sources, 1, 1_000_000)
    most = decided = 0
    for k in range(4_000):
        now = 10_000 * k
        for number, every in ((0, 1), (1, 10)):
            if k % every == 0:
                merger.push(number, sources[number].feed([now], [now], np.array([[float(number)]])))
        decided += sum(len(rows.values) for rows in merger.pull(0, now))
        most = max(most, merger.waiting)
    assert decided == 4_000
    assert most <= 2
