"""What each of the four steps shows, taken from an answer. Frozen; no Qt widgets, no numerics."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gsapp.discrepancy.results import (
    ChannelGap,
    Disagreement,
    FoundEffect,
    ManeuverView,
    Observability,
)
from gsapp.quantities import FloatArray, in_units
from ui.flight.tables import Line
from ui.gap.phrases import (
    NOT_SEEN,
    axis_unit,
    chance_text,
    channel_text,
    coefficient_text,
    joined,
    maneuver_text,
    number_text,
    parameter_text,
    percent_text,
    region_text,
    seen_text,
    shown,
    sigma_text,
    signed,
    sure_text,
    symbol,
    times_floor_text,
)
from ui.gap.request import Answer
from ui.gap.selection import Selection, step_names, view_of
from ui.words import DASH, clock_text, symbol_text, to_match

LEVELS = (1.5, 2.5, 5.0, 10.0)
"""Times the noise floor at which a cell of the map takes the next color."""

NO_BREAK = "\N{NO-BREAK SPACE}"
TO = "\N{NARROW NO-BREAK SPACE}→\N{NARROW NO-BREAK SPACE}"
"""Between before and after: numbers that belong together stay on one line."""


# --- Find ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One maneuver and coefficient of the map.

    Attributes
    ----------
    ratio : float
        Missing part over the noise floor.
    text : str
    level : int
        0 to 4, by `LEVELS`.
    proven : bool
        Whether the baseline's disagreement here is more than chance.
    """

    ratio: float
    text: str
    level: int
    proven: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MapPicture:
    """The map of maneuver and coefficient.

    Attributes
    ----------
    rows : tuple of (str, str, bool)
        Id of each maneuver, its words, whether it was kept out.
    columns : tuple of str
    cells : tuple of tuple of Cell
        One for each row and column.
    """

    rows: tuple[tuple[str, str, bool], ...] = ()
    columns: tuple[str, ...] = ()
    cells: tuple[tuple[Cell, ...], ...] = ()


def level(ratio: float) -> int:
    """Return the level of color of a ratio to the noise floor."""
    return sum(ratio >= bound for bound in LEVELS)


def map_picture(answer: Answer, step: int) -> MapPicture:
    """Return the map of one model."""
    found = answer.discrepancy
    if not found.steps:
        return MapPicture()
    proven = {(one.maneuver, one.coefficient) for one in found.disagreements}
    values = found.steps[step].map
    cells = tuple(
        tuple(
            Cell(
                ratio=float(values[row, column]),
                text=times_floor_text(float(values[row, column])),
                level=level(float(values[row, column])),
                proven=step == 0 and (view.id, name) in proven,
            )
            for column, name in enumerate(found.coefficients)
        )
        for row, view in enumerate(found.maneuvers)
    )
    rows = tuple(
        (view.id, maneuver_text(answer, view, clock=False), view.held_out)
        for view in found.maneuvers
    )
    return MapPicture(rows=rows, columns=found.coefficients, cells=cells)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TracePicture:
    """The missing part of one coefficient over one maneuver.

    Attributes
    ----------
    title : str
    times, missing : ndarray, shape (n,)
    former : ndarray or None
        That of the baseline, where another model is looked at.
    floor : float
    spans : tuple of (float, float)
        Where the disagreement is proven.
    """

    title: str
    times: FloatArray
    missing: FloatArray
    former: FloatArray | None
    floor: float
    spans: tuple[tuple[float, float], ...]


