"""Proves how the competition is decided, on scores of which the right answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, kstest, norm

from gsapp.discrepancy.candidates import CandidateEffect
from gsapp.discrepancy.effect_selection import (
    CandidateScreening,
    EffectDecision,
    detection_threshold,
    log_priors,
    posterior_probabilities,
    select_effect,
)
from gsapp.discrepancy.held_out_maneuvers import is_contradicted
from gsapp.discrepancy.search_stages import SearchStage, equivalent_effects_of
from gsapp.discrepancy.settings import SEARCH
from gsapp.identification.filter_error.filter_error_fit import InformationMatrix
from gsapp.identification.filter_error.kalman import create_filter
from gsapp.quantities import FloatArray
from tests.discrepancy.core_kit import TOY_NOISE, Toy


def competitor(name: str, *, named: bool = True) -> CandidateEffect:
    return CandidateEffect(
        id=name,
        title=name,
        named=named,
        parameter="size",
        plausible_size=1.0,
        neutral=0.0,
        build_column=lambda _: None,
    )


NAMED = tuple(competitor(name) for name in ("a", "b", "c"))
UNNAMED = competitor("unnamed.x", named=False)


def decided(
    gain: list[float],
    competitors: tuple[CandidateEffect, ...] = (*NAMED, UNNAMED),
    *,
    least: float = 20.0,
    temper: float = 1.0,
) -> EffectDecision:
    names = tuple(one.id for one in competitors)
    empty = InformationMatrix(names=names, matrix=np.eye(len(names) + 1), samples=100.0)
    gains = np.array(gain)
    screening = CandidateScreening(
        candidates=competitors,
        full_information=empty,
        projected_information=empty,
        maneuver_information={},
        gain=gains,
        size=np.zeros(len(names)),
        std=np.ones(len(names)),
    )
    return select_effect(screening, gains, least=least, temper=temper)


def test_probabilities_are_likelihood_times_prior() -> None:
    found = posterior_probabilities((*NAMED, UNNAMED), np.array([30.0, 26.0, 0.0, 30.0]))
    raw = np.array([np.exp(15.0), np.exp(13.0), 1.0, SEARCH.unnamed_effect_prior * np.exp(15.0)])
    assert found == pytest.approx(raw / raw.sum())
    # Gains of thousands do not overflow.
    assert posterior_probabilities(NAMED, np.array([9e4, 8e4, 0.0])) == pytest.approx(
        [1.0, 0.0, 0.0]
    )


def test_the_threshold_is_chance_over_all_candidates() -> None:
    random = np.random.default_rng(1)
    best = (random.standard_normal((20_000, 60)) ** 2).max(axis=1)
    many, one = NAMED[:1] * 60, NAMED[:1]
    assert np.mean(best > detection_threshold(0.05, many)) == pytest.approx(0.05, abs=0.006)
    assert (
        detection_threshold(0.003, one * 300)
        > detection_threshold(0.003, one * 30)
        > detection_threshold(0.03, one * 30)
    )
    assert chi2.sf(detection_threshold(0.003, one), 1) == pytest.approx(0.003)


def test_what_has_no_name_has_less_of_a_chance_to_pass() -> None:
    mixed = (*NAMED[:1] * 20, *(UNNAMED,) * 200)
    least = detection_threshold(0.05, mixed)
    random = np.random.default_rng(2)
    gains = random.standard_normal((20_000, 220)) ** 2 + 2.0 * log_priors(mixed)
    assert np.mean(gains.max(axis=1) > least) == pytest.approx(0.05, abs=0.006)
    assert (
        detection_threshold(0.05, NAMED[:1] * 20)
        < least
        < detection_threshold(0.05, NAMED[:1] * 220)
    )
    assert detection_threshold(0.05, (UNNAMED,)) == pytest.approx(
        chi2.isf(0.05, 1) + 2.0 * np.log(SEARCH.unnamed_effect_prior)
    )


def test_nothing_is_named_below_the_threshold() -> None:
    found = decided([19.9, 0.0, 0.0, 0.0])
    assert found.kind == "nothing"
    assert found.best is None
    assert found.alternatives == ()
    assert decided([20.1, 0.0, 0.0, 0.0]).kind == "name"


def test_gains_that_are_exaggerated_count_for_less() -> None:
    assert decided([38.0, 0.0, 0.0, 0.0], temper=0.5).kind == "nothing"
    assert decided([60.0, 53.0, 0.0, 0.0]).kind == "name"
    found = decided([60.0, 53.0, 0.0, 0.0], temper=0.25, least=10.0)
    assert found.kind == "ambiguous"
    assert found.gain[0] == 60.0


def test_an_effect_whose_input_stood_still_is_never_a_name() -> None:
    """Nor is what looks like it; alone, or beside others, it is an alternative."""
    still = replace(NAMED[0], excited=False)
    alone = decided([90.0, 20.0, 0.0, 0.0], (still, *NAMED[1:], UNNAMED))
    assert alone.kind == "ambiguous"
    assert [one.id for one in alone.alternatives] == ["a"]
    beside = decided([60.0, 60.0, 0.0, 0.0], (still, *NAMED[1:], UNNAMED))
    assert beside.kind == "ambiguous"
    assert [one.id for one in beside.alternatives] == ["b", "a"]
    clear = decided([20.0, 60.0, 0.0, 0.0], (still, *NAMED[1:], UNNAMED))
    assert clear.kind == "name"


def test_a_name_needs_nineteen_in_twenty() -> None:
    margin = 2.0 * np.log(SEARCH.min_effect_probability / (1.0 - SEARCH.min_effect_probability))
    for extra, kind in ((0.1, "name"), (-0.1, "ambiguous")):
        found = decided([100.0, 100.0 + margin + extra, 0.0, 0.0])
        assert found.kind == kind
        assert found.best.id == "b"
        assert found.evidence[1] == pytest.approx(SEARCH.min_effect_probability, abs=0.02)


def test_alternatives_hold_the_probability_together() -> None:
    found = decided([100.0, 101.0, 60.0, 0.0])
    assert found.kind == "ambiguous"
    assert [one.id for one in found.alternatives] == ["b", "a"]


@pytest.mark.parametrize(("margin", "kind"), [(8.0, "ambiguous"), (20.0, "name")])
def test_a_lag_and_a_delay_of_one_signal_need_four_deviations(margin: float, kind: str) -> None:
    names = ("sensor.beta.lag", "sensor.beta.delay", "sensor.alpha.delay", "a")
    late = tuple(competitor(one) for one in names)
    found = decided([100.0 + margin, 100.0, 0.0, 0.0], late)
    assert found.kind == kind
    assert found.best.id == "sensor.beta.lag"
    assert found.gain[0] == 100.0 + margin
    assert decided([100.0 + margin, 0.0, 100.0, 0.0], late).kind == "name"


def test_one_stands_for_a_set_that_looks_the_same() -> None:
    gains = [100.0, 101.0, 60.0, 0.0]
    decision = decided(gains)
    for cosine, expected in ((0.99, ("b", "a")), (-0.99, ("b", "a")), (0.7, ())):
        matrix = np.eye(5)
        matrix[0, 1] = matrix[1, 0] = cosine
        names = ("a", "b", "c", "unnamed.x")
        left = InformationMatrix(names=names, matrix=matrix, samples=100.0)
        screening = CandidateScreening(
            candidates=(*NAMED, UNNAMED), full_information=left, projected_information=left,
            maneuver_information={},
            gain=np.array(gains), size=np.zeros(4), std=np.ones(4),
        )  # fmt: skip
        stage = SearchStage(  # type: ignore[arg-type]
            fit=None, added="", screening=screening, decision=decision
        )
        assert equivalent_effects_of(stage) == expected
    named = decided([100.0, 0.0, 0.0, 0.0])
    assert equivalent_effects_of(replace(stage, decision=named)) == ()


def test_structure_without_a_name_is_unexplained() -> None:
    found = decided([100.0, 0.0, 0.0, 120.0])
    assert found.kind == "unexplained"
    assert found.best.id == "unnamed.x"
    # Where both fit alike, the catalog's name is said: what has no name is rarer.
    assert decided([100.0, 0.0, 0.0, 100.0]).kind == "name"
    # Between: neither a name nor a choice among names.
    found = decided([100.0, 0.0, 0.0, 106.0])
    assert found.kind == "unexplained"


def test_no_candidates_decide_nothing() -> None:
    assert decided([], ()).kind == "nothing"


# --- with nothing hidden -------------------------------------------------------------------------


@pytest.mark.long
def test_scores_of_nothing_hidden_are_chi_square() -> None:
    """Toys in gusts, the filter knows the noise: gains of candidates are chi-square of 1.

    Each toy has three candidates that change rates and channels, and two parameters of its model
    that take what they can. Signed roots are normal: mean, spread and shape.
    """
    toy = Toy(TOY_NOISE, n=480)
    own = create_filter(toy.linearization(), TOY_NOISE, toy.motion())
    random = np.random.default_rng(2)
    n_blocks, n_channels, n_x = own.by_state.shape
    z = np.zeros((n_blocks, n_channels, 5 + n_x))
    z[:, :, :5] = random.standard_normal((n_blocks, n_channels, 5)).cumsum(axis=0)
    z *= np.sqrt(toy.measurement)[:, None]
    b = np.zeros((n_blocks - 1, n_x, 5 + n_x))
    b[:, 3:6, :5] = 0.01 * random.standard_normal((n_blocks - 1, 3, 5))
    start = np.zeros((n_x, 5 + n_x))
    start[:, 5:] = np.eye(n_x)
    seen, _ = own.innovations(z, b, start)
    columns = (own.whitener @ seen).reshape(-1, 5 + n_x)
    names = (*(f"c{k}" for k in range(5)), *(f"x{k}" for k in range(n_x)))

    def gains(toy: Toy) -> tuple[FloatArray, FloatArray, float, FloatArray]:
        given = create_filter(toy.linearization(), TOY_NOISE, toy.motion())
        own_z, own_b, _ = given.residual(np.zeros(n_channels))
        found, _ = given.innovations(own_z[:, :, None], own_b[:, :, None])
        rows = np.hstack((columns, (own.whitener @ found).reshape(-1, 1)))
        whole = InformationMatrix(names=names, matrix=rows.T @ rows, samples=float(len(rows)))
        left = whole.projected(("c3", "c4", *names[5:]))
        gain, size, _ = left.gains(whole)
        return gain, size, float(left.matrix[-1, -1]) / left.samples, left.matrix[:3, :3]

    scores, misfits = [], []
    for seed in range(250):
        gain, size, misfit, alike = gains(Toy(TOY_NOISE, seed=100 + seed, n=480))
        scores.append(np.sign(size) * np.sqrt(gain))
        misfits.append(misfit)
    assert scores[0].shape == (3,)
    every = np.array(scores)
    for column in every.T:
        assert kstest(column, norm.cdf).pvalue > 0.002
    assert np.mean(every**2) == pytest.approx(1.0, abs=0.15)
    # Together they are as alike as the candidates' columns.
    sizes = np.sqrt(alike.diagonal())
    drawn = random.multivariate_normal(np.zeros(3), alike / np.outer(sizes, sizes), 20000)
    assert kstest(every.max(axis=1), drawn.max(axis=1)).pvalue > 0.002
    assert np.mean(misfits) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("gain", "found", "against"),
    [
        (0.1, 20.0, False),
        (-0.5, 20.0, True),
        (-0.5, 60.0, False),
        (-9.0, 60.0, True),
        (-1.0, 300.0, True),
    ],
)
def test_maneuvers_kept_out_contradict_what_is_weak_or_should_have_shown(
    gain: float, found: float, against: bool
) -> None:
    assert is_contradicted(gain, found, share=1.0 / 3.0, least=18.0, apart=found / 3.0) is against
