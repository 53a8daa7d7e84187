"""What records say about the three equations of one axis, in one table that adds up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

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
