"""What can be said of an item, what it is said from, and in which words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, Protocol

from calibration.validity import CalibrationInForce
from gsapp.flight.info import FlightInfo
from gsapp.foundation.name_suggestions import format_names
from gsapp.quantities import Block, channel, from_si
from gsapp.session.channel_states import ChannelState, Freshness
from gsapp.session.snapshot import SessionSnapshot

ItemStatus = Literal["red", "amber", "open", "green"]
STATUS_ORDER: Final[tuple[ItemStatus, ...]] = ("red", "amber", "open", "green")


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


def channel_name_text(channel_id: str) -> str:
    """Return the name of a channel inside a sentence: ``left engine speed``."""
    title = channel(channel_id).title
    return title if title[1:2].isupper() else title[0].lower() + title[1:]


def format_channel_value(value: float, channel_id: str, unit: str | None = None) -> str:
    """Return a value with its unit and the digits that its sensor earns.

    Metric where the systems of units differ: the checklist converts its sentences.
    """
    spec = channel(channel_id)
    own = spec.si_display if unit is None or spec.si_display != spec.us_display else unit
    number = from_si(value, own, spec.quantity)
    text = f"{number:.{spec.decimals(own)}f}"
    return f"{text} {own}".rstrip()


def format_list(parts: list[str], most: int = 4) -> str:
    """Return parts as a list in words; of many only the first are named."""
    if len(parts) > most:
        return format_names(parts, most)
    return " and ".join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else "".join(parts)


NO_FLIGHT: Final = RuleResult(state="open", why="no flight is being recorded: connect the aircraft")
NO_DATA_YET: Final = RuleResult(state="open", why="no data from the aircraft yet")


def require_live_equipment(facts: ChecklistContext) -> SessionSnapshot | RuleResult:
    """Return link, recorder and disk of a live flight, or the judgment that there are none."""
    if facts.snapshot is None:
        return NO_FLIGHT
    if facts.snapshot.mode == "replay":
        return RuleResult(state="open", why="recorded flight: nothing to check")
    return facts.snapshot


def check_missing_channels(names: Iterable[str], facts: ChecklistContext) -> RuleResult | None:
    """Return the judgment where telemetry does not carry, or no longer brings, what is needed."""
    if not facts.states:
        return NO_FLIGHT if facts.snapshot is None else NO_DATA_YET
    wanted = tuple(names)
    absent = [channel_name_text(name) for name in wanted if name not in facts.states]
    if absent:
        return RuleResult(
            state="amber",
            why=f"{format_list(absent)} not in the telemetry: check and tick",
            allows_manual_tick=True,
        )
    silent = [name for name in wanted if facts.states[name].freshness is Freshness.STALE]
    if silent:
        oldest = max(facts.states[name].age or 0.0 for name in silent)
        return RuleResult(
            state="red",
            why=f"{format_list([channel_name_text(one) for one in silent])} silent for "
            f"{oldest:.0f} s",
        )
    never = [name for name in wanted if facts.states[name].freshness is Freshness.MISSING]
    if never:
        return RuleResult(
            state="open", why=f"no {format_list([channel_name_text(one) for one in never])} yet"
        )
    return None
