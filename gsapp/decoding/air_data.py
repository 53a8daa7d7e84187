"""Air data: speeds, density and altitude from pressures and temperature.

Dynamic pressure is taken as rho V^2 / 2. What a pitot tube feels is larger by the factor
1 + M^2/4: 0.2 % at 100 ft/s, a fifth of what the transducer is good for, so compressibility is
left out.

Every formula takes single numbers as well as arrays, and gives the same bits for both.
"""

from __future__ import annotations

import math
from typing import TypeVar, cast

import numpy as np

from gsapp.dynamics.arithmetic import where
from gsapp.dynamics.atmosphere import (
    GAS_CONSTANT,
    LAPSE_RATE,
    SEA_LEVEL_DENSITY,
    SEA_LEVEL_TEMPERATURE,
    pressure_altitude,
)
from gsapp.quantities import FloatArray

Number = TypeVar("Number", float, FloatArray)
"""A number, or one for each sample, shape (n,)."""


def density(static_pressure: Number, temperature: Number) -> Number:
    """Return the density (kg/m^3) of air at a pressure (Pa) and temperature (K).

    NaN where either is not positive, as an open input of a converter may read.
    """
    sound = (static_pressure > 0.0) & (temperature > 0.0)
    return static_pressure / (GAS_CONSTANT * cast("Number", where(sound, temperature, np.nan)))


def standard_density(static_pressure: Number) -> Number:
    """Return the density (kg/m^3) of the standard day at a pressure (Pa)."""
    return density(static_pressure, standard_temperature(static_pressure))


def standard_temperature(static_pressure: Number) -> Number:
    """Return the temperature (K) of the standard day at a pressure (Pa)."""
    return SEA_LEVEL_TEMPERATURE - LAPSE_RATE * altitude(static_pressure)


def altitude(static_pressure: Number) -> Number:
    """Return the pressure altitude (m) at a static pressure (Pa); NaN where it is not positive."""
    if isinstance(static_pressure, float):
        return float(pressure_altitude(static_pressure)) if static_pressure > 0.0 else math.nan
    # The last bit of NumPy's powers depends on the processor; so each number is taken by itself.
    pressures = static_pressure.ravel().tolist()
    numbers = [pressure_altitude(each) if each > 0.0 else math.nan for each in pressures]
    return np.array(numbers).reshape(static_pressure.shape)


def true_airspeed(qbar: Number, rho: Number) -> Number:
    """Return V (m/s) from dynamic pressure (Pa) and density; 0 where noise makes qbar negative."""
    return _root(2.0 * _not_negative(qbar) / rho)


def calibrated_airspeed(qbar: Number) -> Number:
    """Return Vc (m/s): the airspeed that this dynamic pressure (Pa) means at sea level."""
    return _root(2.0 * _not_negative(qbar) / SEA_LEVEL_DENSITY)


def dynamic_pressure(V: Number, rho: Number) -> Number:
    """Return rho V^2 / 2 (Pa), with the sign of V: noise about zero stays about zero."""
    return 0.5 * rho * V * abs(V)


def sea_level_dynamic_pressure(Vc: Number) -> Number:
    """Return the dynamic pressure (Pa) that a calibrated airspeed (m/s) means, with its sign."""
    return 0.5 * SEA_LEVEL_DENSITY * Vc * abs(Vc)


def _root(value: Number) -> Number:
    return math.sqrt(value) if isinstance(value, float) else np.sqrt(value)


def _not_negative(value: Number) -> Number:
    if isinstance(value, float):
        return 0.0 if value <= 0.0 else value
    return np.where(value <= 0.0, 0.0, value)