def trace_picture(answer: Answer, selection: Selection) -> TracePicture | None:
    """Return the history behind the chosen cell."""
    view = view_of(answer, selection.maneuver)
    if view is None or selection.coefficient not in view.coefficients:
        return None
    column = view.coefficients.index(selection.coefficient)
    here = (selection.maneuver, selection.coefficient)
    return TracePicture(
        title=f"Missing {coefficient_text(selection.coefficient)}, maneuver {view.id}",
        times=view.times,
        missing=view.missing[selection.step][:, column],
        former=view.missing[0][:, column] if selection.step else None,
        floor=view.coefficient_floor.get(selection.coefficient, float("nan")),
        spans=tuple(
            (one.t_start, one.t_end)
            for one in answer.discrepancy.disagreements
            if (one.maneuver, one.coefficient) == here
        ),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RegionPicture:
    """The missing part of one coefficient against what it may depend on.

    Attributes
    ----------
    title, axis, unit : str
    here : (ndarray, ndarray)
        Condition in the unit of the screen, and missing part, of the chosen maneuver.
    others : tuple of (ndarray, ndarray)
        Of the other maneuvers.
    floor : float
    region : (float, float) or None
        Where the chosen disagreement grows, in the unit of the screen.
    """

    title: str
    axis: str
    unit: str
    here: tuple[FloatArray, FloatArray]
    others: tuple[tuple[FloatArray, FloatArray], ...]
    floor: float
    region: tuple[float, float] | None


def region_picture(answer: Answer, selection: Selection, system: str) -> RegionPicture | None:
    """Return the chosen coefficient against the chosen variable."""
    view = view_of(answer, selection.maneuver)
    name, coefficient = selection.variable, selection.coefficient
    if view is None or name not in view.conditions or coefficient not in view.coefficients:
        return None

    def pair(one: ManeuverView) -> tuple[FloatArray, FloatArray]:
        column = one.coefficients.index(coefficient)
        return shown(name, one.conditions[name], system), one.missing[selection.step][:, column]

    region = next(
        (
            one.region
            for one in answer.discrepancy.disagreements
            if one.coefficient == coefficient
            and one.region is not None
            and one.region.variable == name
        ),
        None,
    )
    bounds = None
    if region is not None:
        low, high = shown(name, np.array([region.low, region.high]), system)
        bounds = (float(low), float(high))
    return RegionPicture(
        title=f"Missing {symbol_text(coefficient)} against {symbol(name)}",
        axis=channel_text(name),
        unit=axis_unit(name, system),
        here=pair(view),
        others=tuple(
            pair(one)
            for one in answer.discrepancy.maneuvers
            if one.id != view.id and name in one.conditions and coefficient in one.coefficients
        ),
        floor=view.coefficient_floor.get(coefficient, float("nan")),
        region=bounds,
    )


def disagreement_text(one: Disagreement, system: str) -> str:
    """Return a disagreement in a sentence."""
    ratio = times_floor_text(one.rms / one.noise_floor) if one.noise_floor > 0 else DASH
    what = coefficient_text(one.coefficient) if one.coefficient else channel_text(one.channel)
    where = region_text(one.region, system)
    grows = f", most with {where}" if where else ""
    return f"{what}: {ratio} times the noise{grows}"


def disagreement_lines(answer: Answer, system: str) -> tuple[Line, ...]:
    """Return the list of disagreements, most significant first; keys are their places."""
    lines = []
    for place, one in enumerate(answer.discrepancy.disagreements):
        when = f"{clock_text(one.t_start, decimals=1)} to {clock_text(one.t_end, decimals=1)}"
        detail = (
            f"Maneuver {one.maneuver}, {when}, seen most in {channel_text(one.channel)}; "
            f"{chance_text(one.p_value)} that noise alone did it."
        )
        lines.append(
            Line(key=place, cells=(one.maneuver, disagreement_text(one, system)), detail=detail)
        )
    return tuple(lines)


def instrument_lines(answer: Answer) -> tuple[str, ...]:
    """Return what is said of instruments that disagree with the others."""
    return tuple(one.words for one in answer.discrepancy.instruments if not one.consistent)


# --- Name ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class RankRow:
    """One candidate of the competition."""

    effect: str
    title: str
    evidence: float
    score: str
    held_out: str
    size: str
    proven: bool = False


def ranking(answer: Answer, step: int) -> tuple[RankRow, ...]:
    """Return the competition that a step's model faced."""
    found = answer.discrepancy
    if not found.steps:
        return ()
    following = found.steps[step + 1].added if step + 1 < len(found.steps) else ""
    return tuple(
        RankRow(
            effect=one.effect,
            title=one.title or answer.title(one.effect),
            evidence=one.evidence,
            score=signed(one.score, 1),
            held_out=signed(one.held_out, 1),
            size=sigma_text(one.sigma),
            proven=one.effect == following,
        )
        for one in found.steps[step].ranking
    )


def competition_text(answer: Answer, step: int) -> str:
    """Return who won the competition, over whom, and by how much."""
    found = answer.discrepancy
    rows = found.steps[step].ranking if found.steps else ()
    if not rows:
        return "Nothing competes here: this model leaves no gap that an effect could close."
    effect = effect_of_step(answer, step + 1)
    if effect is None:
        best = rows[0]
        return (
            f"Nothing more is proven. The best of the rest is “{best.title}” with "
            f"{percent_text(best.evidence)} of the evidence."
        )
    return f"“{effect.title}” – {sure_text(answer, effect)}."


def runner_up_text(answer: Answer, effect: FoundEffect) -> str:
    """Return the runner-up of an effect and the margin over it."""
    if not effect.runner_up:
        return "No other effect comes near."
    margin = number_text(effect.margin, 1)
    return f"Runner-up: “{answer.title(effect.runner_up)}”, behind by {margin} in log-likelihood."


def effect_of_step(answer: Answer, step: int) -> FoundEffect | None:
    """Return the effect that a step added."""
    steps = answer.discrepancy.steps
    if not 0 < step < len(steps):
        return None
    added = steps[step].added
    return next((one for one in answer.discrepancy.effects if one.effect == added), None)


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectPicture:
    """What is known of one candidate, in sentences with headings."""

    title: str
    equation: str
    paragraphs: tuple[tuple[str, str], ...]


def effect_picture(answer: Answer, effect: str) -> EffectPicture:
    """Return what an effect is, what it is mistaken for, and what would tell it apart."""
    note = answer.notes.get(effect)
    seen = next((one for one in answer.discrepancy.observability if one.effect == effect), None)
    paragraphs: list[tuple[str, str]] = []
    alike = [f"{answer.title(name)} ({percent_text(abs(cosine))} alike here)"
             for name, cosine in (seen.aliases if seen is not None else ())]  # fmt: skip
    if alike:
        paragraphs.append(("In these flights it looks like", joined(alike)))
    if note is not None and note.mistaken_for:
        others = joined(answer.title(name) for name in note.mistaken_for)
        paragraphs.append(("Mistaken for", others))
    told = seen.fly if seen is not None and seen.fly else ""
    if note is not None and note.told_apart and note.told_apart != told:
        told = f"{told}; {note.told_apart}" if told else note.told_apart
    if told:
        paragraphs.append(("What would tell it apart", told))
    if note is not None and note.remedy:
        paragraphs.append(("Settled on the ground by", note.remedy))
    if seen is not None:
        paragraphs.append(
            ("Could these flights show it?", f"A plausible size shows {seen_text(seen.sigma)}")
        )
    found = next((one for one in answer.discrepancy.effects if one.effect == effect), None)
    equation = found.equation if found is not None else (note.equation if note is not None else "")
    return EffectPicture(
        title=answer.title(effect), equation=equation, paragraphs=tuple(paragraphs)
    )


def observability_lines(answer: Answer, *, hidden_only: bool) -> tuple[Line, ...]:
    """Return what these flights could show, the least visible first."""
    table = sorted(answer.discrepancy.observability, key=lambda one: one.sigma)
    return tuple(
        Line(
            key=one.effect,
            cells=(
                answer.title(one.effect),
                # What merely rescales coefficients no maneuver shows.
                "on the ground only" if one.effect_class == "C" else seen_text(one.sigma),
                one.fly or _alias_words(answer, one),
            ),
            state="caution" if one.sigma < NOT_SEEN else "plain",
            colored=frozenset({1}),
            detail=f"{one.effect}, class {one.effect_class}. {_alias_words(answer, one)}".strip(),
        )
        for one in table
        if not hidden_only or one.sigma < NOT_SEEN
    )


def _alias_words(answer: Answer, one: Observability) -> str:
    if not one.aliases:
        return ""
    name, cosine = one.aliases[0]
    return f"looks like {answer.title(name)} ({percent_text(abs(cosine))})"


def alternative_lines(answer: Answer, system: str) -> tuple[tuple[str, str, str], ...]:
    """Return title, reason and remedy of what these flights would look the same with."""
    return tuple(
        (one.title, in_units(one.why, system), in_units(one.fly, system))
        for one in answer.discrepancy.alternatives
    )


# --- Add ----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectState:
    """One effect and where it stands.

    Attributes
    ----------
    effect, title : str
    words : str
        ``in the model``, ``next``, ``later``, ``refused``.
    place : int
        Its step; 0 for one that was refused.
    """

    effect: str
    title: str
    words: str
    place: int


def effect_states(answer: Answer, step: int) -> tuple[EffectState, ...]:
    """Return the effects on the way, then those that were refused."""
    states = []
    for place, one in enumerate(answer.discrepancy.steps):
        if not place:
            continue
        words = "in the model" if place <= step else "next" if place == step + 1 else "later"
        if one.added in answer.decisions.forced:
            words += ", forced"
        states.append(
            EffectState(effect=one.added, title=answer.title(one.added), words=words, place=place)
        )
    states += [
        EffectState(effect=name, title=answer.title(name), words="refused", place=0)
        for name in answer.decisions.refused
    ]
    return tuple(states)


def state_lines(states: tuple[EffectState, ...]) -> tuple[Line, ...]:
    """Return the effects as lines."""
    return tuple(
        Line(
            key=one.effect,
            cells=(str(one.place) if one.place else DASH, one.title, one.words),
            strong=one.words.startswith("in the model"),
            italic=one.words == "refused",
            detail=one.effect,
        )
        for one in states
    )


def parameter_lines(answer: Answer, effect: str, system: str) -> tuple[tuple[str, str], ...]:
    """Return name and value of each parameter of a found effect."""
    found = next((one for one in answer.discrepancy.effects if one.effect == effect), None)
    note = answer.notes.get(effect)
    if found is None:
        return ()
    units = note.units if note is not None else {}
    return tuple(
        (name, parameter_text(value, std, units.get(name, ""), system))
        for name, (value, std) in found.parameters.items()
    )


def value_lines(answer: Answer) -> tuple[Line, ...]:
    """Return the derivatives that moved beyond their bounds."""
    lines = []
    for name, one in answer.discrepancy.values.items():
        moved = (one.after - one.before) / one.std if one.std > 0 else float("nan")
        lines.append(
            Line(
                key=name,
                cells=(
                    symbol_text(name),
                    to_match(one.before, one.std),
                    f"{to_match(one.after, one.std)} ± {to_match(one.std, one.std)}",
                    sigma_text(abs(moved)),
                ),
            )
        )
    return tuple(lines)


# --- Show ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OverlayPicture:
    """One channel of one maneuver, measured and computed, in the unit of the screen.

    Attributes
    ----------
    title, axis, unit : str
    times, measured, before, after : ndarray, shape (n,)
    floor : float
    """

    title: str
    axis: str
    unit: str
    times: FloatArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray
    floor: float


def overlay_picture(answer: Answer, selection: Selection, system: str) -> OverlayPicture | None:
    """Return the chosen channel of the chosen maneuver before and after."""
    view = view_of(answer, selection.maneuver)
    name = selection.channel
    if view is None or name not in view.channels:
        return None
    column = view.channels.index(name)
    kept = "kept out of naming and fitting" if view.held_out else "used for naming and fitting"
    floor = shown(name, np.array([view.floor.get(name, np.nan), 0.0]), system)
    return OverlayPicture(
        title=f"Maneuver {view.id}, {kept}",
        axis=channel_text(name),
        unit=axis_unit(name, system),
        times=view.times,
        measured=shown(name, view.measured[:, column], system),
        before=shown(name, view.computed[0][:, column], system),
        after=shown(name, view.computed[selection.step][:, column], system),
        floor=float(floor[0] - floor[1]),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class BarPair:
    """Gap of one channel in units of its noise floor."""

    channel: str
    before: float
    after: float


def bar_pairs(answer: Answer, step: int) -> tuple[BarPair, ...]:
    """Return the gap of each channel on the maneuvers kept out."""
    steps = answer.discrepancy.steps
    if not steps:
        return ()
    nan = float("nan")
    return tuple(
        BarPair(
            channel=name,
            before=steps[0].gap.get(name, nan),
            after=steps[step].gap.get(name, nan),
        )
        for name in answer.discrepancy.channels
        if name in steps[0].gap
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Fall:
    """One step of the waterfall: the misfit before and after it, 1 at the floor."""

    title: str
    before: float
    after: float
    current: bool


def waterfall(answer: Answer, step: int) -> tuple[Fall, ...]:
    """Return how the misfit fell from the baseline on."""
    steps = answer.discrepancy.steps
    names = step_names(answer)
    return tuple(
        Fall(
            title=names[place],
            before=steps[place - 1].misfit if place else one.misfit,
            after=one.misfit,
            current=place == step,
        )
        for place, one in enumerate(steps)
    )


def gap_lines(answer: Answer, system: str) -> tuple[Line, ...]:
    """Return the numbers of each channel: RMS, percent of range, Theil, share in tolerance."""
    return tuple(
        Line(key=name, cells=(symbol(name), *_gap_cells(name, one, system)))
        for name, one in answer.discrepancy.gap.channels.items()
    )


def _gap_cells(name: str, one: ChannelGap, system: str) -> tuple[str, ...]:
    zero, before, after, floor = (
        float(value)
        for value in shown(name, np.array([0.0, one.before, one.after, one.floor]), system)
    )
    decimals = max(len(f"{abs(floor - zero):.1g}".partition(".")[2]) + 1, 1)

    def rms(value: float) -> str:
        return number_text(value - zero, min(decimals, 5))

    def shares(first: float, second: float, digits: int) -> str:
        return f"{number_text(first, digits)}{TO}{number_text(second, digits)}{NO_BREAK}%"

    return (
        f"{rms(before)}{TO}{rms(after)}{NO_BREAK}{axis_unit(name, system)}".rstrip(),
        rms(floor),
        shares(one.before_pct, one.after_pct, 1),
        f"{number_text(one.theil_before, 3)}{TO}{number_text(one.theil_after, 3)}",
        shares(100 * one.within_before, 100 * one.within_after, 0),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceChoice:
    """One effect that can be forced."""

    effect: str
    title: str
    why: str = field(default="")


def force_choices(answer: Answer, step: int) -> tuple[ForceChoice, ...]:
    """Return the effects that are not in the model, the best candidates first, then the catalog."""
    found = answer.discrepancy
    there = {one.added for one in found.steps}
    ranked = found.steps[step].ranking if found.steps else ()
    choices = {
        one.effect: ForceChoice(
            effect=one.effect,
            title=one.title,
            why=f"{percent_text(one.evidence)} of the evidence, size {sigma_text(one.sigma)}",
        )
        for one in ranked
        if one.effect not in there
    }
    for name, note in answer.notes.items():
        if name not in there and name not in choices:
            choices[name] = ForceChoice(effect=name, title=note.title)
    return tuple(choices.values())
