"""Flights drawn with a pen: banks in, coordinated turns out, with the noise of instruments."""

import numpy as np

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.excitation.flight_rows import FlightRows, rows_from_block
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.excitation.trim.trim_monitor import TrimMonitor
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE, FOOT, GRAVITY

RATE = 100.0
SPEED = 30.0
ALPHA = 4.0 * DEGREE
NOISE = {
    "p": 1.0 * DEGREE, "q": 1.0 * DEGREE, "r": 1.0 * DEGREE, "ax": 0.05, "ay": 0.05, "an": 0.05,
    "alpha": 0.1 * DEGREE, "beta": 0.1 * DEGREE, "V": 0.05, "phi": 0.2 * DEGREE,
    "theta": 0.2 * DEGREE, "psi": 0.2 * DEGREE, "altitude": 0.5, "north": 0.2, "east": 0.2,
}  # fmt: skip
POINT = TestPoint(
    speed=SPEED, alpha=ALPHA, speed_tolerance=5.0 * FOOT, alpha_tolerance=1.5 * DEGREE
)


def aircraft() -> Aircraft:
    return load_aircraft("b777")


def drawn(
    bank: np.ndarray,
    *,
    speed: np.ndarray | float = SPEED,
    attitude: bool = True,
    position: bool = False,
    seed: int = 0,
) -> Block:
    """Return a level flight with these banks (rad, 100 Hz) at these speeds (m/s)."""
    count, dt = bank.size, 1.0 / RATE
    V = np.broadcast_to(np.asarray(speed, dtype=float), (count,))
    turn = GRAVITY * np.tan(bank) / np.maximum(V, 5.0)
    heading = np.cumsum(turn) * dt
    truth = {
        "p": np.gradient(bank, dt) - turn * np.sin(ALPHA),
        "q": turn * np.sin(bank) * np.cos(ALPHA),
        "r": turn * np.cos(bank) * np.cos(ALPHA),
        "ax": (GRAVITY + turn * np.sin(bank) * V) * np.sin(ALPHA),
        "ay": np.zeros(count),
        "an": GRAVITY * np.cos(ALPHA) / np.cos(bank),
        "alpha": np.full(count, ALPHA),
        "beta": np.zeros(count),
        "V": V,
        "altitude": np.full(count, 430.0),
    }
    if attitude:
        truth |= {"phi": bank, "theta": np.full(count, ALPHA), "psi": heading}
    if position:
        truth["north"] = np.cumsum(V * np.cos(heading)) * dt
        truth["east"] = np.cumsum(V * np.sin(heading)) * dt
    random = np.random.default_rng(seed)
    columns = [
        values + NOISE[name] * random.standard_normal(count) for name, values in truth.items()
    ]
    return Block(
        channels=tuple(truth), times=np.arange(count) * dt, values=np.column_stack(columns)
    )


def changed(block: Block, **channels: np.ndarray | float | None) -> Block:
    values = {name: block[name] for name in block.channels}
    for name, value in channels.items():
        if value is None:
            values.pop(name, None)
        else:
            values[name] = np.broadcast_to(np.asarray(value, dtype=float), block.times.shape)
    return Block(
        channels=tuple(values), times=block.times, values=np.column_stack(list(values.values()))
    )


def ramped(*pieces: tuple[float, float]) -> np.ndarray:
    bank, now = [], 0.0
    for seconds, degrees in pieces:
        for _ in range(round(seconds * RATE)):
            now += min(max(degrees - now, -45.0 / RATE), 45.0 / RATE)
            bank.append(now)
    return np.array(bank) * DEGREE


def cues(
    rows: FlightRows | Block,
    watch: TrimMonitor | None = None,
    point: TestPoint | None = POINT,
    since: float = 0.0,
) -> list[TrimCue]:
    watch = watch or TrimMonitor(aircraft(), RATE)
    watch.set_test_point(point)
    rows = rows_from_block(rows, RATE) if isinstance(rows, Block) else rows
    found = []
    begin = 5 * round(since * RATE / 5.0)
    watch.process_rows(rows.slice_rows(0, begin))
    for start in range(begin, len(rows) - 4, 5):
        watch.process_rows(rows.slice_rows(start, start + 5))
        assert watch.cue is not None
        found.append(watch.cue)
    return found


def at(found: list[TrimCue], time: float) -> TrimCue:
    return min(found, key=lambda cue: abs(cue.time - time))
