"""The chapter Estimate, driven by keys: settings, saved runs, compared, repeated, stopped."""

import math
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLineEdit, QWidget
from pytestqt.qtbot import QtBot

import ui.main_window
import ui.review.review_page
from gsapp.dynamics.model import load_model, save_model
from gsapp.flight.catalog import Catalog
from gsapp.identification.runs.run_store import stored_runs
from tests.ui.review_kit import ThreadEngine, write_flights
from tests.ui.window_kit import ALT, CONTROL, SHIFT, activate, opened_window, press, until
from ui.display_style import DisplayStyle
from ui.estimate_form import EstimateForm
from ui.main_window import MainWindow
from ui.review.estimate_page import EstimatePage
from ui.review.estimate_request import build_run_request
from ui.review.estimate_tables import (
    LAST_COLUMN,
    NAME_COLUMN,
    TREATMENT_COLUMN,
    VALUE_COLUMN,
    DerivativeTable,
)
from ui.settings import catalog_path

PLAIN = Qt.KeyboardModifier.NoModifier
QUICK = EstimateForm(axis="lon")
"""Where it does not matter what is estimated."""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, qapp: QApplication) -> Iterator[MainWindow]:
    folder = tmp_path_factory.mktemp("window")
    (folder / "flights").mkdir()
    flights = write_flights(folder / "flights")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ui.review.review_page, "create_review_job_runner", ThreadEngine)
        chosen = tuple(str(path) for path in flights)
        with opened_window(folder, review_flights=chosen, review_chapter="estimate") as window:
            yield window


@pytest.fixture
def page(made: MainWindow, qtbot: QtBot) -> Iterator[EstimatePage]:
    activate(qtbot, made)
    made.show_page("flight")
    press(qtbot, Qt.Key.Key_F4)
    press(qtbot, Qt.Key.Key_2, ALT)
    page = made.review_page.pages["estimate"]
    assert isinstance(page, EstimatePage)
    page._show(QUICK)
    until(qtbot, lambda: page.can_run and len(made.review_page.review.flights) == 2)
    page.set_initial_focus()
    yield page
    made.review_page.work._job_runner.hold.set()
    made.review_page.work.cancel()
    until(qtbot, lambda: not made.review_page.work.running)


def run(page: EstimatePage, qtbot: QtBot) -> None:
    count = len(page.run_store.runs)
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    until(qtbot, lambda: len(page.run_store.runs) == count + 1 and not page._runner.running, 30000)


def test_enter_alone_runs_and_the_run_is_kept(made, page, qtbot):
    """The keyboard waits on the button; what came out stands beside the settings and in the list.

    The catalog holds the run, as `gsapp runs` shows it.
    """
    assert page.button.hasFocus()
    count = len(page.selected_maneuvers)
    assert f"{count} maneuvers of 2 flights" in page.message.text()
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: bool(page.run_store.runs), 30000)
    outcome = made.review_page.outcome
    assert outcome.number == 1
    assert "Run 1:" in page.message.text()
    table = page.panel.derivatives
    shown = table.row_model.index(table.names.index("Cm_de"), LAST_COLUMN).data()
    mean = outcome.summary.derivatives["Cm_de"].value.mean
    assert float(str(shown).split()[0].replace("−", "-")) == pytest.approx(mean, rel=0.02)
    assert page.state.detail == f"run 1: {count} maneuvers"
    with Catalog(catalog_path(made.store.current)) as catalog:
        (kept,) = stored_runs(catalog)
    assert kept.values["Cm_de"].mean == mean
    assert page.runs.values.row_model.rows[0].cells[0] == "CN0"


def test_what_stands_beside_is_the_run_that_ended_last(made, page, qtbot):
    run(page, qtbot)
    first = page.runs.current_run
    run(page, qtbot)
    outcome = made.review_page.outcome
    assert outcome.number != first.number
    until(qtbot, lambda: page.runs.current_run is not None)
    assert page.runs.current_run.number == outcome.number  # type: ignore[union-attr]
    # Lines that come later leave it where the user put it.
    page.runs.list.select_row(first.number)
    page.runs.refresh()
    assert page.runs.current_run.number == first.number  # type: ignore[union-attr]
    # As after a start of the program: none is looked at, and these are there.
    page.show_outcome(None)
    assert page.state.text == f"{len(page.run_store.runs)} runs saved"
    page.show_outcome(outcome)


