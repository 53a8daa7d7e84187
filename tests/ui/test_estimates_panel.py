"""Derivatives beside the charts: words, pixels, keys; a real replay fitted in another process."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from pytestqt.qtbot import QtBot

from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.discrepancy.results import DecidingExperiment
from gsapp.flight.cards import TestCard
from gsapp.flight.flight_import import import_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.writers import write_block
from gsapp.identification.campaign import CampaignValue
from gsapp.quantities import trace_color
from gsapp.session import UNLIMITED_SPEED
from gsapp.session.live_estimation.estimate_table import EstimateRow, FittedPoint
from gsapp.session.live_estimation.fit_workers import ProcessFitWorker
from gsapp.session.live_estimation.live_search import LiveSearch, LiveSearchResult
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.ui.window_kit import KILL, pixels, until
from ui.display_style import DisplayStyle
from ui.flight.estimates_panel import (
    EstimatesPanel,
    accessible_row_text,
    bound_percent_text,
    describe_value,
    fit_status_text,
)
from ui.flight.evidence_panel import EvidencePanel, evidence_curves, search_status_text
from ui.main_window import MainWindow

TIMES = np.arange(0.0, 100.0, 0.1)
KNOWN = EstimateRow(
    name="Cm_alpha", value=-0.33, std=0.0066, progress=1.0, why="", times=TIMES,
    values=np.where(TIMES > 40.0, -0.33, np.nan), prior=-0.34, change_text="9 % to 2.0 %",
    points=(FittedPoint(maneuver="M1", time=45.0, value=-0.335, std=0.004),),
    mean=CampaignValue(mean=-0.335, std=0.004, scatter=None, n=1), methods=("ml",),
)  # fmt: skip
UNKNOWN = replace(
    KNOWN, name="Cl_da", value=None, std=None, progress=0.4, points=(), mean=None, change_text="",
    values=np.full(TIMES.size, np.nan), why="the aileron hardly moved",
)  # fmt: skip


def test_rows_in_words() -> None:
    assert accessible_row_text(
        KNOWN
    ) == "Cmα \N{MINUS SIGN}0.3350 ± 0.0040, standard error 1.2 %, " + (
        "last maneuver: 9 % to 2.0 %"
    )
    assert "Clδa unknown" in accessible_row_text(UNKNOWN)
    # The bound in percent stands above the value that it is of.
    assert describe_value(KNOWN) == (
        "ML −0.3350 ± 0.0040", "FTR −0.3300  9→2.0 %",
    )  # fmt: skip
    in_gusts = describe_value(replace(KNOWN, methods=("ml", "fem")))[0]
    assert in_gusts == "ML/FEM −0.3350 ± 0.0040"
    assert describe_value(replace(KNOWN, mean=None, change_text="")) == (
        "FTR −0.3300 ± 0.0066", "",
    )  # fmt: skip
    assert describe_value(UNKNOWN) == ("unknown", "")
    assert bound_percent_text(4000.0) == "> 999 %"
    assert "M3 not fitted" in fit_status_text(2, 1, {"M3": "did not converge"})


def test_history_points_and_excitation_are_drawn(qtbot: QtBot) -> None:
    """Line, dots and dotted line of a known one; a bar for one that is not."""
    style = DisplayStyle()
    panel = EstimatesPanel(style)
    qtbot.addWidget(panel)
    panel.resize(360, 300)
    panel.show()
    assert panel.focusProxy() is None
    panel.show_rows((KNOWN, UNKNOWN), "1 maneuver fitted")
    theme = style.theme

    def count(color: str, part: np.ndarray) -> int:
        return int((part == int(color[1:], 16)).sum())

    screen = pixels(panel)
    rows = panel.list.visualRect(panel.list.row_model.index(0, 0))
    top = panel.list.mapTo(panel, rows.topLeft()).y()
    first, second = screen[top : top + rows.height()], screen[top + rows.height() :]
    # Cm_alpha is of the pitch axis, Cl_da of the roll axis: each in the color of its figures.
    assert count(theme.trace(trace_color("Cm_alpha")), first) > 30
    assert count(theme.trace(trace_color("Cl_da")), first) == 0
    assert count(theme.trace(trace_color("Cl_da")), second[: rows.height()]) > 100
    assert count(theme.trace(trace_color("Cm_alpha")), second[: rows.height()]) == 0
    plot = first[:, 220:]
    assert count(theme.text, plot) >= 4  # points of maximum likelihood; their edges are smoothed
    chosen = []
    panel.opened.connect(chosen.append)
    panel.list.setCurrentIndex(panel.list.row_model.index(0, 0))
    QTest.keyClick(panel.list, Qt.Key.Key_Return)
    assert chosen == ["Cm_alpha"]
    panel.show_rows((replace(KNOWN, value=-0.31), UNKNOWN), "")
    assert panel.list.currentIndex().row() == 0


@pytest.mark.long
def test_derivatives_form_while_a_flight_is_watched(
    qtbot: QtBot, window: MainWindow, tmp_path: Path, flown_short: Callable[[int], VirtualFlight]
) -> None:
    controller = window.flight_controller
    path = tmp_path / "flight"
    import_flight(write_block(tmp_path / "flight.csv", flown_short(6).measured, "csv"), path)
    FlightFolder.open(path).store_aircraft(SHIPPED_AIRCRAFT.find("b777"))
    controller.flight_opener.open_flight(path, speed=UNLIMITED_SPEED)
    until(qtbot, lambda: controller.is_replay, 60_000)
    window.commands.actions["panel_estimates"].trigger()
    panel = window.view.estimates
    workers = controller.session.estimates.fits._workers
    until(qtbot, lambda: bool(getattr(workers._pool, "_processes", None)), 60_000)
    # The system kills the process of the fits: the window goes on, and so do the fits.
    os.kill(next(iter(workers._pool._processes)), KILL)
    until(qtbot, lambda: any(row.value.points for row in panel.list.row_model.rows), 120_000)
    assert not controller.session.estimates.fits.failures
    names = [row.key for row in panel.list.row_model.rows]
    assert "Cm_de" in names
    given = next(row.value for row in panel.list.row_model.rows if row.value.points)
    panel.list.setCurrentIndex(panel.list.row_model.index(names.index(given.name), 0))
    QTest.keyClick(panel.list, Qt.Key.Key_Return)
    until(qtbot, lambda: (controller.time or 0.0) <= given.points[-1].time + 1.0, 30_000)


def test_the_search_shows_evidence_and_is_switched_by_mouse_and_key(qtbot: QtBot) -> None:
    panel = EvidencePanel(DisplayStyle())
    qtbot.addWidget(panel)
    panel.resize(360, 500)
    panel.show()
    switched: list[bool] = []
    panel.switched.connect(switched.append)
    panel.show_search((), "", enabled=False)
    QTest.mouseClick(panel.switch, Qt.MouseButton.LeftButton, pos=QPoint(8, 8))
    QTest.keyClick(panel.switch, Qt.Key.Key_Space)
    assert switched == [True, False]
    few, one, two = (
        LiveSearchResult(time=10.0 * count, maneuvers=count, verdict=verdict, evidence=evidence)
        for count, verdict, evidence in (
            (1, "", {}),
            (4, "ambiguous", {"aero.Cm.alpha2": 0.4, "aero.Cm.speed": 0.3}),
            (5, "effects-found", {"aero.Cm.alpha2": 0.9, "aero.Cm.speed": 0.05, "x": 0.01}),
        )
    )
    panel.show_search((few,), "1 maneuver: too few", enabled=True)
    assert switched == [True, False]
    assert panel.switch.isChecked()
    assert panel.plot is None
    panel.show_search((few, one, two), "found", enabled=True)
    assert panel.plot is not None
    assert panel.plot.isVisible()
    first, second = evidence_curves((one, two))
    assert (first.name, second.name) == ("aero.Cm.alpha2", "aero.Cm.speed")
    assert first.x.tolist() == [4.0, 5.0]
    assert first.y.tolist() == [40.0, 90.0]
    panel.show_search((few, one, two), "", enabled=False)
    assert not panel.plot.isVisible()


def test_names_that_are_not_confirmed_are_shown_by_title() -> None:
    search = LiveSearch(ProcessFitWorker())
    title = "Pitching moment varies with the square of angle of attack"
    search.steps = (
        LiveSearchResult(
            time=60.0, maneuvers=7, verdict="effects-found", why="found", evidence={},
            unconfirmed=("aero.Cm.alpha2", "aero.CN.alpha2"), titles={"aero.Cm.alpha2": title},
        ),
    )  # fmt: skip
    last = search_status_text(search, "US").splitlines()[-1]
    assert title in last
    assert "aero.CN.alpha2" in last
    assert "aero.Cm.alpha2" not in last
    search.enabled = False
    assert not search_status_text(search, "US")


def test_the_experiment_that_decides_becomes_the_first_test_card(window: MainWindow) -> None:
    panel = window.view.estimates.search
    card = TestCard(id="X1", speed="30 m/s", surfaces=("de",), amplitude="3 deg", width="0.4 s")
    names = ("aero.Cm.alpha2", "aero.Cm.speed")
    experiment = DecidingExperiment(purpose="separate", effects=names, titles=names, cards=(card,))
    step = LiveSearchResult(
        time=40.0, maneuvers=4, verdict="ambiguous", evidence=dict.fromkeys(names, 0.5)
    )
    panel.show_search((step,), "", enabled=True)
    assert panel.cards_button.isHidden()
    panel.show_search((replace(step, experiment=experiment),), "", enabled=True)
    assert not panel.cards_button.isHidden()
    panel.cards_button.click()
    cards = window.preflight_page.model.cards.cards
    assert cards is not None
    assert cards.cards[0].id == "X1"
