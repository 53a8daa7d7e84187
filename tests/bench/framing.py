"""Framing, decoding and mapping, in messages per second, against pymavlink in the same run.

The stream is that of a full-rate link: volts at 100 Hz and nine companion messages, 248 messages
per second of flight. Each round measures everything side by side, and what is told is the median
of the rounds. What happens once when a flight begins (reading the channel map and the
certificates) is told apart.
"""

import gc
import itertools
import math
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from pymavlink import mavutil

from gsapp.aircraft import load_aircraft
from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.dialect import dialect
from gsapp.decoding.framing import Framer, MavlinkFrame
from gsapp.decoding.health import LinkHealth
from gsapp.flight.raw_files import FRAMES_FILE, RawTail, RawWriter
from gsapp.flight.raw_files.record_files import RawRecord

START_US = 1_700_000_000_000_000
# Batches of a live link: of a window that has much to do, and of one that takes in every sample
# of 100 Hz as it comes (`ui.session_poller`).
LIVE_SECONDS = (0.04, 0.01)
ROUNDS = 5
FOREIGN = "pymavlink recv_msg on a log"
RATES = {
    "daq": 100, "attitude": 50, "servo": 50, "rc": 20, "rpm": 10, "pressure": 10, "hud": 5,
    "status": 1, "heartbeat": 1, "time": 1,
}  # fmt: skip


def messages_at(now: float, names: list[str]) -> list[object]:
    """Return the messages that are sent at a moment (seconds)."""
    module, wave = dialect(), math.sin(now)
    tick = round(100 * now)
    # As a real box does: not to the microsecond every 10 ms.
    ms, us = 10 * tick + tick * 31 % 3, 10_000 * tick + tick * 7919 % 300
    volts = [2.5 + 0.5 * math.sin(now + 0.3 * k) for k in range(20)] + [0.0] * 38
    volts[18] = 5.0 + 0.01 * wave  # the supply
    make: dict[str, Callable[[], object]] = {
        "daq": lambda: module.MAVLink_debug_float_array_message(us, b"daq", 0, volts),
        "attitude": lambda: module.MAVLink_attitude_message(ms, wave, -wave, wave, 0.1, 0.2, 0.3),
        "servo": lambda: module.MAVLink_servo_output_raw_message(us % 2**32, 0, *[1500] * 8),
        "rc": lambda: module.MAVLink_rc_channels_message(ms, 18, *[1500] * 18, 200),
        "rpm": lambda: module.MAVLink_raw_rpm_message(0, 7000.0 + wave),
        "pressure": lambda: module.MAVLink_scaled_pressure_message(ms, 980.0, 2.0 + wave, 1500),
        "hud": lambda: module.MAVLink_vfr_hud_message(30.0, 31.0, 90, 60, 300.0, 0.1),
        "status": lambda: module.MAVLink_sys_status_message(
            0, 0, 0, 500, 11800, 900, 80, 0, 0, 0, 0, 0, 0
        ),
        "heartbeat": lambda: module.MAVLink_heartbeat_message(1, 3, 81, 0, 4, 3),
        "time": lambda: module.MAVLink_system_time_message(START_US + us, ms),
    }
    return [make[name]() for name in names]


