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
    "nothing", "flight", "replay", "recorder", "change", "undone_change", "search", "gap",
    "gap_idle", "gap_next", "gap_effect", "gap_cards", "charts", "marks", "alarms", "preflight",
    "checklist", "checklist_ticked", "cards", "card", "pilot", "pilot_cards", "pilot_verdict",
    "pilot_training", "pilot_flown", "review", "review_busy", "review_results", "review_written",
    "review_instruments", "review_flights", "review_flight", "review_maneuver", "review_part",
    "review_open", "review_folder", "review_log", "review_panel", "review_ready", "review_run",
    "review_figure", "review_picture", "review_point",
]  # fmt: skip


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


def _menu(
    menu: str, submenu: str, needs: CommandRequirement, *commands: Command
) -> tuple[Command, ...]:
    return tuple(
        replace(
            one,
            menu=menu,
            submenu=submenu,
            requirement=needs if one.requirement == "nothing" else one.requirement,
        )
        for one in commands
    )


def _command(
    command: str,
    text: str,
    *keys: str,
    needs: CommandRequirement = "nothing",
    rule: bool = False,
    repeats: bool = False,
) -> Command:
    return Command(
        id=command,
        menu="",
        text=text,
        shortcuts=keys,
        requirement=needs,
        has_separator=rule,
        auto_repeat=repeats,
    )


CHART_PREFIX = "chart_"  # Begins the ids of the commands that the strip charts themselves obey.

