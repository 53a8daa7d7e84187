"""Flight-path reconstruction: the motion that rates and accelerations make, in closed form.

With C the rotation from the body to where its axes stood at the first sample, the velocity of the
accelerometer through the air is

    v(t) = C' (n0 + integral of (C a) + g0 t),

a the specific force, g0 gravity along the first axes. Nothing but two running integrals: the
equations of u', v', w', phi', theta' solved exactly, no matter how far the aircraft turns. The
place of the accelerometer needs no angular acceleration, as its own velocity is integrated;
vanes, pitot and center of gravity are one cross product away. Given C, n0 and g0 are linear.

Errors of the gyros turn C by a small angle psi (along the first axes), psi' = C dw; then
dn' = psi x C a + C da and dv = C' (dn - psi x n): sensitivities are running integrals, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY

IndexArray = npt.NDArray[np.intp]


def cumulative_integral(values: FloatArray, dt: float) -> FloatArray:
    """Return the integral from the first sample on, cubic between samples, shape as given."""
    steps = 0.5 * (values[1:] + values[:-1])
    if len(values) > 3:
        steps[1:-1] = (13.0 * (values[1:-2] + values[2:-1]) - values[:-3] - values[3:]) / 24.0
    total = np.empty_like(values)
    total[0] = 0.0
    np.cumsum(steps, axis=0, out=total[1:])
    total *= dt
    return total


def integrate_rotation_matrices(rates: FloatArray, dt: float) -> FloatArray:
    """Return C, from the body's axes to those of the first sample, shape (n, 3, 3).

    `rates`, shape (n, 3): rad/s.
    `dt`: sample time, s.
    """
    turns = np.diff(cumulative_integral(rates, dt), axis=0)
    angle = np.sqrt((turns * turns).sum(axis=1))
    half = np.sinc(angle / (2.0 * np.pi)) * 0.5
    q = np.empty((4, len(rates)))
    q[:, 0] = (1.0, 0.0, 0.0, 0.0)
    q[0, 1:] = np.cos(0.5 * angle)
    q[1:, 1:] = half * turns.T
    # Products of all turns up to each sample, by doubling.
    reach = 1
    while reach < q.shape[1]:
        a, b, c, d = q[:, :-reach]
        e, f, g, h = q[:, reach:]
        q[:, reach:] = (
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        )
        reach *= 2
    w, x, y, z = q / np.sqrt((q * q).sum(axis=0))
    C = np.empty((q.shape[1], 3, 3))
    C[:, 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    C[:, 0, 1] = 2.0 * (x * y - w * z)
    C[:, 0, 2] = 2.0 * (x * z + w * y)
    C[:, 1, 0] = 2.0 * (x * y + w * z)
    C[:, 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    C[:, 1, 2] = 2.0 * (y * z - w * x)
    C[:, 2, 0] = 2.0 * (x * z - w * y)
    C[:, 2, 1] = 2.0 * (y * z + w * x)
    C[:, 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    return C


def rotate_to_initial_axes(C: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return C v along the first axes, shape (n, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", C, vectors), dtype=np.float64)


def rotate_to_body_axes(C: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return C' v along the body's axes, shape (n, 3, ...)."""
    return np.asarray(np.einsum("nji,nj...->ni...", C, vectors), dtype=np.float64)


def cross_product_matrices(vectors: FloatArray) -> FloatArray:
    """Return the matrices of v x, shape (..., 3, 3)."""
    found = np.zeros((*vectors.shape, 3))
    x, y, z = np.moveaxis(vectors, -1, 0)
    found[..., 0, 1], found[..., 0, 2] = -z, y
    found[..., 1, 0], found[..., 1, 2] = z, -x
    found[..., 2, 0], found[..., 2, 1] = -y, x
    return found


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReconstructedPath:
    """The motion of one stretch."""

    times: FloatArray  # Shape (n,). From the first sample on, s.
    rates: FloatArray
    force: FloatArray
    """Shape (n, 3). Freed of errors: rad/s; specific force along x, y, z, m/s^2."""
    C: FloatArray  # Shape (n, 3, 3).
    force_initial_axes: FloatArray  # Shape (n, 3). C a, m/s^2.
    velocity_initial_axes: FloatArray
    """Shape (n, 3). Velocity of the accelerometer along the first axes, m/s."""
    velocity: FloatArray  # Shape (n, 3). The same along the body's axes: u, v, w.
    gravity: FloatArray  # Shape (n, 3). Along the body's axes, m/s^2.
    initial_gravity: FloatArray  # Shape (3,).

    @property
    def attitude(self) -> tuple[FloatArray, FloatArray]:
        """Return phi and theta, rad, each of shape (n,)."""
        gx, gy, gz = self.gravity.T
        return np.arctan2(gy, gz), -np.arcsin(np.clip(gx / GRAVITY, -1.0, 1.0))


