"""What a choice among sources keeps in memory."""

from __future__ import annotations

import numpy as np

from gsapp.decoding.grid import Grid
from gsapp.decoding.gridder import Gridder
from gsapp.decoding.merging import Merger


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
