"""Derivatives in other forms: against linear models, and through a change of the state."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gsapp.dynamics.model import load_model
from gsapp.identification.campaign import (
    CampaignResult,
    CampaignSettings,
    CampaignValue,
    ManeuverResult,
    campaign_values,
)
from gsapp.identification.results import DerivativeEstimate, Estimate
from gsapp.identification.summary.derivative_forms import DerivativeForms, forms_of_means
from gsapp.identification.summary.mean_covariance import mean_covariance
from gsapp.quantities import FloatArray
from tests.identification.virtual_maneuvers import fly

VANE = (3.0, 0.0, -0.7)


@pytest.fixture(scope="module")
def forms() -> dict[str, DerivativeForms]:
    """Return the known derivatives of the virtual aircraft in other forms, vanes far off."""
    maneuver = fly(2, "both", duration=3.0, dt=0.02).maneuver
    sensors = maneuver.aircraft.sensors
    moved = sensors.model_copy(
        update={
            name: getattr(sensors, name).model_copy(update={"position": VANE})
            for name in ("alpha_vane", "beta_vane")
        }
    )
    aircraft = maneuver.aircraft.model_copy(update={"sensors": moved})
    truth = load_model("b777").derivatives
    estimate = Estimate(
        method="ml",
        axis="both",
        maneuvers=(maneuver.id,),
        derivatives={
            name: DerivativeEstimate(value=value, std=0.01) for name, value in truth.items()
        },
        free=tuple(truth),
        covariance=1e-4 * np.eye(len(truth)),
    )
    result = CampaignResult(
        settings=CampaignSettings(),
        results=(ManeuverResult(maneuver=replace(maneuver, aircraft=aircraft), estimate=estimate),),
        values=campaign_values([estimate]),
    )
    return dict(forms_of_means(result, result.values))


@pytest.mark.parametrize("at", ["CG", "vane"])
def test_dimensional_moments_are_the_rows_of_the_state_matrix(
    forms: dict[str, DerivativeForms], at: str
) -> None:
    """The vane's rows are derived term by term; the matrix is carried over by its states."""
    form = "dimensional" if at == "CG" else "dimensional-vane"
    for axis, rows in (("lon", {"M": "q"}), ("lat", {"L": "p", "N": "r"})):
        one = forms[axis]
        model = one.model if at == "CG" else one.vane_model
        assert model is not None
        for letter, state in rows.items():
            row = model.states.index(state)
            for columns, matrix in ((model.states, model.A), (model.inputs, model.B)):
                for column, name in enumerate(columns):
                    if f"{letter}_{name}" in one.values[form]:
                        found = one.values[form][f"{letter}_{name}"].value
                        assert found == pytest.approx(matrix[row, column], abs=1e-9)


def test_side_force_at_the_vane_is_what_its_angle_shows(forms: dict[str, DerivativeForms]) -> None:
    one = forms["lat"]
    model = one.vane_model
    assert model is not None
    beta = model.states.index("beta")
    found = one.values["dimensional-vane"]
    for name, by_rate in (
        ("beta", 0.0), ("p", np.sin(one.condition.alpha1)), ("r", -np.cos(one.condition.alpha1)),
    ):  # fmt: skip
        shown = one.condition.U1 * (model.A[beta, model.states.index(name)] - by_rate)
        assert found[f"Y_{name}"].value == pytest.approx(shown, abs=1e-9)
    x, _, z = VANE
    V = one.condition.U1
    at_cg = one.values["dimensional"]
    for letter in "LN":
        by_beta = at_cg[f"{letter}_beta"].value
        assert found[f"{letter}_r"].value == pytest.approx(
            at_cg[f"{letter}_r"].value - by_beta * x / V
        )
        assert found[f"{letter}_p"].value == pytest.approx(
            at_cg[f"{letter}_p"].value + by_beta * z / V
        )


def test_modes_are_the_same_at_the_vane(forms: dict[str, DerivativeForms]) -> None:
    for one in forms.values():
        assert one.model is not None
        assert one.vane_model is not None
        poles = [np.sort_complex(np.linalg.eigvals(each.A)) for each in (one.model, one.vane_model)]
        np.testing.assert_allclose(poles[0], poles[1], atol=1e-9)


def test_lift_and_drag_are_slopes_of_the_turned_forces(forms: dict[str, DerivativeForms]) -> None:
    one, truth = forms["lon"], load_model("b777").derivatives
    condition = one.condition

    def forces(alpha: float, de: float) -> FloatArray:
        normal, axial = (
            truth[f"{name}_0"] + truth[f"{name}_alpha"] * alpha + truth.get(f"{name}_de", 0.0) * de
            for name in ("CN", "CA")
        )
        s, c = np.sin(alpha), np.cos(alpha)
        return np.array([normal * c - axial * s, axial * c + normal * s])

    step = 1e-5
    sides = [forces(condition.alpha1 + x, condition.de1) for x in (step, -step)]
    found = one.values["CL-CD"]
    slopes = (sides[0] - sides[1]) / (2.0 * step)
    assert [found["CL_alpha"].value, found["CD_alpha"].value] == pytest.approx(slopes, abs=1e-6)
    level = forces(condition.alpha1, condition.de1)
    for head, value in zip(("CL", "CD"), level, strict=True):
        shown = found[f"{head}_0"].value + (
            found[f"{head}_alpha"].value * condition.alpha1
            + found[f"{head}_de"].value * condition.de1
        )
        assert shown == pytest.approx(value, abs=1e-9)
    assert one.values["CX-CZ"]["CZ_alpha"].value == -truth["CN_alpha"]


def test_means_keep_the_correlation_of_their_fits() -> None:
    """Two alike fits: the covariance of each over two; a bound given wider widens in proportion."""
    own = np.array([[4.0, -1.8], [-1.8, 1.0]])
    names = ("Cm_alpha", "Cm_q")
    estimate = Estimate(
        method="ml",
        axis="lon",
        maneuvers=("M",),
        derivatives={
            name: DerivativeEstimate(value=1.0, std=float(std))
            for name, std in zip(names, np.sqrt(own.diagonal()), strict=True)
        },
        free=names,
        covariance=own,
    )
    results = tuple(
        ManeuverResult(maneuver=cast("Any", SimpleNamespace()), estimate=estimate) for _ in "ab"
    )
    values = campaign_values([estimate, estimate])
    result = CampaignResult(settings=CampaignSettings(), results=results, values=values)
    np.testing.assert_allclose(mean_covariance(result, values, names), 0.5 * own)
    wider = {
        name: CampaignValue(mean=one.mean, std=3.0 * one.std, scatter=None, n=2)
        for name, one in values.items()
    }
    np.testing.assert_allclose(mean_covariance(result, wider, names), 4.5 * own)
