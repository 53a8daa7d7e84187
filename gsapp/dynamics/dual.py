"""Numbers that carry their derivatives: formulas written once give value and Jacobian.

A `Dual` holds a value of shape (n,) and its derivatives by m quantities, shape (n, m). What is
done to it is done to both, exactly. Used where the formula is short and its hand-made derivative
would be longer than the formula.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gsapp.quantities import FloatArray


class Dual:
    """A value with its derivatives.

    Parameters
    ----------
    value : ndarray, shape (n,)
    derivative : ndarray, shape (n, m)
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
