"""The place Preflight and its flight card, driven by keys, with pixels read."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QLineEdit
from pytestqt.qtbot import QtBot

sys.path.insert(0, str(Path(__file__).parent))

from preflight_kit import (
    ALT,
    CONTROL,
    count,
    dress,
    go,
    in_window,
    made,  # noqa: F401
    press,
    type_into,
    waiting,
    window,  # noqa: F401
)
from window_kit import until, write_flight

from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from ui.preflight.steps import STEPS
from ui.window import MainWindow


def info(window: MainWindow) -> FlightInfo:
    """Return the card that waits, as it stands on the disk."""
    return FlightFolder(path=waiting(window)).info() or FlightInfo()


# The steps


def test_alt_and_a_number_go_to_the_step_of_the_place_on_screen(
    window: MainWindow, qtbot: QtBot
) -> None:
    """The same keys belong to Model gap when that is on screen; the step is remembered."""
    for number, step in enumerate(STEPS, start=1):
        go(window, qtbot, number)
        assert window.preflight.step == step.id
        assert window.preflight.steps.buttons[step.id].isChecked()
        assert window.store.current.preflight_step == step.id
    go(window, qtbot, 3)
    qtbot.keyClick(window, Qt.Key.Key_F5)
    assert not window.commands.actions["preflight_card"].isEnabled()
    press(qtbot, Qt.Key.Key_1, ALT)
    assert window.preflight.step == "checklist"
    qtbot.keyClick(window, Qt.Key.Key_F1)
    assert window.preflight.step == "checklist"
    assert window.preflight.pages["checklist"].list.hasFocus()


def test_no_two_commands_of_one_place_share_a_key(window: MainWindow, qtbot: QtBot) -> None:
    """With what is enabled at each step; Qt does nothing for a key that two commands claim."""
    for number in range(1, 5):
        go(window, qtbot, number)
        keys = [
            key
            for command in window.commands.commands
            if window.commands.actions[command.id].isEnabled()
            for key in command.keys
        ]
        assert len(keys) == len(set(keys)), STEPS[number - 1].id


def check_states(window: MainWindow) -> None:
    """Look for the state of two steps: words, and their color in pixels."""
    shown = window.preflight.steps.buttons
    assert shown["card"].shown.words == "5 missing"
    assert "not green" in shown["checklist"].shown.words
    for name, color in (("card", "caution"), ("checklist", "warning")):
        assert count(shown[name], getattr(window.look.theme, color)) > 40, name


def test_each_step_shows_its_state_in_color_and_words(window: MainWindow, qtbot: QtBot) -> None:
    go(window, qtbot, 1)
    check_states(window)
    card = window.preflight.steps.buttons["card"]
    assert "Missing: pilot" in card.toolTip()
    assert "5 missing" in card.accessibleName()


# The card


def test_a_card_is_filled_by_keys_and_saved_as_it_is_typed(
    window: MainWindow, qtbot: QtBot
) -> None:
    """Tab goes from field to field; the file holds what was typed in the unit of the screen."""
    page = go(window, qtbot, 1)
    assert page.fields["name"][1].edit.hasFocus()
    qtbot.keyClicks(QApplication.focusWidget(), "Flight 7")
    press(qtbot, Qt.Key.Key_Tab)
    qtbot.keyClicks(QApplication.focusWidget(), "Ann")
    type_into(qtbot, page.fields["takeoff_weight"][1], "46,5")
    until(qtbot, lambda: info(window).takeoff_weight is not None)
    found = info(window)
    assert (found.name, found.crew["pilot"]) == ("Flight 7", "Ann")
    assert found.takeoff_weight == pytest.approx(206.84, abs=0.01)
    assert "46.5 lb" in (waiting(window) / "flight.toml").read_text(encoding="utf-8")
    assert page.saved.text() == "✓ Saved"
    # The other units, and back: not a digit is lost.
    press(qtbot, Qt.Key.Key_U, CONTROL)
    weight = page.fields["takeoff_weight"][1]
    assert (weight.text, weight.unit.text()) == ("21.09", "kg")
    press(qtbot, Qt.Key.Key_U, CONTROL)
    assert (weight.text, weight.unit.text()) == ("46.5", "lb")


def test_a_value_in_another_unit_is_understood(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 1)
    field = page.fields["weather.temperature"][1]
    type_into(qtbot, field, "20 degC")
    press(qtbot, Qt.Key.Key_Tab)
    assert (field.text, field.unit.text()) == ("68", "°F")
    assert info(window).weather.temperature == pytest.approx(293.15)


def test_what_will_not_do_is_told_in_words_and_is_not_on_the_card(
    window: MainWindow, qtbot: QtBot
) -> None:
    page = go(window, qtbot, 1)
    field = page.fields["fuel"][1]
    type_into(qtbot, field, "2.7 ft")
    assert "not a unit of mass" in field.sentence.text()
    assert window.preflight.steps.buttons["card"].shown.words == "1 value wrong"
    assert count(field.sentence, window.look.theme.warning) > 20
    press(qtbot, Qt.Key.Key_Tab)
    assert (field.text, info(window).fuel) == ("2.7 ft", None)
    assert "marked" in page.saved.text()
    type_into(qtbot, field, "2.7")
    assert not field.sentence.isVisible()


def test_a_slip_is_doubted_beside_the_value(window: MainWindow, qtbot: QtBot) -> None:
    """Pounds of a scale that shows kilograms: the card takes them, and says what is odd."""
    page = go(window, qtbot, 1)
    field = page.fields["takeoff_weight"][1]
    type_into(qtbot, field, "21.1")
    assert field.sentence.isVisible()
    assert "kg" in field.sentence.text()
    assert count(field.sentence, window.look.theme.caution) > 20


def test_undo_takes_back_field_by_field_and_redo_makes_it_again(
    window: MainWindow, qtbot: QtBot
) -> None:
    """Also from within a field, and on the disk."""
    page = go(window, qtbot, 1)
    pilot, fuel = page.fields["crew.pilot"][1], page.fields["fuel"][1]
    type_into(qtbot, pilot, "Ann")
    type_into(qtbot, fuel, "2.7")
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert (pilot.text, fuel.text) == ("Ann", "")
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert pilot.text == ""
    assert not info(window).crew
    press(qtbot, Qt.Key.Key_Y, CONTROL, times=2)
    assert (pilot.text, fuel.text) == ("Ann", "2.7")
    assert info(window).crew["pilot"] == "Ann"


def test_scales_say_weight_and_center_of_gravity_as_they_are_typed(
    window: MainWindow, qtbot: QtBot
) -> None:
    page = go(window, qtbot, 1)
    form = page.weighing
    form.way.setFocus()
    press(qtbot, Qt.Key.Key_Down, times=2)
    assert form.way.text == "wheels"
    fields = {name: field for name, (_value, field) in form.fields.items()}
    assert not fields["main"].isVisible()
    type_into(qtbot, fields["nose"], "4.6")
    assert "read the other scales" in fields["nose"].sentence.text()
    type_into(qtbot, fields["left"], "20.8")
    type_into(qtbot, fields["right"], "20.9")
    assert form.weight.text().startswith("46.30 ± ")
    # Nose wheel and main wheels at the places of the aircraft file.
    ahead = (4.6 * 2.62 - 41.7 * 0.26) / 46.3 * 12.0
    assert f"CG {ahead:.2f} ± " in form.words.text()
    assert "ahead of" in form.words.text()
    form.take.setFocus()
    press(qtbot, Qt.Key.Key_Return)
    assert page.fields["takeoff_weight"][1].text == "46.30"
    page.flush()
    assert info(window).weighing.loads["right"].value == pytest.approx(20.9 * 4.44822, rel=1e-4)
    # Two axles have no use for left and right.
    form.way.setFocus()
    press(qtbot, Qt.Key.Key_Up)
    assert (fields["main"].isVisible(), fields["left"].isVisible()) == (True, False)
    type_into(qtbot, fields["main"], "41.7")
    assert form.weight.text().startswith("46.30 ± ")
    page.flush()
    assert set(info(window).weighing.loads) == {"nose", "main"}


def test_the_transmitter_is_noted_with_its_mixers(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 1)
    form = page.transmitter
    for cell, text in zip(form.throws.cells[0], ("100", "60", "20", "4"), strict=True):
        type_into(qtbot, cell, text)
    source, target, share = form.mixers.cells[0]
    source.setFocus()
    press(qtbot, Qt.Key.Key_Down, times=2)
    assert "needs from, to and share" in form.mixers.sentence.text()
    target.setFocus()
    press(qtbot, Qt.Key.Key_Down, times=3)
    type_into(qtbot, share, "15")
    # Another row for the next mixer.
    assert len(form.mixers.cells) == 2
    assert not form.mixers.sentence.isVisible()
    page.flush()
    set_up = info(window).transmitter
    throw = set_up.dual_rates["elevator"]
    assert (throw.high, throw.low, throw.expo) == pytest.approx((1.0, 0.6, 0.2))
    assert set_up.trims["elevator"] == pytest.approx(0.04)
    assert [(one.source, one.target, one.share) for one in set_up.mixers] == [
        ("aileron", "rudder", pytest.approx(0.15))
    ]
    type_into(qtbot, form.throws.cells[0][1], "160")
    assert "150 %" in form.throws.sentence.text()


def test_a_flight_folder_has_its_own_card_also_after_landing(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """The debrief goes into the folder of the flight that is replayed; a plain file has no card."""
    page = go(window, qtbot, 1)
    type_into(qtbot, page.fields["crew.pilot"][1], "Ann")
    csv = write_flight(tmp_path)
    window.desk.open_flight(csv, playing=False)
    until(qtbot, lambda: window.desk.is_loaded)
    assert page.home.text().startswith("small.csv has no card")
    assert page.fields["crew.pilot"][1].text == "Ann"
    folder = FlightFolder.create(tmp_path / "landed", FlightInfo(name="Landed"))
    folder.keep_onboard_log(csv)
    window.desk.open_flight(folder.path, playing=False)
    until(qtbot, lambda: window.desk.name == "Landed")
    assert page.home.text().startswith("Card of Landed, ")
    assert page.fields["crew.pilot"][1].text == ""
    type_into(qtbot, page.fields["pilot_comments"][1], "heavy on rudder")
    qtbot.keyClick(window, Qt.Key.Key_F2)
    assert folder.info().pilot_comments == "heavy on rudder"
    # What another program writes is seen.
    qtbot.keyClick(window, Qt.Key.Key_F1)
    folder.update_info(pilot_comments="light on rudder")
    window.preflight.refresh()
    assert page.fields["pilot_comments"][1].text == "light on rudder"


def test_a_card_that_cannot_be_read_is_left_alone(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 1)
    waiting(window).mkdir(parents=True, exist_ok=True)
    (waiting(window) / "flight.toml").write_text("notes = ", encoding="utf-8")
    window.desk.changed.emit()
    until(qtbot, lambda: any("not valid TOML" in text for text in window.banners.texts()))
    assert not page.area.isEnabled()
    assert "cannot be read" in page.home.text()
    assert window.preflight.steps.buttons["card"].shown.state == "warning"
    assert (waiting(window) / "flight.toml").read_text(encoding="utf-8") == "notes = "


def check_controls(window: MainWindow) -> None:
    """Look that every control of the card is high enough, named, inside, and overlaps no other."""
    page, high = window.preflight.pages["card"], window.look.px(44)
    inside = page.area.widget()
    controls = [
        control
        for kind in (QLineEdit, QComboBox, QAbstractButton)
        for control in inside.findChildren(kind)
        if control.isVisible()
    ]
    assert len(controls) > 25
    boxes = [in_window(control, inside) for control in controls]
    width = page.area.viewport().width()
    for place, (control, box) in enumerate(zip(controls, boxes, strict=True)):
        # Borders and paddings are rounded one by one.
        assert control.height() >= high - 2, control.accessibleName()
        assert control.accessibleName()
        assert 0 <= box.left() < box.right() <= width
        assert not any(box.intersects(other) for other in boxes[place + 1 :])
    for button in window.preflight.steps.buttons.values():
        assert button.height() >= high
    assert window.rect().contains(in_window(window.preflight.steps, window))


def test_nothing_is_cut_and_all_is_high_enough_for_gloves(window: MainWindow, qtbot: QtBot) -> None:
    go(window, qtbot, 1)
    check_controls(window)
    window.resize(2560, 1600)
    qtbot.wait(30)
    check_controls(window)
    window.resize(1280, 800)
    dress(window, "high-contrast", 200)
    qtbot.wait(30)
    check_controls(window)
    check_states(window)
