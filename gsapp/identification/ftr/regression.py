"""Regression in the frequency domain, with bounds for colored noise and forgetting.

For each of U moments and each of three equations, X = transforms of qbar x, Y = of qbar C, with
the real and imaginary parts one over the other (so that theta = Re(X* X)^-1 Re(X* Y), (8.1.15),
is plain least squares):

1. Trim, drift and the noise of the two end samples are projected out of X and Y: columns
   transform(qbar), transform(qbar t), and unit pulses at the ends.
2. G = X'X, b = X'Y, over the variance of the residuals, so that a rough record counts for less
   than a calm one; earlier records add theirs; theta = (G - N)^-1 b, N being what white noise of
   vanes and surfaces made of the diagonal of G.
3. cov = (G - N)^-1 [X' R X + earlier] (G - N)^-1, widened by what the level of the residuals is
   uncertain by (`_wider`). R, the covariance of the residuals, follows from their
   local level s_k and from how the weights in time couple frequencies,

       Gam_kl = s_k s_l K(w_k - w_l),   Psi_kl = s_k s_l K(w_k + w_l),
       K(w) = sum wt_i^2 exp(-j w t_i) / sum wt_i^2,

   s_k^2 = |e_k|^2 averaged over five neighbors, over the share that the fit left there (on
   average (2m - n)/2m). (8.1.17), printed with 1/(m - p), depends on the spacing of the
   frequencies.

Noise in the regressors shrinks derivatives. White noise of vanes and surfaces is taken off G.
That of the gyros is not white (engine vibration folds into it), and reaches the flow angles, too,
where these are moved to the CG. What of the rates goes with the residuals
e of the moment equations is F e, with F = (j w I - qbar b/2V D)^-1 (I inertia, D the
damping derivatives), whether e is noise of the gyros, e = F^-1 n, or a gust's moment that the
rates answer to. So Re sum conj(L F e) e', L being what an error of the rates makes of the
regressors and e' the residuals of any equation, is what X'Y holds too much; it is taken out of b
before the last solution, and |L F e|^2 is noise that excitation is measured against. In the
force equations half of it is taken out (`AxisDynamics.trust`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.axis_dynamics import AxisDynamics
from gsapp.identification.ftr.settings import FTR_ALGORITHM, FrequencyBand
from gsapp.identification.ftr.solution import (
    RecordInformation,
    SolvableInformation,
    combine_real_imag,
    invert_normal_matrices,
    orthonormal_basis,
    subtract_white_noise,
    sum_of_squares,
)
from gsapp.identification.ftr.transform import ComplexArray, Transforms
from gsapp.quantities import FloatArray


class ScratchBuffer:
    """Memory for the one large matrix: asking the system for it anew costs more than filling it."""

    def __init__(self) -> None:
        self._memory = np.empty(0)

    def array(self, *shape: int) -> FloatArray:
        """Return an array that holds until the next is taken; what is in it is left over."""
        size = math.prod(shape)
        if size > self._memory.size:
            self._memory = np.empty(size)
        return self._memory[:size].reshape(shape)


def frequency_coupling(correlation: ComplexArray, m: int, scratch: ScratchBuffer) -> FloatArray:
    """Return the covariance of real over imaginary residuals of unit level, (U, 2 m, 2 m)."""
    # K of a negative frequency is the conjugate. Running forwards and backwards, and half of it,
    # so that all that is added below lies in memory one after the other.
    half = 0.5 * correlation
    around = np.concatenate((half[:, m - 1 :: -1], half[:, 1:m].conj()), axis=1)
    out = scratch.array(len(correlation), 2 * m, 2 * m)
    above, below = out[:, :m], out[:, m:]
    minus, plus = (
        _sliding_windows(around.real.copy(), m)[:, ::-1],
        _sliding_windows(half.real[:, 2:].copy(), m),
    )
    np.add(minus, plus, out=above[:, :, :m])
    np.subtract(minus, plus, out=below[:, :, m:])
    minus, plus = (
        _sliding_windows(around.imag.copy(), m)[:, ::-1],
        _sliding_windows(half.imag[:, 2:].copy(), m),
    )
    np.add(minus, plus, out=below[:, :, :m])
    np.subtract(plus, minus, out=above[:, :, m:])
    return out


def _sliding_windows(row: FloatArray, m: int) -> FloatArray:
    along, across = row.strides
    return np.ndarray((len(row), m, m), row.dtype, row, 0, (along, across, across))


def rate_response(
    residual: FloatArray,
    theta: FloatArray,
    body: AxisDynamics,
    turning: FloatArray,
    omega: FloatArray,
) -> FloatArray:
    """Return what of the rates goes with the residuals, F e, shape (U, 2 m, number of rates)."""
    half = len(omega)
    rates = body.regressors
    e = [residual[:, :half, k] + 1j * residual[:, half:, k] for k in body.equations]
    A = [
        [
            1j * (inertia * omega) - (theta[:, k, rate] * turning)[:, np.newaxis]
            for rate, inertia in zip(rates, row, strict=True)
        ]
        for k, row in zip(body.equations, body.inertia, strict=True)
    ]
    if len(rates) == 1:
        found = [e[0] / A[0][0]]
    else:
        determinant = A[0][0] * A[1][1] - A[0][1] * A[1][0]
        first = A[1][1] * e[0] - A[0][1] * e[1]
        second = A[0][0] * e[1] - A[1][0] * e[0]
        found = [first / determinant, second / determinant]
    out = np.empty((len(residual), 2 * half, len(found)))
    for k, one in enumerate(found):
        out[:, :half, k], out[:, half:, k] = one.real, one.imag
    return out


def sandwich_meat(X: FloatArray, level: FloatArray, coupling: FloatArray) -> FloatArray:
    """Return X' R X for each equation, (U, 3, p, p); level has shape (U, m, 3)."""
    moments, rows, p = X.shape
    # Rows of a matrix lie along the frequencies: products of rows are what is quick.
    across = np.swapaxes(np.concatenate((level, level), axis=1), 1, 2)[:, :, np.newaxis]
    weighed = np.ascontiguousarray(across) * np.ascontiguousarray(np.swapaxes(X, 1, 2))[:, None]
    spread = weighed.reshape(moments, 3 * p, rows) @ coupling
    return weighed @ np.swapaxes(spread.reshape(moments, 3, p, rows), 2, 3)


