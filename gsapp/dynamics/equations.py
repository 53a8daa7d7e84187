"""Six-degree-of-freedom equations of motion of a rigid aircraft with Ixy = Iyz = 0.

Two forms of the same physics:

- *polar*: V, alpha, beta, p, q, r, phi, theta, psi (4.1.15)-(4.1.20), for estimation. The
  misprints of the source are put right (sign of drag, thrust in V' and alpha', theta');
- *body axes*: u, v, w, p, q, r and a quaternion, for simulation. It has no singularity at zero
  speed or vertical attitude.

X, Y, Z are all forces but gravity along the body axes: aerodynamic, propulsive, and of the
ground. With X = T - qS C_A, Y = qS C_Y, Z = -qS C_N the polar form is that of the source. L, M, N
are all moments about the center of gravity. SI, radians. Every function takes single numbers and
arrays of shape (n,) alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gsapp.dynamics.arithmetic import Value, array_namespace
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY

POLAR_STATES = ("V", "alpha", "beta", "p", "q", "r", "phi", "theta", "psi")
Triple = tuple[Value, Value, Value]
"""Components along the body axes, or p, q, r."""
INERTIA_NAMES = ("mass", "ixx", "iyy", "izz", "ixz")


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidBody:
    """Mass (kg) and moments of inertia (kg m^2) about the center of gravity.

    Each may be an array of shape (n,): mass falls as fuel burns.
    """

    mass: Value
    ixx: Value
    iyy: Value
    izz: Value
    ixz: Value = 0.0


class PolarState(NamedTuple):
    """Speed (m/s), flow angles, rates (rad/s), attitude; radians."""

    V: Value
    alpha: Value
    beta: Value
    p: Value
    q: Value
    r: Value
    phi: Value
    theta: Value
    psi: Value


class Loads(NamedTuple):
    """Forces without gravity (N) and moments about the CG (N m) in body axes."""

    X: Value
    Y: Value
    Z: Value
    L: Value
    M: Value
    N: Value


def wind_axis_rates(state: PolarState, X: Value, Y: Value, Z: Value, mass: Value) -> Triple:
    """Return V', alpha', beta' (4.1.15)-(4.1.17), mended.

    X, Y, Z are forces without gravity along the body axes, N; mass in kg.
    """
    V, a, b, p, q, r, phi, theta, _ = state
    m = array_namespace(V)
    sa, ca, sb, cb = m.sin(a), m.cos(a), m.sin(b), m.cos(b)
    st, ct, sp, cp = m.sin(theta), m.cos(theta), m.sin(phi), m.cos(phi)
    ax = X / mass - GRAVITY * st
    ay = Y / mass + GRAVITY * ct * sp
    az = Z / mass + GRAVITY * ct * cp
    return (
        ca * cb * ax + sb * ay + sa * cb * az,
        q - (p * ca + r * sa) * sb / cb + (ca * az - sa * ax) / (V * cb),
        p * sa - r * ca + (cb * ay - sb * (ca * ax + sa * az)) / V,
    )


def angular_accelerations(
    p: Value, q: Value, r: Value, L: Value, M: Value, N: Value, body: RigidBody
) -> Triple:
    """Return p', q', r' (rad/s^2) from the moments about the CG (N m)."""
    ixx, iyy, izz, ixz = body.ixx, body.iyy, body.izz, body.ixz
    determinant = ixx * izz - ixz * ixz
    a = L + ixz * p * q - (izz - iyy) * q * r
    c = N - ixz * q * r - (iyy - ixx) * p * q
    return (
        (izz * a + ixz * c) / determinant,
        (M - (ixx - izz) * p * r - ixz * (p * p - r * r)) / iyy,
        (ixz * a + ixx * c) / determinant,
    )


