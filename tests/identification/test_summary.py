"""The summary of a campaign: honest bounds, outliers and trends, on values whose truth is known."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gsapp.identification.campaign import CampaignResult, CampaignSettings, ManeuverResult
from gsapp.identification.results import DerivativeEstimate, Estimate, ResponseFit
from gsapp.identification.summary import CampaignSummary, summarize_campaign
from gsapp.identification.summary.campaign_summary import assess_bound_consistency
from gsapp.quantities import Block

NAMES = ("Cm_alpha", "Cm_q", "Cm_de", "CN_alpha", "CN_de")
TRUTH = {"Cm_alpha": -0.3, "Cm_q": -20.0, "Cm_de": -1.1, "CN_alpha": 4.5, "CN_de": 0.4}
SHARE = {"Cm_alpha": 0.05, "Cm_q": 0.15, "Cm_de": 0.03, "CN_alpha": 0.02, "CN_de": 0.2}


def flown(
    seed: int,
    *,
    count: int = 16,
    wild: int | None = None,
    optimism: float = 1.0,
    slope: float = 0.0,
    r2: float = 0.99,
) -> CampaignResult:
    """Return a campaign of maneuvers from 25 to 34 m/s with values as their bounds say.

    Parameters
    ----------
    seed, count : int
    wild : int, optional
        A maneuver whose values of three derivatives are off by ten bounds.
    optimism : float
        By how much errors exceed the bounds.
    slope : float
        Change of Cm_de per m/s, share of its value.
    r2 : float
        Of all fits.
    """
    random = np.random.default_rng(seed)
    results = []
    for number in range(count):
        V = float(random.uniform(25.0, 34.0))
        derivatives = {}
        for name in NAMES:
            std = abs(TRUTH[name]) * SHARE[name] * float(random.uniform(0.7, 1.5))
            true = TRUTH[name] * (1.0 + (slope * (V - 29.5) if name == "Cm_de" else 0.0))
            off = 10.0 * std if number == wild and name in NAMES[:3] else 0.0
            value = true + optimism * std * float(random.standard_normal()) + off
            derivatives[name] = DerivativeEstimate(value=value, std=std, cramer_rao=0.5 * std)
        times = np.arange(200) / 50.0
        block = Block(channels=("V",), times=times, values=np.full((200, 1), V))
        maneuver = SimpleNamespace(
            id=f"M{number}", flight="E", block=block, t_start=0.0, clipped={},
            samples=lambda name, block=block: block[name]
            if name in block
            else np.full(len(block), np.nan),
        )  # fmt: skip
        estimate = Estimate(
            method="ml",
            axis="lon",
            maneuvers=(maneuver.id,),
            derivatives=derivatives,
            free=NAMES,
            covariance=np.eye(len(NAMES)),
            fit={"q": ResponseFit(rms=0.1, rms_over_range_pct=2.0, r2=r2, theil=0.1, samples=200)},
            warnings=("gusts of 0.4 m/s were seen",) if number == wild else (),
        )
        results.append(ManeuverResult(maneuver=cast("Any", maneuver), estimate=estimate))
    return CampaignResult(settings=CampaignSettings(), results=tuple(results), values={})


def outliers(summary: CampaignSummary) -> set[tuple[str, str]]:
    return {
        (name, outlier.point.maneuver)
        for name, one in summary.derivatives.items()
        for outlier in one.outliers
    }


def test_honest_bounds_give_no_outlier_no_trend_and_a_ratio_of_one() -> None:
    """Forty campaigns with nothing wrong: at most the few alarms that 1 % allows."""
    ratios, alarms, trends, covered = [], 0, 0, []
    for seed in range(40):
        summary = summarize_campaign(flown(seed))
        alarms += len(outliers(summary))
        for name, one in summary.derivatives.items():
            trends += sum(trend.is_significant for trend in one.trends)
            covered.append(abs(one.value.mean - TRUTH[name]) <= 2.0 * one.value.std)
            ratios.append(one.bound_consistency.ratio)
        assert not summary.outlying_maneuvers
    assert alarms <= 3
    assert trends <= 2
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.05)
    assert np.mean(covered) >= 0.92


def test_bounds_that_are_too_small_are_told() -> None:
    summary = summarize_campaign(flown(1, optimism=2.0, count=40))
    assert summary.bounds_ratio == pytest.approx(2.0, rel=0.2)
    told = [one.bound_consistency for one in summary.derivatives.values()]
    assert all(one is not None and one.p_value < 1e-4 for one in told)
    values, stds = np.array([1.0, 3.0, 5.0]), np.full(3, 0.1)
    spread = assess_bound_consistency(values, stds)
    assert np.hypot(spread.between_maneuver_std, 0.1) == pytest.approx(2.0, rel=1e-3)
    assert assess_bound_consistency(values[:2], stds[:2]) is None


def test_means_and_values_hold_the_truth_though_single_bounds_are_too_small() -> None:
    means, values, narrow = [], [], []
    for seed in range(40):
        for name, one in summarize_campaign(flown(seed, optimism=2.0)).derivatives.items():
            true = TRUTH[name]
            means.append(abs(one.value.mean - true) <= 2.0 * one.value.std)
            values += [abs(point.value - true) <= 2.0 * one.bound(point) for point in one.points]
            narrow += [abs(point.value - true) <= 2.0 * point.std for point in one.points]
    assert np.mean(means) >= 0.9
    assert np.mean(values) >= 0.93
    assert np.mean(narrow) < 0.75


def test_a_wild_maneuver_is_pointed_out_with_a_reason_and_left_out() -> None:
    found = 0
    for seed in range(20):
        result = flown(seed, wild=5)
        summary = summarize_campaign(result)
        named = {maneuver for _, maneuver in outliers(summary)}
        assert named <= {"M5"}
        found += bool(summary.outlying_maneuvers)
        for one in summary.outlying_maneuvers:
            assert (one.maneuver, one.derivative_count, one.fits_well) == ("M5", 5, True)
            assert any("0.4 m/s" in reason for reason in one.reasons)
        without = replace(
            result, results=tuple(one for one in result.results if one.maneuver.id != "M5")
        )
        if ("Cm_de", "M5") in outliers(summary):
            alone = summarize_campaign(without).derivatives["Cm_de"].value
            assert summary.derivatives["Cm_de"].value == alone
            assert len(summary.derivatives["Cm_de"].points) == 16
    assert found >= 18
    assert not summarize_campaign(flown(3, wild=5, r2=0.5)).outlying_maneuvers[0].fits_well


def test_a_dependence_on_speed_is_found_and_its_slope_covered() -> None:
    covered = []
    for seed in range(20):
        summary = summarize_campaign(flown(seed, slope=0.03))
        (trend,) = summary.derivatives["Cm_de"].trends
        assert trend.is_significant
        covered.append(abs(trend.slope - 0.03 * TRUTH["Cm_de"]) <= 2.0 * trend.std)
        others = [one for name, one in summary.derivatives.items() if name != "Cm_de"]
        assert sum(trend.is_significant for one in others for trend in one.trends) <= 1
    assert np.mean(covered) >= 0.85


def test_too_few_values_claim_nothing() -> None:
    summary = summarize_campaign(flown(0, count=2))
    assert all(
        one.bound_consistency is None and not one.trends for one in summary.derivatives.values()
    )
    assert summary.bounds_ratio is None
    assert summarize_campaign(flown(0, count=0)).derivatives == {}
