"""The steady-state filter of one maneuver, and signals seen through it.

The filter predicts from one block of samples (`blocks`) to the next and compares the means of the
channels over it, which costs no information at the frequencies at which an aircraft moves. With
the filter's gain K, deviations dx of the states from the motion that the model was linearized
along obey, between predictions,

    dx[k+1] = Phi_k (1 - K C_k) dx[k] + Phi_k K z[k] + b[k],     innovation = z[k] - C_k dx[k],

for the residual (z: measured minus computed, b: minus the defect of the motion) and for the
change that a parameter makes (z: its part in the channels, b: minus its part in the rates) alike.
Within blocks both are carried from sample to sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, solve_discrete_lyapunov
from scipy.linalg.lapack import dtbtrs

from gsapp.discrepancy.filtering.blocks import Blocks, Way
from gsapp.discrepancy.filtering.linearizing import Linearization, Motion
from gsapp.discrepancy.filtering.noise import NoiseModel
from gsapp.discrepancy.filtering.riccati import steady_covariance
from gsapp.foundation import FlightError
from gsapp.quantities import BoolArray, FloatArray

_MANY = 6
_LEAST = 1e-9
"""Process noise that every state has, in units of the scales squared per second."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Filter:
    """The filter of one maneuver.

    Attributes
    ----------
    blocks : Blocks
        What no noise changes.
    propagation : ndarray, shape (n_blocks - 1, n_x, n_x)
        Phi (1 - K C).
    injection : ndarray, shape (n_blocks - 1, n_x, n_channels)
        Phi K, zero for channels that do not count in a block.
    whitener : ndarray, shape (n_channels, n_channels)
        Turns innovations into uncorrelated ones of unit variance.
    log_size : float
        Logarithm of the determinant of the innovations' covariance.
    covariance : ndarray, shape (n_channels, n_channels)
        Of the innovations.
    mean_injection : ndarray, shape (n_x, n_channels)
        For the mean dynamics.
    ways : tuple of Way
    colors : ndarray, shape (n_channels,), or None
        Correlation of each channel's noise from block to block, where any is colored. What is
        compared are then the means of the next block less this share of the present ones, in
        which the noise is white (Bryson and Henrikson, J. Spacecraft 5, 1968).
    compared : ndarray, shape (n_compared, n_channels, n_x)
        What is compared by the state at a block's start; n_compared is n_blocks, or one less.
    compared_counted : ndarray of bool, shape (n_compared, n_channels)
    """

    blocks: Blocks
    propagation: FloatArray
    injection: FloatArray
    whitener: FloatArray
    log_size: float
    covariance: FloatArray
    mean_injection: FloatArray
    ways: tuple[Way, ...]
    colors: FloatArray | None
    compared: FloatArray
    compared_counted: BoolArray

    @property
    def linearization(self) -> Linearization:
        """Return what is filtered."""
        return self.blocks.linearization

    @property
    def block(self) -> int:
        """Return the number of samples taken together."""
        return self.blocks.block

    @property
    def by_state(self) -> FloatArray:
        """Return the derivatives of mean channels by the state at a block's start."""
        return self.blocks.by_state

    @property
    def counted(self) -> BoolArray:
        """Return which channels count in which block, shape (n_blocks, n_channels)."""
        return self.blocks.counted

    def residual(self, bias: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the residual, `bias` given for each channel; see `Blocks.residual`."""
        return self.blocks.residual(bias)

    def with_noise(self, noise: NoiseModel) -> Filter:
        """Return the filter of the same maneuver for other noise."""
        if noise.lengths != self.blocks.lengths:
            raise ValueError("scale lengths are part of the blocks; make the filter anew")
        return _filter(self.blocks, noise)

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
        innovations : ndarray, shape (n_compared, n_channels, m)
            Zero for what does not count.
        deviations : ndarray, shape (n_blocks, n_x, m)
        """
        n, _, m = z.shape
        if self.colors is not None:
            z = z[1:] - self.colors[:, None] * z[:-1] - self.by_state[1:] @ b
        if not self.compared_counted.all():
            z = z * self.compared_counted[:, :, None]
        rows = np.zeros((n, self.by_state.shape[2], m))
        np.matmul(self.injection, z[: n - 1], out=rows[1:])
        rows[1:] += b
        if start is not None:
            rows[0] = start
        deviations = solve_forward(self.propagation, rows)
        found = z - self.compared @ deviations[: len(z)]
        if not self.compared_counted.all():
            found *= self.compared_counted[:, :, None]
        return found, deviations

    def adjoints(self, innovations: FloatArray) -> tuple[list[FloatArray], FloatArray]:
        """Return what the smoother makes of the innovations (Bryson and Frazier).

        Parameters
        ----------
        innovations : ndarray, shape (n_compared, n_channels)

        Returns
        -------
        process : list of ndarray, shape (n_blocks - 1, n_x)
            For each of `ways`: the intensity of the process noise times this is its smoothed
            value, block by block.
        measurement : ndarray, shape (n_compared, n_channels)
            Variance of the measurement noise times this is its smoothed value.
        """
        precision = self.whitener.T @ self.whitener
        weighted = innovations @ precision
        steps = len(self.injection)
        rows = np.zeros((steps + 1, self.by_state.shape[2]))
        rows[: len(weighted)] = (weighted[:, None] @ self.compared)[:, 0]
        # Backward in time: reversed, with transposed propagation.
        backward = np.ascontiguousarray(self.propagation[::-1].transpose(0, 2, 1))
        adjoint = solve_forward(backward, rows[::-1, :, None].copy())[::-1, :, 0]
        measurement = weighted.copy()
        measurement[:steps] -= (adjoint[1:, None] @ self.injection)[:, 0]
        process = [
            adjoint[1:] @ way.state + measurement[:steps] @ way.channels for way in self.ways
        ]
        return process, measurement

    def expected(self) -> tuple[list[FloatArray], FloatArray]:
        """Return the covariances of `adjoints` where the noise model holds."""
        precision = self.whitener.T @ self.whitener
        M = self.propagation.mean(axis=0)
        C = self.compared.mean(axis=0)
        J = self.mean_injection
        scales = self.blocks.scales
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
    return _filter(Blocks(linearization, motion, None if noise is None else noise.lengths), noise)


def _filter(blocks: Blocks, noise: NoiseModel | None) -> Filter:
    channels = blocks.linearization.record.channels
    colors = None if noise is None else noise.colors(channels, blocks.block)
    compared, counted = blocks.by_state, blocks.counted
    ways: tuple[Way, ...] = () if noise is None else blocks.ways
    if colors is not None:
        compared = blocks.by_state[1:] @ blocks.transition - colors[:, None] * compared[:-1]
        counted = counted[1:] & (counted[:-1] | (colors == 0.0))
        ways = tuple(
            way._replace(channels=blocks.mean_by_state @ way.state - colors[:, None] * way.channels)
            for way in ways
        )
    if noise is None:
        gain = within = np.zeros((len(blocks.scales), len(channels)))
        covariance = np.eye(len(channels))
    else:
        gain, within, covariance = _gain(blocks, noise, channels, compared, ways)
    n_x = len(gain)
    injection = (blocks.transition.reshape(-1, n_x) @ gain).reshape(-1, n_x, len(channels))
    injection += within
    steps = len(injection)
    if not counted.all():
        injection *= counted[:steps, None, :]
    lower = np.linalg.cholesky(covariance)
    return Filter(
        blocks=blocks,
        propagation=blocks.transition - injection @ compared[:steps],
        injection=injection,
        whitener=np.linalg.inv(lower),
        log_size=2.0 * float(np.log(np.diag(lower)).sum()),
        covariance=covariance,
        ways=ways,
        mean_injection=blocks.mean_transition @ gain + within,
        colors=colors,
        compared=compared,
        compared_counted=counted,
    )


def _gain(
    blocks: Blocks,
    noise: NoiseModel,
    channels: tuple[str, ...],
    compared: FloatArray,
    ways: tuple[Way, ...],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return steady gain, what noise within a block adds to it, and the innovations' covariance.

    Process noise of a block is seen in the means over that block already.
    """
    scales = blocks.scales
    A = blocks.mean_transition / scales[:, None] * scales
    C = compared.mean(axis=0) * scales
    R = np.diag([noise.variances[name] / blocks.block for name in channels])
    Q = noise.process(blocks.V, len(scales) - 3) / scales[:, None] / scales
    # Channels in units of their noise: the equation is badly scaled otherwise.
    units = np.sqrt(np.diag(R))
    C, R = C / units[:, None], np.eye(len(channels))
    scaled = [
        (way.weight, way.state / scales[:, None] * scales, way.channels * scales / units[:, None])
        for way in ways
    ]
    for least in (_LEAST, 1e3 * _LEAST, 1e6 * _LEAST):
        own = Q + least * np.eye(len(scales))
        arrived = np.zeros(Q.shape)
        for weight, N, _ in scaled:
            arrived += weight * N @ own @ N.T
        shared = np.zeros(C.T.shape)
        for weight, N, O in scaled:  # noqa: E741
            shared += weight * N @ own @ O.T
        noise_of_means = R + sum(weight * O @ own @ O.T for weight, _, O in scaled)  # noqa: E741
        try:
            P = steady_covariance(A, C, arrived, noise_of_means, shared)
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
