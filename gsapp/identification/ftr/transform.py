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

from gsapp.identification.ftr.settings import Band
from gsapp.quantities import BoolArray, FloatArray

ComplexArray = npt.NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Transforms:
    """Running transforms after each of U blocks; M frequencies, zero first.

    Attributes
    ----------
    frequencies : ndarray, shape (M,)
        Hz: 0, spacing, 2 spacing, ...
    signals : ndarray, shape (U, M, p + 3 + 4)
        Of the p regressors qbar x; of the three targets qbar C, derivatives taken; of qbar and
        qbar t, a coefficient's constant part and its drift; of a unit pulse at the first and at
        the last valid sample, the noise of the two samples that the end terms rest on.
    correlation : ndarray, shape (U, 2 M - 1)
        K at 0, spacing, ... : the transform of the squared weights, over its value at zero.
    squared : ndarray, shape (U,)
        Sum of the squared weights, s^2.
    listened : ndarray, shape (U,)
        Effective time, s: (sum of weights)^2 over the integral of the squared weights.
    pressure : ndarray, shape (U,)
        Mean dynamic pressure, Pa.
    turning : ndarray, shape (U,)
        Mean of qbar c/2V or qbar b/2V, Pa s.
    noise : ndarray, shape (U, p)
        Variance of one sample of qbar x, from second differences; of the first, of its vane.
    end_noise : ndarray, shape (U, 3)
        Variance that the noise of the two end samples gives the targets.
    broken : ndarray of bool, shape (U, 3)
        Equations that lacked their own instrument at a sample that counted.
    """

    frequencies: FloatArray
    signals: ComplexArray
    correlation: ComplexArray
    squared: FloatArray
    listened: FloatArray
    pressure: FloatArray
    turning: FloatArray
    noise: FloatArray
    end_noise: FloatArray
    broken: BoolArray

    def part(self, moments: slice, step: int) -> Transforms:
        """Return some moments at every `step`-th frequency."""
        sums = 2 * ((len(self.frequencies) - 1) // step) * step
        return Transforms(
            frequencies=self.frequencies[::step],
            signals=self.signals[moments, ::step],
            correlation=self.correlation[moments, : sums + 1 : step],
            squared=self.squared[moments],
            listened=self.listened[moments],
            pressure=self.pressure[moments],
            turning=self.turning[moments],
            noise=self.noise[moments],
            end_noise=self.end_noise[moments],
            broken=self.broken[moments],
        )


class RunningTransform:
    """Transforms of one axis, from the first sample of a record on.

    Parameters
    ----------
    regressors : int
        p.
    band : Band
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
        band: Band,
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
        ago = dt * np.arange(-block, 1.0)
        self._slope = 2j * np.pi * self.frequencies - self._rate
        self._phases = _phases(self.frequencies, ago, self._rate)
        self._square_phases = _phases(doubled, ago, 2.0 * self._rate)
        length = block * dt
        self._marks = _complex(self._phases)
        # From one block to the next: columns of transforms, squared weights, differences.
        turn = np.exp((2j * np.pi * self.frequencies - self._rate) * length)
        square_turn = np.exp((2j * np.pi * doubled - 2.0 * self._rate) * length)
        fade = np.full(self.p + 4, np.exp(-2.0 * self._rate * length))
        self._turn = np.concatenate((np.repeat(turn, self.p + 15), square_turn, fade))
        self.start()

    def start(self) -> None:
        """Begin a record: nothing was heard yet."""
        p, count = self.p, self._count
        # One after the other: transforms by frequency, their columns qbar x, qbar, qbar t, static,
        # spun, ends of spun, 1, qbar b/2V, two pulses; squared weights; squared second differences
        # of qbar x and spun, and how many.
        self._now = np.zeros(count * (p + 15) + 2 * count - 1 + p + 4, dtype=np.complex128)
        self._broken = np.zeros(3, dtype=bool)
        self._begun = False

    def advance(self, columns: FloatArray, valid: BoolArray, running: BoolArray) -> Transforms:
        """Take in U blocks, and return the transforms after each.

        Parameters
        ----------
        columns : ndarray, shape (U, N + 1, p + 9)
            As `AxisRows.columns`, each block headed by the last row of the block before.
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
        ago = self.dt * np.arange(-self.block, 1.0)
        parts = np.empty((many, self.block + 1, p + 15))
        np.multiply(weights[:, :, np.newaxis], columns[:, :, : p + 1], out=parts[:, :, : p + 1])
        np.multiply(parts[:, :, p], ago, out=parts[:, :, p + 1])
        np.multiply(
            weights[:, :, np.newaxis], columns[:, :, p + 1 : p + 7], out=parts[:, :, p + 2 : p + 8]
        )
        spun = columns[:, :, p + 4 : p + 7]
        np.multiply(steps[:, :, np.newaxis], spun, out=parts[:, :, p + 8 : p + 11])
        parts[:, :, p + 11] = weights
        np.multiply(weights, columns[:, :, p + 7], out=parts[:, :, p + 12])
        parts[:, :, p + 13 :] = 0.0
        size, ends = count * (p + 15), count * (p + 15) + 2 * count - 1
        flat = np.empty((many, ends + p + 4), dtype=np.complex128)
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
        flat[:, ends:-1] = ((second**2) * triple[:, :, np.newaxis]).sum(axis=1) / 6.0
        flat[:, -1] = triple.sum(axis=1)
        missed = np.concatenate(
            (self._broken[np.newaxis], ((weights > 0.0)[:, :, np.newaxis] & ~running).any(axis=1))
        )
        broken: BoolArray = np.logical_or.accumulate(missed, axis=0)[1:]
        self._broken = broken[-1].copy()
        anything = np.asarray(joined.any(axis=1)).tolist()
        first: list[int] = joined.argmax(axis=1).tolist()
        last: list[int] = (self.block - joined[:, ::-1].argmax(axis=1)).tolist()

        now, turn, length = self._now, self._turn, self.block * self.dt
        table = now[:size].reshape(count, p + 15)
        for k in range(many):
            # Time counts from now: what was heard lies a block further back.
            table[:, p + 1] -= length * table[:, p]
            now *= turn
            now += flat[k]
            if anything[k]:
                if not self._begun:
                    table[:, p + 13] = self._marks[:, first[k]]
                    self._begun = True
                table[:, p + 14] = self._marks[:, last[k]]
            flat[k] = now
        return self._transforms(
            flat[:, :size].reshape(many, count, p + 15),
            flat[:, size:ends],
            flat[:, ends:].real,
            broken,
        )

    def _transforms(
        self,
        sums: ComplexArray,
        squared: ComplexArray,
        noise: FloatArray,
        broken: BoolArray,
    ) -> Transforms:
        p = self.p
        weight, total = sums[:, 0, p + 11].real, squared[:, 0].real
        heard = total > 0.0
        total, weight = np.where(heard, total, 1.0), np.where(heard, weight, 1.0)
        variance = noise[:, :-1] / np.maximum(noise[:, -1:], 1e-9)
        pulses = sums[:, :, p + 13 :]
        spun, ends = sums[:, :, p + 5 : p + 8], sums[:, :, p + 8 : p + 11]
        signals = np.empty((*sums.shape[:2], p + 7), dtype=np.complex128)
        signals[:, :, :p] = sums[:, :, :p]
        targets = signals[:, :, p : p + 3]
        np.multiply(self._slope[:, np.newaxis], spun, out=targets)
        targets += ends
        targets += sums[:, :, p + 2 : p + 5]
        signals[:, :, p + 3 : p + 5] = sums[:, :, p : p + 2]
        signals[:, :, p + 5 :] = pulses
        return Transforms(
            frequencies=self.frequencies,
            signals=signals,
            correlation=squared / total[:, np.newaxis],
            squared=np.where(heard, total, 0.0),
            # With equal weights the sum of their squares is dt T: this is the length of the record.
            listened=np.where(heard, self.dt * weight**2 / total, 0.0),
            pressure=sums[:, 0, p].real / weight,
            turning=sums[:, 0, p + 12].real / weight,
            noise=variance[:, :p],
            end_noise=variance[:, p:] * (np.abs(pulses[:, 0]) ** 2).sum(axis=1)[:, np.newaxis],
            broken=broken,
        )

    # --- saved state ----------------------------------------------------------------------------

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return all that is remembered, for `restore`."""
        return {
            "now": self._now,
            "broken": self._broken,
            "begun": np.array(self._begun),
        }

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Go on from what `state` gave."""
        self._now = np.array(state["now"], dtype=np.complex128)
        self._broken = np.array(state["broken"], dtype=bool)
        self._begun = bool(state["begun"])


def _phases(frequencies: FloatArray, ago: FloatArray, rate: float) -> FloatArray:
    """Return faded cosines over faded minus-sines, shape (2 M, N + 1): a real matrix is faster."""
    turned = np.exp(np.outer(-2j * np.pi * frequencies, ago) + rate * ago)
    return np.concatenate((turned.real, turned.imag))


def _complex(stacked: FloatArray) -> ComplexArray:
    """Return the complex numbers whose parts lie one over the other on the last axis but one."""
    half = stacked.shape[-2] // 2
    return np.asarray(stacked[..., :half, :] + 1j * stacked[..., half:, :])
