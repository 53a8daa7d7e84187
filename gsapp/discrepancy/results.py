"""What the search for a missing effect returns: everything that is told, drawn or written.

One `DiscrepancyResult` holds the answer; its `steps` tell the story from the baseline to the
revised model, its `maneuvers` the histories behind every picture. All numbers are SI and radians.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from gsapp.discrepancy.effect_catalog import find_effect
from gsapp.discrepancy.effect_selection import EffectDecision
from gsapp.dynamics.effects.unnamed_terms import is_unnamed
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import EffectClass
from gsapp.flight.cards import CardSet, TestCard
from gsapp.quantities import FloatArray

DiscrepancyVerdict = Literal[
    "effects-found", "values-wrong", "model-adequate", "ambiguous", "unexplained", "not-observable"
]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRegion:
    """Where in the flight envelope a disagreement grows."""

    variable: str
    """``alpha``, ``beta``, ``V``, ``throttle``, ``de``, ``da``, ``dr``, ``flap``; ``q`` and so
    on."""
    low: float
    high: float
    """SI, radians."""
    words: str  # "alpha above 6 deg".


@dataclass(frozen=True, slots=True, kw_only=True)
class Disagreement:
    """One place where model and flight disagree beyond the noise."""

    coefficient: str  # CX, CY, CZ, Cl, Cm, Cn; empty where an instrument disagrees with the others.
    channel: str  # The measured channel in which it shows most.
    maneuver: str  # Its id.
    t_start: float
    t_end: float
    """s of flight time."""
    rms: float
    noise_floor: float
    """Of the missing part of the coefficient over that time, and what noise alone would give."""
    p_value: float
    """Chance of as much, corrected for all that was looked at; see
    `gsapp.discrepancy.disagreements.ModelErrorLocation`."""
    region: FlightRegion | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Observability:
    """What these flights could show of one effect of the catalog, said before any verdict."""

    effect: str
    effect_class: EffectClass
    sigma: float
    """Standard deviations that the effect's plausible size would show, after the baseline's own
    parameters have taken what they can."""
    sigma_size: float  # Size (first parameter) that would show one standard deviation.
    aliases: tuple[tuple[str, float], ...] = ()
    """Effects that look alike here, with the cosine, most alike first."""
    fly: str = ""
    """The maneuver that would show it, or tell it from its aliases; empty where none is needed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RankedCandidate:
    """One effect in the competition of one step."""

    effect: str  # Id; ``unnamed.Cm.alpha_de2`` for structure without a name.
    title: str
    score: float  # Gain of the log-likelihood by adding it, less what its parameters cost.
    evidence: float  # Its probability among all candidates, 0 to 1.
    held_out: float  # Gain of the log-likelihood on maneuvers left out of the fit.
    sigma: float  # Size over its standard deviation.


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundEffect:
    """An effect that was proven."""

    effect: str
    title: str
    equation: str
    parameters: Mapping[str, tuple[float, float]]  # Value and standard deviation.
    confidence: float
    """Probability that this name is right; of those said with 0.9, nine in ten are."""
    runner_up: str = ""  # Next best candidate, empty where none came near.
    margin: float = 0.0  # Gain in log-likelihood over it.
    held_out: float = 0.0  # Gain of the log-likelihood on the maneuvers kept out.
    forced: bool = False  # Whether the user put it in.
    one_of: tuple[str, ...] = ()
    """Effects that it stands for, itself with them, where these flights cannot tell which it is."""

    @property
    def named(self) -> bool:
        """Return whether the catalog explains it; else it is found and not understood."""
        return not is_unnamed(self.effect)

    def margin_text(self) -> str:
        """Return the next best candidate and how much less it gains."""
        if self.margin >= 0.0:
            return f"{self.runner_up}, {self.margin:.1f} lower in log-likelihood"
        return f"{self.runner_up}, {-self.margin:.1f} higher, but structure without a name is rarer"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangedValue:
    """A derivative whose value moved beyond its bounds."""

    before: float
    after: float
    std: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative:
    """What else these flights would look the same with."""

    effects: tuple[str, ...]  # One effect, or several that act together.
    title: str
    why: str
    fly: str  # The maneuver, or the measurement on the ground, that would tell.


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelGap:
    """Residual of one channel on the maneuvers kept out, RMS."""

    before: float
    after: float
    floor: float
    """RMS of measured minus computed, and of the noise alone."""
    before_pct: float
    after_pct: float
    """RMS over the range, percent, as in tables 7.4.1 and 7.4.2."""
    theil_before: float
    theil_after: float
    within_before: float
    within_after: float
    """Share of samples within three noise floors."""
    floor_is_bound: bool = False
    """Whether the record shows less noise than `floor`: no instrument is believed better."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gap:
    """The gap between model and flight on maneuvers kept out of naming and fitting."""

    channels: Mapping[str, ChannelGap]
    closed: float | None
    closed_std: float | None
    """Share of the gap that was closed (1: all), and its standard deviation; None where no effect
    was added, or the gap is too small to tell."""
    on: tuple[str, ...]  # Ids of the maneuvers kept out.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModelStep:
    """One model on the way from the baseline (step 0) to the revised one."""

    model: Model
    added: str  # Id of the effect that this step added; empty for the baseline.
    ranking: tuple[RankedCandidate, ...]
    """Of the competition that this step's model then faced, best first: what to add next."""
    coefficient_map: FloatArray
    """Shape (n_maneuvers, n_coefficients). Missing part of each coefficient in units of the noise
    floor (1: nothing but noise)."""
    gap: Mapping[str, float]  # RMS over the noise floor on the maneuvers kept out, by channel.
    misfit: float  # Of all channels together, on the maneuvers kept out; 1 at the floor.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverHistories:
    """Histories of one maneuver."""

    id: str
    flight: str
    kind: str
    held_out: bool
    times: FloatArray  # Shape (n,).
    channels: tuple[str, ...]
    measured: FloatArray  # Shape (n, n_channels). NaN where a sample did not count.
    computed: tuple[FloatArray, ...]  # Shape (n, n_channels). One for each step.
    coefficients: tuple[str, ...]
    missing: tuple[FloatArray, ...]
    """Shape (n, n_coefficients). For each step, the part of each coefficient that its model lacks,
    low-passed."""
    noise_floor: Mapping[str, float]  # Noise floor of each channel.
    coefficient_noise_floor: Mapping[str, float]
    conditions: Mapping[str, FloatArray]
    """Shape (n,). alpha, beta, V, throttle, de, da, dr, flap where they are known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentRemark:
    """What the data compatibility check says of one instrument."""

    channel: str  # Or several, with commas.
    words: str
    consistent: bool
    effect: str = ""
    """Of the catalog, where kinematics alone prove it: a turned axis, two that are swapped."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DecidingExperiment:
    """The smallest experiment that tells effects apart, or makes them show."""

    purpose: Literal["separate", "show"]
    effects: tuple[str, ...]
    titles: tuple[str, ...]
    """Between which it decides, the most probable first, or which it makes visible."""
    cards: tuple[TestCard, ...] = ()  # What to fly.
    separation: float = 0.0
    """Standard deviations: the least by which it tells any two of the effects apart, or by which
    any of usual size stands out, then with the flights so far."""
    separation_now: float = 0.0  # The same of the flights so far.
    target: float = 0.0  # What was wanted.

    @property
    def decides(self) -> bool:
        return self.separation >= self.target

    def card_set(self, aircraft: str) -> CardSet:
        """Return the cards as a set for an aircraft."""
        return CardSet(name="Experiment that decides", aircraft=aircraft, cards=self.cards)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnexplainedStructure:
    """The products without a name that one coefficient needs, together."""

    coefficient: str
    effects: tuple[str, ...]  # Ids of the products.
    equation: str  # With sizes and standard deviations.
    variables: tuple[str, ...]
    """One or two, as a term reads them: those that change it most where it was flown."""
    nodes: tuple[FloatArray, ...]  # Of each variable, SI.
    values: FloatArray  # Shape as the nodes. Others of its variables are at their medians.
    flown: FloatArray
    """Shape as the nodes. Share of all samples that lie nearest to each node."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DiscrepancyResult:
    """The answer."""

    verdict: DiscrepancyVerdict
    why: str  # Plain words.
    disagreements: tuple[Disagreement, ...]  # Of the baseline, most significant first.
    observability: tuple[Observability, ...]
    steps: tuple[ModelStep, ...]  # The baseline first.
    effects: tuple[FoundEffect, ...]
    values: Mapping[str, ChangedValue]
    alternatives: tuple[Alternative, ...]
    disturbance: Mapping[str, float]  # ``gust``: rms of turbulence, m/s; with ``gust_std``.
    gap: Gap
    maneuvers: tuple[ManeuverHistories, ...]
    coefficients: tuple[str, ...]
    channels: tuple[str, ...]
    """Order of the maps and histories."""
    instruments: tuple[InstrumentRemark, ...] = ()
    warnings: tuple[str, ...] = ()
    structures: tuple[UnexplainedStructure, ...] = ()
    experiment: DecidingExperiment | None = None
    """What to fly next, where effects cannot be told apart or nothing could be seen."""

    @property
    def ranking(self) -> tuple[RankedCandidate, ...]:
        return self.steps[0].ranking if self.steps else ()

    @property
    def model(self) -> Model:
        return self.steps[-1].model


def discrepancy_json(
    found: DiscrepancyResult, *, model: Path | str | None = None
) -> dict[str, Any]:
    """Return what `found` says, as strict JSON can hold it (DESIGN section 5): SI and radians.

    Absent, and numbers that are not finite, are None. Beyond the fixed keys stand those that a
    program would otherwise have to work out again: what each step closed, how good a candidate was
    on maneuvers left out, whether an effect was forced. `model` is where the revised model was
    written.
    """
    content = {
        "verdict": found.verdict,
        "why": found.why,
        "disagreements": [asdict(one) for one in found.disagreements],
        "observability": [_observability(one) for one in found.observability],
        "ranking": [asdict(one) for one in found.ranking],
        "effects": [_effect(one) for one in found.effects],
        "values": {name: asdict(one) for name, one in found.values.items()},
        "alternatives": [_alternative(one) for one in found.alternatives],
        "disturbance": {"gust": None, **found.disturbance},
        "gap": asdict(found.gap),
        "steps": [_step(one) for one in found.steps],
        "instruments": [asdict(one) for one in found.instruments],
        "structures": [_structure(one) for one in found.structures],
        "warnings": found.warnings,
        "experiment": None if found.experiment is None else experiment_json(found.experiment),
        "model": None if model is None else str(model),
    }
    plain: dict[str, Any] = _plain(content)
    return plain


def _observability(one: Observability) -> dict[str, Any]:
    return {
        "effect": one.effect,
        "class": one.effect_class,
        "sigma": one.sigma,
        "sigma_size": one.sigma_size,
        "aliases": [name for name, _ in one.aliases],
        "cosines": [cosine for _, cosine in one.aliases],
        "fly": one.fly,
    }


def _effect(one: FoundEffect) -> dict[str, Any]:
    parameters = {
        name: {"value": value, "std": std} for name, (value, std) in one.parameters.items()
    }
    return {
        "effect": one.effect,
        "title": one.title,
        "equation": one.equation,
        "parameters": parameters,
        "confidence": one.confidence,
        "runner_up": one.runner_up or None,
        "margin": one.margin,
        "held_out": one.held_out,
        "forced": one.forced,
        "one_of": one.one_of,
        "named": one.named,
    }


def _structure(one: UnexplainedStructure) -> dict[str, Any]:
    return {
        "coefficient": one.coefficient,
        "effects": one.effects,
        "equation": one.equation,
        "nodes": {
            name: nodes.tolist() for name, nodes in zip(one.variables, one.nodes, strict=True)
        },
        "values": one.values.tolist(),
        "flown": one.flown.tolist(),
    }


def _alternative(one: Alternative) -> dict[str, Any]:
    # A reader of the ranking looks for "effect": one id, or all that act together.
    return {"effect": "+".join(one.effects), **asdict(one)}


def experiment_json(one: DecidingExperiment) -> dict[str, Any]:
    """Return an experiment for programs; SI and radians."""
    return {
        "purpose": one.purpose,
        "effects": one.effects,
        "maneuvers": [
            {
                "card": card.id,
                "input": card.kind,
                "surfaces": card.surfaces,
                "amplitude": card.amplitudes,
                "width": card.width,
                "speed": card.speed,
                "flap": card.flap,
                "throttle_step": card.throttle_step,
                "repeats": card.repeats,
            }
            for card in one.cards
        ],
        "separation": one.separation,
        "separation_now": one.separation_now,
        "target": one.target,
        "decides": one.decides,
    }


def _step(one: ModelStep) -> dict[str, Any]:
    return {
        "added": one.added or None,
        "model": one.model.name,
        "misfit": one.misfit,
        "gap": one.gap,
        "ranking": [asdict(candidate) for candidate in one.ranking],
    }


def _plain(value: Any) -> Any:
    """Return `value` in the types of JSON; numbers that are not finite become None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if value is None or isinstance(value, bool | str | int):
        return value
    number = float(value)
    return number if math.isfinite(number) else None


