"""Slips on a flight card: kilograms written as pounds, Fahrenheit as Celsius, more fuel than fits.

A doubt stops nobody: the file loads, and the card shows the sentence beside the value.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from gsapp.aircraft import Aircraft
from gsapp.aircraft.config import Axles
from gsapp.aircraft.weighing import evaluate_weighing
from gsapp.flight.info import FlightInfo
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.foundation import FlightError
from gsapp.quantities import convert_text_units, from_si, to_si
from gsapp.quantities.constants import DEGREE, GRAVITY

_UNITS: Final = {
    "weight": ("N", "lb", "kg"),
    "mass": ("kg", "lb", "oz", "slug"),
    "temperature": ("degC", "degF", "K"),
    "pressure": ("hPa", "inHg", "kPa", "psi"),
    "speed": ("m/s", "kt", "mph", "km/h", "ft/s"),
}
"""Units that people take for one another, by quantity; the likeliest first."""

_Units = Mapping[str, str]

_SHOWN: Final[Mapping[str, _Units]] = {
    "US": {
        "weight": "lb", "mass": "lb", "length": "in", "angle": "deg", "temperature": "degF",
        "pressure": "inHg", "speed": "kt",
    },
    "SI": {
        "weight": "kg", "mass": "kg", "length": "mm", "angle": "deg", "temperature": "degC",
        "pressure": "hPa", "speed": "m/s",
    },
}  # fmt: skip
"""Units of the sentences, by system and quantity."""

_NAMES: Final = {"takeoff_weight": "take-off weight", "landing_weight": "landing weight"}

_USUAL_AIR: Final = {
    "temperature": (to_si(-30.0, "degC", "temperature"), to_si(50.0, "degC", "temperature")),
    "pressure": (600e2, 1060e2),
    "wind_speed": (0.0, 25.0),
}
_KINDS = {"temperature": "temperature", "pressure": "pressure", "wind_speed": "speed"}


@dataclass(frozen=True, slots=True, kw_only=True)
class InfoWarning:
    """Something on a card that looks like a slip."""

    field: str
    """Key path in ``flight.toml``: ``weather.temperature``."""
    text: str
    """What, and what was probably meant."""


def check_flight_info(
    info: FlightInfo, aircraft: Aircraft | None = None, *, system: str = "US"
) -> tuple[InfoWarning, ...]:
    """Return what looks like a slip, weights and fuel by the aircraft's file."""
    units = _SHOWN[system]
    return tuple(
        InfoWarning(field=field, text=convert_text_units(text, system))
        for field, text in (
            *_weights(info, aircraft, units),
            *_fuel(info, aircraft, units),
            *_scales(info, aircraft, units),
            *_settings(info, aircraft, units),
            *_air(info, units),
        )
    )


_Warnings = Iterator[tuple[str, str]]


def _weights(info: FlightInfo, aircraft: Aircraft | None, units: _Units) -> _Warnings:
    usual = None if aircraft is None else aircraft.mass.mass * GRAVITY
    loaded = sum(item.mass for item in info.loading) * GRAVITY
    dry = 0.0 if aircraft is None else aircraft.mass.fuel * GRAVITY
    for field, value, lightest in (
        ("takeoff_weight", info.takeoff_weight, 0.0),
        ("landing_weight", info.landing_weight, dry),
    ):
        if value is None:
            continue
        name = _NAMES[field]
        if not value > 0.0:
            yield field, f"the {name} is not above zero; read the scale again"
        elif usual is not None:
            expected = usual + loaded
            low, high = (
                (1.0 - FLIGHT_DATA.max_weight_change) * (expected - lightest),
                (1.0 + FLIGHT_DATA.max_weight_change) * expected,
            )
            if not low <= value <= high:
                yield (
                    field,
                    f"the {name} is {_format_value(value, 'weight', units)}, but the aircraft "
                    "usually weighs "
                    f"{_format_value(expected, 'weight', units)}"
                    f"{_unit_suggestion(value, 'weight', low, high)}",
                )
    takeoff, landing = info.takeoff_weight, info.landing_weight
    if takeoff is not None and landing is not None:
        burned = (takeoff - landing) / GRAVITY
        if burned < 0.0:
            yield "landing_weight", "the aircraft landed heavier than it took off; swap the two?"
        elif info.fuel is not None and burned > 1.1 * info.fuel + 0.02:
            yield (
                "landing_weight",
                f"{_format_value(burned, 'mass', units)} were lost in flight, but only "
                f"{_format_value(info.fuel, 'mass', units)} of fuel were on board; weigh again",
            )


