"""Proves that a designed experiment is the smallest that is enough, and promises what it brings.

The shipped model, with Cm curved a little in alpha, flies four maneuvers of five seconds.
"""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gsapp.discrepancy.candidates import CandidateEffect, catalog_candidates
from gsapp.discrepancy.effect_catalog import find_effect
from gsapp.discrepancy.experiment_design import (
    design_separation,
    design_visibility,
    is_held_out,
    separations,
)
from gsapp.discrepancy.results import DecidingExperiment
from gsapp.discrepancy.search_stages import free_parameters
from gsapp.discrepancy.settings import SEARCH
from gsapp.excitation.cueing.card_selector import format_card
from gsapp.flight.cards import load_cards, save_cards
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.quantities.constants import DEGREE
from gsapp.report.discrepancy_text import experiment_text
from tests.bench.deciding_experiment import attempt
from tests.discrepancy.blind.cases import hidden, typical
from tests.discrepancy.core_kit import AIRCRAFT, TRUTH, maneuver, prepared

EFFECT, RIVAL = "aero.Cm.alpha2", "aero.Cm.alpha_q"
CURVED = TRUTH.with_effect(EFFECT, {"Cm_alpha2": -0.3})
FLOWN = [
    maneuver(seed, ("lon", "lat")[seed % 2], duration=5.0, model=CURVED) for seed in (1, 2, 3, 4)
]
OWN, OTHER = catalog_candidates([find_effect(EFFECT), find_effect(RIVAL)], AIRCRAFT)


def linearized(*effects: CandidateEffect) -> FilterErrorFit:
    free = (*free_parameters(TRUTH, True), *(f"{one.id}.{one.parameter}" for one in effects))
    fit = prepared(FLOWN, CURVED if effects else TRUTH, free)
    fit.linearize()
    return fit


@pytest.fixture(scope="module")
def experiment() -> DecidingExperiment:
    found = design_separation(linearized(OWN), OWN, [OTHER], [9.0, 8.0], FLOWN[:3])
    assert found is not None
    return found


def test_separation_is_what_the_rival_cannot_take() -> None:
    # Two effects of 10 and 8 sigma, alike by 0.6: 0.8 of each is left.
    P = np.array([[1.0, 0.6], [0.6, 1.0]])
    found = separations(P, np.array([10.0, -8.0]))
    assert found[0, 1] == pytest.approx(8.0)
    assert found[1, 0] == pytest.approx(6.4)
    # A rival that looks the same leaves nothing.
    assert separations(np.ones((2, 2)), np.array([10.0, 10.0]))[0, 1] == 0.0


def test_the_experiment_separates_enough_within_the_limits_of_the_aircraft(
    experiment: DecidingExperiment,
) -> None:
    assert experiment.effects == (EFFECT, RIVAL)
    assert experiment.decides
    assert experiment.separation >= SEARCH.experiment_separation > experiment.separation_now
    (card,) = experiment.cards
    assert card.surfaces == ("de",)
    limits = AIRCRAFT.limits
    assert limits.stall_speed < card.speed < limits.maximum_speed
    assert 0.0 < card.amplitudes["de"] < 0.5 * np.ptp(AIRCRAFT.controls.de.travel)
    # One maneuver is enough. But after one elevator maneuver the next is held out.
    assert Counter(one.inputs for one in FLOWN[:3])["de",] == 1
    assert [is_held_out(1), is_held_out(2)] == [True, False]
    assert card.repeats == 2


def test_what_no_maneuver_tells_apart_has_no_experiment() -> None:
    twin = replace(OTHER, build_column=OWN.build_column)
    assert design_separation(linearized(OWN), OWN, [twin], [9.0, 9.0], FLOWN) is None


def test_an_experiment_makes_effects_visible() -> None:
    fit = linearized()
    found = design_visibility(fit, [replace(OWN, plausible_size=0.1), OTHER], FLOWN)
    assert found is not None
    assert found.purpose == "show"
    assert found.separation > found.separation_now
    assert len(found.effects) == 1


def test_the_answer_holds_cards_words_and_numbers(
    experiment: DecidingExperiment, tmp_path: Path
) -> None:
    path = save_cards(tmp_path / "cards.toml", experiment.card_set("B777"))
    assert load_cards(path).cards == experiment.cards
    text = experiment_text(experiment, "US")
    assert "fly 2 elevator " in text
    assert "ft/s" in text
    assert "m/s" in experiment_text(experiment, "SI")
    assert f"{experiment.separation:.1f} standard deviations" in text
    (card,) = experiment.cards
    with_levers = card.model_copy(update={"throttle_step": 0.2, "flap": 10.0 * DEGREE})
    assert format_card(with_levers, "US").endswith(" ft/s, flap 10 deg, then throttle +20 %")
    weak = replace(experiment, separation=3.0)
    assert "5 are wanted" in experiment_text(weak, "US")
    assert not weak.decides


@pytest.mark.long
def test_what_was_designed_decides_in_flights_of_another_simulator() -> None:
    case = hidden("aero.Cm.speed", 0.7 * typical("aero.Cm.speed"), plan=63, seed=9063, noise=2.0)
    flown = attempt(case)
    assert flown is not None
    assert flown.experiment.decides
    assert flown.named == ("aero.Cm.speed",)
    # The root of a gain scatters by one.
    assert flown.reached == pytest.approx(flown.experiment.separation, abs=3.0)
