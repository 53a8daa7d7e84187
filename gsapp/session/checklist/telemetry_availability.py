"""Whether there is a flight, and whether its telemetry brings what a rule needs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from gsapp.session.channel_states import Freshness
from gsapp.session.checklist.checklist_text import channel_name_text, format_list
from gsapp.session.checklist.evaluation import ChecklistContext, RuleResult
from gsapp.session.snapshot import SessionSnapshot

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
