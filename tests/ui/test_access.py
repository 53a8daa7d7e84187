"""Every control has a name for a screen reader and is reached by keys, on all pages and dialogs."""

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QComboBox,
    QDialog,
    QInputDialog,
    QMessageBox,
    QScrollArea,
    QWidget,
)
from pytestqt.qtbot import QtBot

import ui
from gsapp.session.live_estimation.live_search import LiveSearchResult
from gsapp.telemetry.log_download import parse_log_link
from gsapp.telemetry.recorder_status import HEARTBEAT_END
from gsapp.virtual.bench import VirtualBench
from tests.ui.access_kit import (
    TabRing,
    controls,
    cut_texts,
    describe,
    is_reached_by_arrows,
    label_name,
    unnamed_controls,
)
from tests.ui.bench_kit import BenchWindow, leave_only, work_through
from tests.ui.gap_kit import make_discrepancy, make_open
from tests.ui.shown_text import PaintedText
from tests.ui.window_kit import activate, answer_dialog, in_window, until
from tests.ui.window_walk import Walk, filled_window
from ui.dialogs.flight_dialogs import (
    CertificatesDialog,
    ChannelMapDialog,
    ask_append,
    ask_closing,
    ask_stop,
)
from ui.dialogs.mavlink_inspector import MavlinkInspector
from ui.dialogs.signing_key_field import SigningKeyField
from ui.gap.add_and_show import ForceEffectDialog
from ui.help_menu import GuideWindow, MessagesDialog
from ui.pilot.pilot_canvas import PilotCanvas
from ui.preflight.calibration_charts import CalibrationPointList
from ui.preflight.wizard_page import WizardPage
from ui.review.maneuvers_page import GradeDialog
from ui.review.onboard_log_dialog import FlightLogs, OnboardLogDialog
from ui.sharing_menu import ShareDialog
from ui.widgets.message_boxes import show_warning
from ui.window_frame.banners import _ElidedLabel

_WHOLE_PAGES = (PilotCanvas, WizardPage)
"""Hold the keyboard for their page while no control of it does; they show no frame."""
_BESIDES = (_ElidedLabel,)
"""Mouse only: a press on a cut message lists all messages, as does the button beside it."""


@dataclass
class Findings:
    """What the walk found, by place."""

    places: list[str] = field(default_factory=list)
    dialogs: set[type] = field(default_factory=set)
    unnamed: set[str] = field(default_factory=set)
    traps: set[str] = field(default_factory=set)
    unreached: set[str] = field(default_factory=set)
    out_of_sight: set[str] = field(default_factory=set)
    without_focus_mark: set[str] = field(default_factory=set)
    unlabeled_combo_boxes: set[str] = field(default_factory=set)
    left_open: set[str] = field(default_factory=set)


