"""Pictures of what a crew does before a flight, made by the window itself.

``python -m tests.screenshots.preflight --out docs/images/preflight`` opens a window of its own with
the virtual aircraft on the ground, calibrates an instrument of it with keys, goes from step to
step, and saves what is on screen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import write_toml
from tests.screenshots.screenshot_taker import (
    ScreenshotTaker,
    WindowAppearance,
    exit_with_message,
    screenshot_parser,
    screenshot_window,
)

if TYPE_CHECKING:
    from calibration.wizard import WizardView
    from ui.preflight.wizard_page import WizardPage

_SPEED = 2.0
"""Of the bench, times real time: a hand takes its time."""
_POINTS = 6
"""Taken when the picture of the points is."""
_LINK_SECONDS = 3.0
"""Seconds after which the bar says what comes in, and the checklist what it sees."""
_TIMEOUT_SECONDS = 150.0
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


def take_preflight_screenshots(out: Path, guise: WindowAppearance) -> tuple[Path, ...]:
    """Go through the steps before a flight and save a picture of each."""

    def lay_out(home: Path) -> None:
        write_toml(home / "next flight" / "flight.toml", _CARD)

    with screenshot_window(guise, prepare=lay_out) as window:
        crew = ScreenshotTaker(window, out, patience=_TIMEOUT_SECONDS)
        return (*_capture_steps(crew), _capture_certificate(out))


def _capture_steps(crew: ScreenshotTaker) -> Iterator[Path]:
    """Go from step to step."""
    crew.wait_for_focus()
    crew.press_key("F1")
    crew.press_key("Alt+1")
    yield crew.take_screenshot("card")
    crew.press_key("Alt+2")
    page = crew.window.preflight_page.pages["calibration"]
    page.practice.speed = _SPEED
    crew.press_key("P")
    crew.wait_until(
        lambda: page.practice.running and crew.window.flight_controller.history.end, "the bench"
    )
    crew.wait_until(lambda: crew.window.flight_controller.is_up_to_date, "the bench")
    crew.press_key("Alt+2")  # the flight that opened took the keyboard
    crew.pause(_LINK_SECONDS)
    yield crew.take_screenshot("calibration")
    crew.press_key("Alt+3")
    crew.pause(_LINK_SECONDS)
    yield crew.take_screenshot("checklist")
    crew.press_key("Alt+4")
    yield crew.take_screenshot("cards")
    crew.press_key("Alt+2")
    yield from _calibrate_surfaces(crew, page)
    yield from _check_elevator(crew, page)
    yield from _calibrate_others(crew, page)


def _calibrate_surfaces(crew: ScreenshotTaker, page: WizardPage) -> Iterator[Path]:
    """Calibrate both elevators and skip the rest: sign, points, curve, and what came of it."""
    crew.press_key("Space")
    crew.wait_until(lambda: page.run is not None, "the calibration")
    _follow_prompts(crew, page, lambda view: view.phase == "sign")
    yield crew.take_screenshot("sign")
    _follow_prompts(crew, page, lambda view: len(view.points) == _POINTS)
    yield crew.take_screenshot("points")
    _follow_prompts(crew, page, lambda view: view.phase == "fit")
    yield crew.take_screenshot("curve")
    _follow_prompts(
        crew,
        page,
        lambda view: _calibrated_channel(view) not in ("elevator_left", "elevator_right"),
    )
    while _calibrated_channel(page.run.view):
        crew.press_key("X")
        crew.press_key("Return")
    crew.pause(_LINK_SECONDS)
    crew.wait_until(lambda: crew.window.flight_controller.is_up_to_date, "the bench")
    yield crew.take_screenshot("done")
    crew.press_key("Space")


def _check_elevator(crew: ScreenshotTaker, page: WizardPage) -> Iterator[Path]:
    """Check the left elevator against the certificate just made, and go back to look at it."""
    crew.press_key("C")
    _follow_prompts(crew, page, lambda view: _calibrated_channel(view) == "elevator_right")
    crew.press_key("PgUp")
    crew.wait_until(lambda: _is_steady(page.run.view), "the check")
    yield crew.take_screenshot("check")
    _abort_calibration(crew)


def _calibrate_others(crew: ScreenshotTaker, page: WizardPage) -> Iterator[Path]:
    """Turn the gyros, lay the aircraft down, cover the pitot and blow."""
    crew.press_key("G")
    _follow_prompts(crew, page, lambda view: view.phase == "gyro_turn" and view.amount)
    yield crew.take_screenshot("gyros")
    while page.run.view.phase == "gyro_turn":
        crew.press_key("PgDown")
    _follow_prompts(
        crew, page, lambda view: view.phase == "accel_position" and view.position == "x_up"
    )
    yield crew.take_screenshot("accelerometers")
    _follow_prompts(crew, page, lambda view: view.phase == "pressure_zero")
    yield crew.take_screenshot("pressures")
    crew.press_key("Space")
    _follow_prompts(crew, page, lambda view: view.phase == "pressure_blow")
    yield crew.take_screenshot("breath")
    _abort_calibration(crew)


def _abort_calibration(crew: ScreenshotTaker) -> None:
    """Leave a calibration for the page on which one begins."""
    crew.press_key("Esc")
    crew.press_key("Return")
    crew.press_key("Space")


def _is_steady(view: WizardView) -> bool:
    """Return whether the volts of the instrument are seen, and at rest."""
    return view.reading is not None and view.reading.state == "steady"


def _calibrated_channel(view: WizardView) -> str:
    """Return the channel that is calibrated; empty at the end."""
    return "" if view.instrument is None else view.instrument.channel


def _capture_certificate(folder: Path) -> Path:
    """Save what the page of a shipped certificate draws."""
    from calibration.certificate_store import load_certificate_overview
    from gsapp.foundation import write_atomically
    from gsapp.report.certificate_report import certificate_document
    from gsapp.report.document import render_png

    standing = {one.certificate.channel: one for one in load_certificate_overview("b777").in_force}
    (picture,) = certificate_document(standing["elevator_left"]).figures
    return write_atomically(folder / "certificate.png", render_png(picture))


def _follow_prompts(
    crew: ScreenshotTaker, page: WizardPage, enough: Callable[[WizardView], object]
) -> None:
    """Let the helper at the bench do what is asked for, with a key for each thing."""
    asked: tuple[object, ...] = ()

    def goes_on() -> bool:
        nonlocal asked
        view = page.run.view
        if page.run.has_no_data:
            # The flight is read anew with the certificates just made.
            return False
        if enough(view):
            return True
        wanted = (_calibrated_channel(view), view.phase, view.target, view.direction, view.position)
        if _calibrated_channel(view) and wanted != asked:
            asked = wanted
            crew.press_key("H")
        return False

    crew.wait_until(goes_on, "what the helper at the bench does")


def main(arguments: Sequence[str] | None = None) -> None:
    """Take the pictures; see the module's text."""
    given = screenshot_parser("tests.screenshots.preflight", __doc__).parse_args(arguments)
    with exit_with_message():
        take_preflight_screenshots(given.out, WindowAppearance.from_arguments(given))


if __name__ == "__main__":
    main()
