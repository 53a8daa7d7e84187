"""Frames as a vehicle would send them, and what a decoder makes of them."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from gsapp.decoding.decoder import Decoder
from gsapp.decoding.dialect import dialect
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.quantities import Block

HOST = 1_700_000_000_000_000


class Sender:
    """Packs messages of one component into records."""

    def __init__(self, system: int = 1, component: int = 1) -> None:
        self._mavlink = dialect().MAVLink(None, srcSystem=system, srcComponent=component)

    def __call__(self, host_us: int, name: str, *fields: object, v1: bool = False) -> RawRecord:
        kind = getattr(dialect(), f"MAVLink_{name.lower()}_message")
        data = bytes(kind(*fields).pack(self._mavlink, force_mavlink1=v1))
        self._mavlink.seq = (self._mavlink.seq + 1) % 256
        return RawRecord(HOST + host_us, "frame", data)

    def daq(self, host_us: int, stamp_us: int, volts: Sequence[float]) -> RawRecord:
        data = [*volts, *[0.0] * (58 - len(volts))]
        return self(host_us, "debug_float_array", stamp_us, b"daq", 0, data)

    def attitude(self, host_us: int, boot_ms: int, *angles: float) -> RawRecord:
        return self(host_us, "attitude", boot_ms, *angles, *[0.0] * (6 - len(angles)))


def gather(
    blocks: Iterable[Block], rate: float = 100.0
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for block in blocks:
        index = np.rint(block.times * rate).astype(np.int64)
        np.testing.assert_array_equal(block.times, index / rate)
        for name in block.channels:
            parts.setdefault(name, []).append((index, block[name]))
    result = {}
    for name, pieces in parts.items():
        index = np.concatenate([piece[0] for piece in pieces])
        assert np.all(np.diff(index) >= 1), f"rows of {name} overlap"
        result[name] = (index, np.concatenate([piece[1] for piece in pieces]))
    return result


def decode_in_chunks(
    make: Callable[[], Decoder], records: Sequence[RawRecord], sizes: Iterable[int]
) -> tuple[dict[str, tuple[np.ndarray, np.ndarray]], Decoder]:
    decoder = make()
    blocks: list[Block] = []
    sizes = list(sizes)
    start = turn = 0
    while start < len(records):
        size = sizes[turn % len(sizes)]
        blocks += decoder.feed(records[start : start + size])
        start, turn = start + size, turn + 1
    return gather(blocks + decoder.finish(), decoder.rate), decoder


def assert_same(
    one: dict[str, tuple[np.ndarray, np.ndarray]], two: dict[str, tuple[np.ndarray, np.ndarray]]
) -> None:
    assert one.keys() == two.keys()
    for name in one:
        np.testing.assert_array_equal(one[name][0], two[name][0], err_msg=name)
        assert one[name][1].tobytes() == two[name][1].tobytes(), name


def write_map(folder: Path, text: str) -> Path:
    path = folder / "map.toml"
    path.write_text(text, encoding="utf-8")
    return path
