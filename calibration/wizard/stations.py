"""Which station looks after which group."""

from __future__ import annotations

from calibration.wizard.accelerometer_station import AccelerometerStation
from calibration.wizard.gyro_station import GyroStation
from calibration.wizard.hand_station import HandStation
from calibration.wizard.pressure_station import PressureStation
from calibration.wizard.state import Group
from calibration.wizard.station import Header, Reference, Station


def station_of(group: Group, header: Header, reference: Reference) -> Station:
    """Return what looks after a group.

    Raises
    ------
    CalibrationError
        If it lacks something that it starts from.
    """
    kind = group.instruments[0].kind
    if kind == "gyro":
        return GyroStation(group, header, reference)
    if kind == "accelerometer":
        return AccelerometerStation(group, header, reference)
    if kind == "pressure":
        return PressureStation(group, header, reference)
    return HandStation(group.instruments[0], header, reference)
