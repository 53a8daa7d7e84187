"""Derivatives of a flight being watched: as it goes on, in a replay, and headless, the same."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import pytest

from gsapp.flight.writers import write_block
from gsapp.session import Session
from gsapp.session.live_estimation.estimate_table import EstimateRow
from gsapp.session.live_estimation.fit_workers import FitWorker, InlineFitWorker, ProcessFitWorker
from gsapp.session.replay_runner import run_replay
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.session.test_maneuver_fits import TRUTH, numbers


@pytest.fixture(scope="module")
def path(
    tmp_path_factory: pytest.TempPathFactory, flown_short: Callable[[int], VirtualFlight]
) -> Path:
    flown = flown_short(6).measured
    return write_block(tmp_path_factory.mktemp("estimates") / "flight.csv", flown, "csv")


@dataclass
class Watched:
    """A flight watched to its end, and what was known of it when 30 s had gone by."""

    session: Session
    early: dict[str, EstimateRow]

    @classmethod
    def of(cls, path: Path, workers: FitWorker) -> Self:
        session = Session.replay(path, aircraft="b777", model="b777", speed=np.inf, workers=workers)
        early: dict[str, EstimateRow] = {}

        def look(_share: float) -> None:
            if not early and (session.now or 0.0) >= 30.0:
                early.update(rows_of(session))

        run_replay(session, look)
        return cls(session, early)


def rows_of(session: Session) -> dict[str, EstimateRow]:
    return {row.name: row for row in session.estimates.rows()}


@pytest.fixture(scope="module")
def at_once(path: Path) -> Iterator[Watched]:
    watched = Watched.of(path, InlineFitWorker())
    yield watched
    watched.session.close()


def test_a_replay_finds_the_truth(at_once: Watched) -> None:
    rows = rows_of(at_once.session)
    assert len(at_once.session.estimates.result.results) == 2
    for name in ("Cl_da", "Cn_dr", "Cm_de"):
        mean, std = rows[name].best or (np.nan, np.nan)
        true = TRUTH.derivative(name)
        assert abs(mean - true) < max(4.0 * std, 0.04 * abs(true))
        assert rows[name].prior == true
    assert len(rows["Cm_de"].points) == 1
    assert "Cm_0" not in rows


@pytest.mark.long
def test_a_replay_gives_the_same_numbers_wherever_fits_run(at_once: Watched, path: Path) -> None:
    elsewhere = Watched.of(path, ProcessFitWorker())
    found = [
        (
            numbers(session.estimates.result),
            [(row.value, row.std) for row in rows_of(session).values()],
        )
        for session in (at_once.session, elsewhere.session)
    ]
    assert found[0] == found[1]
    elsewhere.session.close()


def test_unknown_until_earned_and_what_changed_is_said(at_once: Watched) -> None:
    session = at_once.session
    estimates = session.estimates
    assert at_once.early
    assert all(row.best is None or row.points for row in at_once.early.values())
    late = rows_of(session)
    assert late["Cn_dr"].change_text
    assert late["Cn_dr"].percent < 10.0
    feed = session.replay_feed
    feed.seek(feed.start or 0.0)
    session.update()
    assert estimates.result.results == ()


def test_without_workers_or_aircraft_nothing_is_estimated(path: Path) -> None:
    plain = Session.replay(path, aircraft="b777")
    assert plain.estimates is None
    plain.close()
