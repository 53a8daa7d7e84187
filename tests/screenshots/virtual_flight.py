"""Pictures of the window in flight, made by the window itself.

``python -m tests.screenshots.virtual_flight --out docs/images/flight.png`` flies the virtual
aircraft, records and follows it live, and saves what is on screen a minute and a half later, after
two maneuvers. With ``--flight`` it opens that one and goes to a maneuver.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from gsapp.foundation import GroundStationError
from tests.screenshots.screenshot_taker import (
    ScreenshotTaker,
    WindowAppearance,
    exit_with_message,
    screenshot_parser,
    screenshot_window,
)

_TIMEOUT = 60.0
_SETTLING_SECONDS = 0.5
"""Seconds for a few frames more: ranges and values follow ten times a second."""
_FLIGHT_SECONDS = 90.0
"""Flight time (s) of the picture of a live flight."""


def write_virtual_flight(folder: Path, plan: str = "short") -> Path:
    """Write a flight of the virtual aircraft, as fast as it goes, and return its folder."""
    target = folder / "virtual flight"
    command = [sys.executable, "-P", "-m", "gsapp", "fly", "--out", str(target), "--plan", plan]
    # Into a pipe the program writes UTF-8 on every system.
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
    if done.returncode != 0:
        words = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise GroundStationError(f"the virtual flight was not written: {words[-1]}")
    return target


def save_window_screenshot(
    flight: Path, out: Path, guise: WindowAppearance, *, at: float | None = None
) -> Path:
    """Open a flight, go to a share `at` of it, 0 to 1, and save what the window shows."""
    with screenshot_window(guise) as window:
        controller = window.flight_controller
        crew = ScreenshotTaker(window, out.parent, settles=_SETTLING_SECONDS, patience=_TIMEOUT)
        controller.flight_opener.open_flight(flight, playing=False)
        crew.wait_until(lambda: controller.is_loaded, f"{flight} to open")
        span = controller.replay_span
        if span is not None:
            share = 2.0 / 3.0 if at is None else at
            controller.seek(span[0] + share * (span[1] - span[0]))
        crew.wait_until(lambda: controller.is_up_to_date, "the charts")
        return crew.save_screenshot(out)


def save_live_screenshot(out: Path, guise: WindowAppearance) -> Path:
    """Fly the virtual aircraft in real time, follow it, and save what the window shows."""
    from ui.dialogs.flight_requests import VirtualFlightRequest

    with screenshot_window(guise) as window:
        controller = window.flight_controller
        crew = ScreenshotTaker(
            window, out.parent, settles=_SETTLING_SECONDS, patience=_FLIGHT_SECONDS + _TIMEOUT
        )
        controller.flight_opener.fly_virtual(
            VirtualFlightRequest(
                plan="short",
                seed=1,
                speed=1.0,
                thin=False,
                folder=controller.flight_opener.next_flight_folder(),
            )
        )
        crew.wait_until(lambda: (controller.time or 0.0) >= _FLIGHT_SECONDS, "the flight")
        return crew.save_screenshot(out)


def main(arguments: Sequence[str] | None = None) -> None:
    """Take one picture; see the module's text."""
    parser = screenshot_parser("tests.screenshots.virtual_flight", __doc__, out="picture to write")
    parser.add_argument("--flight", type=Path, help="flight to show; by default one flown live")
    parser.add_argument("--at", type=float, help="share of --flight to go to, 0 to 1")
    given = parser.parse_args(arguments)
    with exit_with_message():
        if given.flight is None:
            save_live_screenshot(given.out, WindowAppearance.from_arguments(given))
        else:
            save_window_screenshot(
                given.flight, given.out, WindowAppearance.from_arguments(given), at=given.at
            )


if __name__ == "__main__":
    main()
