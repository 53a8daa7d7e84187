"""Faults at random moments of a virtual flight: bytes lost, alarms missing or false, recovery.

``bench faults [RUNS] [FIRST_SEED] [FAULT,..]``, by default 200 from seed 0 over all faults. Each
run takes a part of the flight, sends it at its real rate over a real UDP port or pseudo-terminal to
a real recorder process, and follows the folder with a session, or with the real window off screen.
After a while the fault comes. The sender keeps what it delivered; the record must hold it byte for
byte. Counted for every run:

lost
    Bytes that had arrived and are not in the record. What the system could not deliver, because
    no recorder was there or a port was pulled out, is counted apart (missed).
announced
    Seconds from the fault to its alarm, where one is due.
recovered
    Seconds from the end of the cause to new samples on display, all of it read.
false
    Alarms of link, recorder or disk that do not belong to the fault, that come before it, or that
    do not end.

The result is written as JSON to ``faults.json`` in the folder of temporary files. A run can be
repeated by its seed: ``bench faults 1 SEED FAULT``. Needs Linux; as root it also fills a disk,
pulls one out and makes folders read-only.
"""

import contextlib
import ctypes
import json
import multiprocessing
import os
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from dataclasses import asdict
from pathlib import Path

import numpy as np

from gsapp.flight.raw_files import read_tlog
from tests.bench import estimates_live
from tests.bench.fault_kinds import FAULTS, FOR_ROOT
from tests.bench.fault_runs import FLIGHT, Outcome, Run


def conduct(fault: str, seed: int, flight: list[tuple[float, bytes]]) -> Outcome:
    outcome = Outcome(fault, seed)
    with tempfile.TemporaryDirectory(prefix="faults-") as scratch:
        run = Run(outcome, flight, Path(scratch))
        try:
            FAULTS[fault](run)
            if not outcome.sent:
                run.finish()
        except Exception:
            outcome.wrong.append(traceback.format_exc())
        finally:
            for window in run.windows:
                window.stop()
            if handle := run.handle:
                with contextlib.suppress(OSError):
                    os.kill(handle.pid, signal.SIGCONT)
                handle.stop()
            run.cleanup.close()
            for folder in Path(scratch).glob("field/*"):
                folder.chmod(0o755)  # one was read-only
    return outcome


def in_fork(fault: str, seed: int, flight: list[tuple[float, bytes]]) -> Outcome:
    """Conduct a run in a fork of this process: nothing of one is left for the next."""
    reading, writing = multiprocessing.Pipe(duplex=False)

    def work() -> None:
        writing.send(conduct(fault, seed, flight))
        os._exit(0)

    process = multiprocessing.get_context("fork").Process(target=work)
    process.start()
    writing.close()
    try:
        return reading.recv()
    except EOFError:
        return Outcome(fault, seed, wrong=["the run ended early"])
    finally:
        process.join()


def tell(outcomes: list[Outcome]) -> None:
    print(
        f"    {'fault':30}{'runs':>5}{'good':>5}{'MB':>6}{'lost':>8}{'missed':>8}{'silent':>8}"
        f"{'alarm s':>9}{'worst':>7}{'back s':>8}{'worst':>7}{'false':>6}{'wrong':>6}"
    )
    for fault in (*FAULTS, "all"):
        of = [one for one in outcomes if fault in (one.fault, "all")]
        if not of:
            continue
        alarm = [one.announced for one in of if one.announced is not None] or [np.nan]
        back = [one.recovered for one in of if one.recovered is not None] or [np.nan]
        print(
            f"    {fault:30}{len(of):5}{sum(one.good for one in of):5}"
            f"{sum(one.sent for one in of) / 1e6:6.1f}{sum(one.lost for one in of):8}"
            f"{sum(one.missed for one in of):8}"
            f"{sum(one.due and one.announced is None for one in of):8}"
            f"{np.median(alarm):9.2f}{max(alarm):7.2f}{np.median(back):8.2f}{max(back):7.2f}"
            f"{sum(bool(one.false) for one in of):6}{sum(bool(one.wrong) for one in of):6}"
        )


def main(*given: str) -> list[Outcome]:
    """Run the campaign."""
    numbers = [int(one) for one in given if one.isdigit()]
    named = [one for one in given if not one.isdigit() and not one.startswith("-")]
    runs, first = (*numbers, *(200, 0)[len(numbers) :])[:2]
    faults = named[0].split(",") if named else list(FAULTS)
    if os.geteuid() == 0:
        # A recorder of root must obey permissions, too.
        ctypes.CDLL(None).prctl(24, 1, 0, 0, 0)  # PR_CAPBSET_DROP, CAP_DAC_OVERRIDE
    else:
        faults = [one for one in faults if one not in FOR_ROOT]
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch) / "flight.tlog"
        estimates_live.fly(place, FLIGHT)
        records = list(read_tlog(place))
    begin = records[0].stamp_us
    flight = [(1e-6 * (one.stamp_us - begin), one.data) for one in records]
    outcomes, started = [], time.monotonic()
    result = Path(tempfile.gettempdir()) / "faults.json"
    for seed in range(first, first + runs):
        fault = faults[seed % len(faults)]
        outcomes.append(found := in_fork(fault, seed, flight))
        result.write_text(json.dumps([asdict(one) for one in outcomes], indent=1), encoding="utf-8")
        if not found.good:
            print(f"    seed {seed}, {fault}: {asdict(found)}", flush=True)
    tell(outcomes)
    others = Counter((text, one.fault) for one in outcomes for text in one.other)
    for (text, fault), count in others.most_common(20):
        print(f"    alarm of the flight itself, {count} runs of {fault}: {text}")
    print(
        f"    seeds {first} to {first + runs - 1}, {time.monotonic() - started:.0f} s, "
        f"{os.getloadavg()[0]:.1f} processes want {os.cpu_count()} cores; {result}"
    )
    return outcomes


if __name__ == "__main__":
    main(*sys.argv[1:])
