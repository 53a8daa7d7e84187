"""Channels brought to the time at which they were true.

A filter before the converter, a lag, a transport delay: each instrument says in the aircraft file
how late it is. Half a sample between gyros and surfaces bends damping and control derivatives by
five percent.
"""

from __future__ import annotations

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.quantities import Block, BoolArray, FloatArray

_SURFACES = (
    "de", "da", "dr", "elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder",
)  # fmt: skip
_AIR_DATA = ("V", "Vc", "qbar", "dynamic_pressure", "static_pressure", "altitude", "density")


def channel_delays(aircraft: Aircraft) -> dict[str, float]:
    """Return how late each channel is recorded, s; those that are not are left out."""
    sensors = aircraft.sensors
    groups = (
        (sensors.alpha_vane, ("alpha",)),
        (sensors.beta_vane, ("beta",)),
        (sensors.gyro, ("p", "q", "r")),
        (sensors.accelerometer, ("ax", "ay", "an")),
        (sensors.air_data, _AIR_DATA),
        (sensors.surfaces, _SURFACES),
    )
    return {
        name: one.total_delay for one, names in groups for name in names if one.total_delay > 0.0
    }


def advance_samples(samples: FloatArray, steps: float) -> FloatArray:
    """Return what a signal shows so many sample times later, shape (n,), or several, (n, k).

    Cubic between samples, linear beside missing ones. The last samples, of which nothing later is
    known, are missing.
    """
    whole, part = divmod(steps, 1.0)
    count = len(samples)
    unknown = np.full((int(whole) + 3, *samples.shape[1:]), np.nan)
    padded = np.concatenate((samples[:1], samples, unknown))
    first = int(whole)
    # One before, two about, and one after the time asked for.
    a, b, c, d = (padded[first + k : first + k + count] for k in range(4))
    if part == 0.0:
        return b
    f = part
    cubic = (
        -f * (f - 1.0) * (f - 2.0) / 6.0 * a
        + (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0 * b
        - (f + 1.0) * f * (f - 2.0) / 2.0 * c
        + (f + 1.0) * f * (f - 1.0) / 6.0 * d
    )
    return np.where(np.isfinite(cubic), cubic, (1.0 - f) * b + f * c)


def advance_flags(flags: BoolArray, steps: float) -> BoolArray:
    """Return the advanced samples that flagged ones contribute to, shape (n,)."""
    reach = np.where(flags, np.nan, 0.0)
    return np.asarray(np.isnan(advance_samples(reach, steps)), dtype=np.bool_)


def compensate_delays(block: Block, aircraft: Aircraft) -> Block:
    """Return a block with every channel at its right time; even spacing is assumed."""
    late = channel_delays(aircraft)
    if len(block) < 2 or late.keys().isdisjoint(_base_ids(block)):
        return block
    dt = float(np.median(np.diff(block.times)))
    values = block.values.copy()
    for column, name in enumerate(_base_ids(block)):
        if name in late:
            values[:, column] = advance_samples(values[:, column], late[name] / dt)
    return Block(channels=block.channels, times=block.times, values=values)


def _base_ids(block: Block) -> list[str]:
    return [name.partition(".")[0] for name in block.channels]
