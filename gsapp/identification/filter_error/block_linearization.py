"""A linearization taken together in blocks: all of a filter that no noise model changes.

Samples are taken together in blocks of about 0.04 s. Gusts join the states, and behind them what
late instruments are still to show. What a block's start does to the means of its channels and to
its end follows sample by sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from gsapp.dynamics.signal_terms import lag_weights
from gsapp.identification.filter_error.gust_states import MOMENT_TARGETS, GustStates
from gsapp.identification.filter_error.instrument_output import path_delay, path_lag, visible_shares
from gsapp.identification.filter_error.motion_linearization import (
    INTEGRATED_STATES,
    Linearization,
    NominalMotion,
)
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import BoolArray, FloatArray


class NoiseGain(NamedTuple):
    """How process noise at one instant of a block comes through, for the mean dynamics."""

    weight: float  # s of noise that the instant stands for.
    state_gain: FloatArray  # Shape (n_x, n_x). To the state at the end of the block.
    output_gain: FloatArray  # Shape (n_channels, n_x). To the means of the channels over the block.


@dataclass(frozen=True, slots=True, kw_only=True)
class _DelayedReading:
    """A reading that a late instrument is still to show, as a state.

    It is made, from sample to sample, of itself (`decay`) and of what goes in, then (`old`) and
    now (`new`): the channel without its path or, behind a lag or a sample of delay, another
    reading.
    """

    channel: int
    row: int
    source: int | None = None
    """Places among the states; without source the channel itself goes in."""
    decay: float = 0.0
    old: float = 1.0
    new: float = 0.0


class _DelayedInstruments:
    """The readings of all late instruments of a linearization, and what is shown of them."""

    def __init__(self, found: Linearization, first: int) -> None:
        self.readings: list[_DelayedReading] = []
        self.shown: dict[int, dict[int | None, float]] = {}
        """By channel: shares of the readings at these rows (None: of the channel itself)."""
        self._first = first
        dt = found.record.dt
        for channel, path in found.paths.items():
            tau, delay = path_lag(path), path_delay(path) / dt
            last: int | None = None
            if tau is not None:
                decay, old, new = lag_weights(tau, dt)
                last = self._add(channel, None, decay=decay, old=old, new=new)
            delay = min(max(delay, 0.0), round(FILTER_ERROR.max_delay / dt))
            for _ in range(int(delay)):
                last = self._add(channel, last)
            rest = delay - int(delay)
            self.shown[channel] = {last: 1.0 - rest}
            if rest > 0.0:
                self.shown[channel][self._add(channel, last)] = rest

    def _add(self, channel: int, source: int | None, **weights: float) -> int:
        row = self._first + len(self.readings)
        self.readings.append(_DelayedReading(channel=channel, row=row, source=source, **weights))
        return row


class BlockLinearization:
    """A maneuver's linearization in blocks; see the attributes of `SteadyStateFilter`.

    Parameters
    ----------
    noise : NoiseModel, optional
        Gives the scale lengths of the gusts and whether the air rotates; without it gusts stay as
        they are.
    """

    def __init__(
        self, linearization: Linearization, motion: NominalMotion, noise: NoiseModel | None
    ) -> None:
        record = linearization.record
        n_states, n = linearization.states.shape
        self.linearization = linearization
        self.V = linearization.speed
        self.gust_shape = None if noise is None else noise.gust_shape
        self.gusts = gusts = GustStates.create(
            record.states, n_states, self.V, record.maneuver.aircraft.geometry.span, noise
        )
        self.gust = motion.gust if len(motion.gust) == gusts.count else np.zeros((gusts.count, n))
        moved = slice(n_states, n_states + gusts.count)
        self._outputs = np.concatenate(
            (linearization.output_by_state, linearization.output_by_rotation @ gusts.rotation),
            axis=2,
        )
        self._late = _DelayedInstruments(linearization, moved.stop)
        size = moved.stop + len(self._late.readings)
        stepwise = np.zeros((n - 1, size, size))
        stepwise[:, :n_states, :n_states] = linearization.transition
        stepwise[:, moved, moved] = own = expm(gusts.rates * record.dt)
        for index, row in enumerate(gusts.rows):
            rate = gusts.rates[index, index]
            stepwise[:, :n_states, n_states + index] = (
                rate * record.dt * linearization.transition[:, :, row]
            )
        if gusts.is_rotational:
            turned = linearization.rate_by_rotation @ gusts.rotation
            stepwise[:, :n_states, moved] += (
                0.5 * record.dt * (linearization.transition @ turned[:-1] + turned[1:] @ own)
            )
        for one in self._late.readings:
            if one.source is None:
                goes_in = self._outputs[:, one.channel]
                stepwise[:, one.row, : moved.stop] = one.old * goes_in[:-1]
                stepwise[:, one.row] += (
                    one.new * (goes_in[1:, None] @ stepwise[:, : moved.stop])[:, 0]
                )
                stepwise[:, one.row, one.row] = one.decay
            else:
                stepwise[:, one.row, one.source] = 1.0
        block = max(1, round(FILTER_ERROR.block_duration / record.dt))
        n_blocks = n // block
        reach = np.empty((n_blocks, block + 1, size, size))
        reach[:, 0] = np.eye(size)
        for k in range(block):
            step = stepwise[k::block][:n_blocks]
            np.matmul(step, reach[: len(step), k], out=reach[: len(step), k + 1])
            reach[len(step) :, k + 1] = reach[len(step) :, k]
        whole = n_blocks * block
        shows = self._shows[:whole].reshape(n_blocks, block, -1, size)
        # All samples of a block side by side: one product each.
        wide = shows.transpose(0, 2, 1, 3).reshape(n_blocks, -1, block * size)
        self.by_state = wide @ reach[:, :block].reshape(n_blocks, -1, size) / block
        counted = (
            record.valid[:whole].reshape(n_blocks, block, -1).mean(axis=1)
            > FILTER_ERROR.min_valid_share
        )
        self.valid: BoolArray = counted
        self.block_size = block
        self.stepwise = stepwise
        self.state_response = reach[:, :block]
        self.transition = np.ascontiguousarray(reach[:-1, block])

    @property
    def n_states(self) -> int:
        """Return the number of states of the equations, which come first."""
        return len(self.linearization.states)

    @property
    def moment_rows(self) -> tuple[int, ...]:
        """Return the states that unmeasured moments enter."""
        names = self.linearization.record.states
        return tuple(names.index(name) for name in MOMENT_TARGETS if name in names)

    def interpolation_variance(self, process: FloatArray) -> FloatArray:
        """Return the variance in means of channels that are shown as of between two samples.

        Process noise of intensity `process`, (n_states, n_states), is not straight in between.
        """
        found, variances = self.linearization, np.zeros(len(self.linearization.record.channels))
        dt = found.record.dt
        for channel, path in found.paths.items():
            between = path_delay(path) / dt % 1.0
            if path_lag(path) is None:
                slopes = found.output_by_state[:, channel].mean(axis=0)
                intensity = float(slopes @ process @ slopes)
                variances[channel] = between * (1.0 - between) * dt * intensity / self.block_size
        return variances

    @cached_property
    def computed(self) -> FloatArray:
        """Return the channels along the motion, its gusts included, (n, n_channels)."""
        computed = self.linearization.computed
        if not self.gusts.is_rotational:
            return computed
        turned = (self.gusts.rotation @ self.gust).T[:, :, None]
        shown: FloatArray = computed + (self.linearization.output_by_rotation @ turned)[:, :, 0]
        return shown

    @cached_property
    def _shows(self) -> FloatArray:
        """Return what channels show of all states, (n, n_channels, n_x)."""
        n, n_channels, n_moved = self._outputs.shape
        shows = np.zeros((n, n_channels, len(self.scales)))
        shows[:, :, :n_moved] = self._outputs
        for channel, shares in self._late.shown.items():
            shows[:, channel] *= shares.get(None, 0.0)
            for row, share in shares.items():
                if row is not None:
                    shows[:, channel, row] = share
        return shows

    @property
    def initial_state_map(self) -> FloatArray:
        """Return all states by those of the equations and gusts, at the start, (n_x, ...)."""
        first = self._outputs[0]
        rest = np.eye(len(self.scales))[:, : first.shape[1]]
        for one in self._late.readings:
            rest[one.row] = first[one.channel]
        return rest

    @property
    def scales(self) -> FloatArray:
        """Return a size for each state: columns of initial states are in these units."""
        names = self.linearization.record.states
        sizes = dict(zip(INTEGRATED_STATES, FILTER_ERROR.state_scales, strict=True))
        polar = [sizes[name] for name in names]
        own = (1.0,) * (self.n_states - len(polar))
        late = (FILTER_ERROR.reading_scale,) * len(self._late.readings)
        return np.array((*polar, *own, *self.gusts.scales, *late))

    @cached_property
    def noise_gains(self) -> tuple[NoiseGain, ...]:
        """Return how noise in each step of a block comes through."""
        found = self.linearization
        step = self.stepwise.mean(axis=0)
        half = 0.5 * (np.eye(len(step)) + step)
        goes_in = self._outputs.mean(axis=0)
        for one in self._late.readings:
            half[one.row] = one.new * (goes_in[one.channel] @ half[: goes_in.shape[1]])
        shares = np.stack(
            [
                visible_shares(found.paths.get(channel, ()), found.record.dt, self.block_size)
                for channel in range(len(goes_in))
            ]
        )
        return _noise_gains(step, half, self._shows.mean(axis=0), shares, found.record.dt)

    @cached_property
    def rate_response(self) -> FloatArray:
        """Return what rates at each sample of a block, and at the one after it, change.

        Rates run in straight lines from sample to sample, as in the residual, where half a sample's
        delay would be seen too.

        Shape (n_blocks, block + 1, n_channels + n_x, n_states). The means of the channels over the
        block, by what is added; the state at its end, by what must be taken from it.
        """
        found = self.linearization
        n_states, block, dt = self.n_states, self.block_size, found.record.dt
        n_blocks, n_channels, n_x = self.by_state.shape
        whole = n_blocks * block
        shows = self._shows[:whole].reshape(n_blocks, block, n_channels, n_x)
        steps = np.zeros((whole, n_x, n_x))
        steps[: len(self.stepwise)] = self.stepwise[:whole]
        steps = steps.reshape(n_blocks, block, n_x, n_x)
        now, after = self._rates_into_readings()
        both = np.zeros((n_blocks, block + 1, n_channels + n_x, n_states))
        # Backward through the block: how later channels, and its end, depend on a sample's state.
        later = np.zeros((n_blocks, n_channels + n_x, n_x))
        later[:, n_channels:] = np.eye(n_x)
        ends = np.minimum(np.arange(1, n_blocks + 1) * block, len(now) - 1)
        both[:, block] = 0.5 * dt * (later[:, :, :n_states] + later @ now[ends])
        for sample in range(block - 1, -1, -1):
            places = np.arange(n_blocks) * block + sample
            lost = 0.5 * dt * (later @ after[places])
            later = later @ steps[:, sample]
            both[:, sample] = (1.0 if sample else 0.5) * dt * later[:, :, :n_states] - lost
            if sample:
                both[:, sample] += 0.5 * dt * (later @ now[places])
                both[:, sample, :n_channels] += (
                    0.5 * dt * (shows[:, sample, :, :n_states] + shows[:, sample] @ now[places])
                )
            later[:, :n_channels] += shows[:, sample]
        both[:, :, :n_channels] /= block
        both[:, :, n_channels:] *= -1.0
        return both

    def _rates_into_readings(self) -> tuple[FloatArray, FloatArray]:
        """Return what rates do to late readings beside what steps make of them.

        Returns
        -------
        now, after : ndarray, shape (n, n_x, n_states)
            Half a step of a rate is in its own sample already, and so in the reading there; the
            other half comes after it, and not in what the next reading makes of that sample.
        """
        found = self.linearization
        now = np.zeros((len(found.output_by_state), len(self.scales), self.n_states))
        after = np.zeros_like(now)
        for one in self._late.readings:
            if one.source is None:
                goes_in = found.output_by_state[:, one.channel]
                now[:, one.row], after[:, one.row] = one.new * goes_in, one.old * goes_in
        return now, after

    @cached_property
    def defects(self) -> FloatArray:
        """Return by how much the model misses the motion in each step, shape (n - 1, n_x)."""
        found = self.linearization
        n_states, n_moved = self.n_states, self.n_states + self.gusts.count
        gone = np.vstack((found.next_states, np.zeros_like(self.gust[:, 1:])))
        by_gust = self.stepwise[:, :n_moved, n_states:n_moved] @ self.gust[:, :-1].T[:, :, None]
        missed = gone + by_gust[:, :, 0].T - np.vstack((found.states, self.gust))[:, 1:]
        defects = np.zeros((missed.shape[1], len(self.scales)))
        defects[:, :n_moved] = missed.T
        for one in self._late.readings:
            goes_in = self._outputs[1:, one.channel]
            defects[:, one.row] = one.new * (goes_in * defects[:, :n_moved]).sum(axis=1)
        return defects

    @cached_property
    def _zeros(self) -> FloatArray:
        return self.block_means(self.linearization.bias_sensitivity)

    @cached_property
    def _unbiased(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        found = self.linearization
        record, size = found.record, self.block_size
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
        shows = self._shows[:whole].reshape(n_blocks, size, -1, n_x)
        seen = (shows @ within[:, :size, :, None])[:, :, :, 0]
        z = (record.measured - self.computed)[:whole].reshape(n_blocks, size, -1) - seen
        counted = record.valid[:whole].reshape(n_blocks, size, -1)
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
        return (z - bias * self._zeros) * self.valid, b, within

    def block_means(self, history: FloatArray) -> FloatArray:
        """Return the means over the blocks of histories along the first axis."""
        whole = len(self.by_state) * self.block_size
        total = history[0 : whole : self.block_size].copy()
        for sample in range(1, self.block_size):
            total += history[sample : whole : self.block_size]
        total /= self.block_size
        return total


def _noise_gains(
    step: FloatArray, half: FloatArray, output: FloatArray, shares: FloatArray, dt: float
) -> tuple[NoiseGain, ...]:
    """Return how noise in the middle between one sample of a block and the next comes through.

    At a sample it would be seen there wholly, and act from there on only: half a sample late.
    """
    block = shares.shape[1] // 2
    reach = [half]
    for _ in range(block):
        reach.append(step @ reach[-1])
    # What samples show of it: those before at once what they show, the others as it went on.
    seen = [output @ half] * block + [output @ one for one in reach[:block]]
    seen = [share[:, None] * one for share, one in zip(shares.T, seen, strict=True)]
    return tuple(
        NoiseGain(
            weight=dt,
            state_gain=reach[block - 1 - k],
            output_gain=sum(seen[block - 1 - k : 2 * block - 1 - k], np.zeros_like(output)) / block,
        )
        for k in range(block)
    )
