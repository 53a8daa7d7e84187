"""The whole ground station for an hour of real time: memory, handles, frames, latency by minute.

A flight of the virtual aircraft in the air, with maneuvers, is sent over UDP at its real rate by a
process of its own; when it ends it is sent again, with stamps and sequence numbers that go on. A
recorder in its own process writes it; the main window, off screen, follows with 16 charts, alarms,
cues, FTR, and maximum likelihood of every maneuver in a process beside it.

MINUTES of real time follow as an argument (60). What counts is the memory that belongs to no file
(RssAnon); with --trace the lines of the program that hold what was added since minute 5 are told
in the end, which slows all of it.
"""

import gc
import os
import sys
import tempfile
import time
import tracemalloc
from pathlib import Path

import numpy as np

from tests.bench import estimates_live, latency, memory
from tests.bench.sender_process import send_in_real_time, sending

_WATCHED = 10.0  # s of each minute in which frames are timed
_TAIL = 1 << 20  # bytes of the record that hold them


def memory_of(pid: int | str) -> tuple[float, float, int, int]:
    """Return resident memory and what of it belongs to no file (MB), handles and threads."""
    place = Path("/proc") / str(pid)
    lines = (place / "status").read_text(encoding="ascii").splitlines()
    found = {line.partition(":")[0]: line.split()[1] for line in lines if len(line.split()) > 1}
    resident, anonymous = (int(found[name]) / 1024.0 for name in ("VmRSS", "RssAnon"))
    return resident, anonymous, len(list((place / "fd").iterdir())), int(found["Threads"])


def newest_arrivals(folder: Path, scratch: Path) -> dict[int, float]:
    """Return `latency.arrivals` of the end of a record alone."""
    scratch.mkdir(exist_ok=True)
    with (folder / "raw.tlog").open("rb") as file:
        file.seek(max(file.seek(0, os.SEEK_END) - _TAIL, 0))
        (scratch / "raw.tlog").write_bytes(file.read())
    return latency.arrivals(scratch)


def follow(window, folder: Path, scratch: Path, minutes: int, frames, *, trace: bool) -> list:
    """Print and return a row for each minute."""
    from PySide6.QtCore import QEventLoop, QTimer

    def run(seconds: float) -> None:
        loop = QEventLoop()
        QTimer.singleShot(round(1000 * seconds), loop.quit)
        loop.exec()

    rows, first = [], None
    recorder = window.flight_controller.session.recorder.pid
    print(
        f"    {'min':>4}{'window MB':>11}{'of no file':>12}{'handles':>9}{'threads':>9}"
        f"{'recorder MB':>13}{'handles':>9}{'frame ms':>10}{'worst':>7}{'latency ms':>12}"
        f"{'95th':>7}{'CPU %':>7}{'fits':>6}{'alarms':>8}"
    )
    begin = time.monotonic()
    for minute in range(1, minutes + 1):
        used = time.process_time()
        run(begin + 60.0 * minute - _WATCHED - time.monotonic())
        frames.reached, frames.shown, frames.cues, frames.watching = [], [], [], True
        run(begin + 60.0 * minute - time.monotonic())
        frames.watching = False
        share = (time.process_time() - used) / 60.0
        shown = frames.shown
        gaps = 1e3 * np.diff([at for _, at in shown]) if len(shown) > 1 else np.array([np.nan])
        late = latency.ages(shown, newest_arrivals(folder, scratch), shown[0][0]) if shown else {}
        delays = np.array(list(late.values()) or [np.nan])
        gc.collect()
        session = window.flight_controller.session
        own, theirs = memory_of("self"), memory_of(recorder)
        row = (
            minute, own[0], own[1], own[2], own[3], theirs[1], theirs[2], np.median(gaps),
            gaps.max(), np.median(delays), np.percentile(delays, 95), 100 * share,
            len(session.estimates.result.results), len(session.alarm_registry.current_alarms),
        )  # fmt: skip
        rows.append(row)
        print(
            "    {:4d}{:11.1f}{:12.1f}{:9d}{:9d}{:13.1f}{:9d}{:10.1f}{:7.1f}{:12.1f}{:7.1f}"
            "{:7.0f}{:6d}{:8d}".format(*row),
            flush=True,
        )
        if trace and minute == min(5, minutes - 1):
            tracemalloc.start(8)
            first = tracemalloc.take_snapshot()
    if first is not None:
        tell_growth(first, tracemalloc.take_snapshot())
    return rows


def tell_growth(first: tracemalloc.Snapshot, last: tracemalloc.Snapshot) -> None:
    for found in last.compare_to(first, "traceback")[:12]:
        print(f"    {found.size_diff / 1e6:+8.2f} MB in {found.count_diff:+,} pieces")
        print("\n".join(f"      {line.strip()}" for line in found.traceback.format()[-6:]))


def main(*given: str) -> list:
    """Run the window for so many minutes."""
    numbers = [one for one in given if one.isdigit()]
    minutes = int(numbers[0]) if numbers else 3 if "--quick" in given else 60
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from gsapp.virtual.downlink.aircraft_process import find_free_udp_port
    from ui.app import create_application
    from ui.dialogs.flight_requests import ConnectRequest

    application = create_application()
    frames = estimates_live.Seen(watching=False)
    with tempfile.TemporaryDirectory() as place:
        scratch = Path(place)
        os.environ["GSAPP_RUNTIME_FOLDER"] = str(scratch / "runtime")
        sent, folder = scratch / "sent", scratch / "flight"
        sent.mkdir()
        estimates_live.fly(sent / "raw.tlog", memory.FLIGHT)
        window = latency.watched_window(scratch, frames)
        port = find_free_udp_port()
        controller = window.flight_controller
        try:
            controller.flight_opener.connect_aircraft(
                ConnectRequest(
                    link=f"udpin:127.0.0.1:{port}", folder=folder, channel_map="b777",
                    aircraft="b777", calibration="b777",
                )
            )  # fmt: skip
            deadline = time.monotonic() + 30.0
            while not controller.is_open and time.monotonic() < deadline:
                application.processEvents()
            window.commands.actions["panel_estimates"].trigger()
            with sending(__file__, port, sent):
                rows = follow(
                    window, folder, scratch / "tail", minutes, frames, trace="--trace" in given
                )
        finally:
            controller.recorders.stop_recording_and_wait()
            controller.close()
            window.close()
            window.deleteLater()
            application.processEvents()
    used = np.array([row[2] for row in rows])
    for begin in range(0, len(rows) - 1, 10):
        part = used[begin : begin + 11]
        print(f"    minute {begin + 1} to {begin + len(part)}: {part[-1] - part[0]:+.1f} MB")
    return rows


if __name__ == "__main__":
    if sys.argv[1:2] == ["send"]:
        send_in_real_time(int(sys.argv[2]), memory.endless(Path(sys.argv[3])))
    else:
        main(*sys.argv[1:])