def test_a_derivative_is_held_by_keys_taken_back_and_explained(made, page, qtbot):
    """Typed over the value it is held; without a number the field says so and nothing runs."""
    table = page.panel.derivatives
    table.setFocus()
    assert "Hold one at" in page.head.explained.text()
    cells = [table.row_model.index(row, NAME_COLUMN) for row in range(table.row_model.rowCount())]
    assert max(table.sizeHintForIndex(cell).width() for cell in cells) <= table.columnWidth(
        NAME_COLUMN
    )
    row = table.names.index("Cm_q")
    table.setCurrentIndex(table.row_model.index(row, VALUE_COLUMN))
    for letter in "-2x":
        qtbot.keyClicks(QApplication.focusWidget(), letter)
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: page._form.derivative("Cm_q").treated == "held")
    assert "'-2x' is not a number" in page.message.text()
    assert not page.can_run
    assert not made.commands.actions["review_run"].isEnabled()
    table.setFocus()
    table.setCurrentIndex(table.row_model.index(row, VALUE_COLUMN))
    press(qtbot, Qt.Key.Key_Return)
    editor = QApplication.focusWidget()
    assert isinstance(editor, QLineEdit)
    editor.setText("-22.5")
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: page.can_run)
    assert made.store.current.review_estimate == page._form
    run(page, qtbot)
    outcome = made.review_page.outcome
    held = outcome.result.results[0].estimate.derivatives["Cm_q"]
    assert (held.status, held.value) == ("held", -22.5)
    table.setFocus()
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert page._form.derivative("Cm_q").treated == "tables"
    press(qtbot, Qt.Key.Key_Y, CONTROL)
    assert page._form.derivative("Cm_q").treated == "held"
    table.setCurrentIndex(table.row_model.index(row, TREATMENT_COLUMN))
    press(qtbot, Qt.Key.Key_Delete)
    until(qtbot, lambda: page._form == QUICK)


def test_parameters_of_the_effects_of_a_model_can_be_freed(page, qtbot, tmp_path):
    curved = load_model("b777").with_effect("aero.Cm.alpha2", {"Cm_alpha2": -1.5}, name="curved")
    page._show(QUICK.with_changes(model=str(save_model(curved, tmp_path / "curved.toml"))))
    table = page.panel.derivatives
    name = "aero.Cm.alpha2.Cm_alpha2"
    row = table.names.index(name)
    assert table.row_model.data(table.row_model.index(row, VALUE_COLUMN)) == "-1.5"
    table.setFocus()
    table.setCurrentIndex(table.row_model.index(row, TREATMENT_COLUMN))
    press(qtbot, Qt.Key.Key_Space)
    assert page._form.derivative(name).treated == "free"
    asked = build_run_request(page._form, (), ())
    assert (asked.free, asked.free_effects) == (None, (name,))
    page._show(page._form.with_changes(model=""))
    assert name not in table.names
    assert page._form.derivatives == {}


