"""Pictures of the review, made by the window itself.

``python -m tests.screenshots.review --out docs/images/review`` flies a virtual flight as fast as it
goes, opens it, estimates twice with keys alone, and saves each chapter and some of the figures.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from tests.screenshots.screenshot_taker import (
    ScreenshotTaker,
    WindowAppearance,
    exit_with_message,
    screenshot_parser,
    screenshot_window,
)
from tests.screenshots.virtual_flight import write_virtual_flight

_SETTLE_SECONDS: Final = 1.0
"""Seconds in which a figure is drawn."""
_TIMEOUT_SECONDS: Final = 300.0
"""Seconds: FTR listens to whole flights."""
_FIGURES: Final = ("fit", "residuals", "online", "linear", "correlations", "bounds", "modes")
"""Names of the pictures of the figures after that of the values."""


def take_review_screenshots(
    flights: Sequence[Path], out: Path, guise: WindowAppearance
) -> tuple[Path, ...]:
    """Save the chapters of the review of some flights."""
    with screenshot_window(guise) as window:
        window.store.change(review_flights=tuple(str(path.absolute()) for path in flights))
        crew = ScreenshotTaker(window, out, settles=_SETTLE_SECONDS, patience=_TIMEOUT_SECONDS)
        return tuple(_capture_steps(crew, len(flights)))


def _capture_steps(crew: ScreenshotTaker, flights: int) -> Iterator[Path]:
    """Go from chapter to chapter."""
    review = crew.window.review_page
    crew.wait_for_focus()
    crew.press_key("F4")
    crew.wait_until(lambda: len(review.review.flights) == flights, "the flights to open")
    for keys in ("Alt+PgDown", "Alt+PgDown", "Alt+PgDown", "Ctrl+Return", "Down", "Down"):
        crew.press_key(keys)
    yield crew.take_screenshot("maneuvers")
    crew.press_key("Alt+2")
    estimate = review.pages["estimate"]
    estimate.panel.bound_factor.setFocus()
    for key in ("1", "0"):
        crew.press_key(key)
    _run_estimate(crew, "Return")
    crew.press_key("Ctrl+Shift+Backspace")
    _run_estimate(crew, "Ctrl+Return")
    runs = estimate.runs.list
    runs.setFocus()
    crew.wait_until(lambda: len(runs.row_model.rows) == 2, "the kept runs")
    crew.press_key("Down")
    crew.press_key("Space")
    crew.press_key("Up")
    estimate.area.verticalScrollBar().setValue(0)
    yield crew.take_screenshot("estimate")
    crew.press_key("Alt+3")
    view = review.pages["figures"].view
    for index, name in enumerate(("values", *_FIGURES)):
        if index:
            crew.press_key("Ctrl+PgDown")
        for _ in range(2):
            # What comes of a job is drawn once more.
            crew.pause(_SETTLE_SECONDS)
            crew.wait_until(lambda: view.is_up_to_date and not review.work.running, name)
        yield crew.take_screenshot(name)
    crew.press_key("Alt+4")
    yield crew.take_screenshot("summary")


def _run_estimate(crew: ScreenshotTaker, keys: str) -> None:
    """Run, and wait for what comes of it."""
    review = crew.window.review_page
    before = review.outcome
    crew.wait_until(
        lambda: review.step_page is not None and review.step_page.can_run, "the settings"
    )
    crew.press_key(keys)
    crew.wait_until(lambda: review.outcome is not before and not review.work.running, "the run")


def main(arguments: Sequence[str] | None = None) -> None:
    """Take the pictures; see the module's text."""
    parser = screenshot_parser("tests.screenshots.review", __doc__)
    parser.add_argument(
        "--flight", type=Path, action="append", help="flight to show; a virtual one by default"
    )
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as scratch, exit_with_message():
        take_review_screenshots(
            given.flight or [write_virtual_flight(Path(scratch), "default")],
            given.out,
            WindowAppearance.from_arguments(given),
        )


if __name__ == "__main__":
    main()
