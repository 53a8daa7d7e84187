"""Proves what a search promises its user, on cheap maneuvers with an effect hidden in them.

The shipped model flies eight maneuvers of five seconds with Cm curved in alpha; the program is
given that model without the curve.
"""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.discrepancy import held_out_maneuvers
from gsapp.discrepancy.effect_fitting import EffectFitter, check_gain
from gsapp.discrepancy.investigation import Investigation, _Search
from gsapp.discrepancy.results import DiscrepancyResult, explain_verdict, find_alternatives
from gsapp.discrepancy.search_checks import check_instruments
from gsapp.discrepancy.search_stages import fit_baseline
from gsapp.discrepancy.settings import DiscrepancySettings, SearchProgress, SearchStoppedError
from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.filter_error.motion_linearization import create_maneuver_record
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities.constants import DEGREE
from tests.discrepancy.core_kit import AIRCRAFT, TRUTH, maneuver
from tests.identification.virtual_maneuvers import fly

EFFECT, SIZE = "aero.Cm.alpha2", -3.0
HELD_OUT = ("2", "5")
SETTINGS = DiscrepancySettings(held_out=HELD_OUT)


def flown(model: Model, *, quiet: tuple[str, ...] = ()) -> list[Maneuver]:
    return [
        maneuver(
            seed,
            ("lon", "lat")[seed % 2],
            duration=5.0,
            model=model,
            noise=0.8 if str(seed) in quiet else 1.0,
        )
        for seed in range(1, 9)
    ]


CURVED = TRUTH.with_effect(EFFECT, {"Cm_alpha2": SIZE})


@pytest.fixture(scope="module")
def search() -> Investigation:
    return Investigation(flown(CURVED), AIRCRAFT, TRUTH)


@pytest.fixture(scope="module")
def told() -> list[SearchProgress]:
    return []


@pytest.fixture(scope="module")
def answer(search: Investigation, told: list[SearchProgress]) -> DiscrepancyResult:
    return search.run(SETTINGS, progress=told.append)


def learned(found: DiscrepancyResult) -> dict[str, float]:
    numbers = dict(found.model.derivatives)
    for one in found.effects:
        for name, (value, std) in one.parameters.items():
            numbers[f"{one.effect}.{name}"] = value
            numbers[f"{one.effect}.{name}.std"] = std
        numbers[f"{one.effect}.confidence"] = one.confidence
        numbers[f"{one.effect}.margin"] = one.margin
    return numbers


def test_the_hidden_effect_is_found(answer: DiscrepancyResult) -> None:
    assert answer.verdict == "effects-found"
    (one,) = answer.effects
    assert one.effect == EFFECT
    assert not one.forced
    value, std = one.parameters["Cm_alpha2"]
    assert abs(value - SIZE) < 3.5 * std
    assert std < 0.1 * abs(SIZE)
    assert one.confidence > 0.9
    assert one.held_out > 5.0
    assert answer.gap.closed == pytest.approx(1.0, abs=0.1)
    assert answer.gap.on == HELD_OUT
    assert answer.steps[0].misfit > answer.steps[1].misfit
    assert EFFECT in answer.why or one.title in answer.why


def test_a_full_fit_that_gains_nothing_refuses_the_effect(search: Investigation) -> None:
    run = _Search(search, SETTINGS, None)
    stage = run._stage(search.baseline(HELD_OUT, lambda _: None), added="")
    best = stage.decision.best
    assert best is not None
    with pytest.raises(FlightError, match=f"{EFFECT}: 0 gained"):
        check_gain(stage, stage.fit, best, SETTINGS.false_alarm)
    fitter = EffectFitter(AIRCRAFT, SETTINGS.false_alarm, lambda _: None)
    borne_out = fitter.fitted(stage.fit, best, stage.screening, "")
    check_gain(stage, borne_out, best, SETTINGS.false_alarm)


