"""Flights for the tests of cues: one input on a straight leg, as samples or as a record."""

from collections.abc import Iterable
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

from calibration import load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.decoding.dialect import dialect
from gsapp.decoding.framing import Framer
from gsapp.dynamics.model import load_model
from gsapp.excitation.cueing import CueGenerator
from gsapp.flight.cards import CardSet, TestCard
from gsapp.flight.raw_files import RawWriter
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE, FOOT
from gsapp.virtual.instruments import DAQ_CHANNELS, AnalogDigitalConverter
from tests.virtual.inputs import fly_input

RATE = 100.0
_ROWS = 1500
"""Rows of a flight: the verdict is given before their end, and no test needs the recovery."""
START_US = 1_700_000_000_000_000
AIRCRAFT = load_aircraft("b777")
MODEL = load_model("b777")


def card(name: str = "E1", surface: str = "de", speed: float = 100.0) -> TestCard:
    return TestCard.model_validate(
        {
            "id": name, "speed": f"{speed} ft/s", "surfaces": [surface],
            "amplitude": "4.5 deg", "width": "0.5 s", "repeats": 2,
        }
    )  # fmt: skip


CARDS = CardSet(name="one", cards=(card(),))


@lru_cache(maxsize=8)
def flown(seed: int = 5003, size: float = 4.5, **draws: object) -> Block:
    usual: dict[str, object] = {
        "surfaces": ("de",), "kind": "doublet", "speed": 100.0 * FOOT, "width": 0.5,
        "amplitudes": _Once(de=size * DEGREE), "balance": 1.0, "bank": 0.0, "speed_off": 0.0,
        "roll_rate": 0.0, "pitch_rate": 0.0, "meddling": (), "hands_off": 6.0, "left_over": 0.0,
        "turbulence": 0.0, "noise": 1.0, "attitude": True, "position": True,
    }  # fmt: skip
    block = fly_input(seed, **{**usual, **draws}).measured
    return part(block, 0, _ROWS)


class _Once(dict[str, float]):
    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self.items()))


def cueing(**changes: object) -> CueGenerator:
    known: dict[str, object] = {"aircraft": AIRCRAFT, "model": MODEL, "cards": CARDS, **changes}
    aircraft, model = known.pop("aircraft"), known.pop("model")
    return CueGenerator(aircraft, model, RATE, **known)  # type: ignore[arg-type]


def feed(cues: CueGenerator, block: Block, cuts: Iterable[int] = ()) -> CueGenerator:
    edges = sorted({0, *cuts, len(block)})
    for start, stop in pairwise(edges):
        cues.feed(part(block, start, stop))
        cues.process_step()
    cues.finish()
    return cues


def part(block: Block, start: int, stop: int, channels: Iterable[str] | None = None) -> Block:
    names = tuple(block.channels if channels is None else channels)
    columns = [block.channels.index(name) for name in names]
    values = block.values[start:stop][:, columns]
    return Block(channels=names, times=block.times[start:stop], values=values)


def frames_of(block: Block) -> list[bytes]:
    """Return what the aircraft's box sends in each hundredth of a second."""
    module = dialect()
    packer = module.MAVLink(None, srcSystem=1, srcComponent=1)
    volts = AnalogDigitalConverter(load_certificates("b777")).volts(
        {name: block[name] for name in DAQ_CHANNELS}
    )
    ticks = []
    for k in range(len(block)):
        messages = [
            module.MAVLink_debug_float_array_message(
                1_000_000 + 10_000 * k, b"daq", 0, [*volts[k].tolist(), *[0.0] * 38]
            )
        ]
        if k % 2 == 0:
            motion = [float(block[name][k]) for name in ("phi", "theta", "psi", "p", "q", "r")]
            messages.append(module.MAVLink_attitude_message(1000 + 10 * k, *motion))
        if k % 100 == 0:
            messages.append(module.MAVLink_heartbeat_message(1, 0, 0, 0, 4, 3))
        packed = []
        for message in messages:
            packed.append(bytes(message.pack(packer)))
            packer.seq = (packer.seq + 1) % 256
        ticks.append(b"".join(packed))
    return ticks


class Record:
    """A flight folder to which a box's frames are written as a recorder would."""

    def __init__(self, folder: Path, block: Block) -> None:
        self._writer = RawWriter(folder)
        self._framer = Framer()
        self._ticks = frames_of(block)
        self._next = 0

    def write(self, count: int | None = None) -> bool:
        stop = len(self._ticks) if count is None else min(self._next + count, len(self._ticks))
        for k in range(self._next, stop):
            self._writer.append(START_US + 10_000 * k, self._framer.feed(self._ticks[k]))
        self._next = stop
        return stop < len(self._ticks)

    def close(self) -> None:
        self._writer.close()
