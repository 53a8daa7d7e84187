"""Sensors that lie: what one shows cannot be, given what all others show.

A vane that sticks, a pitot tube that is blocked and a gyro that is dead still have noise, so their
samples look alive. But they do not move when the motion that the others tell of must move them: in
gusts, where a free vane always moves, and in every turn and input. Gusts cannot feign that, nor can
they feign an airspeed that goes its own way by several times what they do to the vanes.

A few seconds of motion are told twice: by flow sensors, and by rates and accelerations. Rates p, q,
r turn the body's axes by C; what the accelerometers feel, summed along the axes of the first
sample, must then be what the flow sensors show of the velocity, but for a velocity at the start and
gravity, both unknown and constant (`gsapp.identification.compatibility.kinematics`):

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
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.excitation.alerts.row_frames import FlightFrame
from gsapp.excitation.settings import ALERTS
from gsapp.identification.compatibility.kinematics import (
    cumulative_integral,
    integrate_rotation_matrices,
    reconstruct_path,
    rotate_to_body_axes,
    rotate_to_initial_axes,
    sensitivities_to_rates,
)
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE

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
        """Return what all other sensors make of a rate (axis 0, 1, 2: p, q, r), rad/s, shape (n,).

        And the square sum of misses with that rate, over that with the rate shown.
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
    """Compare a stretch of samples, shape (n, len(MOTION_COLUMNS)), SI, without gaps."""
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
    centered = times - times.mean()
    slope = centered @ values / (centered @ centered)
    start = values.mean(axis=0) - slope * times.mean()
    return start, slope, values - start - times[:, None] * slope


def _hat_functions(count: int) -> FloatArray:
    place = np.linspace(0.0, ALERTS.basis_functions - 1.0, count)[:, None]
    return np.maximum(1.0 - np.abs(place - np.arange(ALERTS.basis_functions)), 0.0)


_MUST_MOVE: Final = {"V": 0.4, "alpha": 0.7 * DEGREE, "beta": 0.7 * DEGREE}
"""Standard deviation made by rates and accelerations, at which a sensor must have moved too."""
_FLAT: Final = {"V": 0.03, "alpha": 0.09 * DEGREE, "beta": 0.09 * DEGREE}
"""Standard deviation that is no motion, where no noise is stated: m/s and rad. A free vane moves
more even in calm air; so a gyro that misleads is not taken for a vane that sticks ..."""

_WORDS: Final = {
    "alpha": "does not move with the motion: stuck",
    "beta": "does not move with the motion: stuck",
    "V": "does not change with the motion: pitot blocked",
    "p": "does not follow the motion: dead",
    "q": "does not follow the motion: dead",
    "r": "does not follow the motion: dead",
}
_AGAINST: Final = "goes against the motion: pitot blocked or leaking"


