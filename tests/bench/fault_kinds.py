"""The faults of the campaign: each brings one over a run, and says what is due then."""

import contextlib
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from gsapp.decoding.framing import Framer
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.raw_files import RawTail, RawWriter, read_tlog
from gsapp.flight.raw_files.record_files import find_file_end
from gsapp.session import Session
from gsapp.session.live_estimation.fit_workers import ProcessFitWorker
from gsapp.telemetry.recorder_folder import record_state
from tests.bench import estimates_live
from tests.bench.fault_runs import EQUIPMENT, Run, Sender, SerialPort, Window, of_system, udp


def control(run: Run) -> None:
    run.outcome.due = False
    run.begin()
    run.fly(3.0)


def recorder_killed(run: Run) -> None:
    run.begin()
    killed = time.monotonic()
    run.kill_recorder()
    run.announce("recorder")
    run.expected.add("link")  # frames are missing indeed
    run.record()
    run.excuse(killed, time.monotonic())
    run.recover()


def recorder_frozen(run: Run) -> None:
    run.begin()
    run.kill_recorder(signal.SIGSTOP)
    pid = run.handle.pid
    run.announce("recorder", "link")
    run.expected.update(("recorder", "link"))
    run.fly(run.choose.uniform(0.0, 4.0))
    os.kill(pid, signal.SIGCONT)
    run.recover()


def _moved(run: Run) -> None:
    """Go on in the folder to which the record moved, as the window does."""
    run.expected.update(("folder", "recorder", "link"))
    begin = time.monotonic()
    took = run.wait(lambda: run.session.equipment.moved_to is not None)
    if took == float("inf"):
        run.outcome.wrong.append("the record does not go on elsewhere")
        return
    run.outcome.announced = took if run.is_announced("folder", "recorder") else None
    run.session.close()
    run.folder = run.session.equipment.moved_to
    run.session = run.follow()
    run.recover()
    run.outcome.recovered = run.outcome.recovered + took
    if run.outcome.announced is None:
        run.outcome.announced = (
            time.monotonic() - begin if run.is_announced("folder", "recorder") else None
        )


def folder_removed(run: Run) -> None:
    run.begin()
    while run.folder.exists():  # a status may be written meanwhile
        shutil.rmtree(run.folder, ignore_errors=True)
    _moved(run)


def folder_renamed(run: Run) -> None:
    run.begin()
    run.folder.rename(run.folder.with_name("elsewhere"))
    _moved(run)


def folder_read_only(run: Run) -> None:
    run.begin()
    run.folder.chmod(0o555)
    _moved(run)


def runtime_folder_removed(run: Run) -> None:
    run.outcome.due = False
    run.begin()
    shutil.rmtree(run.scratch / "run")
    run.fly(1.5)
    run.recover()


def _command(*words: str | Path, check: bool = True) -> None:
    found = shutil.which(words[0])
    subprocess.run([found, *words[1:]], check=check, stderr=subprocess.DEVNULL)


@contextlib.contextmanager
def disk(place: Path, size: str = "1g") -> Iterator[None]:
    place.mkdir(parents=True)
    _command("mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", place)
    try:
        yield
    finally:
        _command("umount", "-l", place, check=False)


def resize(place: Path, size: str) -> None:
    _command("mount", "-o", f"remount,size={size}", place)


def disk_full(run: Run) -> None:
    place = run.folder.parent
    with disk(place):
        run.begin()
        used = os.statvfs(place)
        blocks = used.f_blocks - used.f_bfree + run.choose.randrange(2, 6)
        resize(place, str(blocks * used.f_frsize))
        run.announce("recorder", "disk")
        run.expected.update(("recorder", "disk"))
        run.fly(run.choose.uniform(0.5, 4.0))
        resize(place, "1g")
        run.recover()
        run.finish()
        run.count()


def disk_pulled(run: Run) -> None:
    place = run.folder.parent
    with disk(place):
        run.begin()
        _command("umount", "-l", place)
        _moved(run)
        run.finish()
        run.count()


