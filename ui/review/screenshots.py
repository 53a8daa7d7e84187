"""Pictures of the review, made by the window itself.

``python -m ui.review.screenshots --out docs/images/review`` flies a virtual flight as fast as it
goes, opens it, estimates twice with keys alone, and saves each chapter and some of the figures.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from gsapp.foundation import GroundStationError
from ui.screenshot import write_virtual_flight
from ui.screenshot_taker import (
    ScreenshotTaker,
    WindowAppearance,
    screenshot_parser,
    screenshot_window,
)

_SETTLE_SECONDS: Final = 1.0
"""Seconds in which a figure is drawn."""
_TIMEOUT_SECONDS: Final = 300.0
"""Seconds: FTR listens to whole flights."""
_FIGURES: Final = ("fit", "residuals", "online", "linear", "correlations", "bounds", "modes")
"""Names of the pictures of the figures after that of the values."""


def take_review_screenshots(
    flights: Sequence[Path], out: Path, guise: WindowAppearance
) -> tuple[Path, ...]:
    """Save the chapters of the review of some flights.

    Parameters
    ----------
    flights : sequence of Path
        Flight folders or files.
    out : Path
        Folder of the pictures.
    guise : WindowAppearance
        How the window looks.

    Raises
    ------
    GroundStationError
        If a chapter does not come in time, or a picture cannot be written.
    """
    with screenshot_window(guise) as window:
        window.store.change(review_flights=tuple(str(path.absolute()) for path in flights))
        crew = ScreenshotTaker(window, out, settles=_SETTLE_SECONDS, patience=_TIMEOUT_SECONDS)
        return tuple(_capture_steps(crew, len(flights)))


def _capture_steps(crew: ScreenshotTaker, flights: int) -> Iterator[Path]:
    """Go from chapter to chapter."""
    review = crew.window.review
    crew.await_keyboard()
    crew.press("F4")
    crew.wait(lambda: len(review.review.flights) == flights, "the flights to open")
    for keys in ("Alt+PgDown", "Alt+PgDown", "Alt+PgDown", "Ctrl+Return", "Down", "Down"):
        crew.press(keys)
    yield crew.take("maneuvers")
    crew.press("Alt+2")
    estimate = review.pages["estimate"]
    estimate.panel.bound_factor.setFocus()
    for key in ("1", "0"):
        crew.press(key)
    _run_estimate(crew, "Return")
    crew.press("Ctrl+Shift+Backspace")
    _run_estimate(crew, "Ctrl+Return")
    runs = estimate.runs.list
    runs.setFocus()
    crew.wait(lambda: len(runs.lines.lines) == 2, "the kept runs")
    crew.press("Down")
    crew.press("Space")
    crew.press("Up")
    estimate.area.verticalScrollBar().setValue(0)
    yield crew.take("estimate")
    crew.press("Alt+3")
    view = review.pages["figures"].view
    for place, name in enumerate(("values", *_FIGURES)):
        if place:
            crew.press("Ctrl+PgDown")
        for _ in range(2):
            # What comes of a job is drawn once more.
            crew.pause(_SETTLE_SECONDS)
            crew.wait(lambda: view.settled and not review.work.running, name)
        yield crew.take(name)
    crew.press("Alt+4")
    yield crew.take("summary")


def _run_estimate(crew: ScreenshotTaker, keys: str) -> None:
    """Run, and wait for what comes of it."""
    review = crew.window.review
    before = review.outcome
    crew.wait(lambda: review.page is not None and review.page.can_run, "the settings")
    crew.press(keys)
    crew.wait(lambda: review.outcome is not before and not review.work.running, "the run")


def main(arguments: Sequence[str] | None = None) -> int:
    """Take the pictures; see the module's text."""
    parser = screenshot_parser("ui.review.screenshots", __doc__)
    parser.add_argument(
        "--flight", type=Path, action="append", help="flight to show; a virtual one by default"
    )
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as scratch:
        try:
            take_review_screenshots(
                given.flight or [write_virtual_flight(Path(scratch), "default")],
                given.out,
                WindowAppearance.given(given),
            )
        except GroundStationError as error:
            sys.exit(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())
