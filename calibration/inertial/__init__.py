"""Gyros and accelerometers: zeros, scales, misalignment, and the factory's figures."""

from calibration.inertial.accelerometers import (
    ACCELEROMETERS,
    POSITION_WORDS,
    POSITIONS,
    AccelerometerFit,
    Position,
    PositionReading,
    SixPositions,
    recognize_position,
    six_positions,
    specific_force,
)
from calibration.inertial.gyros import (
    GYROS,
    GyroZero,
    gyro_certificate,
    gyro_zero,
    still_watch,
)
from calibration.inertial.turning import TurnReading, TurnWatch
from calibration.inertial.turntable import GyroScale, Turn, gyro_scale, turntable_scale
from calibration.inertial.verdict import FactoryFigures, Verdict, factory_figures

__all__ = [
    "ACCELEROMETERS",
    "GYROS",
    "POSITIONS",
    "POSITION_WORDS",
    "AccelerometerFit",
    "FactoryFigures",
    "GyroScale",
    "GyroZero",
    "Position",
    "PositionReading",
    "SixPositions",
    "Turn",
    "TurnReading",
    "TurnWatch",
    "Verdict",
    "factory_figures",
    "gyro_certificate",
    "gyro_scale",
    "gyro_zero",
    "recognize_position",
    "six_positions",
    "specific_force",
    "still_watch",
    "turntable_scale",
]
