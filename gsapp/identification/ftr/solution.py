"""What records say about the three equations of one axis, and the estimates made from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.axis_dynamics import AxisDynamics
from gsapp.identification.ftr.settings import FTR_ALGORITHM
from gsapp.quantities import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class RecordInformation:
    """What closed records say about the three equations of one axis; sums over records.

    All of it lies in one table, so that records add up in one step.

    Parameters
    ----------
    table : ndarray, shape (..., 3, K)
        One row for each equation.
    p : int
        Derivatives of an equation.

    Attributes
    ----------
    G : ndarray, shape (..., 3, p, p)
    b : ndarray, shape (..., 3, p)
    meat : ndarray, shape (..., 3, p, p)
        X' R X.
    rss, degrees_of_freedom : ndarray, shape (..., 3)
        Squared residuals over the squared weights of the samples; real equations less unknowns.
    coefficient_energy : ndarray, shape (..., 3)
        Integral of (qbar C)^2 in the band, trim and drift taken out.
    noise : ndarray, shape (..., 3, p)
        Share of the diagonal of G that noise of the regressors makes.
    white : ndarray, shape (..., 3, p)
        What of it is to be taken off the diagonal: white noise of what is no rate.
    mean : ndarray, shape (..., 3, p + 2)
        Sums at zero frequency of qbar x, qbar, qbar C.
    mean_noise : ndarray, shape (..., 3)
        Variance of the last of these.
    effective_time : ndarray, shape (..., 3)
        s.
    pressure_energy : ndarray, shape (..., 3)
        Integral of qbar^2 over that time, Pa^2 s.
    regressor_energy : ndarray, shape (..., 3, p)
        Integral of (qbar x)^2 in the band.
    squared_weight : ndarray, shape (..., 3, p)
        Squared diagonal of G over freedom: tells how many records share the weight.
    """

    table: FloatArray
    p: int

    @staticmethod
    def zero(p: int) -> RecordInformation:
        """Return the information of no record at all."""
        return RecordInformation(np.zeros((3, _layout(p).size)), p)

    @staticmethod
    def empty(moments: int, p: int) -> RecordInformation:
        """Return a table for some moments, to be filled in."""
        return RecordInformation(np.empty((moments, 3, _layout(p).size)), p)

    @staticmethod
    def stacked(several: Sequence[RecordInformation]) -> RecordInformation:
        """Return information at several moments, arrays of shape (U, 3, ...)."""
        first = several[0]
        if all(each is first for each in several):
            table = np.broadcast_to(first.table, (len(several), *first.table.shape))
        else:
            table = np.stack([each.table for each in several])
        return RecordInformation(table, first.p)

    def add(self, other: RecordInformation) -> RecordInformation:
        """Return the information of both together."""
        # In the order of C whatever is broadcast: bits of sums must not depend on the chunking.
        return RecordInformation(np.add(self.table, other.table, order="C"), self.p)

    def discounted(self, share: float) -> RecordInformation:
        """Return the information with the signals behind it faded to a share."""
        return RecordInformation(self.table * _fading(self.p, share), self.p)

    def select_moments(self, moments: slice | int) -> RecordInformation:
        """Return some of several moments."""
        return RecordInformation(self.table[moments], self.p)

    def select_equations(self, equations: BoolArray) -> RecordInformation:
        """Return what some of the equations say, shape (3,) of bool; nothing for the others."""
        return RecordInformation(np.where(equations[:, np.newaxis], self.table, 0.0), self.p)

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {"table": self.table}

    @staticmethod
    def from_state(state: Mapping[str, npt.NDArray[np.generic]], p: int) -> RecordInformation:
        table = np.array(state["table"], dtype=np.float64)
        if table.shape != (3, _layout(p).size):
            raise ValueError(f"information has the shape {table.shape}")
        return RecordInformation(table, p)

    @property
    def G(self) -> FloatArray:  # noqa: N802 - its name in the equations
        return self._square(0)

    @property
    def meat(self) -> FloatArray:
        return self._square(self.p * self.p)

    def _square(self, start: int) -> FloatArray:
        part = self.table[..., start : start + self.p * self.p]
        return part.reshape(*part.shape[:-1], self.p, self.p)

    @property
    def b(self) -> FloatArray:
        return self.table[..., _layout(self.p).b]

    @property
    def noise(self) -> FloatArray:
        return self.table[..., _layout(self.p).noise]

    @property
    def white(self) -> FloatArray:
        return self.table[..., _layout(self.p).white]

    @property
    def regressor_energy(self) -> FloatArray:
        return self.table[..., _layout(self.p).spread]

    @property
    def squared_weight(self) -> FloatArray:
        return self.table[..., _layout(self.p).weighty]

    @property
    def mean(self) -> FloatArray:
        return self.table[..., _layout(self.p).mean]

    @property
    def rss(self) -> FloatArray:
        return self.table[..., -6]

    @property
    def degrees_of_freedom(self) -> FloatArray:
        return self.table[..., -5]

    @property
    def coefficient_energy(self) -> FloatArray:
        return self.table[..., -4]

    @property
    def mean_noise(self) -> FloatArray:
        return self.table[..., -3]

    @property
    def effective_time(self) -> FloatArray:
        return self.table[..., -2]

    @property
    def pressure_energy(self) -> FloatArray:
        return self.table[..., -1]


@dataclass(frozen=True, slots=True, eq=False)
class _Layout:
    """Columns of the table, and the powers of a fading of the signals that they go with."""

    b: slice
    noise: slice
    white: slice
    spread: slice
    weighty: slice
    mean: slice
    size: int
    powers: FloatArray


@cache
def _layout(p: int) -> _Layout:
    start = 2 * p * p
    b, noise, white, spread, weighty = (slice(start + k * p, start + (k + 1) * p) for k in range(5))
    mean = slice(start + 5 * p, start + 6 * p + 2)
    size = mean.stop + 6
    powers = np.full(size, 2.0)
    powers[p * p : start] = powers[weighty] = 4.0
    powers[mean] = 1.0
    powers[-5] = 0.0  # a record keeps the number of its equations
    return _Layout(b, noise, white, spread, weighty, mean, size, powers)


@cache
def _fading(p: int, share: float) -> FloatArray:
    return np.asarray(share ** _layout(p).powers, dtype=np.float64)


def sum_of_squares(rows: FloatArray) -> FloatArray:
    """Return the sums of squares over rows, (U, r, e) -> (U, e)."""
    along = np.swapaxes(rows, 1, 2)
    return np.asarray(np.vecdot(along, along), dtype=np.float64)


def orthonormal_basis(columns: FloatArray, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return an orthonormal basis of columns, and how many of them were not zero.

    Columns of the nuisance may vanish (the transform of a constant does at multiples of 1/T) or
    repeat: the basis then holds zeros in their place.

    `columns`, shape (U, r, k).
    `sizes`, shape (U, k): what the columns are measured against.

    Returns
    -------
    basis : ndarray, shape (U, r, k)
    used : ndarray, shape (U,)
    """
    basis = np.ascontiguousarray(columns.transpose(2, 0, 1))
    basis /= np.maximum(sizes.T, 1e-300)[:, :, np.newaxis]
    least = np.maximum(1e-6 * np.sqrt(np.vecdot(basis, basis)), FTR_ALGORITHM.zero_column_tolerance)
    used = np.zeros(len(columns))
    for index, column in enumerate(basis):
        left = np.sqrt(np.vecdot(column, column))
        counts = left > least[index]
        column *= (counts / np.where(counts, left, 1.0))[:, np.newaxis]  # noqa: PLW2901 - in place
        used += counts
        rest = basis[index + 1 :]
        if len(rest):
            rest -= np.vecdot(column, rest)[:, :, np.newaxis] * column
    return np.ascontiguousarray(basis.transpose(1, 2, 0)), used


