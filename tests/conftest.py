"""For all tests: no display needed, BLAS on one thread, and nothing of the user's is touched."""

from __future__ import annotations

import gc
import multiprocessing.connection
import os
import pickle
import tempfile
from collections.abc import Callable, Generator, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

    from gsapp.virtual.virtual_flight import VirtualFlight

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# How long an example takes says more of what else the machine does than of the program.
settings.register_profile("busy", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("busy")

# Where platformdirs looks on Linux, macOS and Windows, which itself asks nobody but the system;
# processes that tests start inherit it.
_HOMES = {
    "XDG_CONFIG_HOME": "config",
    "XDG_CACHE_HOME": "cache",
    "XDG_DATA_HOME": "data",
    "XDG_STATE_HOME": "state",
    "XDG_RUNTIME_DIR": "run",
    "XDG_DOCUMENTS_DIR": "documents",
    "HOME": ".",
    "USERPROFILE": ".",
    "APPDATA": "roaming",
    "LOCALAPPDATA": "local",
    "WIN_PD_OVERRIDE_APPDATA": "roaming",
    "WIN_PD_OVERRIDE_LOCAL_APPDATA": "local",
    "WIN_PD_OVERRIDE_PERSONAL": "documents",
}


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect the tests without looking for garbage in them: a third of the time, in each process.

    They stay to the end, so nobody needs to look through them later either.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture(scope="session", autouse=True)
def _a_home_of_its_own() -> Iterator[None]:
    # On Windows what a session that was not closed still holds cannot be removed.
    with tempfile.TemporaryDirectory(prefix="gsapp-tests-", ignore_cleanup_errors=True) as home:
        before = {name: os.environ.get(name) for name in _HOMES}
        for name, folder in _HOMES.items():
            path = Path(home) / folder
            path.mkdir(mode=0o700, exist_ok=True)
            os.environ[name] = str(path)
        yield
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@pytest.fixture
def pipes_stay(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let no pipe break by the death of the process at its end.

    So it is on Windows until the process has taken its end over from the one that started it.
    """
    held: list[int] = []

    def pipe(duplex: bool = True) -> tuple[Connection, Connection]:
        ours, theirs = made(duplex)
        held.append(os.dup(theirs.fileno()))
        return ours, theirs

    made = multiprocessing.connection.Pipe
    if os.name != "nt":
        monkeypatch.setattr(multiprocessing.connection, "Pipe", pipe)
    yield
    for descriptor in held:
        os.close(descriptor)


@pytest.fixture(scope="session")
def flown_short(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], VirtualFlight]:
    """Return what gives the short flight of a seed, flown once for all processes of a run."""
    from gsapp.foundation.file_lock import FileLock
    from gsapp.virtual.virtual_flight import simulate_flight

    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # which the processes share
    flights: dict[int, VirtualFlight] = {}

    def flown(seed: int) -> VirtualFlight:
        if seed not in flights:
            kept = folder / f"short-{seed}.pickle"
            lock = FileLock(kept.with_suffix(".lock"))
            assert lock.acquire(patience=240.0)
            try:
                if kept.exists():
                    flights[seed] = pickle.loads(kept.read_bytes())  # noqa: S301 - our own
                else:
                    flights[seed] = simulate_flight("short", seed=seed)
                    kept.write_bytes(pickle.dumps(flights[seed]))
            finally:
                lock.release()
        return flights[seed]

    return flown


@pytest.fixture(scope="session")
def qapp() -> QApplication:
    from ui.app import create_application

    return create_application()


@pytest.fixture(autouse=True)
def _garbage_of_a_test() -> Iterator[None]:
    yield
    if not gc.isenabled():
        # What a test made is young as long as nothing collects by itself.
        gc.collect(0)


@pytest.fixture(autouse=True, scope="module")
def _garbage_of_a_file() -> Iterator[None]:
    yield
    if not gc.isenabled():
        gc.collect()
        # What is left stays; it is not looked through after each file.
        gc.freeze()


@pytest.fixture
def shared_data() -> Path:
    named = os.environ.get("GSAPP_SHARED_DATA")
    folder = Path(named) if named else Path(__file__).parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"no real telemetry at {folder}; set GSAPP_SHARED_DATA to have it tried")
    return folder
