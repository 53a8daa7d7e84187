"""The faults of the campaign: each brings one over a run, and says what is due then."""

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from functools import partial
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


# The recorder and its helpers


def recorder_killed(run: Run) -> None:
    run.begin()
    killed = time.monotonic()
    run.signal_recorder(signal.SIGKILL)
    run.announce("recorder")
    run.expected.add("link")  # frames are missing indeed
    run.record()
    run.excuse(killed)
    run.recover()


def recorder_frozen(run: Run) -> None:
    run.begin()
    pid = run.signal_recorder(signal.SIGSTOP)
    run.announce("recorder", "link")
    run.fly(run.choose.uniform(0.0, 4.0))
    os.kill(pid, signal.SIGCONT)
    run.recover()


def laptop_sleeps(run: Run) -> None:
    run.outcome.due = False
    run.begin()
    run.sender.silent = True
    time.sleep(0.05)
    pid = run.signal_recorder(signal.SIGSTOP)
    length = run.choose.uniform(3.0, 12.0)
    time.sleep(length)
    run.asleep += length
    os.kill(pid, signal.SIGCONT)
    run.expected.add("link")
    run.sender.silent = False
    run.recover()


def clock_set(run: Run, direction: int) -> None:
    run.record_here()
    run.begin()
    run.outcome.due = direction < 0
    run.expected.update(("clock",) if run.outcome.due else ())
    run.set_clock(direction * run.choose.choice((1.5, 5.0, 60.0, 3600.0, 86400.0)))
    run.recover()
    if run.outcome.due:
        run.announce("clock")
    else:
        run.fly(1.0)


def worker_killed(run: Run) -> None:
    run.outcome.due = False
    run.start_at(run.choose.uniform(0.0, 30.0))
    run.sender.speed = 6.0
    run.begin(workers=ProcessFitWorker())
    fits = run.session.estimates.fits
    if run.wait(lambda: fits.pending, 60.0, wrong="no maneuver was fitted") is None:
        return
    run.fly(run.choose.uniform(0.0, 1.5))
    known = len(fits.result.results)
    for pid in estimates_live.children(os.getpid()):
        words = Path(f"/proc/{pid}/cmdline").read_bytes()
        if pid != run.handle.pid and b"spawn_main" in words:
            os.kill(pid, signal.SIGKILL)
    run.wait(lambda: len(fits.result.results) > known, 40.0, wrong="no fit after the fault")
    run.outcome.recovered = 0.0
    run.outcome.wrong += [f"{name}: {why}" for name, why in fits.failures.items()]


# Folders and disks


def moved(run: Run, lose: Callable[[Run], object]) -> None:
    """Take the folder away; go on in that to which the record moves, as the window does."""
    run.begin()
    begin = time.monotonic()
    lose(run)
    run.expected.update(("folder", "recorder", "link"))
    text = "the record does not go on elsewhere"
    took = run.wait(lambda: run.session.equipment.moved_to is not None, wrong=text)
    if took is None:
        return
    is_announced = run.is_announced("folder", "recorder")
    run.outcome.announced = took if is_announced else None
    run.session.close()
    run.folder = run.session.equipment.moved_to
    run.sessions = [run.follow()]
    run.recover()
    run.outcome.recovered = (run.outcome.recovered or 0.0) + took
    if not is_announced and run.is_announced("folder", "recorder"):
        run.outcome.announced = time.monotonic() - begin


def remove_folder(run: Run) -> None:
    while run.folder.exists():  # a status may be written meanwhile
        shutil.rmtree(run.folder, ignore_errors=True)


def runtime_folder_removed(run: Run) -> None:
    run.outcome.due = False
    run.begin()
    shutil.rmtree(run.scratch / "run")
    run.fly(1.5)
    run.recover()


def command(*words: str | Path, check: bool = True) -> None:
    found = shutil.which(words[0])
    subprocess.run([found, *words[1:]], check=check, stderr=subprocess.DEVNULL)


def mount_disk(run: Run) -> Path:
    place = run.folder.parent
    place.mkdir(parents=True)
    command("mount", "-t", "tmpfs", "-o", "size=1g", "tmpfs", place)
    run.cleanup.callback(command, "umount", "-l", place, check=False)
    return place


def disk_full(run: Run) -> None:
    place = mount_disk(run)
    run.begin()
    used = os.statvfs(place)
    blocks = used.f_blocks - used.f_bfree + run.choose.randrange(2, 6)
    command("mount", "-o", f"remount,size={blocks * used.f_frsize}", place)
    run.announce("recorder", "disk")
    run.fly(run.choose.uniform(0.5, 4.0))
    command("mount", "-o", "remount,size=1g", place)
    run.recover()


