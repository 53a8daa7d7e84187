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
from ui.translation import QT_TR_NOOP, tr

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
    """Something the user can do."""

    id: str  # Name in code.
    # Menu that lists it, and the submenu there; empty for none.
    menu: str
    text: str  # As listed.
    shortcuts: tuple[str, ...] = ()  # Shortcuts; the first is shown in the menu.
    # What must be there for it to be of use; it is gray otherwise.
    requirement: CommandRequirement = "nothing"
    has_separator: bool = False  # Whether a line stands above it in the menu.
    # Whether it is done again and again while its key is held: what moves, or goes on to the next.
    # A thumb in a glove that rests on a key means one mark, not thirty.
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

MENU_TITLES = (
    QT_TR_NOOP("File"), QT_TR_NOOP("View"), QT_TR_NOOP("Charts"), QT_TR_NOOP("Replay"),
    QT_TR_NOOP("Help"),
)  # fmt: skip
"""Those that are not named after a page."""
_CHART_SUBMENUS = {
    QT_TR_NOOP("Time"): (
        "earlier", "later", "window_earlier", "window_later", "start", "zoom_in", "zoom_out",
    ),
    QT_TR_NOOP("Selected chart"): ("chart_up", "chart_down", "range", "move_up", "move_down"),
    QT_TR_NOOP("Cursors"): (
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
    _command(
        "Preflight", "preflight_card", QT_TR_NOOP("1 Flight card"), "Alt+1", needs="preflight",
    ),
    _command(
        "Preflight", "preflight_calibration", QT_TR_NOOP("2 Calibration"), "Alt+2",
        needs="preflight",
    ),
    _command(
        "Preflight", "preflight_checklist", QT_TR_NOOP("3 Checklist"), "Alt+3", needs="preflight",
    ),
    _command(
        "Preflight", "preflight_cards", QT_TR_NOOP("4 Test cards"), "Alt+4", needs="preflight",
    ),
)  # fmt: skip

_CHECKLIST_COMMANDS = (
    _command(
        "Preflight", "checklist_tick", QT_TR_NOOP("Tick the item"), "Space", needs="checklist",
    ),
    _command(
        "Preflight", "checklist_reset", QT_TR_NOOP("Reset the checklist"), "Ctrl+Shift+Backspace",
        needs="checklist_ticked",
    ),
    _command(
        "Preflight", "preflight_start", QT_TR_NOOP("Start the flight, green or not"), "Ctrl+Return",
        needs="checklist",
    ),
    _command(
        "Preflight", "checklist_edit", QT_TR_NOOP("Edit the checklist…"), "Ctrl+Shift+E",
        needs="checklist",
    ),
)  # fmt: skip

_TEST_CARD_COMMANDS = (
    _command("Preflight", "cards_add", QT_TR_NOOP("Add a test card"), "Ctrl+N", needs="cards"),
    _command(
        "Preflight", "cards_up", QT_TR_NOOP("Test card up"), "Alt+Up", needs="card", repeats=True,
    ),
    _command(
        "Preflight", "cards_down", QT_TR_NOOP("Test card down"), "Alt+Down", needs="card",
        repeats=True,
    ),
    _command(
        "Preflight", "cards_remove", QT_TR_NOOP("Remove the test card"), "Ctrl+Backspace",
        needs="card",
    ),
    _command(
        "Preflight", "cards_open", QT_TR_NOOP("Open test cards…"), "Ctrl+Alt+O", needs="cards",
    ),
    _command(
        "Preflight", "cards_save", QT_TR_NOOP("Save the test cards…"), "Ctrl+S", needs="cards",
    ),
)  # fmt: skip

_PILOT_COMMANDS = (
    _command("Pilot", "pilot_page", QT_TR_NOOP("1 In flight"), "Alt+1", needs="pilot"),
    _command("Pilot", "pilot_debrief", QT_TR_NOOP("2 Debrief"), "Alt+2", needs="pilot"),
    _command(
        "Pilot", "pilot_window", QT_TR_NOOP("The page in a window of its own"), "Shift+F3",
        rule=True,
    ),
    _command("Pilot", "pilot_speak", QT_TR_NOOP("Speak the cues in flight"), "Ctrl+Shift+S"),
)  # fmt: skip

_PILOT_CARD_COMMANDS = (
    _command(
        "Pilot", "pilot_previous_card", QT_TR_NOOP("Show the previous card"), "PgUp",
        needs="pilot_cards", repeats=True,
    ),
    _command(
        "Pilot", "pilot_next_card", QT_TR_NOOP("Show the next card"), "PgDown", needs="pilot_cards",
        repeats=True,
    ),
    _command(
        "Pilot", "pilot_fly_card", QT_TR_NOOP("Fly this card"), "Return", "Enter",
        needs="pilot_cards",
    ),
    _command(
        "Pilot", "pilot_repeat", QT_TR_NOOP("Fly the last card again"), "R", needs="pilot_cards",
    ),
    _command(
        "Pilot", "pilot_any_card", QT_TR_NOOP("Choose the card automatically"), "Backspace",
        needs="pilot_cards",
    ),
)  # fmt: skip

_PILOT_VERDICT_COMMANDS = (
    _command(
        "Pilot", "pilot_dismiss", QT_TR_NOOP("Dismiss the verdict"), "Space", needs="pilot_verdict",
        rule=True,
    ),
    _command(
        "Pilot", "pilot_charts", QT_TR_NOOP("Show the maneuver in the charts"), "Shift+Return",
        needs="pilot_flown",
    ),
    _command("Pilot", "pilot_keep", QT_TR_NOOP("Save the debrief"), "Ctrl+S", needs="pilot_flown"),
    _command(
        "Pilot", "pilot_train", QT_TR_NOOP("Train with the virtual aircraft"), "Ctrl+Shift+T",
        rule=True,
    ),
    _command(
        "Pilot", "pilot_sticks", QT_TR_NOOP("Take or return control"), "H", needs="pilot_training",
    ),
)  # fmt: skip

_REVIEW_ESTIMATE_COMMANDS = (
    _command(
        "Review", "review_run", QT_TR_NOOP("Estimate"), "Ctrl+Return", "Ctrl+Enter",
        needs="review_ready", rule=True,
    ),
    _command(
        "Review", "review_defaults", QT_TR_NOOP("Restore default settings"), "Ctrl+Shift+Backspace",
        needs="review_panel",
    ),
    _command(
        "Review", "review_repeat", QT_TR_NOOP("Repeat the saved run exactly"), "Ctrl+Shift+Return",
        needs="review_run",
    ),
    _command(
        "Review", "review_use", QT_TR_NOOP("Use the settings of the saved run"), "Ctrl+Shift+U",
        needs="review_run",
    ),
    _command(
        "Review", "review_mark", QT_TR_NOOP("Mark the saved run for comparison"), "Ctrl+Shift+M",
        needs="review_run",
    ),
    _command(
        "Review", "review_name", QT_TR_NOOP("Rename the saved run"), "Ctrl+Shift+N",
        needs="review_run",
    ),
    _command(
        "Review", "review_forget", QT_TR_NOOP("Delete the saved run"), "Ctrl+Backspace",
        needs="review_run",
    ),
)  # fmt: skip

_REVIEW_COMMANDS = (
    _command("Review", "review_maneuvers", QT_TR_NOOP("1 Maneuvers"), "Alt+1", needs="review"),
    _command("Review", "review_estimate", QT_TR_NOOP("2 Estimate"), "Alt+2", needs="review"),
    _command("Review", "review_figures", QT_TR_NOOP("3 Figures"), "Alt+3", needs="review"),
    _command("Review", "review_summary", QT_TR_NOOP("4 Summary"), "Alt+4", needs="review"),
    _command("Review", "review_cancel", QT_TR_NOOP("Stop the work"), "Ctrl+.", needs="review_busy"),
)  # fmt: skip

_REVIEW_FLIGHT_COMMANDS = (
    _command(
        "Review", "review_add_open", QT_TR_NOOP("Review the open flight"), "Ctrl+Shift+P",
        needs="review_open",
    ),
    _command(
        "Review", "review_add_folder", QT_TR_NOOP("Add a flight folder…"), "Ctrl+Alt+O",
        needs="review_flights",
    ),
    _command(
        "Review", "review_add_files", QT_TR_NOOP("Add flight files…"), "Ctrl+Alt+F",
        needs="review_flights",
    ),
    _command("Review", "review_take_out", QT_TR_NOOP("Remove flight"), needs="review_flight"),
    _command("Review", "review_trial", QT_TR_NOOP("Simulate a flight"), needs="review"),
    _command(
        "Review", "review_onboard", QT_TR_NOOP("On-board log…"), "Ctrl+Shift+L",
        needs="review_folder", rule=True,
    ),
    _command(
        "Review", "review_onboard_stop", QT_TR_NOOP("Stop the log download"), "Ctrl+Shift+.",
        needs="review_log",
    ),
)  # fmt: skip

_REVIEW_MANEUVER_COMMANDS = (
    _command(
        "Review", "review_previous_maneuver", QT_TR_NOOP("Previous maneuver"), "Alt+PgUp",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_next_maneuver", QT_TR_NOOP("Next maneuver"), "Alt+PgDown",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_zoom", QT_TR_NOOP("Zoom to the maneuver"), "Ctrl+Return", "Ctrl+Enter",
        needs="review_maneuver",
    ),
    _command(
        "Review", "review_whole", QT_TR_NOOP("Show the whole flight"), "Ctrl+Home",
        needs="review_flight",
    ),
    _command(
        "Review", "review_add_maneuver", QT_TR_NOOP("Add the selection as a maneuver"), "Ctrl+N",
        needs="review_flight", rule=True,
    ),
    _command(
        "Review", "review_remove_maneuver", QT_TR_NOOP("Remove the maneuver"), "Ctrl+Backspace",
        needs="review_maneuver",
    ),
    _command(
        "Review", "review_merge", QT_TR_NOOP("Merge with the next, or merge the selected"),
        "Ctrl+J", needs="review_maneuver",
    ),
    _command(
        "Review", "review_rename", QT_TR_NOOP("Rename the maneuver"), "Ctrl+Shift+N",
        needs="review_maneuver",
    ),
    _command(
        "Review", "review_note", QT_TR_NOOP("Edit the note"), "Ctrl+B", needs="review_maneuver",
    ),
    _command(
        "Review", "review_grade", QT_TR_NOOP("Set the grade…"), "Ctrl+Shift+G",
        needs="review_maneuver",
    ),
    _command(
        "Review", "review_in_use", QT_TR_NOOP("Use in the estimate, or exclude"), "U",
        needs="review_maneuver",
    ),
)  # fmt: skip

_REVIEW_EDGE_COMMANDS = (
    _command(
        "Review", "review_start_earlier", QT_TR_NOOP("Start 0.1 s earlier"), "Ctrl+Left",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_start_later", QT_TR_NOOP("Start 0.1 s later"), "Ctrl+Right",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_start_back", QT_TR_NOOP("Start one sample earlier"), "Alt+Left",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_start_on", QT_TR_NOOP("Start one sample later"), "Alt+Right",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_end_earlier", QT_TR_NOOP("End 0.1 s earlier"), "Ctrl+Shift+Left",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_end_later", QT_TR_NOOP("End 0.1 s later"), "Ctrl+Shift+Right",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_end_back", QT_TR_NOOP("End one sample earlier"), "Alt+Shift+Left",
        needs="review_maneuver", repeats=True,
    ),
    _command(
        "Review", "review_end_on", QT_TR_NOOP("End one sample later"), "Alt+Shift+Right",
        needs="review_maneuver", repeats=True,
    ),
)  # fmt: skip

_REVIEW_SUMMARY_COMMANDS = (
    _command(
        "Review", "review_report", QT_TR_NOOP("Write the report…"), "Ctrl+P",
        needs="review_results", rule=True,
    ),
    _command(
        "Review", "review_everything", QT_TR_NOOP("Write report and all files into a folder…"),
        "Ctrl+Shift+P", needs="review_results",
    ),
    _command(
        "Review", "review_file", QT_TR_NOOP("Write one file…"), "Ctrl+S", needs="review_results",
    ),
    _command(
        "Review", "review_open_written", QT_TR_NOOP("Open what was written"), "Ctrl+Alt+P",
        needs="review_written",
    ),
    _command(
        "Review", "review_copy", QT_TR_NOOP("Copy the table"), "Ctrl+C", needs="review_results",
    ),
    _command(
        "Review", "review_compare", QT_TR_NOOP("Compare linear models with flight"), "Ctrl+Alt+L",
        needs="review_results",
    ),
)  # fmt: skip

_REVIEW_FIGURE_COMMANDS = (
    _command(
        "Review", "review_previous_figure", QT_TR_NOOP("Previous figure"), "Ctrl+PgUp",
        needs="review_figure", rule=True, repeats=True,
    ),
    _command(
        "Review", "review_next_figure", QT_TR_NOOP("Next figure"), "Ctrl+PgDown",
        needs="review_figure", repeats=True,
    ),
    _command(
        "Review", "review_figure_previous_maneuver", QT_TR_NOOP("Previous maneuver"), "Alt+PgUp",
        needs="review_figure", repeats=True,
    ),
    _command(
        "Review", "review_figure_next_maneuver", QT_TR_NOOP("Next maneuver"), "Alt+PgDown",
        needs="review_figure", repeats=True,
    ),
    _command(
        "Review", "review_open_fit", QT_TR_NOOP("Show the fit of the maneuver"), "Shift+Return",
        needs="review_point",
    ),
    _command(
        "Review", "review_exclude", QT_TR_NOOP("Exclude from or include in the means"), "X",
        needs="review_point",
    ),
    _command(
        "Review", "review_figure_copy", QT_TR_NOOP("Copy picture"), "Ctrl+C",
        needs="review_picture", rule=True,
    ),
    _command(
        "Review", "review_figure_copy_numbers", QT_TR_NOOP("Copy numbers"), "Ctrl+Alt+C",
        needs="review_picture",
    ),
    _command(
        "Review", "review_figure_save", QT_TR_NOOP("Save as…"), "Ctrl+S", needs="review_picture",
    ),
)  # fmt: skip

COMMANDS: tuple[Command, ...] = (
    _command("File", "connect", QT_TR_NOOP("Connect an aircraft…"), "Ctrl+L"),
    _command("File", "open_file", QT_TR_NOOP("Open a flight file…"), "Ctrl+O"),
    _command("File", "open_folder", QT_TR_NOOP("Open a flight folder…"), "Ctrl+Shift+O"),
    _command("File", "virtual", QT_TR_NOOP("Fly the virtual aircraft…"), "Ctrl+Shift+V"),
    _command("File", "attach", QT_TR_NOOP("Attach to a running recorder"), "Ctrl+R"),
    _command("File", "recorders", QT_TR_NOOP("Running recorders…"), "Ctrl+Alt+R"),
    _command("File", "export", QT_TR_NOOP("Export…"), "Ctrl+E", needs="flight", rule=True),
    _command(
        "File", "stop_recording", QT_TR_NOOP("Stop recording…"), "Ctrl+Shift+R", needs="recorder",
    ),
    _command(
        "File", "end_flight", QT_TR_NOOP("End flight and review"), "Ctrl+Alt+E", needs="recorder",
    ),
    _command("File", "close_flight", QT_TR_NOOP("Close the flight"), "Ctrl+W", needs="flight"),
    _command("File", "settings", QT_TR_NOOP("Settings…"), "Ctrl+,", rule=True),
    _command("File", "quit", QT_TR_NOOP("Quit"), "Ctrl+Q", rule=True),
    _command("View", "place_preflight", QT_TR_NOOP("Preflight"), "F1"),
    _command("View", "place_flight", QT_TR_NOOP("Flight"), "F2"),
    _command("View", "place_pilot", QT_TR_NOOP("Pilot"), "F3"),
    _command("View", "place_review", QT_TR_NOOP("Review"), "F4"),
    _command("View", "place_gap", QT_TR_NOOP("Model gap"), "F5"),
    _command("View", "full_screen", QT_TR_NOOP("Full screen"), *FULL_SCREEN_KEYS, rule=True),
    _command("View", "side_panel", QT_TR_NOOP("Side panel"), "F9", needs="charts"),
    *_within(
        QT_TR_NOOP("Theme"),
        _command("View", "next_theme", QT_TR_NOOP("Next theme"), "Ctrl+T"),
        *(_command("View", f"theme_{name}", theme_title(name)) for name in THEMES),
    ),
    _command("View", "units", QT_TR_NOOP("US or SI units"), "Ctrl+U"),
    _command("View", "larger", QT_TR_NOOP("Larger"), "Ctrl++", "Ctrl+="),
    _command("View", "smaller", QT_TR_NOOP("Smaller"), "Ctrl+-"),
    _command("View", "normal_size", QT_TR_NOOP("Normal size"), "Ctrl+0"),
    *_CHART_COMMANDS,
    *_within(
        QT_TR_NOOP("Selected chart"),
        _command("Charts", "type_range", QT_TR_NOOP("Set y range…"), "Shift+Y", needs="charts"),
        _command("Charts", "type_limits", QT_TR_NOOP("Set limits…"), "Shift+L", needs="charts"),
    ),
    *_within(
        QT_TR_NOOP("Side panel"),
        _command(
            "Flight", "panel_channels", QT_TR_NOOP("Choose channels"), "Ctrl+1", needs="flight",
        ),
        _command(
            "Flight", "panel_values", QT_TR_NOOP("Values at the cursors"), "Ctrl+2", needs="flight",
        ),
        _command("Flight", "panel_marks", QT_TR_NOOP("Marks and notes"), "Ctrl+3", needs="flight"),
        _command("Flight", "panel_alarms", QT_TR_NOOP("Alarms"), "Ctrl+4", needs="flight"),
        _command(
            "Flight", "panel_messages", QT_TR_NOOP("Status messages"), "Ctrl+5", needs="flight",
        ),
        _command(
            "Flight", "panel_estimates", QT_TR_NOOP("Live derivatives"), "Ctrl+6", needs="flight",
        ),
    ),
    _command("Flight", "link", QT_TR_NOOP("MAVLink inspector…"), "Ctrl+I", needs="flight"),
    _command("Flight", "mark", QT_TR_NOOP("Mark this moment"), "M", needs="flight", rule=True),
    _command("Flight", "note", QT_TR_NOOP("Mark and write a note"), "N", needs="flight"),
    _command("Flight", "undo", QT_TR_NOOP("Undo"), "Ctrl+Z", needs="change"),
    _command("Flight", "redo", QT_TR_NOOP("Redo"), "Ctrl+Y", "Ctrl+Shift+Z", needs="undone_change"),
    _command(
        "Flight", "previous_mark", QT_TR_NOOP("Previous mark"), "Shift+Left", needs="marks",
        repeats=True,
    ),
    _command(
        "Flight", "next_mark", QT_TR_NOOP("Next mark"), "Shift+Right", needs="marks", repeats=True,
    ),
    _command(
        "Flight", "acknowledge", QT_TR_NOOP("Acknowledge the alarms"), "K", needs="alarms",
        rule=True,
    ),
    # The second key serves while letters are sticks.
    _command("Flight", "mute", QT_TR_NOOP("Sound on or off"), "S", "Ctrl+M"),
    _command("Replay", "slower", QT_TR_NOOP("Slower"), "[", needs="replay"),
    _command("Replay", "faster", QT_TR_NOOP("Faster"), "]", needs="replay"),
    _command("Replay", "step_back", QT_TR_NOOP("One step back"), ",", needs="replay", repeats=True),
    _command("Replay", "step", QT_TR_NOOP("One step forward"), ".", needs="replay", repeats=True),
    _command("Replay", "go_to", QT_TR_NOOP("Go to time…"), "G", "Ctrl+G", needs="replay"),
    _command(
        "Replay", "certificates", QT_TR_NOOP("Use other certificates for this flight…"), "Ctrl+K",
        needs="replay", rule=True,
    ),
    *_PREFLIGHT_COMMANDS,
    *_within(QT_TR_NOOP("Checklist"), *_CHECKLIST_COMMANDS),
    *_within(QT_TR_NOOP("Test cards"), *_TEST_CARD_COMMANDS),
    *_PILOT_COMMANDS,
    *_within(QT_TR_NOOP("Cards"), *_PILOT_CARD_COMMANDS),
    *_PILOT_VERDICT_COMMANDS,
    *_REVIEW_COMMANDS,
    *_within(QT_TR_NOOP("Flights"), *_REVIEW_FLIGHT_COMMANDS),
    *_within(QT_TR_NOOP("Maneuvers"), *_REVIEW_MANEUVER_COMMANDS),
    *_within(QT_TR_NOOP("Start and end of a maneuver"), *_REVIEW_EDGE_COMMANDS),
    *_within(QT_TR_NOOP("Estimate"), *_REVIEW_ESTIMATE_COMMANDS),
    *_within(QT_TR_NOOP("Figures"), *_REVIEW_FIGURE_COMMANDS),
    *_within(QT_TR_NOOP("Summary"), *_REVIEW_SUMMARY_COMMANDS),
    _command("Model gap", "gap_search", QT_TR_NOOP("Search for a missing effect…"), "Ctrl+F"),
    _command("Model gap", "gap_cancel", QT_TR_NOOP("Stop the search"), "Ctrl+.", needs="search"),
    _command(
        "Model gap", "gap_find", QT_TR_NOOP("1 Find the disagreement"), "Alt+1", needs="gap",
        rule=True,
    ),
    _command("Model gap", "gap_name", QT_TR_NOOP("2 Name the effect"), "Alt+2", needs="gap"),
    _command("Model gap", "gap_add", QT_TR_NOOP("3 Add it to the model"), "Alt+3", needs="gap"),
    _command("Model gap", "gap_show", QT_TR_NOOP("4 Show the gap shrink"), "Alt+4", needs="gap"),
    *_within(
        QT_TR_NOOP("Models and maneuvers"),
        _command(
            "Model gap", "gap_step_back", QT_TR_NOOP("Previous model"), "Alt+Left", needs="gap",
            repeats=True,
        ),
        _command(
            "Model gap", "gap_step_on", QT_TR_NOOP("Next model"), "Alt+Right", needs="gap",
            repeats=True,
        ),
        _command(
            "Model gap", "gap_previous_maneuver", QT_TR_NOOP("Previous maneuver"), "Alt+PgUp",
            needs="gap", repeats=True,
        ),
        _command(
            "Model gap", "gap_next_maneuver", QT_TR_NOOP("Next maneuver"), "Alt+PgDown",
            needs="gap", repeats=True,
        ),
    ),
    *_within(
        QT_TR_NOOP("Effect"),
        _command(
            "Model gap", "gap_accept", QT_TR_NOOP("Accept the next effect"), "Ctrl+Return",
            needs="gap_next",
        ),
        _command(
            "Model gap", "gap_refuse", QT_TR_NOOP("Reject this effect"), "Ctrl+Backspace",
            needs="gap_effect",
        ),
        _command(
            "Model gap", "gap_force", QT_TR_NOOP("Force another effect…"), "Ctrl+Shift+F",
            needs="gap_idle",
        ),
    ),
    _command(
        "Model gap", "gap_save", QT_TR_NOOP("Save the revised model…"), "Ctrl+S", needs="gap",
        rule=True,
    ),
    _command(
        "Model gap", "gap_report", QT_TR_NOOP("Write the report…"), "Ctrl+P", needs="gap_idle",
    ),
    _command("Help", "guide", QT_TR_NOOP("User guide"), "Ctrl+F1"),
    _command("Help", "keys", QT_TR_NOOP("All keys"), "?", "Shift+F1"),
    _command(
        "Help", "copy_details", QT_TR_NOOP("Copy the details of the last error"), "Ctrl+Shift+C",
    ),
    _command("Help", "messages", QT_TR_NOOP("Messages…"), "Ctrl+Shift+D"),
    _command("Help", "dismiss", QT_TR_NOOP("Close message"), "Ctrl+D"),
    _command("Help", "about", QT_TR_NOOP("About"), rule=True),
)  # fmt: skip
"""All commands, in the order of the menus."""

CHECKABLE_COMMANDS = frozenset(
    {"full_screen", "side_panel", "mute", "pilot_window", "pilot_speak"}
    | {f"theme_{name}" for name in THEMES}
)
"""Commands that are on or off; the menu shows which."""


_DISABLED_REASONS: Mapping[str, str] = {
    "flight": QT_TR_NOOP("Open a flight first"),
    "replay": QT_TR_NOOP("Open a recorded flight first"),
    "recorder": QT_TR_NOOP("No recording is running"),
    "charts": QT_TR_NOOP("Open a flight on the Flight page first"),
    "change": QT_TR_NOOP("Nothing to undo"),
    "undone_change": QT_TR_NOOP("Nothing to redo"),
    "marks": QT_TR_NOOP("No marks yet"),
    "alarms": QT_TR_NOOP("No alarm to acknowledge"),
    "checklist": QT_TR_NOOP("A replay: connect an aircraft to use the checklist"),
    "checklist_ticked": QT_TR_NOOP("Nothing is ticked yet"),
    "pilot_verdict": QT_TR_NOOP("No verdict on screen"),
    "pilot_flown": QT_TR_NOOP("No maneuver yet"),
    "review_flight": QT_TR_NOOP("Choose a flight first"),
    "review_maneuver": QT_TR_NOOP("Choose a maneuver first"),
    "review_ready": QT_TR_NOOP("Add a flight with maneuvers first"),
    "review_figure": QT_TR_NOOP("Run an estimate first"),
    "review_picture": QT_TR_NOOP("No figure is drawn"),
    "review_results": QT_TR_NOOP("Run an estimate first"),
    "review_point": QT_TR_NOOP("Choose a point in the figure first"),
    "review_run": QT_TR_NOOP("Choose a saved run first"),
    "search": QT_TR_NOOP("No search is running"),
    "review_busy": QT_TR_NOOP("No estimate is running"),
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
    """An action that knows whether a key triggers it."""

    by_key = False  # True while a shortcut is being handled.

    def event(self, event: QEvent) -> bool:
        self.by_key = event.type() == QEvent.Type.Shortcut
        try:
            return super().event(event)
        finally:
            self.by_key = False


class CommandSet:
    """The actions of a window, one for each command."""

    def __init__(self, parent: QWidget, commands: Iterable[Command] = COMMANDS) -> None:
        self.commands = tuple(commands)
        self.actions: dict[str, CommandAction] = {}
        for command in self.commands:
            action = CommandAction(tr(command.text), parent)
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
        menus: dict[tuple[str, str], QMenu] = {}
        for command in self.commands:
            place = (command.menu, command.submenu)
            if (command.menu, "") not in menus:
                menus[command.menu, ""] = bar.addMenu(f"&{tr(command.menu)}")
            if place not in menus:
                menus[place] = menus[command.menu, ""].addMenu(tr(command.submenu))
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
            page = tr("Not available now; see the {page} page").format(page=tr(command.menu))
            reason = _DISABLED_REASONS.get(command.requirement)
            action.setToolTip("" if is_enabled else tr(reason) if reason else page)

    def check(self, command_id: str, on: bool) -> None:
        """Show a command as on or off without running it."""
        self.actions[command_id].setChecked(on)

    def hint(self, command_id: str) -> str:
        """Return ``Mark this moment (M)``, for tool tips."""
        command = next(known for known in self.commands if known.id == command_id)
        keys = f" ({shortcut_text(command.shortcuts[0])})" if command.shortcuts else ""
        return tr(command.text).rstrip("…") + keys
