"""What an instrument or a servo is calibrated against: volts, a pulse's width, counts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from calibration.adc import ADC_RESOLUTION
from calibration.settings import CALIBRATION
from gsapp.foundation import UnitError


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """A kind of raw signal."""

    name: str
    """As it is listed."""
    unit: str
    """In which certificates hold it."""
    factors: Mapping[str, float]
    """Every unit that may be written, and how many of `unit` it is."""
    resolution: float
    """Smallest step, in `unit`."""
    limits: tuple[float, float]
    """Lowest and highest possible, in `unit`."""


SIGNALS: Final = (
    Signal(
        name="volts", unit="V", factors={"V": 1.0, "mV": 1e-3}, resolution=ADC_RESOLUTION,
        limits=CALIBRATION.volts_range,
    ),
    Signal(
        name="pulse", unit="us", factors={"us": 1.0, "ms": 1e3}, resolution=1.0,
        limits=CALIBRATION.pulse_range,
    ),
    Signal(
        name="counts", unit="count", factors={"count": 1.0, "counts": 1.0},
        resolution=1.0, limits=CALIBRATION.counts_range,
    ),
)  # fmt: skip
"""Volts of a transducer, width of a servo's pulse, counts of a converter."""


def find_signal(unit: str) -> Signal:
    """Return the signal that is measured in a unit; raise UnitError for none."""
    for signal in SIGNALS:
        if unit.strip() in signal.factors:
            return signal
    raise UnitError(f"'{unit}' is no unit of a signal; use V, mV, us, ms or count")