def test_runs_are_compared_named_repeated_forgotten_and_their_settings_used_again(
    made: MainWindow, page: EstimatePage, qtbot: QtBot
) -> None:
    until(qtbot, lambda: bool(page.run_store.runs) or not page.run_store.catalog.is_file())
    run(page, qtbot)
    page.panel.bound_factor.setFocus()
    qtbot.keyClicks(page.panel.bound_factor, "10")
    until(qtbot, lambda: page._form.bound_factor == "10")
    run(page, qtbot)
    newest, before = page.run_store.runs[0].number, page.run_store.runs[1].number
    runs = page.runs.list
    runs.setFocus()
    runs.select_row(before)
    press(qtbot, Qt.Key.Key_Space)
    runs.select_row(newest)
    differing = [line.cells for line in page.runs.settings.row_model.rows]
    assert differing == [("bounds", "10 times Cramer-Rao", "corrected for colored residuals")]
    one, other = (page.run_store.find_run(number) for number in (newest, before))
    assert one is not None
    assert other is not None
    name = page.runs.values.row_model.rows[0].key
    apart = abs(one.values[name].mean - other.values[name].mean) / math.hypot(
        one.values[name].std, other.values[name].std
    )
    assert page.runs.values.row_model.rows[0].cells[3].endswith(f"{apart:.1f} bounds")
    press(qtbot, Qt.Key.Key_N, CONTROL | SHIFT)
    editor = QApplication.focusWidget()
    assert isinstance(editor, QLineEdit)
    editor.setText("as in the source")
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: page.run_store.runs[0].label == "as in the source")
    runs.select_row(before)
    press(qtbot, Qt.Key.Key_U, CONTROL | SHIFT)
    assert page._form == QUICK
    assert f"those of run {before}" in page.message.text()
    runs.setFocus()
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: "dentical to the last bit" in page.message.text(), 30000)
    count = len(page.run_store.runs)
    runs.select_row(newest)
    press(qtbot, Qt.Key.Key_Delete)
    until(qtbot, lambda: len(page.run_store.runs) == count - 1)
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    until(qtbot, lambda: page.run_store.find_run(newest) is not None)


def test_a_copy_of_a_flight_is_told_beside_the_button(made, page, qtbot, tmp_path):
    """The same flight from another folder narrows the bounds of the means: that is said at once."""
    maneuvers = made.review_page.pages["maneuvers"]
    opening = maneuvers.opening
    copy = Path(shutil.copy(made.review_page.review.flights[0].path, tmp_path / "copy.csv"))
    opening.open([copy])
    until(qtbot, lambda: len(made.review_page.review.flights) == 3 and not opening.status_text)
    try:
        until(qtbot, lambda: page.can_run)
        page.set_initial_focus()
        run(page, qtbot)
        assert "flights 1 and 3" in page.message.text()
    finally:
        flights = maneuvers.flights
        flights.select_flight(made.review_page.review.flights[2])
        flights.remove_flight()


def test_runs_that_cannot_be_read_are_not_called_none(made, page, qtbot):
    """A damaged catalog may hold some; once it can be read, nothing is said of it."""
    page.run_store.runs = ()
    path = catalog_path(made.store.current)
    kept = path.read_bytes() if path.is_file() else None
    path.write_bytes(b"no catalog" * 500)
    try:
        page.run_store.reload()
        until(qtbot, lambda: "They cannot be read" in page.runs.empty.text())
        assert "damaged" in page.runs.empty.text()
    finally:
        path.unlink()
        if kept is not None:
            path.write_bytes(kept)
    page.run_store.reload()
    until(qtbot, lambda: page.runs.empty.text().startswith("No runs yet"))


def test_what_is_typed_while_a_run_ends_stays(made, page, qtbot):
    """The name of a kept run and a value to hold are typed on while new values arrive."""
    run(page, qtbot)
    count, named = len(page.run_store.runs), page.run_store.runs[0].number
    engine = made.review_page.work._job_runner
    engine.hold.clear()
    page.panel.label.setText("first")
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    page.panel.label.setText("second")
    page.runs.list.select_row(named)
    press(qtbot, Qt.Key.Key_N, CONTROL | SHIFT)
    qtbot.keyClicks(QApplication.focusWidget(), "calm")
    engine.hold.set()
    until(qtbot, lambda: len(page.run_store.runs) == count + 1 and not page._runner.running, 30000)
    qtbot.keyClicks(QApplication.focusWidget(), " air")
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: page.run_store.find_run(named).label == "calm air")
    assert (page.run_store.runs[0].label, page.panel.label.text()) == ("first", "second")
    page.panel.label.clear()
    table = page.panel.derivatives
    table.setFocus()
    table.setCurrentIndex(table.row_model.index(table.names.index("Cm_q"), VALUE_COLUMN))
    for letter in "-2":
        qtbot.keyClicks(QApplication.focusWidget(), letter)
    table.show_last({"Cm_q": "-20.0"})
    qtbot.keyClicks(QApplication.focusWidget(), "2")
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: page._form.derivative("Cm_q").value == "-22")


