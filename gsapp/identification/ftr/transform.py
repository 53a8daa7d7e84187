"""Running Fourier transforms of the signals of one axis, block by block.

Sums go over intervals between neighboring valid samples (trapezoids), in fixed blocks of samples
that lie at absolute places on the grid, so that nothing depends on how samples arrived. Phases
are taken relative to *now*, the last sample of the block: from one block to the next a transform
is turned, faded and added to,

    X <- X exp(j w B - B/tau) + sum over the block,      B = block length, s,

which is (8.1.18) times a phase that cancels in the regression. The transform of a derivative is

    (j w - 1/tau) Z + sum over intervals of [z_i phi_i - z_(i-1) phi_(i-1)],

where all but the ends of each unbroken stretch cancel: gaps contribute nothing, and every stretch
has its own end terms.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.settings import FrequencyBand
from gsapp.quantities import BoolArray, FloatArray

ComplexArray = npt.NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Transforms:
    """Running transforms after each of U blocks; M frequencies, zero first."""

    frequencies: FloatArray
    """Shape (M,). Hz: 0, spacing, 2 spacing, ..."""
    signals: FloatArray
    """Shape (U, 2, M, p + 3 + 4). Real over imaginary parts. Of the p regressors qbar x; of the
    three targets qbar C, derivatives taken; of qbar and qbar t, a coefficient's constant part and
    its drift; of a unit pulse at the first and at the last valid sample, the noise of the two
    samples that the end terms rest on."""
    correlation: ComplexArray
    """Shape (U, 2 M - 1). K at 0, spacing, ... : the transform of the squared weights, over its
    value at zero."""
    squared: FloatArray
    """Shape (U,). Sum of the squared weights, s^2."""
    effective_time: FloatArray
    """Shape (U,). Effective time, s: (sum of weights)^2 over the integral of the squared
    weights."""
    mean_pressure: FloatArray
    """Shape (U,). Mean dynamic pressure, Pa."""
    mean_rate_scale: FloatArray
    """Shape (U,). Mean of qbar c/2V or qbar b/2V, Pa s."""
    noise: FloatArray
    """Shape (U, p). Variance of one sample of qbar x, from second differences; of the first, of its
    vane."""
    end_noise: FloatArray
    """Shape (U, 3). Variance that the noise of the two end samples gives the targets."""
    lost_instrument: BoolArray
    """Shape (U, 3). Equations that lacked their own instrument at a sample that counted."""

    def select_moments(self, moments: slice, step: int) -> Transforms:
        """Return some moments at every `step`-th frequency."""
        sums = 2 * ((len(self.frequencies) - 1) // step) * step
        return Transforms(
            frequencies=self.frequencies[::step],
            signals=self.signals[moments, :, ::step],
            correlation=self.correlation[moments, : sums + 1 : step],
            squared=self.squared[moments],
            effective_time=self.effective_time[moments],
            mean_pressure=self.mean_pressure[moments],
            mean_rate_scale=self.mean_rate_scale[moments],
            noise=self.noise[moments],
            end_noise=self.end_noise[moments],
            lost_instrument=self.lost_instrument[moments],
        )


class RunningTransform:
    """Transforms of one axis, from the first sample of a record on.

    Parameters
    ----------
    regressors : int
        p.
    spacing : float
        Hz.
    forgetting : float or None
        tau, s.
    dt : float
        Sample time, s.
    block : int
        Samples of a block, N.
    """

    def __init__(
        self,
        regressors: int,
        band: FrequencyBand,
        spacing: float,
        forgetting: float | None,
        dt: float,
        block: int,
    ) -> None:
        self.p, self.dt, self.block = regressors, dt, block
        highest = min(band.highest, 0.4 / dt)
        # A hair of slack: 2.0 / 0.1 must count as twenty.
        self._count = int(np.floor(highest / spacing + 1e-9)) + 1
        self.frequencies: FloatArray = spacing * np.arange(float(self._count))
        # Squared weights are needed at sums of frequencies, too.
        doubled: FloatArray = spacing * np.arange(2.0 * self._count - 1.0)
        self._rate = 0.0 if forgetting is None else 1.0 / forgetting
        self._ago = ago = dt * np.arange(-block, 1.0)
        self._slope = 2j * np.pi * self.frequencies - self._rate
        self._phases = _phases(self.frequencies, ago, self._rate)
        self._square_phases = _phases(doubled, ago, 2.0 * self._rate)
        length = block * dt
        self._marks = _complex(self._phases)
        # From one block to the next: columns of transforms, squared weights, squared differences,
        # sums at zero frequency.
        turn = np.exp((2j * np.pi * self.frequencies - self._rate) * length)
        square_turn = np.exp((2j * np.pi * doubled - 2.0 * self._rate) * length)
        fade = np.exp(-self._rate * length * np.array([2.0] * (self.p + 4) + [1.0] * 2))
        self._turn = np.concatenate((np.repeat(turn, self.p + 13), square_turn, fade))
        self.start_record()

    def start_record(self) -> None:
        """Begin a record: nothing was heard yet."""
        p, count = self.p, self._count
        # One after the other: transforms by frequency, their columns qbar x, static, qbar, qbar t,
        # two pulses, spun, ends of spun; squared weights; squared second differences of qbar x and
        # spun, and how many; weights and qbar b/2V, summed.
        self._now = np.zeros(count * (p + 13) + 2 * count - 1 + p + 6, dtype=np.complex128)
        self._broken = np.zeros(3, dtype=bool)
        self._begun = False

    def advance(self, columns: FloatArray, valid: BoolArray, running: BoolArray) -> Transforms:
        """Take in U blocks, and return the transforms after each.

        Parameters
        ----------
        columns : ndarray, shape (U, N + 1, p + 9)
            As `RegressionRows.columns`, each block headed by the last row of the block before.
        valid : ndarray of bool, shape (U, N + 1)
        running : ndarray of bool, shape (U, N + 1, 3)
        """
        p, count = self.p, self._count
        many = len(columns)
        joined: BoolArray = np.asarray(valid[:, 1:] & valid[:, :-1], dtype=bool)
        weights = np.zeros(valid.shape)
        steps = np.zeros(valid.shape)
        half = 0.5 * self.dt * joined
        weights[:, 1:] += half
        weights[:, :-1] += half
        steps[:, 1:] += joined
        steps[:, :-1] -= joined
        spun = columns[:, :, p + 4 : p + 7]
        parts = np.empty((many, self.block + 1, p + 13))
        heavy = weights[:, :, np.newaxis]
        np.multiply(heavy, columns[:, :, : p + 4], out=parts[:, :, : p + 4])
        np.multiply(parts[:, :, p + 3], self._ago, out=parts[:, :, p + 4])
        parts[:, :, p + 5 : p + 7] = 0.0
        np.multiply(heavy, spun, out=parts[:, :, p + 7 : p + 10])
        np.multiply(steps[:, :, np.newaxis], spun, out=parts[:, :, p + 10 :])
        size = count * (p + 13)
        ends = size + 2 * count - 1
        flat = np.empty((many, ends + p + 6), dtype=np.complex128)
        summed = self._phases @ parts
        flat[:, :size].real = summed[:, :count].reshape(many, -1)
        flat[:, :size].imag = summed[:, count:].reshape(many, -1)
        squares = (self._square_phases @ (weights**2)[:, :, np.newaxis])[:, :, 0]
        flat[:, size:ends].real = squares[:, : ends - size]
        flat[:, size:ends].imag = squares[:, ends - size :]
        # The rates, which move a flow angle to the CG, bring the shaking of the gyros into it.
        watched = np.concatenate((columns[:, :, p + 8 :], columns[:, :, 1:p], spun), axis=2)
        second = watched[:, 2:] - 2.0 * watched[:, 1:-1] + watched[:, :-2]
        triple: BoolArray = np.asarray(joined[:, 1:] & joined[:, :-1], dtype=bool)
        flat[:, ends:-3] = ((second**2) * triple[:, :, np.newaxis]).sum(axis=1) / 6.0
        flat[:, -3] = triple.sum(axis=1)
        fading = weights * self._phases[0]
        flat[:, -2] = fading.sum(axis=1)
        flat[:, -1] = (fading * columns[:, :, p + 7]).sum(axis=1)
        missed = np.concatenate(
            (self._broken[np.newaxis], ((weights > 0.0)[:, :, np.newaxis] & ~running).any(axis=1))
        )
        broken: BoolArray = np.logical_or.accumulate(missed, axis=0)[1:]
        self._broken = broken[-1].copy()
        self._accumulate(flat, joined)
        return self._transforms(
            flat[:, :size].reshape(many, count, p + 13),
            flat[:, size:ends],
            flat[:, ends:].real,
            broken,
        )

    def _accumulate(self, flat: ComplexArray, joined: BoolArray) -> None:
        """Turn what single blocks say into what the record says after each."""
        p, count, length = self.p, self._count, self.block * self.dt
        anything = joined.any(axis=1)
        heard = np.asarray(anything).tolist()
        first = joined.argmax(axis=1)
        last = self.block - joined[:, ::-1].argmax(axis=1)
        now, turned = self._now, np.empty_like(self._now)
        size = count * (p + 13)
        table = turned[:size].reshape(count, p + 13)
        trim, drift, ending = table[:, p + 3], table[:, p + 4], table[:, p + 6]
        further = np.empty_like(trim)
        pulses = flat[:, :size].reshape(-1, count, p + 13)[:, :, p + 5 : p + 7]
        here = np.flatnonzero(anything)
        pulses[here, :, 1] = self._marks[:, last[here]].T
        for k, own in enumerate(flat):
            np.multiply(now, self._turn, out=turned)
            # Time counts from now: what was heard lies a block further back.
            np.multiply(trim, length, out=further)
            drift -= further
            if heard[k]:
                ending[:] = 0.0  # there is a later one
            now = np.add(own, turned, out=own)
            if heard[k] and not self._begun:
                pulses[k, :, 0] = self._marks[:, first[k]]
                self._begun = True
        self._now = now.copy()

    def _transforms(
        self,
        sums: ComplexArray,
        squared: ComplexArray,
        noise: FloatArray,
        broken: BoolArray,
    ) -> Transforms:
        p = self.p
        weight, total = noise[:, -2], squared[:, 0].real
        heard = total > 0.0
        total, weight = np.where(heard, total, 1.0), np.where(heard, weight, 1.0)
        variance = noise[:, :-3] / np.maximum(noise[:, -3:-2], 1e-9)
        targets = self._slope[:, np.newaxis] * sums[:, :, p + 7 : p + 10]
        targets += sums[:, :, p + 10 :]
        targets += sums[:, :, p : p + 3]
        signals = np.empty((len(sums), 2, self._count, p + 7))
        signals[:, 0], signals[:, 1] = sums[:, :, : p + 7].real, sums[:, :, : p + 7].imag
        signals[:, 0, :, p : p + 3], signals[:, 1, :, p : p + 3] = targets.real, targets.imag
        ends = (np.abs(sums[:, 0, p + 5 : p + 7]) ** 2).sum(axis=1)
        return Transforms(
            frequencies=self.frequencies,
            signals=signals,
            correlation=squared / total[:, np.newaxis],
            squared=np.where(heard, total, 0.0),
            # With equal weights the sum of their squares is dt T: this is the length of the record.
            effective_time=np.where(heard, self.dt * weight**2 / total, 0.0),
            mean_pressure=signals[:, 0, 0, p + 3] / weight,
            mean_rate_scale=noise[:, -1] / weight,
            noise=variance[:, :p],
            end_noise=variance[:, p:] * ends[:, np.newaxis],
            lost_instrument=broken,
        )

    # --- saved state ----------------------------------------------------------------------------

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {
            "now": self._now,
            "broken": self._broken,
            "begun": np.array(self._begun),
        }

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self._now = np.array(state["now"], dtype=np.complex128)
        self._broken = np.array(state["broken"], dtype=bool)
        self._begun = bool(state["begun"])


def _phases(frequencies: FloatArray, ago: FloatArray, rate: float) -> FloatArray:
    turned = np.exp(np.outer(-2j * np.pi * frequencies, ago) + rate * ago)
    return np.concatenate((turned.real, turned.imag))


def _complex(stacked: FloatArray) -> ComplexArray:
    half = stacked.shape[-2] // 2
    return np.asarray(stacked[..., :half, :] + 1j * stacked[..., half:, :])
