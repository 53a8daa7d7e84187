"""The flight card, ``flight.toml``: the facts about a flight that no instrument writes down."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib import metadata
from typing import Any, Literal

from pydantic import Field, field_validator, model_validator

from gsapp.aircraft.weighing import WeighingRecord
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.foundation import StrictModel
from gsapp.quantities.fields import (
    Angle,
    Frequency,
    Mass,
    Position,
    Pressure,
    Ratio,
    Speed,
    Temperature,
    Weight,
)

Lever = Literal["elevator", "aileron", "rudder", "throttle", "flap", "gear"]
Stick = Literal["elevator", "aileron", "rudder"]


class DualRate(StrictModel):
    """Throw of one stick at either position of the rate switch."""

    high: Ratio = 1.0
    low: Ratio = 1.0
    """Shares of the full throw."""
    expo: Ratio = 0.0
    """Softness about the center: 0 is a straight line, 1 all cubic."""

    @model_validator(mode="after")
    def _must_make_sense(self) -> DualRate:
        if not 0.0 < self.low <= self.high <= FLIGHT_DATA.max_throw:
            raise ValueError(
                'needs 0 % < low <= high <= 150 %; write for example high = "100 %", low = "60 %"'
            )
        if not -1.0 <= self.expo <= 1.0:
            raise ValueError("expo lies from -100 % to 100 %; write it as the transmitter shows it")
        return self


class Mixer(StrictModel):
    """One lever that moves another's servo as well."""

    source: Lever
    target: Lever
    """``aileron`` with target ``rudder`` turns the rudder with the ailerons."""
    share: Ratio
    """Of the target's throw at full throw of the source."""

    @model_validator(mode="after")
    def _must_make_sense(self) -> Mixer:
        if self.source == self.target:
            raise ValueError("mixes a lever with itself; name another target")
        if not abs(self.share) <= FLIGHT_DATA.max_throw:
            raise ValueError('share is beyond 150 %; write for example "15 %"')
        return self


class Transmitter(StrictModel):
    """What the pilot's transmitter does with the sticks."""

    model: str = ""
    """Make and memory, in words."""
    rate: Literal["high", "low"] | None = None
    """Position of the rate switch at take-off."""
    dual_rates: Mapping[Stick, DualRate] = Field(default_factory=dict)
    """``elevator``, ``aileron``, ``rudder``."""
    mixers: tuple[Mixer, ...] = ()
    trims: Mapping[Lever, Ratio] = Field(default_factory=dict)
    """Trim levers at take-off as shares of full stick; signs as of the sticks: nose up, right wing
    down, nose right positive."""
    remarks: str = ""

    @model_validator(mode="after")
    def _must_make_sense(self) -> Transmitter:
        for lever, trim in self.trims.items():
            if not abs(trim) <= 1.0:
                raise ValueError(
                    f'the trim of the {lever} is beyond 100 %; write for example "4 %"'
                )
        return self


# The unit in which each value with a unit is written; the file may be edited in any other.
_WRITTEN_UNITS: dict[str, str] = {
    "takeoff_weight": "N",
    "landing_weight": "N",
    "fuel": "kg",
    "fuel_end": "kg",
    "mass": "kg",
    "position": "m",
    "flap": "rad",
    "loads": "N",
    "axles": "m",
    "scale_error": "N",
    "axle_error": "m",
    "pitch": "rad",
    "bank": "rad",
    "grid_rate": "Hz",
    "temperature": "K",
    "pressure": "Pa",
    "wind_speed": "m/s",
    "wind_from": "rad",
}


class Weather(StrictModel):
    """The air at the field."""

    temperature: Temperature | None = None
    """K."""
    pressure: Pressure | None = None
    """At the field, not reduced to sea level, Pa."""
    wind_speed: Speed | None = None
    """m/s."""
    wind_from: Angle | None = None
    """Direction the wind comes from, from true north, rad."""
    remarks: str = ""
    """Gusts, clouds, thermals, in words."""


