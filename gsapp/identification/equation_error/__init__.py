"""Equation error: each coefficient regressed on what explains it, no integration."""

from gsapp.identification.equation_error.estimator import estimate
from gsapp.identification.equation_error.start_value_regression import estimate_start_values

__all__ = ["estimate", "estimate_start_values"]
