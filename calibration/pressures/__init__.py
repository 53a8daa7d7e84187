"""Pressures: zero with the pitot covered, a breath into it, and the air on the ground."""

from calibration.pressures.breath import BlowDetector, BlowReading, BlowState
from calibration.pressures.ground import GroundAir
from calibration.pressures.known import (
    WIND,
    PressureZero,
    covered_watch,
    dynamic_zero,
    static_check,
)

__all__ = [
    "WIND",
    "BlowDetector",
    "BlowReading",
    "BlowState",
    "GroundAir",
    "PressureZero",
    "covered_watch",
    "dynamic_zero",
    "static_check",
]
