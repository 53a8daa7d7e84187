"""What each of the four steps shows, taken from a result. Frozen; no Qt widgets, no numerics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.discrepancy.results import (
    ChannelGap,
    Disagreement,
    FoundEffect,
    Observability,
)
from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from gsapp.quantities import FloatArray, convert_text_units
from gsapp.report.discrepancy_pictures import missing_by_condition, to_display_units
from ui.display_limits import DISPLAY
from ui.gap.gap_selection import GapSelection, find_maneuver_view
from ui.gap.gap_text import (
    axis_unit,
    channel_symbol,
    channel_text,
    coefficient_text,
    effect_confidence_text,
    join_with_and,
    maneuver_text,
    noise_ratio_text,
    observability_text,
    p_value_text,
    parameter_text,
    region_text,
    sigma_text,
    signed_number_text,
)
from ui.gap.search_jobs import SearchResult
from ui.number_format import (
    DASH,
    clock_text,
    number_text,
    percent_text,
    symbol_text,
    value_to_std_digits,
)
from ui.translation import tr
from ui.widgets.row_model import CellFormat, TableRow

NO_BREAK_SPACE = "\N{NO-BREAK SPACE}"
ARROW = "\N{NARROW NO-BREAK SPACE}→\N{NARROW NO-BREAK SPACE}"
"""Between before and after: numbers that belong together stay on one line."""


# --- Find ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class MapCell:
    """One maneuver and coefficient of the map."""

    ratio: float
    level: int
    """0 to 4, by `DISPLAY.map_levels`."""
    proven: bool
    """Whether the baseline's disagreement here is more than chance."""


def build_map_rows(result: SearchResult, step: int) -> tuple[TableRow, ...]:
    """Return the map of one model: a row for each maneuver, a `MapCell` for each coefficient."""
    found = result.discrepancy
    if not found.steps:
        return ()
    proven = {(one.maneuver, one.coefficient) for one in found.disagreements} if step == 0 else ()
    rows = []
    for view, ratios in zip(found.maneuvers, found.steps[step].coefficient_map, strict=True):
        heading = maneuver_text(result, view, clock=False)
        cells = [
            MapCell(
                ratio=float(ratio),
                level=sum(ratio >= bound for bound in DISPLAY.map_levels),
                proven=(view.id, name) in proven,
            )
            for name, ratio in zip(found.coefficients, ratios, strict=True)
        ]
        texts = tuple(noise_ratio_text(cell.ratio) for cell in cells)
        formats = {
            column: CellFormat(
                detail=tr(
                    "{coefficient} of maneuver {heading}: {ratio} times the noise floor"
                ).format(
                    coefficient=COEFFICIENT_TITLES.get(name, name), heading=heading, ratio=text
                )
                + (tr(", significant") if cell.proven else "")
            )
            for column, (name, text, cell) in enumerate(
                zip(found.coefficients, texts, cells, strict=True)
            )
        }
        rows.append(
            TableRow(key=view.id, heading=heading, cells=texts, formats=formats, value=tuple(cells))
        )
    return tuple(rows)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissingCoefficientScatter:
    """The missing part of one coefficient against what it may depend on."""

    title: str
    axis: str
    unit: str
    selected: tuple[FloatArray, FloatArray]
    """Condition in the unit of the screen, and missing part, of the chosen maneuver."""
    others: tuple[tuple[FloatArray, FloatArray], ...]
    floor: float
    region: tuple[float, float] | None
    """Where the chosen disagreement grows, in the unit of the screen."""


