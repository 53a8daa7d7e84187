"""Virtual maneuvers whose instruments have known errors."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from gsapp.identification.compatibility import PLAUSIBLE_ERRORS
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, FloatArray
from tests.identification.virtual_maneuvers import COLORED, NOISE, edited, fly


def with_errors(
    seed: int,
    kind: str,
    names: Sequence[str],
    *,
    size: float = 0.5,
    color: float = 0.0,
    attitude: bool = False,
    gyros: float = 1.0,
    duration: float = 10.0,
) -> tuple[Maneuver, dict[str, float]]:
    """Fly a maneuver and show it by instruments with random errors; return those, too.

    Parameters
    ----------
    names : sequence of str
        Errors, ``alpha.scale``.
    size : float
        Their standard deviation as a share of what is plausible; scales at most 0.15.
    gyros : float
        Noise of the rate gyros, deg/s.
    """
    random = np.random.default_rng(10_000 + seed)
    clean = fly(seed, kind, noise=0.0, attitude=attitude, duration=duration).maneuver
    truth: dict[str, float] = {}
    for name in names:
        spread = PLAUSIBLE_ERRORS[name] * size
        value = random.normal() * (min(spread, 0.15) if name.endswith("scale") else spread)
        truth[name] = abs(value) if name.endswith("delay") else value
    values = clean.block.values.copy()
    for column, channel in enumerate(clean.block.channels):
        if channel in NOISE:
            share = gyros if channel in ("p", "q", "r") else 1.0
            values[:, column] = _shown(
                values[:, column], channel, share * NOISE[channel], truth, clean.dt, random, color
            )
    block = Block(channels=clean.block.channels, times=clean.block.times, values=values)
    nominal = {name: value + name.endswith("scale") for name, value in truth.items()}
    return replace(clean, block=block), nominal


def _shown(
    true: FloatArray,
    channel: str,
    size: float,
    errors: Mapping[str, float],
    dt: float,
    random: np.random.Generator,
    color: float,
) -> FloatArray:
    places = np.arange(true.size, dtype=np.float64)
    late = np.interp(places - errors.get(f"{channel}.delay", 0.0) / dt, places, true)
    noise = random.standard_normal(true.size + 200)
    if color and channel in COLORED:
        noise = lfilter([(1.0 - color * color) ** 0.5], [1.0, -color], noise)
    scale = 1.0 + errors.get(f"{channel}.scale", 0.0)
    return scale * late + errors.get(f"{channel}.bias", 0.0) + size * noise[200:]


def with_signs(
    maneuver: Maneuver, turned: Sequence[str] = (), exchanged: tuple[str, str] | None = None
) -> Maneuver:
    changes = {name: -maneuver.block[name] for name in turned}
    if exchanged is not None:
        one, other = exchanged
        changes |= {one: maneuver.block[other], other: maneuver.block[one]}
    return edited(maneuver, **changes)


def with_channels(maneuver: Maneuver, **samples: FloatArray) -> Maneuver:
    block = maneuver.block
    table = {name: block[name] for name in block.channels}
    table.update({name.replace("__", "."): values for name, values in samples.items()})
    return replace(
        maneuver,
        block=Block(
            channels=tuple(table), times=block.times, values=np.column_stack([*table.values()])
        ),
    )