def _fuel(info: FlightInfo, aircraft: Aircraft | None, units: _Units) -> _Warnings:
    for field, value in (("fuel", info.fuel), ("fuel_end", info.fuel_end)):
        if value is None:
            continue
        if value < 0.0:
            yield field, "the fuel is below zero; write what is in the tanks"
        elif aircraft is not None and 0.0 < FLIGHT_DATA.max_fuel_ratio * aircraft.mass.fuel < value:
            most = FLIGHT_DATA.max_fuel_ratio * aircraft.mass.fuel
            yield (
                field,
                f"{_format_value(value, 'mass', units)} of fuel exceed the tank capacity of "
                f"{_format_value(aircraft.mass.fuel, 'mass', units)}"
                f"{_unit_suggestion(value, 'mass', 0.0, most)}",
            )
    if info.fuel is not None and info.fuel_end is not None and info.fuel_end > info.fuel:
        yield "fuel_end", "more fuel after the flight than before; swap the two?"


def _scales(info: FlightInfo, aircraft: Aircraft | None, units: _Units) -> _Warnings:
    if info.weighing is None:
        return
    axles = Axles() if aircraft is None else aircraft.axles
    try:
        found = evaluate_weighing(info.weighing, axles)
    except FlightError as error:
        yield "weighing", str(error)
        return
    if info.takeoff_weight is not None and info.takeoff_weight > 0.0:
        sum_of_scales = (found.mass.value + _fuel_added_later(info)) * GRAVITY
        if abs(sum_of_scales / info.takeoff_weight - 1.0) > FLIGHT_DATA.scales_tolerance:
            yield (
                "weighing",
                f"the scales add up to {_format_value(sum_of_scales, 'weight', units)} at "
                "take-off, the card "
                f"says {_format_value(info.takeoff_weight, 'weight', units)}; read them again, "
                "or write the "
                "fuel on board when weighed",
            )
    if aircraft is not None and abs(found.cg[0]) > 0.25 * aircraft.geometry.chord:
        yield (
            "weighing",
            f"the scales give a CG {_format_cg_offset(found.cg[0], units)} of the aircraft "
            "file's, more than a quarter of the chord; check the assignment of readings to "
            "wheels",
        )


def _fuel_added_later(info: FlightInfo) -> float:
    weighed = None if info.weighing is None else info.weighing.fuel
    return 0.0 if weighed is None or info.fuel is None else info.fuel - weighed


def _settings(info: FlightInfo, aircraft: Aircraft | None, units: _Units) -> _Warnings:
    if info.flap is None or aircraft is None:
        return
    low, high = aircraft.controls.flap.travel
    if not low - DEGREE <= info.flap <= high + DEGREE:
        yield (
            "flap",
            f"a flap setting of {_format_value(info.flap, 'angle', units)} is beyond its travel, "
            f"{_format_value(low, 'angle', units)} to {_format_value(high, 'angle', units)}",
        )


def _air(info: FlightInfo, units: _Units) -> _Warnings:
    for key, (low, high) in _USUAL_AIR.items():
        value = getattr(info.weather, key)
        if value is not None and not low <= value <= high:
            kind = _KINDS[key]
            yield (
                f"weather.{key}",
                f"{_format_value(value, kind, units)} is no {key.replace('_', ' ')} to fly in"
                f"{_unit_suggestion(value, kind, low, high)}",
            )


def _unit_suggestion(value: float, kind: str, low: float, high: float) -> str:
    """Return the question whether another unit was meant, where one would fit; else a remedy."""
    for written in _UNITS[kind]:
        number = from_si(value, written, kind)
        for unit in _UNITS[kind]:
            if unit != written and low <= to_si(number, unit, kind) <= high:
                return f"; was '{number:.4g} {unit}' meant instead of '{number:.4g} {written}'?"
    return "; read it again"


def _format_value(value: float, kind: str, units: _Units) -> str:
    unit = units[kind]
    number = from_si(value, unit, kind)
    digits = 1 if abs(number) >= 10.0 or not math.isfinite(number) else 2
    return f"{number:.{digits}f} {unit}"


def _format_cg_offset(x: float, units: _Units) -> str:
    return f"{_format_value(abs(x), 'length', units)} {'ahead' if x > 0.0 else 'aft'}"
