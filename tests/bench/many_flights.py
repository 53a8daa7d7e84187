"""Many short virtual flights through one interface: processes of this computer, and Dask.

Arguments: COUNT of flights (60), FOLDER that keeps them from run to run. What is printed: flights
flown a minute; ``gsapp estimate`` in one process, in as many as there are cores and on Dask: time,
CPU, memory of the largest process by number of flights; whether the JSON is the same to the last
bit; what a killed worker costs; overhead of a task; what 1,000 flights would need.
"""

import importlib.util
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from gsapp.foundation.executors import WorkerPool
from tests.cli.command_kit import busy_worker

GSAPP = (sys.executable, "-m", "gsapp.cli")
CORES = os.cpu_count() or 1
GOAL = 1000  # flights
TASKS = 500  # that do nothing, for the overhead


@dataclass(frozen=True)
class Call:
    """One call of a command."""

    seconds: float
    cpu: float
    memory: float  # MB, of its largest process
    content: bytes  # Its JSON.


def fly(folder: Path, count: int) -> list[Path]:
    """Return as many flights, of which those that lack are flown on all cores."""
    paths = [folder / f"flight{seed}" for seed in range(count)]
    commands = [
        [*GSAPP, "fly", "--out", str(path), "--plan", "short", "--seed", str(seed)]
        for seed, path in enumerate(paths)
        if not path.exists()
    ]
    for address, part in (("local:1", commands[:2]), (f"local:{CORES}", commands[2:])):
        started = time.monotonic()
        with WorkerPool(address) as pool:
            run = partial(subprocess.run, check=True, capture_output=True)
            made = len(list(pool.map(run, part)))
        if made:
            rate = 60.0 * made / (time.monotonic() - started)
            print(f"  flown on {address}: {made} flights, {rate:.1f} a minute", flush=True)
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
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(given[1]) if len(given) > 1 else Path(temporary)
        flights = fly(folder, count)
        # Reading a flight for the first time decodes it, and keeps that beside it.
        show("one process, first reading", estimate(flights), count)
        size = sum(one.stat().st_size for one in flights[0].rglob("*") if one.is_file()) / 1e6
        calls = {}
        for number in sorted({min(6, count), min(24, count), count}):
            calls[number] = estimate(flights[:number])
            show("one process", calls[number], number)
        whole = calls[count]
        address = f"local:{CORES}"
        pooled = estimate(flights, "--on", address)
        show(address, pooled, count, whole.content)
        killed = estimate(flights, "--on", address, kill=True)
        show(f"{address}, a worker killed", killed, count, whole.content)
        addresses = [address]
        if importlib.util.find_spec("distributed") is None:
            print("  Dask is not installed")
        else:
            addresses.append(f"dask://local:{CORES}")
            show(addresses[1], estimate(flights, "--on", addresses[1]), count, whole.content)
        for one in addresses:
            first, each = overhead(one)
            print(f"  {one}: first result after {first:.1f} s, {each:.2f} ms a task")
        share = GOAL / count
        print(
            f"  {GOAL} flights would take {share * size * count / 1e3:.1f} GB on the disk and "
            f"{share * whole.cpu / 60:.0f} minutes of CPU"
        )
    return {"speedup": whole.seconds / pooled.seconds, "memory": whole.memory}


if __name__ == "__main__":
    main(*sys.argv[1:])
