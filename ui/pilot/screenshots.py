"""Pictures of the pilot's page and of the debrief, made by the window itself.

``python -m ui.pilot.screenshots --out docs/images/pilot`` flies a virtual flight as fast as it
goes, opens it, lets the cues judge it, and saves the page where each state first stands; then the
debrief, and a training flight with the sticks taken over.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from gsapp.foundation import GroundStationError
from ui.screenshot import no_recorders, wait, write_virtual_flight
from ui.theme import THEMES

if TYPE_CHECKING:
    from gsapp.excitation.cues import CueEvent
    from ui.window import MainWindow

_SETTLED: Final = 0.7
"""Seconds after which words that are held have come through."""
_FLOWN: Final = 5.0
"""Seconds for which the aircraft is left alone in training, before its picture is taken."""
_PATIENCE: Final = 900.0
"""Seconds: a whole flight is judged twice."""
_SOON: Final = 0.3
"""Seconds of flight after an event at which its picture is taken."""


def _named(event: CueEvent) -> str:
    """Return the picture that an event is good for; empty for none."""
    if event.kind == "trim":
        return {"fly": "fly", "hold": "hold", "go": "go", "gusty": "gusty", "turn": "turn"}.get(
            event.state, ""
        )
    if event.kind == "verdict":
        return "good" if event.state == "good" else "verdict"
    return "hands-off" if (event.kind, event.state) == ("hands-off", "begins") else ""


class Photographer:
    """A window, and the pictures taken of it.

    Parameters
    ----------
    window : MainWindow
    folder : Path
        Where pictures go.
    """

    def __init__(self, window: MainWindow, folder: Path) -> None:
        from PySide6.QtWidgets import QApplication

        self.window = window
        self._folder = folder
        self._work = QApplication.processEvents

    def wait(self, done: Callable[[], object], what: str) -> None:
        """Let the window work until something holds."""
        wait(self._work, lambda: bool(done()), what, _PATIENCE)

    def pause(self, seconds: float) -> None:
        """Let the window work for a while."""
        end = time.monotonic() + seconds
        self.wait(lambda: time.monotonic() > end, "time")

    def take(self, name: str) -> Path:
        """Save what is on screen.

        Raises
        ------
        GroundStationError
            If the picture cannot be written.
        """
        self.pause(_SETTLED)
        path = self._folder / f"{name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        if not self.window.grab().save(str(path)):
            raise GroundStationError(f"{path} cannot be written; check folder and permissions")
        return path


def photograph(
    flight: Path, out: Path, *, theme: str, scale: int, size: tuple[int, int]
) -> tuple[Path, ...]:
    """Save the states of the page as a flight shows them, the debrief, and training.

    Parameters
    ----------
    flight : Path
        Flight folder.
    out : Path
        Folder of the pictures.
    theme : str
        Name of a theme.
    scale : int
        Percent, 100 to 250.
    size : tuple of int
        Width and height of the window.

    Raises
    ------
    GroundStationError
        If the flight does not open in time, or a picture cannot be written.
    """
    from ui.app import make_application
    from ui.faults import FaultDesk
    from ui.settings import SettingsStore
    from ui.window import MainWindow

    application = make_application()
    with tempfile.TemporaryDirectory() as home, no_recorders(Path(home)):
        store = SettingsStore(Path(home) / "window.toml")
        store.change(theme=theme, scale=scale, flights=str(Path(home) / "flights"))
        window = MainWindow(store, FaultDesk(), offer_recorders=False)
        try:
            window.resize(*size)
            window.show()
            crew = Photographer(window, out)
            return (*_flown(crew, flight), *_trained(crew))
        finally:
            window.desk.stop_now()
            window.desk.close()  # so that the window does not ask about the recording
            window.close()
            window.deleteLater()
            application.processEvents()


def _flown(crew: Photographer, flight: Path) -> Iterator[Path]:
    """Go to where each state stands, then to the debrief."""
    desk = crew.window.desk
    desk.open_flight(flight, playing=False)
    crew.wait(lambda: desk.is_loaded, f"{flight} to open")
    crew.window.show_place("pilot")
    for name, at in _moments(crew).items():
        _go_to(crew, at + _SOON)
        yield crew.take(name)
    span = desk.replay_span
    if span is not None:
        _go_to(crew, span[1])
    crew.window.pilot.go(debrief=True)
    yield crew.take("debrief")
    crew.window.pilot.go(debrief=False)


def _moments(crew: Photographer) -> Mapping[str, float]:
    """Return the flight time of each picture: of its kind that nearest to the middle."""
    desk = crew.window.desk
    span, session = desk.replay_span, desk.session
    if span is None or session is None or session.cue_watch is None:
        return {}
    _go_to(crew, span[1])
    middle = 0.5 * (span[0] + span[1])
    log = _seen(session.cue_watch.cueing.log)
    log.sort(key=lambda one: -abs(one.time - middle))
    found = {_named(event): event.time for event in log}  # the nearest come last, and stay
    found.pop("", None)
    return dict(sorted(found.items(), key=lambda pair: pair[1]))


def _seen(log: Sequence[CueEvent]) -> list[CueEvent]:
    """Return the events that show on the page: trim does not from an input to its verdict."""
    from gsapp.excitation.cues import VERDICT_STANDS

    seen: list[CueEvent] = []
    busy = -math.inf
    for event in log:
        if event.kind == "input":
            # Noted once the sticks are let go; it began before.
            began = float(event.data["t_input"]) - _SOON
            seen = [one for one in seen if one.kind != "trim" or one.time < began]
            busy = math.inf
        elif event.kind == "verdict":
            busy = event.time + VERDICT_STANDS
        if event.kind != "trim" or event.time >= busy:
            seen.append(event)
    return seen


def _go_to(crew: Photographer, at: float) -> None:
    crew.window.desk.seek(at)
    crew.wait(lambda: crew.window.desk.is_settled, "the cues")
    crew.window.desk.tick()


def _trained(crew: Photographer) -> Iterator[Path]:
    """Take the sticks of the virtual aircraft."""
    pilot, desk = crew.window.pilot, crew.window.desk
    pilot.train()
    crew.wait(lambda: pilot.training.running and desk.time is not None, "the aircraft")
    crew.wait(lambda: desk.time is not None and desk.time > 1.0, "the aircraft")
    pilot.training.exchange()
    crew.wait(lambda: pilot.training.flies, "the sticks")
    begin = desk.time or 0.0
    crew.wait(lambda: (desk.time or 0.0) > begin + _FLOWN, "the flight")
    yield crew.take("training")


def main(arguments: Sequence[str] | None = None) -> int:
    """Take the pictures; see the module's text."""
    parser = argparse.ArgumentParser(prog="python -m ui.pilot.screenshots", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder of the pictures")
    parser.add_argument("--flight", type=Path, help="flight to show; a virtual one by default")
    parser.add_argument("--theme", choices=sorted(THEMES), default="daylight")
    parser.add_argument("--scale", type=int, default=100, help="percent, 100 to 250")
    parser.add_argument("--size", default="1280x800", help="of the window")
    given = parser.parse_args(arguments)
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    width, _, height = given.size.partition("x")
    with tempfile.TemporaryDirectory() as scratch:
        try:
            photograph(
                given.flight or _virtual(Path(scratch)),
                given.out,
                theme=given.theme,
                scale=given.scale,
                size=(int(width), int(height)),
            )
        except GroundStationError as error:
            sys.exit(str(error))
    return 0


def _virtual(folder: Path) -> Path:
    """Write a whole virtual flight, with the cards of its aircraft."""
    from gsapp.flight.cards import load_cards
    from gsapp.flight.folder import FlightFolder

    flight = write_virtual_flight(folder, "default")
    FlightFolder(path=flight).keep_cards(load_cards("b777"))
    return flight


if __name__ == "__main__":
    sys.exit(main())
