"""Zero-phase smoothing and differentiation, the same for both sides of an equation.

An equation that holds at every instant still holds after both of its sides went through the same
linear filter. So smoothing needs no exact passband; what spoils slopes is a filter that one side
passes and the other does not. The derivative of a signal is taken as its central difference,
which is the mean of the true derivative over two sample intervals; everything beside it is
averaged over the same two intervals by Simpson's rule (`matched`). The two then agree to
(w dt)^4/180, 5e-5 at 5 Hz and 100 samples a second, and one symmetric kernel smooths both.

Kernels have a finite reach: near a gap, a clipped stretch or the end of the record a smoothed
sample does not count, and nothing is extrapolated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import convolve1d

from gsapp.identification.preparation_settings import PREPARATION
from gsapp.quantities import FloatArray

BoolArray = npt.NDArray[np.bool_]

_SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0
_DIFFERENCE = np.array([1.0, 0.0, -1.0]) / 2.0
_CUTOFF_TIMES_WIDTH = 0.7203
"""Product of the -3 dB frequency and the whole width of a raised cosine."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Smoother:
    """A symmetric low-pass, and the differentiation that goes with it."""

    dt: float  # Sample time, s.
    cutoff: float  # Where the gain is 1/sqrt(2), Hz; infinite for no smoothing.
    kernel: FloatArray  # Shape (2 m + 1,). Raised cosine; its sum is 1.

    @property
    def stride(self) -> int:
        """Return how many samples may be passed over without losing what the kernel left."""
        return max(1, int(0.2 / (self.cutoff * self.dt)))

    @property
    def half_width(self) -> int:
        """Return on how many samples to either side a smoothed derivative depends."""
        return self.kernel.size // 2 + 1

    def simpson_average(self, signals: FloatArray) -> FloatArray:
        """Average as the central difference does (Simpson), shape as given, time first."""
        return _convolve(signals, _SIMPSON)

    def differentiate(self, signals: FloatArray) -> FloatArray:
        """Return the central difference per second, shape as given, time first."""
        return _convolve(signals, _DIFFERENCE / self.dt)

    def smooth(self, signals: FloatArray) -> FloatArray:
        """Smooth along the first axis; within `half_width` of the ends values mean nothing."""
        return _convolve(signals, self.kernel) if self.kernel.size > 1 else signals

    def white_noise(self, signals: FloatArray) -> FloatArray:
        """Return the covariance of white noise in smoothed signals, shape (k, k).

        Taken where a rigid aircraft does not move, between a quarter and nearly half of the
        sample rate, without the frequencies at which a tone stands out (engines fold there).

        `signals`, shape (n, k): `simpson_average`, not yet smoothed, none missing.
        """
        count, width = signals.shape
        frequency = np.asarray(np.fft.rfftfreq(count, self.dt), dtype=np.float64)
        high = _high_frequency_mask(frequency, self.dt)
        if count < 64 or high.sum() < 8:
            return np.zeros((width, width))
        # What Simpson's rule took of each frequency is put back.
        gain = (2.0 + np.cos(2.0 * np.pi * frequency[high] * self.dt)) / 3.0
        found = _transform(signals)[high] / gain[:, None]
        power = np.abs(found) ** 2
        quiet = (power <= 8.0 * np.median(power, axis=0)).all(axis=1)
        kept = found[quiet] if quiet.sum() >= 8 else found
        passed = float(np.sum(np.convolve(self.kernel, _SIMPSON) ** 2))
        return np.asarray(passed * (kept.T @ kept.conj()).real / len(kept), dtype=np.float64)

    def valid_samples(self, missing: BoolArray) -> BoolArray:
        """Return the samples whose smoothed values depend on no missing one, shape (n,).

        Those within `half_width` of the ends are not among them.
        """
        reach = self.half_width
        count = missing.size
        total = np.concatenate(([0], np.cumsum(missing)))
        good = np.zeros(count, dtype=bool)
        if count > 2 * reach:
            good[reach : count - reach] = total[2 * reach + 1 :] == total[: -2 * reach - 1]
        return good


