"""Measured quantities in files: a value with its unit, or a pair of value and standard deviation.

``["5.00 ft", "0.01 ft"]`` is read as `MeasuredValue`, SI; ``"5.00 ft"`` as one without uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator

from gsapp.quantities import units


class MeasuredValue(NamedTuple):
    """A quantity with its standard deviation, SI."""

    value: float
    std: float = 0.0


def _measured_validator(key: str) -> BeforeValidator:
    def read(given: Any) -> MeasuredValue:
        if isinstance(given, (list, tuple)):
            if len(given) != 2:
                raise ValueError(
                    'must be a value, or a pair of value and standard deviation; write ["5.00 ft", '
                    '"0.01 ft"]'
                )
            value, std = (units.parse_quantity(one, key) for one in given)
            if std < 0.0:
                raise ValueError("the standard deviation is negative; write it positive")
            return MeasuredValue(value, std)
        return MeasuredValue(units.parse_quantity(given, key))

    parser: Callable[[Any], MeasuredValue] = read
    return BeforeValidator(parser)


MeasuredLength = Annotated[MeasuredValue, _measured_validator("length")]
MeasuredWeight = Annotated[MeasuredValue, _measured_validator("weight")]
MeasuredMass = Annotated[MeasuredValue, _measured_validator("mass")]
MeasuredAngle = Annotated[MeasuredValue, _measured_validator("angle")]
