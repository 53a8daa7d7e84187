"""Units at the edges: which ones each quantity may be written in, and their factors.

Inside the program everything is SI and radians. Pint supplies the factors; the lists here
decide which texts are units at all. Left to itself pint reads ``g`` as gram and converts
degrees to percent: here ``g`` is 9.80665 m/s^2, and a unit converts within its quantity only.
"""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np
import numpy.typing as npt

from gsapp.foundation import UnitError, UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean

if TYPE_CHECKING:
    import pint

# The units that files are written in, as pint reads definitions.
# Pint's own list holds some thousand units, and reading it takes longer than all the rest of an
# aircraft file. Those few that `gsapp.quantities.units` lets pass are defined here, by the same
# international agreements; a test compares each with pint's own.

DEFINITIONS: Final = """
micro- = 1e-6 = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
hecto- = 1e2 = h-
kilo- = 1e3 = k-
meter = [length] = m
second = [time] = s
gram = [mass] = g
ampere = [current] = A
kelvin = [temperature]; offset: 0 = K
radian = [] = rad
bit = []
percent = 0.01
pi = 3.141592653589793
degree = pi / 180 * radian = deg
revolution = 2 * pi * radian
byte = 8 * bit = B
minute = 60 * second = min
hour = 60 * minute = h
hertz = 1 / second = Hz
inch = 0.0254 * meter = in
foot = 12 * inch = ft
mile = 5280 * foot = mi
nautical_mile = 1852 * meter = nmi
liter = 1e-3 * meter ** 3 = l
US_liquid_gallon = 231 * inch ** 3
US_fluid_ounce = US_liquid_gallon / 128
knot = nautical_mile / hour
mile_per_hour = mile / hour = mph
standard_gravity = 9.80665 * meter / second ** 2
pound = 0.45359237 * kilogram = lb
ounce = pound / 16 = oz
newton = kilogram * meter / second ** 2 = N
joule = newton * meter
pound_force = pound * standard_gravity = lbf
kilogram_force = kilogram * standard_gravity
slug = pound_force * second ** 2 / foot
pascal = newton / meter ** 2 = Pa
millibar = 100 * pascal
psi = pound_force / inch ** 2
inch_H2O = inch * 1000 * kilogram / meter ** 3 * standard_gravity
inch_Hg = inch * 13595.1 * kilogram / meter ** 3 * standard_gravity
degree_Celsius = kelvin; offset: 273.15 = degC
degree_Fahrenheit = 5 / 9 * kelvin; offset: 233.15 + 200 / 9 = degF
coulomb = ampere * second = C
volt = joule / coulomb = V
"""
"""Prefixes, base units, and what is made of them, the made after what it is made of."""