def worker_killed(run: Run) -> None:
    run.outcome.due = False
    run.offset = run.choose.uniform(0.0, 30.0)
    run.sender = Sender(run.part(), udp(run.port))
    run.senders = [run.sender]
    run.sender.speed = 6.0
    run.begin(workers=ProcessFitWorker())
    fits = run.session.estimates.fits
    if run.wait(lambda: fits.pending, 60.0) == float("inf"):
        run.outcome.wrong.append("no maneuver was fitted")
        return
    run.fly(run.choose.uniform(0.0, 1.5))
    known = len(fits.result.results)
    for pid in estimates_live.children(os.getpid()):
        words = Path(f"/proc/{pid}/cmdline").read_bytes()
        if pid != run.handle.pid and b"spawn_main" in words:
            os.kill(pid, signal.SIGKILL)
    took = run.wait(lambda: len(fits.result.results) > known, 40.0)
    run.outcome.recovered = took if took == float("inf") else 0.0
    run.outcome.wrong += [f"{name}: {why}" for name, why in fits.failures.items()]


def port_unplugged(run: Run) -> None:
    port = SerialPort(run.scratch / "ttyGround")
    port.plug()
    run.link = f"serial:{port.name}:115200"
    run.sender.deliver = port.deliver
    run.begin()
    _pulled(run, port)
    run.fly(run.choose.uniform(0.0, 1.0))
    port.plug()
    run.recover()


def _pulled(run: Run, port: SerialPort) -> None:
    """Pull the plug; what the driver still held then never reached a program."""
    at = time.monotonic()
    port.unplug()
    run.announce("link")
    run.excuse(at - 0.05, at + 0.05)


def port_renamed(run: Run) -> None:
    port = SerialPort(run.scratch / "ttyGround")
    run.link = f"serial:{port.name}:115200"
    run.sender.deliver = port.deliver
    plugged = run.scratch / "plugged"
    plugged.write_text(str(port.name))

    def ports() -> list[SimpleNamespace]:
        return [
            SimpleNamespace(device=one, vid=0x0403, pid=0x6015, serial_number="AB12")
            for one in plugged.read_text().split()
        ]

    run.record_here(ports=ports)  # a fork would hold what is open now
    port.plug()
    run.begin()
    plugged.write_text("")
    _pulled(run, port)
    port.name = run.scratch / "ttyOther"
    port.plug()
    plugged.write_text(str(port.name))
    run.recover()


def garbage(run: Run) -> None:
    choose = run.choose

    def spoil(frame: bytes) -> list[bytes]:
        kind = choose.random()
        if kind < 0.1:
            return [frame, choose.randbytes(choose.randrange(1, 600))]
        if kind < 0.15:  # cut, with the start of a frame that never ends
            return [frame[: choose.randrange(1, len(frame))], b"\xfd\xff\x00"]
        if kind < 0.2:
            wrong = bytearray(frame)
            wrong[choose.randrange(len(wrong))] ^= 1 << choose.randrange(8)
            return [bytes(wrong)]
        return [frame]

    run.outcome.due = False
    run.begin()
    run.expected.update(("link", "aircraft"))
    run.sender.shape = spoil
    run.fly(run.choose.uniform(1.0, 3.0))
    run.sender.shape = lambda frame: [frame]
    run.recover()


def burst(run: Run) -> None:
    run.outcome.due = False
    waiting: list[bytes] = []
    run.begin()
    run.sender.shape = lambda frame: waiting.append(frame) or []
    run.expected.add("link")
    run.fly(run.choose.uniform(0.5, 8.0))

    def release(frame: bytes) -> list[bytes]:
        found = [*waiting, frame]
        waiting.clear()
        return found

    run.sender.shape = release
    run.recover()


def silence(run: Run) -> None:
    run.begin()
    run.sender.silent = True
    began = time.monotonic()
    run.announce("link")
    length = 30.0 if run.choose.random() < 0.15 else run.choose.uniform(0.0, 2.0)
    run.fly(max(began + length - time.monotonic(), 0.0))
    run.sender.silent = False
    run.recover()


def duplicates(run: Run) -> None:
    choose, held = run.choose, []
    run.outcome.due = False

    def shuffle(frame: bytes) -> list[bytes]:
        held.append(frame)
        if choose.random() < 0.1:
            return []
        choose.shuffle(held)
        found = [*held, *(one for one in held if choose.random() < 0.2)]
        held.clear()
        return found

    run.begin()
    run.sender.shape = shuffle
    run.fly(run.choose.uniform(2.0, 5.0))
    run.sender.shape = lambda frame: [*held, frame]
    time.sleep(0.02)
    run.sender.shape = lambda frame: [frame]
    run.recover()


