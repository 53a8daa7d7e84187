"""Pressures: zero with the pitot covered, a breath into it, and the air on the ground.

The slope of a pressure transducer cannot be checked at a field without a manometer; it stays as it
was certified, and the curve is moved so that it passes through what is known today: no dynamic
pressure with the pitot covered, and the pressure that the field's barometer reads.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

import numpy as np
import numpy.typing as npt

from calibration.certificate import Certificate
from calibration.fit import polynomial
from calibration.points import CalibrationError, CalibrationPoint
from calibration.quality import Quality
from calibration.rest import Rest, RestLimit, RestWatch
from calibration.straight import STEP
from calibration.stretches import Stretch, StretchCutter
from gsapp.quantities import channel, from_si, to_si

BlowState = Literal["waiting", "blowing", "green", "reversed", "blocked", "leaking"]

_QUIET, _QUIET_STD = 2.5, 6.0
"""Pa: how far half-second means of the dynamic pressure may wander, and its samples scatter."""
_STATIC_QUIET, _STATIC_STD = 60.0, 150.0
"""The same for the static pressure, Pa."""
ZERO_TOLERANCE = 50.0
"""Pa: a covered pitot that reads more than that is named."""
STATIC_TOLERANCE = 600.0
"""Pa: half a percent of an atmosphere; about 50 m of altitude."""
LINEARITY = 0.01
"""Of the transducers, relative: what the source says of them."""
BREATH = 150.0
"""Pa above zero that count as a breath; lungs give several thousand."""
_SUCK = 60.0
_BACK = 40.0
"""Pa above what the wind made before at which a breath is over."""
_STATIC_MOVES = 500.0
"""Pa of static pressure that a breath into the pitot must not move."""
_LAST, _BLOCKED_AFTER = 0.3, 10.0
"""s for which a breath must last, and after which pressure that stays is shut in."""
_PLACES = 9
_LENGTH = 0.05
"""s: means over that are judged."""


def covered_watch(
    dynamic: Certificate, static: Certificate | None = None, *, seconds: float = 3.0
) -> RestWatch:
    """Return a watch for steady pressures, the pitot being covered against wind.

    An uncovered pitot in a light wind may still pass in a lull, some pascals off: the cover is
    what keeps the wind away, the watch only finds that it was forgotten in any other wind.

    Parameters
    ----------
    dynamic, static : Certificate
        In force, or shipped; their slopes say what steady means in volts.
    seconds : float
        For how long.
    """
    limits = {dynamic.channel: _limit(dynamic, _QUIET_STD, _QUIET)}
    if static is not None:
        limits[static.channel] = _limit(static, _STATIC_STD, _STATIC_QUIET)
    return RestWatch(limits, seconds=seconds)


def _limit(certificate: Certificate, std: float, wander: float) -> RestLimit:
    slope = abs(certificate.end_slopes[0])
    return RestLimit(std=std / slope, wander=wander / slope)


@dataclass(frozen=True, slots=True, kw_only=True)
class PressureZero:
    """A transducer at a known pressure.

    Attributes
    ----------
    certificate : Certificate
        The former curve, moved through today's point.
    volts, uncertainty : float
        Mean, and its half width at 95 %, V.
    shift : float
        Pressure that the former certificate showed above the known one, Pa.
    passed : bool
        Whether the shift is within what such a transducer drifts.
    sentence : str
        For the crew.
    """

    certificate: Certificate
    volts: float
    uncertainty: float
    shift: float
    passed: bool
    sentence: str


def dynamic_zero(
    rest: Rest,
    former: Certificate,
    *,
    who: str,
    stamp: datetime,
    temperature: float | None = None,
) -> PressureZero:
    """Return the zero of the dynamic pressure with the pitot covered.

    Parameters
    ----------
    rest : Rest
        Found by `covered_watch`.
    former : Certificate
        Whose slope is kept.
    who, stamp, temperature
        As in `Certificate`.

    Raises
    ------
    CalibrationError
        If the transducer reads at an end of the converter, so that nothing can be told.
    """
    return _moved(rest, former, 0.0, ZERO_TOLERANCE, who, stamp, temperature)


def static_check(
    rest: Rest,
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
        As for `dynamic_zero`.
    pressure : float
        At the field, not reduced to sea level, Pa.

    Raises
    ------
    CalibrationError
        As for `dynamic_zero`.
    """
    return _moved(rest, former, pressure, STATIC_TOLERANCE, who, stamp, temperature)