def attitude_rates(p: Value, q: Value, r: Value, phi: Value, theta: Value) -> Triple:
    """Return phi', theta', psi' (rad/s) (4.1.8), (4.1.9); singular at theta = +/-90 deg."""
    m = array_namespace(phi)
    sp, cp = m.sin(phi), m.cos(phi)
    turn = (q * sp + r * cp) / m.cos(theta)
    return p + turn * m.sin(theta), q * cp - r * sp, turn


def polar_rates(state: PolarState, loads: Loads, body: RigidBody) -> tuple[Value, ...]:
    """Return the rates of the nine polar states, in their order."""
    flow = wind_axis_rates(state, loads.X, loads.Y, loads.Z, body.mass)
    spin = angular_accelerations(state.p, state.q, state.r, loads.L, loads.M, loads.N, body)
    turn = attitude_rates(state.p, state.q, state.r, state.phi, state.theta)
    return (*flow, *spin, *turn)


class PolarJacobian(NamedTuple):
    """Derivatives of the nine polar rates."""

    states: FloatArray  # Shape (n, 9, 9). With respect to `POLAR_STATES`.
    loads: FloatArray  # Shape (n, 9, 6). With respect to the loads, in the order of `Loads`.
    body: FloatArray  # Shape (n, 9, 5). With respect to `INERTIA_NAMES`.


def polar_jacobian(state: PolarState, loads: Loads, body: RigidBody) -> PolarJacobian:
    """Return the exact derivatives of `polar_rates`; numbers count as arrays of length 1."""
    V, a, b, p, q, r, phi, theta, _ = (np.atleast_1d(np.asarray(x)) for x in state)
    X, Y, Z, L, M, N = (np.atleast_1d(np.asarray(x)) for x in loads)
    count = np.broadcast_shapes(V.shape, X.shape, L.shape, p.shape, phi.shape)[0]
    f_x = np.zeros((count, 9, 9))
    f_l = np.zeros((count, 9, 6))
    f_b = np.zeros((count, 9, 5))
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    tb = sb / cb
    mass = body.mass
    ax = X / mass - GRAVITY * st
    ay = Y / mass + GRAVITY * ct * sp
    az = Z / mass + GRAVITY * ct * cp

    # V' = ca cb ax + sb ay + sa cb az
    forward = ca * ax + sa * az
    upward = ca * az - sa * ax
    f_x[:, 0, 1] = cb * upward
    f_x[:, 0, 2] = cb * ay - sb * forward
    # alpha' = q - tan b (p ca + r sa) + upward/(V cb)
    f_x[:, 1, 0] = -upward / (V * V * cb)
    f_x[:, 1, 1] = tb * (p * sa - r * ca) - forward / (V * cb)
    f_x[:, 1, 2] = -(p * ca + r * sa) / (cb * cb) + upward * sb / (V * cb * cb)
    f_x[:, 1, 3] = -tb * ca
    f_x[:, 1, 4] = 1.0
    f_x[:, 1, 5] = -tb * sa
    # beta' = p sa - r ca + (cb ay - sb forward)/V
    f_x[:, 2, 0] = -(cb * ay - sb * forward) / (V * V)
    f_x[:, 2, 1] = p * ca + r * sa - sb * upward / V
    f_x[:, 2, 2] = -(sb * ay + cb * forward) / V
    f_x[:, 2, 3] = sa
    f_x[:, 2, 5] = -ca

    # The three accelerations enter through the forces, the mass and gravity alike.
    by_acceleration = np.zeros((count, 3, 3))
    by_acceleration[:, 0, :] = np.stack(np.broadcast_arrays(ca * cb, sb, sa * cb), axis=-1)
    by_acceleration[:, 1, 0] = -sa / (V * cb)
    by_acceleration[:, 1, 2] = ca / (V * cb)
    by_acceleration[:, 2, 0] = -sb * ca / V
    by_acceleration[:, 2, 1] = cb / V
    by_acceleration[:, 2, 2] = -sb * sa / V
    by_phi = GRAVITY * np.stack(np.broadcast_arrays(0.0 * phi, ct * cp, -ct * sp), axis=-1)
    by_theta = GRAVITY * np.stack(np.broadcast_arrays(-ct, -st * sp, -st * cp), axis=-1)
    f_x[:, :3, 6] = np.einsum("nij,nj->ni", by_acceleration, by_phi)
    f_x[:, :3, 7] = np.einsum("nij,nj->ni", by_acceleration, by_theta)
    weight = np.broadcast_to(np.asarray(mass, dtype=np.float64), (count,))
    f_l[:, :3, :3] = by_acceleration / weight[:, None, None]
    force = np.stack(np.broadcast_arrays(X, Y, Z), axis=-1)
    f_b[:, :3, 0] = -np.einsum("nij,nj->ni", f_l[:, :3, :3], force) / weight[:, None]

    _angular_jacobian(f_x, f_l, f_b, (p, q, r), (L, M, N), body)

    # phi' = p + turn st, theta' = q cp - r sp, psi' = turn, turn = (q sp + r cp)/ct
    turn = (q * sp + r * cp) / ct
    side = (q * cp - r * sp) / ct
    f_x[:, 6, 3] = 1.0
    f_x[:, 6, 4] = sp * st / ct
    f_x[:, 6, 5] = cp * st / ct
    f_x[:, 6, 6] = side * st
    f_x[:, 6, 7] = turn / ct
    f_x[:, 7, 4] = cp
    f_x[:, 7, 5] = -sp
    f_x[:, 7, 6] = -turn * ct
    f_x[:, 8, 4] = sp / ct
    f_x[:, 8, 5] = cp / ct
    f_x[:, 8, 6] = side
    f_x[:, 8, 7] = turn * st / ct
    return PolarJacobian(f_x, f_l, f_b)


