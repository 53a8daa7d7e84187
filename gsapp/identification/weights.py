"""Files with the weights of the responses (W1 of (5.1.4)), per flight, with their units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field, field_validator

from gsapp.dynamics.sensors import OUTPUTS
from gsapp.foundation import StrictModel, read_toml
from gsapp.foundation.files import ShippedFiles
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import channel, normalize_unit, to_si

SHIPPED_WEIGHTS = ShippedFiles(folder=Path(__file__).parent / "weights", kind="weights")
_LARGEST = 1_000_000_000
Weight = Annotated[float, Field(strict=True)]


class Weights(StrictModel):
    """A weights file, read."""

    name: str = "weights"
    source: str = ""
    units: dict[str, str] = Field(default_factory=dict)
    """By response: unit of the residual that the weight multiplies. SI where left out."""
    default: dict[str, Weight] = Field(default_factory=dict)
    """Weights for every flight, in those units: a residual of one unit adds half the weight to the
    sum of (5.1.4). 0 switches a response off."""
    flights: dict[str, dict[str, Weight]] = Field(default_factory=dict)
    """By flight: what differs from the default."""

    @field_validator("units")
    @classmethod
    def _known_units(cls, value: dict[str, str]) -> dict[str, str]:
        _check_responses(value)
        return {name: normalize_unit(unit, channel(name).quantity) for name, unit in value.items()}

    @field_validator("default")
    @classmethod
    def _sound(cls, value: dict[str, float]) -> dict[str, float]:
        _check_weights(value)
        return value

    @field_validator("flights")
    @classmethod
    def _all_sound(cls, value: dict[str, dict[str, float]]) -> dict[str, dict[str, float]]:
        for weights in value.values():
            _check_weights(weights)
        return value

    def for_flight(self, flight: str = "") -> dict[str, float]:
        """Return the weight of each response in SI, the default's where the flight has none.

        `flight`: its name. ``Flight B``, ``flight_b`` and ``B`` are the same flight.
        """
        own: Mapping[str, float] = {}
        for name, weights in self.flights.items():
            if _normalize_flight_name(name) == _normalize_flight_name(flight):
                own = weights
        found = {}
        for name, weight in {**self.default, **own}.items():
            spec = channel(name)
            # A difference of one unit, in SI: offsets (degC) fall out.
            unit = self.units.get(name, spec.unit)
            size = to_si(1.0, unit, spec.quantity) - to_si(0.0, unit, spec.quantity)
            found[name] = weight / (size * size)
        return found


def shipped_weights() -> tuple[str, ...]:
    """Return the names of the weights files that come with the program."""
    return SHIPPED_WEIGHTS.names()


def load_weights(name_or_path: str | Path) -> Weights:
    """Read a weights file.

    `name_or_path`: A path, or the name of a shipped file: ``table-6.2.7``.

    Raises `FileProblemsError` if the file holds mistakes; all are named. Raises `UnknownNameError`
    if there is neither such a file nor such a shipped one.
    """
    return read_toml(SHIPPED_WEIGHTS.find(name_or_path), Weights)


def _normalize_flight_name(flight: str) -> str:
    return re.sub(r"^flight", "", re.sub(r"[\s_-]+", "", flight.casefold()))


def _check_responses(value: Mapping[str, object]) -> None:
    unknown = [name for name in value if name not in OUTPUTS]
    if unknown:
        hint = did_you_mean(unknown[0], OUTPUTS, f"choose from {', '.join(OUTPUTS)}")
        raise ValueError(f"'{unknown[0]}' is not a response; {hint}")


def _check_weights(value: Mapping[str, float]) -> None:
    _check_responses(value)
    for name, weight in value.items():
        if not 0.0 <= weight <= _LARGEST:
            raise ValueError(
                f"the weight of {name} is {weight:g}; give 0 or more, {_LARGEST:g} at most"
            )
