r"""Derivatives in the forms that others publish: lift and drag, dimensional, at the vane, A and B.

All are linear in the derivatives of the build-up, so values and full covariance carry over exactly.
Body axes throughout, as gyros measure; about the CG as flown; at the mean speed and density of the
maneuvers.

Lift and drag are turned by the steady angle of attack, and so hold what the turning of the axes
adds: :math:`C_{L,\alpha} = C_{N,\alpha} \cos\alpha_1 - C_{A,\alpha} \sin\alpha_1 - C_{D,1}`.

Dimensional moments are those of the equations of :math:`p'` and :math:`r'`, so the product of
inertia is in them (primed, in McRuer's notation).

A vane ahead of the CG shows :math:`\alpha_v = \alpha - q x/V` and
:math:`\beta_v = \beta + (r x - p z)/V`. Who takes its angle for the state finds, for a moment or
force :math:`F`,

.. math::
    F_q' = F_q + F_\alpha x/V, \quad F_r' = F_r - F_\beta x/V, \quad F_p' = F_p + F_\beta z/V,

and in the equation of the angle itself the acceleration of the vane's own place,
:math:`Z_k' \leftarrow Z_k' - x M_k'` and :math:`Y_k' \leftarrow Y_k' + x N_k' - z L_k'`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.linearization import LinearModel
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_SURFACES
from gsapp.identification.campaign import CampaignResult, CampaignSettings, CampaignValue
from gsapp.identification.estimate_corrections import derivatives_about_flown_cg
from gsapp.identification.linear_models.derivative_conversion import SteadyCondition
from gsapp.identification.linear_models.model_comparison import mean_condition
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.results import Estimate
from gsapp.identification.summary.campaign_linear_models import (
    known_derivatives,
    model_about_flown_cg,
)
from gsapp.identification.summary.mean_covariance import mean_covariance
from gsapp.identification.summary.mode_uncertainty import (
    ModeUncertainty,
    propagate_mode_covariance,
)
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY
from gsapp.quantities.fields import Position

FORM_TITLES: Final[Mapping[str, str]] = {
    "CL-CD": "lift and drag coefficients (stability axes)",
    "CX-CZ": "body-axis force coefficients",
    "dimensional": "dimensional derivatives, flow angles at the CG",
    "dimensional-vane": "dimensional derivatives, flow angles at the vanes",
    "state-space": "state matrices and modes",
}
"""The forms by the words of ``gsapp estimate --form``."""

_RATES: Final = ("p", "q", "r")
_LATERAL: Final = ("beta", "p", "r", "da", "dr")
_LONGITUDINAL: Final = ("alpha", "q", "de")

Row = dict[str, float]
"""Factor of each derivative of the build-up in one derivative of another form; '' is constant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FormValue:
    """One derivative of a form."""

    value: float
    std: float
    unit: str = ""  # SI; empty for a coefficient per radian.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DerivativeForms:
    """The derivatives of one axis in other forms."""

    axis: LinearAxis
    condition: SteadyCondition
    vane: Position  # Of the alpha vane (longitudinal) or the beta vane, from the CG, m.
    values: Mapping[str, Mapping[str, FormValue]]
    """By form and name. What needs a derivative that is not known is left out."""
    model: LinearModel | None = None
    vane_model: LinearModel | None = None
    """A and B with the flow angle at the CG, and at the vane, among the states; None where
    derivatives are missing that no model can do without."""
    modes: tuple[ModeUncertainty, ...] = ()


def forms_of_means(
    result: CampaignResult, values: Mapping[str, CampaignValue]
) -> dict[LinearAxis, DerivativeForms]:
    """Return the means of a campaign in other forms, by axis.

    `values`: the means. What was held, or a model knows, counts as exact.
    """
    means = {name: one.mean for name, one in values.items()}
    names = tuple(means)
    flown = [one.maneuver for one in result.results if one.estimate is not None]
    known = known_derivatives(result.settings, means)
    covariance = mean_covariance(result, values, names)
    return _forms(result.settings, flown, known, names, covariance)


def forms_of_estimate(
    result: CampaignResult, estimate: Estimate
) -> dict[LinearAxis, DerivativeForms]:
    """Return one fit of a campaign, such as a joint one, in other forms, by axis."""
    found = {name: float(estimate.value(name) or 0.0) for name in estimate.free}
    flown = [one.maneuver for one in result.results if one.maneuver.id in estimate.maneuvers]
    held = {
        name: one.value
        for name, one in estimate.derivatives.items()
        if one.status == "held" and one.value is not None
    }
    return _forms(result.settings, flown, {**held, **found}, tuple(found), estimate.covariance)


def _forms(
    settings: CampaignSettings,
    flown: Sequence[Maneuver],
    values: Mapping[str, float],
    names: Sequence[str],
    covariance: FloatArray,
) -> dict[LinearAxis, DerivativeForms]:
    found: dict[LinearAxis, DerivativeForms] = {}
    axes: tuple[LinearAxis, ...] = ("lon", "lat")
    for axis in axes:
        own = [one for one in flown if not set(AXIS_SURFACES[axis]).isdisjoint(one.inputs)]
        if not own:
            continue
        # Without airspeed there is no dimensional form.
        with contextlib.suppress(FlightError):
            condition = mean_condition(own, settings.stand_ins)
            found[axis] = _axis_forms(axis, own[0], condition, values, names, covariance)
    return found