def build_missing_scatter(
    result: SearchResult, selection: GapSelection, system: str
) -> MissingCoefficientScatter | None:
    """Return the chosen coefficient against the chosen variable."""
    view = find_maneuver_view(result, selection.maneuver)
    name, coefficient = selection.variable, selection.coefficient
    if view is None or name not in view.conditions or coefficient not in view.coefficients:
        return None

    pairs = {
        one.id: pair
        for one in result.discrepancy.maneuvers
        if (pair := missing_by_condition(one, coefficient, name, selection.step, system))
    }
    region = next(
        (
            one.region
            for one in result.discrepancy.disagreements
            if one.coefficient == coefficient
            and one.region is not None
            and one.region.variable == name
        ),
        None,
    )
    bounds = None
    if region is not None:
        low, high = to_display_units(name, np.array([region.low, region.high]), system)
        bounds = (float(low), float(high))
    return MissingCoefficientScatter(
        title=tr("Missing {coefficient} against {channel}").format(
            coefficient=symbol_text(coefficient), channel=channel_symbol(name)
        ),
        axis=channel_text(name),
        unit=axis_unit(name, system),
        selected=pairs.pop(view.id),
        others=tuple(pairs.values()),
        floor=view.coefficient_noise_floor.get(coefficient, float("nan")),
        region=bounds,
    )


def describe_disagreement(one: Disagreement, system: str) -> str:
    """Return a disagreement in a sentence."""
    ratio = noise_ratio_text(one.rms / one.noise_floor) if one.noise_floor > 0 else DASH
    what = coefficient_text(one.coefficient) if one.coefficient else channel_text(one.channel)
    where = region_text(one.region, system)
    grows = tr(", most with {where}").format(where=where) if where else ""
    return tr("{what}: {ratio} times the noise{grows}").format(what=what, ratio=ratio, grows=grows)


def build_disagreement_rows(result: SearchResult, system: str) -> tuple[TableRow, ...]:
    """Return the list of disagreements, most significant first; keys are their places."""
    lines = []
    for index, one in enumerate(result.discrepancy.disagreements):
        when = tr("{start} to {end}").format(
            start=clock_text(one.t_start, decimals=1), end=clock_text(one.t_end, decimals=1)
        )
        detail = tr(
            "Maneuver {maneuver}, {when}, largest in {channel}; {p_value} that it is noise alone."
        ).format(
            maneuver=one.maneuver,
            when=when,
            channel=channel_text(one.channel),
            p_value=p_value_text(one.p_value),
        )
        lines.append(
            TableRow(
                key=index, cells=(one.maneuver, describe_disagreement(one, system)), detail=detail
            )
        )
    return tuple(lines)


def list_instrument_texts(result: SearchResult) -> tuple[str, ...]:
    """Return what is said of instruments that disagree with the others."""
    return tuple(one.words for one in result.discrepancy.instruments if not one.consistent)


# --- Name ---------------------------------------------------------------------------------------


def build_ranking_rows(result: SearchResult, step: int) -> tuple[TableRow, ...]:
    """Return the competition that a step's model faced; the evidence is the value of a row."""
    found = result.discrepancy
    if not found.steps:
        return ()
    following = found.steps[step + 1].added if step + 1 < len(found.steps) else ""
    rows = []
    for one in found.steps[step].ranking:
        title = one.title or result.title(one.effect)
        cells = (
            title,
            percent_text(one.evidence),
            signed_number_text(one.score, 1),
            signed_number_text(one.held_out, 1),
            sigma_text(one.sigma),
        )
        rows.append(
            TableRow(
                key=one.effect,
                cells=cells,
                is_bold=one.effect == following,
                detail=f"{title} ({one.effect})",
                value=one.evidence,
            )
        )
    return tuple(rows)


def describe_ranking(result: SearchResult, step: int) -> str:
    """Return who won the competition, over whom, and by how much."""
    found = result.discrepancy
    rows = found.steps[step].ranking if found.steps else ()
    if not rows:
        return tr("No candidate: this model leaves no gap for an effect to close.")
    effect = find_step_effect(result, step + 1)
    if effect is None:
        best = rows[0]
        return tr(
            "No further effect is proven. Best remaining candidate: “{title}”, with "
            "{evidence} of the evidence."
        ).format(title=best.title, evidence=percent_text(best.evidence))
    return f"“{effect.title}” – {effect_confidence_text(result, effect)}."


