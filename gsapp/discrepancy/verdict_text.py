"""The answer in plain words, and what else would look the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gsapp.discrepancy.effect_catalog import find_effect
from gsapp.discrepancy.effect_selection import EffectDecision
from gsapp.discrepancy.results import (
    Alternative,
    ChangedValue,
    DiscrepancyResult,
    DiscrepancyVerdict,
)
from gsapp.dynamics.model import Model


def find_alternatives(
    verdict: DiscrepancyVerdict,
    decisions: Sequence[EffectDecision],
    values: Mapping[str, ChangedValue],
    model: Model | None,
) -> tuple[Alternative, ...]:
    """Return what these flights cannot tell from the answer, for decisions that named nothing."""
    found = []
    for decision in decisions:
        if decision.kind not in ("ambiguous", "unexplained"):
            continue
        found += [
            Alternative(
                effects=(one.id,),
                title=one.title,
                why="explains the same samples equally well",
                fly=find_effect(one.id).separated_by if one.named else "",
            )
            for one in decision.alternatives
            if one.named or verdict == "unexplained"
        ]
    if model is not None and values:
        found += _rescaling_alternatives(values)
    return tuple(found)


_RESCALING_EFFECTS = (
    (("Cm_alpha", "Cm_q", "Cm_de"), "mass.inertia.iyy", 1.0),
    (("Cl_beta", "Cl_p", "Cl_r", "Cl_da"), "mass.inertia.ixx", 1.0),
    (("Cn_beta", "Cn_r", "Cn_dr"), "mass.inertia.izz", 1.0),
    (("CN_alpha",), "mass.mass.error", 1.0),
)


def _rescaling_alternatives(values: Mapping[str, ChangedValue]) -> list[Alternative]:
    """Return the errors of mass and inertia that would move these values all by one factor."""
    found = []
    for names, effect, _ in _RESCALING_EFFECTS:
        moved = [values[name] for name in names if name in values]
        if len(moved) < max(1, len(names) - 1):
            continue
        ratios = [one.after / one.before for one in moved if one.before]
        spread = [abs(one.std / one.before) for one in moved if one.before]
        if not ratios:
            continue
        mean = sum(ratios) / len(ratios)
        if all(
            abs(ratio - mean) < 3.0 * bound for ratio, bound in zip(ratios, spread, strict=True)
        ):
            lore = find_effect(effect)
            found.append(
                Alternative(
                    effects=(effect,),
                    title=lore.title,
                    why=f"moves {', '.join(names)} by one factor, here {mean:.2f}",
                    fly=lore.remedy,
                )
            )
    if "Cm_alpha" in values and "CN_alpha" not in values:
        lore = find_effect("mass.cg.x")
        found.append(
            Alternative(
                effects=("mass.cg.x",),
                title=lore.title,
                why="moves Cm_alpha by CN_alpha times the shift over the chord",
                fly=lore.remedy,
            )
        )
    return found


def explain_verdict(found: DiscrepancyResult, decision: EffectDecision) -> str:
    """Return the answer in plain words."""
    sentences = []
    for one in found.effects:
        if one.forced:
            sentences.append(f"{one.title}: forced into the model.")
            continue
        if one.one_of:
            sentences.append(
                f"These flights cannot distinguish: {', '.join(one.one_of)}. The model uses the "
                f"first ({one.title}), which explains the most."
            )
            continue
        sentences.append(
            f"{one.title}: {one.confidence:.0%} sure"
            + (
                f"; the next best explanation, {one.runner_up}, is {one.margin:.0f} lower in "
                "log-likelihood."
                if one.runner_up
                else "."
            )
        )
    if decision.kind == "ambiguous":
        names = ", ".join(one.id for one in decision.alternatives)
        sentences.append(f"These flights cannot distinguish: {names}.")
    if found.verdict == "unexplained" or (found.effects and decision.kind == "unexplained"):
        best = decision.best
        sentences.append(
            "An effect is missing that is not in the catalog"
            + (f"; nearest: {best.title}." if best is not None else ".")
        )
    if found.verdict == "values-wrong":
        sentences.append(
            f"The model structure is adequate; {', '.join(found.values)} differ from the model "
            "by more than their bounds."
        )
    if found.verdict == "model-adequate":
        sentences.append("The model explains these flights to the noise level.")
    if found.verdict == "not-observable":
        sentences.append(
            "Nothing found, but these maneuvers cannot show it: few effects of typical size "
            "would exceed the noise. Fly larger doublets on every surface, at two or more "
            "speeds."
        )
    if found.disturbance:
        sentences.append(
            f"Turbulence of about {found.disturbance['gust']:.1f} m/s disturbed the flights; "
            "not a model error."
        )
    return " ".join(sentences)
