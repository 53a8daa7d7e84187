"""What ``flight.toml`` holds: the facts about a flight that no instrument writes down."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib import metadata
from typing import Any

from pydantic import Field, field_validator

from gsapp.foundation import StrictModel
from gsapp.quantities.fields import Angle, Frequency, Mass, Pressure, Speed, Temperature, Weight

# The unit in which each value with a unit is written; the file may be edited in any other.
_WRITTEN_UNITS: dict[str, str] = {
    "takeoff_weight": "N",
    "landing_weight": "N",
    "fuel": "kg",
    "grid_rate": "Hz",
    "temperature": "K",
    "pressure": "Pa",
    "wind_speed": "m/s",
    "wind_from": "rad",
}


class Weather(StrictModel):
    """The air at the field.

    Attributes
    ----------
    temperature : float or None
        K.
    pressure : float or None
        At the field, not reduced to sea level, Pa.
    wind_speed : float or None
        m/s.
    wind_from : float or None
        Direction the wind comes from, from true north, rad.
    remarks : str
        Gusts, clouds, thermals, in words.
    """

    temperature: Temperature | None = None
    pressure: Pressure | None = None
    wind_speed: Speed | None = None
    wind_from: Angle | None = None
    remarks: str = ""


class FlightInfo(StrictModel):
    """The content of ``flight.toml``. Every value is SI once read; None = not known.

    Attributes
    ----------
    name : str
        What the crew calls the flight.
    date : datetime or None
        When the record began; with its time zone.
    aircraft : str
        Name of the aircraft file in force.
    takeoff_weight, landing_weight : float or None
        N. A scale's pounds may be written as ``"64.5 lb"``.
    fuel : float or None
        On board at take-off, kg.
    weather : Weather
        The air at the field.
    crew : mapping of str to str
        Role to name.
    notes, pilot_comments : str
        In words, as many lines as needed.
    source : str
        The link, or the file that was imported.
    channel_map : str
        Name of the channel map in force.
    onboard_log : str
        File name of the on-board log inside the folder; empty if there is none.
    grid_rate : float or None
        Samples per second of the grid, Hz; None leaves it to the reader.
    versions : mapping of str to str
        Of the program and of what it reads with.
    """

    name: str = ""
    date: datetime | None = None
    aircraft: str = ""
    takeoff_weight: Weight | None = None
    landing_weight: Weight | None = None
    fuel: Mass | None = None
    weather: Weather = Weather()
    crew: Mapping[str, str] = Field(default_factory=dict)
    notes: str = ""
    pilot_comments: str = ""
    source: str = ""
    channel_map: str = ""
    onboard_log: str = ""
    grid_rate: Frequency | None = None
    versions: Mapping[str, str] = Field(default_factory=dict)

    @field_validator("onboard_log")
    @classmethod
    def _must_stay_inside(cls, value: str) -> str:
        if "/" in value or "\\" in value or value in (".", ".."):
            raise ValueError(
                f"'{value}' is not a plain file name; copy the log into the flight folder and "
                "write its name only"
            )
        return value

    @field_validator("date")
    @classmethod
    def _must_have_a_zone(cls, value: datetime | None) -> datetime | None:
        if value is not None and value.tzinfo is None:
            return value.astimezone()
        return value

    def content(self) -> dict[str, Any]:
        """Return what a TOML file holds: values with units as text, empty ones left out."""
        return _written(self.model_dump())


def _written(values: Mapping[str, Any]) -> dict[str, Any]:
    content: dict[str, Any] = {}
    for key, value in values.items():
        if value is None or value == "":
            continue
        if isinstance(value, Mapping):
            inner = _written(value)
            if inner:
                content[key] = inner
        elif key in _WRITTEN_UNITS and isinstance(value, float):
            content[key] = f"{value!r} {_WRITTEN_UNITS[key]}"
        else:
            content[key] = value
    return content


def current_versions() -> dict[str, str]:
    """Return the versions of the program and of the libraries that shape its numbers."""
    versions = {"python": platform.python_version()}
    for package in ("gsapp-ground-station", "numpy", "scipy", "pymavlink"):
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return versions


def now() -> datetime:
    """Return the present time, to the second, in the zone of the place."""
    return datetime.now(UTC).astimezone().replace(microsecond=0)
