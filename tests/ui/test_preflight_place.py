"""The place Preflight, driven by keys, with pixels read: card, checklist, test cards."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from pathlib import Path
from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QFileDialog, QLineEdit
from pytestqt.qtbot import QtBot

from calibration import Certificate, load_certificates, write_certificate
from calibration.certificate_store import CertificateStore, CheckRecord
from calibration.drift import CheckResult
from calibration.plan import CALIBRATION_PLANS
from calibration.validity import CalibrationInForce
from calibration.wizard import WizardView
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT, load_aircraft
from gsapp.flight.cards import load_cards
from gsapp.flight.events import read_events
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.maneuvers import DetectedManeuver
from gsapp.foundation import FlightError
from gsapp.quantities.constants import DEGREE, FOOT
from gsapp.telemetry.recorder_control import find_recorders
from tests.ui.preflight_kit import ALT, CONTROL, SHIFT, as_opened, dress, go, waiting
from tests.ui.window_kit import (
    Aircraft,
    count,
    free_port,
    in_window,
    press,
    type_into,
    until,
    write_flight,
)
from ui.dialogs.flight_requests import ConnectRequest
from ui.main_window import MainWindow
from ui.number_format import MINUS
from ui.preflight.calibration_controller import CalibrationController, CalibrationFolder
from ui.preflight.card_set_model import find_cards_state
from ui.preflight.flight_card_fields import list_missing_values
from ui.preflight.preflight_model import PreflightModel
from ui.preflight.preflight_steps import PREFLIGHT_STEPS
from ui.preflight.wizard_rows import list_instrument_statuses
from ui.preflight.wizard_text import build_prompt
from ui.settings import SettingsStore, calibrations_path

_PATIENCE_MS = 30_000
"""A recorder is a process of its own, which may take a while to start."""


@pytest.fixture
def window(made: MainWindow, qtbot: QtBot) -> Iterator[MainWindow]:
    yield from as_opened(made, qtbot)


def info(window: MainWindow) -> FlightInfo:
    return FlightFolder(path=waiting(window)).info() or FlightInfo()


# The steps


def test_alt_and_a_number_go_to_the_step_of_the_place_on_screen(
    window: MainWindow, qtbot: QtBot
) -> None:
    for number, step in enumerate(PREFLIGHT_STEPS, start=1):
        go(window, qtbot, number)
        assert window.preflight_page.step == step.id
        assert window.preflight_page.steps.buttons[step.id].isChecked()
        assert window.store.current.preflight_step == step.id
    go(window, qtbot, 3)
    qtbot.keyClick(window, Qt.Key.Key_F5)
    assert not window.commands.actions["preflight_card"].isEnabled()
    press(qtbot, Qt.Key.Key_1, ALT)
    assert window.preflight_page.step == "checklist"
    qtbot.keyClick(window, Qt.Key.Key_F1)
    assert window.preflight_page.step == "checklist"
    assert window.preflight_page.pages["checklist"].list.hasFocus()


def check_of(certificate: Certificate, zero: float, slope: float, *, passed: bool) -> CheckRecord:
    result = CheckResult(
        zero=zero, zero_uncertainty=0.1, slope=slope, slope_uncertainty=0.01, largest=1.6,
        off=(1.4, 1.5, 1.6), passed=passed, sentence="",
    )  # fmt: skip
    return CheckRecord(
        channel="rudder", who="", stamp=certificate.stamp, certificate=certificate.stamp,
        unit="deg", result=result,
    )  # fmt: skip


def test_a_check_that_failed_stands_at_its_step(tmp_path: Path) -> None:
    store = SettingsStore(tmp_path / "window.toml")
    rudder = load_certificates(store.current.calibration)["rudder"]
    calibrations = CertificateStore(calibrations_path(store.path), "B777")
    calibrations.put_in_force(rudder)
    books = PreflightModel(store)
    books.read_calibration()
    assert "moved" not in books.step_states()["calibration"].text
    calibrations.record_check(check_of(rudder, 1.5, 0.0, passed=False))
    books.read_calibration()
    state = books.step_states()["calibration"]
    assert (state.state, state.text) == ("warning", "1 moved")
    assert "Rudder" in state.detail
    # Somebody wrote into the file: then nothing is known, and nothing breaks.
    calibrations.checks("rudder")[-1].write_text("passed = maybe", encoding="utf-8")
    books.read_calibration()
    assert "moved" not in books.step_states()["calibration"].text


@pytest.mark.parametrize(
    ("zero", "slope", "passed", "what", "size"),
    [
        (0.02, 0.12, False, "slope", "+12.0 %"),
        (0.02, -0.125, False, "slope", f"{MINUS}12.5 %"),
        (1.5, 0.004, False, "zero", "+1.50°"),
        (0.02, 0.008, True, "zero", "+0.02°"),
    ],
)
def test_a_check_names_what_moved(
    tmp_path: Path, zero: float, slope: float, passed: bool, what: str, size: str
) -> None:
    """A lever at another hole changes the slope alone: a zero that moved by nothing is no news."""
    rudder = load_certificates("b777")["rudder"]
    calibrations = CalibrationFolder(calibrations_path(tmp_path / "window.toml"), "B777")
    calibrations.store.put_in_force(rudder)
    checked = check_of(rudder, zero, slope, passed=passed)
    calibrations.store.record_check(checked)
    plan = calibrations.load_plan_in_use().select_kinds(("surface",))
    (standing,) = [
        one for one in list_instrument_statuses(plan, calibrations) if one.title == "Rudder"
    ]
    assert standing.text.endswith(f"{'holds' if passed else 'has moved'}: {what} {size}")
    (instrument,) = [one for one in plan.instruments if one.channel == "rudder"]
    view = WizardView(
        instrument=instrument,
        index=0,
        count=1,
        phase="fit",
        prompt="",
        mode="check",
        check_result=checked.result,
    )
    cue = build_prompt(view)
    assert (cue.caption, cue.main_text) == (f"The {what} has moved by", size)


@pytest.mark.parametrize(
    ("replaying", "aircraft", "kept"), [(False, "B777", True), (True, "B777", False),
                                        (False, "Skywalker X8", False)],
)  # fmt: skip
def test_certificates_go_only_into_the_flight_that_goes_on(
    tmp_path: Path, replaying: bool, aircraft: str, kept: bool
) -> None:
    store = SettingsStore(tmp_path / "window.toml")
    calibrations = CalibrationFolder(calibrations_path(store.path), aircraft, "b777")
    calibrations.store.put_in_force(load_certificates("b777")["rudder"])
    flight = FlightFolder.create(tmp_path / "flight")
    session = SimpleNamespace(
        aircraft=load_aircraft("b777"), path=flight.path, replay_feed=flight if replaying else None
    )
    at_hand = CalibrationController(
        SimpleNamespace(session=session), store, SimpleNamespace(running=False)
    )
    at_hand.apply(at_hand.folder if aircraft == at_hand.folder.aircraft else calibrations)
    assert [path.stem for path in flight.certificate_files()] == (["rudder"] if kept else [])
    assert load_certificates(store.current.calibration)["rudder"].channel == "rudder"


def test_the_last_operator_is_found_among_stamps_with_and_without_a_zone(tmp_path: Path) -> None:
    folder = CalibrationFolder(calibrations_path(tmp_path / "window.toml"), "B777")
    certificate = load_certificates("b777")["rudder"]
    noon = datetime.fromisoformat("2026-05-12T12:00")
    for channel, who, stamp in (
        ("rudder", "Ada", noon),
        ("flap", "Bo", noon.astimezone(timezone(timedelta(hours=-9))) + timedelta(hours=1)),
        ("alpha", "Cy", noon.astimezone(timezone(timedelta(hours=9))) - timedelta(hours=1)),
    ):
        folder.store.put_in_force(replace(certificate, channel=channel, who=who, stamp=stamp))
    assert folder.last_operator() == "Bo"


def test_no_fuel_is_a_value_too() -> None:
    info = FlightInfo.model_validate({"fuel": "0 lb", "crew": {"pilot": "A"}})
    assert list_missing_values(info) == ("take-off weight", "temperature", "pressure")
    assert "fuel at start" in list_missing_values(FlightInfo())


def test_the_step_of_the_cards_counts_what_is_wrong() -> None:
    cards = load_cards("b777")
    for problems, text in ((("no number",), "1 value wrong"), (("a", "b"), "2 values wrong")):
        assert find_cards_state(cards, None, problems, own=True, flies=False).text == text


def test_an_aircraft_has_the_same_calibrations_with_and_without_a_flight(tmp_path: Path) -> None:
    file = tmp_path / "skywalker-2026.toml"
    text = (SHIPPED_AIRCRAFT.folder / "b777.toml").read_text(encoding="utf-8")
    file.write_text(text.replace('name = "B777"', 'name = "Skywalker X8"'), encoding="utf-8")
    store = SettingsStore(tmp_path / "window.toml")
    known = load_certificates(store.current.calibration)
    del known["rudder"]
    for name, certificate in known.items():
        write_certificate(certificate, tmp_path / "known" / f"{name}.toml")
    store.change(aircraft=str(file), calibration=str(tmp_path / "known"))
    plans = calibrations_path(store.path) / "plans"
    plans.mkdir(parents=True)
    plan = (CALIBRATION_PLANS.folder / "b777.toml").read_text(encoding="utf-8")
    (plans / "Skywalker X8.toml").write_text(plan.replace('"Rudder"', '"Tail"'), encoding="utf-8")
    in_force = CalibrationInForce(certificates=known, flight_date=None, missing=["rudder"])
    flight = SimpleNamespace(aircraft=load_aircraft(file), calibration_in_force=in_force)
    practice = SimpleNamespace(running=False)
    for session in (None, flight):
        controller = SimpleNamespace(session=session)
        assert CalibrationController(controller, store, practice).folder.aircraft == "Skywalker X8"
        books = PreflightModel(store)
        books.session = session
        books.read_calibration()
        assert "Rudder surface" in books.step_states()["calibration"].detail


def check_states(window: MainWindow) -> None:
    shown = window.preflight_page.steps.buttons
    assert shown["card"].state.text == "5 missing"
    assert "not green" in shown["checklist"].state.text
    for name, color in (("card", "caution"), ("checklist", "warning")):
        assert count(shown[name], getattr(window.display_style.theme, color)) > 40, name


def test_each_step_shows_its_state_in_color_and_words(window: MainWindow, qtbot: QtBot) -> None:
    go(window, qtbot, 1)
    check_states(window)
    card = window.preflight_page.steps.buttons["card"]
    assert "Missing: pilot" in card.toolTip()
    assert "5 missing" in card.accessibleName()


# The card


def test_a_card_is_filled_by_keys_and_saved_as_it_is_typed(
    window: MainWindow, qtbot: QtBot
) -> None:
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
    assert "unit of mass" in field.message.text()
    assert window.preflight_page.steps.buttons["card"].state.text == "1 value wrong"
    assert count(field.message, window.display_style.theme.warning) > 20
    press(qtbot, Qt.Key.Key_Tab)
    assert (field.text, info(window).fuel) == ("2.7 ft", None)
    assert "marked" in page.saved.text()
    type_into(qtbot, field, "2.7")
    assert not field.message.isVisible()


def test_a_slip_is_doubted_beside_the_value(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 1)
    field = page.fields["takeoff_weight"][1]
    type_into(qtbot, field, "21.1")
    assert field.message.isVisible()
    assert "kg" in field.message.text()
    assert count(field.message, window.display_style.theme.caution) > 20


def test_undo_takes_back_field_by_field_and_redo_makes_it_again(
    window: MainWindow, qtbot: QtBot
) -> None:
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
    assert "other scales" in fields["nose"].message.text()
    type_into(qtbot, fields["left"], "20.8")
    type_into(qtbot, fields["right"], "20.9")
    assert form.weight.text().startswith("46.30 ± ")
    # Nose wheel and main wheels at the places of the aircraft file.
    ahead = (4.6 * 2.62 - 41.7 * 0.26) / 46.3 * 12.0
    assert f"CG {ahead:.2f} ± " in form.summary.text()
    assert "ahead of" in form.summary.text()
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
    assert form.mixers.message.text()
    target.setFocus()
    press(qtbot, Qt.Key.Key_Down, times=3)
    type_into(qtbot, share, "15")
    # Another row for the next mixer.
    assert len(form.mixers.cells) == 2
    assert not form.mixers.message.isVisible()
    page.flush()
    set_up = info(window).transmitter
    throw = set_up.dual_rates["elevator"]
    assert (throw.high, throw.low, throw.expo) == pytest.approx((1.0, 0.6, 0.2))
    assert set_up.trims["elevator"] == pytest.approx(0.04)
    assert [(one.source, one.target, one.share) for one in set_up.mixers] == [
        ("aileron", "rudder", pytest.approx(0.15))
    ]
    type_into(qtbot, form.throws.cells[0][1], "160")
    assert "150 %" in form.throws.message.text()


def test_a_flight_folder_has_its_own_card_also_after_landing(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    page = go(window, qtbot, 1)
    type_into(qtbot, page.fields["crew.pilot"][1], "Ann")
    csv = write_flight(tmp_path)
    window.flight_controller.flight_opener.open_flight(csv, playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)
    assert page.home.text().startswith("small.csv")
    assert page.fields["crew.pilot"][1].text == "Ann"
    folder = FlightFolder.create(tmp_path / "landed", FlightInfo(name="Landed"))
    folder.store_onboard_log(csv)
    window.flight_controller.flight_opener.open_flight(folder.path, playing=False)
    until(qtbot, lambda: window.flight_controller.name == "Landed")
    assert page.home.text().startswith("Card of Landed, ")
    assert page.fields["crew.pilot"][1].text == ""
    type_into(qtbot, page.fields["pilot_comments"][1], "heavy on rudder")
    qtbot.keyClick(window, Qt.Key.Key_F2)
    assert folder.info().pilot_comments == "heavy on rudder"
    # What another program writes is seen.
    qtbot.keyClick(window, Qt.Key.Key_F1)
    folder.update_info(pilot_comments="light on rudder")
    window.preflight_page.refresh()
    assert page.fields["pilot_comments"][1].text == "light on rudder"


def test_a_card_with_more_loading_than_rows_grow_loses_none(
    window: MainWindow, qtbot: QtBot
) -> None:
    """Eight things written by hand, one of them changed on the form: eight remain."""
    listed = "".join(
        f'[[loading]]\nwhat = "thing {n}"\nmass = "{n} lb"\nposition = ["1 ft", "0 ft", "0 ft"]\n'
        for n in range(1, 9)
    )
    waiting(window).mkdir(parents=True, exist_ok=True)
    (waiting(window) / "flight.toml").write_text(listed, encoding="utf-8")
    page = go(window, qtbot, 1)
    window.flight_controller.changed.emit()
    cells = page.loading.rows.cells
    until(qtbot, lambda: len(cells) == 8)
    type_into(qtbot, cells[0][1], "9")
    page.flush()
    masses = [one.mass / 0.45359237 for one in info(window).loading]
    assert masses == pytest.approx([9, 2, 3, 4, 5, 6, 7, 8], rel=1e-3)


def test_a_card_that_cannot_be_read_is_left_alone(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 1)
    waiting(window).mkdir(parents=True, exist_ok=True)
    (waiting(window) / "flight.toml").write_text("notes = ", encoding="utf-8")
    window.flight_controller.changed.emit()
    until(qtbot, lambda: any("not valid TOML" in text for text in window.banners.texts()))
    assert not page.area.isEnabled()
    assert "cannot be read" in page.home.text()
    assert window.preflight_page.steps.buttons["card"].state.state == "warning"
    assert (waiting(window) / "flight.toml").read_text(encoding="utf-8") == "notes = "


def check_controls(window: MainWindow) -> None:
    """Look that every control of the card is high enough, named, inside, and overlaps no other."""
    page, high = window.preflight_page.pages["card"], window.display_style.px(44)
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
    for index, (control, box) in enumerate(zip(controls, boxes, strict=True)):
        # Borders and paddings are rounded one by one.
        assert control.height() >= high - 2, control.accessibleName()
        assert control.accessibleName()
        assert 0 <= box.left() < box.right() <= width
        crossing = [
            controls[at].accessibleName()
            for at, other in enumerate(boxes[index + 1 :], index + 1)
            if box.intersects(other)
        ]
        assert not crossing, (control.accessibleName(), crossing, box)
    for button in window.preflight_page.steps.buttons.values():
        assert button.height() >= high
    assert window.rect().contains(in_window(window.preflight_page.steps, window))


def test_nothing_is_cut_and_all_is_high_enough_for_gloves(window: MainWindow, qtbot: QtBot) -> None:
    go(window, qtbot, 1)
    qtbot.waitUntil(lambda: check_controls(window), timeout=30_000)  # laid out
    window.resize(2560, 1600)
    qtbot.waitUntil(lambda: check_controls(window), timeout=30_000)  # laid out
    window.resize(1280, 800)
    dress(window, "high-contrast", 200)
    qtbot.waitUntil(lambda: check_controls(window), timeout=30_000)  # laid out
    check_states(window)
    check_lines(window, qtbot, 3)
    check_lines(window, qtbot, 4)


def check_lines(window: MainWindow, qtbot: QtBot, step: int) -> None:
    lines = go(window, qtbot, step).list
    shown = lines.viewport()
    assert lines.height() >= window.display_style.px(120)
    assert window.rect().contains(in_window(lines, window))
    for row in range(2):
        box = lines.visualRect(lines.row_model.index(row, 0))
        assert 0 <= box.left() < box.right() <= shown.width()
        assert count(shown, window.display_style.theme.text, box & shown.rect()) > 400


def state_of(window: MainWindow, item_id: str) -> str:
    items = window.preflight_page.model.checklist.items
    return next(item.state for item in items if item.id == item_id)


# The checklist


def test_space_ticks_item_after_item_and_undo_takes_back(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 3)
    book = page.model
    begun = len(book.open_items)
    assert page.list.hasFocus()
    first = page.list.current_key
    press(qtbot, Qt.Key.Key_Space, times=2)
    assert len(book.ticks) == 2
    assert first in book.ticks
    assert page.summary.text == f"{begun - 2} not green"
    assert page.list.current_key not in book.ticks
    assert len(read_events(waiting(window) / "events.jsonl").events) == 2
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert book.ticks == {first}
    press(qtbot, Qt.Key.Key_Y, CONTROL)
    assert len(book.ticks) == 2
    press(qtbot, Qt.Key.Key_Backspace, CONTROL | SHIFT)
    assert not book.ticks
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert len(book.ticks) == 2


def test_what_telemetry_says_cannot_be_ticked_by_hand(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 3)
    page.list.select_item("link")
    press(qtbot, Qt.Key.Key_Space)
    assert "cannot be ticked" in page.message.text()
    assert state_of(window, "link") == "open"


def test_nothing_is_ticked_begun_anew_or_started_in_a_replay(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    window.flight_controller.flight_opener.open_flight(write_flight(tmp_path), playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded, _PATIENCE_MS)
    page = go(window, qtbot, 3)
    before, items = page.model.ticks, page.model.items
    item = next(item for item in items if item.can_tick)
    assert not page.model.toggle(item.id)
    page.model.restart()
    assert page.model.record_start() == ""
    assert page.model.ticks == before
    page.list.select_item(item.id)
    press(qtbot, Qt.Key.Key_Space)
    assert "This is a replay" in page.message.text()
    assert page.model.ticks == before


def test_without_a_flight_there_is_nothing_to_start(window: MainWindow, qtbot: QtBot) -> None:
    go(window, qtbot, 3)
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    assert any("connect" in text for text in window.banners.texts())
    assert window.preflight_page.isVisible()


def test_the_crews_own_list_is_opened_and_counts_as_soon_as_it_is_saved(
    window: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[Path] = []
    monkeypatch.setattr(
        QDesktopServices, "openUrl", lambda url: opened.append(Path(url.toLocalFile())) or True
    )
    page = go(window, qtbot, 3)
    page.list.select_item("airframe")
    press(qtbot, Qt.Key.Key_Space)
    press(qtbot, Qt.Key.Key_E, CONTROL | SHIFT)
    own = window.store.path.parent / "checklist.toml"
    assert opened == [own]
    text = own.read_text(encoding="utf-8")
    assert "[[items]]" in text
    short = 'name = "Ours"\n[[items]]\nid = "airframe"\nwords = "All tight"\n'
    own.write_text(short + '[[items]]\nid = "sky"\nwords = "Sky clear"\n', encoding="utf-8")
    until(qtbot, lambda: len(page.model.items) == 2)
    assert state_of(window, "airframe") == "green"
    assert page.summary.text == "1 not green"
    own.write_text(short + "[[items]]\nid = 3\n", encoding="utf-8")
    until(qtbot, lambda: "items[1]" in page.message.text())
    assert len(page.model.items) == 2


def test_telemetry_turns_items_green_and_starting_all_the_same_is_recorded(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """From the card that waited to the start: in the folder of the flight, with a real recorder."""
    card = go(window, qtbot, 1)
    type_into(qtbot, card.fields["crew.pilot"][1], "Ann")
    page = go(window, qtbot, 3)
    page.list.select_item("airframe")
    press(qtbot, Qt.Key.Key_Space)
    folder, port = tmp_path / "flights" / "first", free_port()
    request = ConnectRequest(
        link=f"udpin:127.0.0.1:{port}", folder=folder, channel_map="b777", aircraft="b777",
        calibration="b777",
    )  # fmt: skip
    try:
        with Aircraft(port):
            window.flight_controller.flight_opener.connect_aircraft(request)
            until(qtbot, lambda: window.flight_controller.is_open, _PATIENCE_MS)
            assert FlightFolder(path=folder).info().crew == {"pilot": "Ann"}
            assert state_of(window, "airframe") == "green"
            until(qtbot, lambda: state_of(window, "link") == "green", _PATIENCE_MS)
            until(qtbot, lambda: state_of(window, "recorder") == "green", _PATIENCE_MS)
            # The box's supply is simulated far too low: red, in a red band, on top.
            until(qtbot, lambda: page.model.items[0].state == "red", _PATIENCE_MS)
            until(qtbot, lambda: page.list.row_model.rows[0].value.state == "warning", _PATIENCE_MS)
            shown = page.list.viewport()
            top = page.list.visualRect(page.list.row_model.index(0, 0))
            theme = window.display_style.theme
            assert count(shown, theme.warning_band, top) > 0.5 * top.width() * top.height()
            last = page.list.visualRect(page.list.row_model.index(5, 0))
            assert count(shown, theme.warning_band, last) == 0
            assert count(page.red, theme.warning) > 100
            page.list.setFocus()
            press(qtbot, Qt.Key.Key_Return, CONTROL)
            assert window.pages.currentWidget() is window.flight_page
            assert any("anyway" in text for text in window.banners.texts())
    finally:
        for recorder in find_recorders():
            recorder.stop()
    starts = [
        event for event in read_events(folder / "events.jsonl").events
        if event.kind == "flight-start"
    ]  # fmt: skip
    assert len(starts) == 1
    assert "excitation" in starts[0].data["red"]
    assert "airframe" in starts[0].data["green"]
    assert "Flight started at" in page.model.started_text


# Test cards


def cards_file(window: MainWindow) -> Path:
    return waiting(window) / "cards.toml"


def test_cards_are_added_changed_moved_and_removed_by_keys(
    window: MainWindow, qtbot: QtBot
) -> None:
    """Each step is on the disk, and each is taken back with the same key."""
    page = go(window, qtbot, 4)
    assert page.list.hasFocus()
    shipped = [card.id for card in page.model.cards.cards]
    assert not cards_file(window).exists()
    press(qtbot, Qt.Key.Key_Down)
    press(qtbot, Qt.Key.Key_N, CONTROL)
    # The name is ready to be typed over.
    qtbot.keyClicks(QApplication.focusWidget(), "X7")
    type_into(qtbot, page.form.fields["speed"], "110")
    type_into(qtbot, page.form.fields["repeats"], "5")
    press(qtbot, Qt.Key.Key_Escape)
    assert page.list.hasFocus()
    made = load_cards(cards_file(window)).card("X7")
    assert (made.speed, made.repeats) == (pytest.approx(110 * FOOT), 5)
    press(qtbot, Qt.Key.Key_Up, ALT, times=2)
    assert [card.id for card in load_cards(cards_file(window)).cards] == ["X7", *shipped]
    assert page.list.current_key == "X7"
    press(qtbot, Qt.Key.Key_Delete)
    assert [card.id for card in load_cards(cards_file(window)).cards] == shipped
    while page.undo_history.canUndo():
        press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert page.model.editor.file.content["cards"][1]["id"] == shipped[1]
    assert len(page.model.cards.cards) == len(shipped)
    press(qtbot, Qt.Key.Key_Y, CONTROL)
    assert len(load_cards(cards_file(window)).cards) == len(shipped) + 1


@pytest.mark.parametrize("step", [1, 4])
def test_what_the_disk_refuses_is_not_said_to_be_being_saved(
    window: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch, step: int
) -> None:
    page = go(window, qtbot, step)
    editor = page.editor if step == 1 else page.model.editor
    said = page.saved if step == 1 else page.message

    def refuse() -> None:
        raise FlightError("the disk is full")

    with monkeypatch.context() as disk:
        disk.setattr(type(editor), "save", lambda _self: refuse())
        if step == 1:
            type_into(qtbot, page.fields["weather.temperature"][1], "68")
            assert said.text() == "Saving…"
            press(qtbot, Qt.Key.Key_Tab)
        else:
            press(qtbot, Qt.Key.Key_N, CONTROL)
        assert said.text().endswith("Not saved")
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert not said.text().endswith("Not saved")


def test_a_card_says_what_will_not_do(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 4)
    fields = page.form.fields
    for name, text, words in (
        ("id", page.model.cards.cards[1].id, "two cards have the id"),
        ("repeats", "two", "not a whole number"),
        ("speed", "900", "not a plausible speed"),
    ):
        type_into(qtbot, fields[name], text)
        assert words in fields[name].message.text()
        assert count(fields[name].message, window.display_style.theme.warning) > 20
        press(qtbot, Qt.Key.Key_Z, CONTROL)
        assert not fields[name].message.isVisible()
    assert window.preflight_page.steps.buttons["cards"].state.state != "warning"


def test_other_surfaces_ask_for_their_own_amplitudes(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 4)
    fields = page.form.fields
    fields["surfaces"].setFocus()
    while page.model.cards.cards[0].surfaces != ("da", "dr"):
        press(qtbot, Qt.Key.Key_Down)
    assert (fields["da"].isVisible(), fields["dr"].isVisible(), fields["de"].isVisible()) == (
        True, True, False,
    )  # fmt: skip
    type_into(qtbot, fields["dr"], "9")
    amplitudes = page.model.cards.cards[0].amplitudes
    assert amplitudes["dr"] == pytest.approx(9 * DEGREE)
    assert amplitudes["da"] == pytest.approx(4.5 * DEGREE)


def test_cards_are_saved_for_others_and_taken_from_a_file(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = go(window, qtbot, 4)
    path = tmp_path / "monday.toml"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), ""))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(path), ""))
    press(qtbot, Qt.Key.Key_S, CONTROL)
    assert load_cards(path).cards == page.model.cards.cards
    path.write_text(
        'name = "Monday"\n[[cards]]\nid = "Q"\nspeed = "30 m/s"\nsurfaces = ["dr"]\n'
        'amplitude = "8 deg"\nwidth = "0.4 s"\n',
        encoding="utf-8",
    )
    press(qtbot, Qt.Key.Key_O, CONTROL | ALT)
    assert page.title.text() == "Monday: 1 maneuver"
    press(qtbot, Qt.Key.Key_Delete)
    assert len(page.model.cards.cards) == 1
    assert page.message.text()
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert page.title.text().startswith("B777")
    path.write_text("cards = 3", encoding="utf-8")
    press(qtbot, Qt.Key.Key_O, CONTROL | ALT)
    until(qtbot, lambda: any("monday.toml" in text for text in window.banners.texts()))


def flown(card_surfaces: tuple[str, ...], speed: float, size: float) -> DetectedManeuver:
    return DetectedManeuver(
        id="1", t_start=10.0, t_end=16.0, inputs=card_surfaces, kind="doublet", amplitude=size,
        grade="A", reasons=(), V=speed, alpha=0.05, t_input=11.0, t_input_end=11.9,
        amplitudes={card_surfaces[0]: size},
    )  # fmt: skip


def test_a_flight_without_cards_has_none_at_every_place(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    folder = FlightFolder.create(tmp_path / "landed", FlightInfo(name="Landed"))
    folder.store_onboard_log(write_flight(tmp_path))
    window.flight_controller.flight_opener.open_flight(folder.path, playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)
    page = go(window, qtbot, 4)
    shown = window.preflight_page.steps.buttons["cards"]
    good = flown(("de",), page.model.cards.cards[0].speed, 4.5 * DEGREE)
    for found in (False, True):
        if found:
            page.model.set_maneuvers((good,))
        window.preflight_page.refresh()
        assert window.pilot_page.cues.cards is None
        assert shown.state.text == "none in this flight"
    folder.store_cards(page.model.cards)
    assert "of 5 cards done" in page.model.state.text


def test_the_list_says_which_cards_are_done(window: MainWindow, qtbot: QtBot) -> None:
    page = go(window, qtbot, 4)
    card = page.model.cards.cards[0]
    good = flown(("de",), card.speed, 4.5 * DEGREE)
    page.model.set_maneuvers((good, good, good, flown(("de",), card.speed, 20 * DEGREE)))
    page._show_list()
    lines = [row.value for row in page.list.row_model.rows]
    assert (lines[0].state, lines[0].state_text) == ("good", "3 of 3")
    assert lines[1].state_text.startswith("0 of")
    assert "done" in page.model.state.text
    box = page.list.visualRect(page.list.row_model.index(0, 0))
    assert count(page.list.viewport(), window.display_style.theme.good, box) > 60
    window.resize(860, 800)
    qtbot.wait(30)
    assert not page.form.isVisible()
    page.list.setFocus()
    press(qtbot, Qt.Key.Key_Return)
    assert (page.form.isVisible(), page.list.isVisible()) == (True, False)
    press(qtbot, Qt.Key.Key_Escape)
    assert page.list.hasFocus()
