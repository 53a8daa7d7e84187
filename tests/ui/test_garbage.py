"""Windows in cycles are destroyed in their own thread, whatever other threads allocate."""

import gc
import threading

import pyqtgraph
import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

_MANY = 20_000
"""Objects, with which Python would look for garbage some thirty times."""


class _Witness:
    def __init__(self, seen: list[threading.Thread]) -> None:
        self.seen = seen

    def __del__(self) -> None:
        self.seen.append(threading.current_thread())


def _leave_a_window(seen: list[threading.Thread]) -> None:
    chart = pyqtgraph.PlotWidget()
    chart.plot([0.0, 1.0], [0.0, 1.0])
    chart.witness = _Witness(seen)
    chart.itself = chart


def test_a_window_in_a_cycle_is_destroyed_by_the_thread_of_the_windows(
    qtbot: QtBot, qapp: QApplication, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(qapp.property("collector"), "threshold", (0, 10, 10))
    seen: list[threading.Thread] = []
    gc.collect(0)
    _leave_a_window(seen)

    worker = threading.Thread(target=lambda: [{"one": [number]} for number in range(_MANY)])
    worker.start()
    worker.join()
    assert not seen

    qtbot.waitUntil(lambda: bool(seen), timeout=10_000)
    assert seen == [threading.main_thread()]
