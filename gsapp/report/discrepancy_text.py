"""The answer of a search for a missing effect in words and rows: for the screen, HTML and paper."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from gsapp.discrepancy.effect_catalog import find_effect
from gsapp.discrepancy.results import (
    Alternative,
    ChangedValue,
    DecidingExperiment,
    Disagreement,
    DiscrepancyResult,
    FoundEffect,
    Gap,
)
from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from gsapp.flight.cards import TestCard
from gsapp.foundation import UnknownNameError
from gsapp.quantities import (
    SURFACE_NAMES,
    FloatArray,
    channel,
    clock_text,
    convert_value_and_std,
    from_si,
)

HEADLINES = {
    "effects-found": "The model lacks a named effect.",
    "values-wrong": "The model structure is adequate with wrong values; refit them.",
    "model-adequate": "The model is adequate: residuals are noise.",
    "ambiguous": "The model lacks an effect that these flights cannot distinguish.",
    "unexplained": "The model lacks an effect that is not in the catalog.",
    "not-observable": "These flights cannot show whether the model lacks an effect.",
}
"""What each verdict means, as a sentence."""

_VISIBLE_MISFIT = 1.05
"""Residual of all channels over the noise floor from which something is left, said so."""
_CLASSES = {
    "A": "seen even when all derivatives are free",
    "B": "seen by kinematics",
    "C": "seen only against trusted values",
}


def coefficient_label(coefficient: str) -> str:
    """Return "pitching moment (Cm)"."""
    text = COEFFICIENT_TITLES.get(coefficient)
    return f"{text} ({coefficient})" if text else coefficient


def effect_class_text(effect_class: str) -> str:
    """Return what the class of an effect means."""
    return _CLASSES[effect_class]


def experiment_text(one: DecidingExperiment, system: str) -> str:
    """Return what to fly next and what it will show, in one or two sentences."""
    inputs = _joined([_card_text(card, system) for card in one.cards])
    if one.purpose == "show":
        goal = (
            f"{len(one.effects)} effects of typical size exceed the noise by {one.separation:.1f} "
            f"standard deviations or more, now {one.separation_now:.1f}"
        )
        start = f"Fly {inputs}"
    else:
        first, *others = (f"“{title}”" for title in one.titles)
        rest = _joined(others) if len(others) < 3 else f"{len(others)} others"
        goal = f"this separates {first} from {rest} by {one.separation:.1f} standard deviations"
        start = f"To decide, fly {inputs}"
    if one.decides:
        return f"{start}: {goal}."
    return (
        f"No few maneuvers are sure to decide. The best are {inputs}: {goal}; {one.target:.0f} are "
        "wanted."
    )


def _joined(parts: Sequence[str]) -> str:
    *first, last = parts
    return f"{', '.join(first)} and {last}" if first else last


def _card_text(card: TestCard, system: str) -> str:
    """Return "two elevator doublets of 4.5 deg at 85 ft/s, flap 20 deg"."""
    spec = channel("V")
    unit = spec.display_unit(system)
    name = " and ".join(SURFACE_NAMES[surface] for surface in card.surfaces)
    shape = f"{card.kind} input" if card.kind[0].isdigit() else card.kind
    sizes = " and ".join(
        f"{from_si(size, 'deg', 'angle'):.3g}" for size in card.amplitudes.values()
    )
    text = (
        f"{card.repeats} {name} {shape}{'s' if card.repeats > 1 else ''} of {sizes} deg at "
        f"{from_si(card.speed, unit, spec.quantity):.0f} {unit}"
    )
    if card.flap:
        text += f" with flap {from_si(card.flap, 'deg', 'angle'):.0f} deg"
    if card.throttle_step:
        text += f", then {100.0 * card.throttle_step:+.0f} % throttle"
    return text


def closed_gap_text(found: DiscrepancyResult) -> str:
    """Return how much of the reducible gap was closed, as a sentence."""
    gap = found.gap
    where = f"maneuver{'s' if len(gap.on) != 1 else ''} {', '.join(gap.on)}"
    if not gap.on:
        return "No maneuver was held out: the model is not validated on new data."
    if gap.closed is None and found.effects:
        return f"On {where} (held out) the gap is too small to tell which share was closed."
    if gap.closed is None:
        return "No effect was added to close a gap."
    if gap.closed < 0.0:
        return f"On {where} (held out) the gap has not shrunk."
    left = found.steps[-1].misfit
    rest = (
        f" What no candidate explains is left: residuals {left:.2f} times the noise floor."
        if left > _VISIBLE_MISFIT
        else ""
    )
    digits = 0 if gap.closed_std is None or gap.closed_std > 0.0095 else 1
    spread = "" if gap.closed_std is None else f" ± {100.0 * gap.closed_std:.{digits}f}"
    share = f"{100.0 * gap.closed:.{digits}f}{spread} %"
    if gap.closed > 0.999 and gap.closed_std is not None and gap.closed_std < 0.001:
        share = "more than 99.9 %"
    return f"On {where} (held out) {share} of the gap was closed.{rest}"


def alternative_groups(found: DiscrepancyResult) -> tuple[tuple[Alternative, ...], ...]:
    """Return the alternatives in sets: of each effect that stands for one, and of what is left."""
    sets = [set(one.one_of) for one in found.effects if one.one_of]
    grouped = [
        tuple(other for other in found.alternatives if set(other.effects) <= own) for own in sets
    ]
    rest = tuple(
        other for other in found.alternatives if not any(set(other.effects) <= own for own in sets)
    )
    return tuple(group for group in (*grouped, rest) if group)


def residual_remarks(found: DiscrepancyResult) -> tuple[str, ...]:
    """Return what to know of residuals and their noise, as sentences."""
    remarks = []
    if found.disturbance.get("gust"):
        remarks.append(
            "Simulations fly in still air: what the gusts did to the aircraft is in these "
            "residuals."
        )
    if any(one.floor_is_bound for one in found.gap.channels.values()):
        remarks.append(
            "≤: the record shows less noise than an instrument should have; even small "
            "errors of a model are many times that."
        )
    return tuple(remarks)


def disturbance_text(found: DiscrepancyResult) -> str:
    """Return what is said of gusts; empty where there were none."""
    gust = found.disturbance.get("gust")
    if not gust:
        return ""
    std = found.disturbance.get("gust_std")
    spread = "" if std is None or std < 0.005 else f" ± {std:.2f}"
    return (
        f"The air was not calm: gusts of {gust:.2f}{spread} m/s (rms). They are a disturbance, "
        "not a model effect."
    )


def disagreement_sentence(one: Disagreement) -> str:
    """Return where one disagreement is, as a sentence."""
    times = one.rms / one.noise_floor if one.noise_floor > 0.0 else math.inf
    region = f", {one.region.words}" if one.region else ""
    start, end = (clock_text(time, decimals=1) for time in (one.t_start, one.t_end))
    where = f"Maneuver {one.maneuver}, {start} to {end}{region}"
    if not one.coefficient:
        return f"{where}: the instrument of {one.channel} is off by {times:.1f} times the noise."
    return (
        f"{where}: the {coefficient_label(one.coefficient)} is off by {times:.1f} times the "
        f"noise, most in {one.channel}."
    )


def format_p_value(p_value: float) -> str:
    """Return a probability without more digits than it earns."""
    if not math.isfinite(p_value):
        return ""
    return (
        "< 1e-12" if p_value < 1e-12 else f"{p_value:.1e}" if p_value < 0.01 else f"{p_value:.2f}"
    )


def effect_text(one: FoundEffect, system: str) -> str:
    """Return what was found, with its size and how sure that is, as a sentence."""
    sizes = ", ".join(
        " ".join(filter(None, (f"{name} = {size}", unit)))
        for _, name, size, unit in parameter_rows((one,), system)
    )
    sure = format_confidence(one)
    if one.named and not one.forced:
        sure = f"confidence {sure}"
    return f"{one.title[:1].upper()}{one.title[1:]} ({one.effect}): {sizes}; {sure}."


def format_confidence(one: FoundEffect) -> str:
    """Return the confidence in an effect, in percent; never a certainty, none without a name."""
    if one.forced:
        return "forced"
    if not one.named:
        return "not understood"
    others = [name for name in one.one_of if name != one.effect]
    alone = f"{100.0 * one.confidence:.0f} %"
    return f"{alone}; cannot be distinguished from {', '.join(others)}" if one.one_of else alone


def gain_text(gain: float) -> str:
    """Return a gain in log-likelihood with its sign, no more digits than matter."""
    return f"{gain:+.0f}" if abs(gain) >= 100.0 else f"{gain:+.1f}"


def probability_text(evidence: float) -> str:
    """Return a probability among candidates, in percent; never none and never all."""
    if evidence > 0.999:
        return "> 99.9 %"
    return "< 0.1 %" if evidence < 0.001 else f"{100.0 * evidence:.1f} %"


def value_with_std(value: float, std: float | None) -> str:
    """Return a value and its standard deviation, as many digits as the latter earns (two)."""
    if not math.isfinite(value):
        return "unknown"
    if std is None or not math.isfinite(std) or std <= 0.0:
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(std)))
    if digits > 6:
        return f"{value:.3g} ± {std:.1g}"
    return f"{value:.{digits}f} ± {std:.{digits}f}"


def parameter_unit(effect: str, parameter: str) -> str:
    """Return the SI unit of a parameter; empty for pure numbers and what is not in the catalog."""
    try:
        known = find_effect(effect)
    except UnknownNameError:
        return ""
    return next((one.unit for one in known.parameters if one.name == parameter), "")


def parameter_rows(
    effects: Sequence[FoundEffect], system: str
) -> tuple[tuple[str, str, str, str], ...]:
    """Return effect, parameter, value with spread, unit, in the units of a system."""
    rows = []
    for one in effects:
        for name, (value, std) in one.parameters.items():
            shown, spread, unit = convert_value_and_std(
                value, std, parameter_unit(one.effect, name), system
            )
            rows.append((one.effect, name, value_with_std(shown, spread), unit))
    return tuple(rows)


def rms_rows(gap: Gap, units: Literal["US", "SI"]) -> tuple[tuple[str, str, str, str], ...]:
    """Return channel with unit, RMS before, after, and of the noise, in the units of display."""
    rows = []
    for name, one in gap.channels.items():
        spec = channel(name)
        unit = spec.display_unit(units)
        zero = from_si(0.0, unit, spec.quantity)
        before, after, floor = (
            f"{from_si(value, unit, spec.quantity) - zero:.3g}"
            for value in (one.before, one.after, one.floor)
        )
        if one.floor_is_bound:
            floor = f"≤ {floor}"
        rows.append((f"{name} [{unit}]" if unit else name, before, after, floor))
    return tuple(rows)


def change_text(value: ChangedValue) -> str:
    """Return by how many standard deviations a derivative moved."""
    return f"{(value.after - value.before) / value.std:+.1f}" if value.std > 0.0 else ""


def residual_map(found: DiscrepancyResult, step: int) -> FloatArray:
    """Return measured less computed of each channel over its noise floor, RMS, under one model.

    Returns
    -------
    ndarray, shape (n_maneuvers, n_channels)
        In the order of the answer's maneuvers and channels; NaN where a channel lacks.
    """
    sizes = np.full((len(found.maneuvers), len(found.channels)), np.nan)
    for row, view in enumerate(found.maneuvers):
        for index, name in enumerate(view.channels):
            left = view.measured[:, index] - view.computed[step][:, index]
            left = left[np.isfinite(left)]
            floor = view.noise_floor.get(name, 0.0)
            if left.size and floor > 0.0 and name in found.channels:
                column = found.channels.index(name)
                with np.errstate(over="ignore"):
                    sizes[row, column] = np.sqrt(np.mean(left**2)) / floor
    return sizes
