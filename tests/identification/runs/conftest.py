"""Two short flights, and a run of both, for all tests of runs."""

from pathlib import Path

import pytest

from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_execution import RunOutcome, execute_run
from tests.identification.runs_kit import WINDOWS, write_flights


@pytest.fixture(scope="session")
def flight_files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return write_flights(tmp_path_factory.mktemp("flights"))


@pytest.fixture(scope="session")
def outcome(flight_files: tuple[Path, Path]) -> RunOutcome:
    """Return the run of all four maneuvers."""
    return execute_run(
        RunRequest(flights=flight_files, maneuver_windows=WINDOWS, label="both", model="b777")
    )
