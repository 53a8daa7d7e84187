"""What the cues of a live flight cost, and how long after the telemetry they come.

Cost: a virtual flight is fed to `gsapp.excitation.cueing.Cueing` in blocks of two hundredths of a
second, as a live session does, with cards, aircraft and model known. Processor time over time of
flight is the share of one core; it is told by part. *Looking ahead* (bounds, and what each card
would bring) is done in slices between the blocks, a few times in a flight: its share, and the
longest time that one block held up its caller.

Latency: a sender in a process of its own speaks the full-rate link over UDP, in real time, while
the virtual aircraft flies an input. A recorder in its own process stamps and writes it, a session
follows the folder as a window does. For every tick of 0.05 s that was judged: from the recorder's
stamp on the datagram with the newest sample of the tick, as it read it from the socket, until the
session's snapshot holds the tick; and the same for each event of the log. The first second is left
out: rows wait there until it is known which channels speak.
"""

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from tests.bench.sender_process import send_in_real_time, sending

RATE = 100
BLOCK = 2
"""Samples in a block of a live session that looks 50 times a second."""
LOOK = 0.004
"""Seconds between two looks of a window at its record."""
_SEED = 5003


# --- cost ---------------------------------------------------------------------------------------


class Meter:
    """Adds up the processor time of some methods."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def watch(self, inner: Any, title: str) -> None:
        def counted(*arguments: Any, **named: Any) -> Any:
            begin = time.process_time()
            try:
                return inner(*arguments, **named)
            finally:
                spent = self.seconds.get(title, 0.0)
                self.seconds[title] = spent + time.process_time() - begin

        setattr(inner.__self__, inner.__name__, counted)


def cost(plan: str, seed: int) -> None:
    """Print the shares of a core that a whole flight takes."""
    from gsapp.aircraft import load_aircraft
    from gsapp.dynamics.model import load_model
    from gsapp.excitation.cueing import CueGenerator
    from gsapp.flight.cards import load_cards
    from gsapp.quantities import Block
    from gsapp.virtual.virtual_flight import simulate_flight

    block = simulate_flight(plan, seed=seed).measured
    seconds = float(block.times[-1] - block.times[0])
    cues = CueGenerator(load_aircraft("b777"), load_model("b777"), RATE, cards=load_cards("b777"))
    meter = Meter()
    meter.watch(cues._stream._put, "rows joined")
    meter.watch(cues._stream._take, "rows joined")
    meter.watch(cues._trim.process_rows, "trim")
    meter.watch(cues._doublets.process_rows, "inputs and verdicts")
    meter.watch(cues._dangers.process_rows, "dangers")
    meter.watch(cues._card_selector.process_rows, "cards")
    meter.watch(cues._card_selector.update_selection, "cards")
    meter.watch(cues._lessons.process_rows, "estimates, fuel, time")
    meter.watch(cues._lessons.run_slice, "looking ahead, in slices")
    meter.watch(cues._lessons.update_outlook, "looking ahead, at its end")
    longest = 0.0
    begin = time.process_time()
    for start in range(0, len(block), BLOCK):
        rows = slice(start, start + BLOCK)
        piece = Block.unchecked(block.channels, block.times[rows], block.values[rows])
        before = time.process_time()
        cues.feed(piece)
        cues.process_step()
        longest = max(longest, time.process_time() - before)
    spent = time.process_time() - begin
    print(f"\n{plan} flight of {seconds:.0f} s, {len(cues.verdicts)} inputs, {BLOCK}-row blocks")
    print(f"    {'share of one core':34}{'%':>7}")
    for title, part in sorted(meter.seconds.items(), key=lambda one: -one[1]):
        print(f"    {title:34}{100.0 * part / seconds:7.2f}")
    ahead = sum(part for title, part in meter.seconds.items() if title.startswith("looking"))
    print(f"    {'all but looking ahead':34}{100.0 * (spent - ahead) / seconds:7.2f}")
    print(f"    {'all':34}{100.0 * spent / seconds:7.2f}")
    blocks = seconds * RATE / BLOCK
    print(
        f"    a block takes {1e6 * (spent - ahead) / blocks:.0f} us, the longest "
        f"{1e3 * longest:.0f} ms; looking ahead takes "
        f"{ahead / max(len(cues.verdicts), 1):.2f} s for each input",
        flush=True,
    )


# --- latency ------------------------------------------------------------------------------------


def send(port: int) -> None:
    from tests.excitation.cue_kit import flown, frames_of

    frames = frames_of(flown(_SEED))
    send_in_real_time(port, ((index / RATE, data) for index, data in enumerate(frames)))


def arrivals(folder: Path) -> dict[int, float]:
    from gsapp.decoding.dialect import dialect
    from gsapp.flight.raw_files import RawTail

    reader = dialect().MAVLink(None)
    found = {}
    for record in RawTail(folder).poll():
        if record.kind == "frame" and record.data[7:10] == b"\x5e\x01\x00":  # 350
            stamp = reader.decode(bytearray(record.data)).time_usec
            found[round(stamp * RATE / 1e6)] = record.stamp_us / 1e6
    return found


def latency() -> None:
    """Print how old the newest sample of a tick, and of an event, was when it was told."""
    from gsapp.flight.folder import FlightFolder
    from gsapp.session import Session
    from gsapp.telemetry.recorder_control import start_recorder
    from gsapp.virtual.downlink.aircraft_process import find_free_udp_port
    from tests.excitation.cue_kit import CARDS

    ticks: dict[int, float] = {}
    events: list[tuple[str, int, float]] = []
    with tempfile.TemporaryDirectory() as place:
        os.environ["GSAPP_RUNTIME_FOLDER"] = str(Path(place) / "runtime")
        folder = Path(place) / "flight"
        FlightFolder.create(folder).store_cards(CARDS)
        port = find_free_udp_port()
        recorder = start_recorder(f"udpin:127.0.0.1:{port}", folder)
        session = Session.follow(folder, channel_map="b777", aircraft="b777")
        try:
            with sending(__file__, port) as sender:
                known, quiet = 0, time.monotonic() + 60.0
                while sender.poll() is None and time.monotonic() < quiet:
                    session.update()
                    now, cues = time.time(), session.cues
                    if cues is not None and cues.time is not None:
                        ticks.setdefault(round(cues.time * RATE), now)
                        log = session.cue_monitor.cueing.log
                        events += [
                            (f"{one.kind} {one.state}", round(one.time * RATE), now)
                            for one in log[known:]
                        ]
                        known = len(log)
                    time.sleep(LOOK)
        finally:
            recorder.stop()
            session.close()
        arrived = arrivals(folder)
    known_from = min(ticks, default=0) + RATE
    ticks = {k: at for k, at in ticks.items() if k > known_from}
    events = [one for one in events if one[1] > known_from]
    print("\nlatency from telemetry to cue, ms; goal 100 ms")
    print(f"    {'':34}{'50th':>7}{'95th':>7}{'99th':>7}{'worst':>7}")
    tell("every tick judged", [1e3 * (at - arrived[k]) for k, at in ticks.items() if k in arrived])
    tell("events", [1e3 * (at - arrived[k]) for _, k, at in events if k in arrived])
    for title, k, at in events:
        if k in arrived and not title.startswith("trim"):
            print(f"    {title:34}{1e3 * (at - arrived[k]):7.1f}")
    if hasattr(os, "getloadavg"):
        print(f"    {os.getloadavg()[0]:.1f} processes want {os.cpu_count()} cores", flush=True)


def tell(title: str, ages: list[float]) -> None:
    if not ages:
        print(f"    {title:34} nothing came")
        return
    middle, high, higher = np.percentile(ages, (50, 95, 99))
    print(f"    {title:34}{middle:7.1f}{high:7.1f}{higher:7.1f}{max(ages):7.1f}   {len(ages)}")


def main(*options: str) -> None:
    cost("short" if "--quick" in options else "default", seed=0)
    for _ in range(1 if "--quick" in options else 3):
        latency()


if __name__ == "__main__":
    if sys.argv[1:2] == ["send"]:
        send(int(sys.argv[2]))
    else:
        main(*sys.argv[1:])
