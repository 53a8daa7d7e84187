"""A linearization taken together in blocks: all of a filter that no noise model changes.

Samples are taken together in blocks of about 0.04 s; gusts join the states. What a block's start
does to the means of its channels and to its end follows sample by sample.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from gsapp.discrepancy.filtering.linearizing import Linearization, Motion
from gsapp.discrepancy.filtering.noise import GUST_ROWS
from gsapp.quantities import BoolArray, FloatArray

_BLOCK = 0.04
"""Length of a block, s."""
_SCALES = (1.0, 0.01, 0.01, 0.05, 0.05, 0.05, 0.02, 0.02)
"""Sizes (SI) that make the states comparable: V, alpha, beta, p, q, r, phi, theta."""
_GUST_SCALES = (1.0, 0.01, 0.01)
_ENOUGH = 0.6
"""Share of its samples that must count for a channel to count in a block."""


class Way(NamedTuple):
    """How process noise at one instant of a block comes through, for the mean dynamics.

    Attributes
    ----------
    weight : float
        s of noise that the instant stands for.
    state : ndarray, shape (n_x, n_x)
        To the state at the end of the block.
    channels : ndarray, shape (n_channels, n_x)
        To the means of the channels over the block.
    """

    weight: float
    state: FloatArray
    channels: FloatArray


class Blocks:
    """A maneuver's linearization in blocks; see the attributes of `Filter`.

    Parameters
    ----------
    linearization : Linearization
    motion : Motion
    lengths : tuple of float, optional
        Effective scale lengths of the gusts, m; without them gusts stay as they are.
    """

    def __init__(
        self, linearization: Linearization, motion: Motion, lengths: tuple[float, ...] | None
    ) -> None:
        record = linearization.record
        n_states, n = linearization.states.shape
        size = n_states + 3
        self.linearization, self.gust, self.lengths = linearization, motion.gust, lengths
        self.V = float(np.mean(linearization.states[0]))
        stepwise = np.zeros((n - 1, size, size))
        stepwise[:, :n_states, :n_states] = linearization.transition
        for place, (row, length) in enumerate(zip(GUST_ROWS, lengths or (), strict=False)):
            rate = self.V / length
            column = n_states + place
            stepwise[:, :n_states, column] = -rate * record.dt * linearization.transition[:, :, row]
            stepwise[:, column, column] = np.exp(-rate * record.dt)
        block = max(1, round(_BLOCK / record.dt))
        n_blocks = n // block
        reach = np.empty((n_blocks, block + 1, size, size))
        reach[:, 0] = np.eye(size)
        for k in range(block):
            step = stepwise[k::block][:n_blocks]
            np.matmul(step, reach[: len(step), k], out=reach[: len(step), k + 1])
            reach[len(step) :, k + 1] = reach[len(step) :, k]
        whole = n_blocks * block
        slopes = linearization.by_state[:whole].reshape(n_blocks, block, -1, n_states)
        # All samples of a block side by side: one product each.
        wide = slopes.transpose(0, 2, 1, 3).reshape(n_blocks, -1, block * n_states)
        self.by_state = wide @ reach[:, :block, :n_states].reshape(n_blocks, -1, size) / block
        counted = record.counted[:whole].reshape(n_blocks, block, -1).mean(axis=1) > _ENOUGH
        self.counted: BoolArray = counted
        self.block = block
        self.stepwise = stepwise
        self.reach = reach[:, :block]
        self.transition = np.ascontiguousarray(reach[:-1, block])

    @property
    def scales(self) -> FloatArray:
        """Return a size for each state: columns of initial states are in these units."""
        own = (1.0,) * (self.by_state.shape[2] - len(_SCALES) - len(_GUST_SCALES))
        return np.array((*_SCALES, *own, *_GUST_SCALES))

    @cached_property
    def ways(self) -> tuple[Way, ...]:
        """Return how noise at each sample of a block comes through."""
        found = self.linearization
        step, slopes = self.stepwise.mean(axis=0), found.by_state.mean(axis=0)
        return _ways(step, slopes, self.block, found.record.dt)

    @cached_property
    def mean_transition(self) -> FloatArray:
        """Return the mean transition from block to block."""
        mean: FloatArray = self.transition.mean(axis=0)
        return mean

    @cached_property
    def mean_by_state(self) -> FloatArray:
        """Return the mean of `by_state`."""
        mean: FloatArray = self.by_state.mean(axis=0)
        return mean

    @cached_property
    def reaching(self) -> FloatArray:
        """Return what rates at each sample of a block, and at the one after it, change.

        Rates run in straight lines from sample to sample, as in the residual, where half a sample's
        delay would be seen too.

        Returns
        -------
        ndarray, shape (n_blocks, block + 1, n_channels + n_x, n_states)
            The means of the channels over the block, by what is added; the state at its end, by
            what must be taken from it.
        """
        found = self.linearization
        n_states, block, dt = len(found.states), self.block, found.record.dt
        n_blocks, n_channels, n_x = self.by_state.shape
        whole = n_blocks * block
        slopes = found.by_state[:whole].reshape(n_blocks, block, n_channels, n_states)
        steps = np.zeros((whole, n_x, n_x))
        steps[: len(self.stepwise)] = self.stepwise[:whole]
        steps = steps.reshape(n_blocks, block, n_x, n_x)
        both = np.zeros((n_blocks, block + 1, n_channels + n_x, n_states))
        seen, carried = both[:, :, :n_channels], both[:, :, n_channels:]
        # Backward through the block: how later channels, and its end, depend on a sample's state.
        later = np.zeros((n_blocks, n_channels, n_x))
        end = np.broadcast_to(np.eye(n_x), (n_blocks, n_x, n_x))
        carried[:, block] = -0.5 * dt * end[:, :, :n_states]
        for sample in range(block - 1, -1, -1):
            later = later @ steps[:, sample]
            end = end @ steps[:, sample]
            share = 1.0 if sample else 0.5
            seen[:, sample] = share * dt / block * later[:, :, :n_states]
            carried[:, sample] = -share * dt * end[:, :, :n_states]
            if sample:
                seen[:, sample] += 0.5 * dt / block * slopes[:, sample]
            later[:, :, :n_states] += slopes[:, sample]
        return both

    @cached_property
    def defects(self) -> FloatArray:
        """Return by how much the model misses the motion in each step, shape (n - 1, n_x)."""
        found = self.linearization
        n_states = len(found.states)
        gone = np.vstack((found.stepped, np.zeros_like(self.gust[:, 1:])))
        by_gust = self.stepwise[:, :, n_states:] @ self.gust[:, :-1].T[:, :, None]
        gone = gone + by_gust[:, :, 0].T
        return np.ascontiguousarray((gone - np.vstack((found.states, self.gust))[:, 1:]).T)

    @cached_property
    def _zeros(self) -> FloatArray:
        return self.means(self.linearization.zeros)

    @cached_property
    def _unbiased(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        found = self.linearization
        record = found.record
        n_states, size = len(found.states), self.block
        defects = self.defects
        n_blocks, _, n_x = self.by_state.shape
        within = np.zeros((n_blocks, size + 1, n_x))
        padded = np.zeros((n_blocks * size, n_x))
        steps = np.zeros((n_blocks * size, n_x, n_x))
        last = min(len(padded), len(defects))
        padded[:last], steps[:last] = defects[:last], self.stepwise[:last]
        by_block = padded.reshape(n_blocks, size, -1)
        steps = steps.reshape(n_blocks, size, n_x, n_x)
        for k in range(size):
            carried = steps[:, k] @ within[:, k, :, None]
            within[:, k + 1] = carried[:, :, 0] + by_block[:, k]
        whole = n_blocks * size
        by_state = found.by_state[:whole].reshape(n_blocks, size, -1, n_states)
        seen = (by_state @ within[:, :size, :n_states, None])[:, :, :, 0]
        z = (record.measured - found.computed)[:whole].reshape(n_blocks, size, -1) - seen
        counted = record.counted[:whole].reshape(n_blocks, size, -1)
        z = (z * counted).sum(axis=1) / np.maximum(counted.sum(axis=1), 1)
        return z, within[:-1, size], within[:, :size]

    def residual(self, bias: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the residual, `bias` given for each channel (`Linearization.zeros`).

        Returns
        -------
        z : ndarray, shape (n_blocks, n_channels)
        b : ndarray, shape (n_blocks - 1, n_x)
        within : ndarray, shape (n_blocks, block, n_x)
            What the defects of a block's motion add up to, at its samples.
        """
        z, b, within = self._unbiased
        return (z - bias * self._zeros) * self.counted, b, within

    def means(self, history: FloatArray) -> FloatArray:
        """Return the means over the blocks of histories along the first axis."""
        whole = len(self.by_state) * self.block
        total = history[0 : whole : self.block].copy()
        for sample in range(1, self.block):
            total += history[sample : whole : self.block]
        total /= self.block
        return total


def _ways(step: FloatArray, slopes: FloatArray, block: int, dt: float) -> tuple[Way, ...]:
    """Return how noise in the middle between one sample of a block and the next comes through.

    At a sample it would be seen there wholly, and act from there on only: half a sample late.
    """
    size = len(step)
    output = np.zeros((len(slopes), size))
    output[:, : slopes.shape[1]] = slopes
    reach = [0.5 * (np.eye(size) + step)]
    for _ in range(block):
        reach.append(step @ reach[-1])
    return tuple(
        Way(
            weight=dt,
            state=reach[block - 1 - k],
            channels=sum((output @ one for one in reach[: block - 1 - k]), np.zeros_like(output))
            / block,
        )
        for k in range(block)
    )