def disk_pulled(run: Run) -> None:
    place = mount_disk(run)
    moved(run, lambda _run: command("umount", "-l", place))


# Links


def port_unplugged(run: Run, *, renamed: bool) -> None:
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

    if renamed:
        run.record_here(ports=ports)  # a fork would hold what is open now
    port.plug()
    run.begin()
    plugged.write_text("")
    at = time.monotonic()
    port.unplug()
    run.announce("link")
    run.excuse(at - 0.05, at + 0.05)  # what the driver still held never reached a program
    if renamed:
        port.name = run.scratch / "ttyOther"
    else:
        run.fly(run.choose.uniform(0.0, 1.0))
    port.plug()
    plugged.write_text(str(port.name))
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


Shape = Callable[[Run, list[bytes], bytes], list[bytes]]


def deformed(
    run: Run, shape: Shape, seconds: tuple[float, float], expected: tuple[str, ...] = ()
) -> None:
    """Send for some seconds what a function makes of each frame, then what it held back."""
    held: list[bytes] = []

    def release(frame: bytes) -> list[bytes]:
        found = [*held, frame]
        held.clear()
        return found

    run.outcome.due = False
    run.begin()
    run.expected.update(expected)
    run.sender.shape = partial(shape, run, held)
    run.fly(run.choose.uniform(*seconds))
    run.sender.shape = release
    run.recover()


def spoil(run: Run, _held: list[bytes], frame: bytes) -> list[bytes]:
    choose = run.choose
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


def hold(_run: Run, held: list[bytes], frame: bytes) -> list[bytes]:
    held.append(frame)
    return []


def shuffle(run: Run, held: list[bytes], frame: bytes) -> list[bytes]:
    held.append(frame)
    if run.choose.random() < 0.1:
        return []
    run.choose.shuffle(held)
    found = [*held, *(one for one in held if run.choose.random() < 0.2)]
    held.clear()
    return found


def two_aircraft(run: Run) -> None:
    """Another one of another id, which the map rules out, or of the same id: from there or here."""
    run.begin()
    kind = run.choose.choice(("other id", "other address", "same address"))
    run.offset += 20.0
    other = Sender(run.part(), run.sender.deliver if kind == "same address" else udp(run.port))
    if kind == "other id":
        other.shape = lambda frame: [of_system(frame, 7)]
    run.senders.append(other)
    other.start()
    run.outcome.due = kind != "other id"
    if run.outcome.due:
        run.expected.add("link")
        run.announce("aircraft", "stranger")
    run.fly(1.0)
    flown = run.session.decoder.health.report(run.session.equipment.host_us()).system
    if flown != 1:
        run.outcome.wrong.append(f"system {flown} is flown")
    other.stop()
    run.recover()


# Windows


def second_window(run: Run) -> None:
    run.outcome.due = False
    run.begin()
    one, two = run.session, run.follow()
    run.sessions.append(two)
    run.recover(lambda: run.is_current(two))
    mark = one.mark("a mark")
    text = "a mark does not reach the other window"
    run.wait(lambda: mark.text in [other.text for other in two.marks], 3.0, wrong=text)
    run.sender.silent = True
    run.expected.add("link")
    run.wait(lambda: run.alarm("link", session=one) and run.alarm("link", session=two))
    one.acknowledge_all()
    text = "an acknowledgment does not reach the other window"
    run.wait(lambda: not two.alarm_registry.unacknowledged, 3.0, wrong=text)
    run.sender.silent = False
    run.recover()
    end = min(one.now, two.now) - 0.5
    for name in one.history.channels:
        blocks = [each.history.block((name,), end - 2.0, end) for each in (one, two)]
        if not np.array_equal(blocks[0].values, blocks[1].values, equal_nan=True):
            run.outcome.wrong.append(f"the windows show different samples of {name}")


def in_window(run: Run, fault: Callable[[Run, Window], Window]) -> None:
    """Bring a fault over the real window, and wait for the one that is left."""
    run.start()
    run.outcome.due = False
    window = Window(run)
    window.wait(60.0)
    time.sleep(run.choose.uniform(0.0, 1.5))
    begin = time.monotonic()
    window = fault(run, window)
    began, took = time.monotonic(), window.wait(60.0)
    if took is not None:
        run.outcome.recovered = took + (began - begin if run.outcome.due else 0.0)
    if run.outcome.due:
        run.excuse(begin)
    time.sleep(0.5)
    run.outcome.false += [
        f"{key}: in the window"
        for key in window.alarms
        if key in EQUIPMENT and key not in run.expected
    ]


