"""What can be done on the page, as buttons with their keys. No Qt widgets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from PySide6.QtGui import QAction

from ui.commands import shortcut_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.action_bar import ActionItem

_ACTION_LABELS: Final[Mapping[str, str]] = {
    "pilot_dismiss": QT_TR_NOOP("Dismiss"),
    "pilot_previous_card": QT_TR_NOOP("Previous card"),
    "pilot_next_card": QT_TR_NOOP("Next card"),
    "pilot_fly_card": QT_TR_NOOP("Fly this card"),
    "pilot_repeat": QT_TR_NOOP("Repeat card"),
    "pilot_any_card": QT_TR_NOOP("Best card"),
    "pilot_sticks": QT_TR_NOOP("Sticks"),
    "pilot_charts": QT_TR_NOOP("Show in charts"),
    "pilot_keep": QT_TR_NOOP("Keep"),
    "pilot_debrief": QT_TR_NOOP("Debrief"),
    "pilot_page": QT_TR_NOOP("In flight"),
    "pilot_window": QT_TR_NOOP("Separate window"),
    "pilot_train": QT_TR_NOOP("Train"),
    "mute": QT_TR_NOOP("Sound"),
}
"""Short words of the commands that have a button."""


def build_page_actions(
    actions: Mapping[str, QAction], *, debrief: bool, looking: bool, sticks: str
) -> tuple[ActionItem, ...]:
    """Return the buttons below the page: what acts now, the most wanted first.

    Parameters
    ----------
    looking : bool
        Whether another card is looked at than that which is to be flown.
    sticks : str
        What taking or giving back the sticks is called now; empty without training.
    """
    # The verdict's button keeps its place without a verdict, so that no other comes under a thumb.
    shown = ["pilot_charts", "pilot_keep"] if debrief else ["pilot_dismiss"]
    if not debrief and actions["pilot_fly_card"].isEnabled():
        shown += ["pilot_previous_card", "pilot_next_card", "pilot_fly_card", "pilot_repeat",
                  "pilot_any_card"]  # fmt: skip
    if sticks:
        shown.insert(0, "pilot_sticks")
    shown.append("pilot_page" if debrief else "pilot_debrief")
    shown += ["pilot_window", "pilot_train", "mute"]
    return tuple(
        ActionItem(
            id=name,
            text=sticks if name == "pilot_sticks" else tr(_ACTION_LABELS[name]),
            # Letters are sticks while a trainee flies: the last key is no letter.
            key=shortcut_text(
                actions[name].shortcuts()[-1 if sticks and name == "mute" else 0].toString()
            ),
            is_default=name == "pilot_fly_card" and looking,
            disabled_reason="" if actions[name].isEnabled() else actions[name].toolTip(),
        )
        for name in shown
    )
