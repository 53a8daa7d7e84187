"""Models on the way to an answer, and names that are taken back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gsapp.discrepancy.candidates import CandidateEffect
from gsapp.discrepancy.effect_selection import (
    CandidateScreening,
    DecisionKind,
    EffectDecision,
    detection_threshold,
    log_priors,
)
from gsapp.discrepancy.held_out_maneuvers import HeldOutManeuvers
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.effects.unnamed_terms import is_unnamed
from gsapp.dynamics.model import Model, load_model
from gsapp.foundation import FlightError
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit, InformationMatrix
from gsapp.identification.filter_error.motion_linearization import ManeuverRecord
from gsapp.identification.filter_error.noise_model import ROTATIONS
from gsapp.identification.filter_error.noise_tuning import (
    ActivityCallback,
    fit_to_convergence,
    select_noise_correlation,
)
from gsapp.identification.filter_error.settings import FILTER_ERROR


def free_parameters(model: Model, fitted: bool) -> tuple[str, ...]:
    """Return what is free: the whole linear build-up, or what a given model has of it, and levels.

    A derivative that a given model does not have at all is a missing effect, not a wrong value.
    """
    names = axis_derivatives("both")
    if fitted:
        return names
    return tuple(name for name in names if name.endswith("_0") or name in model.derivatives)


def initial_model() -> Model:
    """Return the linear build-up with values from which the fit finds its way."""
    shipped = load_model("b777")
    return Model(name="linear build-up", derivatives=shipped.derivatives)


def fit_baseline(
    records: Sequence[ManeuverRecord], model: Model | None, tick: ActivityCallback
) -> FilterErrorFit:
    """Return the baseline fitted to maneuvers."""
    start = initial_model() if model is None else model
    free = free_parameters(start, model is None)
    return fit_from_record(records, start, free, tick, "fitting the current model")


def fit_from_record(
    records: Sequence[ManeuverRecord],
    model: Model,
    free: Sequence[str],
    tick: ActivityCallback,
    doing: str,
    later: Sequence[str] = (),
) -> FilterErrorFit:
    """Return a model fitted to maneuvers of whose noise nothing is known.

    `later`: parameters that are free once the others have found their way.
    """
    fit = FilterErrorFit.create(records, model, free)
    fit_to_convergence(fit, 2, tick, doing, fresh=True)
    select_noise_correlation(fit, FILTER_ERROR.noise_rounds)
    fit_to_convergence(fit, SEARCH.max_passes - 2, tick, doing)
    if later:
        fit = fit.with_model(fit.revised_model(), (*free, *later))
        fit_to_convergence(fit, SEARCH.max_passes_far_start, tick, doing)
    return _with_rotating_air(fit, tick)


def _with_rotating_air(fit: FilterErrorFit, tick: ActivityCallback) -> FilterErrorFit:
    """Return the fit with gusts that turn the air, where these are likelier.

    Gusts that differ across the span roll it, those that differ along the flight path pitch and
    yaw it (MIL-F-8785C): in nature (gain 1), not in every simulation (0), in some with the other
    sign (-1). Left out, they move the derivatives of rates and controls by many bounds.
    """
    if max(_gust_rms(fit)) < SEARCH.min_gust_rms:
        return fit
    best, information = fit, fit.information()
    # G. Schwarz, Estimating the Dimension of a Model, Annals of Statistics 6, 1978.
    parameters = len(ROTATIONS) * len(fit.noise)
    least = fit.deviance() - parameters * float(np.log(information.samples))
    for gain in (1.0, 0.0, -1.0):
        trial = fit.with_model(fit.model, fit.free)
        trial.noise = {
            flight: replace(
                one,
                rotation_intensities=(FILTER_ERROR.initial_rotation_intensity,) * 3,
                gradient_gains=(gain, gain),
            )
            for flight, one in fit.noise.items()
        }
        try:
            fit_to_convergence(trial, 1, tick, "looking for turning gusts")
        except FlightError:
            continue
        deviance = trial.deviance()
        if deviance < least:
            best, least = trial, deviance
        if best is fit:
            # Gusts roll the air whatever the gain: without a trace of it, no gain will help.
            return fit
    fit_to_convergence(best, SEARCH.effect_passes - 1, tick, "looking for turning gusts")
    return best


def _gust_rms(fit: FilterErrorFit) -> list[float]:
    """Return the rms (m/s) of the gusts over all directions, of each maneuver."""
    found = []
    for one in fit.maneuvers:
        rms = fit.noise[one.record.flight].gust_rms(float(np.mean(one.motion.states[0])))
        found.append(float(np.sqrt(np.mean(np.square([*rms.values()])))))
    return found


def gust_of(fit: FilterErrorFit) -> dict[str, float]:
    """Return the rms of turbulence, ``gust`` with ``gust_std``, unless the air is still."""
    found = np.array(_gust_rms(fit))
    mean = float(np.sqrt(np.mean(found**2)))
    if mean < SEARCH.min_gust_rms:
        return {}
    return {"gust": mean, "gust_std": float(np.std(found) / np.sqrt(len(found)))}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SearchStage:
    """One model on the way, with the competition that it faced."""

    fit: FilterErrorFit
    added: str  # The effect that it has and the stage before has not; empty for the baseline.
    screening: CandidateScreening
    decision: EffectDecision
    forced: bool = False  # Whether the effect was put in by hand.
    proven: bool = False  # Whether kinematics alone prove it.
    equivalent_effects: tuple[str, ...] = ()
    """The set that the effect stands for, itself with it, where these flights cannot tell which."""

    @property
    def information(self) -> InformationMatrix:
        """Return that of the fit, priors included; the candidates are in it, too."""
        return self.screening.full_information

    def deviance(self) -> float:
        """Return that of the fit, which must still have its filters."""
        return self.fit.deviance(self.information, has_priors=True)

    def gain_of(self, effect: str) -> float:
        """Return what an effect gains in the competition; infinite where it does not compete."""
        ids = [one.id for one in self.screening.candidates]
        named = effect.replace(".reversed", ".scale")
        return float(self.decision.gain[ids.index(named)]) if named in ids else float("inf")


def equivalent_effects_of(stage: SearchStage) -> tuple[str, ...]:
    """Return the set that the best of a stage's decision can stand for; empty where it cannot.

    What cannot be told apart because it looks the same leaves the same behind, and the search can
    go on; a set of different things, or one whose input did not move, leaves its rests to be
    misnamed. Structure without a name may be in the set, beside an effect that is likelier.
    """
    decision = stage.decision
    is_open = decision.kind in ("ambiguous", "unexplained")
    if not is_open or decision.best is None or not decision.best.named:
        return ()
    if not all(one.excited for one in decision.alternatives):
        return ()
    cosines = np.abs(stage.screening.cosines(decision.best.id))
    ids = tuple(one.id for one in decision.alternatives)
    alike = all(cosines[stage.screening.index(one)] >= SEARCH.min_equivalence_cosine for one in ids)
    return ids if alike else ()


def is_refuted(
    before: SearchStage, held: HeldOutManeuvers, number: int, false_alarm: float
) -> bool:
    """Return whether maneuvers kept out contradict what was added after a stage.

    `held`: them under the models of all stages, of which this is the one with this number.
    """
    return held.contradict(
        number,
        found=float(before.decision.gain.max()),
        samples=before.screening.projected_information.samples,
        least=detection_threshold(false_alarm, before.screening.candidates),
    )


def refuted(before: SearchStage, false_alarm: float) -> SearchStage:
    """Return a stage of which maneuvers kept out contradict the best explanation."""
    least = detection_threshold(false_alarm, before.screening.candidates)
    is_strong = float(before.decision.gain.max()) > SEARCH.strong_gain_ratio * least
    kind: DecisionKind = "unexplained" if is_strong else "nothing"
    return replace(before, decision=replace(before.decision, kind=kind, contradicted=True))


def next_effect(
    found: Sequence[SearchStage], last: SearchStage, most_names: int, false_alarm: float
) -> CandidateEffect | None:
    """Return what to add next: what was named, or the structure for which there is no name.

    None if nothing is proven, or the stages `found` hold as many names as they may.
    """
    names = sum(not is_unnamed(one.added) for one in found)
    is_clear = last.decision.kind == "name" or equivalent_effects_of(last)
    if last.decision.kind == "unexplained" and not is_clear:
        return best_unnamed(last, detection_threshold(false_alarm, last.screening.candidates))
    return last.decision.best if is_clear and names < most_names else None


def best_unnamed(stage: SearchStage, least: float) -> CandidateEffect | None:
    """Return the structure without a name that a stage lacks most; None if it lacks none."""
    competitors, decision = stage.screening.candidates, stage.decision
    if decision.best is None:
        return None
    # Where a name is likelier, but not by enough, all else comes first: then it will be clearer.
    undecided = _alike(stage.screening, decision.best.id) if decision.best.named else []
    worth = decision.gain * stage.screening.gain_factor + 2.0 * log_priors(competitors)
    places = [
        k
        for k, one in enumerate(competitors)
        if not one.named and one.id not in undecided and worth[k] > least
    ]
    return competitors[max(places, key=lambda k: decision.gain[k])] if places else None


def find_wrong_effects(stages: Sequence[SearchStage], first: int) -> tuple[int, frozenset[str]]:
    """Return the first stage whose effect is wrong, and what must not stand for it.

    Stages before `first` stay; zero and an empty set where nothing is wrong. Wrong is a name of
    whose own structure much turned out to have no name, one of many names for one coefficient,
    and structure without a name that a name found later makes unnecessary.
    """
    for number in range(first, len(stages)):
        before, after = stages[number - 1], stages[number]
        if after.proven:
            continue
        if is_unnamed(after.added):
            if _is_unnecessary(after.added, stages[-1]):
                return number, frozenset((after.added,))
        elif _is_misnamed(before, after, stages[number + 1 :]) or _is_rest(stages[: number + 1]):
            return number, frozenset(_alike(before.screening, after.added))
    crowded, names = _first_crowded_stage(stages, first)
    return crowded, names


def _is_misnamed(before: SearchStage, after: SearchStage, later: Sequence[SearchStage]) -> bool:
    """Return whether much of what a name explained is like structure that has none."""
    explained = before.gain_of(after.added)
    alike = _alike(before.screening, after.added)
    left = sum(
        earlier.gain_of(one.added)
        for earlier, one in pairwise((after, *later))
        if is_unnamed(one.added) and one.added in alike
    )
    last = (after, *later)[-1].decision
    if last.kind == "unexplained" and last.best and last.best.id in alike:
        left += float(last.gain.max())
    return left >= SEARCH.max_unexplained_share * explained


def _is_rest(stages: Sequence[SearchStage]) -> bool:
    """Return whether the last name is like structure without a name that was found before it.

    Then it is a rest of that, which has another shape.
    """
    return any(
        is_unnamed(after.added) and stages[-1].added in _alike(before.screening, after.added)
        for before, after in pairwise(stages[:-1])
    )


def _alike(screening: CandidateScreening, effect: str) -> list[str]:
    """Return the candidates, the effect among them, that look much like it."""
    if effect not in screening.projected_information.names:
        return [effect]
    cosines = np.abs(screening.cosines(effect))
    table = dict(zip(screening.projected_information.names, cosines, strict=True))
    return [one.id for one in screening.candidates if table[one.id] >= SEARCH.min_alias_cosine]


def _is_unnecessary(effect: str, last: SearchStage) -> bool:
    """Return whether an effect of a stage's model is lost in its noise."""
    names = (*last.fit.free, *last.fit.bias_names())
    _, covariance = last.information.solution(names)
    places = [k for k, name in enumerate(names) if name.startswith(f"{effect}.")]
    sigmas = [abs(last.fit.values[names[k]]) / float(np.sqrt(covariance[k, k])) for k in places]
    return max(sigmas, default=np.inf) < SEARCH.min_unnamed_sigmas