Values = TypeVar("Values", float, npt.NDArray[np.float64])


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A physical quantity and the units it may be written in."""

    name: str  # In words, as used in messages.
    units: tuple[str, ...]  # Allowed units; the first is the SI unit used inside.

    @property
    def si(self) -> str:
        return self.units[0]


def _quantities(**units: str) -> dict[str, Quantity]:
    return {
        key: Quantity(name=key.replace("_", " "), units=tuple(text.split(",")))
        for key, text in units.items()
    }


QUANTITIES: dict[str, Quantity] = _quantities(
    ratio=",%",
    time="s,ms,us,min,h",
    angle="rad,deg",
    angular_rate="rad/s,deg/s",
    angular_acceleration="rad/s^2,deg/s^2",
    rotation_speed="rad/s,rpm,Hz",
    frequency="Hz,kHz,1/s",
    length="m,ft,in,cm,mm,km,mi,nmi",
    area="m^2,ft^2,in^2,cm^2",
    volume="m^3,l,floz,gal,in^3,ft^3",
    speed="m/s,ft/s,kt,mph,km/h,ft/min",
    acceleration="m/s^2,ft/s^2,g",
    mass="kg,slug,lb,oz",
    mass_flow="kg/s,slug/s,lb/s,lb/min,oz/min",
    force="N,lbf",
    weight="N,lbf,lb,kg",
    moment="N*m,lbf*ft",
    inertia="kg*m^2,slug*ft^2,lb*ft^2",
    density="kg/m^3,slug/ft^3",
    pressure="Pa,hPa,kPa,mbar,psi,lbf/ft^2,inH2O,inHg",
    temperature="K,degC,degF",
    voltage="V,mV",
    current="A,mA",
    charge="C,mAh,Ah",
    latitude="rad,deg",
    data_rate="B/s,kB/s",
    count=",1",
)
"""Every quantity by its key."""

# Where our text and pint's differ.
_PINT_TEXT = {
    "": "dimensionless",
    "1": "dimensionless",
    "%": "percent",
    "g": "standard_gravity",
    "kt": "knot",
    "floz": "US_fluid_ounce",
    "gal": "US_liquid_gallon",
    "inH2O": "inch_H2O",
    "inHg": "inch_Hg",
    "mbar": "millibar",
    "rpm": "revolution / minute",
    "mAh": "milliampere * hour",
    "Ah": "ampere * hour",
    "B/s": "byte / second",
    "kB/s": "kilobyte / second",
    "l": "liter",
}

# A pound or kilogram is a mass in `mass` and what a scale shows for it in `weight`; pint's Hz is
# one radian per second.
_PINT_TEXT_OF_QUANTITY = {
    ("weight", "lb"): "lbf",
    ("weight", "kg"): "kilogram_force",
    ("rotation_speed", "Hz"): "revolution / second",
}

_ALIASES = {
    "°": "deg",
    "°/s": "deg/s",
    "fps": "ft/s",
    "psf": "lbf/ft^2",
    "lb/ft^2": "lbf/ft^2",
    "°C": "degC",
    "°F": "degF",
    "kn": "kt",
    "V_dc": "V",
    "-": "",
    "usec": "us",
    "slug*ft2": "slug*ft^2",
    "ft2": "ft^2",
    "m2": "m^2",
    "kg*m2": "kg*m^2",
}

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*((?:[^\s\d.,].*?)?)\s*")


@cache
def _registry() -> pint.UnitRegistry[float]:
    import pint  # takes a while, so only where a unit is really converted

    registry: pint.UnitRegistry[float] = pint.UnitRegistry(None, cache_folder=None)
    registry.load_definitions(DEFINITIONS.strip().splitlines())
    return registry


def quantity(key: str) -> Quantity:
    """Return the quantity of that key; raise `UnknownNameError` for any other."""
    try:
        return QUANTITIES[key]
    except KeyError:
        hint = did_you_mean(key, QUANTITIES, f"known are {', '.join(QUANTITIES)}")
        raise UnknownNameError(f"no quantity is called '{key}'; {hint}") from None


def normalize_unit(text: str, key: str) -> str:
    """Return the listed spelling of a unit that must express a quantity, by its key.

    Blanks, ``**``, a middle dot and superscripts are understood. Raise UnitError if the unit is
    unknown or does not express that quantity.
    """
    allowed = quantity(key).units
    plain = re.sub(r"\s+", "", text).replace("**", "^").replace("²", "^2").replace("³", "^3")
    plain = plain.replace("·", "*")
    plain = _ALIASES.get(plain, plain)
    if plain in allowed:
        return plain
    # "slug ft^2" and "lbf ft" are commonly written with a blank for the product.
    spaced = re.sub(r"\s+", "*", text.strip()).replace("**", "^")
    spaced = _ALIASES.get(spaced, spaced)
    if spaced in allowed:
        return spaced
    listed = ", ".join(unit or "(no unit)" for unit in allowed)
    shown = f"'{text}'" if text.strip() else "no unit"
    hint = did_you_mean(plain, [unit for unit in allowed if unit], most=1) if plain else ""
    raise UnitError(
        f"{shown} is not a unit of {quantity(key).name}; {hint}{' ' if hint else ''}"
        f"use one of: {listed}"
    )


@cache
def _linear(unit: str, key: str) -> tuple[float, float]:
    """Return (factor, offset) with SI value = factor * value + offset."""
    registry = _registry()
    name = _PINT_TEXT_OF_QUANTITY.get((key, unit)) or _PINT_TEXT.get(unit, unit)
    si_unit = quantity(key).si
    target = registry.Unit(_PINT_TEXT.get(si_unit, si_unit))
    source = registry.Unit(name)
    offset = float(registry.Quantity(0.0, source).to(target).magnitude)
    factor = float(registry.Quantity(1.0, source).to(target).magnitude) - offset
    # Conversion chains round in the last digit; the definitions are shorter than that.
    return float(f"{factor:.15g}"), float(f"{offset:.15g}")


def to_si(values: Values, unit: str, key: str) -> Values:
    """Convert from one of the units of a quantity to its SI unit; NaN stays NaN.

    Raise UnitError if the unit does not express the quantity.
    """
    unit = normalize_unit(unit, key)
    if unit == quantity(key).si:
        return values
    factor, offset = _linear(unit, key)
    return values * factor + offset


def from_si(values: Values, unit: str, key: str) -> Values:
    """Convert from SI to a unit; the inverse of `to_si`."""
    unit = normalize_unit(unit, key)
    if unit == quantity(key).si:
        return values
    factor, offset = _linear(unit, key)
    return (values - offset) / factor


def parse_quantity(text: str | float, key: str) -> float:
    """Read a value with its unit, such as ``"11.33 ft^2"``, into SI.

    A bare number is taken only for quantities without a unit. Raise UnitError if there is no
    number, no unit where one is needed, or a unit of another quantity.
    """
    known = quantity(key)
    example = f'write for example "1.0 {known.units[-1]}"'
    if isinstance(text, bool) or not isinstance(text, (str, int, float)):
        raise UnitError(f"{text!r} is not a {known.name}; {example}")
    if not isinstance(text, str):
        if "" in known.units:
            return _finite(text, known)
        raise UnitError(f"{text!r} has no unit; {example}")
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise UnitError(f"'{text}' does not begin with a number; {example}")
    if not match.group(2).strip() and "" not in known.units:
        raise UnitError(f"'{text.strip()}' has no unit; {example}")
    return _finite(to_si(float(match.group(1)), match.group(2), key), known)


def _finite(value: float, known: Quantity) -> float:
    # Compared as it is: an int may have more digits than a float can hold.
    if not abs(value) <= sys.float_info.max:
        raise UnitError(f"the {known.name} is not a finite number; correct it")
    return float(value)


def parse_finite_number(text: str) -> float | None:
    """Return the number that a text is; NaN for an empty one, None for what is no finite number.

    `float` also takes ``1_000``, and digits of other scripts: neither is meant, and what stands
    for them is damaged.
    """
    try:
        value = float(text)
    except ValueError:
        return None if text and not text.isspace() else math.nan
    return None if math.isinf(value) or "_" in text or not text.isascii() else value
