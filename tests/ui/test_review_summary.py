"""The page Summary, by keys: what it tells of a campaign, what it chooses, what it writes."""

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QApplication, QFileDialog, QMainWindow
from pytestqt.qtbot import QtBot

from gsapp.aircraft import SHIPPED_AIRCRAFT, load_aircraft
from gsapp.identification.compatibility import InstrumentError
from gsapp.identification.runs.run_execution import exclude_maneuvers
from gsapp.report.estimate_report import CampaignReportData, estimate_document
from gsapp.report.form_text import campaign_form_tables
from tests.report.campaign_kit import WILD, gusty, outcome, regressed, unearned
from tests.ui.window_kit import ALT, CONTROL, until
from ui.appearance_controller import AppearanceController
from ui.commands import CommandSet
from ui.display_style import DisplayStyle
from ui.review.job_queue import JobQueue
from ui.review.review_jobs import ReviewJob, ReviewJobHandler
from ui.review.review_steps import ReviewContext, ReviewSelection
from ui.review.summary_page import SummaryPage
from ui.review.summary_rows import describe_derivative
from ui.settings import SettingsStore


class Here:
    def do(self, job: ReviewJob, tell: object) -> object:
        return ReviewJobHandler(tell).do(job)  # type: ignore[arg-type]

    def close(self) -> None:
        """End nothing."""


class Room:
    """A window with the page alone, its commands and its keys."""

    def __init__(self, folder: Path) -> None:
        self.window = QMainWindow()
        self.style = DisplayStyle()
        self.store = SettingsStore(folder / "window.toml")
        self.appearance = AppearanceController(self.style, self.store)
        self.appearance.apply()
        self.commands = CommandSet(self.window)
        self.selection = ReviewSelection()
        self.errors: list[BaseException] = []
        self.work = JobQueue(Here(), self.errors.append)
        self.page = SummaryPage(
            ReviewContext(
                actions=self.commands.actions, style=self.style, store=self.store,
                selection=self.selection, begin_job=self.work.submit,
                report_error=self.errors.append,
            )
        )  # fmt: skip
        for name, act in self.page.handlers.items():
            self.commands.actions[name].triggered.connect(lambda _on=False, act=act: act())
        self.page.changed.connect(lambda: self.commands.update_enabled(self.page.present))
        self.window.setCentralWidget(self.page)
        self.window.resize(1280, 800)
        self.window.show()

    def cells(self, key: str) -> dict[str, str]:
        """Return the cells of a derivative by the titles of their columns."""
        model = self.page.table.row_model
        line = next(one for one in model.rows if one.key == key)
        titles = [
            str(model.headerData(column, Qt.Orientation.Horizontal))
            for column in range(model.columnCount())
        ]
        return dict(zip(titles, line.cells, strict=True))


@pytest.fixture
def room(qapp: QApplication, tmp_path: Path) -> Iterator[Room]:
    made = Room(tmp_path / "settings")
    made.page.show_outcome(outcome())
    made.page.set_initial_focus()
    yield made
    made.work.close()
    made.window.close()
    made.window.deleteLater()


def test_the_page_tells_what_came_out_and_how_far_to_believe_it(room: Room) -> None:
    page = room.page
    assert page.headline.text().startswith("6 maneuvers")
    assert "their bounds" in page.validity.text()
    cells = room.cells("Cm_de")
    one = outcome().summary.derivatives["Cm_de"]
    assert float(cells["Mean"].replace("−", "-")) == pytest.approx(one.value.mean, abs=1e-3)
    assert cells["Before"].startswith("−1.10")
    assert (cells["n"], cells["Out"]) == ("5", "1")
    assert float(cells["Bound"]) == pytest.approx(one.value.std, rel=0.1)
    parts = [float(cells[name].replace("–", "0")) for name in ("Noise", "Systematic", "Disagree")]
    assert np.hypot.reduce(parts) == pytest.approx(one.value.std, rel=0.1)
    assert float(cells["Scatter"]) == pytest.approx(one.value.scatter, abs=1e-3)
    assert cells["/ bound"] == f"{one.bound_consistency.ratio:.1f} ×"  # type: ignore[union-attr]
    # Said by a sign as well as by its color, and in words beside the table.
    assert room.cells("Cm_alpha")["/ bound"] == "▲ 1.4 ×"
    assert page.attention.row_model.rows[0].cells[0] == WILD
    assert "wild: " in page.attention.row_model.rows[0].cells[1]
    assert len([one for one in page.attention.row_model.rows if one.cells[0] == WILD]) == 1
    assert page_state(room) == "1 outlying maneuver"


def page_state(room: Room) -> str:
    return room.page.state.text