def clock_back(run: Run) -> None:
    run.record_here()
    run.begin()
    run.expected.add("clock")
    run.set_clock(-run.choose.choice((1.5, 5.0, 60.0, 3600.0, 86400.0)))
    run.recover()
    run.announce("clock")


def clock_forward(run: Run) -> None:
    run.outcome.due = False
    run.record_here()
    run.begin()
    run.set_clock(run.choose.choice((1.5, 5.0, 60.0, 3600.0, 86400.0)))
    run.recover()
    run.fly(1.0)


def two_aircraft(run: Run) -> None:
    """Another one of another id, which the map rules out, or of the same id: from there or here."""
    run.begin()
    kind = run.choose.choice(("other id", "other address", "same address"))
    deliver = run.sender.deliver if kind == "same address" else udp(run.port)
    run.offset += 20.0
    other = Sender(run.part(), deliver)
    if kind == "other id":
        other.shape = lambda frame: [of_system(frame, 7)]
    run.senders.append(other)
    other.start()
    run.outcome.due = kind != "other id"
    run.expected.update(("aircraft", "stranger", "link") if run.outcome.due else ())
    if run.outcome.due:
        run.announce("aircraft", "stranger")
    run.fly(1.0)
    flown = run.session.decoder.health.report(run.session.equipment.host_us()).system
    if flown != 1:
        run.outcome.wrong.append(f"system {flown} is flown")
    other.stop()
    run.recover()


def second_window(run: Run) -> None:
    run.outcome.due = False
    run.begin()
    run.others.append(run.follow())
    run.recover(lambda: run.is_current(run.others[0]))
    one, two = run.session, run.others[0]
    mark = one.mark("a mark")
    if run.wait(lambda: mark.text in [other.text for other in two.marks], 3.0) == float("inf"):
        run.outcome.wrong.append("a mark does not reach the other window")
    run.sender.silent = True
    run.expected.add("link")
    run.wait(lambda: run.alarm("link", session=one) and run.alarm("link", session=two))
    one.acknowledge_all()
    if run.wait(lambda: not two.alarm_registry.unacknowledged, 3.0) == float("inf"):
        run.outcome.wrong.append("an acknowledgment does not reach the other window")
    run.sender.silent = False
    run.recover()
    end = min(one.now, two.now) - 0.5
    for name in one.history.channels:
        blocks = [each.history.block((name,), end - 2.0, end) for each in (one, two)]
        if not np.array_equal(blocks[0].values, blocks[1].values, equal_nan=True):
            run.outcome.wrong.append(f"the windows show different samples of {name}")


def laptop_sleeps(run: Run) -> None:
    run.outcome.due = False
    run.begin()
    pid = run.handle.pid
    run.sender.silent = True
    time.sleep(0.05)
    os.kill(pid, signal.SIGSTOP)
    length = run.choose.uniform(3.0, 12.0)
    time.sleep(length)
    run.asleep += length
    os.kill(pid, signal.SIGCONT)
    run.expected.update(("link",))
    run.sender.silent = False
    run.recover()


def power_lost(run: Run) -> None:
    """Open the record as cut off at every byte of its last second, and go on from there."""
    run.outcome.due = False
    run.begin()
    run.fly(1.0)
    run.session.mark("the last mark")
    run.kill_recorder()
    for sender in run.senders:
        sender.stop()
    run.session.close()
    run.session, copy = None, run.scratch / "copy"
    raw = run.folder / "raw.tlog"
    ends, position = [], 0
    for record in read_tlog(raw):
        position += 8 + len(record.data)
        ends.append((position, record.stamp_us))
    first = next(end for end, stamp in ends if stamp > ends[-1][1] - 1_000_000)
    bounds = np.array([end for end, _ in ends])
    shutil.copytree(run.folder, copy)
    begin = time.monotonic()
    for size in range(raw.stat().st_size, first, -1):
        os.truncate(copy / "raw.tlog", size)
        whole = int(bounds[bounds <= size].max())
        end = find_file_end(copy / "raw.tlog")
        if (end.size, end.torn) != (whole, size - whole):
            run.outcome.wrong.append(f"{size} bytes: {end}, and {whole} are whole")
            run.outcome.lost += whole - end.size
    run.outcome.recovered = (time.monotonic() - begin) / (raw.stat().st_size - first)
    for name in ("raw.tlog", "senders.txt", "recorder.json", "events.jsonl", "recorder.lock"):
        there = run.folder / name
        length = there.stat().st_size if there.exists() else 0
        cuts = range(first, length) if name == "raw.tlog" else range(length)
        for size in run.choose.sample(cuts, min(len(cuts), 12)):
            shutil.rmtree(copy)
            shutil.copytree(run.folder, copy)
            os.truncate(copy / name, size)
            _go_on(run, copy, f"{name} of {size} bytes", ends, size if name == "raw.tlog" else None)


