"""Every command of the window with its keys: menus, shortcuts and the help come from here."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from PySide6.QtCore import QEvent
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QWidget

from ui.strips.chart_keys import KEY_ACTIONS
from ui.theme import THEMES, theme_title

CommandRequirement = Literal[
    "nothing",
    "flight",
    "replay",
    "recorder",
    "change",
    "undone_change",
    "search",
    "gap",
    "gap_idle",
    "gap_next",
    "gap_effect",
    "charts",
    "marks",
    "alarms",
    "preflight",
    "checklist",
    "checklist_ticked",
    "cards",
    "card",
    "pilot",
    "pilot_cards",
    "pilot_verdict",
    "pilot_training",
    "pilot_flown",
    "review",
    "review_busy",
    "review_results",
    "review_written",
    "review_flights",
    "review_flight",
    "review_maneuver",
    "review_open",
    "review_folder",
    "review_log",
    "review_panel",
    "review_ready",
    "review_run",
    "review_figure",
    "review_picture",
    "review_point",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """Something the user can do.

    Attributes
    ----------
    id : str
        Name in code.
    menu, submenu : str
        Menu that lists it, and the submenu there; empty for none.
    text : str
        As listed.
    shortcuts : tuple of str
        Shortcuts; the first is shown in the menu.
    requirement : str
        What must be there for it to be of use; it is gray otherwise.
    has_separator : bool
        Whether a line stands above it in the menu.
    auto_repeat : bool
        Whether it is done again and again while its key is held: what moves, or goes on to the
        next. A thumb in a glove that rests on a key means one mark, not thirty.
    """

    id: str
    menu: str
    text: str
    shortcuts: tuple[str, ...] = ()
    requirement: CommandRequirement = "nothing"
    has_separator: bool = False
    auto_repeat: bool = False
    submenu: str = ""


def _within(submenu: str, *commands: Command) -> tuple[Command, ...]:
    """Return commands as a submenu of their menu: a menu stays one column on small screens."""
    return tuple(replace(command, submenu=submenu) for command in commands)


def _command(
    menu: str,
    command: str,
    text: str,
    *keys: str,
    needs: CommandRequirement = "nothing",
    rule: bool = False,
    repeats: bool = False,
) -> Command:
    return Command(
        id=command,
        menu=menu,
        text=text,
        shortcuts=keys,
        requirement=needs,
        has_separator=rule,
        auto_repeat=repeats,
    )


CHART_PREFIX = "chart_"
"""Begins the ids of the commands that the strip charts themselves obey."""

# Marking is the window's: a mark goes into the flight, not only onto the charts.
FULL_SCREEN_KEYS = ("Meta+Ctrl+F", "F11") if sys.platform == "darwin" else ("F11",)
"""On macOS the system keeps F11 for itself."""

_CHART_SUBMENUS = {
    "Time": ("earlier", "later", "window_earlier", "window_later", "start", "zoom_in", "zoom_out"),
    "Selected chart": ("chart_up", "chart_down", "range", "move_up", "move_down"),
    "Cursors": (
        "cursor", "cursor_earlier", "cursor_later", "cursor_far_earlier", "cursor_far_later",
        "set_a", "set_b",
    ),
}  # fmt: skip
_CHART_COMMANDS = tuple(
    Command(
        id=CHART_PREFIX + action.id,
        menu="Charts",
        text=action.text,
        shortcuts=action.keys,
        requirement="charts",
        auto_repeat=action.repeats,
        submenu=next((name for name, ids in _CHART_SUBMENUS.items() if action.id in ids), ""),
    )
    for action in KEY_ACTIONS
    if action.id != "mark"
)

# Keys of one place serve another too: only the commands of the place on screen are enabled.
_PREFLIGHT_COMMANDS = (
    _command("Preflight", "preflight_card", "1 Flight card", "Alt+1", needs="preflight"),
    _command("Preflight", "preflight_calibration", "2 Calibration", "Alt+2", needs="preflight"),
    _command("Preflight", "preflight_checklist", "3 Checklist", "Alt+3", needs="preflight"),
    _command("Preflight", "preflight_cards", "4 Test cards", "Alt+4", needs="preflight"),
)  # fmt: skip

_CHECKLIST_COMMANDS = (
    _command("Preflight", "checklist_tick", "Tick the item", "Space", needs="checklist"),
    _command(
        "Preflight", "checklist_reset", "Reset the checklist", "Ctrl+Shift+Backspace",
        needs="checklist_ticked",
    ),
    _command(
        "Preflight", "preflight_start", "Start the flight, green or not", "Ctrl+Return",
        needs="checklist",
    ),
    _command(
        "Preflight", "checklist_edit", "Edit the checklist…", "Ctrl+Shift+E", needs="checklist"
    ),
)  # fmt: skip

_TEST_CARD_COMMANDS = (
    _command("Preflight", "cards_add", "Add a test card", "Ctrl+N", needs="cards"),
    _command("Preflight", "cards_up", "Test card up", "Alt+Up", needs="card", repeats=True),
    _command("Preflight", "cards_down", "Test card down", "Alt+Down", needs="card", repeats=True),
    _command("Preflight", "cards_remove", "Remove the test card", "Ctrl+Backspace", needs="card"),
    _command("Preflight", "cards_open", "Open test cards…", "Ctrl+Alt+O", needs="cards"),
    _command("Preflight", "cards_save", "Save the test cards…", "Ctrl+S", needs="cards"),
)  # fmt: skip

_PILOT_COMMANDS = (
    _command("Pilot", "pilot_page", "1 In flight", "Alt+1", needs="pilot"),
    _command("Pilot", "pilot_debrief", "2 Debrief", "Alt+2", needs="pilot"),
    _command("Pilot", "pilot_window", "The page in a window of its own", "Shift+F3", rule=True),
    _command("Pilot", "pilot_speak", "Speak the cues in flight", "Ctrl+Shift+S"),
)  # fmt: skip

_PILOT_CARD_COMMANDS = (
    _command(
        "Pilot", "pilot_previous_card", "Show the previous card", "PgUp", needs="pilot_cards",
        repeats=True,
    ),
    _command(
        "Pilot", "pilot_next_card", "Show the next card", "PgDown", needs="pilot_cards",
        repeats=True,
    ),
    _command("Pilot", "pilot_fly_card", "Fly this card", "Return", "Enter", needs="pilot_cards"),
    _command("Pilot", "pilot_repeat", "Fly the last card again", "R", needs="pilot_cards"),
    _command(
        "Pilot", "pilot_any_card", "Choose the card automatically", "Backspace",
        needs="pilot_cards",
    ),
)  # fmt: skip

_PILOT_VERDICT_COMMANDS = (
    _command(
        "Pilot", "pilot_dismiss", "Dismiss the verdict", "Space", needs="pilot_verdict", rule=True
    ),
    _command(
        "Pilot", "pilot_charts", "Show the maneuver in the charts", "Shift+Return",
        needs="pilot_flown",
    ),
    _command("Pilot", "pilot_keep", "Save the debrief", "Ctrl+S", needs="pilot_flown"),
    _command(
        "Pilot", "pilot_train", "Train with the virtual aircraft", "Ctrl+Shift+T", rule=True
    ),
    _command(
        "Pilot", "pilot_sticks", "Take or return control", "H",
        needs="pilot_training",
    ),
)  # fmt: skip

_REVIEW_ESTIMATE_COMMANDS = (
    _command(
        "Review", "review_run", "Estimate", "Ctrl+Return", "Ctrl+Enter", needs="review_ready",
        rule=True,
    ),
    _command(
        "Review", "review_defaults", "Restore default settings", "Ctrl+Shift+Backspace",
        needs="review_panel",
    ),
    _command(
        "Review", "review_repeat", "Repeat the saved run exactly", "Ctrl+Shift+Return",
        needs="review_run",
    ),
    _command(
        "Review", "review_use", "Use the settings of the saved run", "Ctrl+Shift+U",
        needs="review_run",
    ),
    _command(
        "Review", "review_mark", "Mark the saved run for comparison", "Ctrl+Shift+M",
        needs="review_run",
    ),
    _command("Review", "review_name", "Rename the saved run", "Ctrl+Shift+N", needs="review_run"),
    _command(
        "Review", "review_forget", "Delete the saved run", "Ctrl+Backspace", needs="review_run"
    ),
)  # fmt: skip

_REVIEW_COMMANDS = (
    _command("Review", "review_maneuvers", "1 Maneuvers", "Alt+1", needs="review"),
    _command("Review", "review_estimate", "2 Estimate", "Alt+2", needs="review"),
    _command("Review", "review_figures", "3 Figures", "Alt+3", needs="review"),
    _command("Review", "review_summary", "4 Summary", "Alt+4", needs="review"),
    _command("Review", "review_cancel", "Stop the work", "Ctrl+.", needs="review_busy"),
)  # fmt: skip

_REVIEW_FLIGHT_COMMANDS = (
    _command(
        "Review", "review_add_open", "Review the open flight", "Ctrl+Shift+P",
        needs="review_open",
    ),
    _command(
        "Review", "review_add_folder", "Add a flight folder…", "Ctrl+Alt+O",
        needs="review_flights",
    ),
    _command(
        "Review", "review_add_files", "Add flight files…", "Ctrl+Alt+F", needs="review_flights"
    ),
    _command("Review", "review_take_out", "Remove flight", needs="review_flight"),
    _command(
        "Review", "review_trial", "Simulate a flight", needs="review"
    ),
    _command(
        "Review", "review_onboard", "On-board log…", "Ctrl+Shift+L", needs="review_folder",
        rule=True,
    ),
    _command(
        "Review", "review_onboard_stop", "Stop the log download", "Ctrl+Shift+.",
        needs="review_log",
    ),
)  # fmt: skip

_REVIEW_MANEUVER_COMMANDS = (
    _command(
        "Review", "review_previous_maneuver", "Previous maneuver", "Alt+PgUp",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_next_maneuver", "Next maneuver", "Alt+PgDown", needs="review_maneuver",
        repeats=True,
    ),
    _command(
        "Review", "review_zoom", "Zoom to the maneuver", "Ctrl+Return", "Ctrl+Enter",
        needs="review_maneuver",
    ),
    _command(
        "Review", "review_whole", "Show the whole flight", "Ctrl+Home", needs="review_flight"
    ),
    _command(
        "Review", "review_add_maneuver", "Add the selection as a maneuver", "Ctrl+N",
        needs="review_flight", rule=True,
    ),
    _command(
        "Review", "review_remove_maneuver", "Remove the maneuver", "Ctrl+Backspace",
        needs="review_maneuver",
    ),
    _command(
        "Review", "review_merge", "Merge with the next, or merge the selected", "Ctrl+J",
        needs="review_maneuver",
    ),
    _command(
        "Review", "review_rename", "Rename the maneuver", "Ctrl+Shift+N", needs="review_maneuver"
    ),
    _command("Review", "review_note", "Edit the note", "Ctrl+B", needs="review_maneuver"),
    _command("Review", "review_grade", "Set the grade…", "Ctrl+Shift+G", needs="review_maneuver"),
    _command(
        "Review", "review_in_use", "Use in the estimate, or exclude", "U", needs="review_maneuver"
    ),
)  # fmt: skip

_REVIEW_EDGE_COMMANDS = (
    _command(
        "Review", "review_start_earlier", "Start 0.1 s earlier", "Ctrl+Left",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_start_later", "Start 0.1 s later", "Ctrl+Right",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_start_back", "Start one sample earlier", "Alt+Left",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_start_on", "Start one sample later", "Alt+Right",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_end_earlier", "End 0.1 s earlier", "Ctrl+Shift+Left",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_end_later", "End 0.1 s later", "Ctrl+Shift+Right",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_end_back", "End one sample earlier", "Alt+Shift+Left",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_end_on", "End one sample later", "Alt+Shift+Right",
        needs="review_maneuver", repeats=True,
    ),
)  # fmt: skip

_REVIEW_SUMMARY_COMMANDS = (
    _command(
        "Review", "review_report", "Write the report…", "Ctrl+P", needs="review_results", rule=True
    ),
    _command(
        "Review", "review_everything", "Write report and all files into a folder…",
        "Ctrl+Shift+P", needs="review_results",
    ),
    _command("Review", "review_file", "Write one file…", "Ctrl+S", needs="review_results"),
    _command(
        "Review", "review_open_written", "Open what was written", "Ctrl+Alt+P",
        needs="review_written",
    ),
    _command("Review", "review_copy", "Copy the table", "Ctrl+C", needs="review_results"),
    _command(
        "Review", "review_compare", "Compare linear models with flight", "Ctrl+Alt+L",
        needs="review_results",
    ),
)  # fmt: skip

_REVIEW_FIGURE_COMMANDS = (
    _command(
        "Review", "review_previous_figure", "Previous figure", "Ctrl+PgUp", needs="review_figure",
        rule=True, repeats=True,
    ),
    _command(
        "Review", "review_next_figure", "Next figure", "Ctrl+PgDown", needs="review_figure",
        repeats=True,
    ),
    _command(
        "Review", "review_figure_previous_maneuver", "Previous maneuver", "Alt+PgUp",
        needs="review_figure", repeats=True,
    ),
    _command(
        "Review", "review_figure_next_maneuver", "Next maneuver", "Alt+PgDown",
        needs="review_figure", repeats=True,
    ),
    _command(
        "Review", "review_open_fit", "Show the fit of the maneuver", "Shift+Return",
        needs="review_point",
    ),
    _command(
        "Review", "review_exclude", "Exclude from or include in the means", "X",
        needs="review_point",
    ),
    _command(
        "Review", "review_figure_copy", "Copy picture", "Ctrl+C", needs="review_picture", rule=True
    ),
    _command(
        "Review", "review_figure_copy_numbers", "Copy numbers", "Ctrl+Alt+C",
        needs="review_picture",
    ),
    _command("Review", "review_figure_save", "Save as…", "Ctrl+S", needs="review_picture"),
)  # fmt: skip

COMMANDS: tuple[Command, ...] = (
    _command("File", "connect", "Connect an aircraft…", "Ctrl+L"),
    _command("File", "open_file", "Open a flight file…", "Ctrl+O"),
    _command("File", "open_folder", "Open a flight folder…", "Ctrl+Shift+O"),
    _command("File", "virtual", "Fly the virtual aircraft…", "Ctrl+Shift+V"),
    _command("File", "attach", "Attach to a running recorder", "Ctrl+R"),
    _command("File", "recorders", "Running recorders…", "Ctrl+Alt+R"),
    _command("File", "export", "Export…", "Ctrl+E", needs="flight", rule=True),
    _command("File", "stop_recording", "Stop recording…", "Ctrl+Shift+R", needs="recorder"),
    _command("File", "end_flight", "End flight and review", "Ctrl+Alt+E", needs="recorder"),
    _command("File", "close_flight", "Close the flight", "Ctrl+W", needs="flight"),
    _command("File", "settings", "Settings…", "Ctrl+,", rule=True),
    _command("File", "quit", "Quit", "Ctrl+Q", rule=True),
    _command("View", "place_preflight", "Preflight", "F1"),
    _command("View", "place_flight", "Flight", "F2"),
    _command("View", "place_pilot", "Pilot", "F3"),
    _command("View", "place_review", "Review", "F4"),
    _command("View", "place_gap", "Model gap", "F5"),
    _command("View", "full_screen", "Full screen", *FULL_SCREEN_KEYS, rule=True),
    _command("View", "side_panel", "Side panel", "F9", needs="charts"),
    *_within(
        "Theme",
        _command("View", "next_theme", "Next theme", "Ctrl+T"),
        *(_command("View", f"theme_{name}", theme_title(name)) for name in THEMES),
    ),
    _command("View", "units", "US or SI units", "Ctrl+U"),
    _command("View", "larger", "Larger", "Ctrl++", "Ctrl+="),
    _command("View", "smaller", "Smaller", "Ctrl+-"),
    _command("View", "normal_size", "Normal size", "Ctrl+0"),
    *_CHART_COMMANDS,
    *_within(
        "Selected chart",
        _command("Charts", "type_range", "Set y range…", "Shift+Y", needs="charts"),
        _command("Charts", "type_limits", "Set limits…", "Shift+L", needs="charts"),
    ),
    *_within(
        "Side panel",
        _command("Flight", "panel_channels", "Choose channels", "Ctrl+1", needs="flight"),
        _command("Flight", "panel_values", "Values at the cursors", "Ctrl+2", needs="flight"),
        _command("Flight", "panel_marks", "Marks and notes", "Ctrl+3", needs="flight"),
        _command("Flight", "panel_alarms", "Alarms", "Ctrl+4", needs="flight"),
        _command("Flight", "panel_messages", "Status messages", "Ctrl+5", needs="flight"),
        _command("Flight", "panel_estimates", "Live derivatives", "Ctrl+6", needs="flight"),
    ),
    _command("Flight", "link", "MAVLink inspector…", "Ctrl+I", needs="flight"),
    _command("Flight", "mark", "Mark this moment", "M", needs="flight", rule=True),
    _command("Flight", "note", "Mark and write a note", "N", needs="flight"),
    _command("Flight", "undo", "Undo", "Ctrl+Z", needs="change"),
    _command("Flight", "redo", "Redo", "Ctrl+Y", "Ctrl+Shift+Z", needs="undone_change"),
    _command("Flight", "previous_mark", "Previous mark", "Shift+Left", needs="marks", repeats=True),
    _command("Flight", "next_mark", "Next mark", "Shift+Right", needs="marks", repeats=True),
    _command("Flight", "acknowledge", "Acknowledge the alarms", "K", needs="alarms", rule=True),
    # The second key serves while letters are sticks.
    _command("Flight", "mute", "Sound on or off", "S", "Ctrl+M"),
    _command("Replay", "slower", "Slower", "[", needs="replay"),
    _command("Replay", "faster", "Faster", "]", needs="replay"),
    _command("Replay", "step_back", "One step back", ",", needs="replay", repeats=True),
    _command("Replay", "step", "One step forward", ".", needs="replay", repeats=True),
    _command("Replay", "go_to", "Go to time…", "G", "Ctrl+G", needs="replay"),
    _command(
        "Replay",
        "certificates",
        "Use other certificates for this flight…",
        "Ctrl+K",
        needs="replay",
        rule=True,
    ),
    *_PREFLIGHT_COMMANDS,
    *_within("Checklist", *_CHECKLIST_COMMANDS),
    *_within("Test cards", *_TEST_CARD_COMMANDS),
    *_PILOT_COMMANDS,
    *_within("Cards", *_PILOT_CARD_COMMANDS),
    *_PILOT_VERDICT_COMMANDS,
    *_REVIEW_COMMANDS,
    *_within("Flights", *_REVIEW_FLIGHT_COMMANDS),
    *_within("Maneuvers", *_REVIEW_MANEUVER_COMMANDS),
    *_within("Start and end of a maneuver", *_REVIEW_EDGE_COMMANDS),
    *_within("Estimate", *_REVIEW_ESTIMATE_COMMANDS),
    *_within("Figures", *_REVIEW_FIGURE_COMMANDS),
    *_within("Summary", *_REVIEW_SUMMARY_COMMANDS),
    _command("Model gap", "gap_search", "Search for a missing effect…", "Ctrl+F"),
    _command("Model gap", "gap_cancel", "Stop the search", "Ctrl+.", needs="search"),
    _command("Model gap", "gap_find", "1 Find the disagreement", "Alt+1", needs="gap", rule=True),
    _command("Model gap", "gap_name", "2 Name the effect", "Alt+2", needs="gap"),
    _command("Model gap", "gap_add", "3 Add it to the model", "Alt+3", needs="gap"),
    _command("Model gap", "gap_show", "4 Show the gap shrink", "Alt+4", needs="gap"),
    *_within(
        "Models and maneuvers",
        _command(
            "Model gap",
            "gap_step_back",
            "Previous model",
            "Alt+Left",
            needs="gap",
            repeats=True,
        ),
        _command("Model gap", "gap_step_on", "Next model", "Alt+Right", needs="gap", repeats=True),
        _command(
            "Model gap",
            "gap_previous_maneuver",
            "Previous maneuver",
            "Alt+PgUp",
            needs="gap",
            repeats=True,
        ),
        _command(
            "Model gap",
            "gap_next_maneuver",
            "Next maneuver",
            "Alt+PgDown",
            needs="gap",
            repeats=True,
        ),
    ),
    *_within(
        "Effect",
        _command(
            "Model gap",
            "gap_accept",
            "Accept the next effect",
            "Ctrl+Return",
            needs="gap_next",
        ),
        _command(
            "Model gap", "gap_refuse", "Reject this effect", "Ctrl+Backspace", needs="gap_effect"
        ),
        _command(
            "Model gap", "gap_force", "Force another effect…", "Ctrl+Shift+F", needs="gap_idle"
        ),
    ),
    _command("Model gap", "gap_save", "Save the revised model…", "Ctrl+S", needs="gap", rule=True),
    _command("Model gap", "gap_report", "Write the report…", "Ctrl+P", needs="gap_idle"),
    _command("Help", "guide", "User guide", "Ctrl+F1"),
    _command("Help", "keys", "All keys", "?", "Shift+F1"),
    _command("Help", "copy_details", "Copy the details of the last error", "Ctrl+Shift+C"),
    _command("Help", "messages", "Messages…", "Ctrl+Shift+D"),
    _command("Help", "dismiss", "Close message", "Ctrl+D"),
    _command("Help", "about", "About", rule=True),
)
"""All commands, in the order of the menus."""

CHECKABLE_COMMANDS = frozenset(
    {"full_screen", "side_panel", "mute", "pilot_window", "pilot_speak"}
    | {f"theme_{name}" for name in THEMES}
)
"""Commands that are on or off; the menu shows which."""


_DISABLED_REASONS: Mapping[str, str] = {
    "flight": "Open a flight first",
    "replay": "Open a recorded flight first",
    "recorder": "No recording is running",
    "charts": "Open a flight on the Flight page first",
    "change": "Nothing to undo",
    "undone_change": "Nothing to redo",
    "marks": "No marks yet",
    "alarms": "No alarm to acknowledge",
    "checklist": "A replay: connect an aircraft to use the checklist",
    "checklist_ticked": "Nothing is ticked yet",
    "pilot_verdict": "No verdict on screen",
    "pilot_flown": "No maneuver yet",
    "review_flight": "Choose a flight first",
    "review_maneuver": "Choose a maneuver first",
    "review_ready": "Add a flight with maneuvers first",
    "review_figure": "Run an estimate first",
    "review_picture": "No figure is drawn",
    "review_results": "Run an estimate first",
    "review_point": "Choose a point in the figure first",
    "review_run": "Choose a saved run first",
    "search": "No search is running",
    "review_busy": "No estimate is running",
}
"""Why a command is gray; of others the page is named on which they work."""


def shortcut_text(keys: str) -> str:
    """Return a shortcut as this system writes it."""
    return QKeySequence(keys).toString(QKeySequence.SequenceFormat.NativeText)


def action_hint(action: QAction) -> str:
    """Return ``Mark this moment (M)`` for the tool tip of a button; of a gray one, why it is so."""
    if not action.isEnabled():
        return action.toolTip()
    keys, text = shortcut_text(action.shortcut().toString()), action.text().rstrip("…")
    return f"{text} ({keys})" if keys else text


class CommandAction(QAction):
    """An action that knows whether a key triggers it.

    Attributes
    ----------
    by_key : bool
        True while a shortcut is being handled.
    """

    by_key = False

    def event(self, event: QEvent) -> bool:
        self.by_key = event.type() == QEvent.Type.Shortcut
        try:
            return super().event(event)
        finally:
            self.by_key = False


class CommandSet:
    """The actions of a window, one for each command.

    Parameters
    ----------
    parent : QWidget
        The window.
    commands : iterable of Command
        The table.
    """

    def __init__(self, parent: QWidget, commands: Iterable[Command] = COMMANDS) -> None:
        self.commands = tuple(commands)
        self.actions: dict[str, CommandAction] = {}
        for command in self.commands:
            action = CommandAction(command.text, parent)
            action.setShortcuts([QKeySequence(keys) for keys in command.shortcuts])
            action.setCheckable(command.id in CHECKABLE_COMMANDS)
            action.setAutoRepeat(command.auto_repeat)
            parent.addAction(action)
            self.actions[command.id] = action

    def bind(self, *handlers: Mapping[str, Callable[[], object]]) -> None:
        """Say what each command does.

        Raises
        ------
        ValueError
            If a command has no handler, two of them, or a handler no command.
        """
        named = [name for part in handlers for name in part]
        odd = sorted(
            {name for name in named if named.count(name) > 1} | (set(named) ^ set(self.actions))
        )
        if odd:
            raise ValueError(f"commands and handlers differ: {', '.join(odd)}")
        for part in handlers:
            for name, handler in part.items():
                self.actions[name].triggered.connect(lambda _checked=False, act=handler: act())

    def fill_menu_bar(self, bar: QMenuBar) -> None:
        """Put the menus into a menu bar."""
        menus: dict[tuple[str, str], QMenu] = {}
        for command in self.commands:
            place = (command.menu, command.submenu)
            if (command.menu, "") not in menus:
                menus[command.menu, ""] = bar.addMenu(f"&{command.menu}")
            if place not in menus:
                menus[place] = menus[command.menu, ""].addMenu(command.submenu)
            if command.has_separator and not menus[place].isEmpty():
                menus[place].addSeparator()
            menus[place].addAction(self.actions[command.id])
        for menu in menus.values():
            menu.setToolTipsVisible(True)

    def update_enabled(self, present: Iterable[CommandRequirement]) -> None:
        """Gray what has nothing to act on, and say why; `present` says what is there."""
        there = {"nothing", *present}
        for command in self.commands:
            action, is_enabled = self.actions[command.id], command.requirement in there
            action.setEnabled(is_enabled)
            why = _DISABLED_REASONS.get(
                command.requirement, f"Not available now; see the {command.menu} page"
            )
            action.setToolTip("" if is_enabled else why)

    def check(self, command_id: str, on: bool) -> None:
        """Show a command as on or off without running it."""
        self.actions[command_id].setChecked(on)

    def hint(self, command_id: str) -> str:
        """Return ``Mark this moment (M)``, for tool tips."""
        command = next(known for known in self.commands if known.id == command_id)
        keys = f" ({shortcut_text(command.shortcuts[0])})" if command.shortcuts else ""
        return f"{command.text.rstrip('…')}{keys}"