def describe_runner_up(result: SearchResult, effect: FoundEffect) -> str:
    """Return the runner-up of an effect and the margin over it."""
    if not effect.runner_up:
        return tr("No other candidate is close.")
    margin = number_text(effect.margin, 1)
    return tr("Second: “{title}”, behind by {margin}.").format(
        title=result.title(effect.runner_up), margin=margin
    )


def find_step_effect(result: SearchResult, step: int) -> FoundEffect | None:
    """Return the effect that a step added."""
    steps = result.discrepancy.steps
    if not 0 < step < len(steps):
        return None
    added = steps[step].added
    return next((one for one in result.discrepancy.effects if one.effect == added), None)


def describe_effect(result: SearchResult, effect: str) -> tuple[str, tuple[tuple[str, str], ...]]:
    """Return the equation of an effect, and what is known of it as headings with sentences."""
    note = result.effect_infos.get(effect)
    seen = next((one for one in result.discrepancy.observability if one.effect == effect), None)
    paragraphs: list[tuple[str, str]] = []
    alike = [tr("{title} ({percent} alike here)").format(
                 title=result.title(name), percent=percent_text(abs(cosine)))
             for name, cosine in (seen.aliases if seen is not None else ())]  # fmt: skip
    if alike:
        paragraphs.append((tr("Looks the same in these flights as"), join_with_and(alike)))
    if note is not None and note.mistaken_for:
        others = join_with_and(result.title(name) for name in note.mistaken_for)
        paragraphs.append((tr("Mistaken for"), others))
    text = seen.fly if seen is not None and seen.fly else ""
    if note is not None and note.distinguished_by and note.distinguished_by != text:
        text = f"{text}; {note.distinguished_by}" if text else note.distinguished_by
    if text:
        paragraphs.append((tr("Maneuver that separates them"), text))
    if note is not None and note.remedy:
        paragraphs.append((tr("Ground measurement"), note.remedy))
    if seen is not None:
        paragraphs.append(
            (
                tr("Observable in these flights?"),
                tr("A plausible size shows {observability}").format(
                    observability=observability_text(seen.sigma)
                ),
            )
        )
    found = next((one for one in result.discrepancy.effects if one.effect == effect), None)
    equation = found.equation if found is not None else (note.equation if note is not None else "")
    return equation, tuple(paragraphs)


def build_observability_rows(result: SearchResult, *, hidden_only: bool) -> tuple[TableRow, ...]:
    """Return what these flights could show, the least visible first."""
    table = sorted(result.discrepancy.observability, key=lambda one: one.sigma)
    return tuple(
        TableRow(
            key=one.effect,
            cells=(
                result.title(one.effect),
                # What merely rescales coefficients no maneuver shows.
                tr("on the ground only")
                if one.effect_class == "C"
                else observability_text(one.sigma),
                one.fly or _alias_text(result, one),
            ),
            state="caution" if one.sigma < DISPLAY.min_observable_sigmas else "plain",
            colored=frozenset({1}),
            detail=tr("{effect}, class {effect_class}. {alias}")
            .format(
                effect=one.effect, effect_class=one.effect_class, alias=_alias_text(result, one)
            )
            .strip(),
        )
        for one in table
        if not hidden_only or one.sigma < DISPLAY.min_observable_sigmas
    )


def _alias_text(result: SearchResult, one: Observability) -> str:
    if not one.aliases:
        return ""
    name, cosine = one.aliases[0]
    return tr("looks like {title} ({percent})").format(
        title=result.title(name), percent=percent_text(abs(cosine))
    )


def build_alternative_rows(result: SearchResult, system: str) -> tuple[tuple[str, str, str], ...]:
    """Return title, reason and remedy of what these flights would look the same with."""
    return tuple(
        (one.title, convert_text_units(one.why, system), convert_text_units(one.fly, system))
        for one in result.discrepancy.alternatives
    )


# --- Add ----------------------------------------------------------------------------------------


