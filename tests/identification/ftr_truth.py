"""Maneuvers with known derivatives for Fourier transform regression, and its errors over bounds."""

from collections import defaultdict
from functools import cache

import numpy as np
from scipy.signal import lfilter

from gsapp.identification.ftr import estimate
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, FloatArray
from tests.identification.virtual_maneuvers import COLORED, NOISE, Virtual, fly

# Settings were developed on seeds from 5000 on.
SEEDS = range(300, 308)  # flown by other tests, too
LEVELS = {"CN_0", "CA_0", "CY_0"}
"""Their bounds hold the uncertain zero of the accelerometer."""


@cache
def quiet(seed: int, kind: str) -> Virtual:
    return fly(seed, kind, noise=0.0)


def with_values(maneuver: Maneuver, values: FloatArray, **changes: object) -> Maneuver:
    block = Block(channels=maneuver.block.channels, times=maneuver.block.times, values=values)
    fields = {
        "id": maneuver.id,
        "flight": maneuver.flight,
        "aircraft": maneuver.aircraft,
        "inputs": maneuver.inputs,
        "mass": maneuver.mass,
        **changes,
    }
    return Maneuver(block=block, **fields)  # type: ignore[arg-type]


def noisy(maneuver: Maneuver, seed: int, color: float = 0.0) -> Maneuver:
    random = np.random.default_rng(seed)
    values = maneuver.block.values.copy()
    for column, name in enumerate(maneuver.block.channels):
        error = random.standard_normal(len(values) + 200)
        if color and name in COLORED:
            error = lfilter([np.sqrt(1.0 - color * color)], [1.0, -color], error)
        values[:, column] += NOISE.get(name, 0.0) * error[200:]
    return with_values(maneuver, values)


def errors_over_bounds(kind: str, color: float, repeats: int) -> dict[str, FloatArray]:
    ratios: dict[str, list[float]] = defaultdict(list)
    for seed in SEEDS:
        virtual = quiet(seed, kind)
        for repeat in range(repeats):
            found = estimate([noisy(virtual.maneuver, 1000 * seed + repeat, color)], kind)  # type: ignore[arg-type]
            for name, one in found.derivatives.items():
                if one.value is not None and one.std is not None:
                    ratios[name].append((one.value - virtual.truth[name]) / one.std)
    return {name: np.array(values) for name, values in ratios.items()}
