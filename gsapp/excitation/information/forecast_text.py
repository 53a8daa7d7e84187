"""Prospects in words: "two more rudder-aileron doublets at 105 ft/s: C_nr from 35 % to 15 %"."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

from gsapp.dynamics.model import Model
from gsapp.excitation.information.outlook import BoundReduction
from gsapp.flight.cards import TestCard
from gsapp.flight.cards.card import SURFACE_NAMES
from gsapp.quantities import from_si

_NUMBERS: Final = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_INPUTS: Final = {"3-2-1-1": "3-2-1-1 input"}
_SPEEDS: Final = {"US": "ft/s", "SI": "m/s"}
_WIDEST: Final = 1.0
"""A bound as large as its derivative says nothing yet."""


def format_derivative(name: str) -> str:
    """Return a derivative as it is written: ``C_nr``, ``C_m_alpha``."""
    family, _, variable = name.partition("_")
    joint = "" if len(variable) == 1 else "_"
    return f"C_{family[1:]}{joint}{variable}"


def describe_forecast(
    card: TestCard,
    repeats: int,
    gains: Sequence[BoundReduction],
    model: Model,
    wanted: Mapping[str, float],
    system: str = "US",
) -> str:
    """Return what some repeats of a card bring, with the derivative that gains most.

    Parameters
    ----------
    wanted : mapping of str to float
        Bounds asked for; what is below them already is not spoken of.
    system : {"US", "SI"}
    """
    count = _NUMBERS[repeats] if repeats < len(_NUMBERS) else str(repeats)
    surfaces = "-".join(SURFACE_NAMES[name] for name in card.surfaces)
    shape = _INPUTS.get(card.kind, card.kind) + ("s" if repeats > 1 else "")
    unit = _SPEEDS[system]
    speed = from_si(card.speed, unit, "speed")
    said = f"{count} more {surfaces} {shape} at {speed:.0f} {unit}"
    best = _largest_reduction(gains, model, wanted)
    if best is None:
        return said
    value = abs(model.derivative(best.name))
    after = _percent(best.bound_after / value)
    if best.bound_before is None or best.bound_before > _WIDEST * value:
        return f"{said}: {format_derivative(best.name)} to {after}"
    before = _percent(best.bound_before / value)
    return f"{said}: {format_derivative(best.name)} from {before} to {after}"


def log_bound_reduction(gain: BoundReduction, model: Model) -> float:
    """Return by how much the logarithm of a bound shrinks, from 100 % of the derivative down.

    Negative where it stays above that; minus infinity for what has no value in the model.
    """
    value = abs(model.derivative(gain.name))
    if gain.name.endswith("_0") or not value:
        return -math.inf
    begun = value if gain.bound_before is None else min(gain.bound_before, value)
    return math.log(begun / gain.bound_after)


def _largest_reduction(
    gains: Sequence[BoundReduction], model: Model, wanted: Mapping[str, float]
) -> BoundReduction | None:
    """Return the gain that says most among bounds that are still above those wanted."""
    open_ones = [
        gain
        for gain in gains
        if (gain.bound_before is None or gain.bound_before > wanted.get(gain.name, 0.0))
        and log_bound_reduction(gain, model) > 0.0
    ]
    return max(open_ones, key=lambda gain: log_bound_reduction(gain, model), default=None)


def _percent(share: float) -> str:
    percent = 100.0 * share
    digits = 0 if percent >= 9.5 else 1 if percent >= 0.95 else 2
    return f"{percent:.{digits}f} %"
