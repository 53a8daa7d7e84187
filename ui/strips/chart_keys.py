"""Every key of the strip charts, in one table: the widget obeys it, the help shows it."""

from __future__ import annotations

from dataclasses import dataclass

from ui.translation import QT_TR_NOOP


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyAction:
    """Something the charts do."""

    id: str  # Name in code, for `StripChart.perform`.
    keys: tuple[str, ...]  # In the portable text of key sequences; the first is the one to show.
    text: str  # What it does, in words.
    repeats: bool = False  # Whether it is done again and again while its key is held.


def _action(action: str, text: str, *keys: str, repeats: bool = False) -> KeyAction:
    return KeyAction(id=action, keys=keys, text=text, repeats=repeats)


KEY_ACTIONS: tuple[KeyAction, ...] = (
    _action("pause", QT_TR_NOOP("Pause or resume; recording never stops"), "Space"),
    _action("live", QT_TR_NOOP("Go to the newest sample"), "Home", "End"),
    _action("earlier", QT_TR_NOOP("Scroll back a tenth of the window"), "Left", repeats=True),
    _action("later", QT_TR_NOOP("Scroll forward a tenth of the window"), "Right", repeats=True),
    _action("window_earlier", QT_TR_NOOP("Scroll back a whole window"), "PgUp", repeats=True),
    _action("window_later", QT_TR_NOOP("Scroll forward a whole window"), "PgDown", repeats=True),
    _action("start", QT_TR_NOOP("To the start of the flight"), "Shift+Home"),
    _action("zoom_in", QT_TR_NOOP("Zoom in"), "+", "=", repeats=True),
    _action("zoom_out", QT_TR_NOOP("Zoom out"), "-", repeats=True),
    _action("chart_up", QT_TR_NOOP("Select the chart above"), "Up", repeats=True),
    _action("chart_down", QT_TR_NOOP("Select the chart below"), "Down", repeats=True),
    _action("enlarge", QT_TR_NOOP("Enlarge the selected chart, or show all"), "Return", "Enter"),
    _action("range", QT_TR_NOOP("Next y range: automatic, limits"), "Y"),
    _action("move_up", QT_TR_NOOP("Move the chart up"), "Alt+Up", repeats=True),
    _action("move_down", QT_TR_NOOP("Move the chart down"), "Alt+Down", repeats=True),
    _action("cursor", QT_TR_NOOP("Cursor on or off: all values at that time"), "C"),
    _action("cursor_earlier", QT_TR_NOOP("Cursor one column back"), "Ctrl+Left", repeats=True),
    _action("cursor_later", QT_TR_NOOP("Cursor one column forward"), "Ctrl+Right", repeats=True),
    _action(
        "cursor_far_earlier", QT_TR_NOOP("Cursor 20 columns back"), "Ctrl+Shift+Left", repeats=True
    ),
    _action(
        "cursor_far_later",
        QT_TR_NOOP("Cursor 20 columns forward"),
        "Ctrl+Shift+Right",
        repeats=True,
    ),
    _action("set_a", QT_TR_NOOP("Set A at the cursor"), "A", "1"),
    _action("set_b", QT_TR_NOOP("Set B where the cursor is; differences B−A"), "B", "2"),
    _action("clear", QT_TR_NOOP("Clear the cursors, show all charts"), "Esc"),
    _action("mark", QT_TR_NOOP("Mark this moment"), "M"),
)
"""All actions, in the order of the help."""

ACTION_BY_KEY = {key: action for action in KEY_ACTIONS for key in action.keys}
"""Action by key, in portable text."""
