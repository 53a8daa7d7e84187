"""A checklist being gone through: ticks by hand, rules judged from telemetry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gsapp.foundation import UnknownNameError
from gsapp.quantities import Block, convert_text_units
from gsapp.session.checklist.evaluation import (
    STATUS_ORDER,
    ChecklistContext,
    EvaluatedItem,
    RuleEvaluator,
)
from gsapp.session.checklist.items import ChecklistFile, ChecklistItem
from gsapp.session.checklist.rule_evaluators import create_evaluator


@dataclass(frozen=True, slots=True, kw_only=True)
class ManualTick:
    """That a person said so."""

    who: str = ""
    """Empty where nobody gave a name."""


class Checklist:
    """The state of one checklist."""

    def __init__(self, file: ChecklistFile) -> None:
        self.file = file
        self._items = {item.id: item for item in file.items}
        self._ticks: dict[str, ManualTick] = {}
        self._judges: dict[str, RuleEvaluator] = {}
        self.restart()

    @property
    def ticks(self) -> Mapping[str, ManualTick]:
        """Return what was ticked by hand."""
        return dict(self._ticks)

    @property
    def required_channels(self) -> tuple[str, ...]:
        """Return the channels whose samples the rules need."""
        names = (
            name
            for item in self.file.items
            if item.rule is not None
            for name in item.rule.required_channels
        )
        return tuple(dict.fromkeys(names))

    def restart(self) -> None:
        """Begin anew: no tick stands and no sample was seen."""
        self._ticks.clear()
        self._judges = {
            item.id: create_evaluator(item.rule)
            for item in self.file.items
            if item.rule is not None
        }

    def feed(self, block: Block) -> None:
        if len(block):
            for judge in self._judges.values():
                judge.feed(block)

    def tick(self, item_id: str, who: str = "") -> None:
        """Say by hand that an item is done.

        Raises
        ------
        UnknownNameError
            If there is no such item.
        """
        self._ticks[self._item(item_id).id] = ManualTick(who=who)

    def untick(self, item_id: str) -> None:
        """Take a tick back.

        Raises
        ------
        UnknownNameError
            If there is no such item.
        """
        self._ticks.pop(self._item(item_id).id, None)

    def evaluate(self, facts: ChecklistContext) -> tuple[EvaluatedItem, ...]:
        """Return all items: red first, then amber, open, green; each in the order of the list."""
        found = [self._state(item, facts) for item in self.file.items]
        return tuple(sorted(found, key=lambda one: STATUS_ORDER.index(one.state)))

    def _item(self, item_id: str) -> ChecklistItem:
        try:
            return self._items[item_id]
        except KeyError:
            raise UnknownNameError(
                f"the checklist has no item '{item_id}'; it has {', '.join(self._items)}"
            ) from None

    def _state(self, item: ChecklistItem, facts: ChecklistContext) -> EvaluatedItem:
        tick = self._ticks.get(item.id)
        said = f"ticked by {tick.who}" if tick is not None and tick.who else "ticked"
        if item.rule is None:
            return EvaluatedItem(
                id=item.id,
                text=item.words,
                checked_by="hand",
                state="open" if tick is None else "green",
                why="tick when done" if tick is None else said,
                can_tick=True,
            )
        judgment = self._judges[item.id].evaluate(facts)
        why = convert_text_units(judgment.why, facts.system)
        by_hand = judgment.allows_manual_tick and tick is not None
        return EvaluatedItem(
            id=item.id,
            text=item.words,
            checked_by="hand" if by_hand else "telemetry",
            state="green" if by_hand else judgment.state,
            why=f"{said}; {why}" if by_hand else why,
            can_tick=judgment.allows_manual_tick,
        )
