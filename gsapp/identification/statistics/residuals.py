"""Tests of residuals: goodness of fit, whiteness, gusts.

An output-error model flies in calm air. What a gust does is left in the residuals: the vane shows
it at once, and so, through lift or side force, does the accelerometer. Two things tell it from all
else, both between 0.5 and 4 Hz:

- the residuals of flow angle and acceleration go *together*, as C_N_alpha and C_Y_beta say. Noise
  of the two instruments, however colored, does not;
- the residuals contradict *kinematics*. The flow angle that follows from the residuals of the rates
  and of the acceleration alone, alpha' = q - a_n/V and beta' = p sin alpha - r + (a_y + g phi)/V,
  is that of a body in still air. A wrong moment or force makes the computed motion wrong, but all
  its parts alike; a gust moves the air and shows in the difference, which goes together with the
  acceleration, too.

A gust also exceeds the noise of the vane, which is measured above the band; with 10 samples a
second nothing lies there, and the band ends at 2 Hz. Where a long record makes the contradiction
certain, a weaker correlation of the forces suffices.

Tried on virtual maneuvers: the first correlation is 0.7 to 0.99 in gusts from 0.15 m/s up, and at
most 0.45 in calm air; with moments and forces left wrong the first comes to 0.75, the second to
0.4, hardly ever both.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.fft import rfft, rfftfreq
from scipy.special import chdtrc

from gsapp.identification.results import ResponseFit
from gsapp.identification.statistics.correlation import (
    STATISTICS,
    BoolArray,
    ComplexArray,
    LagLayout,
    bartlett,
    default_lags,
)
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY


def response_fit(measured: FloatArray, computed: FloatArray) -> ResponseFit:
    """Compare one response with its measurement.

    `measured` and `computed`, shape (n,): samples that are not finite in either do not count. With
    none left all is NaN; over a range of zero the percentage and r2 are NaN.
    """
    counted = np.isfinite(measured) & np.isfinite(computed)
    z, y = measured[counted], computed[counted]
    if not z.size:
        return ResponseFit(
            rms=np.nan, rms_over_range_pct=np.nan, r2=np.nan, theil=np.nan, samples=0
        )
    v = z - y
    rms = _rms(v)
    spread = float(np.ptp(z))
    about_mean = float(((z - z.mean()) ** 2).sum())
    sizes = _rms(z) + _rms(y)
    return ResponseFit(
        rms=rms,
        rms_over_range_pct=100.0 * rms / spread if spread > 0.0 else np.nan,
        r2=1.0 - float(v @ v) / about_mean if about_mean > 0.0 else np.nan,
        theil=rms / sizes if sizes > 0.0 else 0.0,
        samples=int(z.size),
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values * values)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Whiteness:
    """What the residuals of one response look like."""

    p_value: float
    """Of the portmanteau test (Ljung-Box; missing samples allowed for): the chance of such
    correlation in white residuals."""
    low_frequency_share: float
    """Share of the power below 2 Hz, where the aircraft moves and derivatives are felt."""
    white_share: float  # What that share would be for white residuals.
    inflation: float
    """Density at low frequency over that of white residuals of the same size: the number of samples
    divided by it is the effective number."""
    white: bool  # Whether the test lets it pass at 0.1 %.


def evaluate_whiteness(
    v: FloatArray, segments: Sequence[slice] | None = None, *, dt: float = 0.01
) -> tuple[Whiteness, ...]:
    """Test the residuals of each response.

    `v`, shape (n, n_responses): NaN where a sample does not count.
    `dt`: sample time, s.

    One for each response. Residuals of zero or fewer than 20 samples say nothing: p = 1.
    """
    lags = default_lags(len(v))
    layout = LagLayout(len(v), segments, lags)
    counted = np.isfinite(v)
    sums = layout.autocovariance_sums(np.where(counted, v, 0.0))
    return tuple(
        _evaluate_response(sums[:, index], counted[:, [index]], layout, dt)
        for index in range(v.shape[1])
    )


def _evaluate_response(
    sums: FloatArray, counted: BoolArray, layout: LagLayout, dt: float
) -> Whiteness:
    """Test one response by its lagged sums; which samples count has the shape (n, 1)."""
    count, lags = len(counted), layout.lags
    samples = int(counted.sum())
    edge = min(2.0 * STATISTICS.low_frequency * dt, 1.0)
    own = sums * layout.pair_normalization(counted)[:, 0, 0]
    if samples < STATISTICS.min_samples or not own[lags] > 0.0:
        return Whiteness(
            p_value=1.0, low_frequency_share=np.nan, white_share=edge, inflation=np.nan, white=True
        )
    rho = own / own[lags]
    j = np.arange(-lags, lags + 1)
    tapered = rho * bartlett(lags)
    # Ljung-Box by the means over the pairs that there are.
    after = slice(lags + 1, lags + 1 + min(STATISTICS.portmanteau_lags, lags))
    pairs = layout.pair_counts(counted)[after, 0, 0]
    mean = rho[after] / (1.0 - j[after] / count)
    statistic = (samples + 2.0) / samples * float((mean * mean * pairs).sum())
    p_value = float(chdtrc(pairs.size, statistic))
    # The density of the tapered covariance, integrated to the edge of the low band.
    share = float((tapered * edge * np.sinc(edge * j)).sum())
    return Whiteness(
        p_value=p_value,
        low_frequency_share=min(max(share, 0.0), 1.0),
        white_share=edge,
        inflation=max(float(tapered.sum()), 0.0),
        white=p_value >= STATISTICS.significance_level,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TurbulenceDetection:
    """What the residuals tell of gusts in one direction."""

    direction: Literal["vertical", "lateral"]
    detected: bool
    force_coherence: float
    """Correlation of the residuals of flow angle and acceleration, in the band."""
    gust_std: float
    """Standard deviation, in the band, of the air that moved, m/s: of Dryden gusts about half. In
    calm air it is the noise of the vane, times the speed."""

    @property
    def warning(self) -> str:
        """Return the sentence for the crew; empty where nothing was detected."""
        if not self.detected:
            return ""
        angle, force = ("alpha", "a_n") if self.direction == "vertical" else ("beta", "a_y")
        return (
            f"turbulence: the residuals of {angle} and {force} are correlated (correlation "
            f"{self.force_coherence:.2f}) as only {self.direction} gusts, here of about "
            f"{self.gust_std:.1f} m/s, do; output-error values and bounds are degraded: "
            "estimate by filter error"
        )


def detect_turbulence(
    residuals: Mapping[str, FloatArray],
    *,
    dt: float,
    V: float,
    alpha: float = 0.0,
    arms: tuple[float, float] = (0.0, 0.0),
    segments: Sequence[slice] | None = None,
) -> tuple[TurbulenceDetection, ...]:
    """Look for gusts in the residuals of one maneuver.

    Parameters
    ----------
    residuals : mapping of str to ndarray, shape (n,)
        Measured minus computed, SI, by response; NaN where a sample does not count. Vertical
        gusts take alpha, q and an, lateral ones beta, p, r and ay; with one of them missing, that
        direction is left out.
    dt : float
        s.
    V, alpha : float
        Mean airspeed (m/s) and angle of attack (rad).
    arms : tuple of float
        How far the alpha and the beta vane sit ahead of the CG, m.
    segments : sequence of slice, optional
        Stretches of contiguous samples.
    """
    found: list[TurbulenceDetection] = []
    count = next((len(values) for values in residuals.values()), 0)
    parts = [
        part
        for part in ([slice(0, count)] if segments is None else segments)
        if len(range(count)[part]) * dt >= STATISTICS.min_segment_length
    ]
    if {"alpha", "q", "an"} <= residuals.keys():
        sums = _BandPowers()
        for part in parts:
            flow, q, an = (_centered(residuals[name][part]) for name in ("alpha", "q", "an"))
            sums.add(flow + arms[0] / V * q, q - an / V, an / V, dt)
        found += sums.judge("vertical", V)
    if {"beta", "p", "r", "ay"} <= residuals.keys():
        sums = _BandPowers()
        for part in parts:
            flow, p, r, ay = (_centered(residuals[name][part]) for name in ("beta", "p", "r", "ay"))
            phi = dt * (np.cumsum(p) - 0.5 * p)
            rate = alpha * p - r + (ay + GRAVITY * phi) / V
            # Sideslip pushes into the wind: C_Y_beta < 0.
            sums.add(flow - arms[1] / V * r, rate, -ay / V, dt)
        found += sums.judge("lateral", V)
    return tuple(found)


class _BandPowers:
    """Powers and cross powers in the band, over the segments."""

    def __init__(self) -> None:
        self._flow = self._free = self._force = 0.0
        self._together = self._against = self._noise = 0.0
        self._frequencies = self._quiet_frequencies = self._parts = 0

    def add(self, flow: FloatArray, rate: FloatArray, force: FloatArray, dt: float) -> None:
        """Add a segment: flow angle, its rate by kinematics, and the force that goes with it."""
        from scipy.signal.windows import tukey  # a third of a second

        count = len(flow)
        window = tukey(count, STATISTICS.taper_share)
        frequency = rfftfreq(count, dt)
        kept = frequency >= STATISTICS.gust_band[0]
        frequency = frequency[kept]
        # Squares of these transforms add up to the variance in their band.
        size = np.sqrt(2.0 / count / (window @ window))

        def spectrum(values: FloatArray) -> ComplexArray:
            found: ComplexArray = size * rfft(values)[kept]
            return found

        seen = spectrum(window * flow)
        # Under a window that is zero at both ends: (w x)' = w x' + w' x.
        explained = spectrum(window * rate + np.gradient(window, dt) * flow)
        free = seen - explained / (2j * np.pi * frequency)
        pushed = spectrum(window * force)
        inside = frequency <= min(STATISTICS.gust_band[1], STATISTICS.max_rate_share / dt)
        quiet = frequency >= STATISTICS.noise_frequency
        self._flow += _cross_power(seen[inside], seen[inside])
        self._free += _cross_power(free[inside], free[inside])
        self._force += _cross_power(pushed[inside], pushed[inside])
        self._together += _cross_power(seen[inside], pushed[inside])
        self._against += _cross_power(free[inside], pushed[inside])
        self._noise += _cross_power(seen[quiet], seen[quiet])
        self._parts += 1
        self._frequencies += int(inside.sum())
        self._quiet_frequencies += int(quiet.sum())

    def judge(
        self, direction: Literal["vertical", "lateral"], V: float
    ) -> list[TurbulenceDetection]:
        if self._frequencies < STATISTICS.min_frequencies or not min(
            self._flow, self._free, self._force
        ):
            return []
        together = self._together / (self._flow * self._force) ** 0.5
        against = self._against / (self._free * self._force) ** 0.5
        noise = 0.0
        if self._quiet_frequencies >= STATISTICS.min_frequencies:
            noise = self._noise / self._quiet_frequencies * self._frequencies
        gust = V * (self._free / self._parts) ** 0.5
        # Of the correlation of two series with so many frequencies, over its deviation.
        sigmas = against * (2.0 * self._frequencies / max(1.0 - against**2, 1e-9)) ** 0.5
        certain = sigmas > STATISTICS.kinematic_sigmas
        return [
            TurbulenceDetection(
                direction=direction,
                detected=together > STATISTICS.min_force_coherence[certain]
                and against > STATISTICS.min_kinematic_coherence
                and self._free > STATISTICS.min_noise_ratio * noise
                and gust > STATISTICS.min_gust,
                force_coherence=together,
                gust_std=gust,
            )
        ]


def _cross_power(one: ComplexArray, other: ComplexArray) -> float:
    return float(np.sum((one.conj() * other).real))


def _centered(values: FloatArray) -> FloatArray:
    """Return residuals without their mean, zero where a sample does not count."""
    counted = np.isfinite(values)
    mean = values[counted].mean() if counted.any() else 0.0
    return np.where(counted, values - mean, 0.0)