def _axis_forms(
    axis: LinearAxis,
    first: Maneuver,
    condition: SteadyCondition,
    values: Mapping[str, float],
    names: Sequence[str],
    covariance: FloatArray,
) -> DerivativeForms:
    sensors = first.aircraft.sensors
    vane = (sensors.alpha_vane if axis == "lon" else sensors.beta_vane).position
    build = _DimensionalRows(first.aircraft, condition, first.cg_shift)
    dimensional = build.longitudinal() if axis == "lon" else build.lateral()
    rows: dict[str, Mapping[str, Row]] = {}
    if axis == "lon":
        rows["CL-CD"] = _lift_and_drag_rows(condition)
        rows["CX-CZ"] = {
            f"{body}_{term}": {f"{force}_{term}": -1.0}
            for body, force in (("CX", "CA"), ("CZ", "CN"))
            for term in ("0", *_LONGITUDINAL)
        }
    rows["dimensional"] = dimensional
    rows["dimensional-vane"] = _rows_at_vane(dimensional, axis, vane, condition.U1)
    forms = DerivativeForms(
        axis=axis,
        condition=condition,
        vane=vane,
        values={
            form: _evaluate(own, form, values, names, covariance) for form, own in rows.items()
        },
    )
    try:
        model = model_about_flown_cg(first, condition, axis, values)
        modes = propagate_mode_covariance(first, condition, axis, values, names, covariance)
    except FlightError:
        return forms
    return replace(forms, model=model, vane_model=model_at_vane(model, vane), modes=modes)


def _evaluate(
    rows: Mapping[str, Row],
    form: str,
    values: Mapping[str, float],
    names: Sequence[str],
    covariance: FloatArray,
) -> dict[str, FormValue]:
    found = {}
    for name, row in rows.items():
        needed = [one for one in row if one]
        if not all(one in values for one in needed):
            continue
        slopes = np.array([row.get(one, 0.0) for one in names])
        found[name] = FormValue(
            value=row.get("", 0.0) + sum(row[one] * values[one] for one in needed),
            std=float(np.sqrt(max(float(slopes @ covariance @ slopes), 0.0))),
            unit=_unit(name) if form.startswith("dimensional") else "",
        )
    # What was held alone is no result.
    return {name: one for name, one in found.items() if one.std > 0.0}


def _unit(name: str) -> str:
    head, _, term = name.partition("_")
    if term == "u":
        return "1/s"
    if head in "LMN":
        return "1/s" if term in _RATES else "1/s^2"
    return "m/s" if term in _RATES else "m/s^2"


def _sum(*parts: tuple[float, Mapping[str, float]]) -> Row:
    """Return a combination of rows; what cancels or counts nothing needs no value."""
    total: Row = {}
    for factor, row in parts:
        for name, one in row.items():
            total[name] = total.get(name, 0.0) + factor * one
    return {name: one for name, one in total.items() if one != 0.0}


def _steady_row(force: str, condition: SteadyCondition) -> Row:
    """Return a body-axis force coefficient in the steady flight."""
    row = {
        f"{force}_0": 1.0,
        f"{force}_alpha": condition.alpha1,
        f"{force}_de": condition.de1,
    }
    return {name: one for name, one in row.items() if one}


def _lift_and_drag_rows(condition: SteadyCondition) -> dict[str, Row]:
    s, c = np.sin(condition.alpha1), np.cos(condition.alpha1)
    normal, axial = _steady_row("CN", condition), _steady_row("CA", condition)
    lift, drag = _sum((c, normal), (-s, axial)), _sum((c, axial), (s, normal))
    rows: dict[str, Row] = {}
    for term in _LONGITUDINAL:
        own, other = {f"CN_{term}": 1.0}, {f"CA_{term}": 1.0}
        turned = 1.0 if term == "alpha" else 0.0
        rows[f"CL_{term}"] = _sum((c, own), (-s, other), (-turned, drag))
        rows[f"CD_{term}"] = _sum((c, other), (s, own), (turned, lift))
    for head, steady in (("CL", lift), ("CD", drag)):
        rows[f"{head}_0"] = _sum(
            (1.0, steady),
            (-condition.alpha1, rows[f"{head}_alpha"]),
            (-condition.de1, rows[f"{head}_de"]),
        )
    order = [f"{head}_{term}" for head in ("CL", "CD") for term in ("0", *_LONGITUDINAL)]
    return {name: rows[name] for name in order}