NUISANCE_COLUMNS = 4
"""Columns that trim, drift and the two ends take out of every equation."""

IndexArray = npt.NDArray[np.int64]


def resolved_frequencies(
    listened: FloatArray, band: FrequencyBand, spacing: float, count: int, p: int
) -> tuple[IndexArray, IndexArray]:
    """Return the step between the frequencies that records resolve, and the first, in steps.

    The first is zero where there are too few.

    Parameters
    ----------
    listened : ndarray, shape (U,)
        Effective length, s.
    spacing : float
        Of the frequencies transformed, Hz.
    count : int
        How many there are, zero included.
    p : int
        Derivatives of an equation.
    """
    # Less than a millisecond resolves nothing, either.
    length = np.maximum(listened, 1e-3)
    step = np.maximum(np.ceil(1.0 / (length * spacing) - 1e-3), 1.0)
    lowest = np.maximum(band.lowest, 2.0 / length)
    first = np.maximum(np.ceil(lowest / (spacing * step) - 1e-3), 1.0)
    number = (count - 1) // step + 1.0 - first
    enough = 2.0 * number >= p + NUISANCE_COLUMNS + 2
    return (
        np.where(enough, step, 1.0).astype(np.int64),
        np.where(enough, first, 0.0).astype(np.int64),
    )