class LoadingItem(StrictModel):
    """Something on board that the aircraft file does not count, or that was taken out."""

    what: str
    """In words: ``nose ballast``."""
    mass: Mass
    """kg; negative for what was taken out."""
    position: Position
    """In the frame of the aircraft file, m."""


class FlightInfo(StrictModel):
    """The content of ``flight.toml``. Every value is SI once read; None = not known."""

    name: str = ""
    """What the crew calls the flight."""
    date: datetime | None = None
    """When the record began; with its time zone."""
    aircraft: str = ""
    """Name of the aircraft file in force."""
    airframe: str = ""
    """Serial number or registration, where several aircraft share a file: ``"SN 3"``."""
    takeoff_weight: Weight | None = None
    landing_weight: Weight | None = None
    """N, as in table 6.2.3. A scale's pounds may be written as ``"46.5 lb"``."""
    fuel: Mass | None = None
    fuel_end: Mass | None = None
    """On board at take-off and after landing, kg."""
    flap: Angle | None = None
    """Setting for the maneuvers, rad."""
    weighing: WeighingRecord | None = None
    """Readings of scales under the wheels, for weight and center of gravity."""
    loading: tuple[LoadingItem, ...] = ()
    """What is on board beside, or missing from, what the aircraft file counts."""
    weather: Weather = Weather()
    """The air at the field."""
    transmitter: Transmitter = Transmitter()
    """Dual rates, mixers, trims."""
    crew: Mapping[str, str] = Field(default_factory=dict)
    notes: str = ""
    pilot_comments: str = ""
    """In words, as many lines as needed; the comments are those of the debrief."""
    source: str = ""
    """The link, or the file that was imported."""
    channel_map: str = ""
    """Name of the channel map in force."""
    onboard_log: str = ""
    """File name of the on-board log inside the folder; empty if there is none."""
    grid_rate: Frequency | None = None
    """Samples per second of the grid, Hz; None leaves it to the reader."""
    versions: Mapping[str, str] = Field(default_factory=dict)
    """Of the program and of what it reads with."""

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
        """Return what a TOML file holds: values with units as text, what says nothing left out."""
        return _format_table(_tables_last(self.model_dump(exclude_defaults=True)))


def _tables_last(values: Mapping[str, Any]) -> dict[str, Any]:
    return dict(sorted(values.items(), key=lambda item: _is_table(item[1])))


def _is_table(value: Any) -> bool:
    return isinstance(value, Mapping) or (
        isinstance(value, (list, tuple)) and bool(value) and isinstance(value[0], Mapping)
    )


def _format_table(values: Mapping[str, Any], unit: str | None = None) -> dict[str, Any]:
    """Return a table for TOML; `unit` is that of everything in it where keys are free names."""
    content: dict[str, Any] = {}
    for key, value in values.items():
        own = unit or _WRITTEN_UNITS.get(key)
        if value is None or value == "":
            continue
        if isinstance(value, Mapping):
            inner = _format_table(value, own)
            if inner:
                content[key] = inner
        elif _is_table(value):
            content[key] = [_format_table(one) for one in value]
        else:
            content[key] = _format_value(value, own)
    return content


def _format_value(value: Any, unit: str | None) -> Any:
    if isinstance(value, (list, tuple)):
        # Of a value with its deviation; one that was not given stays unsaid.
        given = value[:1] if len(value) == 2 and value[1] == 0.0 else value
        return (
            _format_value(given[0], unit)
            if len(given) == 1
            else [_format_value(one, unit) for one in given]
        )
    return f"{value!r} {unit}" if unit is not None and isinstance(value, float) else value


def current_versions() -> dict[str, str]:
    """Return the versions of the program and of the libraries that shape its numbers."""
    versions = {"python": platform.python_version()}
    for package in ("gsapp-ground-station", "numpy", "scipy", "pymavlink"):
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return versions


def local_timestamp() -> datetime:
    """Return the present time, to the second, in the zone of the place."""
    return datetime.now(UTC).astimezone().replace(microsecond=0)
