"""What the filter believes of noise: instruments, turbulence, and unmeasured moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gsapp.dynamics.flight_model import MODEL_INPUTS
from gsapp.identification.filter_error.equation_jacobian import CONTROLS
from gsapp.identification.filter_error.motion_linearization import ManeuverRecord
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE

GUSTS = ("u", "v", "w")
ROTATIONS = ("p", "q", "r")
"""Gusts along and about x, y, z."""
_MEDIAN_OF_NORMAL = 0.6745
_RHO = np.concatenate(([0.0], np.linspace(0.3, 0.9, 61)))
"""Correlations that are tried; what changes more slowly than the last is a bias or turbulence."""
MIN_NOISE_STD: Mapping[str, float] = {
    "V": 0.02,
    "ax": 0.01,
    "ay": 0.01,
    "an": 0.01,
    **dict.fromkeys(("alpha", "beta", "phi", "theta"), 0.005 * DEGREE),
    **dict.fromkeys(("p", "q", "r"), 0.02 * DEGREE),
}
"""No instrument is believed better than this (SI), standard deviation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel:
    """Covariances of the filter.

    Turbulence is first order: in gust g with time constant L/V, ``g' = -V/L g + w``, and the same
    white noise w drives the airspeed or flow angle. L is an effective length: Dryden's shape for
    side and up gusts has 0.7 of its scale length.
    """

    variances: Mapping[str, float]
    """Of the noise of each channel, white per sample, SI squared; of colored noise, of what each
    sample adds to it."""
    gust_intensities: tuple[float, float, float] = (FILTER_ERROR.initial_gust_intensity,) * 3
    """Intensity of the white noise behind the gusts along x, y, z, m^2/s^3."""
    gust_lengths: tuple[float, float, float] = (150.0, 60.0, 40.0)  # Effective scale lengths, m.
    moment_intensity: float = FILTER_ERROR.initial_moment_intensity
    """Intensity of white noise in p', q', r', rad^2/s^3: what no channel shows."""
    correlations: Mapping[str, float] = field(default_factory=dict)
    """Of colored noise from sample to sample, 0 to 1; channels with white noise are left out."""
    rotation_intensities: tuple[float, float, float] | None = None
    """Intensity of the white noise behind rotation of the air about x, y, z, rad^2/s^3; None: the
    air does not rotate."""
    gradient_gains: tuple[float, float] = (0.0, 0.0)
    """Share of the gradients of gusts along z and y in pitch and yaw of the air; 1 by physics."""
    roll_length: float = 1.0
    """Length over which the air rolls, of the 4b/pi of MIL-F-8785C; MIL-STD-1797A has sqrt(L_w
    b)/2.6, which is 2 to 4 times as long."""
    control_intensities: tuple[float, ...] = (0.0,) * len(CONTROLS)
    """Intensity of the noise in the measured de, da, dr, flap, throttle, rad^2 s: the model flies
    with it, the aircraft does not."""

    def block_mean_variances(self, channels: Sequence[str], block: int) -> FloatArray:
        """Return the variance of the white noise in means over blocks, shape (n_channels,).

        With colored noise little of it is white: steps of the converter.
        """
        return np.array(
            [
                self.variances[name]
                / block
                * (FILTER_ERROR.white_share if name in self.correlations else 1.0)
                for name in channels
            ]
        )

    def with_value(self, name: str, value: float) -> NoiseModel:
        """Return the model with one number changed: ``gust.w``, ``length.w``, ``moments`` ..."""
        if name == "moments":
            return replace(self, moment_intensity=value)
        kind, _, axis = name.partition(".")
        if axis in ROTATIONS:
            p, q, r = (value if own == axis else self.value(f"gust.{own}") for own in ROTATIONS)
            return replace(self, rotation_intensities=(p, q, r))
        place = GUSTS.index(axis)
        old = self.gust_intensities if kind == "gust" else self.gust_lengths
        new = tuple(value if index == place else one for index, one in enumerate(old))
        if kind == "gust":
            return replace(self, gust_intensities=(new[0], new[1], new[2]))
        return replace(self, gust_lengths=(new[0], new[1], new[2]))

    def value(self, name: str) -> float:
        """Return one of its numbers; see `with_value`."""
        if name == "moments":
            return self.moment_intensity
        kind, _, axis = name.partition(".")
        if axis in ROTATIONS:
            return (self.rotation_intensities or (0.0, 0.0, 0.0))[ROTATIONS.index(axis)]
        return (self.gust_intensities if kind == "gust" else self.gust_lengths)[GUSTS.index(axis)]

    def with_variances(self, variances: Mapping[str, float]) -> NoiseModel:
        """Return the model with other instrument noise."""
        bounded = {name: max(one, MIN_NOISE_STD[name] ** 2) for name, one in variances.items()}
        return replace(self, variances=bounded)

    @property
    def gust_shape(self) -> tuple[tuple[float, float, float], bool, tuple[float, float], float]:
        """Return what the states of gusts depend on: lengths, and how the air rotates."""
        is_rotating = self.rotation_intensities is not None
        return self.gust_lengths, is_rotating, self.gradient_gains, self.roll_length

    def rotation_rate(self, name: str, V: float, span: float) -> float:
        """Return the bandwidth (rad/s) of rotation of the air; MIL-F-8785C, section 3.7.2.

        `name`: of `ROTATIONS`; airspeed in m/s, span in m.
        """
        share = {"p": 4.0 * self.roll_length, "q": 4.0, "r": 3.0}[name]
        return np.pi * V / span / share

    def process_noise(
        self, names: Sequence[str], entries: FloatArray, moment_rows: Sequence[int]
    ) -> FloatArray:
        """Return the intensity of process noise, shape (n_moving, n_moving).

        `names`, `entries`: `GustStates.names` and `GustStates.entries`, shape (n_names, n_moving).
        `moment_rows`: states that unmeasured moments enter.
        """
        found = np.zeros((entries.shape[1],) * 2)
        for name, entry in zip(names, entries, strict=True):
            found += self.value(f"gust.{name}") * np.outer(entry, entry)
        for row in moment_rows:
            found[row, row] += self.moment_intensity
        return found

    def gust_rms(self, V: float) -> dict[str, float]:
        """Return the standard deviation (m/s) of the gusts along u, v, w at airspeed V."""
        return {
            name: float(np.sqrt(0.5 * intensity * length / V))
            for name, intensity, length in zip(
                GUSTS, self.gust_intensities, self.gust_lengths, strict=True
            )
        }

    def rotation_rms(self, V: float, span: float) -> dict[str, float]:
        """Return the standard deviation (rad/s) of rotation that gusts do not explain.

        At airspeed `V`; `span` in m.
        """
        return {
            name: float(
                np.sqrt(0.5 * self.value(f"gust.{name}") / self.rotation_rate(name, V, span))
            )
            for name in ROTATIONS
        }


