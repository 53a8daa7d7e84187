"""Stages made an answer: what was found, how sure, what else, and the gap before and after."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.stats import norm

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.candidates import coefficient_of
from gsapp.discrepancy.disagreements import (
    apply_residual_floor,
    coefficient_map,
    find_disagreements,
    localize_model_errors,
)
from gsapp.discrepancy.effect_catalog import all_effects, find_effect
from gsapp.discrepancy.effect_selection import (
    CandidateScreening,
    DecisionKind,
    posterior_probabilities,
)
from gsapp.discrepancy.held_out_maneuvers import HeldOutManeuvers, compute_gap, maneuver_histories
from gsapp.discrepancy.mass_patterns import MovedValues, mass_errors
from gsapp.discrepancy.results import (
    ChangedValue,
    DiscrepancyResult,
    DiscrepancyVerdict,
    FoundEffect,
    InstrumentRemark,
    ModelStep,
    Observability,
    RankedCandidate,
    explain_verdict,
    find_alternatives,
)
from gsapp.discrepancy.search_checks import record_remarks
from gsapp.discrepancy.search_stages import SearchStage, gust_of, is_refuted, refuted
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import create_term
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities.constants import MAD_TO_STD


def find_changed_values(moved: MovedValues) -> dict[str, ChangedValue]:
    """Return the derivatives that moved beyond their bounds, all together significantly."""
    if moved.p_value(moved.change, len(moved.names)) > SEARCH.change_significance:
        return {}
    std = np.sqrt(moved.covariance.diagonal())
    least = float(norm.isf(0.5 * SEARCH.change_significance / len(moved.names)))
    return {
        name: ChangedValue(before=float(old), after=float(new), std=float(bound))
        for name, old, new, bound in zip(moved.names, moved.before, moved.after, std, strict=True)
        if abs(new - old) > least * bound
    }


def compute_observability(
    screening: CandidateScreening, found: Collection[str]
) -> tuple[Observability, ...]:
    """Return, for every effect of the catalog, what these flights could show of it."""
    rows = []
    ids = [one.id for one in screening.candidates]
    for one in screening.candidates:
        if not one.named:
            continue
        index = screening.index(one.id)
        std = float(screening.std[index])
        sigma = abs(one.plausible_size) / std if np.isfinite(std) else 0.0
        aliases: tuple[tuple[str, float], ...] = ()
        if np.isfinite(std):
            cosines = screening.cosines(one.id)
            table = dict(zip(screening.projected_information.names, cosines, strict=True))
            alike = sorted(
                (
                    (name, float(table[name]))
                    for name in ids
                    if name != one.id
                    and abs(table[name]) > SEARCH.min_alias_cosine
                    and np.isfinite(screening.std[screening.index(name)])
                ),
                key=lambda pair: -abs(pair[1]),
            )
            aliases = tuple(alike[: SEARCH.max_aliases])
        record = find_effect(one.id)
        fly = record.separated_by if aliases or sigma < SEARCH.visible_sigma else ""
        rows.append(
            Observability(
                effect=one.id,
                effect_class=record.effect_class,
                sigma=float(sigma),
                sigma_size=std,
                aliases=aliases,
                fly="" if one.id in found and not aliases else fly,
            )
        )
    rows += [
        Observability(
            effect=one.id,
            effect_class=one.effect_class,
            sigma=0.0,
            sigma_size=float("inf"),
            fly=one.remedy or one.separated_by,
        )
        for one in all_effects()
        if one.effect_class == "C" or (one.beyond_linear_alpha and one.id not in ids)
    ]
    rows.sort(key=lambda row: -row.sigma)
    return tuple(rows)


_REPORTED = ("CX", "CY", "CZ", "Cl", "Cm", "Cn")


def validate_on_held_out(
    stages: Sequence[SearchStage],
    against: Callable[[Sequence[SearchStage]], HeldOutManeuvers],
    forced: int,
    false_alarm: float,
) -> tuple[list[SearchStage], HeldOutManeuvers]:
    """Return the stages that maneuvers kept out bear out, and those maneuvers under them.

    The baseline comes first, and so many `forced` ones after it stay. `against` computes the
    maneuvers kept out under the models of stages.
    """
    kept = list(stages)
    held = against(kept)
    while len(kept) > 1 + forced and is_refuted(kept[-2], held, len(kept) - 2, false_alarm):
        kept = [*kept[:-2], refuted(kept[-2], false_alarm)]
        held = against(kept)
    return kept, held


def build_result(
    stages: Sequence[SearchStage],
    held: HeldOutManeuvers,
    *,
    maneuvers: Sequence[Maneuver],
    aircraft: Aircraft,
    model: Model | None,
    instruments: tuple[InstrumentRemark, ...],
    false_alarm: float,
) -> DiscrepancyResult:
    """Return the answer.

    The baseline is the first of the stages; `held` are the maneuvers kept out, under their models.
    Maneuvers are all, `model` the one that was given.
    """
    effects = tuple(
        _found_effect(before, after, stages[-1], held, index, aircraft)
        for index, (before, after) in enumerate(pairwise(stages))
    )
    last = stages[-1]
    open_ = [before.decision for before, after in pairwise(stages) if after.equivalent_effects]
    open_.append(last.decision)
    # A fitted model cannot be wrong in its values.
    moved = None if model is None else MovedValues.of_fit(model, last.fit)
    values = find_changed_values(moved) if moved and moved.names else {}
    targets = {coefficient_of(create_term(one.effect, aircraft).target) for one in effects}
    rescaled = mass_errors(moved, aircraft, targets) if moved and values else ()
    seen = compute_observability(stages[0].screening, {one.effect for one in effects})
    verdict = _verdict(last.decision.kind, effects, values, seen)
    shown = maneuver_histories(held, _REPORTED)
    if last.decision.kind == "nothing":
        shown = apply_residual_floor(shown)
    maps = coefficient_map(shown, _REPORTED)
    misfits = held.misfits()
    steps = tuple(
        ModelStep(
            model=_stage_model(stage, effects[:index], model),
            added=stage.added,
            ranking=_ranking(stage, held, index),
            coefficient_map=maps[index],
            gap=held.relative_rms(index),
            misfit=misfits[index],
        )
        for index, stage in enumerate(stages)
    )
    found = DiscrepancyResult(
        verdict=verdict,
        why="",
        disagreements=find_disagreements(
            shown, localize_model_errors(stages[0].fit, stages[0].screening), false_alarm
        ),
        observability=seen,
        steps=steps,
        effects=effects,
        values=values,
        alternatives=(*find_alternatives(verdict, open_), *rescaled),
        disturbance=gust_of(last.fit),
        gap=compute_gap(
            held, _next_gain(steps[-1].ranking) if effects else None, _misfit_scatter(last)
        ),
        maneuvers=shown,
        coefficients=_REPORTED,
        channels=tuple(dict.fromkeys(name for one in shown for name in one.channels)),
        warnings=(*held.warnings, *record_remarks(maneuvers, aircraft)),
        instruments=instruments,
    )
    return replace(found, why=explain_verdict(found, last.decision))


def _next_gain(ranking: Sequence[RankedCandidate]) -> float:
    """Return the gain that the best of the effects still to add has on maneuvers kept out."""
    return ranking[0].held_out if ranking else 0.0


def _misfit_scatter(stage: SearchStage) -> float:
    """Return how the mean square of the innovations differs between most maneuvers of the fit."""
    squares = [
        float(one.matrix[-1, -1]) / max(one.samples, 1.0)
        for one in stage.screening.maneuver_information.values()
    ]
    away = np.abs(np.array(squares) - np.median(squares))
    return MAD_TO_STD * float(np.median(away)) if len(squares) > 2 else float("inf")


def _stage_model(stage: SearchStage, effects: Sequence[FoundEffect], given: Model | None) -> Model:
    """Return the model of a stage: what it revises, why, and what its values were fitted to."""
    fitted = [one.record.flight for one in stage.fit.maneuvers]
    source = f"fitted to {len(fitted)} maneuvers of {', '.join(dict.fromkeys(fitted))}"
    model = stage.fit.revised_model().model_copy(update={"source": source})
    if not effects:
        if given is None:
            return model
        return model.model_copy(
            update={
                "name": f"{given.name}, refitted",
                "parent": given.name,
                "evidence": "all values are refitted; no effect is added",
            }
        )
    text = "; ".join(
        f"{one.effect} ({one.title}): "
        + (
            "forced"
            if one.forced
            else f"confidence {one.confidence:.0%}"
            if one.named
            else "found, not understood"
        )
        + (f", or another of {', '.join(one.one_of)}" if one.one_of else "")
        for one in effects
    )
    return model.model_copy(update={"evidence": text})


def _found_effect(
    before: SearchStage,
    after: SearchStage,
    last: SearchStage,
    held: HeldOutManeuvers,
    number: int,
    aircraft: Aircraft,
) -> FoundEffect:
    """Return what `after` has and `before` has not, with the values of the last stage."""
    effect = after.added
    term = create_term(effect, aircraft)
    fit = last.fit
    names = (*fit.free, *fit.bias_names())
    _, covariance = last.information.solution(names)
    stds = dict(zip(names, np.sqrt(covariance.diagonal()), strict=True))
    moved = {name: name for name in fit.free} | fit.shared_parameters()
    prefix = f"{effect}."
    parameters = {
        name.removeprefix(prefix): (fit.values[leader], float(stds[leader]))
        for name, leader in moved.items()
        if name.startswith(prefix)
    }
    evidence = before.decision.evidence
    competitors = before.screening.candidates
    stood_for = effect.replace(".reversed", ".scale")
    own = next((k for k, one in enumerate(competitors) if one.id in (effect, stood_for)), None)
    order = [k for k in np.argsort(-before.decision.gain) if k != own]
    runner = competitors[order[0]] if order else None
    margin = (
        0.5 * float(before.decision.gain[own] - before.decision.gain[order[0]])
        if own is not None and order
        else 0.0
    )
    if after.proven:
        confidence = SEARCH.max_confidence
    else:
        confidence = (
            SEARCH.max_confidence * float(evidence[own])
            if own is not None and not after.forced
            else 0.0
        )
    return FoundEffect(
        effect=effect,
        title=term.title,
        equation=term.equation,
        parameters=parameters,
        confidence=confidence,
        runner_up="" if runner is None else runner.id,
        margin=margin,
        held_out=held.gain(number, number + 1),
        forced=after.forced,
        one_of=after.equivalent_effects,
    )


def _ranking(
    stage: SearchStage, held: HeldOutManeuvers, number: int
) -> tuple[RankedCandidate, ...]:
    screening, decision = stage.screening, stage.decision
    evidence = (
        decision.evidence
        if decision.kind != "nothing"
        else posterior_probabilities(screening.candidates, screening.gain)
    )
    order = np.lexsort((-decision.gain, -evidence))[: SEARCH.max_ranked]
    outside = held.candidate_gains(number, screening, [int(place) for place in order])
    return tuple(
        RankedCandidate(
            effect=screening.candidates[place].id,
            title=screening.candidates[place].title,
            score=0.5 * float(decision.gain[place]),
            evidence=float(evidence[place]),
            held_out=gain,
            sigma=float(np.sqrt(max(decision.gain[place], 0.0))),
        )
        for place, gain in zip(order, outside, strict=True)
    )


def _verdict(
    last: DecisionKind,
    effects: Sequence[FoundEffect],
    values: Mapping[str, ChangedValue],
    seen: Sequence[Observability],
) -> DiscrepancyVerdict:
    named = [one for one in effects if one.named]
    if any(not one.forced and not one.one_of for one in named):
        return "effects-found"
    if any(one.one_of for one in effects):
        return "ambiguous"
    if last == "ambiguous":
        return "ambiguous"
    if last == "unexplained" or any(not one.named and not one.forced for one in effects):
        return "unexplained"
    if effects:
        return "effects-found"
    if values:
        return "values-wrong"
    able = [one.sigma >= SEARCH.visible_sigma for one in seen if one.effect_class != "C"]
    return (
        "model-adequate"
        if sum(able) >= SEARCH.min_observable_share * len(able)
        else "not-observable"
    )
