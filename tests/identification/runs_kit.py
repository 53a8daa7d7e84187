"""Two short flights of the virtual aircraft, made in a moment, for tests of runs."""

from pathlib import Path

import numpy as np

from gsapp.flight.writers import write_block
from gsapp.quantities import Block
from tests.identification.virtual_maneuvers import fly

WINDOWS = ("1:0:6", "1:8:14", "2:0:6", "2:8:14")
"""Where the maneuvers are: an elevator one, and one of ailerons and rudder, in each flight."""


def write_flights(folder: Path) -> tuple[Path, Path]:
    first, second = (
        write_block(folder / f"{name}.csv", _flown(seed), "csv")
        for name, seed in (("a", 3), ("b", 13))
    )
    return first, second


def _flown(seed: int) -> Block:
    parts = [
        fly(seed + index, kind, duration=6.0, dt=0.02).maneuver.block
        for index, kind in enumerate(("lon", "lat"))
    ]
    return Block(
        channels=parts[0].channels,
        times=np.concatenate([parts[0].times, 8.0 + parts[1].times]),
        values=np.vstack([one.values for one in parts]),
    )
