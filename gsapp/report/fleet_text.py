"""Trends, groups and changes of a fleet as rows of tables, in the user's units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from gsapp.flight.catalog.derived_conditions import condition_quantity
from gsapp.identification.fleet.change_detection import ChangeKind
from gsapp.identification.fleet.fleet_analysis import (
    FleetTrend,
    SeriesChange,
    condition_unit,
    date_text,
    value_unit,
)
from gsapp.identification.fleet.fleet_values import DATE, FleetValues
from gsapp.identification.fleet.mixed_model import EffectEstimate
from gsapp.identification.fleet.settings import FLEET
from gsapp.quantities import FloatArray, channel, convert_value_and_std, from_si, to_si

KIND_TEXTS: Final[dict[ChangeKind, str]] = {
    "step": "step",
    "drift": "drift",
    "step-or-drift": "step or drift",
    "none": "none",
    "unknown": f"unknown: fewer than {FLEET.min_flights} flights",
}

_PLURALS: Final = {"aircraft": "aircraft", "inputs": "inputs"}


def display_condition_unit(name: str, units: str) -> str:
    """Return the unit in which a condition is shown; empty for none."""
    if name == "wing_loading":
        return "Pa" if units == "SI" else "lbf/ft^2"
    si = condition_unit(name)
    return channel(name).display_unit(units) if si and name != DATE else si


def display_condition(name: str, values: FloatArray, units: str) -> FloatArray:
    """Return SI values of a condition in the unit in which it is shown."""
    if name == DATE or not condition_unit(name):
        return values
    unit = display_condition_unit(name, units)
    return np.asarray(from_si(values, unit, condition_quantity(name)))


def slope_factor(name: str, units: str) -> float:
    """Return what a slope per SI unit is multiplied by to be one per unit shown."""
    if name == DATE or not condition_unit(name):
        return 1.0
    unit, quantity = display_condition_unit(name, units), condition_quantity(name)
    return float(to_si(1.0, unit, quantity) - to_si(0.0, unit, quantity))


def value_and_bound(name: str, value: float, std: float, units: str) -> tuple[float, float, str]:
    """Return a value of a fleet and its bound as shown, and the unit; empty: per radian."""
    return convert_value_and_std(value, std, value_unit(name), units)


def trend_title(trend: FleetTrend) -> str:
    """Return what was fitted, in words."""
    found = trend.values
    method = f", {found.method}" if found.method else ""
    return (
        f"{found.name} against {', '.join(trend.conditions)}, by {trend.by}: "
        f"{len(found.values)} values of {found.flights} flights{method}"
    )


def effect_rows(trend: FleetTrend, units: str) -> Iterator[tuple[str, float, float, float, float]]:
    """Yield name, value, standard error and both ends of the interval of each effect."""
    name = trend.values.name
    at = ", ".join(_condition_text(key, one, units) for key, one in trend.fit.reference.items())
    unit = value_and_bound(name, 0.0, 0.0, units)[2]
    shown = f"{name} [{unit}]" if unit else name
    yield (f"{shown} at {at}", *_effect(name, trend.fit.intercept, 1.0, units))
    for key, one in trend.fit.slopes.items():
        per = display_condition_unit(key, units)
        yield (
            f"slope per {per or 'unit'} of {key}",
            *_effect(name, one, slope_factor(key, units), units),
        )


def _condition_text(name: str, value: float, units: str) -> str:
    if name == DATE:
        return date_text(value)
    unit = display_condition_unit(name, units)
    shown = display_condition(name, np.array([value]), units)
    return f"{name} {float(shown[0]):.4g} {unit}".rstrip()


def _effect(
    name: str, one: EffectEstimate, factor: float, units: str
) -> tuple[float, float, float, float]:
    value, std, _ = value_and_bound(name, factor * one.value, factor * one.std, units)
    low, high, _ = value_and_bound(name, factor * one.low, factor * one.high, units)
    return value, std, low, high


def group_rows(
    trend: FleetTrend, units: str
) -> Iterator[tuple[str, int, float, float, float | None, float | None]]:
    """Yield name, values, value at the reference with bound, slope with bound of each group."""
    name = trend.values.name
    factor = slope_factor(trend.conditions[0], units)
    for group, one in trend.fit.groups.items():
        value, std, _ = value_and_bound(name, one.intercept, one.intercept_std, units)
        if one.slope is None or one.slope_std is None:
            yield group, one.n, value, std, None, None
            continue
        slope = value_and_bound(name, factor * one.slope, factor * one.slope_std, units)
        yield group, one.n, value, std, slope[0], slope[1]


def trend_remarks(trend: FleetTrend, units: str) -> list[str]:
    """Return sentences on what scatters, and what was left out."""
    fit, name = trend.fit, trend.values.name

    def shown(std: float) -> str:
        found, _, unit = value_and_bound(name, std, 0.0, units)
        return f"{found:.2g} {unit}".rstrip()

    groups = _PLURALS.get(trend.by, f"{trend.by}s")
    scatter = [f"{shown(fit.intercept_std)} between {groups}"] if len(fit.groups) > 1 else []
    if fit.slope_std is not None:
        factor = slope_factor(trend.conditions[0], units)
        scatter.append(f"{shown(factor * fit.slope_std)} between their slopes")
    if fit.flight_std is not None:
        scatter.append(f"{shown(fit.flight_std)} between flights")
    scatter.append(f"{shown(fit.residual_std)} between maneuvers beyond their bounds")
    remarks = [f"standard deviations: {', '.join(scatter)}"]
    if len(fit.groups) > 1 and fit.slope_std is None:
        remarks.append(
            f"one slope for all: fewer than {FLEET.min_slope_groups} {groups} show their own"
        )
    if not fit.converged:
        remarks.append("the standard deviations are not certain: searches for them disagree")
    if trend.lacking:
        remarks.append(f"{trend.lacking} values without the condition were left out")
    return [*remarks, *unknown_remarks([trend.values])]


def unknown_remarks(fleet: Sequence[FleetValues]) -> list[str]:
    """Return sentences on maneuvers that gave no value."""
    return [
        f"{one.name} is unknown in {one.unknown} of {one.unknown + len(one.values)} maneuvers: "
        "not excited enough, or correlated with others; they are left out"
        for one in fleet
        if one.unknown
    ]


CHANGE_COLUMNS: Final = (
    "", "group", "flights", "change", "date", "between", "size", "bound", "before", "now", "p",
)  # fmt: skip


def change_row(one: SeriesChange, units: str) -> tuple[str, ...]:
    """Return a change as the cells under `CHANGE_COLUMNS`."""
    found = one.change
    p_value = "" if found.p_value is None else f"{found.p_value:.2g}"
    head = (one.name, one.group, str(found.n), KIND_TEXTS[found.kind])
    if found.time is None or found.earliest is None or found.latest is None:
        return (*head, "", "", "", "", "", "", p_value)
    size, bound = "", ""
    if found.size is not None and found.size_std is not None:
        value, std, unit = value_and_bound(one.name, found.size, found.size_std, units)
        per = "/year" if found.kind == "drift" else ""
        size, bound = f"{value:+.3g} {unit}{per}".rstrip(), f"{std:.2g}"
    before, now, _ = value_and_bound(one.name, found.before or 0.0, found.now or 0.0, units)
    return (
        *head,
        date_text(found.time),
        f"{date_text(found.earliest)} - {date_text(found.latest)}",
        size,
        bound,
        f"{before:.4g}",
        f"{now:.4g}",
        p_value,
    )
