"""Which station looks after which group."""

from __future__ import annotations

from calibration.wizard.accelerometer_procedure import AccelerometerProcedure
from calibration.wizard.angle_procedure import AngleProcedure
from calibration.wizard.gyro_procedure import GyroProcedure
from calibration.wizard.pressure_procedure import PressureProcedure
from calibration.wizard.procedure import CalibrationProcedure, JournalHeader, ReferenceCertificates
from calibration.wizard.state import InstrumentGroup


def create_procedure(
    group: InstrumentGroup, header: JournalHeader, reference: ReferenceCertificates
) -> CalibrationProcedure:
    """Return what looks after a group.

    Raises
    ------
    CalibrationError
        If it lacks something that it starts from.
    """
    kind = group.instruments[0].kind
    if kind == "gyro":
        return GyroProcedure(group, header, reference)
    if kind == "accelerometer":
        return AccelerometerProcedure(group, header, reference)
    if kind == "pressure":
        return PressureProcedure(group, header, reference)
    return AngleProcedure(group.instruments[0], header, reference)
