"""What instruments show of a path, and how that changes with every error of theirs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.sensors import alpha_vane, beta_vane, pitot_airspeed
from gsapp.identification.compatibility.kinematics import (
    PathSensitivities,
    ReconstructedPath,
    cross_product_matrices,
    gravity_tangents,
    reconstruct_path,
    rotate_to_initial_axes,
    sensitivities_to_force,
    sensitivities_to_initial_state,
    sensitivities_to_rates,
)
from gsapp.identification.compatibility.segments import CompatibilitySegment
from gsapp.identification.compatibility.settings import ACCELERATION_CHANNELS, RATE_CHANNELS
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY

INITIAL_STATE_NAMES = ("u", "v", "w", "tilt.1", "tilt.2")
"""Free at the start of every stretch: velocity (m/s) and two small turns (rad)."""
_AXIS_SIGNS = np.array([1.0, 1.0, -1.0])
"""From ax, ay, an to x, y, z."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InitialState:
    """Where a stretch begins: velocity (m/s) and gravity (m/s^2), body axes, shape (3,)."""

    velocity: FloatArray
    gravity: FloatArray

    def perturbed(self, step: FloatArray) -> InitialState:
        """Return the start after a step in `INITIAL_STATE_NAMES`."""
        gravity = self.gravity + step[3:] @ gravity_tangents(self.gravity)
        return InitialState(
            velocity=self.velocity + step[:3],
            gravity=gravity * (GRAVITY / np.sqrt(gravity @ gravity)),
        )


def correct_rates_and_forces(
    stretch: CompatibilitySegment, errors: Mapping[str, float]
) -> tuple[FloatArray, FloatArray]:
    """Return rates (rad/s) and specific force (x, y, z; m/s^2) freed of errors, (n, 3) each."""

    def one(name: str) -> FloatArray:
        samples = delay_samples(
            stretch.inputs[name], -errors.get(f"{name}.delay", 0.0) / stretch.dt
        )
        return (samples - errors.get(f"{name}.bias", 0.0)) / errors.get(f"{name}.scale", 1.0)

    rates = np.column_stack([one(name) for name in RATE_CHANNELS])
    return rates, np.column_stack([one(name) for name in ACCELERATION_CHANNELS]) * _AXIS_SIGNS


def delay_samples(samples: FloatArray, steps: float) -> FloatArray:
    """Return a signal so many sample times late, shape (n,); its ends go on as constants."""
    if not steps:
        return samples
    places = np.arange(samples.size, dtype=np.float64)
    return np.interp(places - steps, places, samples)


def estimate_accelerometer_bias(stretch: CompatibilitySegment, start: InitialState) -> FloatArray:
    """Return errors of ax, ay, an (m/s^2) that a straight line and gravity leave, shape (3,)."""
    _, slope, _ = _fit_straight_flight(stretch, {})
    return np.asarray((start.gravity - slope) * _AXIS_SIGNS, dtype=np.float64)


def _fit_straight_flight(
    stretch: CompatibilitySegment, errors: Mapping[str, float]
) -> tuple[FloatArray, FloatArray, float]:
    """Return first velocity (m/s), slope of what rates and forces leave (m/s^2), mean alpha."""
    rates, force = correct_rates_and_forces(stretch, errors)
    count = len(rates)
    nothing = np.zeros(count)
    good = np.ones(count, dtype=bool)
    values = {}
    for name in ("V", "alpha", "beta"):
        samples = stretch.outputs.get(name)
        if samples is None:
            values[name] = nothing + (stretch.assumed_speed or 30.0 if name == "V" else 0.0)
            continue
        samples = (samples - errors.get(f"{name}.bias", 0.0)) / errors.get(f"{name}.scale", 1.0)
        good &= np.isfinite(samples)
        values[name] = samples
    if good.sum() < 3:
        good[:] = True
        values = {name: np.nan_to_num(samples) for name, samples in values.items()}
    V, alpha, beta = values["V"], values["alpha"], values["beta"]
    flow = np.column_stack(
        (V * np.cos(alpha) * np.cos(beta), V * np.sin(beta), V * np.sin(alpha) * np.cos(beta))
    )
    sensors = stretch.aircraft.sensors
    arm = np.subtract(sensors.accelerometer.position, sensors.alpha_vane.position)
    flow += np.cross(rates, arm)
    # Along the first axes: flown less what was pushed is a straight line, of slope gravity.
    path = reconstruct_path(rates, force, stretch.dt, np.zeros(3), np.zeros(3))
    line = rotate_to_initial_axes(path.C, flow)[good] - path.velocity_initial_axes[good]
    design = np.column_stack((np.ones(int(good.sum())), path.times[good]))
    (velocity, gravity), *_ = np.linalg.lstsq(design, line, rcond=None)
    return velocity, gravity, float(np.nanmean(alpha))


