"""A day at the field by mouse and keys, in the X server that the environment names.

day_walk.py whole FOLDER    calibrate, fly, land, review, report: `tests/bench/day.py` runs it
day_walk.py quick FOLDER    wrong port, connect, alarm, end, review: `test_day.py` runs it
day_walk.py again FOLDER    the next start: the flight is among the recent ones

Pictures, settings and flights go to the folder; what was seen, to a file of JSON.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QLineEdit, QMessageBox, QPushButton
from shiboken6 import isValid

from gsapp.telemetry.recorder_control import find_recorders
from tests.ui.window_kit import Aircraft, free_port
from tests.ui.x_driver import XDriver, run_program
from ui.dialogs.connect import ConnectDialog
from ui.main_window import MainWindow
from ui.preflight.wizard_page import WizardPage
from ui.review.estimate_page import EstimatePage
from ui.settings import SettingsStore

PLAN = """\
name = "day"
[engines]
start = "1 s"
running = "9 s"
[[engines.run_ups]]
at = "2 s"
throttle = 1.0
[[engines.run_ups]]
at = "5 s"
throttle = 0.0
[pattern]
height = "180 ft"
leg = "8 s"
[[maneuvers]]
inputs = ["de"]
stick = [0.26]
step = "0.45 s"
"""
SPEED = 4.0
OTHER = """\
import socket, sys, time
from gsapp.decoding.dialect import dialect
names = dialect()
packer = names.MAVLink(None, srcSystem=7, srcComponent=1)
line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
while True:
    beat = packer.heartbeat_encode(1, 3, 81, 0, 4)
    line.sendto(beat.pack(packer), ("127.0.0.1", int(sys.argv[1])))
    time.sleep(0.2)
