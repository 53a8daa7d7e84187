"""Records made ready: curved attitudes, delays, deflections, air data.

An attitude that comes at half the rate of the grid stands on it with straight lines between its
samples. In a short period of 11 rad/s these chords cut off 0.2 percent of the motion: many times
what the smooth answer of an autopilot has of noise, and just what a wrong scale would do.

A table that repeats a slow value until the next one comes makes it half an interval late: 30 ms for
vanes read 17 times a second.

A filter before the converter, a lag, a transport delay: each instrument says in the aircraft file
how late it is. Half a sample between gyros and surfaces bends damping and control derivatives by
five percent.

An autopilot logs what it asks of its servos. Between that and the surface lie delay, lag and rate
limit of the servo and play in the linkage. Left out, a lag of 0.04 s halves the roll damping of a
light aircraft, whose roll mode is as quick as the servo, and the fit looks none the worse. The
aircraft file says where each control is measured and what lies beyond; here the record is sent
along that way.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from scipy.interpolate import Akima1DInterpolator, CubicSpline

from gsapp.aircraft import Aircraft, Control
from gsapp.dynamics.actuators import control_paths, simulate_control_path
from gsapp.flight.maneuvers.signals import SURFACE_PARTS, SURFACES
from gsapp.flight.uniform_grid import median_step
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.smoothing import interpolate_missing
from gsapp.quantities import Block, BoolArray, FloatArray

INTERPOLATED_CHANNELS: Final = ("phi", "theta")
"""Channels that are smooth between samples: integrals of what the gyros show."""
_AIR_DATA = ("V", "Vc", "qbar", "dynamic_pressure", "static_pressure", "altitude", "density")
MOTION_CHANNELS: Final = (
    "phi", "theta", "alpha", "beta", "p", "q", "r", "ax", "ay", "an", *_AIR_DATA,
)  # fmt: skip
"""Channels that do not jump: a value that stays and then does is held from sample to sample."""


def interpolate_held_samples(block: Block) -> Block:
    """Return a block whose slow channels are curved between their own samples.

    Attitudes that stand on the grid with straight lines between, and any motion that a table
    repeats from one sample of its instrument to the next.
    """
    values = block.values.copy()
    for column, name in enumerate(_base_ids(block)):
        if name in MOTION_CHANNELS:
            values[:, column] = interpolate_repeated(values[:, column])
        if name in INTERPOLATED_CHANNELS:
            values[:, column] = interpolate_cubic(values[:, column])
    return Block(channels=block.channels, times=block.times, values=values)


def interpolate_repeated(samples: FloatArray) -> FloatArray:
    """Return a signal with Akima's curve in place of repeated values, shape (n,).

    It passes through the first of each, and is itself where nothing shows that values are held. A
    motion that stands still and then jumps by many steps of its converter is held: a coarse one
    that does move steps once after each pause.
    """
    steps = np.diff(samples)
    moved = np.flatnonzero(np.abs(steps) > 0.0)
    after_pause = moved[(moved > 0) & (steps[moved - 1] == 0.0)]
    if after_pause.size < max(PREPARATION.min_held_share * moved.size, PREPARATION.min_knots):
        return samples
    sizes = np.abs(steps)
    if np.median(sizes[after_pause]) < PREPARATION.min_held_steps * sizes[moved].min():
        return samples
    fresh = np.isfinite(samples)
    fresh[1:] &= steps != 0.0
    own = np.flatnonzero(fresh)
    out = samples.copy()
    between = np.arange(own[0], own[-1] + 1)
    between = between[np.isfinite(samples[between])]
    out[between] = Akima1DInterpolator(own, samples[own])(between)
    return out


def interpolate_cubic(samples: FloatArray) -> FloatArray:
    """Return a signal with cubics in place of its chords, shape (n,); itself where it has none.

    Where a chord ends is seen by the signal itself: in between, and nowhere else, three samples
    always lie on a line.
    """
    ends = _knot_indices(samples)
    if ends is None:
        return samples
    out = samples.copy()
    known = np.isfinite(samples[ends])
    breaks = np.flatnonzero(np.diff(known.astype(int))) + 1
    for run in np.split(np.arange(ends.size), breaks):
        if known[run[0]] and run.size >= PREPARATION.min_knots:
            own = ends[run]
            inside = np.arange(own[0], own[-1] + 1)
            out[inside] = CubicSpline(own, samples[own])(inside)
            out[own] = samples[own]
    return out


def _knot_indices(samples: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.intp]] | None:
    """Return where the chords of a signal end; None where it is not made of chords."""
    bends = np.full(samples.size, np.nan)
    bends[1:-1] = np.abs(np.diff(samples, 2))
    judged = np.isfinite(bends)
    usual = float(np.sqrt(np.mean(bends[judged] ** 2))) if judged.any() else 0.0
    if usual == 0.0:
        return None
    straight = bends < PREPARATION.collinearity_tolerance * usual
    for length in range(2, PREPARATION.max_interval + 1):
        for first in range(length):
            end = np.zeros(samples.size, dtype=bool)
            end[first::length] = True
            between, at = judged & ~end, judged & end
            if not (between.any() and at.any()):
                continue
            if (
                straight[between].mean() > PREPARATION.min_linear_share
                and straight[at].mean() < PREPARATION.max_linear_knot_share
            ):
                return np.flatnonzero(end)
    return None


_SURFACES = (
    "de", "da", "dr", "elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder",
)  # fmt: skip


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
    known, are missing; with fewer than no steps the first ones, of which nothing earlier is known.
    """
    if steps < 0.0:
        return advance_samples(samples[::-1], -steps)[::-1]
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
    delays = {
        name: late[base]
        for name, base in zip(block.channels, _base_ids(block), strict=True)
        if base in late
    }
    return advance_channels(block, delays)