def estimate_initial_state(
    stretch: CompatibilitySegment, errors: Mapping[str, float]
) -> InitialState:
    """Return where a stretch seems to begin: the straight line through what the vanes show."""
    velocity, gravity, alpha = _fit_straight_flight(stretch, errors)
    if "beta" not in stretch.outputs or not {"p", "r", "ay"}.isdisjoint(stretch.absent):
        gravity[1] = 0.0
    if "phi" in stretch.outputs or "theta" in stretch.outputs:
        gravity = _measured_gravity(stretch, gravity)
    size = float(np.sqrt(gravity @ gravity))
    if not size > 0.3 * GRAVITY or gravity[2] < 0.1 * size:
        attack = alpha
        gravity = GRAVITY * np.array([-np.sin(attack), 0.0, np.cos(attack)])
    else:
        gravity = gravity * (GRAVITY / size)
    return InitialState(velocity=velocity, gravity=gravity)


def _measured_gravity(stretch: CompatibilitySegment, otherwise: FloatArray) -> FloatArray:
    """Return gravity at the first samples as the attitude channels show it."""
    x, y, z = otherwise
    phi, theta = np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z))
    for name in ("phi", "theta"):
        samples = stretch.outputs.get(name)
        if samples is not None:
            seen = samples[np.isfinite(samples)][:10]
            phi, theta = (seen.mean(), theta) if name == "phi" else (phi, seen.mean())
    return GRAVITY * np.array(
        [-np.sin(theta), np.sin(phi) * np.cos(theta), np.cos(phi) * np.cos(theta)]
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChannelGradients:
    """What a channel is and how it follows velocity and gravity."""

    value: FloatArray  # Shape (n,).
    arm: FloatArray  # Shape (3,). From the accelerometer to where the channel is measured, m.
    by_velocity: FloatArray | None  # Shape (n, 3). By the velocity there.
    by_gravity: FloatArray
    """Shape (n, 3). By gravity along the body's axes, where it does not follow velocity."""

    def chain(self, slopes: PathSensitivities) -> FloatArray:
        """Return the derivatives by the causes of some slopes, shape (n, m)."""
        if self.by_velocity is None:
            return _multiply_rows(self.by_gravity, slopes.gravity)
        there = slopes.velocity
        if self.arm.any() and slopes.rates.any():
            there = there + cross_product_matrices(self.arm).T @ slopes.rates
        return _multiply_rows(self.by_velocity, there)


def _multiply_rows(rows: FloatArray, matrices: FloatArray) -> FloatArray:
    """Return the products of rows (n, 3) and matrices (n, 3, m), shape (n, m)."""
    found: FloatArray = (rows[:, None, :] @ matrices)[:, 0]
    return found


def channel_gradients(
    path: ReconstructedPath, aircraft: Aircraft, channel: str, ahead: float = 0.0
) -> ChannelGradients:
    """Return a channel of a faultless instrument, with its derivatives.

    `aircraft` tells where its instruments sit; the one of this channel is `ahead` (m) of there.
    """
    sensors = aircraft.sensors
    if channel in ("phi", "theta"):
        gx, gy, gz = path.gravity.T
        down = np.zeros_like(path.gravity)
        phi, theta = path.attitude
        if channel == "phi":
            square = gy * gy + gz * gz
            down[:, 1], down[:, 2] = gz / square, -gy / square
            return ChannelGradients(value=phi, arm=np.zeros(3), by_velocity=None, by_gravity=down)
        down[:, 0] = -1.0 / np.sqrt(np.maximum(GRAVITY**2 - gx * gx, 1e-6))
        return ChannelGradients(value=theta, arm=np.zeros(3), by_velocity=None, by_gravity=down)
    instrument = {"V": sensors.air_data, "alpha": sensors.alpha_vane, "beta": sensors.beta_vane}
    arm = np.subtract(instrument[channel].position, sensors.accelerometer.position)
    arm[0] += ahead
    u, v, w = (path.velocity + np.cross(path.rates, arm)).T
    flow = (u, v, w)
    slope = np.zeros_like(path.velocity)
    if channel == "V":
        value = pitot_airspeed(flow)
        slope[:] = np.column_stack(flow) / value[:, None]
    elif channel == "alpha":
        upwash = sensors.alpha_vane.upwash
        value = alpha_vane(flow, upwash)
        square = u * u + w * w
        slope[:, 0], slope[:, 2] = -upwash * w / square, upwash * u / square
    else:
        vane = sensors.beta_vane
        value = beta_vane(flow, vane.kind, vane.upwash)
        if vane.kind == "fixed":
            square = u * u + v * v
            slope[:, 0], slope[:, 1] = -vane.upwash * v / square, vane.upwash * u / square
        else:
            square, level = u * u + v * v + w * w, np.sqrt(u * u + w * w)
            slope[:] = np.column_stack((-u * v, level * level, -w * v))
            slope *= (vane.upwash / (square * level))[:, None]
    return ChannelGradients(
        value=value, arm=arm, by_velocity=slope, by_gravity=np.zeros_like(slope)
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prediction:
    """What the instruments of a stretch should show."""

    path: ReconstructedPath
    channels: tuple[str, ...]
    computed: FloatArray  # Shape (n, n_channels).
    ideal: tuple[ChannelGradients, ...]  # Of faultless instruments, by channel.


def predict_channels(
    stretch: CompatibilitySegment, errors: Mapping[str, float], start: InitialState
) -> Prediction:
    """Return what the instruments of a stretch should show."""
    rates, force = correct_rates_and_forces(stretch, errors)
    path = reconstruct_path(rates, force, stretch.dt, start.velocity, start.gravity)
    channels = tuple(stretch.outputs)
    ideal = tuple(
        channel_gradients(path, stretch.aircraft, name, errors.get(f"{name}.position", 0.0))
        for name in channels
    )
    computed = np.column_stack(
        [
            errors.get(f"{name}.scale", 1.0)
            * delay_samples(one.value, errors.get(f"{name}.delay", 0.0) / stretch.dt)
            + errors.get(f"{name}.bias", 0.0)
            for name, one in zip(channels, ideal, strict=True)
        ]
    )
    return Prediction(path=path, channels=channels, computed=computed, ideal=ideal)


def channel_sensitivities(
    stretch: CompatibilitySegment,
    errors: Mapping[str, float],
    start: InitialState,
    found: Prediction,
    free: Sequence[str],
) -> FloatArray:
    """Return the derivatives of the computed channels.

    By the free errors, then by `INITIAL_STATE_NAMES`. Zero for errors of channels that are not
    there.
    """
    S = np.zeros((*found.computed.shape, len(free) + len(INITIAL_STATE_NAMES)))
    for group in (RATE_CHANNELS, ACCELERATION_CHANNELS):
        places = [
            place
            for place, name in enumerate(free)
            if (channel := name.partition(".")[0]) in group and channel not in stretch.absent
        ]
        if places:
            slopes = _input_error_sensitivities(
                stretch, errors, found.path, [free[place] for place in places]
            )
            for row, one in enumerate(found.ideal):
                S[:, row, places] = one.chain(slopes)
    first = sensitivities_to_initial_state(found.path, gravity_tangents(start.gravity))
    for row, (name, one) in enumerate(zip(found.channels, found.ideal, strict=True)):
        S[:, row, len(free) :] = one.chain(first)
        scale = errors.get(f"{name}.scale", 1.0)
        S[:, row] *= scale
        late = errors.get(f"{name}.delay", 0.0) / stretch.dt
        if (label := f"{name}.bias") in free:
            S[:, row, free.index(label)] = 1.0
        if (label := f"{name}.scale") in free:
            S[:, row, free.index(label)] = delay_samples(one.value, late)
        if (label := f"{name}.delay") in free:
            slope = np.gradient(one.value, stretch.dt)
            S[:, row, free.index(label)] = -scale * delay_samples(slope, late)
        if (label := f"{name}.position") in free and one.by_velocity is not None:
            by_position = np.cross(found.path.rates, [1.0, 0.0, 0.0])
            S[:, row, free.index(label)] = scale * (one.by_velocity * by_position).sum(axis=1)
    return S


def _input_error_sensitivities(
    stretch: CompatibilitySegment,
    errors: Mapping[str, float],
    path: ReconstructedPath,
    names: Sequence[str],
) -> PathSensitivities:
    """Return what errors of gyros, or of accelerometers, do to the motion."""
    of_rates = names[0].partition(".")[0] in RATE_CHANNELS
    group, truth = (
        (RATE_CHANNELS, path.rates)
        if of_rates
        else (ACCELERATION_CHANNELS, path.force * _AXIS_SIGNS)
    )
    axes = np.array([group.index(name.partition(".")[0]) for name in names])
    changes = np.empty((len(path.times), len(names)))
    for column, name in enumerate(names):
        channel, _, kind = name.partition(".")
        true = truth[:, axes[column]]
        scale = errors.get(f"{channel}.scale", 1.0)
        if kind == "bias":
            changes[:, column] = -1.0 / scale
        elif kind == "scale":
            changes[:, column] = -true / scale
        else:
            changes[:, column] = np.gradient(true, stretch.dt)
    if of_rates:
        return sensitivities_to_rates(path, stretch.dt, axes, changes)
    return sensitivities_to_force(path, stretch.dt, axes, changes * _AXIS_SIGNS[axes])
