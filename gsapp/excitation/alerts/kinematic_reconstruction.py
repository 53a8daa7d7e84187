"""A few seconds of motion told twice: by flow sensors, and by rates and accelerations.

Rates p, q, r turn the body's axes by C; what the accelerometers feel, summed along the axes of the
first sample, must then be what the flow sensors show of the velocity, but for a velocity at the
start and gravity, both unknown and constant (`gsapp.identification.compatibility.kinematics`):

    C v = n0 + integral of (C a) + g0 t

So a straight line is taken out of each axis, and what is left is gusts, or the lie of a sensor. No
attitude is needed, no aerodynamics, no model. In the other direction, rates that one gyro is not
believed for are found from all other sensors: hats over time, each a number to be solved for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.alerts.settings import ALERTS
from gsapp.identification.compatibility.kinematics import (
    cumulative_integral,
    integrate_rotation_matrices,
    reconstruct_path,
    rotate_to_body_axes,
    rotate_to_initial_axes,
    sensitivities_to_rates,
)
from gsapp.quantities import FloatArray

MOTION_COLUMNS: Final = ("p", "q", "r", "ax", "ay", "an", "V", "alpha", "beta")
"""What a stretch holds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorPositions:
    """Where the flow is measured, seen from the accelerometer, and how."""

    alpha_vane: tuple[float, float, float] = (0.0, 0.0, 0.0)
    beta_vane: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Body axes, m."""
    upwash: float = 1.0
    sidewash: float = 1.0
    swivel: bool = False
    """Whether the beta vane turns with alpha."""

    @classmethod
    def from_aircraft(cls, aircraft: Aircraft | None) -> SensorPositions:
        """Return those of an aircraft; without one all sit together."""
        if aircraft is None:
            return cls()
        sensors = aircraft.sensors
        center = sensors.accelerometer.position
        alpha, beta = sensors.alpha_vane, sensors.beta_vane

        def seen(position: tuple[float, float, float]) -> tuple[float, float, float]:
            x, y, z = (a - b for a, b in zip(position, center, strict=True))
            return x, y, z

        return cls(
            alpha_vane=seen(alpha.position),
            beta_vane=seen(beta.position),
            upwash=alpha.upwash,
            sidewash=beta.upwash,
            swivel=beta.kind == "swivel",
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReconstructedMotion:
    """What both tell of one stretch."""

    dt: float
    """s."""
    rates: FloatArray
    specific_force: FloatArray
    """Shape (n, 3). rad/s; specific force, m/s^2."""
    initial_velocity: FloatArray
    gravity: FloatArray
    """Shape (3,). Velocity, m/s, and gravity, m/s^2, along the axes of the first sample, as
    fitted."""
    residual: FloatArray
    """Shape (n, 3). u, v, w shown less what rates and accelerations make of them, m/s."""
    measured: dict[str, FloatArray]
    reconstructed: dict[str, FloatArray]
    """Shape (n,). V (m/s), alpha and beta (rad) as shown, and as rates and accelerations make them;
    each without its straight line."""

    def reconstruct_rate(self, axis: int) -> tuple[FloatArray, float]:
        """Return what all other sensors make of one rate.

        Parameters
        ----------
        axis : int
            0, 1, 2: p, q, r.

        Returns
        -------
        rate : ndarray, shape (n,)
            rad/s.
        left : float
            The square sum of misses with that rate, over that with the rate shown.
        """
        count = len(self.rates)
        hats = _hat_functions(count)
        path = reconstruct_path(
            self.rates, self.specific_force, self.dt, self.initial_velocity, self.gravity
        )
        slopes = sensitivities_to_rates(path, self.dt, np.full(ALERTS.basis_functions, axis), hats)
        back = path.C.transpose(0, 2, 1)
        matrix = np.zeros((3 * count + ALERTS.basis_functions, 6 + ALERTS.basis_functions))
        matrix[: 3 * count] = np.concatenate(
            (back, path.times[:, None, None] * back, slopes.velocity), axis=2
        ).reshape(3 * count, -1)
        matrix[3 * count :, 6:] = np.eye(ALERTS.basis_functions) * (
            ALERTS.residual_std / ALERTS.gyro_error_std
        )
        wanted = np.concatenate((self.residual.ravel(), np.zeros(ALERTS.basis_functions)))
        normal = matrix.T @ matrix
        solved = np.linalg.solve(
            normal + 1e-9 * np.trace(normal) * np.eye(len(normal)), matrix.T @ wanted
        )
        misses = self.residual.ravel() - matrix[: 3 * count] @ solved
        before = float(np.sum(self.residual**2))
        left = float(misses @ misses) / before if before > 0.0 else 1.0
        return self.rates[:, axis] + hats @ solved[6:], left


def reconstruct_motion(
    samples: FloatArray, dt: float, places: SensorPositions
) -> ReconstructedMotion:
    """Compare one stretch.

    Parameters
    ----------
    samples : ndarray, shape (n, len(COLUMNS))
        SI, without gaps.
    dt : float
        s.
    """
    rates = samples[:, :3]
    force = samples[:, 3:6] * (1.0, 1.0, -1.0)
    speed, alpha, beta = samples[:, 6:].T
    p, q, r = rates.T
    slope = np.tan(alpha) / places.upwash
    lean = np.sin(beta) / np.cos(beta) if not places.swivel else np.tan(beta) / np.cos(alpha)
    lean = lean / places.sidewash
    u = np.maximum(speed, 1.0) / np.sqrt(1.0 + slope * slope + lean * lean)
    # From where the vanes are to where the accelerometers are.
    side = places.beta_vane[0] * r - places.beta_vane[2] * p
    down = places.alpha_vane[1] * p - places.alpha_vane[0] * q
    velocity = np.column_stack((u, u * lean - side, u * slope - down))
    C = integrate_rotation_matrices(rates, dt)
    line = rotate_to_initial_axes(C, velocity) - cumulative_integral(
        rotate_to_initial_axes(C, force), dt
    )
    times: FloatArray = dt * np.arange(len(samples), dtype=np.float64)
    start, gravity, left = _fit_lines(line, times)
    miss = rotate_to_body_axes(C, left)
    made = velocity - miss
    shown = {"V": speed, "alpha": slope, "beta": lean}
    fast = np.sqrt(np.sum(made * made, axis=1))
    other = {"V": fast, "alpha": (made[:, 2] + down) / u, "beta": (made[:, 1] + side) / u}
    return ReconstructedMotion(
        dt=dt,
        rates=rates,
        specific_force=force,
        initial_velocity=start,
        gravity=gravity,
        residual=miss,
        measured={name: detrend(values) for name, values in shown.items()},
        reconstructed={name: detrend(values) for name, values in other.items()},
    )


def detrend(values: FloatArray) -> FloatArray:
    """Return values less the straight line through them, shape (n,)."""
    times: FloatArray = np.arange(len(values), dtype=np.float64)
    return _fit_lines(values[:, None], times)[2][:, 0]


def _fit_lines(values: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value at the start, slope, and what is left, of the line through each column."""
    centered = times - times.mean()
    slope = centered @ values / (centered @ centered)
    start = values.mean(axis=0) - slope * times.mean()
    return start, slope, values - start - times[:, None] * slope


def _hat_functions(count: int) -> FloatArray:
    place = np.linspace(0.0, ALERTS.basis_functions - 1.0, count)[:, None]
    return np.maximum(1.0 - np.abs(place - np.arange(ALERTS.basis_functions)), 0.0)