def advance_channels(block: Block, delays: Mapping[str, float]) -> Block:
    """Return a block with some channels earlier, by their delays (s); even spacing is assumed."""
    if len(block) < 2 or delays.keys().isdisjoint(block.channels):
        return block
    dt = median_step(block.times)
    values = block.values.copy()
    for column, name in enumerate(block.channels):
        if name in delays:
            values[:, column] = advance_samples(values[:, column], delays[name] / dt)
    return Block(channels=block.channels, times=block.times, values=values)


def correct_vane_zeros(block: Block, aircraft: Aircraft) -> Block:
    """Return a block whose vanes show zero in straight flow, as far as the aircraft file knows."""
    sensors = aircraft.sensors
    biases = {"alpha": sensors.alpha_vane.bias, "beta": sensors.beta_vane.bias}
    return subtract_biases(block, {name: bias for name, bias in biases.items() if bias})


def subtract_biases(block: Block, biases: Mapping[str, float]) -> Block:
    """Return a block with biases (SI) taken off some channels."""
    if biases.keys().isdisjoint(block.channels):
        return block
    values = block.values.copy()
    for column, name in enumerate(block.channels):
        values[:, column] -= biases.get(name, 0.0)
    return Block(channels=block.channels, times=block.times, values=values)


def _base_ids(block: Block) -> list[str]:
    return [name.partition(".")[0] for name in block.channels]


COMMAND_CHANNELS: Mapping[str, str] = {name: f"{name}_command" for name in SURFACES}
"""The channel of what was asked of each surface's servo."""


def aircraft_as_recorded(block: Block, aircraft: Aircraft) -> Aircraft:
    """Return an aircraft whose controls are commands where a record has nothing else of them.

    Of a control whose kind the aircraft file states nothing is assumed.
    """

    def holds(name: str) -> bool:
        return name in block and bool(np.isfinite(block[name]).any())

    commanded = {
        name: control.model_copy(update={"kind": "command"})
        for name, command in COMMAND_CHANNELS.items()
        if "kind" not in (control := getattr(aircraft.controls, name)).model_fields_set
        and holds(command)
        and not any(map(holds, (name, *SURFACE_PARTS[name])))
    }
    if not commanded:
        return aircraft
    controls = aircraft.controls.model_copy(update=commanded)
    return aircraft.model_copy(update={"controls": controls})


