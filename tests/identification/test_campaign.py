"""A campaign: what each axis frees, and equation error beside maximum likelihood in gusts."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gsapp.foundation import FlightError
from gsapp.identification import campaign as campaign_fitting
from gsapp.identification.campaign import CampaignResult, CampaignSettings, run_campaign
from gsapp.identification.estimate_json import campaign_json
from gsapp.identification.results import Estimate
from gsapp.identification.summary.method_comparison import compare_method_means, compare_methods
from tests.identification.virtual_maneuvers import Virtual, fly


def test_each_axis_frees_its_own_of_the_derivatives_named() -> None:
    """Names of both axes at once: a maneuver is never asked for the other axis."""
    flown = [replace(fly(1, kind).maneuver, id=kind) for kind in ("lon", "lat")]
    result = run_campaign(flown, CampaignSettings(free=("Cm_alpha", "Cm_de", "Cl_p", "Cl_da")))
    asked = {
        one.maneuver.id: {
            name for name, found in one.estimate.derivatives.items() if found.status != "held"
        }
        for one in result.results
        if one.estimate is not None
    }
    assert asked == {"lon": {"Cm_alpha", "Cm_de"}, "lat": {"Cl_p", "Cl_da"}}


def flown(gust: float, kind: str = "lat") -> Virtual:
    return fly(31, kind, gust=gust, dt=0.02)


def result_of(*maneuvers: Virtual) -> CampaignResult:
    return run_campaign([one.maneuver for one in maneuvers], CampaignSettings())


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_in_gusts_equation_error_stands_beside_and_is_nearer_the_truth(kind: str) -> None:
    virtual = flown(1.0, kind)
    (result,) = result_of(virtual).results
    assert result.estimate.gusty_maneuvers == (virtual.maneuver.id,)
    assert any("turbulence" in text for text in result.estimate.warnings)
    assert result.equation_error_estimate.method == "ee"
    both = [one for one in compare_methods(result) if one.maximum_likelihood and one.equation_error]
    assert len(both) >= (8 if kind == "lon" else 15)
    # Constants hold zero offsets of accelerometers, which equation error does not know.
    assert not any(one.name.endswith("_0") for one in both)
    assert _miss(result.equation_error_estimate, virtual, kind) < 0.5 * _miss(
        result.estimate, virtual, kind
    )


STRONG = {
    "lon": ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"),
    "lat": ("CY_beta", "Cl_p", "Cn_beta", "Cn_r"),
}


def _miss(estimate: Estimate, virtual: Virtual, kind: str) -> float:
    errors = [(estimate.value(name) or 0.0) / virtual.truth[name] - 1.0 for name in STRONG[kind]]
    return float(np.sqrt(np.mean(np.square(errors))))


def test_in_calm_air_nothing_is_computed_beside(monkeypatch: pytest.MonkeyPatch) -> None:
    def called(*_given: Any, **_options: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(campaign_fitting.equation_error, "estimate", called)
    result = result_of(flown(0.0))
    (one,) = result.results
    assert (one.estimate.gusty_maneuvers, one.equation_error_estimate) == ((), None)
    assert compare_methods(one) == compare_method_means(result.results) == ()
    (content,) = campaign_json(result)["maneuvers"]
    assert content["equation_error"] is None


def test_programs_get_both_values_of_a_maneuver_in_gusts() -> None:
    calm, rough = flown(0.0), flown(1.0)
    rough = replace(rough, maneuver=replace(rough.maneuver, id="rough"))
    result = result_of(calm, rough)
    first, second = json.loads(json.dumps(campaign_json(result)))["maneuvers"]
    assert first["equation_error"] is None
    beside = second["equation_error"]["derivatives"]
    assert beside["Cn_r"] != second["derivatives"]["Cn_r"]
    assert beside.keys() == second["derivatives"].keys()
    (mean,) = [one for one in compare_method_means(result.results) if one.name == "Cn_r"]
    assert mean.equation_error == pytest.approx((beside["Cn_r"]["value"], beside["Cn_r"]["std"]))
    own = second["derivatives"]["Cn_r"]
    assert mean.normalized_difference == pytest.approx(
        (beside["Cn_r"]["value"] - own["value"]) / np.hypot(beside["Cn_r"]["std"], own["std"])
    )


def test_where_equation_error_fails_that_is_said_and_the_fit_stands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def failing(*_given: Any, **_options: Any) -> None:
        raise FlightError("the vane was gone")

    monkeypatch.setattr(campaign_fitting.equation_error, "estimate", failing)
    (one,) = result_of(flown(1.0)).results
    assert one.equation_error_estimate is None
    assert one.estimate.converged
    assert any("vane was gone" in text for text in one.estimate.warnings)
