"""One set of formulas for single numbers and for whole arrays.

NumPy costs a microsecond for every operation on a single number, the `math` module a tenth of
that; for arrays it is the other way around. Formulas written once ask here for the functions
that fit their argument. NumPy 2 has the names of `math` (`atan2`, `asin`, ...).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gsapp.quantities import FloatArray

Value = float | FloatArray
"""A number, or an array of shape (n,) with one number for each sample."""


def array_namespace(value: Value | Dual) -> Any:
    """Return `math` for a single float, `Dual` for one with derivatives, else `numpy`."""
    if isinstance(value, float):
        return math
    return Dual if isinstance(value, Dual) else np


def clip(value: Value, low: Value, high: Value) -> Value:
    """Return `value` limited to the range from `low` to `high`."""
    if isinstance(value, float) and isinstance(low, float) and isinstance(high, float):
        return low if value < low else high if value > high else value
    return np.clip(value, low, high)


def where(condition: Any, yes: Value, no: Value) -> Value:
    """Return `yes` where the condition holds, `no` elsewhere."""
    if isinstance(condition, bool):
        return yes if condition else no
    return np.asarray(np.where(condition, yes, no), dtype=np.float64)


class Dual:
    """A value, shape (n,), with its derivatives by m quantities, shape (n, m).

    What is done to it is done to both, exactly. Used where the formula is short and its hand-made
    derivative would be longer than the formula.
    """

    __slots__ = ("derivative", "value")
    # Arrays on the left leave the operation to this class.
    __array_ufunc__ = None

    def __init__(self, value: FloatArray, derivative: FloatArray) -> None:
        self.value = value
        self.derivative = derivative

    def _chain(self, value: FloatArray, factor: FloatArray) -> Dual:
        return Dual(value, factor[:, None] * self.derivative)

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.derivative)

    def __add__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return Dual(self.value + other.value, self.derivative + other.derivative)
        return Dual(self.value + other, self.derivative)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Dual:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Dual:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return Dual(
                self.value * other.value,
                self.value[:, None] * other.derivative + other.value[:, None] * self.derivative,
            )
        return self._chain(self.value * other, other + np.zeros_like(self.value))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        return self.__mul__(1.0 / other)

    def __rtruediv__(self, other: Any) -> Dual:
        inverse = 1.0 / self.value
        return self._chain(other * inverse, -other * inverse * inverse)

    # The functions of `gsapp.dynamics.arithmetic.array_namespace`.

    @staticmethod
    def sin(x: Dual) -> Dual:
        return x._chain(np.sin(x.value), np.cos(x.value))

    @staticmethod
    def cos(x: Dual) -> Dual:
        return x._chain(np.cos(x.value), -np.sin(x.value))

    @staticmethod
    def sqrt(x: Dual) -> Dual:
        root = np.sqrt(x.value)
        return x._chain(root, 0.5 / root)

    @staticmethod
    def asin(x: Dual) -> Dual:
        return x._chain(np.asin(x.value), 1.0 / np.sqrt(1.0 - x.value * x.value))

    @staticmethod
    def atan2(y: Dual, x: Dual) -> Dual:
        square = x.value * x.value + y.value * y.value
        slope = (x.value / square)[:, None] * y.derivative - (y.value / square)[
            :, None
        ] * x.derivative
        return Dual(np.atan2(y.value, x.value), slope)
