"""One set of formulas for single numbers and for whole arrays.

NumPy costs a microsecond for every operation on a single number, the `math` module a tenth of
that; for arrays it is the other way around. Formulas written once ask here for the functions
that fit their argument. NumPy 2 has the names of `math` (`atan2`, `asin`, ...).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gsapp.dynamics.dual import Dual
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
