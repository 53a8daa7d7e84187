"""What the program answered to a blind case, beside what is right: marks for one case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from blind.cases import WHOLE, Case
from blind.engine import RATE, STATE
from blind.flying import FlownCase
from blind.instruments import NOISE
from blind.jsbsim_aircraft import DERIVATIVES
from blind.plan import PLAN
from blind.sensitivity import (
    CHANNELS,
    baseline_columns,
    distances,
    effect_columns,
    showing,
)

from gsapp.discrepancy.catalog import catalog

if TYPE_CHECKING:
    from gsapp.discrepancy.results import Discrepancy, ManeuverView
    from gsapp.quantities import FloatArray

APART = 4.0
"""Effects nearer to each other than this, in sigmas, may be said not to be told apart."""
_COEFFICIENTS = {"CN": "CZ", "CA": "CX"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Named:
    """One effect that the program named."""

    effect: str
    confidence: float
    size: float | None = None
    std: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What the program answered, as much of it as is judged.

    Attributes
    ----------
    id : str
        Of the case.
    verdict : str
        ``failed`` where the program raised.
    named : tuple of Named
    ranking : tuple of str
        Of the competition that the baseline faced.
    alternatives : tuple of tuple of str
    values : tuple of str
        Derivatives said to be wrong.
    gust : float
        rms that it says, m/s; 0 if it says none.
    told_closed : float or None
        Share of the reducible gap closed, by the program's own account.
    closed : float or None
        The same with the true floor.
    coefficient, channel, maneuver : str
        Where it sees the worst disagreement.
    cpu : float
        s.
    error : str
    """

    id: str
    verdict: str
    named: tuple[Named, ...] = ()
    ranking: tuple[str, ...] = ()
    alternatives: tuple[tuple[str, ...], ...] = ()
    values: tuple[str, ...] = ()
    gust: float = 0.0
    told_closed: float | None = None
    closed: float | None = None
    coefficient: str = ""
    channel: str = ""
    maneuver: str = ""
    cpu: float = 0.0
    error: str = ""


def outcome_of(flown: FlownCase, answer: Discrepancy, cpu: float) -> Outcome:
    """Return what is judged of an answer."""
    worst = answer.disagreements[0] if answer.disagreements else None
    named = []
    for one in answer.effects:
        size, std = next(iter(one.parameters.values()), (None, None))
        named.append(
            Named(
                effect=one.effect, confidence=one.confidence, size=_number(size), std=_number(std)
            )
        )
    return Outcome(
        id=flown.case.id,
        verdict=answer.verdict,
        named=tuple(named),
        ranking=tuple(one.effect for one in answer.ranking[:6]),
        alternatives=tuple(one.effects for one in answer.alternatives),
        values=tuple(answer.values),
        gust=float(answer.disturbance.get("gust", 0.0)),
        told_closed=answer.gap.closed,
        closed=closed_gap(flown, answer.maneuvers),
        coefficient=worst.coefficient if worst else "",
        channel=worst.channel if worst else "",
        maneuver=worst.maneuver if worst else "",
        cpu=cpu,
    )


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)


