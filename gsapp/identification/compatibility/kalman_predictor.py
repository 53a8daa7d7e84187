"""Residuals made white: noise of gyros and accelerometers is integrated, and air moves.

Integrated noise is a random walk: residuals of plain output error are anything but white, and
their bounds far too small. With the error of velocity and of attitude (body axes) as states,

    dv' = -w x dv + g x phi + v x dw + da + gusts,    phi' = -w x phi + dw,

residuals are what a Kalman predictor leaves; it is linear, so sensitivities go through the same
one, and the fit stays a least-squares problem. Its start has no error: that is free in the fit.
Residuals are first averaged over a few samples.

White noise of each instrument is read from frequencies at which no aircraft moves. What the
instruments show below them beside the motion (gusts, colored noise) is found by making the
predicted residuals as likely as can be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.identification.compatibility.instrument_prediction import Prediction
from gsapp.identification.compatibility.kinematics import cross_product_matrices
from gsapp.identification.compatibility.segments import CompatibilitySegment
from gsapp.identification.compatibility.settings import (
    COMPATIBILITY,
    KINEMATIC_INPUTS,
    RATE_CHANNELS,
)
from gsapp.identification.filter_error.steady_state import (
    InnovationsForm,
    propagated_covariance,
)
from gsapp.quantities import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorStateModel:
    """Averages and the error equations of one stretch."""

    width: int  # Samples averaged.
    step: float  # Between averages, s.
    Phi: FloatArray  # Shape (m, 6, 6).
    H: FloatArray  # Shape (m, n_channels, 6).
    process: FloatArray
    """Shape (9, 6, 6). Covariance over one step for a unit density of p, q, r, ax, ay, an, and
    gusts u, v, w."""
    input_density: FloatArray  # Shape (9,). White densities; gusts those of calm air.
    output_variance: FloatArray  # Shape (n_channels,). White variances of averages.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NoiseLevels:
    """How much noise there is: factors on the white one."""

    input_factors: FloatArray  # Shape (9,).
    output_factors: FloatArray  # Shape (n_channels,).

    @classmethod
    def white(cls, channels: int) -> NoiseLevels:
        """Return the white noise itself."""
        return cls(input_factors=np.ones(9), output_factors=np.ones(channels))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyKalmanGain:
    """A steady Kalman predictor: gain (6, n_channels) and residual covariance and its inverse."""

    K: FloatArray
    covariance: FloatArray
    weight: FloatArray


def samples_per_average(stretch: CompatibilitySegment, rate: float) -> int:
    """Return how many samples of a stretch make one of `rate` averages per second."""
    return max(1, round(1.0 / (rate * stretch.dt)))


def block_average(values: FloatArray, counted: BoolArray, width: int) -> FloatArray:
    """Average over `width` samples those that count; NaN where none does.

    Parameters
    ----------
    values : ndarray, shape (n, n_channels, ...)
    counted : ndarray of bool, shape (n, n_channels)
    width : int
        Samples to an average.

    Returns
    -------
    ndarray, shape (n // width, n_channels, ...)
    """
    count = len(values) // width
    shape = (count, width, *values.shape[1:])
    mask = counted[: count * width].reshape(count, width, -1)
    kept = values[: count * width].reshape(shape)
    if mask.all():
        return np.asarray(kept.mean(axis=1), dtype=np.float64)
    extra = (1,) * (values.ndim - 2)
    weights = mask.reshape(*mask.shape, *extra)
    number = weights.sum(axis=1)
    # At least half of them: what is left of an average else is another one.
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(weights, kept, 0.0).sum(axis=1) / number
    return np.asarray(np.where(2 * number >= width, mean, np.nan), dtype=np.float64)


def build_error_state_model(
    stretch: CompatibilitySegment, found: Prediction, errors: Mapping[str, float], rate: float
) -> ErrorStateModel:
    """Set up the error equations along a path."""
    path = found.path
    width = samples_per_average(stretch, rate)
    count = len(path.times) // width

    def mean(values: FloatArray) -> FloatArray:
        kept = values[: count * width]
        return np.asarray(kept.reshape(count, width, *values.shape[1:]).mean(axis=1))

    step = width * stretch.dt
    w, v, g = mean(path.rates), mean(path.velocity), mean(path.gravity)
    A = np.zeros((count, 6, 6))
    A[:, :3, :3] = A[:, 3:, 3:] = -cross_product_matrices(w)
    A[:, :3, 3:] = cross_product_matrices(g)
    Phi = np.eye(6) + step * A + 0.5 * step * step * (A @ A)
    channels = len(found.channels)
    H = np.zeros((count, channels, 6))
    show = np.empty(channels)
    for row, (name, one) in enumerate(zip(found.channels, found.ideal, strict=True)):
        variance = stretch.noise[name] ** 2 / width
        if one.by_velocity is not None:
            slope = mean(one.by_velocity)
            H[:, row, :3] = slope
            # Noise of the gyros on the way from the accelerometer to the vane.
            felt = slope @ cross_product_matrices(one.arm).T
            powers = [stretch.noise.get(gyro, 0.0) ** 2 for gyro in RATE_CHANNELS]
            variance += float(np.mean(felt**2, axis=0) @ powers) / width
        else:
            H[:, row, 3:] = (mean(one.by_gravity)[:, None, :] @ cross_product_matrices(g))[:, 0]
        H[:, row] *= errors.get(f"{name}.scale", 1.0)
        show[row] = variance
    if stretch.assumed_speed is not None and "V" in found.channels:
        # A constant error: it counts once, not once for every sample.
        show[found.channels.index("V")] = COMPATIBILITY.assumed_speed_std**2 * count
    process = np.zeros((9, 6, 6))
    middle = cross_product_matrices(v.mean(axis=0))
    for axis in range(3):
        by_rate = np.concatenate((middle[:, axis], np.eye(3)[axis]))
        by_force = np.concatenate((np.eye(3)[axis], np.zeros(3)))
        process[axis] = step * np.outer(by_rate, by_rate)
        process[3 + axis] = process[6 + axis] = step * np.outer(by_force, by_force)
    drive = np.full(9, COMPATIBILITY.calm_air_density)
    for index, name in enumerate(KINEMATIC_INPUTS):
        unknown = (
            COMPATIBILITY.unmeasured_rate_density
            if index < 3
            else COMPATIBILITY.unmeasured_force_density
        )
        drive[index] = unknown if name in stretch.absent else stretch.noise[name] ** 2 * stretch.dt
    return ErrorStateModel(
        width=width,
        step=step,
        Phi=Phi,
        H=H,
        process=process,
        input_density=drive,
        output_variance=show,
    )


def steady_kalman_gains(
    predictor: ErrorStateModel, noises: Sequence[NoiseLevels]
) -> tuple[FloatArray, FloatArray]:
    """Return steady gains (c, 6, n_channels) and covariances of what they leave, for c noises.

    The covariance has run over a thousand steps from an exact start.
    """
    drive = np.array([one.input_factors for one in noises]) * predictor.input_density
    Q = np.einsum("cd,dij->cij", drive, predictor.process)
    R = np.array([one.output_factors for one in noises]) * predictor.output_variance
    H = predictor.H.mean(axis=0)
    P = propagated_covariance(
        predictor.Phi.mean(axis=0),
        np.einsum("ki,ck,kj->cij", H, 1.0 / R, H),
        Q,
        COMPATIBILITY.covariance_doublings,
    )
    covariance = H @ P @ H.T
    covariance[:, np.arange(len(H)), np.arange(len(H))] += R
    K = P @ H.T @ np.linalg.inv(covariance)
    return K, covariance


def kalman_gain_pair(
    predictor: ErrorStateModel, noise: NoiseLevels, other: NoiseLevels
) -> tuple[SteadyKalmanGain, SteadyKalmanGain]:
    """Return the predictors for two noises."""
    K, covariance = steady_kalman_gains(predictor, [noise, other])
    one, two = (
        SteadyKalmanGain(K=K[k], covariance=covariance[k], weight=np.linalg.inv(covariance[k]))
        for k in range(2)
    )
    return one, two


def whiten_residuals(predictor: ErrorStateModel, K: FloatArray, columns: FloatArray) -> FloatArray:
    """Return what the predictor leaves of averages.

    `K`, shape (6, n_channels), or (c, 6, n_channels) for a single column.
    `columns`, shape (m, n_channels, k): NaN where a sample does not count.

    Shape (m, n_channels, k) or (c, m, n_channels, 1). NaN where a sample does not count.
    """
    counted = np.isfinite(columns)
    valid = np.asarray(counted.all(axis=2))
    clean = np.where(counted, columns, 0.0)
    if K.ndim > 2:
        left = _predict_with_each_gain(predictor, K, clean, valid)
    else:
        injection = (predictor.Phi @ K) * valid[:, None, :]
        form = InnovationsForm(
            by_state=predictor.H,
            propagation=(predictor.Phi - injection @ predictor.H)[:-1],
            injection=injection[:-1],
            valid=valid,
        )
        left, _ = form.predict(clean)
    left[..., ~valid, :] = np.nan
    return left


def _predict_with_each_gain(
    predictor: ErrorStateModel, K: FloatArray, columns: FloatArray, valid: BoolArray
) -> FloatArray:
    """Return what predictors with gains (c, 6, n_channels) leave of one column, all at once."""
    n, n_channels, _ = columns.shape
    gains = np.ascontiguousarray(K.transpose(2, 1, 0))
    left = np.empty((n, n_channels, len(K)))
    deviation = np.zeros((gains.shape[1], len(K)))
    complete = np.asarray(valid.all(axis=1), dtype=np.bool_)
    for k in range(n):
        e = np.subtract(columns[k], predictor.H[k] @ deviation, out=left[k])
        if not complete[k]:
            e *= valid[k, :, None]
        deviation = predictor.Phi[k] @ (deviation + (gains * e[:, None]).sum(axis=0))
    return np.ascontiguousarray(left.transpose(2, 0, 1))[..., None]


def neg2_log_likelihood(left: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return twice the negative log-likelihood of predicted residuals, shape (c,).

    `left`, shape (c, m, n_channels).
    `covariance`, shape (c, n_channels, n_channels).
    """
    counted = np.isfinite(left)
    clean = np.where(counted, left, 0.0)
    squares = ((clean @ np.linalg.inv(covariance)) * clean).sum(axis=(1, 2))
    share = counted.mean(axis=(1, 2))
    return np.asarray(squares + share * left.shape[1] * np.linalg.slogdet(covariance)[1])


def estimate_noise_levels(
    predictor: ErrorStateModel, residuals: FloatArray, start: NoiseLevels
) -> NoiseLevels:
    """Return the noise under which residuals are the most likely.

    Gusts, gyros and every channel are tried up and down by a factor, the best step taken, until
    none helps. Nothing falls below the white noise.

    `residuals`, shape (m, n_channels): averages, NaN where one does not count.
    `start`: where to begin.
    """
    places = [("drive", k) for k in (0, 1, 2, 6, 7, 8)]
    places += [("show", k) for k in range(residuals.shape[1])]
    best, columns = start, residuals[:, :, None]

    def judged(noises: Sequence[NoiseLevels]) -> FloatArray:
        K, covariance = steady_kalman_gains(predictor, noises)
        return neg2_log_likelihood(whiten_residuals(predictor, K, columns)[..., 0], covariance)

    least = float(judged([best])[0])
    factor = COMPATIBILITY.search_factor**2
    while factor > 1.5:
        for _ in range(COMPATIBILITY.max_search_steps):
            tried = [
                changed
                for group, place in places
                for times in (factor, 1.0 / factor)
                if (changed := _scale_noise_level(best, group, place, times)) is not None
            ]
            values = judged(tried)
            gained = least - values
            if gained.max() < 1.0:
                break
            # All that help, together; where they do not go together, the best alone.
            together = best
            for one, gain_of_one in zip(tried, gained, strict=True):
                if gain_of_one > 1.0:
                    together = NoiseLevels(
                        input_factors=together.input_factors
                        * one.input_factors
                        / best.input_factors,
                        output_factors=together.output_factors
                        * one.output_factors
                        / best.output_factors,
                    )
            value = float(judged([together])[0])
            if value > values.min():
                together, value = tried[int(values.argmin())], float(values.min())
            best, least = together, value
        factor = factor**0.5
    return best


def _scale_noise_level(
    noise: NoiseLevels, group: str, place: int, times: float
) -> NoiseLevels | None:
    drive, show = noise.input_factors.copy(), noise.output_factors.copy()
    chosen = drive if group == "drive" else show
    if chosen[place] * times < 0.999:
        return None
    chosen[place] *= times
    return NoiseLevels(input_factors=drive, output_factors=show)