def initial_noise(records: Sequence[ManeuverRecord]) -> NoiseModel:
    """Return where tuning starts: third differences of the channels, which motion leaves alone."""
    names = dict.fromkeys(name for record in records for name in record.channels)
    correlations = {name: _correlation(records, name) for name in names}
    found = {
        name: [_from_differences(record, name) for record in records if name in record.channels]
        for name in names
    }
    variances = {name: float(np.median(values)) for name, values in found.items()}
    return NoiseModel(
        variances=variances,
        control_intensities=tuple(
            float(np.median([_intensity(record, name) for record in records])) for name in CONTROLS
        ),
        correlations={
            name: one
            for name, one in correlations.items()
            if one > FILTER_ERROR.max_white_correlation
        },
    ).with_variances(variances)


def _from_differences(record: ManeuverRecord, name: str) -> float:
    """Return the variance of a channel's white noise from its third differences.

    Robust, so that the corners of an input do not count. Tones of the engines count, as the filter
    meets them: two to eight times the noise of the gyros that
    `gsapp.identification.compatibility.segments.estimate_white_noise` finds beside the tones.
    """
    column = record.channels.index(name)
    samples = np.where(record.valid[:, column], record.measured[:, column], np.nan)
    found = _third_differences(samples)
    return MIN_NOISE_STD[name] ** 2 if found is None else found


def _third_differences(samples: FloatArray) -> float | None:
    differences = np.diff(samples, 3)
    differences = differences[np.isfinite(differences)]
    if differences.size <= FILTER_ERROR.min_samples:
        return None
    size = float(np.median(np.abs(differences))) / _MEDIAN_OF_NORMAL
    # 20 = 1 + 9 + 9 + 1.
    return size * size / 20.0


def _intensity(record: ManeuverRecord, control: str) -> float:
    found = _third_differences(record.motion.inputs[:, MODEL_INPUTS.index(control)])
    return 0.0 if found is None else found * record.dt


