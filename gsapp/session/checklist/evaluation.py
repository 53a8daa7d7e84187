"""What can be said of an item, and what it is said from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, Protocol

from calibration.validity import CalibrationInForce
from gsapp.flight.info import FlightInfo
from gsapp.quantities import Block
from gsapp.session.channel_states import ChannelState
from gsapp.session.snapshot import SessionSnapshot

ItemStatus = Literal["red", "amber", "open", "green"]

STATUS_ORDER: Final[tuple[ItemStatus, ...]] = ("red", "amber", "open", "green")
"""What is not green comes first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChecklistContext:
    """What is known at a moment, beside the samples."""

    snapshot: SessionSnapshot | None = None
    """Link, recorder, disk, certificates; None where no flight is open."""
    states: Mapping[str, ChannelState] = field(default_factory=dict)
    """By channel; one that the telemetry does not carry is not in it."""
    card: FlightInfo | None = None
    card_issues: tuple[str, ...] = ()
    """What looks like a slip on it, in words."""
    calibration: CalibrationInForce | None = None
    """The certificates of the flight; None where no flight is open."""
    system: str = "US"
    """Units of the sentences."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RuleResult:
    """What a rule says."""

    state: ItemStatus
    """``open``: not seen yet."""
    why: str
    allows_manual_tick: bool = False
    """Whether telemetry cannot tell, so that a person may tick it."""


class RuleEvaluator(Protocol):
    """Judges one item from all samples since the checklist was begun."""

    def feed(self, block: Block) -> None:
        """Take in the next samples."""

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        """Return how the item stands."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EvaluatedItem:
    """One line of the checklist as it stands."""

    id: str
    text: str
    checked_by: Literal["hand", "telemetry"]
    state: ItemStatus
    why: str
    can_tick: bool
    """Whether a person may tick it now, or untick it."""
