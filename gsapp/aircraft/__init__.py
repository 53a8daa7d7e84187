"""The aircraft as a file: geometry, mass, propulsion, instruments, controls, limits."""

from gsapp.aircraft.aircraft_loader import (
    SHIPPED_AIRCRAFT,
    file_warnings,
    load_aircraft,
    shipped_aircraft,
    write_sensor_values,
)
from gsapp.aircraft.config import (
    Accelerometer,
    Accuracy,
    Aircraft,
    AirData,
    AlphaVane,
    BetaVane,
    Control,
    Geometry,
    Gyro,
    Limits,
    MassProperties,
    Propulsion,
    Sensors,
)

__all__ = [
    "SHIPPED_AIRCRAFT",
    "Accelerometer",
    "Accuracy",
    "AirData",
    "Aircraft",
    "AlphaVane",
    "BetaVane",
    "Control",
    "Geometry",
    "Gyro",
    "Limits",
    "MassProperties",
    "Propulsion",
    "Sensors",
    "file_warnings",
    "load_aircraft",
    "shipped_aircraft",
    "write_sensor_values",
]
