"""A fleet in a catalog: trends, and changes over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gsapp.api.result import Result, table_of, unit_system
from gsapp.flight.catalog import Catalog, ManeuverFilter
from gsapp.foundation import FlightError
from gsapp.identification.fleet.fleet_analysis import (
    FleetTrend,
    SeriesChange,
    changes_json,
    check_condition,
    date_text,
    find_changes,
    fit_trend,
    settings_remarks,
    trend_json,
)
from gsapp.identification.fleet.fleet_values import (
    check_any_value,
    check_group_key,
    list_fleet_names,
    select_fleet_values,
)
from gsapp.report.fleet_figures import change_figure, trend_figure
from gsapp.report.fleet_text import (
    effect_rows,
    group_rows,
    trend_remarks,
    trend_title,
    unknown_remarks,
    value_and_bound,
)


def trend(
    catalog: str | Path,
    name: str,
    against: str | Sequence[str],
    *,
    by: str = "airframe",
    method: str = "",
    units: str = "us",
    **wanted: Any,
) -> Result[FleetTrend]:
    """Fit a value against conditions, with random effects, as ``gsapp catalog CATALOG trend``.

    Parameters
    ----------
    catalog : str or Path
        As ``--catalog`` wrote it.
    name : str
        A derivative, or the error of an instrument, as ``alpha.bias``.
    against : str or sequence of str
        Conditions before the input: channels, ``mach``, ``reynolds``, ``wing_loading`` or ``date``.
        The first one has slopes that differ between groups.
    by : str, optional
        Groups: airframe, aircraft, flight, inputs, kind, grade, year or month.
    method : str, optional
        By default that of most values.
    units : {"us", "si"}, optional
        Of tables and figure; derivatives are per radian.
    **wanted
        Which maneuvers: flight, aircraft, airframe, since, until, inputs, kind, worst_grade, text,
        and conditions (SI), as ``conditions={"V": (27.0, None)}``.

    Returns
    -------
    Result
        Tables ``effects`` (value at the mean condition, slopes), ``groups`` and ``values``; a
        figure.
    """
    system = unit_system(units)
    conditions = (against,) if isinstance(against, str) else tuple(against)
    check_group_key(by)
    for one in conditions:
        check_condition(one)
    with _opened(catalog) as store:
        found = select_fleet_values(
            store, name, ManeuverFilter(**wanted), method=method, conditions=conditions
        )
    fitted = fit_trend(found, conditions, by)
    return Result(
        summary=trend_title(fitted),
        outcome=fitted,
        content=trend_json(fitted),
        tables={
            "effects": table_of("effect value std low high", effect_rows(fitted, system)),
            "groups": table_of(f"{by} n value std slope slope_std", group_rows(fitted, system)),
            "values": table_of(
                f"flight maneuver airframe {' '.join(conditions)} value std",
                (
                    (one.flight, one.maneuver, one.airframe, *row, one.value, one.std)
                    for one, row in zip(fitted.values.values, fitted.columns.tolist(), strict=True)
                ),
            ),
        },
        figures={"trend": trend_figure(fitted, units=system)},
        remarks=(*trend_remarks(fitted, system), *settings_remarks([fitted.values])),
    )


def changes(
    catalog: str | Path,
    names: str | Sequence[str] = (),
    *,
    by: str = "airframe",
    against: str | Sequence[str] = (),
    method: str = "",
    units: str = "us",
    **wanted: Any,
) -> Result[tuple[SeriesChange, ...]]:
    """Find and date changes of values over time, as ``gsapp catalog CATALOG changes``.

    Parameters
    ----------
    catalog : str or Path
        As ``--catalog`` wrote it.
    names : str or sequence of str, optional
        Derivatives, or errors of instruments; by default all that the catalog has.
    by : str, optional
        Each group is a series of its own.
    against : str or sequence of str, optional
        Conditions whose trend is taken out first.
    method, units, **wanted
        As for `gsapp.trend`.

    Returns
    -------
    Result
        Table ``changes``: kind, date, the dates between which it lies, size (of a drift per year),
        values before and now; a figure.
    """
    system = unit_system(units)
    conditions = (against,) if isinstance(against, str) else tuple(against)
    check_group_key(by)
    with _opened(catalog) as store:
        wanted_names = (names,) if isinstance(names, str) else tuple(names)
        fleet = [
            select_fleet_values(
                store, name, ManeuverFilter(**wanted), method=method, conditions=conditions
            )
            for name in wanted_names or list_fleet_names(store)
        ]
    for one in fleet if wanted_names else ():
        check_any_value(one)
    found = find_changes([one for one in fleet if one.values], by, conditions)
    changed = sum(series.change.time is not None for series in found)
    return Result(
        summary=f"{changed} of {len(found)} series changed",
        outcome=found,
        content=changes_json(found, by),
        tables={
            "changes": table_of(
                "name group flights kind date earliest latest size std before now unit p_value",
                (_change_row(series, system) for series in found),
            )
        },
        figures={"changes": change_figure(found, units=system)},
        remarks=(*unknown_remarks(fleet), *settings_remarks(fleet)),
    )


def _change_row(one: SeriesChange, system: str) -> tuple[Any, ...]:
    change = one.change
    factor, _, unit = value_and_bound(one.name, 1.0, 0.0, system)
    dates = (change.time, change.earliest, change.latest)
    numbers = (change.size, change.size_std, change.before, change.now)
    return (
        one.name,
        one.group,
        change.n,
        change.kind,
        *(None if each is None else date_text(each) for each in dates),
        *(None if each is None else factor * each for each in numbers),
        unit or "per radian",
        change.p_value,
    )


def _opened(catalog: str | Path) -> Catalog:
    if not Path(catalog).is_file():
        raise FlightError(f"there is no catalog {catalog}; gsapp maneuvers --catalog makes one")
    return Catalog(catalog)
