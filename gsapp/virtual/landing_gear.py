"""Three wheels on the runway: springs, dampers, tires.

The source gives no numbers of the gear but its layout, one nose wheel and two mains. Stiffness
and damping are chosen so that the aircraft sits down 3 cm under its weight and does not bounce
twice; they matter to the look of a landing, not to any derivative.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from gsapp.aircraft import Aircraft
from gsapp.dynamics.equations import Loads, Matrix
from gsapp.quantities.constants import GRAVITY

_CREEP = 0.12
"""Speed at which a braked wheel has most of its grip, m/s: a step of 10 ms can follow that."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    """One wheel."""

    position: tuple[float, float, float]
    """Of the unloaded tire's lowest point from the CG, body axes, m."""
    steers: bool
    brakes: bool
    """Whether it turns with the rudder stick, and whether it has a brake."""


class LandingGear:
    """Forces of the wheels on the aircraft.

    Parameters
    ----------
    aircraft : Aircraft
        Its length, span and mass give the size of the gear.
    """

    ROLLING_FRICTION = 0.03
    BRAKE_FRICTION = 0.9
    """At full brake, which stands for chocks as well."""
    SIDE_FRICTION = 0.7
    STEERING = math.radians(20.0)
    """Angle of the nose wheel at full stick, rad."""

    def __init__(self, aircraft: Aircraft) -> None:
        length = aircraft.geometry.length or aircraft.geometry.span
        half_track = 0.11 * aircraft.geometry.span
        self.height = 0.15 * length
        """Of the CG above the unloaded wheels, m."""
        self.wheels = (
            Wheel(position=(0.3 * length, 0.0, self.height), steers=True, brakes=False),
            Wheel(position=(-0.03 * length, -half_track, self.height), steers=False, brakes=True),
            Wheel(position=(-0.03 * length, half_track, self.height), steers=False, brakes=True),
        )
        weight = aircraft.mass.mass * GRAVITY
        self._stiffness = weight / 2.0 / 0.03
        self._damping = 1.3 * math.sqrt(self._stiffness * aircraft.mass.mass / 2.0)

    def loads(
        self,
        down: float,
        velocity: tuple[float, float, float],
        rates: tuple[float, float, float],
        matrix: Matrix,
        *,
        steer: float,
        brake: float,
    ) -> tuple[Loads, bool]:
        """Return the loads of the ground, and whether a main wheel carries weight.

        Parameters
        ----------
        down : float
            Of the CG below the runway (negative above it), m.
        velocity : tuple of float
            Over the ground along the body axes, m/s.
        rates : tuple of float
            p, q, r, rad/s.
        matrix : tuple of float
            Body to Earth, row by row.
        steer : float
            -1 to 1, positive right.
        brake : float
            0 to 1.
        """
        u, v, w = velocity
        p, q, r = rates
        X = Y = Z = L = M = N = 0.0
        weight_on_wheels = False
        for wheel in self.wheels:
            x, y, z = wheel.position
            deep = down + matrix[6] * x + matrix[7] * y + matrix[8] * z
            if deep <= 0.0:
                continue
            along, side, vertical = u + q * z - r * y, v + r * x - p * z, w + p * y - q * x
            sinking = matrix[6] * along + matrix[7] * side + matrix[8] * vertical
            # The damper pulls no wheel into the ground, and bites as the tire flattens.
            bite = min(deep / 0.03, 1.0)
            push = max(self._stiffness * deep + bite * self._damping * sinking, 0.0)
            weight_on_wheels = weight_on_wheels or not wheel.steers
            angle = steer * self.STEERING if wheel.steers else 0.0
            ca, sa = math.cos(angle), math.sin(angle)
            rolling = along * ca + side * sa
            sliding = side * ca - along * sa
            friction = self.ROLLING_FRICTION + (self.BRAKE_FRICTION * brake if wheel.brakes else 0)
            drag = -friction * push * math.tanh(rolling / _CREEP)
            grip = -self.SIDE_FRICTION * push * math.tanh(sliding / max(0.2, 0.1 * abs(rolling)))
            fx, fy, fz = drag * ca - grip * sa, drag * sa + grip * ca, -push
            X += fx
            Y += fy
            Z += fz
            L += y * fz - z * fy
            M += z * fx - x * fz
            N += x * fy - y * fx
        return Loads(X, Y, Z, L, M, N), weight_on_wheels