def find_alternatives(
    verdict: DiscrepancyVerdict, decisions: Sequence[EffectDecision]
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
            if (one.named or verdict == "unexplained")
            # What was taken back is no alternative to itself.
            and not (one.named and one is decision.best and decision.kind == "unexplained")
        ]
    return tuple(found)


def _effect_sentences(effects: Sequence[FoundEffect]) -> list[str]:
    sentences = []
    for one in effects:
        if one.forced:
            sentences.append(f"{one.title}: forced into the model.")
            continue
        if not one.named:
            continue
        if one.one_of:
            sentences.append(
                f"These flights cannot distinguish: {', '.join(one.one_of)}. The model uses the "
                f"first ({one.title}), which explains the most."
            )
            continue
        sentences.append(
            f"{one.title}: {one.confidence:.0%} sure"
            + (f"; next best: {one.margin_text()}." if one.runner_up else ".")
        )
    return sentences


def explain_verdict(found: DiscrepancyResult, decision: EffectDecision) -> str:
    """Return the answer in plain words."""
    sentences = _effect_sentences(found.effects)
    if decision.kind == "ambiguous":
        names = ", ".join(one.id for one in decision.alternatives)
        if len(decision.alternatives) > 1:
            sentences.append(f"These flights cannot distinguish: {names}.")
        sentences += [
            f"{one.title} ({one.id}) would explain these flights, but what it acts through did "
            f"not move. Fly {find_effect(one.id).separated_by}."
            for one in decision.alternatives
            if not one.excited
        ]
    unnamed = [one.title for one in found.effects if not one.named and not one.forced]
    if unnamed:
        it, terms = ("them", "terms") if len(unnamed) > 1 else ("it", "a term")
        sentences.append(
            f"Found, not understood: {', '.join(unnamed)}; the catalog has no effect like {it}. "
            f"The model holds {it} as {terms} without a name."
        )
        if decision.kind == "nothing" and found.verdict == "unexplained":
            sentences.append("But for this the model explains these flights to the noise level.")
    if decision.kind == "unexplained":
        best = decision.best
        if best is not None and decision.contradicted:
            sentences.append(
                f"Something more is missing: {best.title} ({best.id}) explains the fitted "
                "maneuvers best, but the held-out maneuvers contradict it."
            )
        else:
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
