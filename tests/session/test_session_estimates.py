"""Derivatives of a flight being watched: as it goes on, in a replay, and headless, the same."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from test_maneuver_fits import TRUTH, measured, numbers

from gsapp.flight.writers import write_block
from gsapp.session import Session
from gsapp.session.estimating.workers import AtOnce, OtherProcess, Workers
from gsapp.session.running import run_through


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_block(tmp_path_factory.mktemp("estimates") / "flight.csv", measured()[0], "csv")


def watched(path: Path, workers: Workers) -> Session:
    return Session.replay(path, aircraft="b777", model="b777", speed=np.inf, workers=workers)


def test_a_replay_gives_the_same_numbers_wherever_fits_run(path: Path) -> None:
    """FTR's values and the fits, to the last bit; near the truth; each maneuver's own."""
    found = []
    for workers in (AtOnce(), OtherProcess()):
        session = watched(path, workers)
        run_through(session)
        estimates = session.estimates
        assert estimates is not None
        rows = {row.name: row for row in estimates.rows()}
        found.append((numbers(estimates.result), [(row.value, row.std) for row in rows.values()]))
        assert len(estimates.result.results) == 2
        for name in ("Cl_da", "Cn_dr", "Cm_de"):
            mean, std = rows[name].best or (np.nan, np.nan)
            true = TRUTH.derivative(name)
            assert abs(mean - true) < max(4.0 * std, 0.04 * abs(true))
            assert rows[name].known == true
        assert len(rows["Cm_de"].points) == 1
        assert "Cm_0" not in rows
        session.close()
    assert found[0] == found[1]


def test_unknown_until_earned_and_what_changed_is_said(path: Path) -> None:
    """Before the first maneuver nothing is known; after the last a row says what it brought."""
    session = watched(path, AtOnce())
    estimates = session.estimates
    assert estimates is not None
    while (session.now or 0.0) < 30.0:
        session.update()
        feed = session.replaying
        assert feed is not None
        if feed.complete and (session.now or 0.0) > 60.0:
            break
    early = {row.name: row for row in estimates.rows()}
    if early:
        assert all(row.best is None or row.points for row in early.values())
    run_through(session)
    late = {row.name: row for row in estimates.rows()}
    assert late["Cn_dr"].changed
    assert late["Cn_dr"].percent is not None
    assert late["Cn_dr"].percent < 10.0
    feed = session.replaying
    assert feed is not None
    feed.seek(feed.start or 0.0)
    session.update()
    assert estimates.result.results == ()
    session.close()


def test_without_workers_or_aircraft_nothing_is_estimated(path: Path) -> None:
    plain = Session.replay(path, aircraft="b777")
    assert plain.estimates is None
    plain.close()