class WholeWalk(Walk):
    """Opens every kind of dialog, and pages in states that a flight reaches only at times."""

    def other_dialogs(self) -> None:
        self._ask("place_flight", "link", MavlinkInspector)
        for command, kind in (("guide", GuideWindow), ("messages", MessagesDialog)):
            self.act(command)
            opened = self.window.findChild(kind)
            activate(self.qtbot, opened)
            self.record(command)
            opened.close()
            activate(self.qtbot, self.window)
        self.act("place_review", "review_maneuvers")
        self._ask("review_next_maneuver", "review_grade", GradeDialog)
        self.act("place_gap")
        self._ask("gap_add", "gap_force", ForceEffectDialog)
        self.act("gap_search")
        self.record("Model gap, new search")

    def rare_dialogs(self, folder: Path) -> None:
        """Open what needs a flight, a file or a moment of its own, by its owner's method."""
        window, style = self.window, self.window.display_style
        box = QMessageBox
        self._open("ask stop", box, lambda: ask_stop(window, "flight", HEARTBEAT_END))
        self._open("ask append", box, lambda: ask_append(window, "flight", "flight-2"))
        self._open("ask closing", box, lambda: ask_closing(window, ["flight"], ["Estimate"]))
        self._open("warning", box, lambda: show_warning(window, "Title", "A sentence."))
        self._open("heading", QInputDialog, window.view.channels._add_heading)
        self._open("layout", QInputDialog, window.view.channels._ask_name)
        key = SigningKeyField("", folder, style)
        self.qtbot.addWidget(key)
        self._open("passphrase", QInputDialog, key._ask_passphrase)
        self._open("share", ShareDialog, window.file_menu.sharing.ask_address)
        self._open("map", ChannelMapDialog, lambda: window.file_menu._ask_map(folder / "a.bin"))
        self._open("certificates", CertificatesDialog, window.file_menu.reload_with_certificates)
        logs = FlightLogs(
            path=folder, name="f", in_force="now.bin", state=None,
            stored_logs=("now.bin", "old.bin"), link="udpin:127.0.0.1:15000",
        )  # fmt: skip
        for row, title in enumerate(("file", "link", "stored", "none")):
            dialog = OnboardLogDialog(style, (logs,), (), parse_log_link, tuple, window)
            dialog.origin.setCurrentIndex(row)
            self._open(f"on-board log, {title}", OnboardLogDialog, dialog.exec)

    def rare_pages(self) -> None:
        window = self.window
        self.act("place_pilot", "pilot_window")
        activate(self.qtbot, window.pilot_page.own_window.window)
        self.record("Pilot, separate window")
        window.pilot_page.own_window.window.close()
        activate(self.qtbot, window)
        self.act("place_flight", "panel_estimates")
        evidence = window.view.estimates.search
        steps = [LiveSearchResult(time=40.0, maneuvers=4, verdict="ambiguous", evidence={"x": 0.5},
                                  experiment=make_open(make_discrepancy()).experiment)]  # fmt: skip
        show = window.view.show_state
        with self.patch.context() as patch:  # Each tick shows the state of the flight again.
            patch.setattr(
                window.view, "show_state",
                lambda state: show(replace(state, has_search=True, search_enabled=True,
                                           search_steps=steps, search_state="4 maneuvers")),
            )  # fmt: skip
            until(self.qtbot, evidence.cards_button.isVisible)
            self.qtbot.wait(200)  # The page grows.
            self.record("Flight, live search")
        self.act("place_gap")
        window.gap_page._show_result_view()
        self.act("gap_find")
        view = window.gap_page.result_view
        undecided = replace(view.result, discrepancy=make_open(view.result.discrepancy))
        view.show_result(undecided)
        assert view.cards_button.isVisible()
        self.record("Model gap, undecided")
        search = window.gap_page.search
        engine, request = search._job_runner, search.result.request
        engine.effects = ("unnamed.CA.absbeta",)
        engine.hold.clear()
        search.search(request)
        until(self.qtbot, lambda: window.gap_page.busy)
        self.record("Model gap, search under way")
        engine.hold.set()
        until(self.qtbot, lambda: not window.gap_page.busy)
        self.act("gap_add")
        assert view.stages["add"].structure.isVisible()
        self.record("Model gap, structure without a name")

    def _ask(self, before: str, command: str, kind: type[QDialog]) -> None:
        self.act(before)
        assert self.window.commands.actions[command].isEnabled(), command
        self._open(command, kind, lambda: self.act(command))

    def _open(self, where: str, kind: type[QDialog], opening: Callable[[], object]) -> None:
        seen: list[bool] = []

        def look(_dialog: QDialog) -> None:
            self.record(where)
            seen.append(True)

        answer_dialog(kind, look)
        opening()
        until(self.qtbot, lambda: bool(seen))
        activate(self.qtbot, self.window)


class AccessWalk(WholeWalk):
    """Goes through the window with Tab and asks for the names of all that it shows."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*arguments)
        self.findings = Findings()
        self._seen: set[tuple[object, ...]] = set()

    def record(self, where: str) -> None:
        QApplication.processEvents()
        top = QApplication.activeWindow()
        assert top is not None
        found = self.findings
        found.places.append(where)
        found.dialogs.add(type(top))
        ring = TabRing(top)
        found.unnamed |= {f"{where}: {name}" for name in unnamed_controls(top)}
        if ring.trap:
            found.traps.add(f"{where}: {ring.trap}")
        found.out_of_sight |= {f"{where}: {describe(stop)}" for stop in ring.out_of_sight}
        for control in controls(top):
            if control in ring.stops or control is ring.start or is_reached_by_arrows(control):
                continue
            if not isinstance(control, _BESIDES):
                found.unreached.add(f"{where}: {describe(control)}")
        for stop in ring.stops:
            self._look_at(stop, where)
        if isinstance(top, QDialog):
            QTest.keyClick(top, Qt.Key.Key_Escape)
            if top.isVisible():
                found.left_open.add(where)

    def _look_at(self, stop: QWidget, where: str) -> None:
        """Compare a control with and without the focus, once for each kind."""
        kind = (type(stop), stop.objectName(), stop.property("role"), stop.isEnabled())
        if isinstance(stop, QComboBox) and not label_name(
            QAccessible.queryAccessibleInterface(stop)
        ):
            self.findings.unlabeled_combo_boxes.add(f"{where}: {describe(stop)}")
        if kind in self._seen or isinstance(stop, _WHOLE_PAGES) or stop.size().isEmpty():
            return
        self._seen.add(kind)
        stop.setFocus(Qt.FocusReason.TabFocusReason)
        top, parent = stop.window(), stop.parentWidget()
        while parent is not None:
            if isinstance(parent, QScrollArea):
                parent.ensureWidgetVisible(stop)
            parent = parent.parentWidget()
        with_focus = top.grab(in_window(stop, top)).toImage()
        stop.clearFocus()
        if top.grab(in_window(stop, top)).toImage() == with_focus:
            self.findings.without_focus_mark.add(f"{where}: {describe(stop)}")
        stop.setFocus(Qt.FocusReason.TabFocusReason)


class CutTextWalk(WholeWalk):
    """Looks for texts that have no room."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*arguments)
        self.cut: set[str] = set()

    def record(self, where: str) -> None:
        QApplication.processEvents()
        top = QApplication.activeWindow()
        assert top is not None
        self.cut |= {f"{where}: {text}" for text in cut_texts(top)}