def combine_real_imag(rows: FloatArray) -> FloatArray:
    """Return sums of what belongs to real and imaginary parts, (U, 2 m, e) -> (U, m, e)."""
    half = rows.shape[1] // 2
    return np.asarray(rows[:, :half] + rows[:, half:], dtype=np.float64)


def subtract_white_noise(inverse: FloatArray, white: FloatArray) -> FloatArray:
    """Return the inverse of G with white noise taken off its diagonal.

    Of each variable up to 1/(2p) of what it did on its own is taken off: then at least half of G
    stays, whatever the variables. More is not needed where the variable was excited enough to be
    shown. Four terms of the series I + T + T^2 + ... , T = G^-1 N, leave out no more than the
    fourth power of that share.
    """
    diagonal = np.maximum(np.diagonal(inverse, axis1=-2, axis2=-1), 1e-300)
    less = np.minimum(white, 0.5 / diagonal.shape[-1] / diagonal)
    T = inverse * less[..., np.newaxis, :]
    first = inverse + T @ inverse
    return np.asarray(first + T @ (T @ first), dtype=np.float64)


def invert_normal_matrices(G: FloatArray) -> FloatArray:
    """Return the inverse of scaled normal matrices; a variable that did nothing gets zeros."""
    p = G.shape[-1]
    diagonal = np.diagonal(G, axis1=-2, axis2=-1)
    there = diagonal > 0.0
    scale = there / np.sqrt(np.where(there, diagonal, 1.0))
    scales = scale[..., np.newaxis] * scale[..., np.newaxis, :]
    scaled = G * scales
    # A hair on the diagonal keeps columns that are equal to the last bit from stopping it all.
    scaled.reshape(-1, p * p)[:, :: p + 1] += np.where(there, 1e-12, 1.0).reshape(-1, p)
    return np.asarray(np.linalg.inv(scaled) * scales, dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FTRSolution:
    """Estimates at U moments, from one axis's three equations."""

    theta: FloatArray
    """Shape (U, 3, p)."""
    covariance: FloatArray
    """Shape (U, 3, p, p). Honest."""
    std: FloatArray
    """Shape (U, 3, p). Square roots of its diagonal."""
    plain: FloatArray
    """Shape (U, 3, p). Standard deviation if residuals were white."""
    bias: FloatArray
    bias_std: FloatArray
    """Shape (U, 3). The constant part of the coefficient; the zero offset of its accelerometer is
    in its bound."""
    bias_slopes: FloatArray
    """Shape (U, 3, p). Derivatives of the bias by theta: minus the mean of each variable."""
    signal_to_noise: FloatArray
    """Shape (U, 3, p). What each variable did on its own (not explained by the others), over its
    noise."""
    alone: FloatArray
    """Shape (U, 3, p). Share of its energy that a variable had on its own, 0 to 1."""
    amplitude: FloatArray
    """Shape (U, 3, p). Rms of each variable in the band over the time listened to, in its unit."""
    uncertain: FloatArray
    """Shape (U, 3, p + 1). Bound times what the variable did, over what the coefficient did; of the
    bias, last."""
    freedom: FloatArray
    """Shape (U, 3). Real equations less unknowns."""
    listened: FloatArray
    """Shape (U, 3). Effective time, s."""
    correlation: FloatArray
    """Shape (U, 3, p, p). Of the regressors in the band."""

    def covariance_with_bias(self, equation: int) -> FloatArray:
        """Return the last covariance of an equation, bias first, shape (p + 1, p + 1)."""
        inner = self.covariance[-1, equation]
        cross = inner @ self.bias_slopes[-1, equation]
        p = len(inner)
        out = np.empty((p + 1, p + 1))
        out[1:, 1:] = inner
        out[0, 1:] = out[1:, 0] = cross
        out[0, 0] = self.bias_std[-1, equation] ** 2
        return out

    def widened(self, stds: FloatArray) -> FTRSolution:
        """Return the solution with what is not known of some derivatives in the bounds of all.

        `stds`, shape (U, 3, p): how far off each may be; zero where its own bound says it.
        """
        variances = np.diagonal(self.covariance, axis1=-2, axis2=-1)
        # What the others become when one is changed: a column of the covariance over its variance.
        moved = np.divide(
            self.covariance * stds[..., np.newaxis, :],
            variances[..., np.newaxis, :],
            out=np.zeros_like(self.covariance),
            where=variances[..., np.newaxis, :] > 0.0,
        )
        covariance = self.covariance + moved @ np.swapaxes(moved, -1, -2)
        std = np.sqrt(np.maximum(np.diagonal(covariance, axis1=-2, axis2=-1), 0.0))
        # The constant is that of the flight as it was: the mean of what is withheld belongs to it.
        by_bias = np.vecmat(self.bias_slopes, moved) - self.bias_slopes * stds
        bias_std = np.sqrt(self.bias_std**2 + np.vecdot(by_bias, by_bias))
        before = np.concatenate((self.std, self.bias_std[..., np.newaxis]), axis=-1)
        after = np.concatenate((std, bias_std[..., np.newaxis]), axis=-1)
        ratio = np.divide(after, before, out=np.ones_like(after), where=before > 0.0)
        return replace(
            self, covariance=covariance, std=std, bias_std=bias_std,
            uncertain=self.uncertain * ratio,
        )  # fmt: skip

    def select_moment(self, moment: int) -> FTRSolution:
        """Return one moment (U = 1)."""
        place = moment % len(self.theta)
        return FTRSolution(
            **{one.name: getattr(self, one.name)[place : place + 1].copy() for one in fields(self)}
        )

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @staticmethod
    def from_state(state: Mapping[str, npt.NDArray[np.generic]]) -> FTRSolution:
        names = (one.name for one in fields(FTRSolution))
        return FTRSolution(**{name: np.array(state[name], dtype=np.float64) for name in names})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SolvableInformation:
    """What there is to conclude from at U moments."""

    information: RecordInformation
    """Of all records, arrays of shape (U, 3, ...)."""
    inverse: FloatArray
    """Shape (U, 3, p, p). Of its G, white noise of the regressors taken off."""

    @staticmethod
    def from_closed_records(past: RecordInformation) -> SolvableInformation:
        """Return what closed records alone say, at U moments."""
        return SolvableInformation(
            information=past,
            inverse=subtract_white_noise(invert_normal_matrices(past.G), past.white),
        )

    @staticmethod
    def concatenate(parts: Sequence[SolvableInformation]) -> SolvableInformation:
        """Return moments one after the other."""
        if len(parts) == 1:
            return parts[0]
        tables = np.concatenate([part.information.table for part in parts])
        return SolvableInformation(
            information=RecordInformation(tables, parts[0].information.p),
            inverse=np.concatenate([part.inverse for part in parts]),
        )


def solve_estimates(evidence: SolvableInformation, body: AxisDynamics) -> FTRSolution:
    """Return estimates and their qualities."""
    information, inverse = evidence.information, evidence.inverse
    G = information.G
    p = G.shape[-1]
    theta = np.matvec(inverse, information.b)
    diagonal: FloatArray = np.diagonal(G, axis1=2, axis2=3)
    wide = _bound_inflation(diagonal**2 / np.maximum(information.squared_weight, 1e-300))
    covariance = inverse @ information.meat @ inverse
    covariance *= wide[..., np.newaxis] * wide[..., np.newaxis, :]
    there = diagonal > 0.0
    natural = np.where(there, diagonal, 1.0)
    variance = np.diagonal(inverse, axis1=2, axis2=3)
    own = np.where(there, np.minimum(1.0 / np.where(there, variance, 1.0), diagonal), 0.0)
    base = information.mean[..., p]
    safe = np.where(base > 0.0, base, 1.0)
    slopes = np.divide(-information.mean[..., :p], safe[..., np.newaxis], order="C")
    bias = information.mean[..., p + 1] / safe + np.vecdot(slopes, theta)
    through = np.vecdot(np.matvec(covariance, slopes), slopes)
    # The mean square of qbar over the time listened to.
    square = information.pressure_energy / np.maximum(information.effective_time, 1e-300)
    zero = body.accelerometer_offset**2 / np.where(square > 0.0, square, 1.0)
    bias_std = np.sqrt(np.maximum(through + information.mean_noise / safe**2 + zero, 0.0))
    std = np.sqrt(np.maximum(np.diagonal(covariance, axis1=2, axis2=3), 0.0))
    variation = np.sqrt(np.maximum(information.coefficient_energy, 1e-300))
    uncertain = np.concatenate(
        (
            std * np.sqrt(information.regressor_energy) / variation[..., np.newaxis],
            (bias_std * np.sqrt(information.pressure_energy) / variation)[..., np.newaxis],
        ),
        axis=-1,
    )
    noise = np.maximum(information.noise, 1e-300)
    # What white noise made of G is taken off already.
    left = information.noise - information.white
    scale = np.sqrt(natural)
    return FTRSolution(
        theta=theta,
        covariance=covariance,
        std=std,
        # Records are weighted by one over the variance of their residuals.
        plain=np.sqrt(np.maximum(variance, 0.0)),
        bias=bias,
        bias_std=bias_std,
        bias_slopes=slopes,
        signal_to_noise=np.sqrt(np.maximum(own - left, 0.0) / noise),
        alone=np.where(there, own / natural, 0.0),
        amplitude=np.sqrt(
            information.regressor_energy
            / np.maximum(information.pressure_energy, 1e-300)[..., np.newaxis]
        ),
        uncertain=uncertain,
        freedom=information.degrees_of_freedom,
        listened=information.effective_time,
        correlation=G / (scale[..., np.newaxis] * scale[..., np.newaxis, :]),
    )


def _bound_inflation(freedom: FloatArray) -> FloatArray:
    """Return what widens bounds so that three of them hold as much as of a normal distribution.

    The level of the residuals is itself estimated, around each frequency from its neighbors: as
    if from two thirds of all residuals. (Student's quantile over three, expanded.)
    """
    levels = np.maximum(2.0 / 3.0 * freedom, 4.0)
    return np.asarray(1.0 + 2.5 / levels + 5.75 / levels**2, dtype=np.float64)