def test_a_value_is_shown_with_all_of_its_bound(qtbot: QtBot) -> None:
    table = DerivativeTable(DisplayStyle())
    qtbot.addWidget(table)
    table.resize(500, 300)
    table.set_form(EstimateForm(axis="lat"))
    table.show()
    for last in (
        {"Cn_0": "−0.5 ± 0.1"},
        {"Cn_0": "−0.0000129 ± 0.0000067", "Cl_p": "−1.06 ± 0.01"},
    ):
        table.show_last(last)
        assert table.sizeHintForColumn(LAST_COLUMN) <= table.columnWidth(LAST_COLUMN)
        high = table.sizeHintForRow(table.names.index("Cn_0"))
        assert high <= table.rowHeight(0)
        bar = table.horizontalScrollBar()
        assert table.viewport().height() >= table.rowHeight(0) * min(12, len(table.names))
    assert bar.isVisible()


def test_a_run_that_is_stopped_leaves_nothing(made, page, qtbot):
    until(qtbot, lambda: bool(page.run_store.runs) or not page.run_store.catalog.is_file())
    before, count = made.review_page.outcome, len(page.run_store.runs)
    engine = made.review_page.work._job_runner
    engine.hold.clear()
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    until(qtbot, lambda: made.review_page.strip.isVisible() and "left" not in page.message.text())
    assert not made.commands.actions["review_run"].isEnabled()
    press(qtbot, Qt.Key.Key_Period, CONTROL)
    until(qtbot, lambda: not made.review_page.work.running)
    assert not made.review_page.strip.isVisible()
    until(qtbot, lambda: "Stopped; nothing was saved." in page.message.text())
    assert made.review_page.outcome is before
    assert len(page.run_store.runs) == count
    engine.hold.set()
    run(page, qtbot)


def test_a_run_that_cannot_be_kept_is_shown_and_says_so(made, page, qtbot, tmp_path, monkeypatch):
    before = made.review_page.outcome
    (tmp_path / "file").touch()
    monkeypatch.setattr(page.run_store, "_catalog", lambda: tmp_path / "file" / "campaign.sqlite")
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    until(qtbot, lambda: made.review_page.outcome is not before, 30000)
    outcome = made.review_page.outcome
    assert outcome.number is None
    assert "not saved" in page.message.text()
    assert page.state.text.startswith("not saved")
    monkeypatch.undo()
    page.run_store.reload()
    until(qtbot, lambda: page.run_store._job is None)


@pytest.mark.parametrize("way", ["button", "key"])
def test_a_run_tells_of_itself_while_another_place_is_on_screen(
    made: MainWindow, page: EstimatePage, qtbot: QtBot, way: str
) -> None:
    engine = made.review_page.work._job_runner
    engine.hold.clear()
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    press(qtbot, Qt.Key.Key_F2)
    until(qtbot, lambda: any("Estimating" in text for text in made.banners.texts()))
    engine.hold.set()
    until(qtbot, lambda: any(text == "Estimating: done." for text in made.banners.texts()), 30000)
    banner = next(one for one in made.banners.banners if one.label.text() == "Estimating: done.")
    if way == "button":
        banner.buttons[0].click()
    else:
        press(qtbot, Qt.Key.Key_F4)
    assert made.review_page.isVisible()
    # Nobody offers to show what is on screen.
    assert "Estimating: done." not in made.banners.texts()


def test_every_control_can_be_reached_and_has_a_name(page: EstimatePage, qtbot: QtBot) -> None:
    seen: list[QWidget] = []
    for _ in range(80):
        focus = QApplication.focusWidget()
        assert focus is not None
        if focus in seen:
            break
        seen.append(focus)
        press(qtbot, Qt.Key.Key_Tab)
    inside = [one for one in seen if page.isAncestorOf(one)]
    assert all(one.accessibleName() for one in inside)
    assert {page.panel.method, page.panel.derivatives, page.panel.stand_ins} <= set(inside)