def sample_variance(record: ManeuverRecord, name: str, correlation: float) -> float:
    """Return the variance of a channel's noise, tones of the engines included; 0 if unknown.

    From the power above the frequencies at which an aircraft moves; below, noise goes on flat, or
    as a first-order recursion with this correlation from sample to sample.
    """
    column = record.channels.index(name)
    if not record.valid[:, column].all():
        return 0.0
    power, angle = _periodogram(record.measured[:, column])
    high = angle > 2.0 * np.pi * FILTER_ERROR.max_motion_frequency * record.dt
    if high.sum() < FILTER_ERROR.min_frequencies:
        return 0.0
    shape = 1.0 + correlation**2 - 2.0 * correlation * np.cos(angle[high])
    return float((power[high] * shape).mean()) / (1.0 - correlation**2)


def _correlation(records: Sequence[ManeuverRecord], name: str) -> float:
    """Return the correlation of a channel's noise from sample to sample.

    The shape of a first-order recursion fitted (Whittle) to the periodogram above the frequencies
    at which an aircraft moves: there all is noise, or turbulence.
    """
    cost = np.zeros(len(_RHO))
    for record in records:
        column = record.channels.index(name) if name in record.channels else -1
        if column < 0 or not record.valid[:, column].all():
            continue
        power, angle = _periodogram(record.measured[:, column])
        high = angle > 2.0 * np.pi * FILTER_ERROR.max_motion_frequency * record.dt
        power, angle = power[high], angle[high]
        if len(power) < FILTER_ERROR.min_frequencies:
            continue
        shape = 1.0 + _RHO[:, None] ** 2 - 2.0 * _RHO[:, None] * np.cos(angle)
        size = (power * shape).mean(axis=1)
        cost += len(power) * np.log(size) - np.log(shape).sum(axis=1)
    return float(_RHO[int(np.argmin(cost))])


def _periodogram(samples: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return power and angle (rad a sample); tapered, so that slow motion does not leak."""
    count = len(samples)
    taper = np.hanning(count)
    slow = np.polyval(np.polyfit(np.arange(count), samples, 3), np.arange(count))
    found = np.fft.rfft((samples - slow) * taper)
    return np.abs(found) ** 2 / (taper**2).sum(), np.linspace(0.0, np.pi, len(found))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ColoredNoise:
    """The channels with colored noise, and what a block makes of it.

    With e of variance `driving_variance` from sample to sample, noise goes ``n' = rho n + e``.
    """

    channel_indices: NDArray[np.intp]  # Shape (n_colored,). Of the channels.
    driving_variance: FloatArray
    """Shape (n_colored,). Variance of what each sample adds, SI squared."""
    stds: FloatArray  # Shape (n_colored,). Standard deviation of the noise.
    variance_of_means: FloatArray  # Shape (n_colored,). Of its mean over a block.
    decay: FloatArray
    """Shape (n_colored,). Share of the noise at a block's start that is left at its end."""
    mean_share: FloatArray  # Shape (n_colored,). Share of it in the mean over the block.
    by_end: FloatArray
    by_mean: FloatArray
    """Shape (n_colored, block). Share of what the second sample of a block, the third ... and the
    one after it add, in the noise at the block's end and in the mean over it."""

    @classmethod
    def from_noise_model(
        cls, noise: NoiseModel | None, channels: Sequence[str], block: int
    ) -> ColoredNoise:
        """Return what a noise model makes of these channels in blocks of so many samples."""
        known = {} if noise is None else noise.correlations
        names = [name for name in channels if name in known]
        rho = np.array([known[name] for name in names])
        added = np.array([noise.variances[name] for name in names if noise is not None])
        powers: FloatArray = rho[:, None] ** np.arange(block + 1.0)
        # Of what comes in at sample k of a block, samples k to block - 1 show something.
        sums = np.cumsum(powers[:, :block], axis=1) / block
        by_mean = np.hstack((sums[:, :-1][:, ::-1], np.zeros((len(rho), 1))))
        shown = sums[:, -1]
        variance = added / (1.0 - rho**2)
        return cls(
            channel_indices=np.array([channels.index(name) for name in names], dtype=np.intp),
            driving_variance=added,
            stds=np.sqrt(variance),
            variance_of_means=shown**2 * variance + (by_mean**2).sum(axis=1) * added,
            decay=powers[:, block],
            mean_share=shown,
            by_end=powers[:, :block][:, ::-1],
            by_mean=by_mean,
        )
