"""Pressures: zero with the pitot covered, a breath into it, and the air on the ground."""

from calibration.pressures.ground_air import GroundAir
from calibration.pressures.known_pressure import (
    PressureZero,
    create_covered_pitot_monitor,
    dynamic_pressure_zero,
    static_pressure_check,
)
from calibration.pressures.pitot_blow import PitotBlowDetector, PitotBlowState, PitotBlowStatus

__all__ = [
    "GroundAir",
    "PitotBlowDetector",
    "PitotBlowState",
    "PitotBlowStatus",
    "PressureZero",
    "create_covered_pitot_monitor",
    "dynamic_pressure_zero",
    "static_pressure_check",
]
