"""What the instruments are exposed to where they sit (NOTES: sensors at (x, y, z) from the CG)."""

from __future__ import annotations

import math

from gsapp.dynamics.atmosphere import GRAVITY

Vector = tuple[float, float, float]


def velocity_at(position: Vector, flow: Vector, rates: Vector) -> Vector:
    """Return the velocity through the air at a place on the aircraft, body axes, m/s."""
    x, y, z = position
    u, v, w = flow
    p, q, r = rates
    return u + q * z - r * y, v + r * x - p * z, w + p * y - q * x


def accelerations_at(position: Vector, force: Vector, rates: Vector, spin: Vector) -> Vector:
    """Return ax, ay, an (m/s^2) as an accelerometer at a place reads them.

    Parameters
    ----------
    position : tuple of float
        From the CG, m.
    force : tuple of float
        Specific force at the CG along the body axes, m/s^2.
    rates, spin : tuple of float
        p, q, r (rad/s) and their rates (rad/s^2).
    """
    x, y, z = position
    p, q, r = rates
    p_dot, q_dot, r_dot = spin
    ax = force[0] - (q * q + r * r) * x + (p * q - r_dot) * y + (p * r + q_dot) * z
    ay = force[1] + (p * q + r_dot) * x - (p * p + r * r) * y + (q * r - p_dot) * z
    az = force[2] + (p * r - q_dot) * x + (q * r + p_dot) * y - (p * p + q * q) * z
    return ax, ay, -az


def flow_angles(flow: Vector) -> tuple[float, float, float]:
    """Return V, alpha, beta; the angles are zero where there is hardly any flow."""
    u, v, w = flow
    V = math.sqrt(u * u + v * v + w * w)
    if V < CALM:
        return V, 0.0, 0.0
    return V, math.atan2(w, u), math.asin(v / V)


CALM = 3.0
"""Below this airspeed, m/s, vanes hang where friction holds them."""


def alpha_vane(flow: Vector, upwash: float) -> float:
    """Return the angle of an alpha vane, rad."""
    return upwash * math.atan2(flow[2], flow[0]) if _speed(flow) > CALM else 0.0


def beta_vane(flow: Vector, kind: str, upwash: float) -> float:
    """Return the angle of a beta vane, fixed on the body's z axis or swiveling, rad."""
    speed = _speed(flow)
    if speed < CALM:
        return 0.0
    angle = math.atan2(flow[1], flow[0]) if kind == "fixed" else math.asin(flow[1] / speed)
    return upwash * angle


def _speed(flow: Vector) -> float:
    return math.sqrt(flow[0] ** 2 + flow[1] ** 2 + flow[2] ** 2)


__all__ = [
    "CALM",
    "GRAVITY",
    "Vector",
    "accelerations_at",
    "alpha_vane",
    "beta_vane",
    "flow_angles",
    "velocity_at",
]
