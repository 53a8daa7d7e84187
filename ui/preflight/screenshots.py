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
from ui.photographer import Photographer, picture_parser, studio

if TYPE_CHECKING:
    from calibration.wizard import WizardView
    from ui.preflight.wizard_page import WizardPage

_SPEED = 3.0
"""Of the bench, times real time: a hand takes its time."""
_POINTS = 6
"""Taken when the picture of the points is."""
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


def photograph(out: Path, *, theme: str, scale: int, size: tuple[int, int]) -> tuple[Path, ...]:
    """Go through the steps before a flight and save a picture of each.

    Parameters
    ----------
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
        If a step does not come in time, or a picture cannot be written.
    """

    def lay_out(home: Path) -> None:
        write_toml(home / "next flight" / "flight.toml", _CARD)

    with studio(theme=theme, scale=scale, size=size, prepare=lay_out) as window:
        return (*_pictures(Photographer(window, out)), _certificate(out))


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
    yield crew.take("calibration")
    crew.press("Space")
    crew.wait(lambda: page.run is not None, "the calibration")
    _set_surfaces(crew, page, lambda view: view.phase == "sign")
    yield crew.take("sign")
    _set_surfaces(crew, page, lambda view: len(view.points) == _POINTS)
    yield crew.take("points")
    crew.press("Alt+3")
    crew.pause(3.0)
    yield crew.take("checklist")
    crew.press("Alt+4")
    yield crew.take("cards")


def _certificate(folder: Path) -> Path:
    """Save what the page of a shipped certificate draws."""
    from calibration.overview import overview
    from gsapp.foundation import write_atomically
    from gsapp.report.certificate_report import certificate_document
    from gsapp.report.document import picture_png

    standing = {one.certificate.channel: one for one in overview("b777").standing}
    (picture,) = certificate_document(standing["elevator_left"]).pictures
    return write_atomically(folder / "certificate.png", picture_png(picture))


def _set_surfaces(
    crew: Photographer, page: WizardPage, enough: Callable[[WizardView], bool]
) -> None:
    """Let the helper at the bench do what is asked for, with a key for each setting."""
    asked: tuple[object, ...] = ()

    def goes_on() -> bool:
        nonlocal asked
        view = page.run.view
        if enough(view):
            return True
        channel = None if view.instrument is None else view.instrument.channel
        wanted = (channel, view.phase, view.target, view.direction)
        if channel is not None and wanted != asked:
            asked = wanted
            crew.press("H")
        return False

    crew.wait(goes_on, "the helper at the bench")


def main(arguments: Sequence[str] | None = None) -> int:
    """Take the pictures; see the module's text."""
    given = picture_parser("ui.preflight.screenshots", __doc__).parse_args(arguments)
    try:
        photograph(given.out, theme=given.theme, scale=given.scale, size=given.size)
    except GroundStationError as error:
        sys.exit(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())
