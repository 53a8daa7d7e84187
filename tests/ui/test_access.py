"""Every control has a name for a screen reader and is reached by keys, on all pages and dialogs."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QDialog, QScrollArea, QWidget
from pytestqt.qtbot import QtBot

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
from tests.ui.shown_text import PaintedText
from tests.ui.window_kit import activate, answer_dialog, in_window, until
from tests.ui.window_walk import Walk, filled_window
from ui.dialogs.mavlink_inspector import MavlinkInspector
from ui.gap.add_and_show import ForceEffectDialog
from ui.help_menu import GuideWindow, MessagesDialog
from ui.pilot.pilot_canvas import PilotCanvas
from ui.preflight.calibration_charts import CalibrationPointList
from ui.preflight.wizard_page import WizardPage
from ui.review.maneuvers_page import GradeDialog
from ui.window_frame.banners import _ElidedLabel

_WHOLE_PAGES = (PilotCanvas, WizardPage)
"""Hold the keyboard for their page while no control of it does; they show no frame."""
_BESIDES = (_ElidedLabel,)
"""Mouse only: a press on a cut message lists all messages, as does the button beside it."""


@dataclass
class Findings:
    """What the walk found, by place."""

    places: list[str] = field(default_factory=list)
    unnamed: set[str] = field(default_factory=set)
    traps: set[str] = field(default_factory=set)
    unreached: set[str] = field(default_factory=set)
    out_of_sight: set[str] = field(default_factory=set)
    without_focus_mark: set[str] = field(default_factory=set)
    unlabeled_combo_boxes: set[str] = field(default_factory=set)
    left_open: set[str] = field(default_factory=set)


class AccessWalk(Walk):
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

    def _ask(self, before: str, command: str, kind: type[QDialog]) -> None:
        seen: list[bool] = []

        def look(_dialog: QDialog) -> None:
            self.record(command)
            seen.append(True)

        self.act(before)
        assert self.window.commands.actions[command].isEnabled(), command
        answer_dialog(kind, look)
        self.act(command)
        until(self.qtbot, lambda: bool(seen))
        activate(self.qtbot, self.window)


class CutTextWalk(Walk):
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
        walk.dialogs()
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
            window.flight_controller.close_flight()
            walk.act("place_flight")
            activate(qtbot, window)
            walk.record("Start page")
        yield walk.findings


def lines(found: set[str]) -> str:
    return f"{len(found)}\n" + "\n".join(sorted(found))


def test_every_control_has_a_name(findings: Findings) -> None:
    assert len(findings.places) > 40
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


def test_the_wizard_at_work_has_names_and_keys(tmp_path: Path, qapp: QApplication) -> None:
    leave_only(tmp_path, "elevator_left")
    window = BenchWindow(tmp_path, VirtualBench(3))
    try:
        window.press(Qt.Key.Key_Space)
        window.controller.pass_time(4.0)
        for phase in ("sign", "fit"):
            if phase != "sign":
                work_through(window, phase)
            assert window.view.phase == phase
            assert list(unnamed_controls(window)) == []
            ring = TabRing(window)
            assert not ring.trap
            missed = [one for one in controls(window) if one not in ring.stops]
            assert [one for one in missed if not isinstance(one, CalibrationPointList)] == []
            if phase == "fit":
                # The list of points is drawn; the arrows choose in it.
                window.page.set_initial_focus()
                points = window.page.findChild(CalibrationPointList)
                window.press(Qt.Key.Key_Up)
                assert points.choice is not None
            window.page.set_initial_focus()
    finally:
        window.leave()
