"""Pressures: zero with the pitot covered, a breath into it, and the air on the ground.

The slope of a pressure transducer cannot be checked at a field without a manometer; it stays as it
was certified, and the curve is moved so that it passes through what is known today: no dynamic
pressure with the pitot covered, and the pressure that the field's barometer reads.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Literal

import numpy as np
import numpy.typing as npt

from calibration.adc import ADC_RESOLUTION
from calibration.certificate import Certificate
from calibration.points import CalibrationError, CalibrationPoint
from calibration.polynomial_fit import evaluate_polynomial
from calibration.quality import CalibrationQuality
from calibration.rest_detection import (
    RestCriteria,
    RestMonitor,
    RestPeriod,
    SampleSegment,
    SampleSegmenter,
)
from calibration.settings import PRESSURES
from gsapp.quantities import channel, from_si, to_si


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundAir:
    """The air at the field as entered."""

    pressure: float
    """Not reduced to sea level, Pa."""
    temperature: float
    """K."""

    @classmethod
    def from_input(
        cls, pressure: float, pressure_unit: str, temperature: float, temperature_unit: str
    ) -> GroundAir:
        """Return what was entered, if air at a field can be so.

        Raises
        ------
        CalibrationError
            If the pressure or the temperature cannot be that of a field.
        UnitError
            If a unit is not one of pressure, or of temperature.
        """
        pascal = to_si(pressure, pressure_unit, "pressure")
        kelvin = to_si(temperature, temperature_unit, "temperature")
        if not 60e3 <= pascal <= 108e3:
            raise CalibrationError(
                f"{pressure:g} {pressure_unit} is not plausible; enter the barometer reading at "
                "the field, such as 1000 hPa"
            )
        if not 233.0 <= kelvin <= 328.0:
            raise CalibrationError(
                f"{temperature:g} {temperature_unit} is not plausible; enter the air "
                "temperature in the shade"
            )
        return cls(pressure=pascal, temperature=kelvin)


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
    pressure : float
        At the field, not reduced to sea level, Pa.
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
    text = "within" if passed else "more than"
    title = channel(name).title
    sentence = f"{title} was {shift:+.0f} Pa off, {text} the {tolerance:.0f} Pa of allowed drift."
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
        resolution=ADC_RESOLUTION * float(slope.max()),
        covered=(float(here), float(here)),
        uncertainty_volts=tuple(places.tolist()),
        half_widths=tuple(np.linalg.norm(parts, axis=0).tolist()),
    )


PitotBlowState = Literal["waiting", "blowing", "green", "reversed", "blocked", "leaking"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PitotBlowStatus:
    """How a breath into the pitot goes on."""

    state: PitotBlowState
    """``green`` once a breath was seen and has gone again, and stays. ``reversed``: the pressure
    fell. ``blocked``: it does not go back. ``leaking``: the static pressure rose with it."""
    pressure: float
    peak: float
    """Now, and the highest of the breath, Pa."""
    sentence: str
    """For the crew; empty while there is nothing to say."""


_SENTENCES: Mapping[PitotBlowState, str] = {
    "waiting": "Blow gently into the pitot.",
    "blowing": "",
    "green": "Pitot OK.",
    "reversed": "The pressure falls when you blow: the hoses of pitot and static are swapped.",
    "blocked": "The pressure remains after the breath: check the hose for water or a kink.",
    "leaking": "The static pressure rises with the breath: a hose leaks, or two are swapped.",
}


class PitotBlowDetector:
    """Goes green by itself when somebody blows into the pitot.

    Judged in means of a twentieth of a second, counted from time zero: the result does not depend
    on how the samples were cut.

    Parameters
    ----------
    dynamic : Certificate
        With today's zero: `PressureZero.certificate`.
    static : Certificate, optional
        To find hoses that are swapped or leak.
    """

    def __init__(self, dynamic: Certificate, static: Certificate | None = None) -> None:
        self._curves = tuple(c for c in (dynamic, static) if c is not None)
        self._cutter = SampleSegmenter([c.channel for c in self._curves], PRESSURES.averaging)
        self.restart()

    def restart(self) -> None:
        """Wait for another breath."""
        self._cutter.restart()
        self._state: PitotBlowState = "waiting"
        self._pressure = self._peak = math.nan
        self._began = self._sucked = self._calm = math.nan
        self._level = self._static_before = self._static_rise = math.nan

    def feed(self, times: npt.ArrayLike, volts: Mapping[str, npt.ArrayLike]) -> None:
        for stretch in self._cutter.feed(times, volts):
            self._judge(stretch)

    @property
    def status(self) -> PitotBlowStatus:
        return PitotBlowStatus(
            state=self._state,
            pressure=self._pressure,
            peak=self._peak,
            sentence=_SENTENCES[self._state],
        )

    def _judge(self, stretch: SampleSegment) -> None:
        time = stretch.number * PRESSURES.averaging
        pressures = [
            float(curve.evaluate(volts))
            for curve, volts in zip(self._curves, stretch.mean, strict=True)
        ]
        if math.isnan(pressures[0]):
            return
        self._pressure = pressures[0]
        static = pressures[1] if len(pressures) > 1 else math.nan
        if self._state in ("waiting", "reversed"):
            self._await_breath(time, static)
        elif self._state in ("blowing", "blocked", "leaking"):
            self._follow_breath(time, static)

    def _await_breath(self, time: float, static: float) -> None:
        if self._pressure > PRESSURES.blow_pressure:
            self._state, self._began, self._peak = "blowing", time, self._pressure
            self._level = 0.0 if math.isnan(self._level) else self._level
            self._static_rise, self._calm = 0.0, math.nan
            return
        if self._pressure < -PRESSURES.suction_pressure:
            self._sucked = time if math.isnan(self._sucked) else self._sucked
            if time - self._sucked >= PRESSURES.min_duration:
                self._state = "reversed"
            return
        self._sucked = math.nan
        self._level = _track_baseline(self._level, self._pressure)
        self._static_before = _track_baseline(self._static_before, static)

    def _follow_breath(self, time: float, static: float) -> None:
        self._peak = max(self._peak, self._pressure)
        if not math.isnan(static) and not math.isnan(self._static_before):
            self._static_rise = max(self._static_rise, static - self._static_before)
        if self._pressure < PRESSURES.blow_pressure and math.isnan(self._calm):
            self._calm = time
        if self._pressure >= PRESSURES.blow_pressure:
            self._calm = math.nan
        if self._pressure > self._level + PRESSURES.end_pressure:
            if self._state == "blowing" and time - self._began > PRESSURES.blocked_time:
                self._state = "blocked"
            return
        lasted = (time if math.isnan(self._calm) else self._calm) - self._began
        if lasted < PRESSURES.min_duration:
            self._state, self._peak = "waiting", math.nan
        elif self._static_rise > PRESSURES.max_static_change:
            self._state = "leaking"
        else:
            self._state = "green"


def _track_baseline(before: float, now: float) -> float:
    return now if math.isnan(before) else before + 0.1 * (now - before)