def kill_window(run: Run, window: Window) -> Window:
    window.stop()
    time.sleep(run.choose.uniform(0.0, 1.0))
    return Window(run)


def freeze_window(run: Run, window: Window) -> Window:
    window.process.send_signal(signal.SIGSTOP)
    time.sleep(run.choose.uniform(1.0, 6.0))
    window.process.send_signal(signal.SIGCONT)
    return window


def kill_recorder(run: Run, window: Window) -> Window:
    run.outcome.due = True
    run.expected.update(("recorder", "link"))
    died = run.handle
    run.signal_recorder(signal.SIGKILL)
    run.outcome.announced = run.wait(lambda: "recorder" in window.alarms, step=False)
    text = "the window does not start the recorder again"
    if run.wait(lambda: run.handle not in (None, died), 8.0, step=False, wrong=text) is None:
        run.record()
    return window


# Power


def power_lost(run: Run) -> None:
    """Open the record as cut off at every byte of its last second, and go on from there."""
    run.outcome.due = False
    run.begin()
    run.fly(1.0)
    run.session.mark("the last mark")
    run.signal_recorder(signal.SIGKILL)
    run.finish()
    # Its last bytes may be lost: only what the file holds counts.
    run.outcome.lost = 0
    raw, copy = run.folder / "raw.tlog", run.scratch / "copy"
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
            whole = int((bounds <= size).sum()) if name == "raw.tlog" else len(ends)
            try:
                wrong = go_on(copy, whole, run.flight[0][1], may_pass=name == "recorder.json")
            except Exception as error:  # whatever it is, it is a defect
                wrong = [repr(error)]
            run.outcome.wrong += [f"{name} of {size} bytes: {text}" for text in wrong]


def go_on(folder: Path, whole: int, frame: bytes, *, may_pass: bool) -> list[str]:
    """Read, continue and follow a record of so many whole frames; return what is wrong.

    `may_pass`: whether it may pass for finished.
    """
    wrong = []
    state, loaded = record_state(folder), load_flight(folder)
    writer = RawWriter(folder)
    writer.append(writer.last_stamp + 1, Framer().feed(frame))
    writer.close()
    kept = len([one for one in RawTail(folder).poll() if one.kind == "frame"])
    if kept != whole + 1 or not len(loaded.block):
        wrong.append(f"{kept - 1} of {whole} frames")
    if state != "interrupted" and not may_pass:
        wrong.append(f"the record passes for {state}")
    session = Session.follow(folder, channel_map="b777", aircraft="b777")
    for _ in range(3):
        session.update(0.05)
    problem = session.snapshot().problem
    session.close()
    return [*wrong, *filter(None, (problem,))]


FAULTS: dict[str, Callable[[Run], object]] = {
    "control": control,
    "recorder_killed": recorder_killed,
    "recorder_frozen": recorder_frozen,
    "folder_removed": partial(moved, lose=remove_folder),
    "folder_renamed": partial(
        moved, lose=lambda run: run.folder.rename(run.folder.with_name("elsewhere"))
    ),
    "folder_read_only": partial(moved, lose=lambda run: run.folder.chmod(0o555)),
    "runtime_folder_removed": runtime_folder_removed,
    "disk_full": disk_full,
    "disk_pulled": disk_pulled,
    "worker_killed": worker_killed,
    "port_unplugged": partial(port_unplugged, renamed=False),
    "port_renamed": partial(port_unplugged, renamed=True),
    "garbage": partial(deformed, shape=spoil, seconds=(1.0, 3.0), expected=("link", "aircraft")),
    "burst": partial(deformed, shape=hold, seconds=(0.5, 8.0), expected=("link",)),
    "silence": silence,
    "duplicates": partial(deformed, shape=shuffle, seconds=(2.0, 5.0)),
    "clock_back": partial(clock_set, direction=-1),
    "clock_forward": partial(clock_set, direction=1),
    "two_aircraft": two_aircraft,
    "second_window": second_window,
    "laptop_sleeps": laptop_sleeps,
    "power_lost": power_lost,
    "window_killed": partial(in_window, fault=kill_window),
    "window_frozen": partial(in_window, fault=freeze_window),
    "recorder_killed_under_window": partial(in_window, fault=kill_recorder),
}
FOR_ROOT = {"folder_read_only", "disk_full", "disk_pulled"}