def closed_gap(flown: FlownCase, views: Sequence[ManeuverView]) -> float | None:
    """Return the share of the reducible gap that was closed on maneuvers held out, by the truth.

    The gap: computed minus what a perfect model computes from the same measured deflections, in
    units of noise, less all that derivatives, initial states and zero offsets can make of it:
    these are estimated from noise, and what that does to them no structure closes. Reducible of
    it is what the hidden effect itself makes: its own columns, projected like the gap. The rest,
    such as what two integrators make of the noise of a pot between two samples, is there before
    and after. Not closed is what is left along the effect, and all that the last model brought in
    elsewhere. Sums of squares.
    """
    held = [view for view in views if view.held_out and len(view.computed) > 1]
    if not flown.effects or not held:
        return None
    every = RATE // flown.case.rate
    columns = dict(zip((one.id for one in PLAN), baseline_columns(flown.case.plan), strict=True))
    own = [_column(flown, effect) for effect in flown.effects]
    count = len(DERIVATIVES) + len(CHANNELS)
    gaps, freedoms, shown = [], [], []
    for place, view in enumerate(held):
        maneuver = view.id.rpartition(":")[2]
        free = columns[maneuver][::every]
        gap, kept = _gap(flown, view)
        wide = np.zeros((*free.shape[:2], count + len(STATE) * len(held)))
        wide[:, :, : len(DERIVATIVES)] = free[:, :, : len(DERIVATIVES)]
        wide[:, range(len(CHANNELS)), range(len(DERIVATIVES), count)] = 1.0
        first = count + place * len(STATE)
        wide[:, :, first : first + len(STATE)] = free[:, :, len(DERIVATIVES) :]
        freedoms.append(wide[kept])
        gaps.append(gap[kept])
        shown.append(np.stack([one[maneuver][::every] for one in own], axis=-1)[kept])
    basis = _orthogonal(np.concatenate(freedoms))
    before, after = _without(basis, np.concatenate(gaps)).T
    effects = _orthogonal(_without(basis, np.concatenate(shown)))
    reducible = effects.T @ before
    left = effects.T @ after
    brought = _without(effects, (after - before)[:, np.newaxis])
    whole = float(np.sum(reducible**2))
    return 1.0 - float(np.sum(left**2) + np.sum(brought**2)) / whole if whole > 0.0 else None


def _column(flown: FlownCase, effect: str) -> dict[str, FloatArray]:
    """Return what an effect changes, by maneuver, shape (n, n_channels)."""
    _, columns = effect_columns(flown.case.plan, effect)
    return dict(zip((one.id for one in PLAN), columns, strict=True))


def _without(basis: FloatArray, columns: FloatArray) -> FloatArray:
    """Return columns less what an orthonormal basis can make of them."""
    return np.asarray(columns - basis @ (basis.T @ columns))


