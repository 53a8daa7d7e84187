"""Rate gyros: the zero from a period of rest, and the scale from turns through a known angle.

A gyro gives v = z + k w, with w the rate about its axis. Over a turn through the angle A,

    integral of (v - z) dt = k A,

whatever the course of the rate, so the turntable need not run evenly: only its angle must be
known. The zero z goes straight from the rest before the turn to the rest after it. With the time
T that the turn took, A / T is the mean rate, and z + k A / T the volts that belong to it: these are
the points of the certificate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
import numpy.typing as npt

from calibration.certificate import Certificate
from calibration.inertial.straight_line import (
    FactoryCalibration,
    SensorVerdict,
    StraightLineCalibration,
    factory_calibrations,
)
from calibration.points import CalibrationError, CalibrationPoint
from calibration.rest_detection import RestCriteria, RestMonitor, RestPeriod
from calibration.settings import INERTIAL
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """One turn through a known angle, as one gyro saw it."""

    channel: str
    """The gyro about whose axis the turn went."""
    angle: float
    """Known, deg; positive right-handed about the body axis (right wing down, nose up, nose
    right)."""
    start: float
    end: float
    """Flight time, s."""
    zero: float
    """Volts at rest during the turn, V."""
    mean_volts: float
    """Mean volts over the turn, V."""
    sensitivity: float
    uncertainty: float
    """V per deg/s, and its half width at 95 %."""
    cross: Mapping[str, float]
    """What the other gyros saw, as a share of the turn, each by its factory scale."""
    verdict: SensorVerdict
    """Against the factory's scale."""

    @property
    def seconds(self) -> float:
        return self.end - self.start

    @property
    def mean_rate(self) -> float:
        return self.angle / self.seconds

    @property
    def point(self) -> CalibrationPoint:
        """Return the turn as a point of a certificate."""
        return CalibrationPoint(volts=self.mean_volts, value=self.mean_rate)


