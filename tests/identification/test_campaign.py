"""A campaign: what each axis frees, methods beside each other, contradictions."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gsapp.foundation import FlightError
from gsapp.identification import campaign as campaign_fitting
from gsapp.identification.campaign import CampaignResult, CampaignSettings, run_campaign
from gsapp.identification.channel_faults import sign_warnings
from gsapp.identification.estimate_json import campaign_json
from gsapp.identification.results import Estimate
from gsapp.identification.summary import summarize_campaign
from gsapp.identification.summary.method_comparison import (
    compare_method_means,
    compare_methods,
    contradiction_warnings,
)
from tests.identification.virtual_instruments import with_channels
from tests.identification.virtual_maneuvers import Virtual, edited, fly


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


def test_moved_surfaces_may_be_named() -> None:
    """The rudder of a combined maneuver is taken for one that only trims."""
    one = replace(fly(2, "lat", dt=0.02).maneuver, id="lat")
    result = run_campaign([one], CampaignSettings(inputs=("da",), method="ee"))
    (found,) = result.results
    assert found.maneuver.inputs == ("da",)
    assert found.estimate is not None
    assert "Cn_da" in found.estimate.free
    assert "Cn_dr" not in found.estimate.free
    with pytest.raises(FlightError, match="'dx' is not a surface"):
        CampaignSettings(inputs=("dx",))


def test_signs_of_no_aircraft_are_said_of_means() -> None:
    """No maneuver alone is sure of a sign; their mean is."""
    signs = sign_warnings({"Cm_alpha": (0.4, 0.05), "Cm_de": (0.9, 0.1), "Cm_q": (-20.0, 1.0)})
    assert len(signs) == 1
    assert "Cm_alpha = 0.4 and Cm_de = 0.9" in signs[0]
    assert sign_warnings({"Cm_alpha": (0.4, 0.2), "Cm_de": (0.9, 0.4)}) == ()
    reversed_elevator = edited(fly(31, "lon", dt=0.02).maneuver, de=np.negative)
    result = run_campaign([reversed_elevator], CampaignSettings(method="ee"))
    assert result.results[0].estimate is not None
    assert any("elevator" in one for one in result.results[0].estimate.warnings)
    # Said of the maneuver, it is not said again of the mean.
    assert not any("elevator" in one for one in result.remarks)


def flown(gust: float, kind: str = "lat") -> Virtual:
    return fly(31, kind, gust=gust, dt=0.02)


def result_of(*maneuvers: Virtual) -> CampaignResult:
    return run_campaign([one.maneuver for one in maneuvers], CampaignSettings())


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_in_gusts_filter_error_takes_over_and_is_nearer_the_truth(kind: str) -> None:
    virtual = flown(1.0, kind)
    (result,) = result_of(virtual).results
    assert result.estimate.gusty_maneuvers == (virtual.maneuver.id,)
    assert any("turbulence" in text for text in result.estimate.warnings)
    assert result.estimate.method == "fem"
    assert set(result.comparisons) >= {"ml", "ee", "ftr"}
    both = [one for one in compare_methods(result) if {"ml", "fem"} <= one.values.keys()]
    assert len(both) >= (8 if kind == "lon" else 15)
    assert not any("ml" in one.contradictions for one in both)
    assert _miss(result.estimate, virtual, kind) < 0.5 * _miss(
        result.comparisons["ml"], virtual, kind
    )


def test_a_single_method_asked_for_stays_in_gusts() -> None:
    virtual = flown(1.0)
    (result,) = run_campaign([virtual.maneuver], CampaignSettings(single_method=True)).results
    assert (result.estimate.method, result.comparisons) == ("ml", {})


STRONG = {
    "lon": ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"),
    "lat": ("CY_beta", "Cl_p", "Cn_beta", "Cn_r"),
}


def _miss(estimate: Estimate, virtual: Virtual, kind: str) -> float:
    errors = [(estimate.value(name) or 0.0) / virtual.truth[name] - 1.0 for name in STRONG[kind]]
    return float(np.sqrt(np.mean(np.square(errors))))


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_in_calm_air_methods_do_not_contradict_each_other(kind: str) -> None:
    result = result_of(flown(0.0, kind))
    compared = compare_methods(result.results[0])
    assert len(compared) >= (8 if kind == "lon" else 15)
    assert not any(one.contradictions or one.disagreement for one in compared)
    assert contradiction_warnings(result) == ()
    assert result.results[0].estimate.influences == ()


def test_programs_get_the_values_of_every_method() -> None:
    result = result_of(flown(1.0))
    (content,) = json.loads(json.dumps(campaign_json(result)))["maneuvers"]
    assert content["comparisons"].keys() >= {"ee", "ftr"}
    other, own = content["comparisons"]["ee"]["derivatives"], content["derivatives"]
    assert other.keys() == own.keys()
    (mean,) = [one for one in compare_method_means(result.results) if one.name == "Cn_r"]
    assert mean.values["ee"] == pytest.approx((other["Cn_r"]["value"], other["Cn_r"]["std"]))
    assert mean.difference("ee") == pytest.approx(
        (other["Cn_r"]["value"] - own["Cn_r"]["value"])
        / np.hypot(other["Cn_r"]["std"], own["Cn_r"]["std"])
    )


def with_vane_ahead(virtual: Virtual, ahead: float) -> Virtual:
    """Return a maneuver whose alpha vane stands farther ahead than its aircraft file says."""
    maneuver = virtual.maneuver
    alpha = maneuver.block["alpha"] - ahead * maneuver.block["q"] / maneuver.block["V"]
    return replace(virtual, maneuver=with_channels(maneuver, alpha=alpha))


def test_a_vane_elsewhere_makes_methods_contradict_and_the_bound_covers_it() -> None:
    """No method knows of the vane: what one alone states as its bound, another contradicts."""
    wrong = with_vane_ahead(flown(0.0, "lon"), 1.5)
    result = result_of(wrong)
    compared = {one.name: one for one in compare_methods(result.results[0])}
    assert compared["Cm_q"].contradictions
    assert contradiction_warnings(result)
    value = summarize_campaign(result).derivatives["Cm_q"].value
    assert value.std**2 == pytest.approx(value.noise**2 + value.disagreement**2)
    assert value.noise == pytest.approx(result.values["Cm_q"].std)
    far = max(compared["Cm_q"].values.values(), key=lambda one: abs(one[0] - value.mean))
    assert abs(far[0] - value.mean) < 1.5 * value.std
    assert abs(wrong.truth["Cm_q"] - value.mean) < 3.0 * value.std


def test_a_response_that_contradicts_the_others_is_named() -> None:
    """An accelerometer that reads 60 % high: the change foretold is that of the fit without."""
    virtual = fly(3, "lon", dt=0.02)
    an = virtual.maneuver.block["an"]
    bent = with_channels(virtual.maneuver, an=an.mean() + 1.6 * (an - an.mean()))
    result = run_campaign([bent], CampaignSettings(single_method=True)).results[0]
    assert result.comparisons == {}
    named = result.estimate.influences
    assert {one.response for one in named} == {"an"}
    strongest = max(
        (one for one in named if one.name.startswith("Cm_")), key=lambda one: one.sigmas
    )
    assert any(strongest.response in text for text in result.estimate.warnings)
    responses = tuple(name for name in result.estimate.fit if name != strongest.response)
    left = CampaignSettings(single_method=True, responses=responses)
    without = run_campaign([bent], left).results[0].estimate.value(strongest.name)
    change = without - result.estimate.value(strongest.name)
    assert change == pytest.approx(strongest.change, rel=0.3)


def test_where_equation_error_fails_that_is_said_and_the_fit_stands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def failing(*_given: Any, **_options: Any) -> None:
        raise FlightError("the vane was gone")

    monkeypatch.setattr(campaign_fitting.equation_error, "estimate", failing)
    (one,) = result_of(flown(1.0)).results
    assert "ee" not in one.comparisons
    assert one.estimate.converged
    assert any("vane was gone" in text for text in one.estimate.warnings)
