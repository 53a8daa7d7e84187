"""Airspeed, dynamic pressure and density of a flight, from what it measured."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gsapp.decoding.air_data import density, dynamic_pressure, standard_density, true_airspeed
from gsapp.flight.info import Weather
from gsapp.quantities import Block, FloatArray

ChannelSamples = Callable[[str], FloatArray]
"""Gives a channel, shape (n,); all NaN where there is none."""


def air_density(samples: ChannelSamples, weather: Weather | None = None) -> FloatArray:
    """Return the density of the air, kg/m^3, shape (n,).

    Measured; else from static pressure and temperature, either of them at the field's where no
    instrument shows it; else of the standard day at that pressure; else what V and dynamic
    pressure mean together. NaN where nothing tells.
    """
    weather = weather or Weather()
    static = _measured_or_default(samples("static_pressure"), weather.pressure)
    candidates: tuple[Callable[[], FloatArray], ...] = (
        lambda: samples("density"),
        lambda: density(static, _measured_or_default(samples("temperature"), weather.temperature)),
        lambda: standard_density(static),
        lambda: _density_from_speed_and_qbar(
            samples("V"), _first_available(samples, "qbar", "dynamic_pressure")
        ),
    )
    for candidate in candidates:
        rho = candidate()
        if np.isfinite(rho).any():
            return rho
    return static * np.nan


def airspeed_history(samples: ChannelSamples, rho: FloatArray) -> FloatArray:
    """Return the airspeed, m/s, shape (n,): measured, or from dynamic pressure and density."""
    V = samples("V")
    if np.isfinite(V).any():
        return V
    qbar = _first_available(samples, "qbar", "dynamic_pressure")
    return np.where(np.isfinite(qbar), true_airspeed(qbar, rho), np.nan)


def add_air_data(block: Block, weather: Weather | None = None) -> Block:
    """Return a block with V, qbar and density added where they follow from the rest."""

    def samples(name: str) -> FloatArray:
        return block[name] if name in block else np.full(len(block), np.nan)

    rho = air_density(samples, weather)
    V = airspeed_history(samples, rho)
    qbar = _first_available(samples, "qbar", "dynamic_pressure")
    if not np.isfinite(qbar).any():
        qbar = dynamic_pressure(V, rho)
    added = {
        name: values
        for name, values in (("V", V), ("qbar", qbar), ("density", rho))
        if name not in block and np.isfinite(values).any()
    }
    if not added:
        return block
    return Block(
        channels=(*block.channels, *added),
        times=block.times,
        values=np.column_stack([block.values, *added.values()]),
    )


def _first_available(samples: ChannelSamples, *names: str) -> FloatArray:
    found = [samples(name) for name in names]
    return next((one for one in found if np.isfinite(one).any()), found[0])


def _measured_or_default(measured: FloatArray, otherwise: float | None) -> FloatArray:
    if np.isfinite(measured).any() or otherwise is None:
        return measured
    return np.full(measured.shape, otherwise)


def _density_from_speed_and_qbar(V: FloatArray, qbar: FloatArray) -> FloatArray:
    if not np.isfinite(V * qbar).any():
        return V * np.nan
    with np.errstate(divide="ignore", invalid="ignore"):
        # The median of the ratio: sample by sample it would only carry noise.
        return np.full(V.shape, np.nanmedian(2.0 * qbar / V**2))