def _orthogonal(columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis of columns that may hardly differ from one another."""
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-12)
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    strong = values > 1e-10 * values[-1]
    return np.asarray(scaled @ (vectors[:, strong] / np.sqrt(values[strong])))


def _gap(flown: FlownCase, view: ManeuverView) -> tuple[FloatArray, np.ndarray]:
    """Return computed minus truth, first and last model (n, n_channels, 2), and what counts."""
    maneuver = next(one for one in flown.maneuvers if one.id == view.id.rpartition(":")[2])
    truth = flown.steady[maneuver.id]
    places = np.rint((view.times - maneuver.t_start) / maneuver.dt).astype(np.intp)
    total = np.zeros((len(maneuver.block), len(CHANNELS), 2))
    kept = np.zeros(total.shape[:2], dtype=np.bool_)
    for column, name in enumerate(CHANNELS):
        own, scale = name, np.full(len(places), 1.0 / NOISE[name])
        if name == "dynamic_pressure" and "V" in view.channels:
            own = "V"
            scale = scale * truth["density"][places] * truth["V"][places]
        if own not in view.channels:
            continue
        source = view.channels.index(own)
        for end, computed in enumerate((view.computed[0], view.computed[-1])):
            total[places, column, end] = (computed[:, source] - truth[own][places]) * scale
        kept[places, column] = np.isfinite(total[places, column]).all(axis=1)
    return total, kept


@dataclass(frozen=True, slots=True, kw_only=True)
class Marks:
    """What was right; None where a question does not arise.

    Attributes
    ----------
    verdict : bool
    first, three : bool or None
        The truth was named first; was among the first three of the ranking (or named).
    ambiguity : bool or None
        Where it said that effects cannot be told apart: whether the truth was among them.
    deserved : bool or None
        Where it said so: whether they truly cannot.
    false_name : bool
        A name of the catalog that is not right.
    abstained : bool or None
        Outside the catalog: named nothing of it.
    coefficient, maneuver : bool or None
    closed : float or None
    size_error : float or None
        Relative.
    covered : bool or None
        The true size lies within the 95 % interval.
    confidences : tuple of (float, bool)
        Of each name said: how sure, and whether right.
    """

    verdict: bool
    first: bool | None = None
    three: bool | None = None
    ambiguity: bool | None = None
    deserved: bool | None = None
    false_name: bool = False
    abstained: bool | None = None
    coefficient: bool | None = None
    maneuver: bool | None = None
    closed: float | None = None
    size_error: float | None = None
    covered: bool | None = None
    confidences: tuple[tuple[float, bool], ...] = field(default_factory=tuple)

    @property
    def first_or_ambiguous(self) -> bool | None:
        """Return whether it was named first, or listed where effects cannot be told apart."""
        return self.first if self.ambiguity is None else self.ambiguity


def is_named(effect: str) -> bool:
    """Return whether an id is a name of the catalog (decoys and unnamed structure are not)."""
    return any(one.id == effect and not one.decoy for one in catalog())


def judge(case: Case, outcome: Outcome) -> Marks:
    """Return the marks for the answer to a case (with its sizes filled in)."""
    right = {name for group in case.accepted for name in group}
    names = [one.effect for one in outcome.named]
    wrong = [name for name in names if is_named(name) and name not in right]
    confidences = tuple(
        (one.confidence, one.effect in right) for one in outcome.named if is_named(one.effect)
    )
    listed = {name for group in outcome.alternatives for name in group}
    common = {
        "false_name": bool(wrong),
        "confidences": confidences,
        "verdict": outcome.verdict in case.verdicts,
    }
    if case.group == "nothing":
        allowed = right if case.clock else set()
        return Marks(**{**common, "false_name": any(n not in allowed for n in wrong)})  # type: ignore[arg-type]
    if case.group == "outside":
        return Marks(**common, abstained=not any(is_named(one) for one in names))  # type: ignore[arg-type]
    found = [any(name in group for name in names) for group in case.accepted]
    lacks = {next(iter(case.effects)).removeprefix("aero.").replace(".", "_")}
    first = bool(names) and names[0] in right and all(found)
    if "values-wrong" in case.verdicts and outcome.verdict == "values-wrong":
        first = lacks <= set(outcome.values)
    three = first or bool(right & {*names, *outcome.ranking[:3]})
    ambiguous = outcome.verdict == "ambiguous"
    near = {name for name, apart in distances(case).items() if apart < APART}
    size_error, covered = _size(case, outcome)
    return Marks(
        **common,  # type: ignore[arg-type]
        first=first,
        three=three,
        ambiguity=bool(right & listed) if ambiguous else None,
        deserved=bool(near) if ambiguous else None,
        coefficient=_coefficient(case, outcome),
        maneuver=_maneuver(case, outcome),
        closed=outcome.closed,
        size_error=size_error,
        covered=covered,
    )


def _size(case: Case, outcome: Outcome) -> tuple[float | None, bool | None]:
    """Return the relative error of the first right name's size, and whether its bound holds."""
    for one in outcome.named:
        true = case.effects.get(one.effect)
        if true is None or one.size is None or not one.std or one.effect.endswith(WHOLE):
            continue
        rest = 1.0 if one.effect.startswith("sensor.") and one.effect.endswith("scale") else 0.0
        return abs(one.size - true) / abs(true - rest), abs(one.size - true) < 1.96 * one.std
    return None, None


def _coefficient(case: Case, outcome: Outcome) -> bool | None:
    if case.group != "hidden" or not (outcome.coefficient or outcome.channel):
        return None
    group, target, *_ = next(iter(case.effects)).split(".")
    if group == "sensor":
        return not outcome.coefficient or outcome.channel in target.split("_")
    if group == "control":
        return outcome.coefficient in ("Cm", "CZ")
    right = {"thrust": "CX"}.get(target, _COEFFICIENTS.get(target, target))
    return outcome.coefficient == right


def _maneuver(case: Case, outcome: Outcome) -> bool | None:
    if case.group != "hidden" or not outcome.maneuver:
        return None
    where = showing(case.plan, case.recording).where[next(iter(case.effects))]
    share = where.get(outcome.maneuver.rpartition(":")[2], 0.0)
    return share >= 0.5 * max(where.values())