def reconstruct_deflections(block: Block, aircraft: Aircraft) -> Block:
    """Return a block with de, da and dr as the surfaces stood; even spacing is assumed.

    A control that is measured on the surface stays as it is. One of ``kind = "servo"`` passes the
    linkage, one of ``kind = "command"`` its travel, the servo and the linkage; where such a flight
    has no ``de``, its ``de_command`` is taken.

    `block`: from some time before the surfaces move: the way is taken as at rest in the beginning.
    """
    if len(block) < 2:
        return block
    dt = median_step(block.times)
    found = {}
    for name in SURFACES:
        control: Control = getattr(aircraft.controls, name)
        record = _command_record(block, name, control)
        if record is not None:
            found[name] = _actuator_response(record, aircraft, name, control, dt)
    if not found:
        return block
    kept = [name for name in block.channels if name not in found]
    rest = block.select(kept)
    return Block(
        channels=(*rest.channels, *found),
        times=block.times,
        values=np.column_stack((rest.values, *found.values())),
    )


def unmodeled_servos(block: Block, aircraft: Aircraft) -> tuple[str, ...]:
    """Return the surfaces that moved, recorded as commands to a servo of which nothing is said."""
    return tuple(
        name
        for name in SURFACES
        if (control := getattr(aircraft.controls, name)).kind == "command"
        and not control_paths(aircraft, name)[0]
        and (record := _command_record(block, name, control)) is not None
        and np.nanmax(record) > np.nanmin(record)
    )


def _command_record(block: Block, name: str, control: Control) -> FloatArray | None:
    """Return the record of a control that is not measured on its surface; None without one."""
    if control.kind == "position":
        return None
    sources = (name, COMMAND_CHANNELS[name]) if control.kind == "command" else (name,)
    for source in sources:
        if source in block and np.isfinite(block[source]).any():
            return block[source]
    return None


def _actuator_response(
    record: FloatArray, aircraft: Aircraft, name: str, control: Control, dt: float
) -> FloatArray:
    """Return where the surface stood, missing where it hangs on missing samples."""
    servo, linkage = control_paths(aircraft, name)
    path = linkage if control.kind == "servo" else (*servo, *linkage)
    lost = ~np.isfinite(record)
    whole = interpolate_missing(record, lost)
    if control.kind == "command" and "travel" in control.model_fields_set:
        whole = np.clip(whole, *control.travel)
    found = simulate_control_path(path, whole, dt)
    reach = found.tangent(lost.astype(np.float64)[:, None])[:, 0]
    return np.where(lost | (np.abs(reach) > PREPARATION.max_missing_share), np.nan, found.values)


def interpolate_air_data(block: Block) -> Block:
    """Return a block with short gaps of its air data bridged by straight lines.

    A radio that sends in bursts, or a slow pitot channel on a quick grid, leaves them.
    """
    columns = [
        column
        for column, name in enumerate(_base_ids(block))
        if name in (*_AIR_DATA, "temperature") and not np.isfinite(block.values[:, column]).all()
    ]
    if not columns or len(block) < 2:
        return block
    values = block.values.copy()
    longest = PREPARATION.max_air_data_gap / median_step(block.times)
    for column in columns:
        known = np.flatnonzero(np.isfinite(values[:, column]))
        if not known.size:
            continue
        rows = np.arange(len(block))
        after = np.searchsorted(known, rows)
        inside = (after > 0) & (after < known.size)
        gap = np.zeros(len(block))
        gap[inside] = known[after[inside]] - known[after[inside] - 1]
        bridged = np.interp(rows, known, values[known, column])
        near = inside & (gap <= longest)
        # Beside the first and the last sample the nearest one.
        near |= ~inside & (np.abs(rows - np.clip(rows, known[0], known[-1])) <= longest)
        values[near, column] = bridged[near]
    return Block(channels=block.channels, times=block.times, values=values)
