"""Equation error: each coefficient regressed on what explains it, no integration."""

from gsapp.identification.equation_error.estimator import estimate, estimate_start_values

__all__ = ["estimate", "estimate_start_values"]
