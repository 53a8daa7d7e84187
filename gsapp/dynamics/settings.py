"""Settings of the simulation of an aircraft and of its instruments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationSettings:
    """Engineering choices unless a source is named."""

    min_speed: float = 3.0  # m/s: aerodynamics fade out below; flow angles mean nothing.
    max_flow_angles: tuple[float, float] = (math.radians(45.0), math.radians(30.0))
    """Angles of attack and sideslip, rad, beyond which coefficients stay as they are, with
    stall: a crosswind at taxi speed must not roll the aircraft over."""
    swivel_iterations: int = 5  # Each leaves about a hundredth of the error.
    spool_down_time: float = 1.0  # Time constant of a fan whose engine was stopped, s.
    control_smoothing: float = 0.1  # s, of a record for play: shorter than a hand's move.
    play_start: float = 0.5  # s, of a record over whose mean play begins.
    min_time_constant: float = 5e-3  # s, in the continuous form; smaller ones act as this.
    edge_rounding: float = 0.01  # Time (s) in which the continuous form of an edge is rounded.


SIMULATION: Final = SimulationSettings()
