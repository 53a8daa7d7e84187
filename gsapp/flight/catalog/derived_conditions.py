"""Mach number, Reynolds number and wing loading of a maneuver, from its conditions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from gsapp.aircraft import Aircraft
from gsapp.decoding.air_data import density, standard_temperature
from gsapp.dynamics.atmosphere import pressure_at, speed_of_sound, viscosity
from gsapp.flight.info import FlightInfo
from gsapp.foundation import UnknownNameError
from gsapp.quantities import channel
from gsapp.quantities.constants import GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivedCondition:
    """A condition that no channel holds."""

    title: str
    quantity: str  # Key in `gsapp.quantities.units.QUANTITIES`.
    unit: str  # SI.


DERIVED_CONDITIONS: Final[Mapping[str, DerivedCondition]] = {
    "mach": DerivedCondition(title="Mach number", quantity="ratio", unit=""),
    "reynolds": DerivedCondition(title="Reynolds number (chord)", quantity="ratio", unit=""),
    "wing_loading": DerivedCondition(title="Wing loading (W/S)", quantity="pressure", unit="Pa"),
}


def condition_quantity(name: str) -> str:
    """Return the quantity of a condition: a channel, or a derived one.

    Raises
    ------
    UnknownNameError
        If it is neither.
    """
    known = DERIVED_CONDITIONS.get(name)
    if known is not None:
        return known.quantity
    try:
        return channel(name).quantity
    except UnknownNameError as error:
        raise UnknownNameError(
            f"{error}; other conditions are {', '.join(DERIVED_CONDITIONS)}"
        ) from error


def derived_conditions(
    means: Mapping[str, float], aircraft: Aircraft, info: FlightInfo | None
) -> dict[str, float]:
    """Return Mach number, Reynolds number and wing loading (Pa), as far as they are known.

    Parameters
    ----------
    means : mapping of str to float
        Of the channels before the input, SI.
    info : FlightInfo, optional
        Its weather stands in for instruments that the flight lacks, its take-off weight for the
        weight.
    """
    found = {}
    info = info or FlightInfo()
    pressure = means.get("static_pressure", info.weather.pressure)
    if pressure is None and "altitude" in means:
        pressure = float(pressure_at(means["altitude"]))
    temperature = means.get("temperature", info.weather.temperature)
    if temperature is None and pressure is not None:
        temperature = standard_temperature(pressure)
    V = means.get("V")
    if V is not None and temperature is not None and temperature > 0.0:
        found["mach"] = V / speed_of_sound(temperature)
        rho = means.get("density")
        if rho is None and pressure is not None:
            rho = density(pressure, temperature)
        if rho is not None:
            found["reynolds"] = rho * V * aircraft.geometry.chord / viscosity(temperature)
    mass = means.get("mass", aircraft.mass.mass)
    weight = GRAVITY * mass
    if "mass" not in means and info.takeoff_weight is not None:
        weight = info.takeoff_weight
    found["wing_loading"] = weight / aircraft.geometry.wing_area
    return {name: one for name, one in found.items() if math.isfinite(one)}