def build_effect_status_rows(result: SearchResult, step: int) -> tuple[TableRow, ...]:
    """Return the effects on the way with where each stands, then those that were refused."""
    rows = []
    for place, one in enumerate(result.discrepancy.steps[1:], start=1):
        text = (
            tr("in the model")
            if place <= step
            else tr("next")
            if place == step + 1
            else tr("later")
        )
        if one.added in result.request.forced:
            text += tr(", forced")
        cells = (str(place), result.title(one.added), text)
        rows.append(TableRow(key=one.added, cells=cells, is_bold=place <= step, detail=one.added))
    rows += [
        TableRow(
            key=name, cells=(DASH, result.title(name), tr("refused")), italic=True, detail=name
        )
        for name in result.request.refused
    ]
    return tuple(rows)


def build_parameter_rows(
    result: SearchResult, effect: str, system: str
) -> tuple[tuple[str, str], ...]:
    """Return name and value of each parameter of a found effect."""
    found = next((one for one in result.discrepancy.effects if one.effect == effect), None)
    note = result.effect_infos.get(effect)
    if found is None:
        return ()
    units = note.units if note is not None else {}
    return tuple(
        (name, parameter_text(value, std, units.get(name, ""), system))
        for name, (value, std) in found.parameters.items()
    )


def build_changed_value_rows(result: SearchResult) -> tuple[TableRow, ...]:
    """Return the derivatives that moved beyond their bounds."""
    lines = []
    for name, one in result.discrepancy.values.items():
        moved = (one.after - one.before) / one.std if one.std > 0 else float("nan")
        lines.append(
            TableRow(
                key=name,
                cells=(
                    symbol_text(name),
                    value_to_std_digits(one.before, one.std),
                    f"{value_to_std_digits(one.after, one.std)} ± "
                    f"{value_to_std_digits(one.std, one.std)}",
                    sigma_text(abs(moved)),
                ),
            )
        )
    return tuple(lines)


# --- Show ---------------------------------------------------------------------------------------


def build_gap_rows(result: SearchResult, system: str) -> tuple[TableRow, ...]:
    """Return the numbers of each channel: RMS, percent of range, Theil, share in tolerance."""
    return tuple(
        TableRow(key=name, cells=(channel_symbol(name), *_format_gap_cells(name, one, system)))
        for name, one in result.discrepancy.gap.channels.items()
    )


def _format_gap_cells(name: str, one: ChannelGap, system: str) -> tuple[str, ...]:
    zero, before, after, floor = (
        float(value)
        for value in to_display_units(
            name, np.array([0.0, one.before, one.after, one.floor]), system
        )
    )
    decimals = max(len(f"{abs(floor - zero):.1g}".partition(".")[2]) + 1, 1)

    def rms(value: float) -> str:
        return number_text(value - zero, min(decimals, 5))

    def shares(first: float, second: float, digits: int) -> str:
        return f"{number_text(first, digits)}{ARROW}{number_text(second, digits)}{NO_BREAK_SPACE}%"

    return (
        f"{rms(before)}{ARROW}{rms(after)}{NO_BREAK_SPACE}{axis_unit(name, system)}".rstrip(),
        rms(floor),
        shares(one.before_pct, one.after_pct, 1),
        f"{number_text(one.theil_before, 3)}{ARROW}{number_text(one.theil_after, 3)}",
        shares(100 * one.within_before, 100 * one.within_after, 0),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceableEffect:
    """One effect that can be forced."""

    effect: str
    title: str
    reason: str = ""


def list_forceable_effects(result: SearchResult, step: int) -> tuple[ForceableEffect, ...]:
    """Return the effects that are not in the model, the best candidates first, then the catalog."""
    found = result.discrepancy
    there = {one.added for one in found.steps}
    ranked = found.steps[step].ranking if found.steps else ()
    choices = {
        one.effect: ForceableEffect(
            effect=one.effect,
            title=one.title,
            reason=tr("{evidence} of the evidence, size {sigma}").format(
                evidence=percent_text(one.evidence), sigma=sigma_text(one.sigma)
            ),
        )
        for one in ranked
        if one.effect not in there
    }
    for name, note in result.effect_infos.items():
        if name not in there and name not in choices:
            choices[name] = ForceableEffect(effect=name, title=note.title)
    return tuple(choices.values())
