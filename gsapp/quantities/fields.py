"""Types for pydantic models: a value with its unit in the file, SI inside.

``wing_area: Area`` reads ``"11.33 ft^2"`` and holds 1.0526 (m^2).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BeforeValidator

from gsapp.quantities import units


def _reader(key: str) -> BeforeValidator:
    def read(value: Any) -> float:
        return units.parse_quantity(value, key)

    parser: Callable[[Any], float] = read
    return BeforeValidator(parser)


Ratio = Annotated[float, _reader("ratio")]
Time = Annotated[float, _reader("time")]
Angle = Annotated[float, _reader("angle")]
AngularRate = Annotated[float, _reader("angular_rate")]
RotationSpeed = Annotated[float, _reader("rotation_speed")]
Frequency = Annotated[float, _reader("frequency")]
Length = Annotated[float, _reader("length")]
Area = Annotated[float, _reader("area")]
Volume = Annotated[float, _reader("volume")]
Speed = Annotated[float, _reader("speed")]
Acceleration = Annotated[float, _reader("acceleration")]
Mass = Annotated[float, _reader("mass")]
MassFlow = Annotated[float, _reader("mass_flow")]
Force = Annotated[float, _reader("force")]
Weight = Annotated[float, _reader("weight")]
Inertia = Annotated[float, _reader("inertia")]
Density = Annotated[float, _reader("density")]
Pressure = Annotated[float, _reader("pressure")]
Temperature = Annotated[float, _reader("temperature")]
Voltage = Annotated[float, _reader("voltage")]
Position = tuple[Length, Length, Length]
