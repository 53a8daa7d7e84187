"""The air on the ground, entered by the crew for the air data."""

from __future__ import annotations

from dataclasses import dataclass

from calibration.points import CalibrationError
from gsapp.quantities import to_si


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundAir:
    """The air at the field as entered."""

    pressure: float
    """Not reduced to sea level, Pa."""
    temperature: float
    """K."""

    @classmethod
    def from_input(
        cls, pressure: float, pressure_unit: str, temperature: float, temperature_unit: str
    ) -> GroundAir:
        """Return what was entered, if air at a field can be so.

        Raises
        ------
        CalibrationError
            If the pressure or the temperature cannot be that of a field.
        UnitError
            If a unit is not one of pressure, or of temperature.
        """
        pascal = to_si(pressure, pressure_unit, "pressure")
        kelvin = to_si(temperature, temperature_unit, "temperature")
        if not 60e3 <= pascal <= 108e3:
            raise CalibrationError(
                f"{pressure:g} {pressure_unit} is not plausible; enter the barometer reading at "
                "the field, such as 1000 hPa"
            )
        if not 233.0 <= kelvin <= 328.0:
            raise CalibrationError(
                f"{temperature:g} {temperature_unit} is not plausible; enter the air "
                "temperature in the shade"
            )
        return cls(pressure=pascal, temperature=kelvin)
