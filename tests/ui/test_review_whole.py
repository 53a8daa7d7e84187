"""A whole review by keys, with the real process: a flight opened, corrected, run, looked at, told.

On the way the run is stopped in the midst, and its process is killed.
"""

import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QFileDialog
from pytestqt.qtbot import QtBot

from gsapp.flight.catalog import Catalog
from gsapp.identification.runs.run_store import stored_runs
from tests.ui.review_kit import write_flights
from tests.ui.window_kit import ALT, CONTROL, KILL, SHIFT, activate, open_window, press, until
from ui.estimate_form import EstimateForm
from ui.main_window import MainWindow
from ui.review.estimate_page import EstimatePage


@pytest.fixture
def window(tmp_path: Path, qtbot: QtBot, alone: None) -> Iterator[MainWindow]:
    (tmp_path / "flights").mkdir()
    shutil.move(write_flights(tmp_path)[0], tmp_path / "flights" / "a.csv")
    made = open_window(tmp_path, review_estimate=EstimateForm(axis="lon").model_dump())
    activate(qtbot, made)
    yield made
    made.close()
    made.deleteLater()


@pytest.mark.long
def test_a_whole_review_by_keys(window, qtbot, tmp_path, monkeypatch):
    flight = tmp_path / "flights" / "a.csv"
    window.flight_controller.flight_opener.open_flight(flight, playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)
    press(qtbot, Qt.Key.Key_F4)
    review = window.review_page.review
    until(qtbot, lambda: len(review.flights) == 1)
    # Correct the first maneuver: its end, a tenth of a second at a time.
    first = review.flights[0].maneuvers[0]
    until(qtbot, lambda: window.review_page.selection.maneuver == first.id)
    press(qtbot, Qt.Key.Key_Left, CONTROL | SHIFT, times=3)
    corrected = review.flights[0][first.id]
    assert corrected.t_end == pytest.approx(first.t_end - 0.3, abs=0.02)
    press(qtbot, Qt.Key.Key_2, ALT)
    page = window.review_page.pages["estimate"]
    assert isinstance(page, EstimatePage)
    until(qtbot, lambda: page.can_run)
    # Killed in the midst: it is told, and the next run begins another process.
    press(qtbot, Qt.Key.Key_Return)
    engine = window.review_page.work._job_runner
    until(qtbot, lambda: engine.pid is not None)
    os.kill(engine.pid, KILL)
    until(qtbot, lambda: not window.review_page.work.running, 20000)
    until(qtbot, lambda: any("without a message" in text for text in window.banners.texts()))
    assert kept(page) == []
    window.banners.dismiss()
    # Stopped in the midst: nothing is kept, and nothing stands half done.
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, window.review_page.strip.isVisible)
    press(qtbot, Qt.Key.Key_Period, CONTROL)
    until(qtbot, lambda: not window.review_page.work.running)
    until(qtbot, lambda: "Stopped; nothing was saved." in page.message.text())
    assert kept(page) == []
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: window.review_page.outcome is not None, 120000)
    outcome = window.review_page.outcome
    assert kept(page) == [outcome.number]
    used = {one.id: one for one in outcome.request.maneuvers}
    assert used[first.id].t_end == corrected.t_end
    # A figure: what was estimated is drawn, and another point is chosen there.
    press(qtbot, Qt.Key.Key_3, ALT)
    figures = window.review_page.pages["figures"]
    until(qtbot, lambda: drawn(figures.view.canvas), 20000)
    press(qtbot, Qt.Key.Key_Right, times=2)
    until(qtbot, lambda: window.review_page.selection.maneuver in {*used} - {first.id})
    # Export and report.
    table, report = tmp_path / "derivatives.csv", tmp_path / "report.html"
    press(qtbot, Qt.Key.Key_4, ALT)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(table), ""))
    press(qtbot, Qt.Key.Key_S, CONTROL)
    until(qtbot, table.is_file)
    assert "Cm_de" in table.read_text(encoding="utf-8")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(report), ""))
    press(qtbot, Qt.Key.Key_P, CONTROL)
    until(qtbot, lambda: report.is_file() and not window.review_page.work.running, 60000)
    assert "Cm" in report.read_text(encoding="utf-8")
    # The correction stands beside the flight, for every command.
    events = [
        json.loads(line) for line in flight.with_name("a.csv.events.jsonl").read_text().splitlines()
    ]
    assert [one["kind"] for one in events] == ["maneuver-edit"] * 3


def kept(page: EstimatePage) -> list[int]:
    with Catalog(page.run_store.catalog) as catalog:
        return [one.number for one in stored_runs(catalog)]


def drawn(widget: object) -> bool:
    image = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    if image.isNull():
        return False
    flat = np.frombuffer(image.constBits(), dtype=np.uint32).reshape(image.height(), -1)
    colors = flat[:, : image.width()] & 0xFFFFFF
    values, counts = np.unique(colors, return_counts=True)
    blue = (values & 0xFF).astype(int) - ((values >> 16) & 0xFF).astype(int) > 60
    return bool(counts[blue].sum() > 200)
