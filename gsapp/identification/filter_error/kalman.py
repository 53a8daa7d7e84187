"""The steady-state filter of one maneuver, and signals seen through it.

The filter predicts from one block of samples (`blocks`) to the next and compares the means of the
channels over it, which costs no information at the frequencies at which an aircraft moves. With
the filter's gain K, deviations dx of the states from the motion that the model was linearized
along obey, between predictions,

    dx[k+1] = Phi_k (1 - K C_k) dx[k] + Phi_k K z[k] + b[k],     innovation = z[k] - C_k dx[k],

for the residual (z: measured minus computed, b: minus the defect of the motion) and for the
change that a parameter makes (z: its part in the channels, b: minus its part in the rates) alike.
Within blocks both are carried from sample to sample. Colored noise of a channel is a state like
any other: differences of successive means in its place would hold the turbulence of two blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError

from gsapp.foundation import FlightError
from gsapp.identification.filter_error.block_linearization import BlockLinearization
from gsapp.identification.filter_error.motion_linearization import Linearization, NominalMotion
from gsapp.identification.filter_error.noise_model import ColoredNoise, NoiseModel
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.identification.filter_error.steady_state import (
    InnovationsForm,
    solve_forward,
    solve_lyapunov,
    steady_covariance,
)
from gsapp.quantities import FloatArray

DIVERGED_TEXT = (
    "the model diverges; check signs, units and calibration ('gsapp compatibility'), or use "
    "equation error"
)


class Adjoints(NamedTuple):
    """What the smoother makes of innovations (Bryson and Frazier), or what it should make of them.

    The intensity of a noise times its adjoint is its smoothed value. Histories, block by block;
    covariances where the noise model holds (`SteadyStateFilter.expected`).
    """

    process: list[FloatArray]
    """Shape (n_blocks - 1, n_x) or (n_x, n_x). For each of the ways through a block."""
    measurement: FloatArray  # Shape (n_blocks, n_channels) or (n_channels, n_channels).
    colors: FloatArray
    """Shape (n_blocks - 1, n_colored, block) or (n_colored, block). Of what each sample adds to
    colored noise."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyStateFilter(InnovationsForm):
    """The filter of one maneuver.

    Its states are those of the blocks, and the noise of every colored channel at a block's start.
    """

    blocks: BlockLinearization  # What no noise changes.
    colors: ColoredNoise  # The colored channels.
    whitener: FloatArray
    """Shape (n_blocks, n_channels, n_channels). Turns innovations into uncorrelated ones of unit
    variance."""
    log_determinant: float
    """Sum of the logarithms of the determinants of the innovations' covariances."""
    mean_injection: FloatArray  # Shape (n_x + n_colored, n_channels). For the mean dynamics.
    predicted_covariance: FloatArray
    """Shape (n_x + n_colored, n_x + n_colored). Covariance of the predicted states."""

    @property
    def linearization(self) -> Linearization:
        return self.blocks.linearization

    @property
    def block_size(self) -> int:
        return self.blocks.block_size

    def residual(self, bias: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the residual, `bias` given for each channel; see `BlockLinearization.residual`."""
        return self.blocks.residual(bias)

    def with_noise(self, noise: NoiseModel) -> SteadyStateFilter:
        """Return the filter of the same maneuver for other noise."""
        if noise.gust_shape != self.blocks.gust_shape:
            raise ValueError("the shape of gusts is part of the blocks; build the filter again")
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
        innovations : ndarray, shape (n_blocks, n_channels, m)
            Zero for what does not count.
        deviations : ndarray, shape (n_blocks, n_x, m)
        """
        found, deviations = self.predict(z, b, start)
        return found, deviations[:, : b.shape[1]]

    def adjoints(self, innovations: FloatArray) -> Adjoints:
        """Return what the smoother makes of innovations, shape (n_blocks, n_channels)."""
        adjoint, measurement = self._backward(innovations)
        measurement[:-1] -= (adjoint[1:, None] @ self.injection)[:, 0]
        n_x = len(self.blocks.scales)
        process = [
            adjoint[1:, :n_x] @ way.state_gain + measurement[:-1] @ way.output_gain
            for way in self.blocks.noise_gains
        ]
        own = self.colors
        colors = adjoint[1:, n_x:, None] * own.by_end
        colors += measurement[:-1, own.channel_indices, None] * own.by_mean
        return Adjoints(process=process, measurement=measurement, colors=colors)

    def _backward(self, innovations: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the adjoints of states, (n_blocks, n_all), and the weighted innovations."""
        white = self.whitener @ innovations[:, :, None]
        weighted = (self.whitener.transpose(0, 2, 1) @ white)[:, :, 0]
        rows = (weighted[:, None] @ self.by_state)[:, 0]
        # Backward in time: reversed, with transposed propagation.
        backward = np.ascontiguousarray(self.propagation[::-1].transpose(0, 2, 1))
        adjoint = solve_forward(backward, rows[::-1, :, None].copy())[::-1, :, 0]
        return adjoint, weighted

    def _expected_backward(self) -> tuple[FloatArray, FloatArray]:
        """Return the covariances of `_backward` where the noise model holds."""
        flat = self.whitener.reshape(-1, self.whitener.shape[2])
        precision = flat.T @ flat / len(self.whitener)
        M = self.propagation.mean(axis=0)
        C = self.by_state.mean(axis=0)
        scales = np.concatenate((self.blocks.scales, self.colors.stds))
        C_s, M_s = C * scales, M * scales / scales[:, None]
        try:
            state = solve_lyapunov(M_s, C_s.T @ precision @ C_s)
        except LinAlgError as error:
            raise FlightError(f"{_where(self.blocks)}{DIVERGED_TEXT}") from error
        return state / scales[:, None] / scales, precision

    def smoothed_decay(self, z: FloatArray, b: FloatArray) -> FloatArray:
        """Return what share of colored noise the smoother sees from block to block, (n_colored,).

        The root of E[(n[k+1] - kappa n[k]) n[k]] = 0, given all measurements of the maneuver.

        `z` and `b`: the residual; see `innovations`.
        """
        n_x = len(self.blocks.scales)
        innovations, deviations = self.predict(z[:, :, None], b[:, :, None])
        adjoint, _ = self._backward(innovations[:, :, 0])
        smooth = deviations[:, n_x:, 0] + adjoint @ self.predicted_covariance[:, n_x:]
        information, _ = self._expected_backward()
        left = np.eye(len(self.predicted_covariance)) - information @ self.predicted_covariance
        same = np.diag(self.predicted_covariance @ left)[n_x:]
        next_ = np.diag(self.predicted_covariance @ self.propagation.mean(axis=0).T @ left)[n_x:]
        count = len(smooth) - 1
        held = (smooth[1:] * smooth[:-1]).sum(axis=0) + count * next_
        found: FloatArray = held / ((smooth[:-1] ** 2).sum(axis=0) + count * same)
        return found

    def expected_adjoints(self) -> Adjoints:
        """Return the covariances of `adjoints` where the noise model holds."""
        state, precision = self._expected_backward()
        J = self.mean_injection
        crossing = state @ J
        measurement = precision + J.T @ crossing
        n_x = len(self.blocks.scales)
        process = []
        for _, N, O in self.blocks.noise_gains:  # noqa: E741
            crossed = N.T @ crossing[:n_x] @ O
            process.append(
                N.T @ state[:n_x, :n_x] @ N - crossed - crossed.T + O.T @ measurement @ O
            )
        own = self.colors
        rows = np.arange(n_x, n_x + len(own.channel_indices))
        colors = state[rows, rows, None] * own.by_end**2
        colors -= 2.0 * crossing[rows, own.channel_indices, None] * own.by_end * own.by_mean
        colors += measurement[own.channel_indices, own.channel_indices, None] * own.by_mean**2
        return Adjoints(process=process, measurement=measurement, colors=colors)


def create_filter(
    linearization: Linearization, noise: NoiseModel | None, motion: NominalMotion
) -> SteadyStateFilter:
    """Return the filter for a linearized maneuver; without noise model, none: output error."""
    return _filter(BlockLinearization(linearization, motion, noise), noise)


def _where(blocks: BlockLinearization) -> str:
    """Return the beginning of a sentence about a maneuver."""
    return f"maneuver {blocks.linearization.record.id}: "


def _filter(blocks: BlockLinearization, noise: NoiseModel | None) -> SteadyStateFilter:
    channels = blocks.linearization.record.channels
    colors = ColoredNoise.from_noise_model(noise, channels, blocks.block_size)
    n_x, n_all = len(blocks.scales), len(blocks.scales) + len(colors.channel_indices)
    transition = np.zeros((len(blocks.transition), n_all, n_all))
    transition[:, :n_x, :n_x] = blocks.transition
    transition[:, range(n_x, n_all), range(n_x, n_all)] = colors.decay
    by_state = np.zeros((*blocks.by_state.shape[:2], n_all))
    by_state[:, :, :n_x] = blocks.by_state
    by_state[:, colors.channel_indices, range(n_x, n_all)] = colors.mean_share
    n_blocks, n_channels = blocks.valid.shape
    if noise is None:
        injection = np.zeros((n_blocks - 1, n_all, n_channels))
        whitener = np.broadcast_to(np.eye(n_channels), (n_blocks, n_channels, n_channels))
        log_size, P = 0.0, np.zeros((n_all, n_all))
    else:
        P, shared, of_means = _steady_covariance(
            blocks, noise, colors, transition.mean(axis=0), by_state.mean(axis=0)
        )
        # What is expected of states hardly changes with speed; what they show does.
        crossed = by_state @ P
        covariance = crossed @ by_state.transpose(0, 2, 1) + of_means
        try:
            whitener = np.linalg.inv(np.linalg.cholesky(covariance))
        except LinAlgError as error:
            raise FlightError(f"{_where(blocks)}{DIVERGED_TEXT}") from error
        precision = whitener.transpose(0, 2, 1) @ whitener
        injection = transition @ crossed[:-1].transpose(0, 2, 1) + shared
        injection = injection @ precision[:-1]
        log_size = -2.0 * float(np.log(np.diagonal(whitener, axis1=1, axis2=2)).sum())
    if not blocks.valid.all():
        injection *= blocks.valid[:-1, None, :]
    return SteadyStateFilter(
        blocks=blocks,
        colors=colors,
        valid=blocks.valid,
        by_state=by_state,
        propagation=transition - injection @ by_state[:-1],
        injection=injection,
        whitener=whitener,
        log_determinant=log_size,
        mean_injection=injection.mean(axis=0),
        predicted_covariance=P,
    )


def _steady_covariance(
    blocks: BlockLinearization,
    noise: NoiseModel,
    colors: ColoredNoise,
    transition: FloatArray,
    by_state: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the steady covariance of states, and what noise within a block adds.

    Returns
    -------
    P : ndarray, shape (n_all, n_all)
        Of predicted states, for the mean dynamics.
    shared : ndarray, shape (n_all, n_channels)
        Process noise of a block is seen in the means over that block already: covariance of its
        part in the end of the block and in the means.
    of_means : ndarray, shape (n_channels, n_channels)
        Covariance of the means where states are known: noise of instruments and within the block.
    """
    channels = blocks.linearization.record.channels
    n_x = len(blocks.scales)
    scales = np.concatenate((blocks.scales, colors.stds))
    A = transition / scales[:, None] * scales
    C = by_state * scales
    measured = noise.block_mean_variances(channels, blocks.block_size)
    n_states = blocks.n_states
    Q = np.zeros((n_x, n_x))
    moving = blocks.gusts.entries.shape[1]
    Q[:moving, :moving] = noise.process_noise(
        blocks.gusts.names, blocks.gusts.entries, blocks.moment_rows
    )
    moved = blocks.linearization.rate_by_control
    Q[:n_states, :n_states] += np.einsum(
        "nic,c,njc->ij", moved, noise.control_intensities, moved
    ) / len(moved)
    measured += blocks.interpolation_variance(Q[:n_states, :n_states])
    Q = Q / blocks.scales[:, None] / blocks.scales
    # Channels in units of their noise: the equation is badly scaled otherwise.
    units = np.sqrt(measured)
    units[colors.channel_indices] = np.sqrt(colors.variance_of_means)
    C, R = C / units[:, None], np.diag(measured / units**2)
    ways = [
        (way.weight, way.state_gain / scales[:n_x, None] * scales[:n_x],
         way.output_gain * scales[:n_x] / units[:, None])
        for way in blocks.noise_gains
    ]  # fmt: skip
    rows, places = np.arange(n_x, len(scales)), colors.channel_indices
    for least in (
        FILTER_ERROR.min_intensity,
        1e3 * FILTER_ERROR.min_intensity,
        1e6 * FILTER_ERROR.min_intensity,
    ):
        own = Q + least * np.eye(n_x)
        arrived = np.zeros(A.shape)
        shared = np.zeros(C.T.shape)
        noise_of_means = R.copy()
        for weight, N, O in ways:  # noqa: E741
            arrived[:n_x, :n_x] += weight * N @ own @ N.T
            shared[:n_x] += weight * N @ own @ O.T
            noise_of_means += weight * O @ own @ O.T
        arrived[rows, rows] += (
            (colors.by_end**2).sum(axis=1) * colors.driving_variance / colors.stds**2
        )
        shared[rows, places] += (
            (colors.by_end * colors.by_mean).sum(axis=1)
            * colors.driving_variance
            / (colors.stds * units[places])
        )
        noise_of_means[places, places] += (
            (colors.by_mean**2).sum(axis=1) * colors.driving_variance / units[places] ** 2
        )
        try:
            P = steady_covariance(A, C, arrived, noise_of_means, shared)
            break
        except (LinAlgError, ValueError):
            continue
    else:
        raise FlightError(f"{_where(blocks)}{DIVERGED_TEXT}")
    return (
        P * scales[:, None] * scales,
        shared * scales[:, None] * units,
        noise_of_means * units[:, None] * units,
    )
