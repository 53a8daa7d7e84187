"""A walk through the whole window, with a flight, an estimate, a search and a debrief in it."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication, QDialog
from pytestqt.qtbot import QtBot

import ui.gap.gap_page
import ui.main_window
import ui.review.review_page
from gsapp.discrepancy.results import FlightRegion
from tests.ui.gap_kit import FakeEngine
from tests.ui.pilot_kit import CARDS, STATES, debrief
from tests.ui.review_kit import ThreadEngine, write_flights
from tests.ui.shown_text import PaintedText, shown_texts
from tests.ui.window_kit import answer_dialog, open_window, until
from ui.appearance_controller import SettingsDialog
from ui.dialogs.connect import ConnectDialog
from ui.dialogs.flight_dialogs import ExportDialog, GoToDialog, RangeDialog
from ui.dialogs.limits import LimitsDialog
from ui.dialogs.virtual_flight import VirtualFlightDialog
from ui.estimate_form import EstimateForm
from ui.gap.search_jobs import GapRequest
from ui.help_menu import AboutDialog, ShortcutsDialog
from ui.main_window import MainWindow
from ui.pilot.page_state import FlightCues
from ui.review.figure_kinds import FIGURE_KINDS
from ui.review.review_jobs import EstimateJob

DIALOGS: dict[str, type[QDialog]] = {
    "settings": SettingsDialog,
    "connect": ConnectDialog,
    "virtual": VirtualFlightDialog,
    "export": ExportDialog,
    "go_to": GoToDialog,
    "type_range": RangeDialog,
    "type_limits": LimitsDialog,
    "keys": ShortcutsDialog,
    "about": AboutDialog,
}


class MetricEngine(FakeEngine):
    """Gives an answer whose sentences hold metric values, as a search writes them."""

    def do(self, job, tell):
        answer = super().do(job, tell)
        found = answer.discrepancy
        region = FlightRegion(variable="V", low=20.0, high=26.2, words="V below 26.2 m/s")
        return replace(
            answer,
            remarks=("the CG was 26 mm aft, mass 20.5 kg",),
            discrepancy=replace(
                found,
                why="Turbulence of about 0.3 m/s disturbed the flights.",
                warnings=("air density was not measured; 1.225 kg/m^3 is used",),
                disagreements=tuple(replace(one, region=region) for one in found.disagreements),
                alternatives=tuple(
                    replace(one, fly="the same doublet at 80 ft/s and 120 ft/s")
                    for one in found.alternatives
                ),
            ),
        )


class MetricReview(ThreadEngine):
    """Gives a run whose remarks hold metric values."""

    def do(self, job, tell):
        done = super().do(job, tell)
        if not isinstance(job, EstimateJob):
            return done
        first, *rest = done.result.results
        assert first.estimate is not None
        stopped = replace(first.estimate, converged=False, message="stopped at 26.2 m/s")
        results = (replace(first, estimate=stopped), *rest)
        return replace(
            done,
            remarks=("no linear model of that axis: 27 m/s and 31 m/s", *done.remarks),
            result=replace(done.result, results=results),
            models={},
        )


class Walk:
    """Goes through the window and looks at all that it shows."""

    def __init__(
        self, window: MainWindow, painted: PaintedText, qtbot: QtBot, patch: pytest.MonkeyPatch
    ) -> None:
        self.window, self.painted, self.qtbot, self.patch = window, painted, qtbot, patch
        self.found: dict[str, str] = {}

    def record(self, where: str) -> None:
        QApplication.processEvents()
        self.window.grab()
        for text, widget in shown_texts().items():
            self.found.setdefault(text, f"{where}: {widget}")
        for text in self.painted.texts:
            self.found.setdefault(text, f"{where}: painted")
        self.painted.texts.clear()

    def act(self, *commands: str) -> None:
        for command in commands:
            self.window.commands.actions[command].trigger()
        QApplication.processEvents()

    def dialogs(self) -> None:
        self.act("place_flight")
        for command, kind in DIALOGS.items():
            seen: list[bool] = []

            def collect(dialog: QDialog, command: str = command, seen: list[bool] = seen) -> None:
                dialog.grab()
                self.record(command)
                seen.append(True)

            assert self.window.commands.actions[command].isEnabled(), command
            answer_dialog(kind, collect)
            self.act(command)
            until(self.qtbot, lambda seen=seen: bool(seen))

    def places(self) -> None:
        window = self.window
        self.act("place_preflight")
        for step in ("card", "calibration", "checklist", "cards"):
            self.act(f"preflight_{step}")
            self.record(f"Preflight, {step}")
        self.act("place_flight")
        for panel in ("channels", "values", "marks", "alarms", "messages", "estimates", "plot"):
            self.act(f"panel_{panel}")
            self.record(f"Flight, {panel}")
        self.act("place_pilot", "pilot_page")
        for name in ("fly", "input", "not-trimmed"):
            self.patch.setattr(FlightCues, "snapshot", lambda _self, name=name: STATES[name])
            window.pilot_page.state.restart()
            window.pilot_page.refresh()
            self.record(f"Pilot, {name}")
        self.act("pilot_debrief")
        page = window.pilot_page.debrief.page
        for row in (0, 6):
            page.list.select_row(row)
            self.record("Debrief")
        self.act("place_gap")
        for chapter in ("find", "name", "add", "show"):
            self.act(f"gap_{chapter}")
            self.record(f"Model gap, {chapter}")
        self.review()

    def review(self) -> None:
        window = self.window
        self.act("place_review")
        for step in ("maneuvers", "estimate", "summary"):
            self.act(f"review_{step}")
            self.record(f"Review, {step}")
        self.act("review_figures")
        figures = window.review_page.pages["figures"]
        for kind in FIGURE_KINDS:
            if kind.needs:
                continue  # takes seconds; words and axes are those of the others
            drawn: list[object] = []
            figures.view.drawn.connect(drawn.append)
            figures.show_kind(kind.id)
            until(self.qtbot, lambda drawn=drawn: bool(drawn) or not figures.view.rendered_figure)
            self.record(f"Review, figure {kind.id}")


@contextmanager
def filled_window(
    tmp_path: Path, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> Iterator[MainWindow]:
    """Return a window with a flight, an estimate, an answer of Model gap, and a debrief."""
    monkeypatch.setenv("GSAPP_RUNTIME_FOLDER", str(tmp_path / "run"))
    monkeypatch.setattr(ui.main_window, "ask_closing", lambda *_: "leave")
    monkeypatch.setattr(ui.gap.gap_page, "create_search_job_runner", MetricEngine)
    monkeypatch.setattr(ui.review.review_page, "create_review_job_runner", MetricReview)
    shown = debrief()
    monkeypatch.setattr(FlightCues, "is_open", True)
    monkeypatch.setattr(FlightCues, "cards", CARDS)
    monkeypatch.setattr(FlightCues, "debrief", lambda _self: shown)
    made = open_window(tmp_path, review_estimate=EstimateForm(axis="lon", method="ee").model_dump())
    made.activateWindow()
    flight = write_flights(tmp_path)[0]
    made.flight_controller.flight_opener.open_flight(flight, playing=False)
    until(qtbot, lambda: made.flight_controller.is_loaded)
    made.show_page("review")
    made.review_page.add_flights([flight])
    until(qtbot, made.commands.actions["review_estimate"].isEnabled)
    made.commands.actions["review_estimate"].trigger()
    page = made.review_page.pages["estimate"]
    until(qtbot, lambda: page.can_run)
    made.commands.actions["review_run"].trigger()
    made.gap_page.search.search(GapRequest(flights=(flight,), model="b777"))
    until(
        qtbot,
        lambda: made.review_page.outcome is not None and made.gap_page.search.result is not None,
    )
    made.banners.note_timeout_ms = 600_000  # a walk takes longer than a note stays
    made.banners.show_banner("note", "Kept: the take-off weight is 20.7 kg.")
    yield made
    made.close()
    made.deleteLater()