def build_smoother(dt: float, cutoff: float) -> Smoother:
    """Return the smoother with this cutoff (Hz); infinite smooths nothing."""
    half = 0.5 * _CUTOFF_TIMES_WIDTH / (cutoff * dt)
    steps = np.arange(-int(np.ceil(half)) + 1, int(np.ceil(half))) if half > 1.0 else np.zeros(1)
    kernel = np.cos(0.5 * np.pi * steps / max(half, 1.0)) ** 2
    return Smoother(dt=dt, cutoff=cutoff, kernel=kernel / kernel.sum())


def _convolve(signals: FloatArray, kernel: FloatArray) -> FloatArray:
    return np.asarray(convolve1d(signals, kernel, axis=0, mode="nearest"), dtype=np.float64)


def _transform(signals: FloatArray) -> npt.NDArray[np.complex128]:
    """Return the transform after the ends are brought to zero; its square is a variance."""
    count = len(signals)
    edge = max(1, min(5, count // 4))
    first, last = signals[:edge].mean(axis=0), signals[-edge:].mean(axis=0)
    ramp = np.linspace(0.0, 1.0, count)[:, None]
    found = np.fft.rfft(signals - (first + (last - first) * ramp), axis=0)
    return np.asarray(found / np.sqrt(count), dtype=np.complex128)


def select_cutoff(signals: FloatArray, dt: float) -> float:
    """Return the frequency up to which signals stand out of their own noise, Hz.

    The noise floor of each is the median power between a quarter and nearly half of the sample
    rate, where a rigid aircraft does not move; a signal counts as seen at a frequency where its
    power, averaged over neighbors, is four times that. The signal seen furthest decides.

    `signals`, shape (n, k): rates and flow angles, none missing.
    `dt`: sample time, s.
    """
    count = len(signals)
    highest = min(PREPARATION.max_cutoff, 0.2 / dt)
    if count < 32:
        return highest
    frequency = np.asarray(np.fft.rfftfreq(count, dt), dtype=np.float64)
    power = np.abs(_transform(signals)) ** 2
    # The median of an exponential distribution is ln 2 of its mean; tones do not move it.
    floor = np.median(power[_high_frequency_mask(frequency, dt)], axis=0) / np.log(2.0)
    width = max(3, round(0.5 * count * dt))
    power = convolve1d(power, np.full(width, 1.0 / width), axis=0, mode="nearest")
    inside = frequency <= highest
    peak = np.argmax(power[inside], axis=0)
    # From the peak upwards; what stands out again further up is a tone, not motion.
    hidden = (power <= 4.0 * floor) & (np.arange(len(frequency))[:, None] >= peak)
    lost = np.where(hidden.any(axis=0), np.argmax(hidden, axis=0), len(frequency) - 1)
    seen = power[peak, np.arange(power.shape[1])] > 4.0 * floor
    return float(np.clip(frequency[lost[seen]].max(initial=0.0), PREPARATION.min_cutoff, highest))


def _high_frequency_mask(frequency: FloatArray, dt: float) -> BoolArray:
    return (frequency > 0.25 / dt) & (frequency < 0.48 / dt)


def interpolate_missing(signal: FloatArray, missing: BoolArray) -> FloatArray:
    """Return the signal with missing samples put on straight lines, shape (n,)."""
    if not missing.any() or missing.all():
        return signal
    places = np.arange(signal.size)
    return np.interp(places, places[~missing], signal[~missing])


def contiguous_slices(good: BoolArray) -> tuple[slice, ...]:
    """Return the unbroken stretches of good samples, in order."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], good, [False]))))
    return tuple(
        slice(int(start), int(stop)) for start, stop in zip(edges[::2], edges[1::2], strict=True)
    )
