"""Many short virtual flights through one interface: processes of this computer, and Dask.

Arguments: COUNT of flights (60), FOLDER that keeps them from run to run. What is printed: flights
flown a minute; ``gsapp estimate`` over a tenth of them in one process, over the others on Dask with
a worker for each core: time, CPU, memory of the largest process; whether the JSON is the same to
the last bit wherever it was made, with a worker killed in the middle, too; overhead of a task; what
1,000 flights would need.
"""

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from gsapp.foundation.executors import WorkerPool
from gsapp.virtual.downlink.flight_recording import record_virtual_flight
from gsapp.virtual.downlink.flight_settings import FlightSettings
from tests.cli.command_kit import busy_worker

GSAPP = (sys.executable, "-m", "gsapp.cli")
CORES = os.cpu_count() or 1
GOAL = 1000  # flights
TASKS = 500  # that do nothing, for the overhead
PLAN = """
[engines]
start = "0.2 s"
running = "1.5 s"
[pattern]
height = "120 ft"
leg = "5 s"
[[maneuvers]]
inputs = ["de"]
stick = [0.26]
step = "0.45 s"
"""


@dataclass(frozen=True)
class Call:
    """One call of a command."""

    seconds: float
    cpu: float
    memory: float  # MB, of its largest process
    content: bytes  # Its JSON.


def record(plan: Path, task: tuple[int, Path]) -> None:
    """Fly the plan once."""
    seed, folder = task
    record_virtual_flight(FlightSettings(plan=str(plan), seed=seed), folder)


def fly(folder: Path, count: int) -> list[Path]:
    """Return as many flights, of which those that lack are flown on all cores."""
    plan = folder / "plan.toml"
    plan.write_text(PLAN)
    paths = [folder / f"flight{seed}" for seed in range(count)]
    lacking = [(seed, path) for seed, path in enumerate(paths) if not path.exists()]
    started = time.monotonic()
    with WorkerPool(f"local:{CORES}") as pool:
        made = len(list(pool.map(partial(record, plan), lacking)))
    if made:
        rate = 60.0 * made / (time.monotonic() - started)
        print(f"  flown on local:{CORES}: {made} flights, {rate:.1f} a minute", flush=True)
    return paths


def estimate(flights: list[Path], *options: str, kill: bool = False) -> Call:
    """Call the command; with `kill`, one of its workers is killed when it is busy."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.json"
        command = [*GSAPP, "estimate", *map(str, flights), "--json", str(out), *options]
        started = time.monotonic()
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        ended, status, used = os.wait4(child.pid, os.WNOHANG if kill else 0)
        while not ended:
            if kill and (worker := busy_worker(child.pid)) is not None:
                os.kill(worker, signal.SIGKILL)
                kill = False
            time.sleep(0.02)
            ended, status, used = os.wait4(child.pid, os.WNOHANG if kill else 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            raise RuntimeError(f"exit code {child.returncode}: {' '.join(command)}")
        if kill:
            raise RuntimeError("no worker was busy long enough to be killed; take more flights")
        # As the system counts: the command and, as they end, its processes.
        return Call(
            seconds=time.monotonic() - started,
            cpu=used.ru_utime + used.ru_stime,
            memory=used.ru_maxrss / 1024,
            content=out.read_bytes(),
        )


def cores_given() -> float:
    """Return how many cores other programs leave to this one."""
    code = "import time\nwhile time.process_time() < 2.0: pass"
    started = time.monotonic()
    burning = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(CORES)]
    for one in burning:
        one.wait()
    return 2.0 * CORES / (time.monotonic() - started)


def overhead(address: str) -> tuple[float, float]:
    """Return seconds to the first result, and milliseconds of each further task."""
    with WorkerPool(address) as pool:
        started = time.monotonic()
        found = pool.map(abs, range(TASKS))
        next(found)
        first = time.monotonic() - started
        assert list(found) == list(range(1, TASKS))
        return first, 1e3 * (time.monotonic() - started - first) / TASKS


def show(title: str, call: Call, count: int, same: bytes | None = None) -> None:
    bits = "" if same is None else f", JSON {'the same' if call.content == same else 'DIFFERENT'}"
    print(
        f"  {title:26} {count:4} flights {call.seconds:7.1f} s, CPU {call.cpu:6.1f} s, largest "
        f"process {call.memory:4.0f} MB{bits}",
        flush=True,
    )


def main(*arguments: str) -> dict[str, float]:
    """Measure and print; return figures by name."""
    given = [one for one in arguments if not one.startswith("-")]
    count = int(given[0]) if given else 60
    print(f"  {CORES} cores, of which other programs leave {cores_given():.1f}")
    addresses = [f"local:{CORES}"]
    if importlib.util.find_spec("distributed") is None:
        print("  Dask is not installed")
    else:
        addresses.append(f"dask://local:{CORES}")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(given[1]) if len(given) > 1 else Path(temporary)
        flights = fly(folder, count)
        # Reading a flight for the first time decodes it, and keeps that beside it: both ways get
        # flights that nobody has read.
        for one in folder.glob("flight*/cache"):
            shutil.rmtree(one)
        few, many = flights[: max(count // 10, 6)], flights[max(count // 10, 6) :]
        single = estimate(few)
        show("one process, first reading", single, len(few))
        pooled = estimate(many, "--on", addresses[-1])
        show(f"{addresses[-1]}, first reading", pooled, len(many))
        speedup = (single.seconds / len(few)) / (pooled.seconds / len(many))
        print(f"  a flight {speedup:.2f} times as soon as in one process")
        size = sum(one.stat().st_size for one in flights[0].rglob("*") if one.is_file()) / 1e6
        for number in sorted({6, len(few)}):
            whole = estimate(few[:number])
            show("one process, again", whole, number)
        for address in addresses:
            show(f"{address}, again", estimate(few, "--on", address), len(few), whole.content)
            killed = estimate(few, "--on", address, kill=True)
            show(f"{address}, a worker killed", killed, len(few), whole.content)
        for one in addresses:
            first, each = overhead(one)
            print(f"  {one}: first result after {first:.1f} s, {each:.2f} ms a task")
        share = GOAL / len(few)
        print(
            f"  {GOAL} flights would take {GOAL * size / 1e3:.1f} GB on the disk and "
            f"{share * single.cpu / 60:.0f} minutes of CPU"
        )
    return {"speedup": speedup, "memory": pooled.memory}


if __name__ == "__main__":
    main(*sys.argv[1:])
