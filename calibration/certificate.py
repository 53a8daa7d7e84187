"""The calibration certificate of one instrument: volts to engineering units and back.

Within the voltages that were covered by points the curve is the fitted polynomial. Outside it
goes on straight with the slope at its end, and says so: a value there is better than none for
the person at the screen, but it is not a measurement.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime

import numpy as np
import numpy.typing as npt

from calibration.points import CalibrationPoint
from calibration.polynomial_fit import evaluate_polynomial
from calibration.quality import CalibrationQuality
from calibration.settings import CALIBRATION
from gsapp.quantities import FloatArray, channel, to_si


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Certificate:
    """How the volts of one instrument become a channel."""

    channel: str
    """Id in the vocabulary, such as ``elevator_left``."""
    unit: str
    """Unit of `points`, `coefficients`, `hysteresis`, `rms_residual`, `max_residual`."""
    coefficients: tuple[float, ...]
    """Ascending powers of volts (or what `signal_unit` says); degree 1 to 3."""
    range: tuple[float, float]
    """Lowest and highest voltage covered, V."""
    who: str
    """Who took the readings."""
    stamp: datetime
    """When, to the second."""
    points: tuple[CalibrationPoint, ...] = ()
    """The readings."""
    hysteresis: float = 0.0
    rms_residual: float = 0.0
    max_residual: float = 0.0
    """As in `calibration.polynomial_fit.PolynomialFit`."""
    excitation_voltage: float | None = None
    """Supply of the instrument while it was calibrated, V."""
    ratiometric: bool = False
    """Whether its volts follow the supply, as a potentiometer's do. A supply measured in flight
    then corrects them."""
    temperature: float | None = None
    """Of the surroundings, K."""
    instrument: str = ""
    notes: str = ""
    """What was calibrated, and what is to be known about it."""
    quality: CalibrationQuality | None = None
    """How good it is; None in files written before that was kept."""
    signal_unit: str = "V"
    """What stands here for volts: ``us`` of a servo's pulse, ``count``; `calibration.signals`."""
    si_coefficients: tuple[float, ...] = field(init=False)
    """As `coefficients`, to the SI unit of the channel."""
    end_slopes: tuple[float, float] = field(init=False)
    """Slope of the curve at either end of `range`, SI per V."""
    value_range: tuple[float, float] = field(init=False)
    """Lowest and highest value that was calibrated, in the SI unit."""

    def __post_init__(self) -> None:
        key = channel(self.channel).quantity
        offset = to_si(0.0, self.unit, key)
        factor = to_si(1.0, self.unit, key) - offset
        si = [factor * coefficient for coefficient in self.coefficients]
        si[0] += offset
        object.__setattr__(self, "si_coefficients", tuple(si))
        slope = [power * c for power, c in enumerate(si)][1:]
        ends = evaluate_polynomial(slope, np.array(self.range))
        object.__setattr__(self, "end_slopes", (float(ends[0]), float(ends[1])))
        values = evaluate_polynomial(self.si_coefficients, np.array(self.range))
        object.__setattr__(self, "value_range", (float(values.min()), float(values.max())))

    def out_of_range(self, values: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return which values lie outside what was calibrated; NaN does not.

        Parameters
        ----------
        values : array_like, any shape
            In the SI unit of the channel.
        """
        y = np.asarray(values, dtype=np.float64)
        low, high = self.padded_value_range
        return (y < low) | (y > high)

    @property
    def padded_value_range(self) -> tuple[float, float]:
        """Return `value_range` with the room that rounding takes at its ends, in the SI unit."""
        low, high = self.value_range
        slack = CALIBRATION.range_tolerance * (high - low)
        return low - slack, high + slack

    @property
    def degree(self) -> int:
        return len(self.coefficients) - 1

    def evaluate(self, volts: npt.ArrayLike, excitation: npt.ArrayLike | None = None) -> FloatArray:
        """Return the values that volts stand for.

        Parameters
        ----------
        volts : array_like, any shape
            V; NaN stays NaN.
        excitation : array_like, optional
            Supply in flight, V, of a shape that broadcasts. Counts for ratiometric instruments
            only; values that are missing or implausible (less than half or more than one and a
            half times the supply of the certificate) count as the supply of the certificate.

        Returns
        -------
        ndarray
            In the SI unit of the channel. Outside `range` the curve goes on straight; see
            `extrapolated`.
        """
        v = self._referred(volts, excitation)
        inside = np.clip(v, *self.range)
        beyond = v - inside
        slope = np.where(beyond < 0.0, *self.end_slopes)
        return evaluate_polynomial(self.si_coefficients, inside) + beyond * slope

    def extrapolated(
        self, volts: npt.ArrayLike, excitation: npt.ArrayLike | None = None
    ) -> npt.NDArray[np.bool_]:
        """Return where volts lie outside the range that was calibrated."""
        v = self._referred(volts, excitation)
        return (v < self.range[0]) | (v > self.range[1])

    def uncertainty(
        self, volts: npt.ArrayLike, excitation: npt.ArrayLike | None = None
    ) -> FloatArray:
        """Return the 95 % half width of the values that volts stand for.

        Parameters
        ----------
        volts, excitation : array_like
            As for `evaluate`.

        Returns
        -------
        ndarray
            In the SI unit of the channel. NaN outside `range`, and everywhere if the certificate
            holds no quality.
        """
        v = self._referred(volts, excitation)
        if self.quality is None:
            return np.full_like(v, np.nan)
        key = channel(self.channel).quantity
        factor = to_si(1.0, self.unit, key) - to_si(0.0, self.unit, key)
        return self.quality.half_width(v) * factor

    def volts(self, values: npt.ArrayLike, excitation: npt.ArrayLike | None = None) -> FloatArray:
        """Return the volts at which the instrument shows these values: the inverse of `evaluate`.

        Parameters
        ----------
        values : array_like, any shape
            In the SI unit of the channel.
        excitation : array_like, optional
            As for `evaluate`.

        Returns
        -------
        ndarray
            V, exact to 1e-9 V.
        """
        y = np.asarray(values, dtype=np.float64)
        low, high = self.range
        y_low, y_high = evaluate_polynomial(self.si_coefficients, np.array(self.range))
        inside = np.clip(y, min(y_low, y_high), max(y_low, y_high))
        beyond = y - inside
        at_low = (beyond < 0.0) == (y_low < y_high)
        slope = np.where(at_low, *self.end_slopes)
        result = np.clip(self._solve(inside), low, high) + beyond / slope
        return result / self._reference_ratio(excitation)

    def _referred(self, volts: npt.ArrayLike, excitation: npt.ArrayLike | None) -> FloatArray:
        return np.asarray(volts, dtype=np.float64) * self._reference_ratio(excitation)

    def _reference_ratio(self, excitation: npt.ArrayLike | None) -> FloatArray:
        if excitation is None or not self.ratiometric or self.excitation_voltage is None:
            return np.float64(1.0)  # type: ignore[return-value]
        return reference_ratio(self.excitation_voltage, np.asarray(excitation, dtype=np.float64))

    def _solve(self, y: FloatArray) -> FloatArray:
        """Invert the polynomial within the range."""
        c = self.si_coefficients
        trimmed = c if len(c) > 3 else (*c, 0.0, 0.0)[:3]
        if len(trimmed) == 4 and trimmed[3] != 0.0:
            return self._solve_cubic(y)
        c0, c1, c2 = trimmed[:3]
        if c2 == 0.0:
            return (y - c0) / c1
        # On the branch of the range the slope c1 + 2 c2 v equals sign * root.
        sign = 1.0 if sum(self.end_slopes) > 0.0 else -1.0
        root: FloatArray = np.sqrt(np.maximum(c1 * c1 - 4.0 * c2 * (c0 - y), 0.0))
        if sign * c1 > 0.0:
            return 2.0 * (y - c0) / (c1 + sign * root)
        return (sign * root - c1) / (2.0 * c2)

    def _solve_cubic(self, y: FloatArray) -> FloatArray:
        """Newton's method, held between brackets that shrink as bisection does."""
        c = self.si_coefficients
        slope_c = [power * value for power, value in enumerate(c)][1:]
        low = np.full_like(y, self.range[0])
        high = np.full_like(y, self.range[1])
        rising = sum(self.end_slopes) > 0.0
        v = 0.5 * (low + high)
        for _ in range(60):
            error = evaluate_polynomial(c, v) - y
            above = (error > 0.0) == rising
            high = np.where(above, v, high)
            low = np.where(above, low, v)
            slope = evaluate_polynomial(slope_c, v)
            step = v - error / np.where(slope == 0.0, np.inf, slope)
            bracketed = (step > low) & (step < high)
            following = np.where(bracketed, step, 0.5 * (low + high))
            following = np.where(error == 0.0, v, following)
            settled = bool(np.all(~(np.abs(following - v) > 1e-13)))
            v = following
            if settled:
                break
        return v


def reference_ratio(certified: float | FloatArray, measured: FloatArray) -> FloatArray:
    """Return certified supply / measured supply; 1 where the measured one is implausible."""
    plausible = (measured > 0.5 * certified) & (measured < 1.5 * certified)
    return certified / np.where(plausible, measured, certified)