def group_by_step(steps: IndexArray, firsts: IndexArray) -> list[tuple[slice, int]]:
    """Return stretches of moments with the same step between frequencies, and that step.

    Moments without frequencies go with any.
    """
    found: list[tuple[slice, int]] = []
    start, step = 0, 0
    for index, (own, first) in enumerate(zip(steps.tolist(), firsts.tolist(), strict=True)):
        if first == 0:
            continue
        if step not in (0, own):
            found.append((slice(start, index), step))
            start = index
        step = own
    return [*found, (slice(start, len(steps)), max(step, 1))]


def frequency_mask(firsts: IndexArray, count: int) -> FloatArray:
    """Return ones from the first frequency of each moment on, zero left out, (U, count - 1)."""
    from_first = np.arange(1, count) >= firsts[:, np.newaxis]
    return np.asarray(from_first * (firsts > 0)[:, np.newaxis], dtype=np.float64)


def sum_over_neighbors(values: FloatArray) -> FloatArray:
    """Return sums over each frequency and its two neighbors on either side, (U, m, e)."""
    out = values.copy()
    for reach in range(1, FTR_ALGORITHM.averaged_neighbors + 1):
        out[:, reach:] += values[:, :-reach]
        out[:, :-reach] += values[:, reach:]
    return out


def solve_records(
    transforms: Transforms,
    band: FrequencyBand,
    spacing: float,
    past: RecordInformation,
    body: AxisDynamics,
    scratch: ScratchBuffer,
) -> tuple[list[SolvableInformation], RecordInformation]:
    """Return what there is to conclude from at U moments, and what the last of them adds.

    `spacing`: of the frequencies transformed, Hz.
    `past`: of the records before it, at each moment: arrays of shape (U, 3, ...).
    """
    p = transforms.signals.shape[-1] - 7
    count = len(transforms.frequencies)
    steps, firsts = resolved_frequencies(transforms.effective_time, band, spacing, count, p)
    parts: list[SolvableInformation] = []
    latest = RecordInformation.zero(p)
    for moments, step in group_by_step(steps, firsts):
        before = past.select_moments(moments)
        if firsts[moments].any():
            record = _RecordEquations.of(
                transforms.select_moments(moments, step), firsts[moments], body
            )
            own, inverses = _solve_record(record, before, body, scratch)
            parts.append(SolvableInformation(information=own.add(before), inverse=inverses))
            latest = own.select_moments(-1)
        else:
            parts.append(SolvableInformation.from_closed_records(before))
            latest = RecordInformation.zero(p)
    return parts, latest


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _RecordEquations:
    """Normal equations of the open record at U moments, from m frequencies; r = 2 m rows."""

    transforms: Transforms
    keep: FloatArray
    """Shape (U, m). Ones from the first frequency that the record resolves on."""
    number: FloatArray
    """Shape (U,). How many these are."""
    basis: FloatArray
    """Shape (U, r, 4). Orthonormal, of trim, drift and the two ends."""
    used: FloatArray
    """Shape (U,). How many columns of it there are."""
    X: FloatArray
    Y: FloatArray
    """Shape (U, r, p) and (U, r, 3). Regressors and targets with that projected out."""
    G: FloatArray
    """Shape (U, p, p)."""
    b: FloatArray
    """Shape (U, 3, p)."""
    energy: FloatArray
    """Shape (U, 3). Of the targets."""
    counts: FloatArray
    """Shape (U, 3). One where an equation counts, zero elsewhere."""
    still: FloatArray
    """Shape (U, p). What the noise of single samples makes of the diagonal of G."""
    white: FloatArray
    """Shape (U, p). The part of it that is white by the aircraft file."""

    @staticmethod
    def of(transforms: Transforms, firsts: IndexArray, body: AxisDynamics) -> _RecordEquations:
        """Return the equations from all frequencies not below the first of each moment."""
        moments, _, count, columns = transforms.signals.shape
        p = columns - 7
        keep = frequency_mask(firsts, count)
        number = keep.sum(axis=1)
        signals = transforms.signals[:, :, 1:]
        if keep.all():
            signals = signals.reshape(moments, -1, columns)
        else:
            signals = (signals * keep[:, np.newaxis, :, np.newaxis]).reshape(moments, -1, columns)
        pressure, listened = transforms.mean_pressure, transforms.effective_time
        # Natural sizes: a constant coefficient of one, a drift by one over the record, one sample.
        sizes = np.ones((moments, 4))
        sizes[:, 0] = pressure * listened
        sizes[:, 1] = sizes[:, 0] * listened
        basis, used = orthonormal_basis(signals[:, :, p + 3 :], sizes)
        moved = signals[:, :, : p + 3]
        moved = moved - basis @ (np.swapaxes(basis, 1, 2) @ moved)
        products = np.swapaxes(moved, 1, 2) @ moved
        targets = np.diagonal(products, axis1=1, axis2=2)[:, p:]
        # White noise of variance v in a sample gives v times the squared weights at any frequency.
        sample = transforms.noise * body.band_noise_ratio
        times = (transforms.squared * number)[:, np.newaxis]
        return _RecordEquations(
            transforms=transforms,
            keep=keep,
            number=number,
            basis=basis,
            used=used,
            X=moved[:, :, :p],
            Y=moved[:, :, p:],
            G=products[:, :p, :p],
            b=products[:, p:, :p],
            energy=targets,
            # A target without any energy was not measured: it stood still.
            counts=np.where(
                transforms.lost_instrument | (targets <= 0.0),
                0.0,
                (number > 0)[:, np.newaxis] * 1.0,
            ),
            still=sample * times,
            white=np.minimum(sample, body.noise * (pressure**2)[:, np.newaxis]) * times,
        )


