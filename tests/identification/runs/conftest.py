"""Two short flights, made cheaply, and a run of both, for all tests of runs."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from gsapp.flight.writers import write_block
from gsapp.identification.runs.outcome import Outcome
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.running import run
from gsapp.quantities import Block

sys.path.insert(0, str(Path(__file__).parents[1]))
from virtual_maneuvers import fly

WINDOWS = ("1:0:6", "1:8:14", "2:0:6", "2:8:14")
"""Where the maneuvers are: an elevator one, and one of ailerons and rudder, in each flight."""


@pytest.fixture(scope="session")
def flight_files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return the files of two flights, to be read only."""
    folder = tmp_path_factory.mktemp("flights")
    first, second = (
        write_block(folder / f"{name}.csv", _flown(seed), "csv")
        for name, seed in (("a", 3), ("b", 13))
    )
    return first, second


@pytest.fixture(scope="session")
def request_of_both(flight_files: tuple[Path, Path]) -> RunRequest:
    """Return what asks for all four maneuvers."""
    return RunRequest(flights=flight_files, given=WINDOWS, label="both", model="b777")


@pytest.fixture(scope="session")
def outcome(request_of_both: RunRequest) -> Outcome:
    """Return the run of all four maneuvers."""
    return run(request_of_both)


def _flown(seed: int) -> Block:
    parts = [
        fly(seed + place, kind, duration=6.0, dt=0.02).maneuver.block
        for place, kind in enumerate(("lon", "lat"))
    ]
    return Block(
        channels=parts[0].channels,
        times=np.concatenate([parts[0].times, 8.0 + parts[1].times]),
        values=np.vstack([one.values for one in parts]),
    )
