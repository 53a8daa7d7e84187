"""Records of flights made of plain filters: quick to make, with inputs where one wants them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from gsapp.flight import Flight
from gsapp.flight.catalog import Catalog
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE, GRAVITY

STEPS = {
    "doublet": (1, -1),
    "3-2-1-1": (1, 1, 1, -1, -1, 1, -1),
    "pulse": (1,),
    "sweep": (1, 1, -1, -1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1),
}
NOISE = {
    **dict.fromkeys(("de", "da", "dr"), 0.05 * DEGREE),
    **dict.fromkeys(("p", "q", "r"), 0.6 * DEGREE),
    **dict.fromkeys(("alpha", "beta"), 0.1 * DEGREE),
    **dict.fromkeys(("ax", "ay", "an"), 0.01 * GRAVITY),
    "V": 0.2,
    "altitude": 1.0,
}


@dataclass(frozen=True, kw_only=True)
class Input:
    at: float
    surface: str
    kind: str = "doublet"
    size: float = 5.0
    step: float = 0.45

    @property
    def end(self) -> float:
        return self.at + self.step * len(STEPS[self.kind])


def lagged(samples: np.ndarray, tau: float, dt: float) -> np.ndarray:
    share = 1.0 - np.exp(-dt / tau)
    return lfilter([share], [1.0, share - 1.0], samples)


def resonant(samples: np.ndarray, omega: float, zeta: float, dt: float) -> np.ndarray:
    a = np.exp(-zeta * omega * dt)
    pole = 2.0 * a * np.cos(omega * np.sqrt(1.0 - zeta**2) * dt)
    return lfilter([1.0 - pole + a * a], [1.0, -pole, a * a], samples)


def make_flight(
    inputs: Sequence[Input] = (),
    *,
    seconds: float = 120.0,
    ground: float = 30.0,
    landing: float | None = None,
    range_check: Sequence[tuple[float, str]] = (),
    steering: float = 1.0,
    gusts: float = 0.0,
    seed: int = 0,
    rate: float = 100.0,
    without: Sequence[str] = (),
) -> Flight:
    """Make a record: engines on the ground, take-off, flight with steering and inputs, landing.

    Steering pauses from a second before an input to three seconds after it, as hands do. On the
    ground nothing answers.
    """
    random = np.random.default_rng(seed)
    dt = 1.0 / rate
    times = np.arange(round(seconds * rate)) * dt
    count = times.size
    stop = seconds + 99.0 if landing is None else landing
    flying = (times >= ground + 8.0) & (times < stop) if ground > 0.0 else times < stop
    hands_on = flying.copy()
    for one in inputs:
        hands_on &= ~((times > one.at - 1.2) & (times < one.end + 3.0))
    steer = lagged(hands_on.astype(float), 0.15, dt)
    signals = {}
    for surface, size in (("de", 1.5), ("da", 2.5), ("dr", 1.0)):
        slow = lagged(lagged(random.standard_normal(count), 0.6, dt), 0.6, dt)
        slow *= steering * size * DEGREE / max(slow.std(), 1e-12)
        wanted = slow * steer
        for one in inputs:
            if one.surface == surface:
                for index, unit in enumerate(STEPS[one.kind]):
                    on = (times >= one.at + index * one.step) & (
                        times < one.at + (index + 1) * one.step
                    )
                    wanted = wanted + unit * one.size * DEGREE * on
        for at, checked in range_check:
            if checked == surface:
                wanted = wanted + 17.0 * DEGREE * ((times >= at) & (times < at + 1.2))
        signals[surface] = lagged(lagged(wanted, 0.05, dt), 0.04, dt)
    air = flying.astype(float)
    gust = {name: gusts * lagged(random.standard_normal(count), 0.4, dt) * 9.0 for name in "pqrab"}
    q = resonant(-4.5 * signals["de"] * air, 5.0, 0.5, dt) + gust["q"] * DEGREE * air
    p = lagged(7.0 * signals["da"] * air, 0.1, dt) + gust["p"] * DEGREE * air
    r = resonant(-2.0 * signals["dr"] * air, 5.0, 0.2, dt) + gust["r"] * DEGREE * air
    alpha = 3.0 * DEGREE * air + 0.25 * lagged(q, 0.3, dt) + 0.1 * gust["a"] * DEGREE * air
    beta = -0.25 * lagged(r, 0.3, dt) + 0.1 * gust["b"] * DEGREE * air
    speed = (
        np.interp(times, (ground, ground + 9.0), (0.0, 30.0)) if ground else np.full(count, 30.0)
    )
    height = np.interp(times, (ground + 8.0, ground + 25.0), (0.0, 80.0)) if ground else 80.0
    if landing is not None:
        speed = np.where(times < landing, speed, np.maximum(28.0 - 5.0 * (times - landing), 0.0))
        height = height * np.interp(times, (landing - 15.0, landing), (1.0, 0.0))
    signals |= {
        "p": p, "q": q, "r": r, "alpha": alpha, "beta": beta,
        "ax": 0.3 * np.ones(count), "ay": 4.0 * beta, "an": GRAVITY * (1.0 + 8.0 * (alpha - 0.05)),
        "V": speed, "altitude": 380.0 + height,
    }  # fmt: skip
    signals["an"] = np.where(flying, signals["an"], GRAVITY)
    columns = {}
    for name, clean in signals.items():
        if name not in without:
            columns[name] = clean + NOISE[name] * random.standard_normal(count)
    if "throttle" not in without:
        columns["throttle"] = 0.5 * np.ones(count) + 0.001 * random.standard_normal(count)
    return flight_of(columns, times)


def flight_of(columns: dict[str, np.ndarray], times: np.ndarray, name: str = "made") -> Flight:
    block = Block(
        channels=tuple(columns), times=times, values=np.column_stack(list(columns.values()))
    )
    return Flight(name=name, path=Path(name), block=block, sources={})


def changed(flight: Flight, **columns: np.ndarray | float) -> Flight:
    block = flight.block
    held = {name: np.array(block[name]) for name in block.channels}
    for name, values in columns.items():
        held[name] = np.broadcast_to(np.asarray(values, dtype=float), block.times.shape)
    return flight_of(held, block.times, flight.name)


COMBINED = (Input(at=60.0, surface="da"), Input(at=60.3, surface="dr", size=-9.0))
EVERYTHING = (
    Input(at=60.0, surface="de"),
    Input(at=72.0, surface="da", size=-6.0),
    Input(at=84.0, surface="dr", size=10.0),
    Input(at=96.0, surface="da", size=6.0),
    Input(at=96.4, surface="dr", size=-10.0),
    Input(at=108.0, surface="de", kind="3-2-1-1", size=3.5, step=0.3),
)


def all_rows(catalog: Catalog) -> dict[str, list[dict[str, object]]]:
    """Return all rows of a catalog by table."""
    names = catalog.query("SELECT name FROM sqlite_master WHERE type = 'table'")
    return {
        name: [dict(row) for row in catalog.query(f"SELECT * FROM {name} ORDER BY rowid")]  # noqa: S608
        for (name,) in names
    }