def _solve_record(
    record: _RecordEquations, past: RecordInformation, body: AxisDynamics, scratch: ScratchBuffer
) -> tuple[RecordInformation, FloatArray]:
    """Return what the record says at U moments, and the inverse of G of all records together."""
    X, Y, counts = record.X, record.Y, record.counts
    transforms = record.transforms
    moments, _, p = X.shape
    number, squared = record.number[:, np.newaxis], transforms.squared[:, np.newaxis]
    # Before its residuals are known, a record is taken to be as rough as those before it.
    known = past.degrees_of_freedom > 0.0
    usual = squared * past.rss / np.where(known, past.degrees_of_freedom, 1.0)
    least = (
        FTR_ALGORITHM.zero_column_tolerance * record.energy / np.maximum(number, 1.0)
        + FTR_ALGORITHM.min_roughness
    )
    weight = counts / np.where(known, np.maximum(usual, least), 1.0)
    b = np.add(past.b, weight[:, :, np.newaxis] * record.b, order="C")
    alone = not known.any()
    G = record.G[:, np.newaxis]
    weighted = weight[:, :, np.newaxis, np.newaxis] * G
    inverses = invert_normal_matrices(G if alone else np.add(past.G, weighted, order="C"))
    theta = np.matvec(inverses, b)
    residual = Y - X @ np.swapaxes(theta, 1, 2)
    # How many of the unknowns this record had to pay for, and where.
    squares = X[:, :, :, np.newaxis] * X[:, :, np.newaxis, :]
    pairs = combine_real_imag(squares).reshape(moments, -1, p * p)
    each_way = (weight[:, :, np.newaxis, np.newaxis] * inverses).reshape(-1, 3, p * p)
    lever = pairs @ np.swapaxes(each_way, 1, 2)
    freedom = 2.0 * number - record.used[:, np.newaxis] - lever.sum(axis=1)
    scale = 2.0 * number / np.maximum(freedom, 1.0)
    some = FTR_ALGORITHM.roughness_prior_weight * known
    rough = (sum_of_squares(residual) + some * usual) / np.maximum(freedom + some, 1.0)
    weight = counts / np.maximum(rough, least)

    own = RecordInformation.empty(moments, p)
    each = weight[:, :, np.newaxis]
    np.multiply(each[..., np.newaxis], G, out=own.G)
    np.multiply(each, record.white[:, np.newaxis], out=own.white)
    if alone:
        there = each > 0.0
        inverses = inverses * np.where(there, 1.0 / np.where(there, each, 1.0), 0.0)[..., None]
    else:
        inverses = invert_normal_matrices(np.add(past.G, own.G, order="C"))
    inverses = subtract_white_noise(inverses, past.white + own.white)

    # What of the regressors goes with the residuals: rates, and flow angles moved to the CG.
    omega = 2.0 * np.pi * transforms.frequencies[1:]
    reach = body.rate_error_gain * transforms.mean_rate_scale[:, np.newaxis, np.newaxis]
    moving = rate_response(residual, theta, body, transforms.mean_rate_scale, omega) @ np.swapaxes(
        reach, 1, 2
    )
    excess = (
        np.swapaxes(residual, 1, 2) @ moving * (scale * body.rate_noise_share)[:, :, np.newaxis]
    )
    np.multiply(each, record.b - excess, out=own.b)
    theta = np.matvec(inverses, np.add(past.b, own.b, order="C"))
    residual = Y - X @ np.swapaxes(theta, 1, 2)

    # The fit takes most of what there is at the lowest frequencies, where trim and motion lie.
    taken = lever + combine_real_imag(np.vecdot(record.basis, record.basis)[:, :, np.newaxis])
    keep = record.keep[:, :, np.newaxis]
    neighbors = np.maximum(sum_over_neighbors(keep), 1.0)
    left = np.maximum(sum_over_neighbors((2.0 - taken) * keep) / neighbors, 0.1)
    level = np.sqrt(
        2.0 * keep * sum_over_neighbors(combine_real_imag(residual**2)) / (neighbors * left)
    )
    spun = sandwich_meat(X, level, frequency_coupling(transforms.correlation, len(omega), scratch))
    np.multiply((each**2)[..., np.newaxis], spun, out=own.meat)
    shaken = sum_of_squares(moving) * scale[:, list(body.equations)].max(axis=1)[:, np.newaxis]
    still = record.still
    noise = np.where(body.is_rate, np.maximum(still, shaken), still + shaken)
    np.multiply(each, noise[:, np.newaxis], out=own.noise)
    own.rss[:] = counts * sum_of_squares(residual) / np.where(squared > 0.0, squared, 1.0)
    own.degrees_of_freedom[:] = counts * freedom
    _fill_summary_terms(own, record, level, each)
    return own, inverses


