"""Equation error: each coefficient regressed on what explains it, no integration."""

from gsapp.identification.equation_error.estimate import estimate
from gsapp.identification.equation_error.quick import start_values
from gsapp.identification.equation_error.signs import suspicious_signs

__all__ = ["estimate", "start_values", "suspicious_signs"]