def _moved(
    rest: Rest,
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
            f"{name} reads {volts:.3f} V, an end of the converter; check its wires and its supply"
        )
    value = from_si(pressure, former.unit, key)
    shift = float(former.evaluate(volts)) - pressure
    by = value - from_si(pressure + shift, former.unit, key)
    passed = abs(shift) <= tolerance
    words = "within" if passed else "more than"
    title = channel(name).title
    sentence = f"{title} was {shift:+.0f} Pa off, {words} the {tolerance:.0f} Pa that it may drift."
    coefficients = (former.coefficients[0] + by, *former.coefficients[1:])
    # At no pressure the transducer is at the end of its range, and its noise goes beyond.
    margin = max(10.0 * rest.std[name], 5.0 * STEP)
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
    coefficients: tuple[float, ...], covered: tuple[float, float], rest: Rest, name: str
) -> Quality:
    """Return what a curve through one point is worth: its slope is the factory's to a percent."""
    places = np.linspace(*covered, _PLACES)
    values = polynomial(coefficients, places)
    slope = np.abs(polynomial([n * c for n, c in enumerate(coefficients)][1:], places))
    here = polynomial(coefficients, np.array([rest.volts[name]]))[0]
    parts = [
        rest.uncertainty[name] * slope,
        LINEARITY * np.abs(values - here),
        1.96 * rest.std[name] * slope,
        0.5 * STEP * slope,
    ]
    line = np.polynomial.Polynomial.fit(places, values, 1)
    return Quality(
        degree=len(coefficients) - 1,
        rms=0.0,
        maximum=0.0,
        linearity=float(np.max(np.abs(values - line(places)))),
        scatter=None,
        hysteresis=None,
        hysteresis_uncertainty=None,
        return_to_zero=None,
        resolution=STEP * float(slope.max()),
        covered=(float(here), float(here)),
        places=tuple(places.tolist()),
        half_widths=tuple(np.linalg.norm(parts, axis=0).tolist()),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class BlowReading:
    """How a breath into the pitot goes on.

    Attributes
    ----------
    state : {"waiting", "blowing", "green", "reversed", "blocked", "leaking"}
        ``green`` once a breath was seen and has gone again, and stays. ``reversed``: the
        pressure fell. ``blocked``: it does not go back. ``leaking``: the static pressure rose
        with it.
    pressure, peak : float
        Now, and the highest of the breath, Pa.
    sentence : str
        For the crew; empty while there is nothing to say.
    """

    state: BlowState
    pressure: float
    peak: float
    sentence: str


_SENTENCES: Mapping[BlowState, str] = {
    "waiting": "Blow gently into the pitot.",
    "blowing": "",
    "green": "The pitot answers.",
    "reversed": "The pressure falls when you blow: the hoses of pitot and static are swapped.",
    "blocked": "The pressure stays after the breath: look for water or a kink in the hose.",
    "leaking": "The static pressure rises with the breath: a hose leaks, or two are swapped.",
}


class BlowDetector:
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
        self._cutter = StretchCutter([c.channel for c in self._curves], _LENGTH)
        self.restart()

    def restart(self) -> None:
        """Wait for another breath."""
        self._cutter.restart()
        self._state: BlowState = "waiting"
        self._pressure = self._peak = math.nan
        self._began = self._sucked = self._calm = math.nan
        self._level = self._static_before = self._static_rise = math.nan

    def feed(self, times: npt.ArrayLike, volts: Mapping[str, npt.ArrayLike]) -> None:
        """Take samples; arguments as for `calibration.rest.RestWatch.feed`."""
        for stretch in self._cutter.feed(times, volts):
            self._judge(stretch)

    @property
    def reading(self) -> BlowReading:
        """Return how it goes on."""
        return BlowReading(
            state=self._state,
            pressure=self._pressure,
            peak=self._peak,
            sentence=_SENTENCES[self._state],
        )

    def _judge(self, stretch: Stretch) -> None:
        time = stretch.number * _LENGTH
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
        if self._pressure > BREATH:
            self._state, self._began, self._peak = "blowing", time, self._pressure
            self._level = 0.0 if math.isnan(self._level) else self._level
            self._static_rise, self._calm = 0.0, math.nan
            return
        if self._pressure < -_SUCK:
            self._sucked = time if math.isnan(self._sucked) else self._sucked
            if time - self._sucked >= _LAST:
                self._state = "reversed"
            return
        self._sucked = math.nan
        self._level = _followed(self._level, self._pressure)
        self._static_before = _followed(self._static_before, static)

    def _follow_breath(self, time: float, static: float) -> None:
        self._peak = max(self._peak, self._pressure)
        if not math.isnan(static) and not math.isnan(self._static_before):
            self._static_rise = max(self._static_rise, static - self._static_before)
        if self._pressure < BREATH and math.isnan(self._calm):
            self._calm = time
        if self._pressure >= BREATH:
            self._calm = math.nan
        if self._pressure > self._level + _BACK:
            if self._state == "blowing" and time - self._began > _BLOCKED_AFTER:
                self._state = "blocked"
            return
        lasted = (time if math.isnan(self._calm) else self._calm) - self._began
        if lasted < _LAST:
            self._state, self._peak = "waiting", math.nan
        elif self._static_rise > _STATIC_MOVES:
            self._state = "leaking"
        else:
            self._state = "green"


def _followed(before: float, now: float) -> float:
    """Return what was before the breath: wind and weather, slowly followed."""
    return now if math.isnan(before) else before + 0.1 * (now - before)


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundAir:
    """The air at the field as entered.

    Attributes
    ----------
    pressure : float
        Not reduced to sea level, Pa.
    temperature : float
        K.
    """

    pressure: float
    temperature: float

    @classmethod
    def entered(
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
                f"{pressure:g} {pressure_unit} is not the pressure at a field; enter what a "
                "barometer reads there, such as 1000 hPa"
            )
        if not 233.0 <= kelvin <= 328.0:
            raise CalibrationError(
                f"{temperature:g} {temperature_unit} is no temperature to fly in; enter that of "
                "the air in the shade"
            )
        return cls(pressure=pascal, temperature=kelvin)