def test_what_was_not_earned_has_no_number_but_a_reason(room: Room) -> None:
    """In the table in a few words, beside it in whole; italic, and never a number."""
    room.page.show_outcome(unearned())
    cells = room.cells("CN_q")
    assert "unknown" in cells["Remarks"]
    blank = ("Mean", "Bound", "%", "Scatter", "/ bound", "Before")
    assert {cells[title] for title in blank} == {"–"}
    assert cells["n"] == "0"
    line = next(one for one in room.page.table.row_model.rows if one.key == "Cm_q")
    assert line.italic
    assert line.cells[-1].startswith("not distinguished")
    assert page_state(room) == "no derivatives"
    room.selection.select_derivative("Cm_q")
    assert "hold one" in room.page.detail.text()
    assert not room.page.linear.modes.isVisible()
    assert room.page.linear.no_modes.text().startswith("No linear longitudinal")


@pytest.mark.parametrize(
    ("count", "why"),
    [(2, "Fewer than 3 values"), (4, "Its bound includes an instrument zero")],
)
def test_it_is_said_why_scatter_tells_nothing_of_a_bound(count: int, why: str) -> None:
    text = describe_derivative(regressed(count), "CN_0")
    assert f"from {count} of {count} maneuvers." in text
    assert why in text


def test_a_maneuver_in_gusts_is_to_be_looked_at(room: Room) -> None:
    """The calm one is not named."""
    room.page.show_outcome(gusty())
    lines = [one for one in room.page.attention.row_model.rows if one.cells[1] == "flown in gusts"]
    assert [one.cells[0] for one in lines] == ["M1"]
    assert lines[0].cells[2]


def test_a_row_chosen_by_keys_is_chosen_everywhere(room: Room, qtbot: QtBot) -> None:
    """Down in the table chooses a derivative; in the list of what to look at, a maneuver.

    What is chosen elsewhere is chosen here.
    """
    page = room.page
    qtbot.keyClick(page.table, Qt.Key.Key_Down)
    assert room.selection.derivative == page.table.row_model.rows[1].key == "CN_alpha"
    assert page.detail.text().startswith("CNα is 4.4")
    qtbot.keyClick(page.attention, Qt.Key.Key_Down)
    qtbot.keyClick(page.attention, Qt.Key.Key_Up)
    assert room.selection.maneuver == WILD
    room.selection.select_derivative("Cm_q")
    assert page.table.current_key() == "Cm_q"
    assert f"Maneuver {WILD} is excluded" in page.detail.text()


def test_the_chosen_row_is_seen_in_every_theme(room: Room, qtbot: QtBot) -> None:
    view = room.page.table.viewport()
    for theme in ("daylight", "dark", "high-contrast"):
        room.style.set_theme(theme)
        qtbot.wait(30)
        grabbed = view.grab().toImage()
        ratio = grabbed.devicePixelRatio()

        def line(row: int, image: object = grabbed, ratio: float = ratio) -> np.ndarray:
            box = room.page.table.visualRect(room.page.table.row_model.index(row, 1))
            y = round(box.center().y() * ratio)
            colors = [image.pixelColor(round(x * ratio), y) for x in range(box.left(), box.right())]  # type: ignore[attr-defined]
            return np.array([[one.red(), one.green(), one.blue()] for one in colors])

        chosen, other = line(0), line(1)
        assert np.abs(chosen[2] - other[2]).max() > 15, theme
        assert np.abs(other - other[2]).max() > 120, theme


def test_the_table_is_copied_for_a_spreadsheet(room: Room, qtbot: QtBot) -> None:
    qtbot.keyClick(room.window, Qt.Key.Key_C, CONTROL)
    rows = [line.split("\t") for line in QGuiApplication.clipboard().text().splitlines()]
    assert rows[0][:3] == ["derivative", "mean", "bound"]
    assert {len(row) for row in rows} == {len(rows[0])}
    found = {row[0]: row for row in rows}
    assert float(found["Cm_de"][1]) == pytest.approx(-1.104, abs=0.02)
    assert "clipboard" in room.page.message.text()


def test_a_name_is_proposed_that_every_disk_takes(
    room: Room, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Path] = []

    def ask(_parent: object, _title: str, start: str, _kinds: str) -> tuple[str, str]:
        asked.append(Path(start))
        return "", ""

    monkeypatch.setattr(QFileDialog, "getSaveFileName", ask)
    run = outcome()
    room.page.show_outcome(replace(run, request=run.request.with_changes(label='q/r: "free"')))
    qtbot.keyClick(room.window, Qt.Key.Key_P, CONTROL)
    assert [one.name for one in asked] == ["q-r- -free- report.html"]
    assert not room.work.running