def test_what_maneuvers_kept_out_refute_is_no_alternative_to_itself(
    search: Investigation, answer: DiscrepancyResult
) -> None:
    stage = _Search(search, SETTINGS, None)._stage(
        search.baseline(HELD_OUT, lambda _: None), added=""
    )
    assert stage.decision.best is not None
    refuted = replace(
        stage.decision,
        kind="unexplained",
        alternatives=(stage.decision.best,),
        contradicted=True,
    )
    assert find_alternatives("unexplained", (refuted,)) == ()
    told = explain_verdict(replace(answer, verdict="unexplained", effects=()), refuted)
    assert f"({EFFECT})" in told
    assert "contradict" in told
    assert "not in the catalog" not in told
    # What these flights cannot tell apart stays.
    open_ = replace(refuted, kind="ambiguous", contradicted=False)
    assert [one.effects for one in find_alternatives("ambiguous", (open_,))] == [(EFFECT,)]


def test_what_maneuvers_kept_out_refute_leaves_no_room_for_what_looks_like_it(
    search: Investigation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(held_out_maneuvers, "is_contradicted", lambda *_, **__: True)
    found = search.run(SETTINGS)
    assert found.ranking[0].effect != EFFECT
    assert found.effects == ()
    assert found.verdict == "unexplained"
    assert f"({EFFECT}) explains the fitted maneuvers best, but the held-out" in found.why


@pytest.mark.long
def test_a_vane_mounted_askew_is_named_though_maneuvers_kept_out_say_nothing_of_it() -> None:
    askew = []
    for one in flown(TRUTH):
        values = one.block.values.copy()
        values[:, one.block.channels.index("alpha")] += 4.0 * DEGREE
        askew.append(replace(one, block=replace(one.block, values=values)))
    found = Investigation(askew, AIRCRAFT, TRUTH).run(SETTINGS)
    assert [one.effect for one in found.effects] == ["sensor.alpha.bias"]
    value, std = found.effects[0].parameters["bias"]
    assert abs(value - 4.0 * DEGREE) < 3.0 * std


@pytest.mark.long
def test_instruments_are_judged_apart() -> None:
    sound = flown(TRUTH)[::2]
    (agree,) = check_instruments(sound, try_signs=False)
    assert agree.consistent
    turned = []
    for one in sound[:2]:
        block = one.block
        values = block.values.copy()
        values[:, block.channels.index("ay")] *= -1.0
        turned.append(replace(one, block=replace(block, values=values)))
    remarks = check_instruments(turned)
    assert any("a_y" in one.words and not one.consistent for one in remarks)
    assert "sensor.ay.reversed" in [one.effect for one in remarks]


def test_a_model_with_other_values_does_not_pass_for_the_one_that_was_given(
    answer: DiscrepancyResult,
) -> None:
    fitted_to = "fitted to 6 maneuvers of "
    for step in answer.steps:
        model = step.model
        assert model.derivatives != TRUTH.derivatives
        assert (model.name != TRUTH.name, model.parent) == (True, TRUTH.name)
        assert model.evidence
        assert model.source.startswith(fitted_to)
        assert len(model.source) > len(fitted_to)
    assert not answer.steps[0].model.effects


def test_the_story_has_a_step_for_each_model(
    answer: DiscrepancyResult, search: Investigation
) -> None:
    assert [step.added for step in answer.steps] == ["", EFFECT]
    assert answer.steps[0].ranking[0].effect == EFFECT
    assert answer.model.parent == TRUTH.name
    assert EFFECT in answer.model.evidence
    assert answer.model.effects[0].id == EFFECT
    ranked = [(one.evidence, one.score) for one in answer.steps[0].ranking]
    assert ranked == sorted(ranked, reverse=True)
    assert [one.held_out for one in answer.maneuvers] == [
        one.id in HELD_OUT for one in search.maneuvers
    ]
    for one in answer.maneuvers:
        assert len(one.computed) == len(one.missing) == 2
        assert one.computed[0].shape == one.measured.shape == (len(one.times), len(one.channels))
        assert one.missing[0].shape == (len(one.times), 6)
    assert answer.steps[0].coefficient_map.shape == (8, 6)
    # Pitch maneuvers lack most in Cm, and no longer.
    pitching = [k for k, one in enumerate(search.maneuvers) if one.inputs == ("de",)]
    column = answer.coefficients.index("Cm")
    before, after = (step.coefficient_map[pitching, column].mean() for step in answer.steps)
    assert before > 1.2 * after
    assert answer.disagreements[0].coefficient == "Cm"
    assert answer.disagreements[0].channel == "q"


def test_progress_goes_forward(answer: DiscrepancyResult, told: list[SearchProgress]) -> None:
    assert answer.verdict
    shares = [one.share for one in told]
    assert len(shares) > 8
    assert shares == sorted(shares)
    assert shares[0] > 0.0
    assert shares[-1] == 1.0
    assert all(one.activity for one in told)


@pytest.mark.parametrize("calls", [1, 4, pytest.param(9, marks=pytest.mark.long)])
def test_a_search_can_be_stopped(search: Investigation, calls: int) -> None:
    made: list[SearchProgress] = []

    def stop(progress: SearchProgress) -> bool | None:
        made.append(progress)
        return None if len(made) < calls else False

    fresh = Investigation(search.maneuvers, AIRCRAFT, TRUTH)
    with pytest.raises(SearchStoppedError, match="stopped"):
        fresh.run(SETTINGS, progress=stop)
    assert len(made) == calls


@pytest.mark.long
def test_the_same_again_to_the_last_bit(search: Investigation, answer: DiscrepancyResult) -> None:
    again = search.run(SETTINGS)
    assert learned(again) == learned(answer)
    assert again.why == answer.why
    assert again.gap == answer.gap
    assert again.observability == answer.observability
    for one, other in zip(again.steps, answer.steps, strict=True):
        assert one.ranking == other.ranking
        assert np.array_equal(one.coefficient_map, other.coefficient_map, equal_nan=True)
    for one, other in zip(again.maneuvers, answer.maneuvers, strict=True):
        for ours, theirs in zip(one.computed, other.computed, strict=True):
            assert np.array_equal(ours, theirs)


@pytest.mark.long
def test_maneuvers_kept_out_teach_nothing(answer: DiscrepancyResult) -> None:
    changed = Investigation(flown(CURVED, quiet=HELD_OUT), AIRCRAFT, TRUTH).run(SETTINGS)
    assert learned(changed) == learned(answer)
    assert [one.effect for one in changed.ranking] == [one.effect for one in answer.ranking]
    assert [one.score for one in changed.ranking] == [one.score for one in answer.ranking]
    assert changed.steps[1].misfit != answer.steps[1].misfit
    assert changed.gap.channels != answer.gap.channels


@pytest.mark.long
def test_the_order_of_maneuvers_does_not_matter(answer: DiscrepancyResult) -> None:
    backward = Investigation(flown(CURVED)[::-1], AIRCRAFT, TRUTH).run(SETTINGS)
    ours, theirs = learned(backward), learned(answer)
    assert ours.keys() == theirs.keys()
    for name, value in theirs.items():
        assert ours[name] == pytest.approx(value, rel=1e-5, abs=1e-7), name
    assert [one.effect for one in backward.ranking[:3]] == [
        one.effect for one in answer.ranking[:3]
    ]
    assert backward.gap.closed == pytest.approx(answer.gap.closed, rel=1e-5)
    assert [one.id for one in backward.maneuvers] == [one.id for one in answer.maneuvers][::-1]


def test_what_is_refused_is_neither_named_nor_ranked(search: Investigation) -> None:
    found = search.run(DiscrepancySettings(held_out=HELD_OUT, refused=(EFFECT,)))
    assert EFFECT not in [one.effect for one in found.effects]
    assert all(EFFECT not in [one.effect for one in step.ranking] for step in found.steps)
    assert found.verdict in ("unexplained", "ambiguous")
    # What it did is still there: as structure that is found and not understood.
    assert found.effects
    assert not any(one.named for one in found.effects)
    assert "not understood" in found.why


@pytest.mark.long
def test_what_is_forced_comes_first(search: Investigation) -> None:
    forced = "aero.Cn.beta3"
    found = search.run(DiscrepancySettings(held_out=HELD_OUT, forced=(forced,)))
    assert [one.effect for one in found.effects] == [forced, EFFECT]
    assert [one.forced for one in found.effects] == [True, False]
    ((value, std),) = found.effects[0].parameters.values()
    assert abs(value) < 4.0 * std
    assert found.effects[0].confidence == 0.0
    assert "forced" in found.why
    assert [step.added for step in found.steps] == ["", forced, EFFECT]


def test_as_many_effects_as_allowed(search: Investigation) -> None:
    found = search.run(DiscrepancySettings(held_out=HELD_OUT, most_effects=0))
    assert found.effects == ()
    assert len(found.steps) == 1
    assert found.ranking[0].effect == EFFECT
    assert found.model.effects == ()
    assert found.gap.closed is None


def test_one_of_four_is_kept_out_of_each_kind(search: Investigation) -> None:
    assert search.default_held_out == ("3", "4")
    few = Investigation(flown(CURVED)[:4], AIRCRAFT, TRUTH)
    assert few.default_held_out == ("3", "4")
    assert len(few.default_held_out) < 4


def test_wrong_values_are_told_from_missing_effects() -> None:
    """Flights of the plain model; a model is given whose Cm_alpha is 15 % off: that, and no effect.

    Fitted on the same flights instead, the model is adequate.
    """
    wrong = TRUTH.with_derivatives({"Cm_alpha": 1.15 * TRUTH.derivative("Cm_alpha")})
    settings = DiscrepancySettings(held_out=HELD_OUT)
    found = Investigation(flown(TRUTH), AIRCRAFT, wrong).run(settings)
    assert found.verdict == "values-wrong"
    assert found.effects == ()
    assert "Cm_alpha" in found.values
    assert len(found.values) <= 3
    changed = found.values["Cm_alpha"]
    assert changed.before == wrong.derivative("Cm_alpha")
    assert abs(changed.after - TRUTH.derivative("Cm_alpha")) < 4.0 * changed.std
    assert "Cm_alpha" in found.why
    assert any("mass.cg.x" in one.effects for one in found.alternatives)


def test_an_effect_that_is_not_missing_closes_nothing(search: Investigation) -> None:
    """What is missing could still be added; where nothing is, the gap is too small to tell."""
    forced = DiscrepancySettings(held_out=HELD_OUT, forced=("aero.Cn.beta3",), most_effects=0)
    gap = search.run(forced).gap
    assert gap.closed == pytest.approx(0.0, abs=0.05)
    assert gap.closed_std is not None
    assert gap.closed_std < 0.1
    whole = Investigation(flown(TRUTH), AIRCRAFT, TRUTH).run(forced)
    assert len(whole.effects) == 1
    assert whole.gap.closed is None


def test_nothing_hidden_is_adequate() -> None:
    settings = DiscrepancySettings(held_out=HELD_OUT)
    found = Investigation(flown(TRUTH), AIRCRAFT, TRUTH).run(settings)
    assert found.verdict == "model-adequate"
    assert found.effects == ()
    assert found.values == {}
    assert found.disturbance == {}
    assert found.disagreements == ()
    assert found.steps[0].misfit == pytest.approx(1.0, abs=0.1)


def test_flights_that_show_nothing_do_not_make_a_model_adequate() -> None:
    """Noise thirty times as large: nothing is named, and nothing could have been."""
    noisy = [
        maneuver(seed, ("lon", "lat")[seed % 2], duration=3.0, model=TRUTH, noise=30.0)
        for seed in range(1, 5)
    ]
    found = Investigation(noisy, AIRCRAFT, TRUTH).run(DiscrepancySettings())
    assert found.verdict == "not-observable"
    assert not found.effects
    assert "larger doublets" in found.why


def test_gusts_that_turn_the_air_are_told_from_those_that_do_not() -> None:
    """Rolled by gusts, flights look as if roll damping and aileron were others."""
    for rotating in (True, False):
        flown = [
            fly(
                seed, ("lon", "lat")[seed % 2], duration=5.0, dt=0.02, gust=0.5, rotating=rotating,
                model=TRUTH, aircraft=AIRCRAFT,
            ).maneuver
            for seed in range(1, 7)
        ]  # fmt: skip
        fit = fit_baseline([create_maneuver_record(one) for one in flown], TRUTH, lambda _: None)
        (noise,) = fit.noise.values()
        assert (noise.rotation_intensities is not None) == rotating
        assert (noise.gradient_gains == (1.0, 1.0)) == rotating
