"""Measured quantities in files: a value with its unit, or a pair of value and standard deviation.

``["5.00 ft", "0.01 ft"]`` is read as `Measured`, SI; ``"5.00 ft"`` as one without uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator

from gsapp.quantities import units


class Measured(NamedTuple):
    """A quantity with its standard deviation, SI."""

    value: float
    std: float = 0.0


def _measured(key: str) -> BeforeValidator:
    def read(given: Any) -> Measured:
        if isinstance(given, (list, tuple)):
            if len(given) != 2:
                raise ValueError(
                    'must be a value, or a pair of value and standard deviation; write ["5.00 ft", '
                    '"0.01 ft"]'
                )
            value, std = (units.parse(one, key) for one in given)
            if std < 0.0:
                raise ValueError("the standard deviation is negative; write it positive")
            return Measured(value, std)
        return Measured(units.parse(given, key))

    parser: Callable[[Any], Measured] = read
    return BeforeValidator(parser)


MeasuredLength = Annotated[Measured, _measured("length")]
MeasuredWeight = Annotated[Measured, _measured("weight")]
MeasuredMass = Annotated[Measured, _measured("mass")]
MeasuredAngle = Annotated[Measured, _measured("angle")]
