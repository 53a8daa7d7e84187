"""What the page shows beside the cues: the card looked at, a verdict put away, calm. No Qt."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.test_points.point import TargetInput
from ui.pilot.card_browser import CardBrowser, find_last_flown_card
from ui.pilot.cue_display import CueDisplay
from ui.pilot.cue_display_builder import CueDisplayInput, build_cue_display
from ui.pilot.display_rate_limiter import DisplayRateLimiter

if TYPE_CHECKING:
    from ui.pilot.flight_cues import FlightCues


class PilotPageState:
    """What the crew did to the page, and what follows from it.

    Parameters
    ----------
    cues : FlightCues
        Of the open flight.
    clock : callable
        Seconds of a clock that never goes back.

    Attributes
    ----------
    snapshot : CueSnapshot or None
        As of the last look.
    """

    def __init__(self, cues: FlightCues, clock: Callable[[], float] = time.monotonic) -> None:
        self._cues = cues
        self._clock = clock
        self._choosing = CardBrowser()
        self.snapshot: CueSnapshot | None = None
        self.restart()

    def restart(self) -> None:
        """Begin with another flight."""
        self._choosing.reset()
        self._dismissed = ""
        self._calm = DisplayRateLimiter(self._clock)
        self.snapshot = None

    def update(self) -> CueSnapshot | None:
        """Look at the cues anew, and return them."""
        self.snapshot = self._cues.snapshot()
        return self.snapshot

    def build_display(self, units: str) -> CueDisplay:
        """Return what stands on the page, as of the last look."""
        reading = CueDisplayInput(
            cues=self.snapshot,
            units=units,
            is_flight_open=self._cues.is_open,
            seconds_without_data=self._cues.seconds_without_data(),
            monitored_fraction=self._cues.monitored_fraction(),
            dismissed_verdict_id=self._dismissed,
            browsed_card=self._choosing.browsed_card(self._cues.cards),
            target_input=self._target_input(),
        )
        return self._calm.limit(build_cue_display(reading))

    def _target_input(self) -> TargetInput | None:
        """Return what was wanted of the input whose verdict is on the page."""
        standing = self.shown_verdict_id
        debrief = self._cues.debrief() if standing else None
        maneuvers = () if debrief is None else debrief.maneuvers
        return next((one.target_input for one in maneuvers if one.verdict.id == standing), None)

    # Cards

    @property
    def is_browsing(self) -> bool:
        """Return whether another card is looked at than that which is to be flown."""
        return self._choosing.browsed_card(self._cues.cards) is not None

    def step_card(self, steps: int) -> None:
        """Look at another card."""
        self._calm.reset()
        self._choosing.step(self._cues.cards, self.update(), steps)

    def select_browsed_card(self) -> None:
        """Have the card that is looked at flown from now on."""
        self._choose(self._choosing.selected_card_id(self.update()))

    def repeat_last_card(self) -> None:
        """Have the card of the latest maneuver flown again."""
        card = find_last_flown_card(self.update(), self._cues.cards)
        if card:
            self._choose(card)

    def clear_card_selection(self) -> None:
        """Let the program choose again."""
        self._choose("")

    def _choose(self, card_id: str) -> None:
        self._calm.reset()
        self._choosing.reset()
        self._cues.select_card(card_id)

    # The verdict

    @property
    def shown_verdict_id(self) -> str:
        """Return the id of the maneuver whose verdict is on the page; empty for none."""
        verdict = None if self.snapshot is None else self.snapshot.fresh_verdict
        return verdict.id if verdict is not None and verdict.id != self._dismissed else ""

    def dismiss_verdict(self) -> None:
        """Put the verdict away; it stays in the debrief."""
        self.update()
        self._dismissed = self.shown_verdict_id or self._dismissed