class KinematicMonitor:
    """Compares the last seconds, again and again."""

    def __init__(self, aircraft: Aircraft | None, rate: float) -> None:
        self._places = SensorPositions.from_aircraft(aircraft)
        self._flat = _flatness(aircraft)
        length = max(1, round(ALERTS.frame_duration * rate))
        self._per_frame = max(k for k in range(1, ALERTS.frame_samples + 1) if length % k == 0)
        self._dt = length / rate / self._per_frame
        self.restart()

    def restart(self) -> None:
        self._samples = np.full(
            (ALERTS.compared_frames * self._per_frame, len(MOTION_COLUMNS)), np.nan
        )
        self._lies: dict[str, int] = {}
        self._truths: dict[str, int] = {}
        self._found: dict[str, str] = {}

    def evaluate(self, frame: FlightFrame, doubted: frozenset[str]) -> dict[str, str]:
        """Return the sensors that lie, and how; nothing is compared with those doubted."""
        if frame.rows.starts_segment:
            self._samples[:] = np.nan
        fresh = self._per_frame
        self._samples[:-fresh] = self._samples[fresh:]
        known = not doubted & set(MOTION_COLUMNS)
        self._samples[-fresh:] = self._means(frame) if known else np.nan
        long_enough = (
            frame.time_since_takeoff
            > ALERTS.compared_frames * ALERTS.frame_duration + ALERTS.min_airborne_time
        )
        due = frame.rows.first_index // len(frame.rows) % ALERTS.comparison_interval == 0
        if due and long_enough and not frame.near_ground and np.isfinite(self._samples).all():
            self._compare()
        return self._found

    def _means(self, frame: FlightFrame) -> FloatArray:
        rows = np.stack([frame.rows[name] for name in MOTION_COLUMNS], axis=1)
        parts: FloatArray = rows.reshape(self._per_frame, -1, len(MOTION_COLUMNS))
        return np.asarray(parts.mean(axis=1), dtype=np.float64)

    def _compare(self) -> None:
        """Note who lies now; who has lied does so until it is seen to tell the truth."""
        motion = reconstruct_motion(self._samples, self._dt, self._places)
        lies, truths = self._judged(motion)
        self._lies = {name: self._lies.get(name, 0) + 1 for name in lies}
        self._truths = {name: self._truths.get(name, 0) + 1 for name in truths - lies.keys()}
        for name, why in lies.items():
            if self._lies[name] >= ALERTS.confirm_comparisons:
                self._found.setdefault(name, why)
        self._found = {
            name: why
            for name, why in self._found.items()
            if self._truths.get(name, 0) < ALERTS.confirm_comparisons
        }

    def _judged(self, motion: ReconstructedMotion) -> tuple[dict[str, str], set[str]]:
        """Return who lies and how, and who has moved as it should."""
        turning = {
            name
            for axis, name in enumerate("pqr")
            if _rms(detrend(motion.rates[:, axis])) > 2.0 * ALERTS.max_dead_rate
        }
        dead = self._dead_gyro(motion)
        if dead:
            return {dead: _WORDS[dead]}, turning
        if self._found.keys() & set("pqr"):
            return {}, turning  # nothing can be compared with a rate that is wrong
        lies, truths = {}, turning
        for name, least in _MUST_MOVE.items():
            made, shown = _rms(motion.reconstructed[name]), _rms(motion.measured[name])
            if made > least and shown < min(ALERTS.stuck_share * made, self._flat[name]):
                lies[name] = _WORDS[name]
            elif made > least and shown > ALERTS.free_share * made:
                truths.add(name)
        alike = _correlation(motion.reconstructed["V"], motion.measured["V"])
        against = self._against(motion, alike)
        if against and not lies and self._gyros_live(motion):
            lies["V"] = _AGAINST
        if against or alike < ALERTS.min_valid_correlation:
            truths.discard("V")
        return lies, truths

    @staticmethod
    def _dead_gyro(motion: ReconstructedMotion) -> str:
        """Return the gyro that stands still while all else says that its axis turns."""
        best, least = "", ALERTS.max_unexplained_share
        for axis, name in enumerate("pqr"):
            shown = _rms(detrend(motion.rates[:, axis]))
            if shown > ALERTS.max_dead_rate:
                continue
            rate, left = motion.reconstruct_rate(axis)
            made = _rms(detrend(rate))
            if (
                made > ALERTS.min_predicted_rate
                and shown < ALERTS.stuck_rate_share * made
                and left < least
            ):
                best, least = name, left
        return best

    @staticmethod
    def _against(motion: ReconstructedMotion, alike: float) -> bool:
        """Return whether the airspeed goes another way than gusts could send it."""
        along, across, down = (float(miss) for miss in np.sqrt(np.mean(motion.residual**2, axis=0)))
        gusts = max(
            ALERTS.gust_ratios[0] * across, ALERTS.gust_ratios[1] * down, ALERTS.calm_airspeed_std
        )
        if along > max(ALERTS.wrong_gust_ratio * gusts, ALERTS.min_wrong_residual) and all(
            motion.reconstruct_rate(axis)[1] > ALERTS.max_unexplained_share for axis in range(3)
        ):
            return True
        moves = _rms(motion.reconstructed["V"]) > _MUST_MOVE["V"]
        return (
            alike < ALERTS.reversed_correlation
            and moves
            and along > ALERTS.reversed_gust_ratio * gusts
        )

    @staticmethod
    def _gyros_live(motion: ReconstructedMotion) -> bool:
        """Return whether all gyros move, to the end: one that is dead makes the same misses."""
        late = len(motion.rates) * 2 // 3
        return all(
            _rms(detrend(rate)) > ALERTS.min_live_rate
            and _rms(detrend(rate[late:])) > 0.5 * ALERTS.min_live_rate
            for rate in motion.rates.T
        )


def _flatness(aircraft: Aircraft | None) -> dict[str, float]:
    if aircraft is None:
        return dict(_FLAT)
    sensors = aircraft.sensors
    pressure = sensors.air_data.noise / (SEA_LEVEL_DENSITY * ALERTS.reference_speed)
    noises = {"alpha": sensors.alpha_vane.noise, "beta": sensors.beta_vane.noise, "V": pressure}
    mean = ALERTS.stuck_noise_ratio / np.sqrt(ALERTS.mean_rows)
    return {name: mean * noise if noise > 0.0 else _FLAT[name] for name, noise in noises.items()}


def _correlation(one: FloatArray, other: FloatArray) -> float:
    return float(np.mean(one * other)) / max(_rms(one) * _rms(other), 1e-9)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values * values)))
