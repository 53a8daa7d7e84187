"""Pictures of the pilot's page and of the debrief, made by the window itself.

``python -m tests.screenshots.pilot --out docs/images/pilot`` flies a virtual flight as fast as it
goes, opens it, lets the cues judge it, and saves the page where each state first stands; then the
debrief, and a training flight with the sticks taken over.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tests.screenshots.screenshot_taker import (
    ScreenshotTaker,
    WindowAppearance,
    exit_with_message,
    screenshot_parser,
    screenshot_window,
)
from tests.screenshots.virtual_flight import write_virtual_flight

if TYPE_CHECKING:
    from gsapp.excitation.cues import CueEvent

_SETTLE_SECONDS: Final = 0.7
"""Seconds after which words that are held have come through."""
_TRAINING_START_SECONDS: Final = 6.0
"""Seconds of training after which the first look ahead is over: on a busy machine it takes long
enough for the built-in pilot to take the sticks back."""
_TRAINING_SECONDS: Final = 5.0
"""Seconds for which the aircraft is left alone in training, before its picture is taken."""
_TIMEOUT_SECONDS: Final = 900.0
"""Seconds: a whole flight is judged twice."""
_EVENT_DELAY_SECONDS: Final = 0.3
"""Seconds of flight after an event at which its picture is taken."""


def _picture_name(event: CueEvent) -> str:
    """Return the picture that an event is good for; empty for none."""
    if event.kind == "trim":
        return {"fly": "fly", "hold": "hold", "go": "go", "gusty": "gusty", "turn": "turn"}.get(
            event.state, ""
        )
    if event.kind == "verdict":
        return "good" if event.state == "good" else "verdict"
    return "hands-off" if (event.kind, event.state) == ("hands-off", "begins") else ""


def take_pilot_screenshots(flight: Path, out: Path, guise: WindowAppearance) -> tuple[Path, ...]:
    """Save the states of the page as a flight shows them, the debrief, and training."""
    with screenshot_window(guise) as window:
        crew = ScreenshotTaker(window, out, settles=_SETTLE_SECONDS, patience=_TIMEOUT_SECONDS)
        return (*_capture_flight(crew, flight), *_capture_training(crew))


def _capture_flight(crew: ScreenshotTaker, flight: Path) -> Iterator[Path]:
    """Go to where each state stands, then to the debrief."""
    flight_controller = crew.window.flight_controller
    flight_controller.flight_opener.open_flight(flight, playing=False)
    crew.wait_until(lambda: flight_controller.is_loaded, f"{flight} to open")
    crew.window.show_page("pilot")
    for name, at in _find_picture_times(crew).items():
        _go_to(crew, at + _EVENT_DELAY_SECONDS)
        yield crew.take_screenshot(name)
    span = flight_controller.replay_span
    if span is not None:
        _go_to(crew, span[1])
    crew.window.pilot_page.show_page(debrief=True)
    yield crew.take_screenshot("debrief")
    crew.window.pilot_page.show_page(debrief=False)


def _find_picture_times(crew: ScreenshotTaker) -> Mapping[str, float]:
    """Return the flight time of each picture: of its kind that nearest to the middle."""
    flight_controller = crew.window.flight_controller
    span, session = flight_controller.replay_span, flight_controller.session
    if span is None or session is None or session.cue_monitor is None:
        return {}
    _go_to(crew, span[1])
    middle = 0.5 * (span[0] + span[1])
    log = _visible_events(session.cue_monitor.cueing.log)
    log.sort(key=lambda one: -abs(one.time - middle))
    found = {_picture_name(event): event.time for event in log}  # the nearest come last, and stay
    found.pop("", None)
    return dict(sorted(found.items(), key=lambda pair: pair[1]))


def _visible_events(log: Sequence[CueEvent]) -> list[CueEvent]:
    """Return the events that show on the page: trim does not from an input to its verdict."""
    from gsapp.excitation.settings import CUES

    seen: list[CueEvent] = []
    busy = -math.inf
    for event in log:
        if event.kind == "input":
            # Noted once the sticks are let go; it began before.
            began = float(event.data["t_input"]) - _EVENT_DELAY_SECONDS
            seen = [one for one in seen if one.kind != "trim" or one.time < began]
            busy = math.inf
        elif event.kind == "verdict":
            busy = event.time + CUES.verdict_display_time
        if event.kind != "trim" or event.time >= busy:
            seen.append(event)
    return seen


def _go_to(crew: ScreenshotTaker, at: float) -> None:
    crew.window.flight_controller.seek(at)
    crew.wait_until(lambda: crew.window.flight_controller.is_up_to_date, "the cues")
    crew.window.flight_controller.poller.tick()


def _capture_training(crew: ScreenshotTaker) -> Iterator[Path]:
    """Take the sticks of the virtual aircraft."""
    pilot, flight_controller = crew.window.pilot_page, crew.window.flight_controller
    pilot.start_training()
    crew.wait_until(
        lambda: pilot.training.running and flight_controller.time is not None, "the aircraft"
    )
    crew.wait_until(
        lambda: (flight_controller.time or 0.0) > _TRAINING_START_SECONDS, "the aircraft"
    )
    pilot.training.exchange_control()
    crew.wait_until(lambda: pilot.training.trainee_has_control, "the sticks")
    begin = flight_controller.time or 0.0
    crew.wait_until(
        lambda: (flight_controller.time or 0.0) > begin + _TRAINING_SECONDS, "the flight"
    )
    yield crew.take_screenshot("training")


def main(arguments: Sequence[str] | None = None) -> None:
    """Take the pictures; see the module's text."""
    parser = screenshot_parser("tests.screenshots.pilot", __doc__)
    parser.add_argument("--flight", type=Path, help="flight to show; a virtual one by default")
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as scratch, exit_with_message():
        take_pilot_screenshots(
            given.flight or _write_virtual_flight(Path(scratch)),
            given.out,
            WindowAppearance.from_arguments(given),
        )


def _write_virtual_flight(folder: Path) -> Path:
    """Write a whole virtual flight, with the cards of its aircraft."""
    from gsapp.flight.cards import load_cards
    from gsapp.flight.folder import FlightFolder

    flight = write_virtual_flight(folder, "default")
    FlightFolder(path=flight).store_cards(load_cards("b777"))
    return flight


if __name__ == "__main__":
    main()