def _angular_jacobian(
    f_x: FloatArray,
    f_l: FloatArray,
    f_b: FloatArray,
    rates: tuple[FloatArray, FloatArray, FloatArray],
    moments: tuple[FloatArray, FloatArray, FloatArray],
    body: RigidBody,
) -> None:
    """Fill the rows of p', q', r'."""
    p, q, r = rates
    count = len(f_x)
    ixx, iyy, izz, ixz = body.ixx, body.iyy, body.izz, body.ixz
    determinant = ixx * izz - ixz * ixz
    inverse = np.zeros((count, 3, 3))
    inverse[:, 0, 0] = izz / determinant
    inverse[:, 0, 2] = ixz / determinant
    inverse[:, 1, 1] = 1.0 / iyy
    inverse[:, 2, 0] = ixz / determinant
    inverse[:, 2, 2] = ixx / determinant
    f_l[:, 3:6, 3:6] = inverse
    # Right-hand sides a, b, c of I w' = (a, b, c), by p, q, r.
    sides = np.zeros((count, 3, 3))
    sides[:, 0, 0] = ixz * q
    sides[:, 0, 1] = ixz * p - (izz - iyy) * r
    sides[:, 0, 2] = -(izz - iyy) * q
    sides[:, 1, 0] = -(ixx - izz) * r - 2.0 * ixz * p
    sides[:, 1, 2] = -(ixx - izz) * p + 2.0 * ixz * r
    sides[:, 2, 0] = -(iyy - ixx) * q
    sides[:, 2, 1] = -ixz * r - (iyy - ixx) * p
    sides[:, 2, 2] = -ixz * q
    f_x[:, 3:6, 3:6] = inverse @ sides
    # From I w' + w x I w = M: dw' = -I^-1 (dI w' + w x dI w).
    p_dot, q_dot, r_dot = angular_accelerations(p, q, r, *moments, body)
    zero = np.zeros(count)
    columns = (
        (p_dot, r * p, -q * p),  # ixx: dI w = (p, 0, 0)
        (-r * q, q_dot, p * q),  # iyy: (0, q, 0)
        (q * r, -p * r, r_dot),  # izz: (0, 0, r)
        (-r_dot - q * p, r * -r - p * -p, -p_dot - q * -r),  # ixz: (-r, 0, -p)
    )
    for index, column in enumerate(columns, start=1):
        vector = np.stack(np.broadcast_arrays(*column, zero)[:3], axis=-1)
        f_b[:, 3:6, index] = -np.einsum("nij,nj->ni", inverse, vector)


