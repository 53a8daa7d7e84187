"""A whole day at the field by mouse and keys, in a real X server: what `test_day.py` runs.

day_walk.py FOLDER    pictures, settings and flights go there; prints what was seen as JSON
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "ui"))

from window_kit import free_port, open_window
from x_driver import XDriver, run_script

from ui.app import make_application
from ui.dialogs.connect import ConnectDialog
from ui.preflight.wizard_page import WizardPage
from ui.window import MainWindow

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
        """Start a process beside the window."""
        process = subprocess.Popen(
            [sys.executable, "-P", *arguments],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.outside.append(process)
        return process

    def stop_all(self) -> None:
        """End what is left."""
        for process in self.outside:
            process.kill()
            process.wait()

    def walk(self, person: XDriver) -> None:
        """Do everything in order."""
        for part in (self.preflight, self.wrong_port, self.fly):
            part(person)

    def part(self, name: str) -> tuple[str, str]:
        """Return words and detail of a part of the bar."""
        parts = self.window.desk.bar_parts("us", muted=True)
        found = next(one for one in parts if one.id == name)
        return found.words, found.detail

    def wrong_port(self, person: XDriver) -> None:
        """Connect to a serial port on which nobody sends; leave it again."""
        window = self.window
        controller, port = os.openpty()
        person.menu(window.menuBar(), "File", "Connect an aircraft…")
        dialog = person.dialog(ConnectDialog)
        field = dialog.link.text.lineEdit()
        person.click(field)
        person.keys("ctrl+a")
        person.type(f"serial:{os.ttyname(port)}:57600")
        person.click(dialog.test.button)
        person.until(lambda: "No data" in dialog.test.sentence.text(), "the port is named", 20.0)
        person.note(wrong_port=dialog.test.sentence.text(), port=os.ttyname(port))
        person.picture("02-wrong-port")
        person.click(field)
        person.keys("ctrl+a")
        person.type(f"udpin:127.0.0.1:{self.port}")
        person.click(dialog.button)
        person.until(lambda: not dialog.isVisible(), "the dialog has closed", 60.0)
        os.close(controller)
        os.close(port)
        person.picture("03-connected")

    def preflight(self, person: XDriver) -> None:
        """Calibrate the rudder alone, on the practice bench."""
        window = self.window
        person.picture("01-start")
        person.keys("F1", "alt+2")
        page = person.find(WizardPage, lambda _it: True, "the calibration page")
        page.practice.speed = 8.0
        person.keys("p")
        rows = page.start.instruments
        person.until(
            lambda: window.desk.history is not None and window.desk.history.has("rudder"), "volts"
        )
        person.picture("04-calibration")
        channels = person.ask(lambda: [one.channel for one in page.start.standings or ()])
        person.row(rows, channels.index("rudder"))
        person.keys("Return")
        person.until(
            lambda: page.run is not None and page.run.view.instrument is not None, "it begins"
        )
        person.note(calibrates=person.ask(lambda: page.run.view.instrument.channel))
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            view = person.ask(lambda: page.run.view)
            if view.phase in ("fit", "done"):
                break
            person.keys("h")
            time.sleep(0.5)
            if "confirm_sign" in person.ask(lambda: page.run.view.can):
                person.keys("space")
        person.picture("05-fit")
        person.note(phase=person.ask(lambda: page.run.view.phase))

    def fly(self, person: XDriver) -> None:
        """Fly: an alarm is acknowledged, a second transmitter comes, and the aircraft is lost."""
        window, desk = self.window, self.window.desk
        plan = self.folder / "day.toml"
        plan.write_text(PLAN)
        person.keys("F2")
        aircraft = self.start(
            "-m", "gsapp", "fly", "--to", f"udpout:127.0.0.1:{self.port}", "--plan", str(plan),
            "--speed", str(SPEED),
        )  # fmt: skip
        person.until(lambda: desk.session.snapshot().link.words == "ok", "the link carries", 60.0)
        person.note(alarm_before=person.ask(lambda: desk.session.board.get("link") is not None))
        person.picture("06-flying")
        self.start("-P", "-c", OTHER, str(self.port))
        person.until(lambda: len(desk.session.link_report().vehicles) == 2, "two are heard")
        aircraft.send_signal(signal.SIGSTOP)
        stopped = time.monotonic()
        person.until(lambda: desk.session.snapshot().link.words == "silent", "the loss is seen")
        person.note(seen_after=time.monotonic() - stopped)
        person.picture("07-lost")
        aircraft.send_signal(signal.SIGCONT)
        person.until(lambda: desk.session.snapshot().link.words == "ok", "the aircraft is back")
        person.click(window.view.charts)
        person.keys("k")
        person.until(lambda: not desk.session.board.waiting, "the alarm is acknowledged")
        person.keys("ctrl+4")
        person.picture("08-alarms")
        person.until(
            lambda: desk.session.landing.landed_at is not None, "the landing is recognized", 120.0
        )
        person.picture("09-landed")
        person.press("End flight and review")
        person.until(lambda: window.review.shown, "the review", 60.0)
        person.until(lambda: not desk.records_here, "the recording has ended")
        person.picture("10-review")
        person.note(
            recording=person.ask(lambda: desk.records_here),
            waiting=person.ask(lambda: [one.words for one in desk.session.board.waiting]),
        )


def walk(folder: Path) -> None:
    """Walk through the day in this process, and print what was seen."""
    _application = make_application()  # held for as long as the window lives
    window = open_window(folder)
    day = Day(folder, window)
    driver = XDriver(folder / "pictures")
    try:
        run_script(window, day.walk, driver)
    finally:
        day.stop_all()
        window.desk.stop_now()
        window.desk.close()
    print(json.dumps(driver.facts))


def main(*_options: str) -> None:
    """Start an X server, walk through the day in it, and print what was seen."""
    missing = [name for name in ("Xvfb", "xdotool", "openbox") if shutil.which(name) is None]
    if missing:
        raise SystemExit(f"not installed: {', '.join(missing)}")
    folder = Path(tempfile.mkdtemp(prefix="gsapp-day-"))
    reader, writer = os.pipe()
    command = ["Xvfb", "-displayfd", str(writer), "-screen", "0", "1440x900x24"]
    server = subprocess.Popen(
        [*command, "-nolisten", "tcp"], pass_fds=(writer,), stderr=subprocess.DEVNULL
    )
    os.close(writer)
    with os.fdopen(reader) as lines:
        where = {**os.environ, "DISPLAY": f":{lines.readline().strip()}", "QT_QPA_PLATFORM": "xcb"}
    manager = subprocess.Popen(
        ["openbox"],  # noqa: S607
        env=where,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    begun = time.monotonic()
    try:
        done = subprocess.run(
            [sys.executable, __file__, "walk", str(folder)],
            env=where, capture_output=True, text=True, timeout=400.0,
        )  # fmt: skip
    finally:
        for process in (manager, server):
            process.terminate()
            process.wait()
    if done.returncode:
        raise SystemExit(f"{done.stderr}\nThe last picture is in {folder / 'pictures'}")
    seen = json.loads(done.stdout.splitlines()[-1])
    print(f"a day in {time.monotonic() - begun:.0f} s; pictures in {folder / 'pictures'}")
    print(f"wrong port      {seen['wrong_port']}")
    print(f"calibrated      {seen['calibrates']} alone: {seen['phase']}")
    print(f"lost beside another transmitter, seen after {seen['seen_after']:.1f} s (goal 4 s)")
    print(f"after landing   recording {seen['recording']}, alarms waiting {seen['waiting']}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["walk"]:
        walk(Path(sys.argv[2]))
    else:
        main()
