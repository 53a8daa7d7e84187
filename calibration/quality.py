"""How good a calibration is, in the unit of the instrument: what a crew judges it by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from calibration.points import CalibrationPoint
from calibration.polynomial_fit import (
    CalibrationReadings,
    HysteresisFit,
    PolynomialFit,
    evaluate_polynomial,
)
from calibration.settings import CALIBRATION
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationQuality:
    """Quality of a calibration, in the unit of the certificate where nothing else is given."""

    degree: int
    """Of the curve."""
    rms: float
    max_residual: float
    """As in `calibration.polynomial_fit.PolynomialFit`."""
    linearity: float
    """Largest distance of the curve from the straight line that fits it best over the range."""
    scatter: float | None = None
    """Standard deviation of one setting about its branch: reading the protractor, mostly. None
    where the points leave no freedom to tell."""
    hysteresis: float | None = None
    """Width of the loop, by `calibration.polynomial_fit`; None where only one direction was
    measured."""
    hysteresis_uncertainty: float | None = None
    """Half width of its 95 % interval."""
    return_to_zero: float | None = None
    """How far apart the instrument shows the same zero, reached from below and from above (both by
    the curve); None where zero was not met from both sides."""
    resolution: float
    """One count of the converter where the curve is steepest."""
    covered: tuple[float, float]
    """Lowest and highest value set."""
    travel: tuple[float, float] | None = None
    """Of the surface, as far as it is known."""
    uncertainty_volts: tuple[float, ...] = ()
    """Voltages along the range, V, ascending."""
    half_widths: tuple[float, ...] = ()
    """95 % half widths of the value there, for one sample whose direction is not known: from
    scatter of the settings, play, converter, and noise where the points tell it. What all settings
    have in common, as an error of the protractor's own zero, no points can tell. Empty where
    nothing is known."""
    outliers: tuple[int, ...] = ()
    """Indices of points that do not fit the others."""

    @property
    def coverage(self) -> float | None:
        """Return the share of the travel that was covered, 0 to 1; None without a travel."""
        if self.travel is None:
            return None
        low, high = sorted(self.travel)
        covered = min(high, self.covered[1]) - max(low, self.covered[0])
        return max(covered, 0.0) / (high - low)

    @property
    def uncertainty(self) -> float | None:
        """Return the largest 95 % half width within the range; None where it is not known."""
        return max(self.half_widths) if self.half_widths else None

    def half_width(self, volts: npt.ArrayLike) -> FloatArray:
        """Return the 95 % half width of the value at volts.

        Parameters
        ----------
        volts : array_like, any shape
            V, referred to the supply of the certificate.

        Returns
        -------
        ndarray
            NaN outside the range, where nothing was measured.
        """
        v = np.asarray(volts, dtype=np.float64)
        if not self.uncertainty_volts:
            return np.full_like(v, np.nan)
        return np.interp(v, self.uncertainty_volts, self.half_widths, left=np.nan, right=np.nan)


def assess_quality(
    fit: PolynomialFit,
    readings: CalibrationReadings,
    branch_fit: HysteresisFit,
    *,
    rivals: Sequence[tuple[float, HysteresisFit]] = (),
    travel: tuple[float, float] | None = None,
    count: float,
    outliers: tuple[int, ...] = (),
) -> CalibrationQuality:
    """Judge a curve.

    Parameters
    ----------
    rivals : sequence of (float, HysteresisFit)
        Curves of the other degrees, each with the share that the evidence leaves it.
    travel : tuple of float, optional
        Of the surface, lowest and highest.
    count : float
        One count of the converter, V.
    """
    low, high = float(readings.volts.min()), float(readings.volts.max())
    volts = np.linspace(low, high, 201)
    slopes = np.abs(evaluate_slope(branch_fit.coefficients, volts))
    # The ends to the last bit, so that no voltage within the range lies outside.
    places = np.array(
        [low, *np.linspace(low, high, CALIBRATION.uncertainty_points)[1:-1].round(4), high]
    )
    known = np.isfinite(branch_fit.scatter)
    noise = float(
        np.hypot(readings.noise, count / np.sqrt(12.0) if readings.noise < count else 0.0)
    )
    width = branch_fit.hysteresis
    std = branch_fit.hysteresis_std
    return CalibrationQuality(
        degree=branch_fit.degree,
        rms=fit.rms,
        max_residual=fit.max_residual,
        linearity=linearity(branch_fit.value(volts)),
        scatter=branch_fit.scatter if known else None,
        hysteresis=None if width is None else abs(width),
        hysteresis_uncertainty=(
            None if std is None or not known else std * student_t_95(branch_fit.degrees_of_freedom)
        ),
        return_to_zero=return_to_zero(readings, branch_fit),
        resolution=float(slopes.max()) * count,
        covered=(float(readings.values.min()), float(readings.values.max())),
        travel=travel,
        uncertainty_volts=tuple(float(v) for v in places) if known else (),
        half_widths=(
            tuple(float(u) for u in compute_half_widths(branch_fit, places, noise, rivals))
            if known
            else ()
        ),
        outliers=outliers,
    )


def evaluate_slope(coefficients: tuple[float, ...], volts: FloatArray) -> FloatArray:
    """Return the slope of a curve at volts, shape (n,), unit per volt."""
    return evaluate_polynomial([power * c for power, c in enumerate(coefficients)][1:], volts)


def linearity(curve: FloatArray) -> float:
    """Return how far a curve, at equal steps of volts, leaves the straight line nearest to it.

    Nearest is the line whose largest distance is least. With the line's slope, the spread of the
    curve about it changes convexly, so that its least value can be closed in on.
    """
    steps = np.linspace(-1.0, 1.0, curve.size)

    def spread(slope: float) -> float:
        return float(np.ptp(curve - slope * steps))

    slopes = np.diff(curve) / np.diff(steps)
    low, high = float(slopes.min()), float(slopes.max())
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(40):
        inner, outer = high - golden * (high - low), low + golden * (high - low)
        if spread(inner) < spread(outer):
            high = outer
        else:
            low = inner
    return 0.5 * spread(0.5 * (low + high))


def return_to_zero(readings: CalibrationReadings, branch_fit: HysteresisFit) -> float | None:
    """Return how far apart zero is shown, reached from below and from above."""
    spacing = np.ptp(readings.values) / max(readings.settings.max(), 1.0)
    at_zero = np.abs(readings.values) <= 0.1 * spacing
    up, down = at_zero & (readings.side > 0.0), at_zero & (readings.side < 0.0)
    if not up.any() or not down.any():
        return None
    # What the curve shows, less what was set: settings need not be exactly zero.
    shown = branch_fit.value(readings.volts) - readings.values
    return float(abs(shown[down].mean() - shown[up].mean()))


def compute_half_widths(
    branch_fit: HysteresisFit,
    volts: FloatArray,
    noise: float,
    rivals: Sequence[tuple[float, HysteresisFit]] = (),
) -> FloatArray:
    """Return the 95 % half width of the value that the curve tells at volts.

    The instrument is on one branch or the other, h/2 away from the curve, and which one is not
    known when it is read; to that come the uncertainty of the branch itself, that of the choice
    of the degree (how far other degrees would lie, by their shares), and the noise of a sample.
    The half width U holds 95 % of that sum: P(|h/2 + e| < U) = 0.95, with e by Student.

    Parameters
    ----------
    branch_fit : HysteresisFit
        The curve; its scatter must be known.
    volts : ndarray, shape (n,)
        V.
    noise : float
        Standard deviation of a sample, its rounding by the converter included, V.
    rivals : sequence of (float, HysteresisFit)
        As in `assess_quality`.

    Returns
    -------
    ndarray, shape (n,)
    """
    # SciPy's special functions take a third of a second to import; no window waits for them.
    from scipy.special import stdtr

    variance = 0.5 * (branch_fit.variance(volts, 1.0) + branch_fit.variance(volts, -1.0))
    variance += (evaluate_slope(branch_fit.coefficients, volts) * noise) ** 2
    for share, rival in rivals:
        variance += share * (rival.value(volts) - branch_fit.value(volts)) ** 2
    std = np.sqrt(variance)
    apart = 0.5 * abs(branch_fit.hysteresis or 0.0)
    low = np.zeros_like(volts)
    high = apart + (student_t_95(branch_fit.degrees_of_freedom) + 1.0) * std
    scale = np.where(std > 0.0, std, 1.0)
    for _ in range(40):
        middle = 0.5 * (low + high)
        inside = stdtr(branch_fit.degrees_of_freedom, (middle - apart) / scale) - stdtr(
            branch_fit.degrees_of_freedom, (-middle - apart) / scale
        )
        enough = inside > CALIBRATION.confidence
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return np.where(std > 0.0, high, apart)


def student_t_95(freedom: float) -> float:
    """Return how many standard deviations hold 95 % on both sides together."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + 0.5 * CALIBRATION.confidence))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Calibration:
    """A curve chosen on evidence, and how good it is."""

    fit: PolynomialFit
    """The curve, midway between the branches."""
    quality: CalibrationQuality
    losses: dict[int, float]
    """Root mean square error of predicting each setting from the others, by degree, in the unit of
    the values; only degrees that could be tried."""
    branch_fit: HysteresisFit
    """The curve with its covariance."""

    @property
    def degree(self) -> int:
        return len(self.fit.coefficients) - 1

    def value(self, volts: npt.ArrayLike) -> FloatArray:
        """Return the values at volts, any shape; NaN outside the range that was measured."""
        v = np.asarray(volts, dtype=np.float64)
        inside = np.abs(v - self.branch_fit.center) <= self.branch_fit.half_range * (1.0 + 1e-12)
        return np.where(inside, evaluate_polynomial(self.fit.coefficients, v), np.nan)

    def uncertainty(self, volts: npt.ArrayLike) -> FloatArray:
        """Return the 95 % half width of the value at volts; NaN outside the range."""
        return self.quality.half_width(volts)


def collect_remarks(
    calibration: Calibration, points: Sequence[CalibrationPoint], unit: str
) -> tuple[str, ...]:
    """Return what is odd about a calibration, each with its remedy; empty where all is well."""
    quality = calibration.quality
    found = [
        f"point {index + 1} ({points[index].value:g} {unit}, {points[index].direction}) does not "
        "fit the others; repeat or delete it"
        for index in quality.outliers
    ]
    if not calibration.losses:
        found.append("too few settings to choose the fit order; take at least three")
    if not quality.half_widths:
        found.append("too few points to estimate the uncertainty; take more")
    width, std = calibration.branch_fit.hysteresis, calibration.branch_fit.hysteresis_std
    if width is None:
        found.append("hysteresis was not measured; take the settings in both directions")
    elif std is not None and width < -3.0 * std:
        found.append(
            "the voltage leads the movement; check whether the directions were noted in reverse"
        )
    if quality.coverage is not None and quality.coverage < CALIBRATION.min_coverage:
        found.append(
            f"only {100.0 * quality.coverage:.0f} % of the travel is covered; values beyond are "
            "extrapolated; take settings nearer to the ends"
        )
    return tuple(found)
