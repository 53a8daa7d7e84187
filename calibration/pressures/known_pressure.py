"""Pressure transducers at a pressure that is known.

The slope of a pressure transducer cannot be checked at a field without a manometer; it stays as it
was certified, and the curve is moved so that it passes through what is known today: no dynamic
pressure with the pitot covered, and the pressure that the field's barometer reads.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from calibration.adc import ADC_RESOLUTION
from calibration.certificate import Certificate
from calibration.points import CalibrationError, CalibrationPoint
from calibration.polynomial_fit import evaluate_polynomial
from calibration.pressures.settings import PRESSURES
from calibration.quality import CalibrationQuality
from calibration.rest_detection import RestCriteria, RestMonitor, RestPeriod
from gsapp.quantities import channel, from_si


def create_covered_pitot_monitor(
    dynamic: Certificate,
    static: Certificate | None = None,
    *,
    seconds: float = 4.0,
    lull: bool = False,
) -> RestMonitor:
    """Return a watch for steady pressures, the pitot being covered against wind.

    Under a cover the dynamic pressure moves by its own noise only; wind moves it by more even in
    a lull, so that a forgotten cover is found.

    Parameters
    ----------
    dynamic, static : Certificate
        In force, or shipped; their slopes say what steady means in volts.
    seconds : float
        For how long.
    lull : bool
        Be content with a pressure that moves as in a lull: for a transducer that wanders of
        itself. Its zero may be off by `PRESSURES.wind_uncertainty`.
    """
    noises = math.inf if lull else PRESSURES.noise_ratio
    limits = {
        dynamic.channel: _rest_criteria(
            dynamic, PRESSURES.rest_pressure_std, PRESSURES.rest_pressure, noises
        )
    }
    if static is not None:
        limits[static.channel] = _rest_criteria(
            static, PRESSURES.static_rest_pressure_std, PRESSURES.static_rest_pressure, math.inf
        )
    return RestMonitor(limits, seconds=seconds)


def _rest_criteria(
    certificate: Certificate, std: float, wander: float, noises: float
) -> RestCriteria:
    slope = abs(certificate.end_slopes[0])
    return RestCriteria(std=std / slope, mean_spread=wander / slope, noise_factor=noises)


@dataclass(frozen=True, slots=True, kw_only=True)
class PressureZero:
    """A transducer at a known pressure."""

    certificate: Certificate
    """The former curve, moved through today's point."""
    volts: float
    uncertainty: float
    """Mean, and its half width at 95 %, V."""
    shift: float
    """Pressure that the former certificate showed above the known one, Pa."""
    passed: bool
    """Whether the shift is within what such a transducer drifts."""
    sentence: str


def dynamic_pressure_zero(
    rest: RestPeriod,
    former: Certificate,
    *,
    who: str,
    stamp: datetime,
    temperature: float | None = None,
    lull: bool = False,
) -> PressureZero:
    """Return the zero of the dynamic pressure with the pitot covered.

    Parameters
    ----------
    rest : RestPeriod
        Found by `create_covered_pitot_monitor`.
    who, stamp, temperature
        As in `Certificate`.
    lull : bool
        Whether the pressure moved as in wind: then `PRESSURES.wind_uncertainty` is part of the
        uncertainty.

    Raises
    ------
    CalibrationError
        If the transducer reads at an end of the converter, so that nothing can be told.
    """
    if lull:
        name = former.channel
        wind = PRESSURES.wind_uncertainty / abs(former.end_slopes[0])
        wider = math.hypot(rest.uncertainty[name], wind)
        rest = replace(rest, uncertainty={**rest.uncertainty, name: wider})
    return _shift_certificate(
        rest, former, 0.0, PRESSURES.dynamic_zero_tolerance, who, stamp, temperature
    )


def static_pressure_check(
    rest: RestPeriod,
    former: Certificate,
    pressure: float,
    *,
    who: str,
    stamp: datetime,
    temperature: float | None = None,
) -> PressureZero:
    """Return the static pressure held against the field's barometer.

    Parameters
    ----------
    rest, former, who, stamp, temperature
        As for `dynamic_pressure_zero`.
    pressure : float
        At the field, not reduced to sea level, Pa.

    Raises
    ------
    CalibrationError
        As for `dynamic_pressure_zero`.
    """
    return _shift_certificate(
        rest, former, pressure, PRESSURES.static_tolerance, who, stamp, temperature
    )


def _shift_certificate(
    rest: RestPeriod,
    former: Certificate,
    pressure: float,
    tolerance: float,
    who: str,
    stamp: datetime,
    temperature: float | None,
) -> PressureZero:
    name, key = former.channel, channel(former.channel).quantity
    volts = rest.volts[name]
    if not 0.01 < volts < 4.98:
        raise CalibrationError(
            f"{name} reads {volts:.3f} V, the end of the ADC range; check its wires and supply"
        )
    value = from_si(pressure, former.unit, key)
    shift = float(former.evaluate(volts)) - pressure
    by = value - from_si(pressure + shift, former.unit, key)
    passed = abs(shift) <= tolerance
    words = "within" if passed else "more than"
    title = channel(name).title
    sentence = f"{title} was {shift:+.0f} Pa off, {words} the {tolerance:.0f} Pa of allowed drift."
    coefficients = (former.coefficients[0] + by, *former.coefficients[1:])
    # At no pressure the transducer is at the end of its range, and its noise goes beyond.
    margin = max(10.0 * rest.std[name], 5.0 * ADC_RESOLUTION)
    covered = (min(former.range[0], volts - margin), max(former.range[1], volts + margin))
    certificate = Certificate(
        channel=name,
        unit=former.unit,
        coefficients=coefficients,
        range=covered,
        who=who,
        stamp=stamp.replace(microsecond=0),
        points=(CalibrationPoint(volts=volts, value=value),),
        excitation_voltage=former.excitation_voltage,
        ratiometric=former.ratiometric,
        temperature=temperature,
        instrument=former.instrument,
        notes=f"Moved through one point; slope of {former.stamp:%Y-%m-%d}. {sentence}",
        quality=_quality(coefficients, covered, rest, name),
    )
    return PressureZero(
        certificate=certificate,
        volts=volts,
        uncertainty=rest.uncertainty[name],
        shift=shift,
        passed=passed,
        sentence=sentence,
    )


def _quality(
    coefficients: tuple[float, ...], covered: tuple[float, float], rest: RestPeriod, name: str
) -> CalibrationQuality:
    """Return what a curve through one point is worth: its slope is the factory's to a percent."""
    places = np.linspace(*covered, PRESSURES.line_points)
    values = evaluate_polynomial(coefficients, places)
    slope = np.abs(evaluate_polynomial([n * c for n, c in enumerate(coefficients)][1:], places))
    here = evaluate_polynomial(coefficients, np.array([rest.volts[name]]))[0]
    parts = [
        rest.uncertainty[name] * slope,
        PRESSURES.linearity * np.abs(values - here),
        1.96 * rest.std[name] * slope,
        0.5 * ADC_RESOLUTION * slope,
    ]
    line = np.polynomial.Polynomial.fit(places, values, 1)
    return CalibrationQuality(
        degree=len(coefficients) - 1,
        rms=0.0,
        max_residual=0.0,
        linearity=float(np.max(np.abs(values - line(places)))),
        scatter=None,
        hysteresis=None,
        hysteresis_uncertainty=None,
        return_to_zero=None,
        resolution=ADC_RESOLUTION * float(slope.max()),
        covered=(float(here), float(here)),
        uncertainty_volts=tuple(places.tolist()),
        half_widths=tuple(np.linalg.norm(parts, axis=0).tolist()),
    )
