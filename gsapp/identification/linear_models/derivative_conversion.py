"""Derivatives to linear models and back: appendix A of the source, mended (notes, section 4).

The steady condition is straight flight at speed U1. Longitudinal states are alpha, V, q, theta,
lateral-directional ones beta, p, r, phi; inputs are surface deflections; all SI and radians, small
changes from the steady values. Our derivatives are those of body axes; what the appendix writes
with lift and drag follows from them at the steady angle of attack:

    CL_alpha + CD1 = CN_alpha cos a1 - CA_alpha sin a1
    CD_alpha - CL1 = CA_alpha cos a1 + CN_alpha sin a1
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.linearization import (
    LATERAL_STATES,
    LONGITUDINAL_STATES,
    LinearModel,
    OperatingPoint,
)
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY

LONGITUDINAL_MODEL_OUTPUTS = ("an", "alpha", "V", "q", "theta")
LATERAL_MODEL_OUTPUTS = ("ay", "beta", "p", "r", "phi")


@dataclass(frozen=True, slots=True, kw_only=True)
class SteadyCondition:
    """The steady flight that a linear model belongs to."""

    U1: float  # Airspeed, m/s.
    mass: float  # kg.
    alpha1: float = 0.0
    climb_angle: float = 0.0
    de1: float = 0.0
    """rad; de1 is the elevator."""
    rho: float = SEA_LEVEL_DENSITY  # kg/m^3.
    stability_axes: bool = False
    """Whether p and r are those about stability axes, as printed in the source; gyros measure them
    about body axes."""
    thrust_slope: float = 0.0  # Change of thrust with airspeed, N s/m.

    @property
    def qbar(self) -> float:
        return 0.5 * self.rho * self.U1**2

    @property
    def operating_point(self) -> OperatingPoint:
        return OperatingPoint(speed=self.U1, density=self.rho, mass=self.mass)

    @property
    def theta1(self) -> float:
        """Return the steady pitch angle of the x axis in use, rad."""
        return self.climb_angle + (0.0 if self.stability_axes else self.alpha1)

    @property
    def rate_alpha(self) -> float:
        """Return the angle between the axes of p, r and the stability axes, rad."""
        return 0.0 if self.stability_axes else self.alpha1


@dataclass(frozen=True, slots=True, kw_only=True)
class _AccelerationScales:
    """What turns coefficients into accelerations."""

    force: float
    """qS/m, m/s^2."""
    pitch: float
    """qSc/Iyy, 1/s^2."""
    roll: float
    """qSb/Ixx, 1/s^2."""
    yaw: float
    """qSb/Izz, 1/s^2."""
    by_chord: float
    """c/2U1, s."""
    by_span: float
    """b/2U1, s."""
    A1: float
    """Ixz/Ixx."""
    B1: float
    """Ixz/Izz."""

    @classmethod
    def of(cls, aircraft: Aircraft, condition: SteadyCondition) -> _AccelerationScales:
        geometry, mass = aircraft.geometry, aircraft.mass
        qS = condition.qbar * geometry.wing_area
        return cls(
            force=qS / condition.mass,
            pitch=qS * geometry.chord / mass.iyy,
            roll=qS * geometry.span / mass.ixx,
            yaw=qS * geometry.span / mass.izz,
            by_chord=0.5 * geometry.chord / condition.U1,
            by_span=0.5 * geometry.span / condition.U1,
            A1=mass.ixz / mass.ixx,
            B1=mass.ixz / mass.izz,
        )


def solve_steady_flight(
    aircraft: Aircraft, condition: SteadyCondition, derivatives: Mapping[str, float]
) -> tuple[SteadyCondition, dict[str, float]]:
    """Return what keeps straight flight steady, completed to what speed changes.

    With engines it is level: thrust carries the drag and falls with speed as the aircraft file
    says; its moment, where the engines sit off the CG, is held by that of the air, which grows
    with qbar. Without engines the weight carries the drag, down the path at which it does so.

    `condition`: its `thrust_slope` is set, and without engines its `climb_angle`.
    `derivatives`: with ``CA_0`` and ``CA_alpha``; ``CA_de`` counts where it is given, at
    `SteadyCondition.de1`.

    Returns
    -------
    condition : SteadyCondition
    derivatives : dict of str to float
        With ``CL1``, ``CD1`` and ``Cm_V``.
    """
    given, alpha1 = derivatives.get, condition.alpha1
    s, c = math.sin(alpha1), math.cos(alpha1)
    qS = condition.qbar * aircraft.geometry.wing_area
    weight = condition.mass * GRAVITY
    CA1 = given("CA_0", 0.0) + given("CA_alpha", 0.0) * alpha1 + given("CA_de", 0.0) * condition.de1
    propulsion = aircraft.propulsion
    if not propulsion.max_thrust:
        # Along x nothing but drag and weight: qS C_A = -W sin theta1.
        pitch = -math.asin(min(max(qS * CA1 / weight, -1.0), 1.0))
        path = pitch - alpha1
        return replace(condition, climb_angle=path), {
            **derivatives,
            "CL1": weight * math.cos(path) / qS,
            "CD1": -weight * math.sin(path) / qS,
        }
    # L + T sin a1 = W, D = T cos a1, and C_A = C_D cos a1 - C_L sin a1.
    thrust = qS * CA1 + weight * s
    slope = -thrust / (propulsion.zero_thrust_speed - condition.U1)
    below = float(np.mean([z for _, _, z in propulsion.position])) if propulsion.position else 0.0
    by_speed = below * (slope * condition.U1 - 2.0 * thrust)
    return replace(condition, thrust_slope=slope * c), {
        **derivatives,
        "CL1": (weight - thrust * s) / qS,
        "CD1": thrust * c / qS,
        "Cm_V": given("Cm_V", 0.0) + by_speed / (qS * aircraft.geometry.chord),
    }


def longitudinal_model(
    aircraft: Aircraft, condition: SteadyCondition, derivatives: Mapping[str, float]
) -> LinearModel:
    """Return the linear model in alpha, V, q, theta for an elevator (7.3.7), (7.3.9).

    `derivatives`: ``CN_alpha CN_q CN_de CA_alpha CA_q CA_de Cm_alpha Cm_q Cm_de``, those left out
    are zero. ``CL1`` and ``CD1`` are the steady coefficients (`solve_steady_flight`); CL1 follows
    from the weight where left out, CD1 is not guessed: zero. ``Cm_alphadot`` and ``CL_alphadot``
    are the lag of the downwash (over c/2U1), ``Cm_V`` the moment that speed brings beyond qbar,
    over U1.

    Outputs an (m/s^2, positive up, of the air's force alone), alpha, V, q, theta.
    """
    scale = _AccelerationScales.of(aircraft, condition)
    given = derivatives.get
    U1, s, c = condition.U1, math.sin(condition.alpha1), math.cos(condition.alpha1)
    CL1 = given("CL1", GRAVITY * math.cos(condition.climb_angle) / scale.force)
    CD1 = given("CD1", 0.0)

    def lift(name: str) -> float:
        return given(f"CN_{name}", 0.0) * c - given(f"CA_{name}", 0.0) * s

    def drag(name: str) -> float:
        return given(f"CA_{name}", 0.0) * c + given(f"CN_{name}", 0.0) * s

    Z_alpha, Z_q, Z_de = (
        -scale.force * lift("alpha"),
        -scale.force * lift("q") * scale.by_chord,
        -scale.force * lift("de"),
    )
    Z_u = -scale.force * 2.0 * CL1 / U1
    Z_alphadot = -scale.force * given("CL_alphadot", 0.0) * scale.by_chord
    X_alpha, X_de = -scale.force * drag("alpha"), -scale.force * drag("de")
    X_u = -scale.force * 2.0 * CD1 / U1 + condition.thrust_slope / condition.mass
    M_alpha, M_de = scale.pitch * given("Cm_alpha", 0.0), scale.pitch * given("Cm_de", 0.0)
    M_q = scale.pitch * given("Cm_q", 0.0) * scale.by_chord
    M_alphadot = scale.pitch * given("Cm_alphadot", 0.0) * scale.by_chord
    M_u = scale.pitch * given("Cm_V", 0.0) / U1

    inertial = U1 - Z_alphadot
    climb = GRAVITY * math.sin(condition.climb_angle)
    # g cos gamma1 and g sin gamma1 in X'_a and Z'_a would count gravity twice.
    alpha_row = np.array([Z_alpha, Z_u, U1 + Z_q, -climb]) / inertial
    speed_row = np.array([X_alpha, X_u, 0.0, -GRAVITY * math.cos(condition.climb_angle)])
    pitch_row = M_alphadot * alpha_row + np.array([M_alpha, M_u, M_q, 0.0])
    A = np.array([alpha_row, speed_row, pitch_row, [0.0, 0.0, 1.0, 0.0]])
    b_alpha = Z_de / inertial
    B = np.array([[b_alpha], [X_de], [M_alphadot * b_alpha + M_de], [0.0]])
    # a_n is positive up: a_n = -(Z'' rows), Z'' = U1 Z' but for the centripetal q.
    normal = -U1 * alpha_row + np.array([0.0, 0.0, U1, -climb])
    C = np.vstack([normal, np.eye(4)])
    D = np.array([[-U1 * b_alpha], [0.0], [0.0], [0.0], [0.0]])
    return LinearModel(
        states=LONGITUDINAL_STATES,
        inputs=("de",),
        outputs=LONGITUDINAL_MODEL_OUTPUTS,
        A=A, B=B, C=C, D=D, operating_point=condition.operating_point,
    )  # fmt: skip


def lateral_model(
    aircraft: Aircraft, condition: SteadyCondition, derivatives: Mapping[str, float]
) -> LinearModel:
    """Return the linear model in beta, p, r, phi for ailerons and rudder (7.3.8), (7.3.10).

    `derivatives`: ``CY_beta CY_p CY_r CY_da CY_dr``, likewise ``Cl_`` and ``Cn_``; those left out
    are zero.

    Outputs ay (m/s^2, at the CG), beta, p, r, phi.
    """
    scale = _AccelerationScales.of(aircraft, condition)
    U1 = condition.U1
    columns = ("beta", "p", "r", "da", "dr")
    by = np.array([1.0, scale.by_span, scale.by_span, 1.0, 1.0])

    def row(coefficient: str) -> FloatArray:
        own = np.array([derivatives.get(f"{coefficient}_{name}", 0.0) for name in columns])
        return np.asarray(by * own, dtype=np.float64)

    Y, L, N = scale.force * row("CY"), scale.roll * row("Cl"), scale.yaw * row("Cn")
    coupled = 1.0 - scale.A1 * scale.B1
    L_modified, N_modified = (L + scale.A1 * N) / coupled, (N + scale.B1 * L) / coupled
    beta_row = Y / U1
    # Gyros turn with the body: their p has a part about the stability axes' z.
    beta_row[1] += math.sin(condition.rate_alpha)
    beta_row[2] -= math.cos(condition.rate_alpha)
    theta1 = condition.theta1
    A = np.array(
        [
            [*beta_row[:3], GRAVITY * math.cos(theta1) / U1],
            [*L_modified[:3], 0.0],
            [*N_modified[:3], 0.0],
            [0.0, 1.0, math.tan(theta1), 0.0],
        ]
    )
    B = np.array([beta_row[3:], L_modified[3:], N_modified[3:], [0.0, 0.0]])
    C = np.vstack([[*Y[:3], 0.0], np.eye(4)])
    D = np.vstack([Y[3:], np.zeros((4, 2))])
    return LinearModel(
        states=LATERAL_STATES,
        inputs=("da", "dr"),
        outputs=LATERAL_MODEL_OUTPUTS,
        A=A, B=B, C=C, D=D, operating_point=condition.operating_point,
    )  # fmt: skip


def longitudinal_derivatives(
    aircraft: Aircraft, condition: SteadyCondition, model: LinearModel
) -> dict[str, float]:
    """Return what a longitudinal model means: `longitudinal_model` undone, without alpha-dot.

    `model`: with at least the states alpha and q, and the input de. V adds the drag rows.

    ``CL_alpha+CD1 CL_q CL_de Cm_alpha Cm_q Cm_de``; with V also ``CD_alpha-CL1 CD_de``. In body
    axes at alpha1 = 0 the first is CN_alpha, the last two CA_alpha and CA_de.
    """
    scale = _AccelerationScales.of(aircraft, condition)
    U1 = condition.U1
    alpha, q, de = model.states.index("alpha"), model.states.index("q"), model.inputs.index("de")
    A, B = model.A, model.B
    found = {
        "CL_alpha+CD1": -A[alpha, alpha] * U1 / scale.force,
        "CL_q": -(A[alpha, q] - 1.0) * U1 / scale.force / scale.by_chord,
        "CL_de": -B[alpha, de] * U1 / scale.force,
        "Cm_alpha": A[q, alpha] / scale.pitch,
        "Cm_q": A[q, q] / scale.pitch / scale.by_chord,
        "Cm_de": B[q, de] / scale.pitch,
    }
    if "V" in model.states:
        V = model.states.index("V")
        found["CD_alpha-CL1"] = -A[V, alpha] / scale.force
        found["CD_de"] = -B[V, de] / scale.force
    return {name: float(value) for name, value in found.items()}


def lateral_derivatives(
    aircraft: Aircraft, condition: SteadyCondition, model: LinearModel
) -> dict[str, float]:
    """Return the derivatives CY, Cl, Cn of a lateral-directional model: `lateral_model` undone."""
    scale = _AccelerationScales.of(aircraft, condition)
    states = [model.states.index(name) for name in ("beta", "p", "r")]
    inputs = [model.inputs.index(name) for name in ("da", "dr")]
    rows = np.column_stack([model.A[np.ix_(states, states)], model.B[np.ix_(states, inputs)]])
    beta_row, L_modified, N_modified = rows.copy()
    beta_row[1] -= math.sin(condition.rate_alpha)
    beta_row[2] += math.cos(condition.rate_alpha)
    by = np.array([1.0, scale.by_span, scale.by_span, 1.0, 1.0])
    table = {
        "CY": beta_row * condition.U1 / scale.force / by,
        "Cl": (L_modified - scale.A1 * N_modified) / scale.roll / by,
        "Cn": (N_modified - scale.B1 * L_modified) / scale.yaw / by,
    }
    return {
        f"{coefficient}_{name}": float(value)
        for coefficient, values in table.items()
        for name, value in zip(("beta", "p", "r", "da", "dr"), values, strict=True)
    }
