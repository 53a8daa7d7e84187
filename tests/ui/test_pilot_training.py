"""Training: keys as sticks, and a real virtual aircraft that is flown by them over a real link."""

import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from gsapp.quantities.constants import DEGREE
from gsapp.telemetry.recorder_control import find_recorders
from tests.ui.preflight_kit import as_opened
from tests.ui.window_kit import opened_window, until
from ui.flight_controller import FlightController
from ui.main_window import MainWindow
from ui.pilot.training_flight import StickAction, StickKeys, StickPosition

_PATIENCE_MS = 60_000
"""Recorder and aircraft are processes of their own, which may take a while to start."""

KEYS = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_Left, Qt.Key.Key_Right, Qt.Key.Key_A,
        Qt.Key.Key_D)  # fmt: skip


# Keys


def test_down_pulls_and_the_later_key_of_a_stick_wins() -> None:
    keys = StickKeys()
    keys.press(Qt.Key.Key_Down, trim=False, again=False)
    keys.press(Qt.Key.Key_Right, trim=False, again=False)
    assert keys.position == StickPosition(pitch=1.0, roll=1.0)
    keys.press(Qt.Key.Key_Up, trim=False, again=False)
    assert keys.position == StickPosition(pitch=-1.0, roll=1.0)
    keys.release(Qt.Key.Key_Up)
    assert keys.position == StickPosition(pitch=1.0, roll=1.0)
    keys.release_all()
    assert keys.position == StickPosition()


def test_levers_sizes_and_rates_act_once() -> None:
    keys = StickKeys()
    assert keys.press(Qt.Key.Key_W, trim=False, again=True) == StickAction(lever=("throttle", 0.04))
    assert keys.press(Qt.Key.Key_3, trim=False, again=False) == StickAction(travel=0.5)
    assert keys.press(Qt.Key.Key_3, trim=False, again=True) is None
    assert keys.press(Qt.Key.Key_9, trim=False, again=False) == StickAction(high_rate=False)
    assert keys.press(Qt.Key.Key_Up, trim=True, again=False) == StickAction(lever=("pitch", -0.02))
    assert keys.position == StickPosition()
    assert not StickKeys.is_stick_key(Qt.Key.Key_Space)


@given(st.lists(st.tuples(st.sampled_from(KEYS), st.booleans())))
def test_released_sticks_are_centered_whatever_was_pressed(
    strokes: list[tuple[Qt.Key, bool]],
) -> None:
    keys = StickKeys()
    for key, down in strokes:
        if down:
            keys.press(key, trim=False, again=False)
        else:
            keys.release(key)
        assert max(abs(keys.position.pitch), abs(keys.position.roll), abs(keys.position.yaw)) <= 1.0
    for key in KEYS:
        keys.release(key)
    assert keys.position == StickPosition()


# The aircraft


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, qapp: QApplication) -> Iterator[MainWindow]:
    with opened_window(tmp_path_factory.mktemp("window")) as window:
        yield window
    for recorder in find_recorders():
        recorder.stop()


@pytest.fixture
def window(made: MainWindow, qtbot: QtBot) -> Iterator[MainWindow]:
    yield from as_opened(made, qtbot)


def hold(qtbot: QtBot, key: Qt.Key, done: Callable[[], bool]) -> None:
    QTest.keyPress(QApplication.focusWidget(), key)
    until(qtbot, done, _PATIENCE_MS)
    QTest.keyRelease(QApplication.focusWidget(), key)


@pytest.mark.long
def test_a_trainee_takes_the_aircraft_flies_a_doublet_and_gives_it_back(window, qtbot):
    """All by keys; what they did is measured on the elevator of the record."""
    qtbot.keyClick(
        window,
        Qt.Key.Key_T,
        Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier,
    )
    pilot, controller = window.pilot_page, window.flight_controller
    until(qtbot, lambda: pilot.training.running and controller.time is not None, _PATIENCE_MS)
    assert pilot.isVisible()
    until(qtbot, lambda: controller.time > 1.0, _PATIENCE_MS)
    # It begins in the air, with the cards of the aircraft, and the page judges it.
    until(qtbot, lambda: pilot.canvas.display.card.heading.startswith("NEXT"), _PATIENCE_MS)
    assert "built-in pilot" in pilot.help.text()
    # Letters are commands until the trainee has it; the keyboard is on the page.
    assert pilot.canvas.hasFocus()
    muted = window.store.current.muted
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_S)
    assert window.store.current.muted is not muted
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_H)
    until(qtbot, lambda: pilot.training.trainee_has_control, _PATIENCE_MS)
    assert pilot.help.text().startswith("You have control")
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_S)
    assert window.store.current.muted is not muted
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_M, Qt.KeyboardModifier.ControlModifier)
    assert window.store.current.muted is muted
    # A doublet: half stick back, half stick forward.
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_3)
    assert "half stick" in pilot.help.text()
    begin = controller.time

    def moved() -> np.ndarray:
        values = controller.session.history.block(("de",), begin - 0.5, controller.time).values[
            :, 0
        ]
        return values - np.nanmedian(values[:40])

    # Pulled is trailing edge up, negative, and comes first.
    hold(qtbot, Qt.Key.Key_Down, lambda: bool(np.nanmin(moved()) < -3.0 * DEGREE))
    assert np.nanmax(moved()) < 1.5 * DEGREE
    hold(qtbot, Qt.Key.Key_Up, lambda: bool(np.nanmax(moved()) > 3.0 * DEGREE))
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_H)
    until(qtbot, lambda: not pilot.training.trainee_has_control, _PATIENCE_MS)
    # Another flight ends it.
    aircraft = pilot.training._flight.process
    controller.close_flight()
    ended = time.monotonic() + 10.0
    while aircraft.is_running() and time.monotonic() < ended:
        time.sleep(0.05)
    assert not aircraft.is_running()
    # Its recording ends with it: nobody would come back to it.
    until(qtbot, lambda: not find_recorders(), _PATIENCE_MS)
    assert not pilot.help.isVisible()


def test_training_does_not_take_the_place_of_a_flight_that_is_recorded(window, monkeypatch):
    before = window.pilot_page.training.folder
    with monkeypatch.context() as patch:
        patch.setattr(FlightController, "is_recording", True)
        window.commands.actions["pilot_train"].trigger()
    assert window.pilot_page.training.folder == before
    assert any("being recorded" in text for text in window.banners.texts())


def test_the_start_page_offers_training(window: MainWindow, qtbot: QtBot) -> None:
    button = window.flight_page.start.training_button
    assert "Train" in button.accessibleName()
    focus = window.flight_page.start
    focus.setFocus()
    for _ in range(8):
        qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_Tab)
        if QApplication.focusWidget() is button:
            break
    assert button.hasFocus()