# Marking is the window's: a mark goes into the flight, not only onto the charts.
FULL_SCREEN_KEYS = ("Meta+Ctrl+F", "F11") if sys.platform == "darwin" else ("F11",)
"""On macOS the system keeps F11 for itself."""

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
COMMANDS: tuple[Command, ...] = (
    *_menu(
        QT_TR_NOOP("File"), "", "nothing",
        _command("connect", QT_TR_NOOP("Connect an aircraft…"), "Ctrl+L"),
        _command("open_file", QT_TR_NOOP("Open a flight file…"), "Ctrl+O"),
        _command("open_folder", QT_TR_NOOP("Open a flight folder…"), "Ctrl+Shift+O"),
        _command("virtual", QT_TR_NOOP("Fly the virtual aircraft…"), "Ctrl+Shift+V"),
        _command("attach", QT_TR_NOOP("Attach to a running recorder"), "Ctrl+R"),
        _command("recorders", QT_TR_NOOP("Running recorders and sharing…"), "Ctrl+Alt+R"),
        _command("export", QT_TR_NOOP("Export…"), "Ctrl+E", needs="flight", rule=True),
        _command("stop_recording", QT_TR_NOOP("Stop recording…"), "Ctrl+Shift+R", needs="recorder"),
        _command("end_flight", QT_TR_NOOP("End flight and review"), "Ctrl+Alt+E", needs="recorder"),
        _command("close_flight", QT_TR_NOOP("Close the flight"), "Ctrl+W", needs="flight"),
        _command("settings", QT_TR_NOOP("Settings…"), "Ctrl+,", rule=True),
        _command("quit", QT_TR_NOOP("Quit"), "Ctrl+Q", rule=True),
    ),
    *_menu(
        QT_TR_NOOP("View"), "", "nothing",
        _command("place_preflight", QT_TR_NOOP("Preflight"), "F1"),
        _command("place_flight", QT_TR_NOOP("Flight"), "F2"),
        _command("place_pilot", QT_TR_NOOP("Pilot"), "F3"),
        _command("place_review", QT_TR_NOOP("Review"), "F4"),
        _command("place_gap", QT_TR_NOOP("Model gap"), "F5"),
        _command("full_screen", QT_TR_NOOP("Full screen"), *FULL_SCREEN_KEYS, rule=True),
        _command("side_panel", QT_TR_NOOP("Side panel"), "F9", needs="charts"),
    ),
    *_menu(
        QT_TR_NOOP("View"), QT_TR_NOOP("Theme"), "nothing",
        _command("next_theme", QT_TR_NOOP("Next theme"), "Ctrl+T"),
        *(_command(f"theme_{name}", theme_title(name)) for name in THEMES),
    ),
    *_menu(
        QT_TR_NOOP("View"), "", "nothing",
        _command("units", QT_TR_NOOP("US or SI units"), "Ctrl+U"),
        _command("larger", QT_TR_NOOP("Larger"), "Ctrl++", "Ctrl+="),
        _command("smaller", QT_TR_NOOP("Smaller"), "Ctrl+-"),
        _command("normal_size", QT_TR_NOOP("Normal size"), "Ctrl+0"),
    ),
    *_CHART_COMMANDS,
    *_menu(
        QT_TR_NOOP("Charts"), QT_TR_NOOP("Selected chart"), "charts",
        _command("type_range", QT_TR_NOOP("Set y range…"), "Shift+Y"),
        _command("type_limits", QT_TR_NOOP("Set limits…"), "Shift+L"),
    ),
    *_menu(
        QT_TR_NOOP("Flight"), QT_TR_NOOP("Side panel"), "flight",
        _command("panel_channels", QT_TR_NOOP("Choose channels"), "Ctrl+1"),
        _command("panel_values", QT_TR_NOOP("Values at the cursors"), "Ctrl+2"),
        _command("panel_marks", QT_TR_NOOP("Marks and notes"), "Ctrl+3"),
        _command("panel_alarms", QT_TR_NOOP("Alarms"), "Ctrl+4"),
        _command("panel_messages", QT_TR_NOOP("Status messages"), "Ctrl+5"),
        _command("panel_estimates", QT_TR_NOOP("Live derivatives"), "Ctrl+6"),
        _command("panel_plot", QT_TR_NOOP("Spectrum, channels and ground track"), "Ctrl+7"),
        _command("panel_wider", QT_TR_NOOP("Widen the side panel"), "Shift+F9", needs="charts",
                 rule=True, repeats=True),
        _command("panel_narrower", QT_TR_NOOP("Narrow the side panel"), "Ctrl+F9",
                 needs="charts", repeats=True),
    ),
    *_menu(
        QT_TR_NOOP("Flight"), "", "nothing",
        _command("link", QT_TR_NOOP("MAVLink inspector…"), "Ctrl+I", needs="flight"),
        _command("mark", QT_TR_NOOP("Mark this moment"), "M", needs="flight", rule=True),
        _command("note", QT_TR_NOOP("Mark and write a note"), "N", needs="flight"),
        _command("undo", QT_TR_NOOP("Undo"), "Ctrl+Z", needs="change"),
        _command("redo", QT_TR_NOOP("Redo"), "Ctrl+Y", "Ctrl+Shift+Z", needs="undone_change"),
        _command("previous_mark", QT_TR_NOOP("Previous mark"), "Shift+Left", needs="marks",
                 repeats=True),
        _command("next_mark", QT_TR_NOOP("Next mark"), "Shift+Right", needs="marks", repeats=True),
        _command("acknowledge", QT_TR_NOOP("Acknowledge the alarms"), "K", needs="alarms",
                 rule=True),
        # The second key serves while letters are sticks.
        _command("mute", QT_TR_NOOP("Sound on or off"), "S", "Ctrl+M"),
    ),
    *_menu(
        QT_TR_NOOP("Replay"), "", "replay",
        _command("slower", QT_TR_NOOP("Slower"), "["),
        _command("faster", QT_TR_NOOP("Faster"), "]"),
        _command("step_back", QT_TR_NOOP("One step back"), ",", repeats=True),
        _command("step", QT_TR_NOOP("One step forward"), ".", repeats=True),
        _command("go_to", QT_TR_NOOP("Go to time…"), "G", "Ctrl+G"),
        _command("certificates", QT_TR_NOOP("Use other certificates for this flight…"), "Ctrl+K",
                 rule=True),
    ),
    *_menu(
        QT_TR_NOOP("Preflight"), "", "preflight",
        _command("preflight_card", QT_TR_NOOP("1 Flight card"), "Alt+1"),
        _command("preflight_calibration", QT_TR_NOOP("2 Calibration"), "Alt+2"),
        _command("preflight_checklist", QT_TR_NOOP("3 Checklist"), "Alt+3"),
        _command("preflight_cards", QT_TR_NOOP("4 Test cards"), "Alt+4"),
    ),
    *_menu(
        QT_TR_NOOP("Preflight"), QT_TR_NOOP("Checklist"), "checklist",
        _command("checklist_tick", QT_TR_NOOP("Tick the item"), "Space"),
        _command("checklist_reset", QT_TR_NOOP("Reset the checklist"), "Ctrl+Shift+Backspace",
                 needs="checklist_ticked"),
        _command("preflight_start", QT_TR_NOOP("Start the flight, green or not"), "Ctrl+Return"),
        _command("checklist_edit", QT_TR_NOOP("Edit the checklist…"), "Ctrl+Shift+E"),
    ),
    *_menu(
        QT_TR_NOOP("Preflight"), QT_TR_NOOP("Test cards"), "cards",
        _command("cards_add", QT_TR_NOOP("Add a test card"), "Ctrl+N"),
        _command("cards_up", QT_TR_NOOP("Test card up"), "Alt+Up", needs="card", repeats=True),
        _command("cards_down", QT_TR_NOOP("Test card down"), "Alt+Down", needs="card",
                 repeats=True),
        _command("cards_remove", QT_TR_NOOP("Remove the test card"), "Ctrl+Backspace",
                 needs="card"),
        _command("cards_open", QT_TR_NOOP("Open test cards…"), "Ctrl+Alt+O"),
        _command("cards_save", QT_TR_NOOP("Save the test cards…"), "Ctrl+S"),
    ),
    *_menu(
        QT_TR_NOOP("Pilot"), "", "nothing",
        _command("pilot_page", QT_TR_NOOP("1 In flight"), "Alt+1", needs="pilot"),
        _command("pilot_debrief", QT_TR_NOOP("2 Debrief"), "Alt+2", needs="pilot"),
        _command("pilot_window", QT_TR_NOOP("Pilot page in a separate window"), "Shift+F3",
                 rule=True),
        _command("pilot_speak", QT_TR_NOOP("Speak the cues in flight"), "Ctrl+Shift+S"),
    ),
    *_menu(
        QT_TR_NOOP("Pilot"), QT_TR_NOOP("Cards"), "pilot_cards",
        _command("pilot_previous_card", QT_TR_NOOP("Show the previous card"), "PgUp", repeats=True),
        _command("pilot_next_card", QT_TR_NOOP("Show the next card"), "PgDown", repeats=True),
        _command("pilot_fly_card", QT_TR_NOOP("Fly this card"), "Return", "Enter"),
        _command("pilot_repeat", QT_TR_NOOP("Fly the last card again"), "R"),
        _command("pilot_any_card", QT_TR_NOOP("Choose the card automatically"), "Backspace"),
    ),
    *_menu(
        QT_TR_NOOP("Pilot"), "", "nothing",
        _command("pilot_dismiss", QT_TR_NOOP("Dismiss the verdict"), "Space",
                 needs="pilot_verdict", rule=True),
        _command("pilot_charts", QT_TR_NOOP("Show the maneuver in the charts"), "Shift+Return",
                 needs="pilot_flown"),
        _command("pilot_keep", QT_TR_NOOP("Save the debrief"), "Ctrl+S", needs="pilot_flown"),
        _command("pilot_train", QT_TR_NOOP("Train with the virtual aircraft"), "Ctrl+Shift+T",
                 rule=True),
        _command("pilot_sticks", QT_TR_NOOP("Take or return control"), "H", needs="pilot_training"),
    ),
    *_menu(
        QT_TR_NOOP("Review"), "", "review",
        _command("review_maneuvers", QT_TR_NOOP("1 Maneuvers"), "Alt+1"),
        _command("review_estimate", QT_TR_NOOP("2 Estimate"), "Alt+2"),
        _command("review_figures", QT_TR_NOOP("3 Figures"), "Alt+3"),
        _command("review_summary", QT_TR_NOOP("4 Summary"), "Alt+4"),
        _command("review_cancel", QT_TR_NOOP("Stop the work"), "Ctrl+.", needs="review_busy"),
    ),
    *_menu(
        QT_TR_NOOP("Review"), QT_TR_NOOP("Flights"), "review_flights",
        _command("review_add_open", QT_TR_NOOP("Review the open flight"), "Ctrl+Shift+P",
                 needs="review_open"),
        _command("review_add_folder", QT_TR_NOOP("Add a flight folder…"), "Ctrl+Alt+O"),
        _command("review_add_files", QT_TR_NOOP("Add flight files…"), "Ctrl+Alt+F"),
        _command("review_take_out", QT_TR_NOOP("Remove flight"), needs="review_flight"),
        _command("review_trial", QT_TR_NOOP("Simulate a flight"), needs="review"),
        _command("review_onboard", QT_TR_NOOP("On-board log…"), "Ctrl+Shift+L",
                 needs="review_folder", rule=True),
        _command("review_onboard_stop", QT_TR_NOOP("Stop the log download"), "Ctrl+Shift+.",
                 needs="review_log"),
    ),
    *_menu(
        QT_TR_NOOP("Review"), QT_TR_NOOP("Maneuvers"), "review_maneuver",
        _command("review_previous_maneuver", QT_TR_NOOP("Previous maneuver"), "Alt+PgUp",
                 repeats=True),
        _command("review_next_maneuver", QT_TR_NOOP("Next maneuver"), "Alt+PgDown", repeats=True),
        _command("review_zoom", QT_TR_NOOP("Zoom to the maneuver"), "Ctrl+Return", "Ctrl+Enter",
                 needs="review_part"),
        _command("review_whole", QT_TR_NOOP("Show the whole flight"), "Ctrl+Home",
                 needs="review_flight"),
        _command("review_add_maneuver", QT_TR_NOOP("Add the selection as a maneuver"), "Ctrl+N",
                 needs="review_flight", rule=True),
        _command("review_remove_maneuver", QT_TR_NOOP("Remove the maneuver"), "Ctrl+Backspace"),
        _command("review_merge", QT_TR_NOOP("Merge with the next, or merge the selected"),
                 "Ctrl+J"),
        _command("review_rename", QT_TR_NOOP("Rename the maneuver"), "Ctrl+Shift+N"),
        _command("review_note", QT_TR_NOOP("Edit the note"), "Ctrl+B"),
        _command("review_grade", QT_TR_NOOP("Set the grade…"), "Ctrl+Shift+G"),
        _command("review_in_use", QT_TR_NOOP("Use in the estimate, or exclude"), "U"),
    ),
    *_menu(
        QT_TR_NOOP("Review"), QT_TR_NOOP("Start and end of a maneuver"), "review_maneuver",
        _command("review_start_earlier", QT_TR_NOOP("Start 0.1 s earlier"), "Ctrl+Left",
                 repeats=True),
        _command("review_start_later", QT_TR_NOOP("Start 0.1 s later"), "Ctrl+Right", repeats=True),
        _command("review_start_back", QT_TR_NOOP("Start one sample earlier"), "Alt+Left",
                 repeats=True),
        _command("review_start_on", QT_TR_NOOP("Start one sample later"), "Alt+Right",
                 repeats=True),
        _command("review_end_earlier", QT_TR_NOOP("End 0.1 s earlier"), "Ctrl+Shift+Left",
                 repeats=True),
        _command("review_end_later", QT_TR_NOOP("End 0.1 s later"), "Ctrl+Shift+Right",
                 repeats=True),
        _command("review_end_back", QT_TR_NOOP("End one sample earlier"), "Alt+Shift+Left",
                 repeats=True),
        _command("review_end_on", QT_TR_NOOP("End one sample later"), "Alt+Shift+Right",
                 repeats=True),
    ),
    *_menu(
        QT_TR_NOOP("Review"), QT_TR_NOOP("Estimate"), "review_run",
        _command("review_run", QT_TR_NOOP("Estimate"), "Ctrl+Return", "Ctrl+Enter",
                 needs="review_ready", rule=True),
        _command("review_defaults", QT_TR_NOOP("Restore default settings"),
                 "Ctrl+Shift+Backspace", needs="review_panel"),
        _command("review_repeat", QT_TR_NOOP("Repeat the saved run exactly"), "Ctrl+Shift+Return"),
        _command("review_use", QT_TR_NOOP("Use the settings of the saved run"), "Ctrl+Shift+U"),
        _command("review_mark", QT_TR_NOOP("Mark the saved run for comparison"), "Ctrl+Shift+M"),
        _command("review_name", QT_TR_NOOP("Rename the saved run"), "Ctrl+Shift+N"),
        _command("review_forget", QT_TR_NOOP("Delete the saved run"), "Ctrl+Backspace"),
    ),
    *_menu(
        QT_TR_NOOP("Review"), QT_TR_NOOP("Figures"), "review_figure",
        _command("review_previous_figure", QT_TR_NOOP("Previous figure"), "Ctrl+PgUp", rule=True,
                 repeats=True),
        _command("review_next_figure", QT_TR_NOOP("Next figure"), "Ctrl+PgDown", repeats=True),
        _command("review_figure_previous_maneuver", QT_TR_NOOP("Previous maneuver"), "Alt+PgUp",
                 repeats=True),
        _command("review_figure_next_maneuver", QT_TR_NOOP("Next maneuver"), "Alt+PgDown",
                 repeats=True),
        _command("review_open_fit", QT_TR_NOOP("Show the fit of the maneuver"), "Shift+Return",
                 needs="review_point"),
        _command("review_exclude", QT_TR_NOOP("Exclude from or include in the means"), "X",
                 needs="review_point"),
        _command("review_figure_copy", QT_TR_NOOP("Copy picture"), "Ctrl+C",
                 needs="review_picture", rule=True),
        _command("review_figure_copy_numbers", QT_TR_NOOP("Copy numbers"), "Ctrl+Alt+C",
                 needs="review_picture"),
        _command("review_figure_save", QT_TR_NOOP("Save as…"), "Ctrl+S", needs="review_picture"),
    ),
    *_menu(
        QT_TR_NOOP("Review"), QT_TR_NOOP("Summary"), "review_results",
        _command("review_report", QT_TR_NOOP("Write the report…"), "Ctrl+P", rule=True),
        _command("review_everything", QT_TR_NOOP("Write report and all files into a folder…"),
                 "Ctrl+Shift+P"),
        _command("review_file", QT_TR_NOOP("Write one file…"), "Ctrl+S"),
        _command("review_open_written", QT_TR_NOOP("Open what was written"), "Ctrl+Alt+P",
                 needs="review_written"),
        _command("review_copy", QT_TR_NOOP("Copy the table"), "Ctrl+C"),
        _command("review_update_aircraft", QT_TR_NOOP("Update vanes in the aircraft file"),
                 "Ctrl+Alt+U", needs="review_instruments"),
        _command("review_compare", QT_TR_NOOP("Compare linear models with flight"), "Ctrl+Alt+L"),
    ),
    *_menu(
        QT_TR_NOOP("Model gap"), "", "nothing",
        _command("gap_search", QT_TR_NOOP("Search for a missing effect…"), "Ctrl+F"),
        _command("gap_cancel", QT_TR_NOOP("Stop the search"), "Ctrl+.", needs="search"),
        _command("gap_find", QT_TR_NOOP("1 Find the disagreement"), "Alt+1", needs="gap",
                 rule=True),
        _command("gap_name", QT_TR_NOOP("2 Name the effect"), "Alt+2", needs="gap"),
        _command("gap_add", QT_TR_NOOP("3 Add it to the model"), "Alt+3", needs="gap"),
        _command("gap_show", QT_TR_NOOP("4 Show the gap shrink"), "Alt+4", needs="gap"),
    ),
    *_menu(
        QT_TR_NOOP("Model gap"), QT_TR_NOOP("Models and maneuvers"), "gap",
        _command("gap_step_back", QT_TR_NOOP("Previous model"), "Alt+Left", repeats=True),
        _command("gap_step_on", QT_TR_NOOP("Next model"), "Alt+Right", repeats=True),
        _command("gap_previous_maneuver", QT_TR_NOOP("Previous maneuver"), "Alt+PgUp",
                 repeats=True),
        _command("gap_next_maneuver", QT_TR_NOOP("Next maneuver"), "Alt+PgDown", repeats=True),
    ),
    *_menu(
        QT_TR_NOOP("Model gap"), QT_TR_NOOP("Effect"), "gap_next",
        _command("gap_accept", QT_TR_NOOP("Accept the next effect"), "Ctrl+Return"),
        _command("gap_refuse", QT_TR_NOOP("Reject this effect"), "Ctrl+Backspace",
                 needs="gap_effect"),
        _command("gap_force", QT_TR_NOOP("Force another effect…"), "Ctrl+Shift+F",
                 needs="gap_idle"),
    ),
    *_menu(
        QT_TR_NOOP("Model gap"), "", "gap",
        _command("gap_save", QT_TR_NOOP("Save the revised model…"), "Ctrl+S", rule=True),
        _command("gap_report", QT_TR_NOOP("Write the report…"), "Ctrl+P", needs="gap_idle"),
        _command("gap_cards", QT_TR_NOOP("Add the deciding maneuvers to the test cards"), "Ctrl+J",
                 needs="gap_cards"),
    ),
    *_menu(
        QT_TR_NOOP("Help"), "", "nothing",
        _command("guide", QT_TR_NOOP("User guide"), "Ctrl+F1"),
        _command("keys", QT_TR_NOOP("All keys"), "?", "Shift+F1"),
        _command("copy_details", QT_TR_NOOP("Copy the details of the last error"), "Ctrl+Shift+C"),
        _command("messages", QT_TR_NOOP("Messages…"), "Ctrl+Shift+D"),
        _command("dismiss", QT_TR_NOOP("Close message"), "Ctrl+D"),
        _command("about", QT_TR_NOOP("About"), rule=True),
    ),
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
    "review_part": QT_TR_NOOP("Choose a maneuver that is part of the flight first"),
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


def _add_mnemonic(title: str, used: set[str]) -> str:
    """Return a title with an ampersand before its first letter that no other menu has."""
    for index, letter in enumerate(title):
        if letter.isalnum() and letter.casefold() not in used:
            used.add(letter.casefold())
            return f"{title[:index]}&{title[index:]}"
    return title


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
        self._present: set[str] | None = None
        for command in self.commands:
            action = CommandAction(tr(command.text), parent)
            action.setShortcuts([QKeySequence(keys) for keys in command.shortcuts])
            action.setCheckable(command.id in CHECKABLE_COMMANDS)
            action.setAutoRepeat(command.auto_repeat)
            parent.addAction(action)
            self.actions[command.id] = action

    def bind(self, *handlers: Mapping[str, Callable[[], object]]) -> None:
        """Say what each command does.

        Raises `ValueError` if a command has no handler, two of them, or a handler no command.
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
        mnemonics: set[str] = set()
        for command in self.commands:
            place = (command.menu, command.submenu)
            if (command.menu, "") not in menus:
                menus[command.menu, ""] = bar.addMenu(_add_mnemonic(tr(command.menu), mnemonics))
            if place not in menus:
                menus[place] = menus[command.menu, ""].addMenu(tr(command.submenu))
            if command.has_separator and not menus[place].isEmpty():
                menus[place].addSeparator()
            menus[place].addAction(self.actions[command.id])
        for menu in menus.values():
            menu.setToolTipsVisible(True)

    def update_enabled(self, present: Iterable[CommandRequirement]) -> None:
        """Gray what has nothing to act on, and say why; `present` says what is there."""
        there: set[str] = {"nothing", *present}
        if there == self._present:
            return
        self._present = there
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
