"""Which of several sources gives each row, and what the choice keeps in memory."""

from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from gsapp.decoding.grid import Grid
from gsapp.decoding.gridder import Gridder
from gsapp.decoding.source_selection import SourceSelector


def pairs_of(ends: Sequence[float]) -> Iterator[tuple[float, float]]:
    return zip(ends[::2], ends[1::2], strict=True)


def chosen(*told: tuple[float, ...], end: float, every: float) -> dict[int, float]:
    """Return the rows that come of sources which tell their number between pairs of times (s).

    The better first, each ten times a second; who decides is asked every so many seconds.
    """
    grid = Grid(100.0)
    flags = np.zeros(1, dtype=bool)
    sources = [Gridder(grid, circular=flags, stepwise=flags) for _ in told]
    merger = SourceSelector(grid, sources, 1, 1_000_000)
    found: dict[int, float] = {}

    def ask(now: int, *, final: bool = False) -> None:
        for rows in merger.pull(0, now, final=final):
            assert not set(found) & set(range(rows.first, rows.end)), "told twice"
            found.update(zip(range(rows.first, rows.end), rows.values[:, 0].tolist(), strict=True))

    for tenth in range(round(10 * end)):
        now = 100_000 * tenth
        for number, ends in enumerate(told):
            if any(begin <= tenth / 10 <= until for begin, until in pairs_of(ends)):
                fed = sources[number].feed([now], [now], np.array([[float(number)]]))
                merger.push(number, fed)
        if tenth % round(10 * every) == 0:
            ask(now)
    ask(round(1e6 * end), final=True)
    return found


@pytest.mark.parametrize("every", [0.1, 0.7, 100.0])
def test_there_are_no_rows_before_the_first_sample(every: float) -> None:
    found = chosen((1.5, 4.0), end=4.0, every=every)
    assert sorted(found) == list(range(150, 391))
    assert set(found.values()) == {0.0}


@pytest.mark.parametrize("every", [0.1, 0.7, 100.0])
def test_a_better_source_that_begins_late_leaves_what_stood_before_it(every: float) -> None:
    found = chosen((3.0, 6.0), (0.0, 6.0), end=6.0, every=every)
    assert [found[row] for row in range(300)] == [1.0] * 300
    assert [found[row] for row in range(300, 591)] == [0.0] * 291


@pytest.mark.parametrize("every", [0.1, 100.0])
def test_a_better_source_that_comes_in_time_has_the_place_from_the_beginning(every: float) -> None:
    """Before its first sample there is nothing; what a worse one told would make a step."""
    found = chosen((0.5, 4.0), (0.0, 4.0), end=4.0, every=every)
    assert sorted(found) == list(range(50, 391))
    assert set(found.values()) == {0.0}


@pytest.mark.parametrize("every", [0.1, 100.0])
def test_a_pause_of_all_sources_is_rows_without_a_number_up_to_a_minute(every: float) -> None:
    for pause, filled in ((10.0, True), (70.0, False)):
        back = 2.0 + pause
        spans = (0.0, 2.0, back, back + 2.0)
        found = chosen(spans, spans, end=back + 2.0, every=every)
        known = {row for row, value in found.items() if value == 0.0}
        first, again = round(100 * back), round(100 * back) + 191
        assert known == {*range(201), *range(first, again)}
        assert (set(range(201, first)) <= set(found)) == filled
        assert set(found) <= set(range(again))


def test_the_rows_of_a_source_that_nobody_asks_are_not_kept() -> None:
    grid = Grid(100.0)
    flags = np.zeros(1, dtype=bool)
    sources = [Gridder(grid, circular=flags, stepwise=flags) for _ in range(2)]
    merger = SourceSelector(grid, sources, 1, 1_000_000)
    most = decided = 0
    for k in range(4_000):
        now = 10_000 * k
        for number, every in ((0, 1), (1, 10)):
            if k % every == 0:
                merger.push(number, sources[number].feed([now], [now], np.array([[float(number)]])))
        decided += sum(len(rows.values) for rows in merger.pull(0, now))
        most = max(most, merger.pending_count)
    assert decided == 4_000
    assert most <= 2
