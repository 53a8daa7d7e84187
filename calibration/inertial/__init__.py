"""Gyros and accelerometers: zeros, scales, misalignment, and the factory's figures."""

from calibration.inertial.accelerometers import (
    ACCELEROMETERS,
    POSITION_TEXT,
    POSITIONS,
    AccelerometerFit,
    Position,
    PositionReading,
    SixPositionResult,
    calibrate_accelerometers,
    recognize_position,
    specific_force,
)
from calibration.inertial.factory_comparison import (
    FactoryCalibration,
    SensorVerdict,
    factory_calibrations,
)
from calibration.inertial.gyros import (
    GYROS,
    GyroZero,
    create_inertial_rest_monitor,
    gyro_certificate,
    gyro_zero,
)
from calibration.inertial.turn_detection import TurnMonitor, TurnStatus
from calibration.inertial.turntable import GyroScale, Turn, evaluate_turn, gyro_scale

__all__ = [
    "ACCELEROMETERS",
    "GYROS",
    "POSITIONS",
    "POSITION_TEXT",
    "AccelerometerFit",
    "FactoryCalibration",
    "GyroScale",
    "GyroZero",
    "Position",
    "PositionReading",
    "SensorVerdict",
    "SixPositionResult",
    "Turn",
    "TurnMonitor",
    "TurnStatus",
    "calibrate_accelerometers",
    "create_inertial_rest_monitor",
    "evaluate_turn",
    "factory_calibrations",
    "gyro_certificate",
    "gyro_scale",
    "gyro_zero",
    "recognize_position",
    "specific_force",
]