def full_stream(seconds: int) -> list[tuple[int, bytes]]:
    packer = dialect().MAVLink(None, srcSystem=1, srcComponent=1)
    stream = []
    for tick in range(seconds * 100):
        names = [name for name, rate in RATES.items() if tick % (100 // rate) == 0]
        for message in messages_at(tick / 100, names):
            stream.append((START_US + tick * 10_000, bytes(message.pack(packer))))
            packer.seq = (packer.seq + 1) % 256
    return stream


def per_second(count: int, work: Callable[[], int]) -> float:
    gc.collect()
    # Of this process's own time: what else the machine does is no part of it.
    start = time.process_time()
    done = work()
    elapsed = time.process_time() - start
    if done != count:
        raise RuntimeError(f"{done} of {count} messages came out")
    return count / elapsed


def chunks_of(data: bytes, size: int) -> list[bytes]:
    return [data[start : start + size] for start in range(0, len(data), size)]


def frame_only(chunks: list[bytes]) -> int:
    framer = Framer()
    return sum(len(framer.feed(chunk)) for chunk in chunks) + len(framer.flush())


def foreign_framing(data: bytes) -> int:
    return len(dialect().MAVLink(None).parse_buffer(data))


def foreign_log(path: Path) -> int:
    log = mavutil.mavlink_connection(str(path))
    count = 0
    while log.recv_msg() is not None:
        count += 1
    log.close()
    return count


def new_decoder() -> Decoder:
    return Decoder(load_channel_map("b777"), aircraft=load_aircraft("b777"))


def decode(decoder: Decoder, batches: list[list[RawRecord]]) -> int:
    for batch in batches:
        decoder.feed(batch)
    decoder.finish()
    return sum(map(len, batches))


def frame_and_decode(decoder: Decoder, chunks: list[tuple[int, bytes]]) -> int:
    framer, count = Framer(), 0
    for stamp, chunk in chunks:
        records = [RawRecord(stamp, "frame", item.data) for item in framer.feed(chunk)]
        decoder.feed(records)
        count += len(records)
    last = [RawRecord(stamp, "frame", item.data) for item in framer.flush()]
    decoder.feed(last)
    decoder.finish()
    return count + len(last)


def watch(batches: list[list[RawRecord]]) -> int:
    health = LinkHealth()
    for batch in batches:
        health.feed(batch)
    return health.good


def read_back(folder: Path) -> int:
    return sum(isinstance(record, RawRecord) for record in RawTail(folder).poll())


def stored(folder: Path, stream: list[tuple[int, bytes]]) -> None:
    writer, framer = RawWriter(folder), Framer()
    for stamp, group in itertools.groupby(stream, key=lambda entry: entry[0]):
        items = framer.feed(b"".join(frame for _, frame in group))
        writer.append(stamp, [item for item in items if isinstance(item, MavlinkFrame)])
    writer.append(stream[-1][0] + 1, framer.flush())
    writer.close()


def live_reads(stream: list[tuple[int, bytes]], seconds: float) -> list[tuple[int, bytes]]:
    step = round(seconds * 1e6)
    return [
        (stamp * step, b"".join(frame for _, frame in group))
        for stamp, group in itertools.groupby(stream, key=lambda entry: entry[0] // step)
    ]


def main(*options: str) -> dict[str, float]:
    """Measure and print; return messages per second and ratios to pymavlink."""
    seconds = 10 if "--quick" in options else 60
    stream = full_stream(seconds)
    count = len(stream)
    data = b"".join(frame for _, frame in stream)
    live = {every: live_reads(stream, every) for every in LIVE_SECONDS}
    step = round(LIVE_SECONDS[0] * 1e6)
    batches = [
        [RawRecord(stamp, "frame", frame) for stamp, frame in group]
        for _, group in itertools.groupby(stream, key=lambda entry: entry[0] // step)
    ]
    new_decoder()  # reads the dialect
    start = time.perf_counter()
    new_decoder()
    making = time.perf_counter() - start
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        stored(folder, stream)
        rounds = [one_round(count, data, live, batches, folder) for _ in range(ROUNDS)]
    mean = len(data) / count
    print(f"{count} messages of {mean:.0f} bytes on average, {seconds} s of flight at full rate;")
    print(f"median of {ROUNDS} rounds; once in a flight: {1e3 * making:.0f} ms to make a decoder")
    results: dict[str, float] = {}
    for name in rounds[0]:
        rate = statistics.median(each[name] for each in rounds)
        ratio = statistics.median(each[name] / each[FOREIGN] for each in rounds)
        results[name] = rate
        results[f"{name}, ratio"] = ratio
        print(f"{name:44} {rate:12,.0f} messages/s   {ratio:6.2f} x recv_msg")
    return results


def one_round(
    count: int,
    data: bytes,
    live: dict[float, list[tuple[int, bytes]]],
    batches: list[list[RawRecord]],
    folder: Path,
) -> dict[str, float]:
    """Measure everything once; return messages per second."""
    whole = [list(itertools.chain.from_iterable(batches))]
    large = [(START_US, chunk) for chunk in chunks_of(data, 65536)]
    often = live[LIVE_SECONDS[0]]

    def rate(work: Callable[[], int]) -> float:
        return per_second(count, work)

    def decoding(work: Callable[[Decoder], int]) -> float:
        decoder = new_decoder()
        return per_second(count, lambda: work(decoder))

    # Side by side, since the machine has other things to do: what is compared most comes first.
    results = {FOREIGN: rate(lambda: foreign_log(folder / FRAMES_FILE))}
    for every, reads in live.items():
        name = f"framing, decoding and mapping, every {1e3 * every:.0f} ms"
        results[name] = decoding(lambda new, reads=reads: frame_and_decode(new, reads))
    return results | {
        "framing, decoding and mapping, 64 KiB reads": decoding(
            lambda new: frame_and_decode(new, large)
        ),
        "decoding and mapping, every 40 ms": decoding(lambda new: decode(new, batches)),
        "decoding and mapping, whole": decoding(lambda new: decode(new, whole)),
        "framing, live reads": rate(lambda: frame_only([chunk for _, chunk in often])),
        "framing, 64 KiB reads": rate(lambda: frame_only([chunk for _, chunk in large])),
        "framing, 64-byte reads": rate(lambda: frame_only(chunks_of(data, 64))),
        "reading raw files": rate(lambda: read_back(folder)),
        "link health": rate(lambda: watch(batches)),
        "pymavlink parse_buffer": rate(lambda: foreign_framing(data)),
    }


if __name__ == "__main__":
    main(*sys.argv[1:])