class _DimensionalRows:
    """Dimensional derivatives of an aircraft in a steady condition, as rows."""

    def __init__(self, aircraft: Aircraft, condition: SteadyCondition, cg_shift: Position) -> None:
        self._aircraft, self._condition, self._shift = aircraft, condition, cg_shift

    def longitudinal(self) -> dict[str, Row]:
        """Return X, Z and M by u, alpha, q, de."""
        aircraft, condition = self._aircraft, self._condition
        V = condition.U1
        force = condition.qbar * aircraft.geometry.wing_area / condition.mass
        axial, normal = _steady_row("CA", condition), _steady_row("CN", condition)
        thrust_by_speed: Row = {}
        if aircraft.propulsion.max_thrust:
            # Thrust balances drag and weight along x, and falls to zero at a speed.
            level: Row = {"": GRAVITY * np.sin(condition.theta1)}
            slope = -1.0 / (aircraft.propulsion.zero_thrust_speed - V)
            thrust_by_speed = _sum((slope * force, axial), (slope, level))
        rows = {"X_u": _sum((-2.0 * force / V, axial), (1.0, thrust_by_speed))}
        rows |= {f"X_{term}": self._force("CA", term, -force) for term in _LONGITUDINAL}
        rows["Z_u"] = _sum((-2.0 * force / V, normal))
        rows |= {f"Z_{term}": self._force("CN", term, -force) for term in _LONGITUDINAL}
        return rows | {
            f"M_{term}": _sum((1.0 / aircraft.mass.iyy, self._moment("Cm", term)))
            for term in _LONGITUDINAL
        }

    def lateral(self) -> dict[str, Row]:
        """Return Y, L and N by beta, p, r, da, dr."""
        aircraft, condition = self._aircraft, self._condition
        mass = aircraft.mass
        force = condition.qbar * aircraft.geometry.wing_area / condition.mass
        determinant = mass.ixx * mass.izz - mass.ixz**2
        rows = {f"Y_{term}": self._force("CY", term, force) for term in _LATERAL}
        for name, by_roll, by_yaw in (
            ("L", mass.izz / determinant, mass.ixz / determinant),
            ("N", mass.ixz / determinant, mass.ixx / determinant),
        ):
            rows |= {
                f"{name}_{term}": _sum(
                    (by_roll, self._moment("Cl", term)), (by_yaw, self._moment("Cn", term))
                )
                for term in _LATERAL
            }
        return rows

    def _by(self, term: str) -> float:
        """Return what makes the regressor of the build-up from a rate, s; 1 for an angle."""
        geometry = self._aircraft.geometry
        length = geometry.chord if term == "q" else geometry.span
        return 0.5 * length / self._condition.U1 if term in _RATES else 1.0

    def _force(self, coefficient: str, term: str, scale: float) -> Row:
        return {f"{coefficient}_{term}": scale * self._by(term)}

    def _moment(self, coefficient: str, term: str) -> Row:
        """Return a moment about the CG as flown, N m per rad or rad/s."""
        geometry = self._aircraft.geometry
        length = geometry.chord if coefficient == "Cm" else geometry.span
        scale = self._condition.qbar * geometry.wing_area * length * self._by(term)
        name = f"{coefficient}_{term}"
        forces = ("CN", "CA") if coefficient == "Cm" else ("CY",)
        parts = (name, *(f"{one}_{term}" for one in forces))
        return _sum(
            *(
                (
                    scale
                    * derivatives_about_flown_cg(
                        {one: float(one == part) for one in parts}, self._shift, geometry
                    )[name],
                    {part: 1.0},
                )
                for part in parts
            )
        )


def _rows_at_vane(
    rows: Mapping[str, Row], axis: LinearAxis, vane: Position, V: float
) -> dict[str, Row]:
    """Return dimensional rows with the flow angle at a vane in the place of that at the CG."""
    x, _, z = vane
    arms = {"q": x / V} if axis == "lon" else {"r": -x / V, "p": z / V}
    angle = "alpha" if axis == "lon" else "beta"
    found = {
        name: _sum((1.0, row), (arms.get(name[2:], 0.0), rows[f"{name[0]}_{angle}"]))
        for name, row in rows.items()
    }
    # The angle's own equation holds the acceleration of the vane's place.
    for name in [one for one in found if one[0] in "ZY" and one != "Z_u"]:
        term = name[2:]
        if axis == "lon":
            found[name] = _sum((1.0, found[name]), (-x, found[f"M_{term}"]))
        else:
            found[name] = _sum(
                (1.0, found[name]), (x, found[f"N_{term}"]), (-z, found[f"L_{term}"])
            )
    return found


def model_at_vane(model: LinearModel, vane: Position) -> LinearModel:
    """Return a linear model whose flow angle is the one that a vane shows."""
    x, _, z = vane
    V = 1.0 if model.operating_point is None else model.operating_point.speed
    shown = np.eye(len(model.states))
    for angle, arms in (("alpha", {"q": -x / V}), ("beta", {"r": x / V, "p": -z / V})):
        for rate, arm in arms.items():
            if angle in model.states and rate in model.states:
                shown[model.states.index(angle), model.states.index(rate)] = arm
    back = np.linalg.inv(shown)
    return replace(
        model, A=shown @ model.A @ back, B=shown @ model.B, C=model.C @ back
    )  # fmt: skip
