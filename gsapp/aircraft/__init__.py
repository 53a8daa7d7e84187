"""The aircraft as a file: geometry, mass, propulsion, instruments, controls, limits."""

from gsapp.aircraft.aircraft_loader import file_warnings, load_aircraft, shipped_aircraft
from gsapp.aircraft.config import (
    Accelerometer,
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
    "Accelerometer",
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
]
