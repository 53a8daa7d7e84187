"""Trends and changes of the values of a fleet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from gsapp.flight.catalog.derived_conditions import DERIVED_CONDITIONS, condition_quantity
from gsapp.foundation import FlightError
from gsapp.identification.fleet.change_detection import Change, detect_change
from gsapp.identification.fleet.fleet_values import (
    DATE,
    SECONDS_PER_YEAR,
    FleetValue,
    FleetValues,
    GroupMean,
    check_group_key,
    condition_columns,
    mean_over_flights,
)
from gsapp.identification.fleet.mixed_model import MixedModelFit, fit_mixed_model
from gsapp.quantities import FloatArray, channel


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FleetTrend:
    """A derivative against conditions, with random effects between groups."""

    values: FleetValues  # Those that have all conditions.
    lacking: int  # Values without one of the conditions.
    conditions: tuple[str, ...]
    columns: FloatArray  # Shape (n, n_conditions), SI; the date in years since 1970.
    by: str
    fit: MixedModelFit


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeriesChange:
    """What became of one value of one group over time."""

    name: str
    group: str
    change: Change  # Times in years since 1970.
    times: FloatArray  # Of the flights, in years since 1970, shape (n,).
    means: FloatArray
    stds: FloatArray
    """Of each flight, about the mean condition where the trend was taken out."""
    flights: tuple[str, ...]


def condition_unit(name: str) -> str:
    """Return the SI unit of a condition; the year for the date."""
    if name == DATE:
        return "year"
    known = DERIVED_CONDITIONS.get(name)
    return channel(name).unit if known is None else known.unit


def check_condition(name: str) -> None:
    """Raise `UnknownNameError` unless it is a condition of a trend."""
    if name != DATE:
        condition_quantity(name)


def value_unit(name: str) -> str:
    """Return the SI unit of a value: empty for a derivative, which is per radian."""
    instrument, _, kind = name.rpartition(".")
    fixed = {"scale": "", "delay": "s", "position": "m"}
    if not instrument or kind not in (*fixed, "bias"):
        return ""
    return fixed[kind] if kind in fixed else channel(instrument).unit


def fit_trend(found: FleetValues, against: Sequence[str], by: str) -> FleetTrend:
    """Fit a derivative against conditions.

    Raises
    ------
    FlightError
        If too few values have the conditions, or these do not vary.
    UnknownNameError
        If values are not grouped by `by`.
    """
    check_group_key(by)
    chosen, columns = condition_columns(found, against)
    values, stds = chosen.arrays()
    fit = fit_mixed_model(
        values,
        stds,
        dict(zip(against, columns.T, strict=True)),
        [one.key(by) for one in chosen.values],
        [one.flight for one in chosen.values],
    )
    return FleetTrend(
        values=chosen, lacking=len(found.values) - len(chosen.values), conditions=tuple(against),
        columns=columns, by=by, fit=fit,
    )  # fmt: skip


def find_changes(
    fleet: Sequence[FleetValues], by: str, against: Sequence[str] = ()
) -> tuple[SeriesChange, ...]:
    """Search the values of each group for a change over time, all series together.

    Parameters
    ----------
    against : sequence of str, optional
        Conditions whose trend over the whole fleet is taken out first: a derivative that depends
        on Mach number does not change because flights become faster.

    Raises
    ------
    FlightError
        If no flight has a date, or the trend cannot be fitted.
    """
    check_group_key(by)
    series = []
    for found in fleet:
        adjusted = _without_trend(found, against, by) if against else found.values
        groups: dict[str, list[FleetValue]] = {}
        for one in adjusted:
            if one.time is not None:
                groups.setdefault(one.key(by), []).append(one)
        series += [(found.name, group, *_by_flight(own)) for group, own in sorted(groups.items())]
    if not series:
        raise FlightError("no flight has a date; write it into flight.toml and store them again")
    return tuple(
        SeriesChange(
            name=name, group=group, times=times, means=means, stds=stds, flights=flights,
            change=detect_change(times, means, stds, series=len(series)),
        )
        for name, group, flights, times, means, stds in series
    )  # fmt: skip


def _without_trend(found: FleetValues, against: Sequence[str], by: str) -> list[FleetValue]:
    trend = fit_trend(found, [one for one in against if one != DATE], by)
    slopes = np.array([one.value for one in trend.fit.slopes.values()])
    reference = np.array(list(trend.fit.reference.values()))
    shifts = (trend.columns - reference) @ slopes
    return [
        replace(one, value=one.value - float(shift))
        for one, shift in zip(trend.values.values, shifts, strict=True)
    ]


def _by_flight(
    values: Sequence[FleetValue],
) -> tuple[tuple[str, ...], FloatArray, FloatArray, FloatArray]:
    """Return the flights in order of time, with times, means and standard errors, shape (n,)."""
    flights: dict[tuple[float, str], list[FleetValue]] = {}
    for one in values:
        flights.setdefault((one.time or 0.0, one.flight), []).append(one)
    rows = [(key, mean_over_flights(flights[key])) for key in sorted(flights)]
    return (
        tuple(name for (_, name), _ in rows),
        np.array([time / SECONDS_PER_YEAR for (time, _), _ in rows]),
        np.array([mean for _, (mean, _, _) in rows]),
        np.array([std for _, (_, std, _) in rows]),
    )


def date_text(years: float) -> str:
    """Return a time in years since 1970 as a date."""
    return f"{datetime.fromtimestamp(years * SECONDS_PER_YEAR, UTC):%Y-%m-%d}"


def trend_json(trend: FleetTrend) -> dict[str, Any]:
    """Return a trend for programs: SI, per radian; absent = None."""
    fit = trend.fit
    return {
        **_values_json(trend.values),
        "against": list(trend.conditions),
        "by": trend.by,
        "without_condition": trend.lacking,
        "reference": dict(fit.reference),
        "intercept": asdict(fit.intercept),
        "slopes": {
            name: {**asdict(one), "per": condition_unit(name) or "1"}
            for name, one in fit.slopes.items()
        },
        "groups": {name: asdict(one) for name, one in fit.groups.items()},
        "between_groups": {
            "intercept_std": fit.intercept_std,
            "slope_std": fit.slope_std,
            "correlation": fit.correlation,
        },
        "between_flights_std": fit.flight_std,
        "residual_std": fit.residual_std,
        "log_likelihood": fit.log_likelihood,
        "converged": fit.converged,
    }


def groups_json(found: FleetValues, means: Sequence[GroupMean], by: str) -> dict[str, Any]:
    """Return means by group for programs: SI, per radian; absent = None."""
    return {**_values_json(found), "by": by, "groups": [asdict(one) for one in means]}


def _values_json(found: FleetValues) -> dict[str, Any]:
    return {
        "name": found.name,
        "unit": value_unit(found.name) or "per radian",
        "method": found.method or None,
        "n": len(found.values),
        "flights": found.flights,
        "unknown": found.unknown,
        "different_settings": found.settings,
    }


def changes_json(found: Sequence[SeriesChange], by: str) -> dict[str, Any]:
    """Return changes for programs: dates, SI, drifts per year; absent = None."""

    def date(years: float | None) -> str | None:
        return None if years is None else date_text(years)

    return {
        "by": by,
        "series": [
            {
                "name": one.name,
                "unit": value_unit(one.name) or "per radian",
                "group": one.group,
                **asdict(one.change),
                **{key: date(getattr(one.change, key)) for key in ("time", "earliest", "latest")},
                "first_flight": date(float(one.times[0])),
                "last_flight": date(float(one.times[-1])),
            }
            for one in found
        ],
    }


def settings_remarks(fleet: Sequence[FleetValues]) -> list[str]:
    """Return sentences on values that may differ for another reason than the aircraft."""
    return [
        f"{one.name} was estimated with {one.settings} different settings or models; a difference "
        "may be theirs. Estimate all flights alike, or choose one run"
        for one in fleet
        if one.settings > 1
    ]
