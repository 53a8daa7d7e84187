"""What weighing an aircraft and swinging it as a pendulum share: measured values, uncertainties.

``["5.00 ft", "0.01 ft"]`` is read as `MeasuredValue`, SI; ``"5.00 ft"`` as one without uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Final, NamedTuple

from pydantic import BeforeValidator

from gsapp.quantities import units
from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundTestSettings:
    """Engineering choices."""

    scale_std: float = 0.1  # Of a scale's reading where none is given, N: ten grams.
    axle_std: float = 0.002  # Standard deviation of an axle's place where none is given, m.
    level_std: float = 0.5 * DEGREE  # Of the attitude on the scales where none is given, rad.
    min_axle_distance: float = 0.02  # m: closer axles tell nothing of the CG between them.
    time_range: tuple[float, float] = (0.01, 1e5)  # Of the swings in one time, s.
    max_cycles: int = 10_000  # Of one time.
    max_measured: float = 1e6  # SI: kilometers and a hundred tons.
    stopwatch_std: float = 0.05  # Of a single time taken by hand, s.
    max_mass_height_ratio: float = 0.4
    """Rms height of the mass over the radius of gyration about z, never reached by an aircraft
    of usual shape: wing, tail and fuselage lie nearly in one plane."""


GROUND_TESTS: Final = GroundTestSettings()


class MeasuredValue(NamedTuple):
    """A quantity with its standard deviation, SI."""

    value: float
    std: float = 0.0


def _parse(given: Any, key: str) -> float:
    value = units.parse_quantity(given, key)
    if abs(value) > GROUND_TESTS.max_measured:
        raise ValueError(f"{given} is out of range; correct the number or its unit")
    return value


def _measured_validator(key: str) -> BeforeValidator:
    def read(given: Any) -> MeasuredValue:
        if isinstance(given, (list, tuple)):
            if len(given) != 2:
                raise ValueError(
                    'must be a value, or a pair of value and standard deviation; write ["5.00 ft", '
                    '"0.01 ft"]'
                )
            value, std = (_parse(one, key) for one in given)
            if std < 0.0:
                raise ValueError("the standard deviation is negative; write it positive")
            return MeasuredValue(value, std)
        return MeasuredValue(_parse(given, key))

    parser: Callable[[Any], MeasuredValue] = read
    return BeforeValidator(parser)


MeasuredLength = Annotated[MeasuredValue, _measured_validator("length")]
MeasuredWeight = Annotated[MeasuredValue, _measured_validator("weight")]
MeasuredMass = Annotated[MeasuredValue, _measured_validator("mass")]
MeasuredAngle = Annotated[MeasuredValue, _measured_validator("angle")]
