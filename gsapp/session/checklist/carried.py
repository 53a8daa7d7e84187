"""Whether there is a flight, and whether its telemetry brings what a rule needs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from gsapp.session.checklist.judgment import Facts, Judgment
from gsapp.session.checklist.words import joined, named
from gsapp.session.snapshot import SessionSnapshot
from gsapp.session.states import Freshness

NO_FLIGHT: Final = Judgment(state="open", why="no flight is being recorded: connect the aircraft")
NOTHING_YET: Final = Judgment(state="open", why="nothing has come from the aircraft yet")


def equipment(facts: Facts) -> SessionSnapshot | Judgment:
    """Return link, recorder and disk of a live flight, or the judgment that there are none."""
    if facts.snapshot is None:
        return NO_FLIGHT
    if facts.snapshot.mode == "replay":
        return Judgment(state="open", why="this flight was recorded before: nothing to check")
    return facts.snapshot


def missing_channels(names: Iterable[str], facts: Facts) -> Judgment | None:
    """Return the judgment where telemetry does not carry, or no longer brings, what is needed."""
    if not facts.states:
        return NO_FLIGHT if facts.snapshot is None else NOTHING_YET
    wanted = tuple(names)
    absent = [named(name) for name in wanted if name not in facts.states]
    if absent:
        return Judgment(
            state="amber",
            why=f"{joined(absent)} not in the telemetry: look yourself and tick",
            by_hand=True,
        )
    silent = [name for name in wanted if facts.states[name].freshness is Freshness.STALE]
    if silent:
        oldest = max(facts.states[name].age or 0.0 for name in silent)
        return Judgment(
            state="red", why=f"{joined([named(one) for one in silent])} silent for {oldest:.0f} s"
        )
    never = [name for name in wanted if facts.states[name].freshness is Freshness.MISSING]
    if never:
        return Judgment(state="open", why=f"no {joined([named(one) for one in never])} yet")
    return None
