"""The steady-state filter of one maneuver, and signals seen through it.

Samples are taken together in blocks of about 0.04 s: the filter predicts from one block to the
next and compares the means of the channels over it, which costs no information at the frequencies
at which an aircraft moves. With the filter's gain K, deviations dx of the states from the motion
that the model was linearized along obey, between predictions,

    dx[k+1] = Phi_k (1 - K C_k) dx[k] + Phi_k K z[k] + b[k],     innovation = z[k] - C_k dx[k],

for the residual (z: measured minus computed, b: minus the defect of the motion) and for the
change that a parameter makes (z: its part in the channels, b: minus its part in the rates) alike.
Within blocks both are carried from sample to sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solve_discrete_are, solve_discrete_lyapunov
from scipy.linalg.lapack import dtbtrs

from gsapp.discrepancy.filtering.linearizing import Linearization, Motion
from gsapp.discrepancy.filtering.noise import GUST_ROWS, NoiseModel
from gsapp.foundation import FlightError
from gsapp.quantities import BoolArray, FloatArray

_BLOCK = 0.04
"""Length of a block, s."""
_SCALES = (1.0, 0.01, 0.01, 0.05, 0.05, 0.05, 0.02, 0.02)
"""Sizes (SI) that make the states comparable: V, alpha, beta, p, q, r, phi, theta."""
_GUST_SCALES = (1.0, 0.01, 0.01)
_MANY = 6
_ENOUGH = 0.6
"""Share of its samples that must count for a channel to count in a block."""
_LEAST = 1e-9
"""Process noise that every state has, in units of the scales squared per second."""


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Filter:
    """The filter of one maneuver.

    Attributes
    ----------
    linearization : Linearization
    gust : ndarray, shape (3, n)
    block : int
        Samples taken together.
    stepwise : ndarray, shape (n - 1, n_x, n_x)
        Transitions from sample to sample, the gusts among the n_x = n_states + 3 states.
    reach : ndarray, shape (n_blocks, block, n_x, n_x)
        Transitions from the start of each block to its samples.
    transition : ndarray, shape (n_blocks - 1, n_x, n_x)
        From block to block.
    propagation : ndarray, shape (n_blocks - 1, n_x, n_x)
        Phi (1 - K C).
    injection : ndarray, shape (n_blocks - 1, n_x, n_channels)
        Phi K, zero for channels that do not count in a block.
    by_state : ndarray, shape (n_blocks, n_channels, n_x)
        Of the block's mean channels, by the state at its start.
    counted : ndarray of bool, shape (n_blocks, n_channels)
    whitener : ndarray, shape (n_channels, n_channels)
        Turns innovations into uncorrelated ones of unit variance.
    log_size : float
        Logarithm of the determinant of the innovations' covariance.
    covariance : ndarray, shape (n_channels, n_channels)
        Of the innovations.
    mean_injection : ndarray, shape (n_x, n_channels)
        For the mean dynamics.
    ways : tuple of Way
    """

    linearization: Linearization
    gust: FloatArray
    block: int
    stepwise: FloatArray
    reach: FloatArray
    transition: FloatArray
    propagation: FloatArray
    injection: FloatArray
    by_state: FloatArray
    counted: BoolArray
    whitener: FloatArray
    log_size: float
    covariance: FloatArray
    mean_injection: FloatArray
    ways: tuple[Way, ...]

    @property
    def span(self) -> float:
        """Return the length of a block, s."""
        return self.block * self.linearization.record.dt

    @property
    def scales(self) -> FloatArray:
        """Return a size for each state: columns of initial states are in these units."""
        return _scales(self.by_state.shape[2])

    def means(self, history: FloatArray) -> FloatArray:
        """Return the means over the blocks of histories along the first axis."""
        return _means(history, self.block)

    def residual(self, bias: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the residual, `bias` given for each channel.

        Returns
        -------
        z : ndarray, shape (n_blocks, n_channels)
        b : ndarray, shape (n_blocks - 1, n_x)
        within : ndarray, shape (n_blocks, block, n_x)
            What the defects of a block's motion add up to, at its samples.
        """
        found = self.linearization
        record = found.record
        n_states, size = len(found.states), self.block
        gone = np.vstack((found.stepped, np.zeros_like(self.gust[:, 1:])))
        gone = gone + np.einsum("kij,jk->ik", self.stepwise[:, :, n_states:], self.gust[:, :-1])
        defects = (gone - np.vstack((found.states, self.gust))[:, 1:]).T
        n_blocks = len(self.by_state)
        within = np.zeros((n_blocks, size + 1, self.by_state.shape[2]))
        padded = np.zeros((n_blocks * size, within.shape[2]))
        steps = np.zeros((n_blocks * size, *self.stepwise.shape[1:]))
        last = min(len(padded), len(defects))
        padded[:last], steps[:last] = defects[:last], self.stepwise[:last]
        padded = padded.reshape(n_blocks, size, -1)
        steps = steps.reshape(n_blocks, size, *steps.shape[1:])
        for k in range(size):
            within[:, k + 1] = np.einsum("nij,nj->ni", steps[:, k], within[:, k]) + padded[:, k]
        whole = n_blocks * size
        z = record.measured - found.computed - bias
        by_state = found.by_state[:whole].reshape(n_blocks, size, *found.by_state.shape[1:])
        seen = np.einsum("nkyj,nkj->nky", by_state, within[:, :size, :n_states])
        z = z[:whole].reshape(n_blocks, size, -1) - seen
        counted = record.counted[:whole].reshape(n_blocks, size, -1)
        z = (z * counted).sum(axis=1) / np.maximum(counted.sum(axis=1), 1)
        return z * self.counted, within[:-1, size], within[:, :size]

    def innovations(
        self, z: FloatArray, b: FloatArray, start: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return innovations and deviations of many signals.

        Parameters
        ----------
        z : ndarray, shape (n_blocks, n_channels, m)
        b : ndarray, shape (n_blocks - 1, n_x, m)
        start : ndarray, shape (n_x, m), optional
            Deviation at the first sample.

        Returns
        -------
        innovations : ndarray, shape (n_blocks, n_channels, m)
            Zero for what does not count.
        deviations : ndarray, shape (n_blocks, n_x, m)
        """
        n, _, m = z.shape
        rows = np.zeros((n, self.by_state.shape[2], m))
        np.matmul(self.injection, z[:-1], out=rows[1:])
        rows[1:] += b
        if start is not None:
            rows[0] = start
        deviations = solve_forward(self.propagation, rows)
        found = z - self.by_state @ deviations
        if not self.counted.all():
            found *= self.counted[:, :, None]
        return found, deviations

    def adjoints(self, innovations: FloatArray) -> tuple[list[FloatArray], FloatArray]:
        """Return what the smoother makes of the innovations (Bryson and Frazier).

        Parameters
        ----------
        innovations : ndarray, shape (n_blocks, n_channels)

        Returns
        -------
        process : list of ndarray, shape (n_blocks - 1, n_x)
            For each of `ways`: the intensity of the process noise times this is its smoothed
            value, block by block.
        measurement : ndarray, shape (n_blocks, n_channels)
            Variance of the measurement noise times this is its smoothed value.
        """
        precision = self.whitener.T @ self.whitener
        weighted = innovations @ precision
        rows = np.einsum("nyx,ny->nx", self.by_state, weighted)
        # Backward in time: reversed, with transposed propagation.
        backward = np.ascontiguousarray(self.propagation[::-1].transpose(0, 2, 1))
        adjoint = solve_forward(backward, rows[::-1, :, None].copy())[::-1, :, 0]
        measurement = weighted.copy()
        measurement[:-1] -= np.einsum("kxy,kx->ky", self.injection, adjoint[1:])
        process = [adjoint[1:] @ way.state + measurement[:-1] @ way.channels for way in self.ways]
        return process, measurement

    def expected(self) -> tuple[list[FloatArray], FloatArray]:
        """Return the covariances of `adjoints` where the noise model holds."""
        precision = self.whitener.T @ self.whitener
        M = self.propagation.mean(axis=0)
        C = self.by_state.mean(axis=0)
        J = self.mean_injection
        scales = self.scales
        C_s, M_s = C * scales, M * scales / scales[:, None]
        state = solve_discrete_lyapunov(M_s.T, C_s.T @ precision @ C_s, method="direct")
        state = state / scales[:, None] / scales
        measurement = precision + J.T @ state @ J
        process = []
        for _, N, O in self.ways:  # noqa: E741
            crossed = N.T @ state @ J @ O
            process.append(N.T @ state @ N - crossed - crossed.T + O.T @ measurement @ O)
        return process, measurement


def filter_of(linearization: Linearization, noise: NoiseModel | None, motion: Motion) -> Filter:
    """Return the filter for a linearized maneuver; without noise model, none: output error."""
    record = linearization.record
    n_states, n = linearization.states.shape
    size = n_states + 3
    stepwise = np.zeros((n - 1, size, size))
    stepwise[:, :n_states, :n_states] = linearization.transition
    V = float(np.mean(linearization.states[0]))
    if noise is not None:
        for place, (row, length) in enumerate(zip(GUST_ROWS, noise.lengths, strict=True)):
            rate = V / length
            column = n_states + place
            stepwise[:, :n_states, column] = -rate * record.dt * linearization.transition[:, :, row]
            stepwise[:, column, column] = np.exp(-rate * record.dt)
    block = max(1, round(_BLOCK / record.dt))
    n_blocks = n // block
    reach = np.empty((n_blocks, block + 1, size, size))
    reach[:, 0] = np.eye(size)
    for k in range(block):
        step = stepwise[k::block][:n_blocks]
        reach[: len(step), k + 1] = step @ reach[: len(step), k]
        reach[len(step) :, k + 1] = reach[len(step) :, k]
    whole = n_blocks * block
    slopes = linearization.by_state[:whole].reshape(n_blocks, block, -1, n_states)
    by_state = np.einsum("nkyj,nkji->nyi", slopes, reach[:, :block, :n_states]) / block
    counted = record.counted[:whole].reshape(n_blocks, block, -1).mean(axis=1) > _ENOUGH
    transition = np.ascontiguousarray(reach[:-1, block])
    if noise is None:
        gain = within = np.zeros((size, len(record.channels)))
        covariance = np.eye(len(record.channels))
        ways: tuple[Way, ...] = ()
    else:
        ways = _ways(stepwise.mean(axis=0), linearization.by_state.mean(axis=0), block, record.dt)
        gain, within, covariance = _gain(
            transition, by_state, noise, record.channels, ways, block, V
        )
    injection = (transition @ gain + within) * counted[:-1, None, :]
    lower = np.linalg.cholesky(covariance)
    return Filter(
        linearization=linearization,
        gust=motion.gust,
        block=block,
        stepwise=stepwise,
        reach=reach[:, :block],
        transition=transition,
        propagation=transition - injection @ by_state[:-1],
        injection=injection,
        by_state=by_state,
        counted=counted,
        whitener=np.linalg.inv(lower),
        log_size=2.0 * float(np.log(np.diag(lower)).sum()),
        covariance=covariance,
        ways=ways,
        mean_injection=transition.mean(axis=0) @ gain + within,
    )


def _ways(step: FloatArray, slopes: FloatArray, block: int, dt: float) -> tuple[Way, ...]:
    """Return how noise at each sample of a block, ends counted half, comes through."""
    size = len(step)
    output = np.zeros((len(slopes), size))
    output[:, : slopes.shape[1]] = slopes
    powers = [np.eye(size)]
    for _ in range(block):
        powers.append(step @ powers[-1])
    ways = []
    for k in range(block + 1):
        seen = sum((output @ powers[later] for later in range(block - k)), np.zeros_like(output))
        weight = 0.5 * dt if k in (0, block) else dt
        ways.append(Way(weight=weight, state=powers[block - k], channels=seen / block))
    return tuple(ways)


def _means(history: FloatArray, block: int) -> FloatArray:
    whole = len(history) - len(history) % block
    parts = history[:whole].reshape(whole // block, block, *history.shape[1:])
    means: FloatArray = parts.mean(axis=1)
    return means


def _scales(size: int) -> FloatArray:
    own = (1.0,) * (size - 11)
    return np.array((*_SCALES, *own, *_GUST_SCALES))


def _gain(
    transition: FloatArray,
    by_state: FloatArray,
    noise: NoiseModel,
    channels: tuple[str, ...],
    ways: tuple[Way, ...],
    block: int,
    V: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return steady gain, what noise within a block adds to it, and the innovations' covariance.

    Process noise of a block is seen in the means over that block already.
    """
    scales = _scales(transition.shape[1])
    A = transition.mean(axis=0) / scales[:, None] * scales
    C = by_state.mean(axis=0) * scales
    R = np.diag([noise.variances[name] / block for name in channels])
    Q = noise.process(V, len(scales) - 3) / scales[:, None] / scales
    # Channels in units of their noise: the equation is badly scaled otherwise.
    units = np.sqrt(np.diag(R))
    C, R = C / units[:, None], np.eye(len(channels))
    scaled = [
        (way.weight, way.state / scales[:, None] * scales, way.channels * scales / units[:, None])
        for way in ways
    ]
    for least in (_LEAST, 1e3 * _LEAST, 1e6 * _LEAST):
        own = Q + least * np.eye(len(scales))
        arrived = sum(weight * N @ own @ N.T for weight, N, _ in scaled)
        shared = sum(weight * N @ own @ O.T for weight, N, O in scaled)  # noqa: E741
        noise_of_means = R + sum(weight * O @ own @ O.T for weight, _, O in scaled)  # noqa: E741
        try:
            P = solve_discrete_are(A.T, C.T, arrived, noise_of_means, s=shared)
            break
        except (LinAlgError, ValueError):
            continue
    else:
        raise FlightError("the fit of a model ran away; refuse the effect, or check the data")
    covariance = C @ P @ C.T + noise_of_means
    covariance = 0.5 * (covariance + covariance.T)
    gain = np.linalg.solve(covariance, C @ P).T
    within = np.linalg.solve(covariance, shared.T).T
    return (
        scales[:, None] * gain / units,
        scales[:, None] * within / units,
        covariance * units[:, None] * units,
    )


def solve_forward(propagation: FloatArray, rows: FloatArray) -> FloatArray:
    """Solve d[0] = b[0], d[k+1] - M_k d[k] = b[k+1].

    Parameters
    ----------
    propagation : ndarray, shape (n - 1, n_x, n_x)
    rows : ndarray, shape (n, n_x, m)
        Right-hand sides; overwritten with the solution, which is returned.
    """
    steps, size, _ = propagation.shape
    n, _, m = rows.shape
    if m > _MANY:
        # With many right-hand sides a product a step is quicker than the banded solver.
        for k in range(steps):
            rows[k + 1] += propagation[k] @ rows[k]
        return rows
    band = np.zeros((n, size, 2 * size))
    for i in range(size):
        for j in range(size):
            band[:-1, j, size + i - j] = -propagation[:, i, j]
    flat = np.asfortranarray(rows.reshape(n * size, m))
    solved, _ = dtbtrs(band.reshape(n * size, 2 * size).T, flat, uplo="L", diag="U", overwrite_b=1)
    return np.asarray(solved).reshape(n, size, m)