def test_no_text_is_cut_at_250_percent(
    tmp_path: Path, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    size = (1280, 800)
    with filled_window(tmp_path, qtbot, monkeypatch) as window:
        activate(qtbot, window)
        window.display_style.set_scale(250)
        window.resize(*size)
        walk = CutTextWalk(window, PaintedText(monkeypatch), qtbot, monkeypatch)
        walk.places()
        walk.other_dialogs()
        walk.dialogs()
        walk.rare_dialogs(tmp_path)
        walk.rare_pages()
        # No page needs a wider or higher window.
        assert window.size().toTuple() == size
    assert not walk.cut, lines(walk.cut)


@pytest.fixture(scope="module")
def findings(
    tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest, qapp: QApplication
) -> Iterator[Findings]:
    qtbot = QtBot(request)
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("access")
        with filled_window(folder, qtbot, patch) as window:
            activate(qtbot, window)
            walk = AccessWalk(window, PaintedText(patch), qtbot, patch)
            walk.places()
            walk.other_dialogs()
            walk.dialogs()
            walk.rare_dialogs(folder)
            walk.rare_pages()
            window.flight_controller.close_flight()
            walk.act("place_flight")
            activate(qtbot, window)
            walk.record("Start page")
        yield walk.findings


def lines(found: set[str]) -> str:
    return f"{len(found)}\n" + "\n".join(sorted(found))


def test_every_kind_of_dialog_is_in_the_walk(findings: Findings) -> None:
    for module in pkgutil.walk_packages(ui.__path__, "ui."):
        importlib.import_module(module.name)
    kinds, found = [QDialog], set[type]()
    while kinds:
        below = [one for one in kinds.pop().__subclasses__() if one.__module__.startswith("ui.")]
        kinds += below
        found |= {one for one in below if not one.__subclasses__()}
    assert len(found) > 15
    assert found <= findings.dialogs


def test_every_control_has_a_name(findings: Findings) -> None:
    assert len(findings.places) > 60, len(findings.places)
    assert not findings.unnamed, lines(findings.unnamed)


def test_combo_boxes_have_labels(findings: Findings) -> None:
    """On Linux their name is their value; a screen reader finds the label that belongs to them."""
    assert not findings.unlabeled_combo_boxes, lines(findings.unlabeled_combo_boxes)


def test_tab_goes_round_both_ways(findings: Findings) -> None:
    assert not findings.traps, lines(findings.traps)


def test_every_enabled_control_is_reached_by_keys(findings: Findings) -> None:
    assert not findings.unreached, lines(findings.unreached)


def test_the_focus_is_seen(findings: Findings) -> None:
    assert not findings.out_of_sight, lines(findings.out_of_sight)
    assert not findings.without_focus_mark, lines(findings.without_focus_mark)


def test_escape_closes_every_dialog(findings: Findings) -> None:
    assert not findings.left_open, lines(findings.left_open)


def check_wizard(window: BenchWindow) -> None:
    QApplication.processEvents()
    assert list(unnamed_controls(window)) == []
    ring = TabRing(window)
    assert not ring.trap
    missed = [one for one in controls(window) if one not in ring.stops]
    assert [one for one in missed if not isinstance(one, CalibrationPointList)] == []


def test_the_wizard_at_work_has_names_and_keys(tmp_path: Path, qapp: QApplication) -> None:
    leave_only(tmp_path, "elevator_left")
    window = BenchWindow(tmp_path, VirtualBench(3))
    try:
        window.press(Qt.Key.Key_Space)
        window.controller.pass_time(4.0)
        for phase in ("sign", "points", "fit"):
            if phase != "sign":
                work_through(window, phase)
            assert window.view.phase == phase
            check_wizard(window)
            if phase == "fit":
                # The list of points is drawn; the arrows choose in it.
                window.page.set_initial_focus()
                points = window.page.findChild(CalibrationPointList)
                window.press(Qt.Key.Key_Up)
                assert points.choice is not None
            window.page.set_initial_focus()
        work_through(window)
        assert window.page.pages.currentWidget() is window.page.summary
        check_wizard(window)
    finally:
        window.leave()


@pytest.mark.parametrize(
    ("channel", "phase", "question"),
    [
        ("p", "gyro_still", "skip"),
        ("ax", "accel_position", "abort"),
        ("static_pressure", "pressure_zero", "enter"),
        ("alpha", "sign", "add"),
        ("beta", "sign", "choose_degree"),
    ],
)
def test_the_wizard_asks_with_names_and_keys(
    channel: str, phase: str, question: str, tmp_path: Path, qapp: QApplication
) -> None:
    window = BenchWindow(tmp_path, VirtualBench(3))
    try:
        window.page.calibrate_instrument(channel)
        window.controller.pass_time(4.0)
        assert window.view.phase == phase
        check_wizard(window)
        window.page._questions.ask(question, window.page.run)
        assert window.page.question_bar.isVisible()
        check_wizard(window)
    finally:
        window.leave()
