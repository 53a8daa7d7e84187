"""A maneuver made ready: compared channels, inputs, and the motion to linearize along."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import MeasuredMotion, measured_motion
from gsapp.quantities import BoolArray, FloatArray

INTEGRATED_STATES = ("V", "alpha", "beta", "p", "q", "r", "phi", "theta")
"""Polar states that are integrated; heading changes nothing."""
COMPARED_CHANNELS = ("V", "alpha", "beta", "p", "q", "r", "ax", "ay", "an", "phi", "theta")
"""Channels that are compared, where they were measured."""
_ALWAYS_FROM_RECORD = frozenset(("ax", "ay", "an"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverRecord:
    """One maneuver, ready for linearization."""

    maneuver: Maneuver
    motion: MeasuredMotion
    dt: float  # s.
    channels: tuple[str, ...]
    measured: FloatArray  # Shape (n, n_channels). SI; zero where a sample does not count.
    valid: BoolArray  # Shape (n, n_channels).

    @property
    def id(self) -> str:
        return self.maneuver.id

    @property
    def flight(self) -> str:
        return self.maneuver.flight

    def __len__(self) -> int:
        return len(self.measured)


def create_maneuver_record(maneuver: Maneuver) -> ManeuverRecord:
    """Return a maneuver made ready.

    Raises
    ------
    FlightError
        If it holds too little to simulate anything.
    """
    motion = measured_motion(maneuver)
    columns: dict[str, FloatArray] = {}
    for name in COMPARED_CHANNELS:
        if name in _ALWAYS_FROM_RECORD or name in motion.measured:
            samples = maneuver.samples(name)
            if not np.isfinite(samples).any() and name == "V":
                # Airspeed that follows from pressures.
                samples = np.where(motion.interpolated.get("V", False), np.nan, motion.state("V"))
            if np.isfinite(samples).any():
                columns[name] = samples
    stacked = np.column_stack([*columns.values()])
    counted = np.isfinite(stacked)
    return ManeuverRecord(
        maneuver=maneuver,
        motion=motion,
        dt=maneuver.dt,
        channels=tuple(columns),
        measured=np.where(counted, stacked, 0.0),
        valid=counted,
    )