"""
"""A second transmitter: the heartbeats of system 7."""


class Day:
    """The window of the day, and the processes outside it.

    Parameters
    ----------
    folder : Path
        For everything.
    """

    def __init__(self, folder: Path, window: MainWindow) -> None:
        self.folder = folder
        self.window = window
        self.outside: list[subprocess.Popen[bytes]] = []
        self.port = free_port()

    def start(self, *arguments: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [sys.executable, "-P", *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.outside.append(process)
        return process

    def stop_all(self) -> None:
        for process in self.outside:
            process.kill()
            process.wait()

    def wrong_port(self, person: XDriver) -> None:
        """Connect to a serial port on which nobody sends; leave it again."""
        window = self.window
        controller, port = os.openpty()
        person.menu(window.menuBar(), "File", "Connect an aircraft…")
        dialog = person.dialog(ConnectDialog)
        field = dialog.link.text.lineEdit()
        person.fill(field, f"serial:{os.ttyname(port)}:57600")
        person.click(dialog.test.button)
        person.until(lambda: "No data" in dialog.test.message.text(), "the port is named", 20.0)
        person.note(wrong_port=dialog.test.message.text(), port=os.ttyname(port))
        person.picture("02-wrong-port")
        person.fill(field, f"udpin:127.0.0.1:{self.port}")
        person.click(dialog.button)
        person.until(
            lambda: not isValid(dialog) or not dialog.isVisible(), "the dialog has closed", 60.0
        )
        os.close(controller)
        os.close(port)
        person.picture("03-connected")

    def preflight(self, person: XDriver) -> None:
        """Calibrate the rudder alone, on the practice bench."""
        window = self.window
        person.picture("01-start")
        person.keys("F1", "alt+2")
        page = person.find(WizardPage, lambda _it: True, "the calibration page")
        page.practice.speed = 5.0
        person.keys("p")
        rows = page.start.instruments
        person.until(
            lambda: (
                window.flight_controller.history is not None
                and window.flight_controller.history.has("rudder")
            ),
            "volts",
        )
        person.picture("04-calibration")
        channels = person.ask(lambda: [one.channel for one in page.start.standings or ()])
        person.row(rows, channels.index("rudder"))
        person.keys("Return")
        person.until(
            lambda: page.run is not None and page.run.view.instrument is not None, "it begins", 90.0
        )
        person.note(calibrates=person.ask(lambda: page.run.view.instrument.channel))
        self.obey(person, page)
        person.picture("05-fit")
        # A good fit is accepted after a while.
        person.until(lambda: page.run.view.phase == "done", "the certificate is written")
        person.note(calibrated=person.ask(lambda: page.run.view.prompt))
        person.picture("05-calibrated")
        person.keys("space")
        person.until(lambda: page.run is None, "the calibration is left")

    def obey(self, person: XDriver, page: WizardPage) -> None:
        deadline = time.monotonic() + 240.0
        while (view := person.ask(lambda: page.run.view)).phase not in ("fit", "done"):
            if time.monotonic() > deadline:
                raise TimeoutError(f"the calibration stays at {view.phase}")
            person.keys("h")
            person.changes(lambda: (page.run.view.phase, page.run.view.available_actions), 0.5)
            if "confirm_sign" in person.ask(lambda: page.run.view.available_actions):
                person.keys("space")

    def fly(self, person: XDriver) -> None:
        """Fly: an alarm is acknowledged, a second transmitter comes, and the aircraft is lost."""
        flight_controller = self.window.flight_controller
        plan = self.folder / "day.toml"
        plan.write_text(PLAN)
        person.keys("F2")
        aircraft = self.start(
            "-m", "gsapp", "fly", "--to", f"udpout:127.0.0.1:{self.port}", "--plan", str(plan),
            "--speed", str(SPEED),
        )  # fmt: skip
        person.until(
            lambda: flight_controller.session.snapshot().link.state == "ok",
            "the link carries",
            60.0,
        )
        person.note(
            alarm_before=person.ask(
                lambda: flight_controller.session.alarm_registry.get("link") is not None
            )
        )
        person.picture("06-flying")
        self.start("-P", "-c", OTHER, str(self.port))
        person.until(
            lambda: len(flight_controller.session.link_report().vehicles) == 2, "two are heard"
        )
        aircraft.send_signal(signal.SIGSTOP)
        stopped = time.monotonic()
        person.until(
            lambda: flight_controller.session.snapshot().link.state == "silent", "the loss is seen"
        )
        person.note(seen_after=time.monotonic() - stopped)
        person.picture("07-lost")
        aircraft.send_signal(signal.SIGCONT)
        person.until(
            lambda: flight_controller.session.snapshot().link.state == "ok", "the aircraft is back"
        )
        self.acknowledge(person)
        person.picture("08-alarms")
        person.until(
            lambda: flight_controller.session.landing.landed_at is not None,
            "the landing is recognized",
            120.0,
        )
        person.picture("09-landed")
        person.press("End flight and review")
        self.review(person)

    def quick_flight(self, person: XDriver) -> None:
        flight_controller = self.window.flight_controller
        with Aircraft(self.port) as aircraft:
            person.until(
                lambda: (
                    flight_controller.history is not None and flight_controller.history.has("alpha")
                ),
                "samples",
            )
            person.picture("06-flying")
        person.note(sent=aircraft.sent + aircraft.texts)
        person.until(
            lambda: flight_controller.session.snapshot().link.state == "silent", "the loss is seen"
        )
        self.acknowledge(person)
        person.press("Stop")
        person.press("Stop recording", person.dialog(QMessageBox))
        person.press("Review it")
        self.review(person)

    def acknowledge(self, person: XDriver) -> None:
        window, board = self.window, self.window.flight_controller.session.alarm_registry
        person.note(alarms=person.ask(lambda: [one.message for one in board.unacknowledged]))
        person.click(window.view.charts)
        person.keys("k")
        person.until(lambda: not board.unacknowledged, "the alarm is acknowledged")
        person.keys("ctrl+4")
        person.until(window.view.alarms.isVisible, "the tab of the alarms")

    def review(self, person: XDriver) -> None:
        window = self.window
        person.until(lambda: window.review_page.shown, "the review", 60.0)
        person.until(lambda: not window.flight_controller.is_recording, "the recording has ended")
        person.until(lambda: bool(window.review_page.review.flights), "the flight", 60.0)
        person.picture("10-review")
        person.note(
            recording=person.ask(lambda: window.flight_controller.is_recording),
            waiting=person.ask(
                lambda: [
                    one.message
                    for one in window.flight_controller.session.alarm_registry.unacknowledged
                ]
            ),
        )

    def report(self, person: XDriver) -> None:
        """Estimate derivatives, and write the report for a browser and for print."""
        review = self.window.review_page
        person.keys("alt+2")
        page = person.find(EstimatePage, lambda _it: True, "the Estimate page")
        person.until(lambda: page.can_run, "the settings")
        person.keys("ctrl+Return")
        person.until(lambda: review.outcome is not None and not review.work.running, "a run", 120.0)
        person.picture("11-estimate")
        person.keys("alt+4")
        for ending in ("html", "pdf"):
            path = self.folder / f"report.{ending}"
            person.press("Report…")
            dialog = person.dialog(QFileDialog)
            person.fill(dialog.findChild(QLineEdit), str(path))
            person.keys("Return")
            writer = person.ask(lambda: review.pages["summary"].writer)
            person.until(
                lambda path=path, writer=writer: writer.written == path,
                f"{path.name} is written",
                120.0,
            )
        person.picture("12-report")


def whole(person: XDriver, day: Day) -> None:
    for part in (day.preflight, day.wrong_port, day.fly, day.report):
        part(person)


def quick(person: XDriver, day: Day) -> None:
    for part in (day.wrong_port, day.quick_flight):
        part(person)


def again(person: XDriver, day: Day) -> None:
    """Open the flight of before from the start page."""
    window = day.window
    name = max(
        one.name
        for one in (day.folder / "flights").iterdir()
        if one.is_dir() and "practice" not in one.name
    )
    one = person.find(
        QPushButton, lambda it: it.accessibleName().startswith(f"Open {name},"), f"{name} is listed"
    )
    person.note(listed=person.ask(one.accessibleName))
    person.picture("13-again")
    person.click(one)
    person.until(
        lambda: window.flight_controller.is_loaded and window.flight_controller.name == name,
        "it opens",
    )


WALKS = {"whole": whole, "quick": quick, "again": again}


def main(name: str, folder: Path) -> None:
    """Run the program with a person at it, and write what was seen."""
    settings = folder / "settings.toml"
    SettingsStore(settings).change(flights=str(folder / "flights"), muted=True)
    driver = XDriver(folder / "pictures")
    days: list[Day] = []

    def script(person: XDriver, window: MainWindow) -> None:
        days.append(Day(folder, window))
        WALKS[name](person, days[0])

    try:
        run_program(settings, script, driver)
    finally:
        for day in days:
            day.stop_all()
        recorders = find_recorders()
        driver.note(recorders=[one.folder.name for one in recorders])
        for one in recorders:
            one.stop()
    (folder / f"{name}.json").write_text(json.dumps(driver.facts))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
