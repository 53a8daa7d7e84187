"""Rate gyros: the zero from a period of rest, and the certificate with the scale of turns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

from calibration.certificate import Certificate
from calibration.inertial.factory_comparison import (
    FactoryCalibration,
    SensorVerdict,
    factory_calibrations,
)
from calibration.inertial.settings import INERTIAL
from calibration.inertial.turntable import Turn, gyro_scale
from calibration.points import CalibrationError, CalibrationPoint
from calibration.rest_detection import RestCriteria, RestMonitor, RestPeriod
from calibration.straight_line import StraightLineCalibration

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
    seconds : float
        How long the aircraft must be still.
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
    who, stamp, temperature
        As in `Certificate`.
    factory : mapping of str to FactoryCalibration, optional
        As for `create_inertial_rest_monitor`.

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