def test_one_file_is_written_by_a_key_and_its_folder_remembered(
    room: Room, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "out" / "all"
    room.page.file.box.setCurrentIndex(room.page.file.box.findData("campaign.json"))
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    qtbot.keyClick(room.window, Qt.Key.Key_S, CONTROL)
    until(qtbot, lambda: room.page.writer.written is not None)
    content = json.loads(target.with_suffix(".json").read_text(encoding="utf-8"))
    assert content["campaign"]["Cm_de"]["n"] == 5
    assert room.store.current.review_folder == str(tmp_path / "out")
    assert room.commands.actions["review_open_written"].isEnabled()
    assert not room.page.buttons["review_open_written"].isHidden()


def test_a_report_that_cannot_be_written_says_why(
    room: Room, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "report.html"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    qtbot.keyClick(room.window, Qt.Key.Key_P, CONTROL)
    until(qtbot, lambda: bool(room.errors))
    assert "was not written: " in room.page.message.text()
    assert "A" in str(room.errors[0])
    assert not target.exists()


def test_linear_models_are_compared_on_demand(room: Room, qtbot: QtBot) -> None:
    """The table holds the errors of the report, the words say what judged."""
    assert room.page.linear.errors.isHidden()
    qtbot.keyClick(room.window, Qt.Key.Key_L, CONTROL | ALT)
    until(qtbot, lambda: not room.page.linear.errors.isHidden())
    assert "2 maneuvers of B" in room.page.linear.compared.text()
    comparison = room.page.linear.comparison
    assert comparison is not None
    document = estimate_document(CampaignReportData(outcome=outcome(), linear=comparison))
    table = next(
        part
        for section in document.sections
        for part in section.parts
        if getattr(part, "caption", "").startswith("RMS error over range")
    )
    shown = [line.cells[1:] for line in room.page.linear.errors.row_model.rows]
    assert shown == [row[1:] for row in table.rows]


def test_derivatives_are_shown_in_another_form(room: Room) -> None:
    """As `gsapp estimate --form` prints them, in the units of the screen."""
    forms = room.page.forms
    assert not forms.tables
    combo = forms.form.box
    combo.setCurrentIndex(combo.findData("dimensional"))
    found = outcome()
    expected = campaign_form_tables(found.result, found.summary, "US", ["dimensional"])
    assert [len(table.row_model.rows) for table in forms.tables] == [
        len(one.rows) for one in expected
    ]
    shown = {row.key: row.cells for table in forms.tables for row in table.row_model.rows}
    name, value, bound, unit = expected[0].rows[1]
    assert shown[name] == ("Xα", value.replace("-", "−"), bound, unit.replace("^2", "²"))
    assert name == "X_alpha"
    combo.setCurrentIndex(combo.findData("state-space"))
    assert any("damping ratio" in table.row_model.titles for table in forms.tables)
    combo.setCurrentIndex(0)
    assert not forms.tables


def test_what_is_left_out_by_hand_is_shown(room: Room) -> None:
    room.page.show_outcome(exclude_maneuvers(outcome(), [WILD]))
    last = room.page.attention.row_model.rows[-1]
    assert last.cells[:2] == (WILD, "excluded manually")
    assert f"({WILD})" in room.page.validity.text()
    assert room.cells("Cm_de")["n"] == "5"
    room.page.show_outcome(None)
    # Runs may be kept all the same, from yesterday.
    assert room.page.headline.text().startswith("No run")
    assert "press Enter" in room.page.headline.text()
    assert "review_results" not in room.page.present


def test_found_vane_positions_are_written_by_one_click(
    room: Room, qtbot: QtBot, tmp_path: Path
) -> None:
    file = tmp_path / "own.toml"
    shutil.copy(SHIPPED_AIRCRAFT.find("b777"), file)
    button = room.page.update_aircraft
    assert button.isHidden()
    vane = InstrumentError(
        channel="alpha", kind="position", value=0.4, std=0.02, position=(1.162, 0.0, 0.0)
    )
    request = outcome().request.with_changes(aircraft=str(file))
    room.page.show_outcome(replace(outcome(), instruments=(vane,), request=request))
    assert "alpha" in room.page.instruments.text()
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert load_aircraft(file).sensors.alpha_vane.position[0] == pytest.approx(1.162)
    assert str(file) in room.page.instruments.text()
    assert not button.isEnabled()


def test_vane_positions_do_not_go_into_a_shipped_file(room: Room, qtbot: QtBot) -> None:
    vane = InstrumentError(
        channel="alpha", kind="position", value=0.4, std=0.02, position=(1.162, 0.0, 0.0)
    )
    request = outcome().request.with_changes(aircraft="b777")
    room.page.show_outcome(replace(outcome(), instruments=(vane,), request=request))
    qtbot.mouseClick(room.page.update_aircraft, Qt.MouseButton.LeftButton)
    assert "--aircraft" in room.page.instruments.text()
    assert load_aircraft("b777").sensors.alpha_vane.position[0] != pytest.approx(1.162)