def body_from_polar(V: Value, alpha: Value, beta: Value) -> Triple:
    """Return u, v, w (m/s) from speed and flow angles."""
    m = array_namespace(V)
    forward = V * m.cos(beta)
    return forward * m.cos(alpha), V * m.sin(beta), forward * m.sin(alpha)


def body_rates(
    velocity: Triple,
    rates: Triple,
    force: Triple,
    gravity: Triple,
    mass: Value,
) -> Triple:
    """Return u', v', w' (4.1.2), signs of UR and WP mended.

    All along the body axes: `velocity` over the ground, m/s; `rates` p, q, r, rad/s; `force` X, Y,
    Z without gravity, N; `gravity`, m/s^2. Mass in kg.
    """
    u, v, w = velocity
    p, q, r = rates
    return (
        force[0] / mass + gravity[0] + r * v - q * w,
        force[1] / mass + gravity[1] + p * w - r * u,
        force[2] / mass + gravity[2] + q * u - p * v,
    )


Quaternion = tuple[float, float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]


def quaternion_from_euler(phi: float, theta: float, psi: float) -> Quaternion:
    """Return the attitude quaternion (scalar first, Earth to body)."""
    m = array_namespace(phi)
    sp, cp = m.sin(phi / 2.0), m.cos(phi / 2.0)
    st, ct = m.sin(theta / 2.0), m.cos(theta / 2.0)
    ss, cs = m.sin(psi / 2.0), m.cos(psi / 2.0)
    return (
        cp * ct * cs + sp * st * ss,
        sp * ct * cs - cp * st * ss,
        cp * st * cs + sp * ct * ss,
        cp * ct * ss - sp * st * cs,
    )


def euler_from_quaternion(attitude: Quaternion) -> tuple[float, float, float]:
    """Return phi, theta, psi (rad), psi in (-pi, pi]."""
    matrix = body_to_earth_matrix(attitude)
    m = array_namespace(attitude[0])
    return (
        m.atan2(matrix[7], matrix[8]),
        m.asin(min(1.0, max(-1.0, -matrix[6]))),
        m.atan2(matrix[3], matrix[0]),
    )


def body_to_earth_matrix(attitude: Quaternion) -> Matrix:
    """Return the body-to-Earth matrix, row by row: north = m[0] x + m[1] y + m[2] z, ..."""
    e0, e1, e2, e3 = attitude
    return (
        e0 * e0 + e1 * e1 - e2 * e2 - e3 * e3,
        2.0 * (e1 * e2 - e0 * e3),
        2.0 * (e1 * e3 + e0 * e2),
        2.0 * (e1 * e2 + e0 * e3),
        e0 * e0 - e1 * e1 + e2 * e2 - e3 * e3,
        2.0 * (e2 * e3 - e0 * e1),
        2.0 * (e1 * e3 - e0 * e2),
        2.0 * (e2 * e3 + e0 * e1),
        e0 * e0 - e1 * e1 - e2 * e2 + e3 * e3,
    )


def quaternion_rates(attitude: Quaternion, p: float, q: float, r: float) -> Quaternion:
    """Return the rates of the attitude quaternion for the body rates p, q, r (rad/s)."""
    e0, e1, e2, e3 = attitude
    return (
        -0.5 * (p * e1 + q * e2 + r * e3),
        0.5 * (p * e0 + r * e2 - q * e3),
        0.5 * (q * e0 - r * e1 + p * e3),
        0.5 * (r * e0 + q * e1 - p * e2),
    )
