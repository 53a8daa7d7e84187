"""Air data: speeds, density and altitude from pressures and temperature.

Dynamic pressure is taken as rho V^2 / 2. What a pitot tube feels is larger by the factor
1 + M^2/4: 0.2 % at 100 ft/s, a fifth of what the transducer is good for, so compressibility is
left out.
"""

from __future__ import annotations

import numpy as np

from gsapp.dynamics.atmosphere import (
    GAS_CONSTANT,
    LAPSE_RATE,
    SEA_LEVEL_DENSITY,
    SEA_LEVEL_TEMPERATURE,
    pressure_altitude,
)
from gsapp.quantities import FloatArray


def density(static_pressure: FloatArray, temperature: FloatArray) -> FloatArray:
    """Return the density (kg/m^3) of air at a pressure (Pa) and temperature (K).

    NaN where either is not positive, as an open input of a converter may read.
    """
    sound = (static_pressure > 0.0) & (temperature > 0.0)
    return static_pressure / (GAS_CONSTANT * np.where(sound, temperature, np.nan))


def standard_density(static_pressure: FloatArray) -> FloatArray:
    """Return the density (kg/m^3) of the standard day at a pressure (Pa)."""
    return density(static_pressure, standard_temperature(static_pressure))


def standard_temperature(static_pressure: FloatArray) -> FloatArray:
    """Return the temperature (K) of the standard day at a pressure (Pa)."""
    return SEA_LEVEL_TEMPERATURE - LAPSE_RATE * altitude(static_pressure)


def altitude(static_pressure: FloatArray) -> FloatArray:
    """Return the pressure altitude (m) at a static pressure (Pa); NaN where it is not positive."""
    positive = np.where(static_pressure > 0.0, static_pressure, np.nan)
    return np.asarray(pressure_altitude(positive), dtype=np.float64)


def true_airspeed(qbar: FloatArray, rho: FloatArray) -> FloatArray:
    """Return V (m/s) from dynamic pressure (Pa) and density; 0 where noise makes qbar negative."""
    return np.sqrt(2.0 * np.maximum(qbar, 0.0) / rho)


def calibrated_airspeed(qbar: FloatArray) -> FloatArray:
    """Return Vc (m/s): the airspeed that this dynamic pressure (Pa) means at sea level."""
    return np.sqrt(2.0 * np.maximum(qbar, 0.0) / SEA_LEVEL_DENSITY)


def dynamic_pressure(V: FloatArray, rho: FloatArray) -> FloatArray:
    """Return rho V^2 / 2 (Pa), with the sign of V: noise about zero stays about zero."""
    return 0.5 * rho * V * np.abs(V)


def sea_level_dynamic_pressure(Vc: FloatArray) -> FloatArray:
    """Return the dynamic pressure (Pa) that a calibrated airspeed (m/s) means, with its sign."""
    return 0.5 * SEA_LEVEL_DENSITY * Vc * np.abs(Vc)