def evaluate_turn(
    channel: str,
    times: npt.ArrayLike,
    volts: Mapping[str, npt.ArrayLike],
    *,
    angle: float,
    turning: tuple[float, float],
    factory: Mapping[str, FactoryCalibration] | None = None,
) -> Turn:
    """Return what a gyro makes of a turn.

    Parameters
    ----------
    times : array_like, shape (n,)
        Flight time, s, increasing; from a rest before the turn to a rest after it.
    volts : mapping of str to array_like, shape (n,)
        Of all gyros that are recorded, V; NaN where missing.
    angle : float
        That was turned, deg, with its sign.
    turning : tuple of float
        When the turn began and ended; everything outside was rest. `TurnMonitor` finds it.
    factory : mapping of str to FactoryCalibration, optional
        Volts per unit; of the model airliner by default.

    Raises
    ------
    CalibrationError
        If there is not half a second of rest before and after, or samples are missing during
        the turn.
    """
    figures = factory or factory_calibrations()
    t = np.asarray(times, dtype=np.float64)
    start, end = turning
    samples = {name: np.asarray(v, dtype=np.float64) for name, v in volts.items()}
    moved = {
        name: _integrate_turn(name, t, v, start, end)
        for name, v in samples.items()
        if name == channel or np.any(np.isfinite(v))
    }
    own = moved[channel]
    k = own.area / angle
    seconds = end - start
    in_angle = abs(k) * math.sqrt(2.0) * INERTIAL.turn_angle_error / abs(angle)
    in_zero = own.zero_uncertainty * own.seconds / abs(angle)
    shares = {name: each.area / (figures[name].sensitivity * angle) for name, each in moved.items()}
    return Turn(
        channel=channel,
        angle=angle,
        start=start,
        end=end,
        zero=own.zero,
        mean_volts=own.zero + own.area / seconds,
        sensitivity=k,
        uncertainty=math.hypot(in_angle, in_zero),
        cross={name: share for name, share in shares.items() if name != channel},
        verdict=_evaluate_turn_verdict(figures[channel], own, shares),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _TurnIntegral:
    """What one gyro gave over a turn: zero (V), its uncertainty, area (V s) and extremes."""

    zero: float
    zero_uncertainty: float
    area: float
    seconds: float
    extremes: tuple[float, float]


def _integrate_turn(
    name: str, t: FloatArray, v: FloatArray, start: float, end: float
) -> _TurnIntegral:
    known = np.isfinite(v)
    t, v = t[known], v[known]
    before, after = (
        t < start - 0.5 * INERTIAL.rest_around_turn,
        t > end + 0.5 * INERTIAL.rest_around_turn,
    )
    if min(np.count_nonzero(before), np.count_nonzero(after)) < 5:
        raise CalibrationError(
            f"{name} has no rest before or after the turn; hold the turntable still for two "
            "seconds at both ends"
        )
    inside = (t >= start - INERTIAL.rest_around_turn) & (t <= end + INERTIAL.rest_around_turn)
    ti, vi = t[inside], v[inside]
    if ti.size < 10 or np.max(np.diff(ti)) > INERTIAL.max_gap:
        raise CalibrationError(f"samples of {name} are missing during the turn; repeat the turn")
    ends = [(float(np.mean(t[part])), float(np.mean(v[part]))) for part in (before, after)]
    zero = np.interp(ti, [at for at, _ in ends], [volts for _, volts in ends])
    spread = [_mean_half_width(v[before]), _mean_half_width(v[after])]
    over = vi - zero
    area = float(np.sum(0.5 * (over[1:] + over[:-1]) * np.diff(ti)))
    return _TurnIntegral(
        zero=float(np.mean(zero)),
        zero_uncertainty=0.5 * math.hypot(*spread),
        area=area,
        seconds=float(ti[-1] - ti[0]),
        extremes=(float(vi.min()), float(vi.max())),
    )


def _mean_half_width(v: FloatArray) -> float:
    return 2.0 * float(np.std(v)) / math.sqrt(max(v.size / 4.0, 1.0))


def _evaluate_turn_verdict(
    figures: FactoryCalibration, own: _TurnIntegral, shares: Mapping[str, float]
) -> SensorVerdict:
    name = figures.channel
    share = shares[name]
    others = {other: value for other, value in shares.items() if other != name}
    loudest = max(others, key=lambda other: abs(others[other]), default="")
    if loudest and abs(others[loudest]) > max(2.0 * abs(share), 0.5):
        return SensorVerdict(
            kind="swapped",
            sentence=f"The turn shows in {loudest} instead of {name}; check the turn, "
            "or whether the two are swapped.",
        )
    if abs(share) < INERTIAL.dead_gyro_share:
        return SensorVerdict(
            kind="dead", sentence=f"The {name} gyro does not respond to the turn; check its wires."
        )
    if own.extremes[0] < figures.range[0] - 0.05 or own.extremes[1] > figures.range[1] + 0.05:
        return SensorVerdict(
            kind="clipped",
            sentence=f"The {name} gyro saturated; turn more slowly.",
        )
    if share < 0.0:
        return SensorVerdict(
            kind="reversed",
            sentence=f"The {name} gyro has the wrong sign; check which way was turned.",
        )
    return SensorVerdict(
        kind="agrees" if abs(share - 1.0) <= INERTIAL.gyro_scale_tolerance else "differs",
        sentence=f"The scale of the {name} gyro is {100.0 * (share - 1.0):+.1f} % from the data "
        "sheet.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroScale:
    """The sensitivity of a gyro from one turn or several."""

    channel: str
    """``p``, ``q`` or ``r``."""
    sensitivity: float
    uncertainty: float
    """V per deg/s, and its half width at 95 %."""
    deviation: float
    """From the factory's, relative."""


def gyro_scale(
    turns: Sequence[Turn], *, factory: Mapping[str, FactoryCalibration] | None = None
) -> GyroScale:
    """Join turns of one gyro, each by its uncertainty.

    Raises
    ------
    CalibrationError
        If there is no turn, turns are of several gyros, or a turn cannot be used.
    """
    if not turns:
        raise CalibrationError("no turn; turn the table once to the right and once back")
    channel = turns[0].channel
    if any(turn.channel != channel for turn in turns):
        raise CalibrationError("turns of different gyros cannot be joined; calibrate one by one")
    for turn in turns:
        if not turn.verdict.usable:
            raise CalibrationError(turn.verdict.sentence)
    k = np.array([turn.sensitivity for turn in turns])
    u = np.array([turn.uncertainty for turn in turns])
    weight = u**-2.0 / np.sum(u**-2.0)
    joined = float(weight @ k)
    # Turns that disagree by more than they should say how good they really are.
    stretch = 1.0
    if len(turns) > 1:
        stretch = max(1.0, 2.0 * math.sqrt(np.sum(((k - joined) / u) ** 2) / (len(turns) - 1)))
    figures = (factory or factory_calibrations())[channel]
    return GyroScale(
        channel=channel,
        sensitivity=joined,
        uncertainty=stretch * float(np.sum(u**-2.0)) ** -0.5,
        deviation=joined / figures.sensitivity - 1.0,
    )


GYROS = ("p", "q", "r")


def create_inertial_rest_monitor(
    channels: Sequence[str] = GYROS,
    *,
    seconds: float = 5.0,
    factory: Mapping[str, FactoryCalibration] | None = None,
) -> RestMonitor:
    """Return a watch for a still aircraft.

    Parameters
    ----------
    channels : sequence of str
        Gyros and accelerometers. With accelerometers beside the gyros a slow steady turn about a
        level axis cannot pass for a zero.
    factory : mapping of str to FactoryCalibration, optional
        Volts per unit; of the model airliner by default.
    """
    figures = factory or factory_calibrations()
    limits = {}
    for name in channels:
        wander, shake = (
            (INERTIAL.rest_rate, INERTIAL.rest_rate_std)
            if name in GYROS
            else (INERTIAL.rest_tilt, INERTIAL.rest_acceleration_std)
        )
        per_unit = abs(figures[name].sensitivity)
        limits[name] = RestCriteria(std=shake * per_unit, mean_spread=wander * per_unit)
    return RestMonitor(limits, seconds=seconds)


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroZero:
    """The volts of a gyro at rest."""

    channel: str
    """``p``, ``q`` or ``r``."""
    volts: float
    uncertainty: float
    """Mean, and its half width at 95 %, V."""
    noise: float
    """Standard deviation of single samples, deg/s by the factory's scale."""
    shift: float
    """From the factory's zero, deg/s by the factory's scale."""
    seconds: float
    """Length of the rest."""
    verdict: SensorVerdict
    """Against the factory's zero."""


def gyro_zero(
    channel: str, rest: RestPeriod, *, factory: Mapping[str, FactoryCalibration] | None = None
) -> GyroZero:
    """Return the zero of a gyro from a rest that `create_inertial_rest_monitor` has found."""
    figures = (factory or factory_calibrations())[channel]
    volts = rest.volts[channel]
    shift = (volts - figures.zero) / figures.sensitivity
    if not figures.range[0] <= volts <= figures.range[1]:
        verdict = SensorVerdict(
            kind="dead",
            sentence=f"The {channel} gyro reads {volts:.3f} V at rest, outside its range; "
            "check its wires and its supply.",
        )
    elif abs(shift) > INERTIAL.gyro_zero_tolerance:
        verdict = SensorVerdict(
            kind="differs",
            sentence=f"The zero of the {channel} gyro is {shift:+.1f} deg/s from the data sheet.",
        )
    else:
        verdict = SensorVerdict(
            kind="agrees",
            sentence=f"The zero of the {channel} gyro is {volts:.3f} V, {shift:+.2f} deg/s from "
            "the data sheet.",
        )
    return GyroZero(
        channel=channel,
        volts=volts,
        uncertainty=rest.uncertainty[channel],
        noise=abs(rest.std[channel] / figures.sensitivity),
        shift=shift,
        seconds=rest.end - rest.start,
        verdict=verdict,
    )


def gyro_certificate(
    zero: GyroZero,
    turns: Sequence[Turn] = (),
    *,
    who: str,
    stamp: datetime,
    temperature: float | None = None,
    factory: Mapping[str, FactoryCalibration] | None = None,
) -> Certificate:
    """Return the certificate of a gyro.

    Parameters
    ----------
    turns : sequence of Turn
        About its axis; without any the scale is the factory's, and the certificate says so.

    Raises
    ------
    CalibrationError
        If the gyro or a turn cannot be used.
    """
    if not zero.verdict.usable:
        raise CalibrationError(zero.verdict.sentence)
    figures = (factory or factory_calibrations())[zero.channel]
    scale = gyro_scale(turns, factory=factory) if turns else None
    sensitivity = scale.sensitivity if scale else figures.sensitivity
    points = (
        CalibrationPoint(volts=zero.volts, value=0.0),
        *(turn.point for turn in turns),
    )
    notes = f"Zero of {zero.seconds:.0f} s at rest, to {zero.uncertainty / abs(sensitivity):.2g}"
    notes += " deg/s; "
    if scale is None:
        notes += "scale from the data sheet, not checked today."
    else:
        notes += (
            f"scale from {len(turns)} turn{'s'[: len(turns) > 1]}, to "
            f"{100.0 * scale.uncertainty / abs(scale.sensitivity):.2g} %, "
            f"{100.0 * scale.deviation:+.1f} % from the data sheet. Linearity from the data "
            "sheet."
        )
    line = StraightLineCalibration(
        zero=zero.volts,
        zero_uncertainty=zero.uncertainty,
        sensitivity=sensitivity,
        sensitivity_uncertainty=(
            scale.uncertainty if scale else INERTIAL.gyro_scale_tolerance * abs(figures.sensitivity)
        ),
        noise=zero.noise * abs(figures.sensitivity),
        range=figures.range,
    )
    return line.certificate(
        zero.channel,
        figures.unit,
        points,
        who=who,
        stamp=stamp,
        temperature=temperature,
        instrument="Rate gyro",
        notes=notes,
    )
