"""Pictures of the window in flight, made by the window itself.

``python -m ui.screenshot --out docs/images/flight.png`` flies the virtual aircraft, records and
follows it live, and saves what is on screen a minute and a half later, after two maneuvers. With
``--flight`` it opens that one and goes to a maneuver.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import GroundStationError
from gsapp.telemetry.status import RUNTIME_VARIABLE
from ui.theme import THEMES

if TYPE_CHECKING:
    from ui.window import MainWindow

_PATIENCE = 60.0
_FLOWN = 90.0
"""Flight time (s) of the picture of a live flight."""


def write_virtual_flight(folder: Path, plan: str = "short") -> Path:
    """Write a flight of the virtual aircraft, as fast as it goes, and return its folder."""
    target = folder / "virtual flight"
    command = [sys.executable, "-m", "gsapp.cli", "fly", "--out", str(target), "--plan", plan]
    # Into a pipe the program writes UTF-8 on every system.
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
    if done.returncode != 0:
        words = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise GroundStationError(f"the virtual flight was not written: {words[-1]}")
    return target


def photograph(
    flight: Path,
    out: Path,
    *,
    theme: str = "daylight",
    scale: int = 100,
    size: tuple[int, int] = (1280, 800),
    at: float | None = None,
    prepare: Callable[[MainWindow], object] | None = None,
) -> Path:
    """Open a flight in a window of its own and save what it shows.

    Parameters
    ----------
    flight : Path
        Flight folder or file.
    out : Path
        Picture to write, ``.png``.
    theme : str
        Name of a theme.
    scale : int
        Percent, 100 to 250.
    size : tuple of int
        Width and height of the window.
    at : float, optional
        Share of the flight to go to, 0 to 1; two thirds by default.
    prepare : callable, optional
        Called with the window before the picture is taken.

    Raises
    ------
    GroundStationError
        If the flight does not open in time, or the picture cannot be written.
    """
    from ui.app import make_application
    from ui.faults import FaultDesk
    from ui.settings import SettingsStore
    from ui.window import MainWindow

    application = make_application()
    with tempfile.TemporaryDirectory() as home, no_recorders(Path(home)):
        store = SettingsStore(Path(home) / "window.toml")
        store.change(theme=theme, scale=scale)
        faults = FaultDesk()
        window = MainWindow(store, faults)
        try:
            window.resize(*size)
            window.show()
            window.desk.open_flight(flight, playing=False)
            wait(application.processEvents, lambda: window.desk.is_loaded, f"{flight} to open")
            span = window.desk.replay_span
            if span is not None:
                share = 2.0 / 3.0 if at is None else at
                window.desk.seek(span[0] + share * (span[1] - span[0]))
            if prepare is not None:
                prepare(window)
            wait(application.processEvents, lambda: window.desk.is_settled, "the charts")
            # A few frames more: ranges and values follow ten times a second.
            until = time.monotonic() + 0.5
            wait(application.processEvents, lambda: time.monotonic() > until, "the charts")
            out.parent.mkdir(parents=True, exist_ok=True)
            if not window.grab().save(str(out)):
                raise GroundStationError(f"{out} cannot be written; check folder and permissions")
        finally:
            window.close()
            window.deleteLater()
            application.processEvents()
    return out


def photograph_live(out: Path, *, theme: str, scale: int, size: tuple[int, int]) -> Path:
    """Fly the virtual aircraft in real time, follow it, and save what the window shows.

    Parameters
    ----------
    out : Path
        Picture to write, ``.png``.
    theme : str
        Name of a theme.
    scale : int
        Percent, 100 to 250.
    size : tuple of int
        Width and height of the window.

    Raises
    ------
    GroundStationError
        If the flight does not come in time, or the picture cannot be written.
    """
    from ui.dialogs.requests import VirtualRequest
    from ui.photographer import Photographer, studio

    with studio(theme=theme, scale=scale, size=size) as window:
        desk = window.desk
        crew = Photographer(window, out.parent, settles=0.5, patience=_FLOWN + _PATIENCE)
        desk.fly_virtual(
            VirtualRequest(
                plan="short", seed=1, speed=1.0, hidden=(), thin=False, folder=desk.next_folder()
            )
        )
        crew.wait(lambda: (desk.time or 0.0) >= _FLOWN, "the flight")
        return crew.take(out.stem)


@contextlib.contextmanager
def no_recorders(folder: Path) -> Iterator[None]:
    """See no recorders that happen to run on this computer."""
    before = os.environ.get(RUNTIME_VARIABLE)
    os.environ[RUNTIME_VARIABLE] = str(folder)
    try:
        yield
    finally:
        if before is None:
            del os.environ[RUNTIME_VARIABLE]
        else:
            os.environ[RUNTIME_VARIABLE] = before


def wait(
    work: Callable[[], object], done: Callable[[], bool], what: str, patience: float = _PATIENCE
) -> None:
    """Let a window work until something is done, for so many seconds at most.

    Raises
    ------
    GroundStationError
        If it does not come in time.
    """
    end = time.monotonic() + patience
    while not done():
        if time.monotonic() > end:
            raise GroundStationError(f"waited {patience:.0f} s for {what} in vain")
        work()
        time.sleep(0.005)


def main(arguments: Sequence[str] | None = None) -> int:
    """Take one picture; see the module's text."""
    parser = argparse.ArgumentParser(prog="python -m ui.screenshot", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="picture to write")
    parser.add_argument("--flight", type=Path, help="flight to show; by default one flown live")
    parser.add_argument("--theme", choices=sorted(THEMES), default="daylight")
    parser.add_argument("--scale", type=int, default=100, help="percent, 100 to 250")
    parser.add_argument("--size", default="1280x800", help="of the window")
    parser.add_argument("--at", type=float, help="share of --flight to go to, 0 to 1")
    given = parser.parse_args(arguments)
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    width, _, height = given.size.partition("x")
    size = (int(width), int(height))
    try:
        if given.flight is None:
            photograph_live(given.out, theme=given.theme, scale=given.scale, size=size)
        else:
            photograph(
                given.flight,
                given.out,
                theme=given.theme,
                scale=given.scale,
                size=size,
                at=given.at,
            )
    except GroundStationError as error:
        sys.exit(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())
