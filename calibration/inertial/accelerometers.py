"""Accelerometers: zero, scale and misalignment from the aircraft laid in six positions.

At rest the three accelerometers read the specific force f, as long as gravity and along the body
axis that points up. Their volts are

    v = z + K f,    f = R(tilt) e,

with the zeros z, the sensitivities on the diagonal of K, and what each reads of the other axes
beside it. The aircraft never lies exactly in its position: each position has two small tilts of
its own, known beforehand only to be small. All of it is found at once by least squares, with the
readings weighted by their noise and the tilts by how well the aircraft is laid. So zero and scale
come out clear of tilt to first order, and misalignment as uncertain as the laying makes it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np

from calibration.certificate import Certificate
from calibration.inertial.straight_line import (
    FactoryCalibration,
    SensorVerdict,
    StraightLineCalibration,
    factory_calibrations,
)
from calibration.points import CalibrationError, CalibrationPoint
from calibration.rest_detection import RestPeriod
from calibration.settings import INERTIAL
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class SixPositionSolution:
    """What was found."""

    zero: FloatArray
    zero_std: FloatArray
    """Shape (3,). V, with standard deviations."""
    matrix: FloatArray
    matrix_std: FloatArray
    """Shape (3, 3). V/g; a row for each accelerometer, a column for each axis of the force."""
    tilts: FloatArray
    """Shape (n, 2). Of each reading toward the two axes that were to be level, rad."""
    misfit: float
    """Sum of squares of all residuals, each in its standard deviations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SixPositionProblem:
    """What was read."""

    force: FloatArray
    """Shape (n, 3). Specific force of each reading, had the aircraft lain as asked, g."""
    volts: FloatArray
    noise: FloatArray
    """Shape (n, 3). Means of the three accelerometers, with standard deviations, V."""
    tilt: float
    """Standard deviation with which the aircraft is laid, rad."""

    def solve(self) -> SixPositionSolution:
        """Solve by Gauss-Newton; the unknowns are z (3), K (9, by rows), and two tilts each."""
        n = len(self.force)
        level = np.column_stack([np.ones(n), self.force])
        start = np.linalg.lstsq(level, self.volts, rcond=None)[0]
        x = np.concatenate([start[0], start[1:].T.ravel(), np.zeros(2 * n)])
        for _ in range(INERTIAL.max_iterations):
            residual, jacobian = self._linearized(x)
            step = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
            x = x + step
            if np.max(np.abs(step)) < 1e-12:
                break
        residual, jacobian = self._linearized(x)
        std = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
        return SixPositionSolution(
            zero=x[:3],
            zero_std=std[:3],
            matrix=x[3:12].reshape(3, 3),
            matrix_std=std[3:12].reshape(3, 3),
            tilts=x[12:].reshape(n, 2),
            misfit=float(residual @ residual),
        )

    def _linearized(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what is left (3n + 2n,), each in its standard deviations, and its Jacobian."""
        n = len(self.force)
        matrix, tilts = x[3:12].reshape(3, 3), x[12:].reshape(n, 2)
        residual = np.zeros(5 * n)
        jacobian = np.zeros((5 * n, 12 + 2 * n))
        for k, nominal in enumerate(self.force):
            force, by_tilt = _tilted(nominal, tilts[k])
            for i in range(3):
                row = 3 * k + i
                residual[row] = x[i] + matrix[i] @ force - self.volts[k, i]
                jacobian[row, i] = 1.0
                jacobian[row, 3 + 3 * i : 6 + 3 * i] = force
                jacobian[row, 12 + 2 * k : 14 + 2 * k] = matrix[i] @ by_tilt
                residual[row] /= self.noise[k, i]
                jacobian[row] /= self.noise[k, i]
        own = np.arange(2 * n)
        residual[3 * n :] = x[12:] / self.tilt
        jacobian[3 * n + own, 12 + own] = 1.0 / self.tilt
        return residual, jacobian


def _tilted(nominal: FloatArray, tilt: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a force leaning by two tilts (sines) toward the other axes, and its derivatives."""
    axis = int(np.argmax(np.abs(nominal)))
    others = [index for index in range(3) if index != axis]
    size = float(np.linalg.norm(nominal))
    along = math.sqrt(max(1.0 - float(tilt @ tilt), 1e-6))
    force = nominal * along
    force[others] = size * tilt
    by_tilt = np.zeros((3, 2))
    by_tilt[axis] = -nominal[axis] * tilt / along
    by_tilt[others, [0, 1]] = size
    return force, by_tilt


ACCELEROMETERS = ("ax", "ay", "an")
Position = Literal["z_down", "z_up", "x_up", "x_down", "y_up", "y_down"]
POSITIONS: tuple[Position, ...] = get_args(Position)
"""Which body axis points where: upright, on its back, nose up, nose down, right wing up, down."""
POSITION_TEXT: Mapping[Position, str] = MappingProxyType(
    {
        "z_down": "upright and level",
        "z_up": "on its back, level",
        "x_up": "nose straight up",
        "x_down": "nose straight down",
        "y_up": "right wing straight up",
        "y_down": "right wing straight down",
    }
)
_FORCE: Mapping[Position, tuple[float, float, float]] = MappingProxyType(
    {
        "z_down": (0.0, 0.0, 1.0),
        "z_up": (0.0, 0.0, -1.0),
        "x_up": (1.0, 0.0, 0.0),
        "x_down": (-1.0, 0.0, 0.0),
        "y_up": (0.0, 1.0, 0.0),
        "y_down": (0.0, -1.0, 0.0),
    }
)


def specific_force(position: Position) -> Mapping[str, float]:
    """Return what the accelerometers should show in a position, g."""
    return dict(zip(ACCELEROMETERS, _FORCE[position], strict=True))


def recognize_position(
    volts: Mapping[str, float], *, factory: Mapping[str, FactoryCalibration] | None = None
) -> Position | None:
    """Return the position whose forces the volts are near to by the factory's figures, or None."""
    figures = factory or factory_calibrations()
    force = np.array(
        [(volts[n] - figures[n].zero) / figures[n].sensitivity for n in ACCELEROMETERS]
    )
    if not np.all(np.isfinite(force)):
        return None
    distance = {p: float(np.linalg.norm(force - np.array(f))) for p, f in _FORCE.items()}
    nearest = min(POSITIONS, key=lambda p: distance[p])
    return nearest if distance[nearest] < 0.35 else None


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionReading:
    """The three accelerometers in one position."""

    position: Position
    """How the aircraft lay."""
    rest: RestPeriod
    """Of `ACCELEROMETERS`, found by `create_inertial_rest_monitor`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AccelerometerFit:
    """One accelerometer."""

    channel: str
    """``ax``, ``ay`` or ``an``."""
    zero: float
    zero_uncertainty: float
    """Volts at zero g, V; half width at 95 %, as are all uncertainties here."""
    sensitivity: float
    sensitivity_uncertainty: float
    """V/g, of standard gravity."""
    cross: Mapping[str, float]
    cross_uncertainty: Mapping[str, float]
    """Angle by which it leans toward each other axis, deg."""
    verdict: SensorVerdict
    """Against the factory's figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SixPositionResult:
    """What six positions tell."""

    fits: Mapping[str, AccelerometerFit]
    readings: tuple[PositionReading, ...]
    tilts: tuple[float, ...]
    """How far the aircraft lay from each position, as far as it can be told, deg."""
    issue: str
    """What does not fit together; empty where all does."""
    factory: Mapping[str, FactoryCalibration]
    """What they were held against."""

    def certificate(
        self, channel: str, *, who: str, stamp: datetime, temperature: float | None = None
    ) -> Certificate:
        """Return the certificate of one accelerometer.

        Raises
        ------
        CalibrationError
            If its volts do not tell its acceleration.
        """
        fit = self.fits[channel]
        if not fit.verdict.usable:
            raise CalibrationError(fit.verdict.sentence)
        points = tuple(
            CalibrationPoint(
                volts=reading.rest.volts[channel],
                value=specific_force(reading.position)[channel],
            )
            for reading in self.readings
        )
        leans = ", ".join(
            f"{fit.cross[other]:+.1f} deg toward {other} (to {fit.cross_uncertainty[other]:.1f})"
            for other in fit.cross
        )
        per_unit = abs(fit.sensitivity)
        noise = max(reading.rest.std[channel] for reading in self.readings)
        line = StraightLineCalibration(
            zero=fit.zero,
            zero_uncertainty=fit.zero_uncertainty,
            sensitivity=fit.sensitivity,
            sensitivity_uncertainty=fit.sensitivity_uncertainty,
            noise=noise,
            range=self.factory[channel].range,
        )
        return line.certificate(
            channel,
            self.factory[channel].unit,
            points,
            who=who,
            stamp=stamp,
            temperature=temperature,
            instrument="Accelerometer",
            notes=(
                f"Six positions. Zero to {1e3 * fit.zero_uncertainty / per_unit:.1f} mg, "
                f"scale to {100.0 * fit.sensitivity_uncertainty / per_unit:.2f} %. "
                f"Leans {leans}. {fit.verdict.sentence} Residuals are how the aircraft lay. "
                "Straight to the ends of the range by the factory's word."
            ),
        )


def calibrate_accelerometers(
    readings: Sequence[PositionReading],
    *,
    laying_error: float = INERTIAL.leveling_error,
    factory: Mapping[str, FactoryCalibration] | None = None,
) -> SixPositionResult:
    """Find zero, scale and misalignment of three accelerometers.

    Parameters
    ----------
    readings : sequence of PositionReading
        Each of `POSITIONS` at least once; a position may be read again to gain certainty.
    laying_error : float
        How far the aircraft may lie from a position, about either axis, half width at 95 %, deg.
    factory : mapping of str to FactoryCalibration, optional
        Table 3.5.3 by default.

    Raises
    ------
    CalibrationError
        If a position is missing, or gives no number.
    """
    missing = [p for p in POSITIONS if all(reading.position != p for reading in readings)]
    if missing:
        raise CalibrationError(
            f"the position '{POSITION_TEXT[missing[0]]}' is missing; place the aircraft in this "
            "position"
        )
    volts = np.array([[r.rest.volts[name] for name in ACCELEROMETERS] for r in readings])
    if not np.all(np.isfinite(volts)):
        raise CalibrationError("an accelerometer gave no volts; check that all three are recorded")
    spread = np.array([[r.rest.uncertainty[name] for name in ACCELEROMETERS] for r in readings])
    problem = SixPositionProblem(
        force=np.array([_FORCE[r.position] for r in readings]),
        volts=volts,
        noise=np.hypot(0.5 * spread, INERTIAL.min_mean_std),
        tilt=0.5 * laying_error * DEGREE,
    )
    solution = problem.solve()
    figures = factory or factory_calibrations()
    fits = {name: _build_fit(index, solution, figures) for index, name in enumerate(ACCELEROMETERS)}
    tilts = np.hypot(solution.tilts[:, 0], solution.tilts[:, 1]) / DEGREE
    doubt = ""
    if solution.misfit > INERTIAL.max_misfit:
        worst = readings[int(np.argmax(tilts))].position
        doubt = (
            f"The six positions do not fit together; '{POSITION_TEXT[worst]}' is off by "
            f"{np.max(tilts):.1f} deg; repeat that position."
        )
    return SixPositionResult(
        fits=fits,
        readings=tuple(readings),
        tilts=tuple(tilts.tolist()),
        issue=doubt,
        factory=figures,
    )


def _build_fit(
    index: int, solution: SixPositionSolution, factory: Mapping[str, FactoryCalibration]
) -> AccelerometerFit:
    name = ACCELEROMETERS[index]
    figures = factory[name]
    k = float(solution.matrix[index, index])
    # One that hardly answers has no direction to speak of; its verdict says so.
    per_unit = k if abs(k) > 0.01 * abs(figures.sensitivity) else figures.sensitivity
    others = [(other, ACCELEROMETERS[other]) for other in range(3) if other != index]
    cross = {o: math.degrees(math.atan(solution.matrix[index, j] / per_unit)) for j, o in others}
    cross_uncertainty = {
        o: 2.0 * math.degrees(solution.matrix_std[index, j] / abs(per_unit)) for j, o in others
    }
    zero_shift = (float(solution.zero[index]) - figures.zero) / figures.sensitivity
    shares = solution.matrix[index] / figures.sensitivity
    return AccelerometerFit(
        channel=name,
        zero=float(solution.zero[index]),
        zero_uncertainty=2.0 * float(solution.zero_std[index]),
        sensitivity=k,
        sensitivity_uncertainty=2.0 * float(solution.matrix_std[index, index]),
        cross=cross,
        cross_uncertainty=cross_uncertainty,
        verdict=_evaluate_verdict(index, shares, zero_shift, cross),
    )


def _evaluate_verdict(
    index: int, shares: FloatArray, zero_shift: float, cross: Mapping[str, float]
) -> SensorVerdict:
    name = ACCELEROMETERS[index]
    loudest = int(np.argmax(np.abs(shares)))
    if abs(shares[loudest]) < INERTIAL.dead_accelerometer_share:
        return SensorVerdict(
            kind="dead",
            sentence=f"The accelerometer {name} does not respond to gravity; check its wires.",
        )
    if loudest != index:
        return SensorVerdict(
            kind="swapped",
            sentence=f"The accelerometer {name} responds to the axis of "
            f"{ACCELEROMETERS[loudest]}; the two are swapped, or the position was "
            "wrong.",
        )
    if shares[index] < 0.0:
        return SensorVerdict(
            kind="reversed", sentence=f"The accelerometer {name} has the wrong sign."
        )
    deviation = shares[index] - 1.0
    most = max(abs(angle) for angle in cross.values())
    agrees = (
        abs(zero_shift) <= INERTIAL.accelerometer_zero_tolerance
        and abs(deviation) <= INERTIAL.accelerometer_scale_tolerance
        and most <= INERTIAL.alignment_tolerance
    )
    word = "as specified" if agrees else "not as specified"
    return SensorVerdict(
        kind="agrees" if agrees else "differs",
        sentence=f"The accelerometer {name} is {word}: zero {1e3 * zero_shift:+.0f} mg, "
        f"scale {100.0 * deviation:+.1f} %, leaning {most:.1f} deg.",
    )
