"""How the body answers: inertia, noise of its instruments, what errors of the rates reach."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.identification.axes import AXIS_COEFFICIENTS
from gsapp.identification.ftr.channels import FORCE_ACCELEROMETER, FTRAxis, axis_regressors
from gsapp.identification.record_preparation import advance_samples
from gsapp.quantities import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisDynamics:
    """What the regressions of an axis know of the body.

    The rates, the moments that turn them, and the inertia between; and the accelerometers.
    """

    inertia: FloatArray
    """Shape (n, n). Over S c or S b."""
    rate_error_gain: FloatArray
    """Shape (p, n). What an error of the rates makes of the regressors, as a multiple of what it
    makes of its own: flow angles are moved to the CG by the rates."""
    band_noise_ratio: FloatArray
    """Shape (p,). Variance of white noise in the band over that from second differences: bringing
    late channels to their time smoothes the latter, not the former."""
    noise: FloatArray
    """Shape (p,). Variance of the regressors' own instruments, rad^2, by the aircraft file: what is
    seen beyond it is air that really moves. Zero for the rates."""
    is_rate: BoolArray
    """Shape (p,). Whether a regressor is a rate."""
    rate_noise_share: FloatArray
    """Shape (3,). Share of what the residuals of an equation have in common with the errors of the
    rates that is put down to these: all in the moments; half in the forces, whose residuals go with
    those of the moments through noise of a vane, too, and nothing tells the two apart."""
    accelerometer_offset: FloatArray
    """Shape (3,). What the accelerometers' uncertain zero makes of qbar C, Pa."""
    regressors: tuple[int, ...]
    equations: tuple[int, ...]
    """Places of the rates among the regressors, of the moments among the equations."""


def build_axis_dynamics(
    aircraft: Aircraft,
    axis: FTRAxis,
    *,
    mass: float,
    accelerometer_offset: float,
    late: Mapping[str, float],
) -> AxisDynamics:
    """Return how the rates of an axis answer to its moments.

    Parameters
    ----------
    mass : float
        At the start, kg.
    accelerometer_offset : float
        Uncertain zero, m/s^2.
    late : mapping of str to float
        Sample times by which channels are late.
    """
    geometry, body = aircraft.geometry, aircraft.mass
    zero = accelerometer_offset * mass / geometry.wing_area
    offset = np.array(
        [zero if name in FORCE_ACCELEROMETER else 0.0 for name in AXIS_COEFFICIENTS[axis]]
    )
    sensors = aircraft.sensors
    own = {
        "alpha": sensors.alpha_vane.noise / sensors.alpha_vane.upwash,
        "beta": sensors.beta_vane.noise / sensors.beta_vane.upwash,
        **dict.fromkeys(("p", "q", "r"), 0.0),
    }
    names = axis_regressors(axis)
    sharpness = _band_noise_ratio(names, late)
    noise = np.array([own.get(name, sensors.surfaces.noise) ** 2 for name in names])
    trust = np.array(
        [0.5 if name in FORCE_ACCELEROMETER else 1.0 for name in AXIS_COEFFICIENTS[axis]]
    )
    turns = np.array([name in ("p", "q", "r") for name in names])
    if axis == "lon":
        inertia = np.array([[body.iyy]]) / (geometry.wing_area * geometry.chord)
        x, _, _ = aircraft.sensors.alpha_vane.position
        return AxisDynamics(
            inertia=inertia,
            rate_error_gain=np.array([[2.0 * x / geometry.chord], [1.0], [0.0]]),
            band_noise_ratio=sharpness,
            noise=noise,
            is_rate=turns,
            rate_noise_share=trust,
            accelerometer_offset=offset,
            regressors=(1,),
            equations=(2,),
        )
    inertia = np.array([[body.ixx, -body.ixz], [-body.ixz, body.izz]])
    inertia = inertia / (geometry.wing_area * geometry.span)
    x, _, z = aircraft.sensors.beta_vane.position
    reach = np.zeros((5, 2))
    reach[0] = 2.0 * z / geometry.span, -2.0 * x / geometry.span
    reach[1, 0] = reach[2, 1] = 1.0
    return AxisDynamics(
        inertia=inertia,
        rate_error_gain=reach,
        band_noise_ratio=sharpness,
        noise=noise,
        is_rate=turns,
        rate_noise_share=trust,
        accelerometer_offset=offset,
        regressors=(1, 2),
        equations=(1, 2),
    )


def _band_noise_ratio(names: Iterable[str], late: Mapping[str, float]) -> FloatArray:
    """Return `AxisDynamics.sharpness`."""
    found = []
    for name in names:
        pulse = np.zeros(32)
        pulse[20] = 1.0
        steps = late.get(name, 0.0) % 1.0
        found.append(6.0 / float((np.diff(advance_samples(pulse, steps)[:30], n=2) ** 2).sum()))
    return np.array(found)