def _fill_summary_terms(
    own: RecordInformation, record: _RecordEquations, level: FloatArray, each: FloatArray
) -> None:
    """Fill in what does not depend on the solution itself: sizes, and what is at zero frequency."""
    transforms, counts = record.transforms, record.counts
    p = own.p
    at_zero = transforms.signals[:, 0, 0]
    mean = own.mean
    mean[:, :, :p] = at_zero[:, np.newaxis, :p]
    mean[:, :, p] = at_zero[:, p + 3, np.newaxis]
    mean[:, :, p + 1] = at_zero[:, p : p + 3]
    mean *= counts[:, :, np.newaxis]
    # At zero frequency all power is real; the noise of the ends is not among the residuals.
    lowest = level[np.arange(len(level)), np.argmax(record.keep, axis=1)]
    np.multiply(counts, lowest**2 + transforms.end_noise, out=own.mean_noise)
    twice = 2.0 * float(transforms.frequencies[1])
    diagonal = np.diagonal(record.G, axis1=1, axis2=2)[:, np.newaxis]
    np.multiply(counts, twice * record.energy, out=own.coefficient_energy)
    np.multiply(counts[:, :, np.newaxis], twice * diagonal, out=own.regressor_energy)
    pressure, listened = (
        transforms.mean_pressure[:, np.newaxis],
        transforms.effective_time[:, np.newaxis],
    )
    np.multiply(counts, listened, out=own.effective_time)
    np.multiply(counts, pressure**2 * listened, out=own.pressure_energy)
    np.divide(
        (each * diagonal) ** 2,
        np.maximum(own.degrees_of_freedom, 1.0)[:, :, np.newaxis],
        out=own.squared_weight,
    )
