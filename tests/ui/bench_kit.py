"""A crew at a virtual bench, and a desk that its volts go to without any waiting."""

from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMainWindow

from calibration.plan import CALIBRATION_PLANS
from calibration.wizard import WizardView
from gsapp.aircraft import load_aircraft
from gsapp.session.sample_history import SampleHistory
from gsapp.virtual.bench import VirtualBench
from ui.appearance_controller import AppearanceController
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.preflight.wizard_page import WizardPage
from ui.settings import SettingsStore, calibrations_path

_TICK = 1.0
"""Seconds of volts that come at a time."""
_PAST = 3.0
"""Degrees by which a setting is passed."""


class BenchController(QObject):
    """What a wizard's page needs of a desk; the samples come as fast as they are asked for."""

    changed = Signal()
    refreshed = Signal()
    job_started = Signal(object, str)
    message_posted = Signal(str, str)

    def __init__(self, bench: VirtualBench, folder: Path) -> None:
        super().__init__()
        self.bench = bench
        self.error_reporter = ErrorReporter()
        self.complaints: list[str] = []
        self.opened: list[Path] = []
        self.error_reporter.error_reported.connect(
            lambda fault: self.complaints.append(fault.message)
        )
        self.history = SampleHistory((), 100.0)
        # It notes which flight is to be read anew.
        self.flight_opener = SimpleNamespace(open_flight=self.opened.append)
        self.session: object | None = SimpleNamespace(
            history=self.history,
            feed=SimpleNamespace(is_up_to_date=True),
            aircraft=load_aircraft("b777"),
            replay_feed=None,
            path=folder / "none",
        )

    def close(self) -> None:
        self.history.close()

    def pass_time(self, seconds: float) -> None:
        left = seconds
        while left > 1e-9:
            self.history.append(self.bench.step(min(left, _TICK)))
            left -= _TICK
            self.refreshed.emit()


@dataclass
class Voice:
    words: list[str] = field(default_factory=list)
    tones: list[str] = field(default_factory=list)

    def say(self, words: str) -> None:
        self.words.append(words)

    def play_tone(self, name: str) -> None:
        self.tones.append(name)


def leave_only(folder: Path, *channels: str) -> None:
    head, *tables = (
        CALIBRATION_PLANS.find("b777").read_text(encoding="utf-8").split("[[instruments]]")
    )
    kept = [table for name in channels for table in tables if f'channel = "{name}"' in table]
    own = calibrations_path(folder / "settings" / "window.toml") / "plans" / "B777.toml"
    own.parent.mkdir(parents=True, exist_ok=True)
    text = "[[instruments]]".join([head, *kept])
    # A partner that is not calibrated is none.
    lines = [
        line
        for line in text.splitlines()
        if not line.startswith("partner") or line.partition('"')[2].rstrip('"') in channels
    ]
    own.write_text("\n".join(lines) + "\n", encoding="utf-8")


class BenchWindow(QMainWindow):
    """The wizard's page in a window of its own, at a bench."""

    def __init__(self, folder: Path, bench: VirtualBench) -> None:
        super().__init__()
        self.bench = bench
        self.store = SettingsStore(folder / "settings" / "window.toml")
        self.display_style = DisplayStyle()
        self.appearance = AppearanceController(self.display_style, self.store, self)
        self.appearance.apply()
        self.controller = BenchController(bench, folder)
        self.voice = Voice()
        self.page = WizardPage(self.display_style, self.store, self.controller, self.voice)
        self.setCentralWidget(self.page)
        self.keys = 0
        self.left = False
        self.resize(1190, 660)
        self.show()
        self.activateWindow()
        QTest.qWaitForWindowActive(self)
        self.page.set_initial_focus()

    @property
    def view(self) -> WizardView:
        return self.page.run.view

    def press(
        self, key: Qt.Key, modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier
    ) -> None:
        self.keys += 1
        focus = QApplication.focusWidget()
        assert focus is not None
        QTest.keyClick(focus, key, modifier)

    def leave(self) -> None:
        if self.left:
            return
        self.left = True
        self.page.close_run()
        self.controller.close()
        self.close()
        self.deleteLater()

    def type(self, text: str) -> None:
        QTest.keyClicks(QApplication.focusWidget(), text)

    def set_surface(self, channel: str, angle: float) -> None:
        self.controller.pass_time(self.bench.set_angle(channel, angle))


def work_through(window: BenchWindow, stop: str = "", most: int = 400) -> None:
    """Do at the surfaces what the page asks for until it asks for nothing more."""
    for _ in range(most):
        view = window.view
        instrument = view.instrument
        name = instrument.channel if instrument is not None else ""
        if view.phase in ("done", "aborted", stop) or (stop and name == stop):
            return
        if instrument is None or view.phase == "fit":
            if "repeat these points" in view.prompt:
                # This crew looks at the curve and takes it as it is.
                window.press(Qt.Key.Key_Space)
            window.controller.pass_time(_TICK)
            continue
        if view.phase == "sign":
            window.set_surface(name, max(instrument.settings))
            window.controller.pass_time(2.5)
            continue
        taken, target = len(view.points), view.target
        assert target is not None
        again = "wrong side" in view.message
        if view.direction != "single" and (view.remaining[0].is_turning_point or again):
            window.set_surface(name, target + (-_PAST if view.direction == "up" else _PAST))
        window.set_surface(name, target)
        for _ in range(8):
            if len(window.view.points) != taken or window.view.phase != "points":
                break
            window.controller.pass_time(_TICK)
    raise AssertionError(f"after {most} movements: {window.view.prompt} {window.view.message}")


def try_out(window: BenchWindow, channel: str) -> list[tuple[str, str, str]]:
    """Prove the sign of an instrument by hand, then go to both ends."""
    named: list[tuple[str, str, str]] = []

    def note() -> None:
        for fault in window.view.faults:
            told = (fault.kind, fault.channel, fault.swapped_with)
            if told not in named:
                named.append(told)

    window.controller.refreshed.connect(note)
    window.press(Qt.Key.Key_Space)
    window.controller.pass_time(4.0)
    assert window.view.instrument.channel == channel
    window.set_surface(channel, 15.0)
    window.controller.pass_time(2.0)
    if not named and window.view.phase == "sign":
        # Moved, and nothing happens: the key says that it was moved.
        window.press(Qt.Key.Key_Space)
        window.controller.pass_time(1.0)
    for angle in (-24.0, -20.0, 24.0):
        if not named:
            window.set_surface(channel, angle)
            window.controller.pass_time(2.0)
    return named
