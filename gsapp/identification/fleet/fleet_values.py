"""Values of a catalog that questions to a fleet are asked of: one for each maneuver."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, Final

import numpy as np

from gsapp.flight.catalog import Catalog, ManeuverFilter
from gsapp.flight.catalog.queries import AIRFRAME_COLUMN, MANEUVER_TABLES, NOT_DELETED
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.identification.campaign import weighted_mean
from gsapp.identification.summary.campaign_summary import paule_mandel_std
from gsapp.quantities import FloatArray

GROUP_KEYS: Final = (
    "airframe", "aircraft", "flight", "inputs", "kind", "grade", "year", "month",
)  # fmt: skip
"""What values are grouped by."""
DATE: Final = "date"
"""Stands among conditions for the date of the flight, in years."""
SECONDS_PER_YEAR: Final = 31_557_600
"""Of a Julian year."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetManeuver:
    """What a maneuver of a fleet is grouped by."""

    flight: str
    maneuver: str  # Empty for the error of an instrument, which belongs to a flight.
    airframe: str
    aircraft: str
    inputs: str
    kind: str
    grade: str
    time: float | None  # Date of the flight, s since 1970 UTC.

    def key(self, name: str) -> str:
        """Return what it has in common with others of a group; see `GROUP_KEYS`."""
        if name in ("year", "month"):
            if self.time is None:
                return ""
            date = datetime.fromtimestamp(self.time, UTC)
            return f"{date:%Y}" if name == "year" else f"{date:%Y-%m}"
        return str(getattr(self, name))


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetValue(FleetManeuver):
    """One value of one derivative, or of one instrument's error."""

    value: float
    std: float
    """Per radian about the CG of the aircraft file; of an instrument SI."""
    conditions: Mapping[str, float] = field(default_factory=dict)  # Before the input, SI.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FleetValues:
    """The values that fit, and what was left out."""

    name: str
    method: str  # Empty for an instrument's error.
    values: tuple[FleetValue, ...]
    unknown: int = 0  # Maneuvers that did not excite it, or not apart from others.
    settings: int = 1  # In how many ways the fits were made.

    @property
    def flights(self) -> int:
        return len({one.flight for one in self.values})

    def arrays(self) -> tuple[FloatArray, FloatArray]:
        """Return values and bounds, shapes (n,)."""
        return (
            np.array([one.value for one in self.values]),
            np.array([one.std for one in self.values]),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupMean:
    """The mean of a group of values."""

    group: str
    mean: float
    std: float
    """Standard error; what maneuvers and flights scatter beyond their bounds counts."""
    scatter: float | None  # Standard deviation from flight to flight; None for one flight.
    n: int
    flights: int


_FACTS: Final = f"""m.id, m.name AS maneuver, m.kind, g.grade, f.name AS flight, f.date,
    f.aircraft, {AIRFRAME_COLUMN} AS airframe, (SELECT group_concat(i.surface, '+')
    FROM inputs i WHERE i.maneuver = m.id) AS inputs"""  # noqa: S608 - own columns


def select_fleet_maneuvers(catalog: Catalog, wanted: ManeuverFilter) -> list[FleetManeuver]:
    """Return all maneuvers that fit, by flight and time."""
    clause, values = wanted.where()
    rows = catalog.query(
        f"SELECT {_FACTS} FROM {MANEUVER_TABLES} WHERE {clause} "  # noqa: S608 - own clauses
        "ORDER BY f.name, m.t_start",
        values,
    )
    return [FleetManeuver(**_facts(row)) for row in rows]


def select_fleet_values(
    catalog: Catalog,
    name: str,
    wanted: ManeuverFilter,
    *,
    method: str = "",
    conditions: Sequence[str] = (),
) -> FleetValues:
    """Return the values of a derivative or of an instrument's error, by flight and time.

    A maneuver has one value: that of its latest fit by the method. Joint fits, values that were
    held and those of runs that were forgotten are no values.

    Parameters
    ----------
    name : str
        ``Cm_alpha``; ``alpha.bias``.
    method : str, optional
        By default that of most values: different methods have different errors.
    conditions : sequence of str, optional
        Conditions to return with each value.

    Raises
    ------
    UnknownNameError
        If the catalog has no such value.
    """
    clause, values = wanted.where()
    rows = catalog.query(
        f"""SELECT {_FACTS}, r.method, r.settings, r.converged, r.model, e.value, e.std, e.status
        FROM {MANEUVER_TABLES} JOIN run_maneuvers rm ON rm.maneuver = m.id
        JOIN runs r ON r.id = rm.run JOIN estimates e ON e.run = r.id AND e.name = ?
        WHERE {clause} AND {NOT_DELETED} AND e.status <> 'held'
        AND NOT EXISTS (SELECT 1 FROM run_maneuvers o WHERE o.run = r.id AND o.maneuver <> m.id)
        ORDER BY f.name, m.t_start, r.id""",  # noqa: S608 - own clauses
        (name, *values),
    )
    if not rows:
        return _instrument_values(catalog, name, clause, values, conditions)
    used = method or Counter(row["method"] for row in rows).most_common(1)[0][0]
    latest = {row["id"]: row for row in rows if row["method"] == used}
    if not latest:
        known = sorted({row["method"] for row in rows})
        raise UnknownNameError(
            f"{catalog.path} has no values of {name} by {used}; there are those by "
            f"{', '.join(known)}"
        )
    earned = [row for row in latest.values() if _is_earned(row)]
    held = _conditions_of(catalog, [row["id"] for row in earned], conditions)
    return FleetValues(
        name=name,
        method=used,
        values=tuple(_value(row, held.get(row["id"], {})) for row in earned),
        unknown=len(latest) - len(earned),
        settings=len({(row["settings"], row["model"]) for row in earned}) or 1,
    )


def _is_earned(row: Any) -> bool:
    return bool(
        row["status"] == "estimated"
        and row["converged"]
        and row["value"] is not None
        and row["std"] is not None
    )


def _value(row: Any, conditions: Mapping[str, float]) -> FleetValue:
    return FleetValue(**_facts(row), value=row["value"], std=row["std"], conditions=conditions)


def _facts(row: Any) -> dict[str, Any]:
    date = row["date"]
    plain = ("flight", "maneuver", "airframe", "aircraft", "kind", "grade")
    return {
        **{key: row[key] for key in plain},
        "inputs": row["inputs"] or "none",
        "time": datetime.fromisoformat(date).timestamp() if date else None,
    }


def _conditions_of(
    catalog: Catalog, maneuvers: Sequence[int], names: Sequence[str]
) -> dict[int, dict[str, float]]:
    found: dict[int, dict[str, float]] = {}
    wanted = [one for one in names if one != DATE]
    if wanted:
        for row in catalog.query(
            """SELECT maneuver, channel, mean FROM conditions
            WHERE maneuver IN (SELECT value FROM json_each(?))
            AND channel IN (SELECT value FROM json_each(?))""",
            (json.dumps(maneuvers), json.dumps(wanted)),
        ):
            found.setdefault(row["maneuver"], {})[row["channel"]] = row["mean"]
    return found


def _instrument_values(
    catalog: Catalog, name: str, clause: str, values: Sequence[Any], conditions: Sequence[str]
) -> FleetValues:
    """Return the errors of an instrument, one for each flight, with its mean conditions."""
    rows = catalog.query(
        f"""SELECT f.id, f.name AS flight, f.date, f.aircraft, {AIRFRAME_COLUMN} AS airframe,
            '' AS maneuver, '' AS inputs, '' AS kind, '' AS grade, 1 AS converged,
            i.value, i.std, i.status
        FROM instrument_errors i JOIN flights f ON f.id = i.flight
        WHERE i.name = ? AND f.id IN (SELECT m.flight FROM {MANEUVER_TABLES} WHERE {clause})
        ORDER BY f.name""",  # noqa: S608 - own clauses
        (name, *values),
    )
    if not rows:
        _check_name(catalog, name)
    held: dict[int, dict[str, float]] = {}
    for row in catalog.query(
        """SELECT m.flight, c.channel, avg(c.mean) AS mean FROM conditions c
        JOIN maneuvers m ON m.id = c.maneuver WHERE m.stands = 1
        AND c.channel IN (SELECT value FROM json_each(?)) GROUP BY m.flight, c.channel""",
        (json.dumps(list(conditions)),),
    ):
        held.setdefault(row["flight"], {})[row["channel"]] = row["mean"]
    earned = [row for row in rows if _is_earned(row)]
    return FleetValues(
        name=name,
        method="",
        values=tuple(_value(row, held.get(row["id"], {})) for row in earned),
        unknown=len(rows) - len(earned),
    )


def _check_name(catalog: Catalog, name: str) -> None:
    known = list_fleet_names(catalog)
    if name not in known:
        hint = did_you_mean(name, known, f"it has {', '.join(known[:12]) or 'none'}")
        raise UnknownNameError(f"{catalog.path} has no values of '{name}'; {hint}")


def list_fleet_names(catalog: Catalog) -> list[str]:
    """Return the names of the derivatives and instrument errors that a catalog has values of."""
    rows = catalog.query(
        """SELECT DISTINCT name FROM estimates WHERE status = 'estimated'
        UNION SELECT DISTINCT name FROM instrument_errors WHERE status = 'estimated' ORDER BY 1"""
    )
    return [row["name"] for row in rows]


def check_group_key(name: str) -> None:
    """Raise `UnknownNameError` unless values can be grouped by it."""
    if name not in GROUP_KEYS:
        hint = did_you_mean(name, GROUP_KEYS, f"use one of: {', '.join(GROUP_KEYS)}")
        raise UnknownNameError(f"values are not grouped by '{name}'; {hint}")


def check_any_value(found: FleetValues) -> None:
    """Raise `FlightError` unless a maneuver that fits earned a value."""
    if not found.values:
        unknown = f"; it is unknown in all {found.unknown} of them" if found.unknown else ""
        raise FlightError(f"no maneuver that fits has a value of {found.name}{unknown}")


def condition_columns(found: FleetValues, names: Sequence[str]) -> tuple[FleetValues, FloatArray]:
    """Return the values that have all conditions, and these, shape (n, n_conditions).

    Raises
    ------
    FlightError
        If no value has them.
    """
    check_any_value(found)
    kept, rows = [], []
    for one in found.values:
        row = [
            (None if one.time is None else one.time / SECONDS_PER_YEAR)
            if name == DATE
            else one.conditions.get(name)
            for name in names
        ]
        if None not in row:
            kept.append(one)
            rows.append(row)
    if not kept:
        raise FlightError(
            f"no value of {found.name} has {' and '.join(names)}; store the flights again with "
            "'gsapp maneuvers --catalog', or choose another condition"
        )
    chosen = FleetValues(
        name=found.name, method=found.method, values=tuple(kept), unknown=found.unknown,
        settings=found.settings,
    )  # fmt: skip
    return chosen, np.array(rows, dtype=float).reshape(len(kept), len(names))


def mean_over_flights(values: Sequence[FleetValue]) -> tuple[float, float, float | None]:
    """Return the mean, its standard error and the scatter from flight to flight.

    First over the maneuvers of each flight, then over the flights: maneuvers of one flight share
    their errors.
    """
    by_flight: dict[str, list[FleetValue]] = {}
    for one in values:
        by_flight.setdefault(one.flight, []).append(one)
    means = np.array(
        [_mean(np.array([(v.value, v.std) for v in own])) for own in by_flight.values()]
    )
    mean, std = _mean(means)
    return mean, std, float(np.std(means[:, 0], ddof=1)) if len(means) > 1 else None


def _mean(rows: FloatArray) -> tuple[float, float]:
    values, stds = rows.T
    between = paule_mandel_std(values, stds) if len(values) > 2 else 0.0
    found = weighted_mean(values, stds, np.zeros_like(stds), between)
    return found.mean, found.std


def group_means(found: FleetValues, by: str) -> tuple[GroupMean, ...]:
    """Return the mean of each group, by its name; see `GROUP_KEYS`."""
    check_group_key(by)
    groups: dict[str, list[FleetValue]] = {}
    for one in found.values:
        groups.setdefault(one.key(by), []).append(one)
    means = []
    for name in sorted(groups):
        own = groups[name]
        mean, std, scatter = mean_over_flights(own)
        means.append(
            GroupMean(
                group=name, mean=mean, std=std, scatter=scatter, n=len(own),
                flights=len({one.flight for one in own}),
            )
        )  # fmt: skip
    return tuple(means)


def count_groups(maneuvers: Sequence[FleetManeuver], by: str) -> dict[str, tuple[int, int]]:
    """Return how many flights and maneuvers each group has, by its name; see `GROUP_KEYS`."""
    groups: dict[str, list[str]] = {}
    for one in maneuvers:
        groups.setdefault(one.key(by), []).append(one.flight)
    return {name: (len(set(groups[name])), len(groups[name])) for name in sorted(groups)}