def _first_crowded_stage(stages: Sequence[SearchStage], first: int) -> tuple[int, frozenset[str]]:
    """Return the first of many names for one coefficient, and all names there are for it.

    What takes so many terms of the catalog is something that is not in it. What is left of that
    gains less than what took the most of it; a name that gains as much is another effect, as is one
    that only steps of the flap or the throttle show. Zero and an empty set if no coefficient has
    many.
    """
    places: dict[str, list[int]] = {}
    largest: dict[str, float] = {}
    for number, one in enumerate(stages):
        group, target, *cause = one.added.split(".") if one.added else ("", "")
        is_of_motion = group not in ("sensor", "unnamed") and cause not in (["flap"], ["throttle"])
        if number < first or not is_of_motion:
            continue
        gain = stages[number - 1].gain_of(one.added)
        if gain < SEARCH.max_rest_gain * largest.get(target, np.inf):
            places.setdefault(target, []).append(number)
            largest.setdefault(target, gain)
    crowded = [
        (found[0], target)
        for target, found in places.items()
        if len(found) >= SEARCH.max_effects_per_target
    ]
    if not crowded:
        return 0, frozenset()
    number, target = min(crowded)
    names = (one.id for one in stages[number - 1].screening.candidates if one.named)
    return number, frozenset(name for name in names if name.split(".")[1] == target)
