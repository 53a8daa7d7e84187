"""Pictures of what a crew does before a flight, made by the window itself.

``python -m ui.preflight.screenshots --out docs/images/preflight`` opens a window of its own with
the virtual aircraft on the ground, calibrates an instrument of it with keys, goes from step to
step, and saves what is on screen.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import GroundStationError, write_toml
from ui.photographer import Guise, Photographer, picture_parser, studio

if TYPE_CHECKING:
    from calibration.wizard import WizardView
    from ui.preflight.wizard_page import WizardPage

_SPEED = 2.0
"""Of the bench, times real time: a hand takes its time."""
_POINTS = 6
"""Taken when the picture of the points is."""
_LINK_UP = 3.0
"""Seconds after which the bar says what comes in, and the checklist what it sees."""
_PATIENCE = 150.0
"""Seconds that an instrument may take at the bench."""
_CARD = {
    "name": "2026-05-12-a",
    "takeoff_weight": "46.9 lb",
    "fuel": "2.4 lb",
    "crew": {"pilot": "B. Jones", "engineer": "C. Poe", "ground_station": "D. Lee"},
    "weather": {
        "temperature": "61 degF", "pressure": "29.1 inHg", "wind_speed": "4 mph",
        "wind_from": "200 deg", "remarks": "light, steady",
    },
}  # fmt: skip


def photograph(out: Path, guise: Guise) -> tuple[Path, ...]:
    """Go through the steps before a flight and save a picture of each.

    Parameters
    ----------
    out : Path
        Folder of the pictures.
    guise : Guise
        How the window looks.

    Raises
    ------
    GroundStationError
        If a step does not come in time, or a picture cannot be written.
    """

    def lay_out(home: Path) -> None:
        write_toml(home / "next flight" / "flight.toml", _CARD)

    with studio(guise, prepare=lay_out) as window:
        crew = Photographer(window, out, patience=_PATIENCE)
        return (*_pictures(crew), _certificate(out))


def _pictures(crew: Photographer) -> Iterator[Path]:
    """Go from step to step."""
    crew.await_keyboard()
    crew.press("F1")
    crew.press("Alt+1")
    yield crew.take("card")
    crew.press("Alt+2")
    page = crew.window.preflight.pages["calibration"]
    page.practice.speed = _SPEED
    crew.press("P")
    crew.wait(lambda: page.practice.running and crew.window.desk.history.end, "the bench")
    crew.wait(lambda: crew.window.desk.is_settled, "the bench")
    crew.press("Alt+2")  # the flight that opened took the keyboard
    crew.pause(_LINK_UP)
    yield crew.take("calibration")
    crew.press("Alt+3")
    crew.pause(_LINK_UP)
    yield crew.take("checklist")
    crew.press("Alt+4")
    yield crew.take("cards")
    crew.press("Alt+2")
    yield from _surfaces(crew, page)
    yield from _check(crew, page)
    yield from _others(crew, page)


def _surfaces(crew: Photographer, page: WizardPage) -> Iterator[Path]:
    """Calibrate both elevators and skip the rest: sign, points, curve, and what came of it."""
    crew.press("Space")
    crew.wait(lambda: page.run is not None, "the calibration")
    _obey(crew, page, lambda view: view.phase == "sign")
    yield crew.take("sign")
    _obey(crew, page, lambda view: len(view.points) == _POINTS)
    yield crew.take("points")
    _obey(crew, page, lambda view: view.phase == "fit")
    yield crew.take("curve")
    _obey(crew, page, lambda view: _channel(view) not in ("elevator_left", "elevator_right"))
    while _channel(page.run.view):
        crew.press("X")
        crew.press("Return")
    crew.pause(_LINK_UP)
    crew.wait(lambda: crew.window.desk.is_settled, "the bench")
    yield crew.take("done")
    crew.press("Space")


def _check(crew: Photographer, page: WizardPage) -> Iterator[Path]:
    """Check the left elevator against the certificate just made, and go back to look at it."""
    crew.press("C")
    _obey(crew, page, lambda view: _channel(view) == "elevator_right")
    crew.press("PgUp")
    crew.wait(lambda: _is_steady(page.run.view), "the check")
    yield crew.take("check")
    _break_off(crew)


def _others(crew: Photographer, page: WizardPage) -> Iterator[Path]:
    """Turn the gyros, lay the aircraft down, cover the pitot and blow."""
    crew.press("G")
    _obey(crew, page, lambda view: view.phase == "gyro_turn" and view.amount)
    yield crew.take("gyros")
    while page.run.view.phase == "gyro_turn":
        crew.press("PgDown")
    _obey(crew, page, lambda view: view.phase == "accel_position" and view.position == "x_up")
    yield crew.take("accelerometers")
    _obey(crew, page, lambda view: view.phase == "pressure_zero")
    yield crew.take("pressures")
    crew.press("Space")
    _obey(crew, page, lambda view: view.phase == "pressure_blow")
    yield crew.take("breath")
    _break_off(crew)


def _break_off(crew: Photographer) -> None:
    """Leave a calibration for the page on which one begins."""
    crew.press("Esc")
    crew.press("Return")
    crew.press("Space")


def _is_steady(view: WizardView) -> bool:
    """Return whether the volts of the instrument are seen, and at rest."""
    return view.reading is not None and view.reading.state == "steady"


def _channel(view: WizardView) -> str:
    """Return the channel that is calibrated; empty at the end."""
    return "" if view.instrument is None else view.instrument.channel


def _certificate(folder: Path) -> Path:
    """Save what the page of a shipped certificate draws."""
    from calibration.overview import overview
    from gsapp.foundation import write_atomically
    from gsapp.report.certificate_report import certificate_document
    from gsapp.report.document import picture_png

    standing = {one.certificate.channel: one for one in overview("b777").standing}
    (picture,) = certificate_document(standing["elevator_left"]).pictures
    return write_atomically(folder / "certificate.png", picture_png(picture))


def _obey(crew: Photographer, page: WizardPage, enough: Callable[[WizardView], object]) -> None:
    """Let the helper at the bench do what is asked for, with a key for each thing."""
    asked: tuple[object, ...] = ()

    def goes_on() -> bool:
        nonlocal asked
        view = page.run.view
        if page.run.silent:
            # The flight is read anew with the certificates just made.
            return False
        if enough(view):
            return True
        wanted = (_channel(view), view.phase, view.target, view.direction, view.position)
        if _channel(view) and wanted != asked:
            asked = wanted
            crew.press("H")
        return False

    crew.wait(goes_on, "what the helper at the bench does")


def main(arguments: Sequence[str] | None = None) -> int:
    """Take the pictures; see the module's text."""
    given = picture_parser("ui.preflight.screenshots", __doc__).parse_args(arguments)
    try:
        photograph(given.out, Guise.given(given))
    except GroundStationError as error:
        sys.exit(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())
