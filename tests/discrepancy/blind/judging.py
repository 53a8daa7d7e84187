"""What the program answered to a blind case, beside what is right: marks for one case."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from gsapp.discrepancy.effect_catalog import all_effects
from tests.discrepancy.blind.cases import AIRFRAMES, WHOLE, Case
from tests.discrepancy.blind.sensitivity import distances, showing

if TYPE_CHECKING:
    from gsapp.discrepancy.results import DiscrepancyResult

APART = 4.0
"""Effects nearer to each other than this, in sigmas, may be said not to be told apart."""
_COEFFICIENTS = {"CN": "CZ", "CA": "CX"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Named:
    effect: str
    confidence: float
    size: float | None = None
    std: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What the program answered, as much of it as is judged."""

    id: str  # Of the case.
    verdict: str  # ``failed`` where the program raised.
    named: tuple[Named, ...] = ()
    ranking: tuple[str, ...] = ()  # Of the competition that the baseline faced.
    open: tuple[tuple[str, ...], ...] = ()  # Sets that it said it cannot tell apart.
    values: tuple[str, ...] = ()  # Derivatives said to be wrong.
    gust: float = 0.0  # rms that it says, m/s; 0 if it says none.
    told_closed: float | None = None
    """Share of the reducible gap closed, by the program's own account."""
    closed: float | None = None  # The same with the true floor.
    coefficient: str = ""
    channel: str = ""
    maneuver: str = ""
    """Where it sees the worst disagreement."""
    cpu: float = 0.0  # s.
    error: str = ""


def outcome_of(
    case: Case, answer: DiscrepancyResult, *, closed: float | None, cpu: float
) -> Outcome:
    """Return what is judged of an answer; see `answering.closed_gap`."""
    worst = answer.disagreements[0] if answer.disagreements else None
    named = []
    for one in answer.effects:
        if one.one_of or not one.named:
            continue
        size, std = next(iter(one.parameters.values()), (None, None))
        named.append(
            Named(
                effect=one.effect, confidence=one.confidence, size=_number(size), std=_number(std)
            )
        )
    return Outcome(
        id=case.id,
        verdict=answer.verdict,
        named=tuple(named),
        ranking=tuple(one.effect for one in answer.ranking[:6]),
        open=_open(answer),
        values=tuple(answer.values),
        gust=float(answer.disturbance.get("gust", 0.0)),
        told_closed=answer.gap.closed,
        closed=closed,
        coefficient=worst.coefficient if worst else "",
        channel=worst.channel if worst else "",
        maneuver=worst.maneuver if worst else "",
        cpu=cpu,
    )


def _open(answer: DiscrepancyResult) -> tuple[tuple[str, ...], ...]:
    sets = tuple(one.one_of for one in answer.effects if one.one_of)
    if answer.verdict == "ambiguous" and not sets:
        sets = (tuple(name for one in answer.alternatives for name in one.effects),)
    return sets


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)


@dataclass(frozen=True, slots=True, kw_only=True)
class Marks:
    """What was right; None where a question does not arise."""

    verdict: bool
    first: bool | None = None
    three: bool | None = None
    """The truth was named first; was among the first three of the ranking (or named)."""
    ambiguity: bool | None = None
    """Where it said that effects cannot be told apart: whether the truth was among them."""
    deserved: bool | None = None
    """Where it said so: whether those that it did not name truly cannot."""
    false_name: bool = False  # A name of the catalog that is not right.
    abstained: bool | None = None  # Outside the catalog: named nothing of it.
    coefficient: bool | None = None
    maneuver: bool | None = None
    closed: float | None = None
    size_error: float | None = None  # Relative.
    covered: bool | None = None  # The true size lies within the 95 % interval.
    confidences: tuple[tuple[float, bool], ...] = field(default_factory=tuple)
    """Of each name said: how sure, and whether right."""

    @property
    def first_or_ambiguous(self) -> bool | None:
        return self.first if self.ambiguity is None else self.ambiguity


def is_named(effect: str) -> bool:
    return any(one.id == effect and not one.decoy for one in all_effects())


def judge(case: Case, outcome: Outcome) -> Marks:
    """Return the marks for the answer to a case (with its sizes filled in)."""
    right = {name for group in case.accepted for name in group}
    own = {*AIRFRAMES.get(case.airframe, ())} - right
    names = [one.effect for one in outcome.named if one.effect not in own]
    wrong = [name for name in names if is_named(name) and name not in right]
    confidences = tuple(
        (one.confidence, one.effect in right | own) for one in outcome.named if is_named(one.effect)
    )
    listed = {name for group in outcome.open for name in group}
    common = {
        "false_name": bool(wrong),
        "confidences": confidences,
        "verdict": outcome.verdict in case.verdicts,
    }
    if case.group == "nothing":
        allowed = right if case.clock or case.airframe else set()
        return Marks(**{**common, "false_name": any(n not in allowed for n in wrong)})  # type: ignore[arg-type]
    if case.group == "outside":
        return Marks(**common, abstained=not any(is_named(one) for one in names))  # type: ignore[arg-type]
    found = [any(name in group for name in names) for group in case.accepted]
    lacks = {next(iter(case.effects)).removeprefix("aero.").replace(".", "_")}
    first = bool(names) and names[0] in right and all(found)
    if "values-wrong" in case.verdicts and outcome.verdict == "values-wrong":
        first = lacks <= set(outcome.values)
    three = first or bool(right & {*names, *outcome.ranking[:3]})
    told = all(right & set(one) for one in outcome.open) and all(
        one or listed & set(group) for one, group in zip(found, case.accepted, strict=True)
    )
    unnamed = [effect for effect, one in zip(case.effects, found, strict=True) if not one]
    alike = [
        min(distances(case, one).values(), default=APART) < APART
        for one in unnamed
        if not case.airframe
    ]
    size_error, covered = _size(case, outcome)
    return Marks(
        **common,  # type: ignore[arg-type]
        first=first,
        three=three,
        ambiguity=told if outcome.open else None,
        deserved=bool(alike) and all(alike) if outcome.open else None,
        coefficient=_coefficient(case, outcome),
        maneuver=_maneuver(case, outcome),
        closed=outcome.closed,
        size_error=size_error,
        covered=covered,
    )


def _size(case: Case, outcome: Outcome) -> tuple[float | None, bool | None]:
    for one in outcome.named:
        true = case.effects.get(one.effect)
        if true is None or one.size is None or not one.std or one.effect.endswith(WHOLE):
            continue
        rest = 1.0 if one.effect.startswith("sensor.") and one.effect.endswith("scale") else 0.0
        return abs(one.size - true) / abs(true - rest), abs(one.size - true) < 1.96 * one.std
    return None, None


def _coefficient(case: Case, outcome: Outcome) -> bool | None:
    # Another aircraft's own kinks are larger than what is hidden.
    seen = outcome.coefficient or outcome.channel
    if case.group != "hidden" or case.airframe or not seen:
        return None
    group, target, *_ = next(iter(case.effects)).split(".")
    if group == "sensor":
        return not outcome.coefficient or outcome.channel in target.split("_")
    if group == "control":
        return outcome.coefficient in ("Cm", "CZ")
    right = {"thrust": "CX"}.get(target, _COEFFICIENTS.get(target, target))
    return outcome.coefficient == right


def _maneuver(case: Case, outcome: Outcome) -> bool | None:
    if case.group != "hidden" or case.airframe or not outcome.maneuver:
        return None
    where = showing(case.plan, case.recording).where[next(iter(case.effects))]
    share = where.get(outcome.maneuver.rpartition(":")[2], 0.0)
    return share >= 0.5 * max(where.values())
