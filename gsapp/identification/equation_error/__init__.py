"""Equation error: each coefficient regressed on what explains it, no integration."""

from gsapp.identification.equation_error.estimate import estimate
from gsapp.identification.equation_error.quick import start_values

__all__ = ["estimate", "start_values"]