def _go_on(
    run: Run, folder: Path, what: str, ends: list[tuple[int, int]], size: int | None
) -> None:
    try:
        state = record_state(folder)
        frame = run.flight[0][1]
        whole = sum(end <= size for end, _ in ends) if size is not None else len(ends)
        loaded = load_flight(folder)
        writer = RawWriter(folder)
        writer.append(writer.last_stamp + 1, Framer().feed(frame))
        writer.close()
        kept = len([one for one in RawTail(folder).poll() if one.kind == "frame"])
        if kept != whole + 1 or not len(loaded.block):
            run.outcome.wrong.append(f"{what}: {kept - 1} of {whole} frames")
        if state != "interrupted" and "recorder.json" not in what:
            run.outcome.wrong.append(f"{what}: the record passes for {state}")
        session = Session.follow(folder, channel_map="b777", aircraft="b777")
        for _ in range(3):
            session.update(0.05)
        if session.snapshot().problem:
            run.outcome.wrong.append(f"{what}: {session.snapshot().problem}")
        session.close()
    except Exception as error:  # whatever it is, it is a defect
        run.outcome.wrong.append(f"{what}: {error!r}")


# With the window


@contextlib.contextmanager
def window_of(run: Run) -> Iterator[Window]:
    run.prepare()
    run.record()
    run.sender.start()
    window = Window(run)
    try:
        if run.wait(window.is_current, 60.0, step=False) == float("inf"):
            raise TimeoutError("the window did not show the flight")
        time.sleep(run.choose.uniform(0.0, 1.5))
        yield window
    finally:
        window.stop()


def window_killed(run: Run) -> None:
    run.outcome.due = False  # nobody is left who could
    with window_of(run) as window:
        window.process.kill()
        time.sleep(run.choose.uniform(0.0, 1.0))
        again = Window(run)
        run.outcome.recovered = run.wait(again.is_current, 60.0, step=False)
        _check_window(run, again)
        again.stop()


def window_frozen(run: Run) -> None:
    run.outcome.due = False
    with window_of(run) as window:
        window.process.send_signal(signal.SIGSTOP)
        time.sleep(run.choose.uniform(1.0, 6.0))
        window.process.send_signal(signal.SIGCONT)
        run.outcome.recovered = run.wait(window.is_current, step=False)
        _check_window(run, window)


def recorder_killed_under_window(run: Run) -> None:
    run.expected.update(("recorder", "link"))
    with window_of(run) as window:
        killed, died = time.monotonic(), run.handle
        run.kill_recorder()
        took = run.wait(lambda: "recorder" in window.state().get("alarms", ()), step=False)
        run.outcome.announced = None if took == float("inf") else took
        if run.wait(lambda: run.handle not in (None, died), 8.0, step=False) == float("inf"):
            run.outcome.wrong.append("the window does not start the recorder again")
            run.record()
        run.wait(window.is_current, step=False)
        run.outcome.recovered = time.monotonic() - killed
        run.excuse(killed, time.monotonic())
        _check_window(run, window)


def _check_window(run: Run, window: Window) -> None:
    time.sleep(0.5)
    for key in window.state().get("alarms", ()):
        if key in EQUIPMENT and key not in run.expected:
            run.outcome.false.append(f"{key}: in the window")


FAULTS = {
    one.__name__: one
    for one in (
        control, recorder_killed, recorder_frozen, folder_removed, folder_renamed,
        folder_read_only, runtime_folder_removed, disk_full, disk_pulled, worker_killed,
        port_unplugged, port_renamed, garbage, burst, silence, duplicates, clock_back,
        clock_forward, two_aircraft, second_window, laptop_sleeps, power_lost, window_killed,
        window_frozen, recorder_killed_under_window,
    )
}  # fmt: skip
FOR_ROOT = {"folder_read_only", "disk_full", "disk_pulled"}
