"""Moments of inertia from the periods of pendulums (3.6.1)-(3.6.3), notes section 7.

The aircraft swings in a cradle: as a compound pendulum about a fore-and-aft or a crosswise axis
for Ixx and Iyy, as a bifilar one about the vertical for Izz. What the cradle and the entrained air
add is taken off. SI and radians.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gsapp.quantities.constants import GRAVITY


def small_amplitude_period(period: float, amplitude: float = 0.0, damping: float = 0.0) -> float:
    """Return the period (s) of the same pendulum undamped and at vanishing amplitude.

    The amplitude is the mean angle to either side, rad; the damping the ratio zeta.
    """
    return period / (1.0 + amplitude**2 / 16.0) * math.sqrt(1.0 - damping**2)


class CompoundSwing(NamedTuple):
    """A compound pendulum: aircraft and cradle about one horizontal axis."""

    period: float
    cradle_period: float
    """Of aircraft and cradle together, and of the cradle alone, by `small_amplitude_period`, s."""
    aircraft_weight: float
    cradle_weight: float
    """N."""
    aircraft_arm: float
    cradle_arm: float
    """From the pivot down to the CG of each, vertical, m."""
    distance: float
    """From the pivot to the aircraft's CG, m; equal to `aircraft_arm` for a level aircraft that
    hangs plumb."""
    air_mass: float = 0.0  # Air that the aircraft displaces and drags along, kg.


class PendulumInertia(NamedTuple):
    """A moment of inertia and what it is the difference of, kg m^2."""

    whole: float  # Of all that swings, about the axis of the swing.
    cradle: float  # The cradle's part.
    transfer: float  # What the parallel-axis rule takes off, entrained air included.

    @property
    def value(self) -> float:
        """Return the aircraft's own, about its CG."""
        return self.whole - self.cradle - self.transfer


def compound_inertia(swing: CompoundSwing) -> PendulumInertia:
    """Return the inertia about an axis through the aircraft's CG, parallel to the pivot."""
    cradle = swing.cradle_weight * swing.cradle_arm
    stiffness = swing.aircraft_weight * swing.aircraft_arm + cradle
    moved = swing.aircraft_weight / GRAVITY + swing.air_mass
    return PendulumInertia(
        whole=stiffness * (swing.period / (2.0 * math.pi)) ** 2,
        cradle=cradle * (swing.cradle_period / (2.0 * math.pi)) ** 2,
        transfer=moved * swing.distance**2,
    )


class BifilarSwing(NamedTuple):
    """A bifilar pendulum: aircraft and cradle on two wires, turning about the vertical."""

    period: float
    cradle_period: float
    """As in `CompoundSwing`, s."""
    aircraft_weight: float
    cradle_weight: float
    """N."""
    stiffness: float
    """Restoring moment over angle and weight, m; see `parallel_wire_stiffness` and
    `slanted_wire_stiffness`."""
    aircraft_offset: float = 0.0
    cradle_offset: float = 0.0
    """Horizontal distance of each CG from the one of both together, m."""


def parallel_wire_stiffness(length: float, first: float, second: float) -> float:
    """Return the stiffness (m) of parallel wires at distances r1, r2 (m) from the combined CG."""
    return first * second / length


def slanted_wire_stiffness(height: float, upper: float, lower: float) -> float:
    """Return the stiffness (m) of wires spaced d1 above and d2 below, a height (m) apart."""
    return upper * lower / (4.0 * height)


def bifilar_inertia(swing: BifilarSwing) -> PendulumInertia:
    """Return the inertia about the vertical through the aircraft's CG."""
    weight = swing.aircraft_weight + swing.cradle_weight
    own = swing.cradle_weight * swing.stiffness * (swing.cradle_period / (2.0 * math.pi)) ** 2
    offsets = (
        swing.aircraft_weight * swing.aircraft_offset**2
        + swing.cradle_weight * swing.cradle_offset**2
    )
    return PendulumInertia(
        whole=weight * swing.stiffness * (swing.period / (2.0 * math.pi)) ** 2,
        cradle=own,
        transfer=offsets / GRAVITY,
    )


def product_of_inertia(vertical: float, ixx: float, izz: float, nose_up: float) -> float:
    """Return Ixz from the inertia about the vertical with the nose up by an angle (rad).

    `vertical` is by `bifilar_inertia`, tilted; all kg m^2.
    """
    s, c = math.sin(nose_up), math.cos(nose_up)
    return (vertical - ixx * s * s - izz * c * c) / (2.0 * s * c)
