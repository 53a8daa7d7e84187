"""Settings of the simulation of an aircraft and of its instruments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationSettings:
    """Engineering choices unless a source is named."""

    min_speed: float = 3.0
    """Airspeed below which the aerodynamics fade out, m/s: flow angles mean nothing there."""
    max_flow_angles: tuple[float, float] = (math.radians(45.0), math.radians(30.0))
    """With stall, the angles of attack and sideslip beyond which the coefficients stay as they are:
    a wind from the side at taxi speed must not roll the aircraft over."""
    swivel_iterations: int = 5
    """Rounds of `flow_at_cg` for a swivel head; each leaves about a hundredth of the error."""
    spool_down_time: float = 1.0  # Time constant of a fan whose engine was stopped, s.
    control_smoothing: float = 0.1
    """Seconds over which a record is averaged for a play: shorter than any hand's move."""
    min_time_constant: float = 5e-3
    """Time constants below this (s) act as this in the continuous form."""
    edge_rounding: float = 0.01  # Time (s) in which the continuous form of an edge is rounded.


SIMULATION: Final = SimulationSettings()
