"""An old flight read with other certificates in the window, and uncalibrated channels on screen."""

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from calibration import certificate_paths, load_certificates, write_certificate
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.flight import load_flight
from gsapp.flight.certificates import AppliedCertificates
from gsapp.flight.folder import FlightFolder
from tests.flight.box_kit import box_tlog
from tests.ui.window_kit import open_window, until
from ui.background_job import JobProgress
from ui.dialogs.flight_dialogs import CertificatesDialog
from ui.display_style import DisplayStyle
from ui.flight.panel_rows import build_cursor_value_rows
from ui.main_window import MainWindow
from ui.strips.chart_annotations import ChannelOrigin

_GONE = ("elevator_left", "flap")
_PATIENCE = 30_000
"""Milliseconds: a flight is opened twice, perhaps on a busy machine."""


@pytest.fixture
def flight(tmp_path: Path) -> Path:
    folder = FlightFolder.create(tmp_path / "old flight")
    folder.tlog_file.write_bytes(box_tlog())
    folder.store_channel_map(MAPS.find("b777"))
    folder.store_aircraft(SHIPPED_AIRCRAFT.find("b777"))
    folder.store_certificates(certificate_paths("b777"))
    return folder.path


@pytest.fixture
def other(tmp_path: Path) -> Path:
    folder = tmp_path / "spring"
    folder.mkdir()
    for path in certificate_paths("b777"):
        if path.stem not in _GONE:
            shutil.copy(path, folder)
    alpha = load_certificates("b777")["alpha"]
    first, *rest = alpha.coefficients
    # As the wizard writes it, with the zone of its time; the shipped ones have none.
    moved = replace(alpha, coefficients=(first + 1.0, *rest), stamp=alpha.stamp.astimezone())
    write_certificate(moved, folder / "alpha.toml")
    return folder


@pytest.fixture
def window(qtbot: QtBot, tmp_path: Path, flight: Path, alone: None) -> Iterator[MainWindow]:
    made = open_window(tmp_path)
    qtbot.addWidget(made)
    made.flight_controller.flight_opener.open_flight(flight, playing=False)
    until(qtbot, lambda: made.flight_controller.is_loaded, _PATIENCE)
    yield made
    made.close()


def choose(monkeypatch: pytest.MonkeyPatch, value: str) -> list[str]:
    said: list[str] = []

    def answer(dialog: CertificatesDialog) -> bool:
        place = dialog.certificates.findData(value)
        if place < 0:
            dialog.certificates.insertItem(0, value, value)
            place = 0
        dialog.certificates.setCurrentIndex(place)
        said.append(dialog.message.text())
        return dialog.button.isEnabled()

    monkeypatch.setattr(CertificatesDialog, "exec", answer)
    return said


def bar_part(window: MainWindow) -> tuple[str, str, str, str]:
    (part,) = (part for part in window._status_items() if part.id == "calibration")
    return part.title, part.value, part.note, part.state


def test_read_anew_with_other_certificates_and_back(
    qtbot: QtBot, window: MainWindow, other: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The numbers, the bar, the banner and an export are those of the set; the time stays."""
    controller = window.flight_controller
    controller.seek(12.0)
    own = controller.history.samples("alpha", 1020, 1180)
    before = controller.session
    assert bar_part(window) == ("CALIBRATION", "18", "example values", "caution")
    said = choose(monkeypatch, str(other))
    window.commands.actions["certificates"].trigger()
    assert "elevator_left, flap" in said[0]
    until(qtbot, lambda: controller.session is not before and controller.is_loaded, _PATIENCE)
    until(qtbot, lambda: controller.time == pytest.approx(12.0), _PATIENCE)
    read = controller.history.samples("alpha", 1020, 1180)
    np.testing.assert_allclose(read - own, np.deg2rad(1.0))
    assert bar_part(window) == ("CALIBRATION  OTHER", "16", "2 uncalibrated", "warning")
    until(
        qtbot,
        lambda: any("instead of those of the flight" in text for text in banners(window)),
        _PATIENCE,
    )
    written = controller.export("csv", tmp_path / "out.csv", JobProgress(lambda *_: None))
    exported = load_flight(written).block["alpha"]
    np.testing.assert_allclose(exported[20:180], read, atol=1e-12)

    choose(monkeypatch, "")
    before = controller.session
    window.commands.actions["certificates"].trigger()
    until(qtbot, lambda: controller.session is not before and controller.is_loaded, _PATIENCE)
    until(qtbot, lambda: controller.time == pytest.approx(12.0), _PATIENCE)
    assert bar_part(window)[0] == "CALIBRATION"
    assert np.array_equal(controller.history.samples("alpha", 1020, 1180), own)


def banners(window: MainWindow) -> list[str]:
    return list(window.banners.texts())


def test_what_has_no_certificate_is_charted_hatched_and_called_uncalibrated(
    qtbot: QtBot, window: MainWindow, other: Path
) -> None:
    """The instrument, its volts, and what would be derived from it: chart, panels, tree."""
    controller = window.flight_controller
    controller.reload_with_certificates(str(other))
    until(
        qtbot,
        lambda: controller.calibration.override_source == str(other) and controller.is_loaded,
        _PATIENCE,
    )
    until(qtbot, lambda: "flap" in window.view._state.uncalibrated, _PATIENCE)
    picture = window.view._state
    assert picture.uncalibrated == {
        "elevator_left", "elevator_left_volts", "flap", "flap_volts", "de",
    }  # fmt: skip
    window.view.layouts.show_layout("Overview")
    charts = window.view.charts
    window.view.advance(controller.time)
    order = [strip.traces[0].channel for strip in charts.strip_layout.strips]
    assert "de" in order  # not simply gone
    reading = charts.displayed_values(order.index("de"))[0]
    assert (reading.uncalibrated, reading.stale) == (True, True)
    assert not charts.displayed_values(order.index("alpha"))[0].uncalibrated
    assert "uncalibrated" in window.view.channels._notes["flap"]
    history = controller.history
    at = {"cursor": history.last("alpha")[0]}
    lines = build_cursor_value_rows(history, ["de", "alpha"], at, "US", picture.sources)
    assert [line.cells[0].endswith("uncal") for line in lines] == [True, False]
    far = {"alpha": ChannelOrigin("measured", True, {"alpha": (1.0, 2.0)})}
    (line,) = build_cursor_value_rows(history, ["alpha"], at, "US", far)
    assert line.cells[0].endswith("beyond cal")
    assert line.cells[1] == f"*{lines[1].cells[1]}"
    assert line.cells[2] == lines[1].cells[2], "no cursor, nothing to mark"


def test_the_dialog_refuses_a_folder_without_certificates(qtbot: QtBot, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    dialog = CertificatesDialog(
        DisplayStyle(), AppliedCertificates(override_source=str(tmp_path / "empty")), ["b777"]
    )
    qtbot.addWidget(dialog)
    assert not dialog.button.isEnabled()
    assert "calibration certificate" in dialog.message.text()
    dialog.certificates.setCurrentIndex(dialog.certificates.findData("b777"))
    assert dialog.button.isEnabled()