def reconstruct_path(
    rates: FloatArray, force: FloatArray, dt: float, first: FloatArray, gravity_first: FloatArray
) -> ReconstructedPath:
    """Integrate a stretch.

    Parameters
    ----------
    rates, force : ndarray, shape (n, 3)
        As in `ReconstructedPath`.
    dt : float
        s.
    first : ndarray, shape (3,)
        Velocity of the accelerometer at the first sample, m/s.
    gravity_first : ndarray, shape (3,)
        m/s^2, along the body's axes at the first sample.
    """
    times = dt * np.arange(len(rates), dtype=np.float64)
    C = integrate_rotation_matrices(rates, dt)
    pushed = rotate_to_initial_axes(C, force)
    flown = first + cumulative_integral(pushed, dt) + times[:, None] * gravity_first
    return ReconstructedPath(
        times=times,
        rates=rates,
        force=force,
        C=C,
        force_initial_axes=pushed,
        velocity_initial_axes=flown,
        velocity=rotate_to_body_axes(C, flown),
        gravity=rotate_to_body_axes(C, np.broadcast_to(gravity_first, flown.shape)),
        initial_gravity=gravity_first,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PathSensitivities:
    """Derivatives of a path, each of shape (n, 3, m): one column for each cause."""

    velocity: FloatArray
    gravity: FloatArray
    rates: FloatArray
    """Along the body's axes."""


def sensitivities_to_rates(
    path: ReconstructedPath, dt: float, axes: IndexArray, changes: FloatArray
) -> PathSensitivities:
    """Return what changes of the rates do.

    `axes`, shape (m,): about which axis each change is.
    `changes`, shape (n, m).
    """
    # psi, shape (n, m, 3): vectors last, for cross products.
    psi = cumulative_integral(path.C[:, :, axes].transpose(0, 2, 1) * changes[:, :, None], dt)
    n = cumulative_integral(np.cross(psi, path.force_initial_axes[:, None, :]), dt)
    n -= np.cross(psi, path.velocity_initial_axes[:, None, :])
    g = -np.cross(psi, path.initial_gravity)
    rates = np.zeros((len(changes), 3, axes.size))
    rates[:, axes, np.arange(axes.size)] = changes
    return PathSensitivities(
        velocity=rotate_to_body_axes(path.C, n.transpose(0, 2, 1)),
        gravity=rotate_to_body_axes(path.C, g.transpose(0, 2, 1)),
        rates=rates,
    )


def sensitivities_to_force(
    path: ReconstructedPath, dt: float, axes: IndexArray, changes: FloatArray
) -> PathSensitivities:
    """Return what changes of the specific force do; arguments as in `sensitivities_to_rates`."""
    n = cumulative_integral(path.C[:, :, axes] * changes[:, None, :], dt)
    nothing = np.zeros_like(n)
    return PathSensitivities(
        velocity=rotate_to_body_axes(path.C, n), gravity=nothing, rates=nothing
    )


def sensitivities_to_initial_state(
    path: ReconstructedPath, tangents: FloatArray
) -> PathSensitivities:
    """Return what the first velocity (3 columns) and the first attitude (2 columns) do.

    `tangents`, shape (2, 3): changes of the first gravity, m/s^2 per rad.
    """
    back = path.C.transpose(0, 2, 1)
    tilt = back @ tangents.T
    nothing = np.zeros((len(back), 3, 5))
    gravity = nothing.copy()
    gravity[:, :, 3:] = tilt
    return PathSensitivities(
        velocity=np.concatenate((back, path.times[:, None, None] * tilt), axis=2),
        gravity=gravity,
        rates=nothing,
    )


def gravity_tangents(gravity_first: FloatArray) -> FloatArray:
    """Return two changes of gravity that turn it without stretching it, shape (2, 3)."""
    down = gravity_first / GRAVITY
    across = np.cross(down, (1.0, 0.0, 0.0))
    across /= np.sqrt(across @ across)
    return GRAVITY * np.stack((across, np.cross(across, down)))
