"""Finding maneuvers, runs and models in a catalog; a catalog for other programs."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from gsapp.flight.catalog.records import (
    CONDITION_CHANNELS,
    EstimationRun,
    FlightCondition,
    StoredEstimate,
    StoredManeuver,
)
from gsapp.flight.catalog.store import Catalog, select_where
from gsapp.flight.maneuvers.detected_maneuver import GRADES, DetectedManeuver, Grade
from gsapp.foundation import FlightError
from gsapp.foundation.delimited_text import delimited_text

NOT_DELETED: Final = """(r.kept IS NULL
    OR r.kept IN (SELECT id FROM kept_runs WHERE forgotten_at IS NULL))"""
"""Of the rows of `runs`: those that were not forgotten with the run they belong to."""
AIRFRAME_COLUMN: Final = "coalesce(nullif(f.airframe, ''), f.aircraft)"
"""Of the rows f of `flights`: the airframe, where none was named all of the aircraft are one."""
MANEUVER_TABLES: Final = """maneuvers m JOIN flights f ON f.id = m.flight
    JOIN grades g ON g.id = (SELECT max(id) FROM grades WHERE maneuver = m.id)"""
"""The maneuvers m of flights f with their latest grades g."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverFilter:
    """Which maneuvers of a catalog are wanted; None is any."""

    flight: str | None = None  # Name of the flight.
    aircraft: str | None = None  # Name of the aircraft.
    airframe: str | None = None  # Serial number; see `FlightInfo.airframe`.
    since: str | None = None
    until: str | None = None
    """First and last day of the flight, UTC: ``2026-05-12``; or less of it, ``2026-05``. A flight
    without a date does not fit."""
    inputs: Collection[str] | None = None  # Exactly these surfaces moved.
    kind: str | None = None  # ``doublet``, ``3-2-1-1`` ...
    worst_grade: Grade = "D"  # Worse ones are left out.
    conditions: Mapping[str, tuple[float | None, float | None]] = field(default_factory=dict)
    """Least and greatest mean of a channel before the input, SI: ``{"V": (27.0, 32.0)}``. A
    maneuver without that channel does not fit."""
    text: str | None = None  # Occurs in the note, whatever the case.

    def where(self) -> tuple[str, list[Any]]:
        """Return an SQL condition on `MANEUVER_TABLES`, and its values.

        Maneuvers that were replaced do not fit.
        """
        if self.worst_grade not in GRADES:
            raise FlightError(
                f"there is no grade '{self.worst_grade}'; grades are {', '.join(GRADES)}"
            )
        clause, values = select_where(
            {
                "f.name = ?": self.flight,
                "f.aircraft = ?": self.aircraft,
                f"{AIRFRAME_COLUMN} = ?": self.airframe,
                "f.date >= ?": self.since,
                "m.kind = ?": self.kind,
                "instr(lower(m.note), lower(?)) > 0": self.text,
                "g.grade <= ?": self.worst_grade,
            }
        )
        clauses = ["m.stands = 1", clause]
        if self.until is not None:  # A month holds all days that begin like it.
            clauses.append("substr(f.date, 1, ?) <= ?")
            values += [len(self.until), self.until]
        if self.inputs is not None:
            surfaces = sorted(set(self.inputs))
            marks = ", ".join("?" * len(surfaces))
            clauses.append(
                f"""(SELECT count(*) = ? AND coalesce(sum(i.surface IN ({marks})), 0) = ?
                FROM inputs i WHERE i.maneuver = m.id)"""  # noqa: S608 - question marks
            )
            values += [len(surfaces), *surfaces, len(surfaces)]
        for channel, (least, most) in self.conditions.items():
            clauses.append(
                """EXISTS (SELECT 1 FROM conditions c WHERE c.maneuver = m.id AND c.channel = ?
                AND c.mean >= coalesce(?, c.mean) AND c.mean <= coalesce(?, c.mean))"""
            )
            values += [channel, least, most]
        return " AND ".join(clauses), values


def find_maneuvers(catalog: Catalog, wanted: ManeuverFilter) -> list[int]:
    """Return the row ids of the maneuvers that fit, by flight and time; see `load_maneuvers`."""
    clause, values = wanted.where()
    rows = catalog.query(
        f"SELECT m.id FROM {MANEUVER_TABLES} WHERE {clause} "  # noqa: S608 - own clauses
        "ORDER BY f.name, m.t_start",
        values,
    )
    return [row["id"] for row in rows]


def load_maneuvers(catalog: Catalog, row_ids: Sequence[int]) -> tuple[StoredManeuver, ...]:
    """Return maneuvers of a catalog by their row ids, in their order."""
    chosen = json.dumps(list(row_ids))
    rows = catalog.query(
        f"""SELECT m.id, f.name AS flight, m.record, g.grade, g.reasons, g.given_by,
            (SELECT v.result FROM verdicts v WHERE v.flight = m.flight
            AND v.t_input >= m.t_start AND v.t_input < m.t_end ORDER BY v.t_input LIMIT 1) AS said
        FROM {MANEUVER_TABLES} WHERE m.id IN (SELECT value FROM json_each(?))""",  # noqa: S608
        (chosen,),
    )
    conditions = _conditions(catalog, chosen)
    runs = _runs_by_maneuver(catalog, chosen)
    found = {
        row["id"]: StoredManeuver(
            flight=row["flight"],
            maneuver=replace(
                DetectedManeuver.from_record(_parsed(catalog, row["record"])),
                grade=row["grade"],
                reasons=tuple(_parsed(catalog, row["reasons"])),
            ),
            conditions=conditions.get(row["id"], {}),
            graded_by=row["given_by"],
            runs=tuple(runs.get(row["id"], ())),
            verdict=row["said"] or "",
        )
        for row in rows
    }
    return tuple(found[number] for number in row_ids if number in found)


def search_maneuvers(
    catalog: Catalog, wanted: ManeuverFilter | None = None
) -> tuple[StoredManeuver, ...]:
    """Return the maneuvers that fit, by flight and time."""
    return load_maneuvers(catalog, find_maneuvers(catalog, wanted or ManeuverFilter()))


def search_runs(
    catalog: Catalog,
    *,
    method: str | None = None,
    axis: str | None = None,
    flight: str | None = None,
    derivative: str | None = None,
    kept: int | None = None,
    row_ids: Collection[int] | None = None,
) -> tuple[EstimationRun, ...]:
    """Return the estimations that fit, the oldest first; not those of runs that were forgotten.

    A maneuver of `flight` took part, `derivative` has a value, they are part of the campaign run
    of the number `kept`, and their own number is in `row_ids`.
    """
    wanted, values = select_where(
        {
            "r.kept = ?": kept,
            "r.method = ?": method,
            "r.axis = ?": axis,
            """r.id IN (SELECT rm.run FROM run_maneuvers rm JOIN maneuvers m ON m.id = rm.maneuver
            JOIN flights f ON f.id = m.flight WHERE f.name = ?)""": flight,
            "r.id IN (SELECT run FROM estimates WHERE name = ? AND value IS NOT NULL)": derivative,
            "r.id IN (SELECT value FROM json_each(?))": None
            if row_ids is None
            else json.dumps([*row_ids]),
        }
    )
    rows = catalog.query(
        f"""SELECT r.*, o.name AS model_name FROM runs r LEFT JOIN models o ON o.id = r.model
        WHERE {NOT_DELETED} AND {wanted} ORDER BY r.id""",  # noqa: S608 - own clauses
        values,
    )
    chosen = json.dumps([row["id"] for row in rows])
    maneuvers: dict[int, list[Any]] = {}
    for one in catalog.query(
        """SELECT rm.run, f.name AS flight, m.name, rm.t_start, rm.t_end FROM run_maneuvers rm
        JOIN maneuvers m ON m.id = rm.maneuver JOIN flights f ON f.id = m.flight
        WHERE rm.run IN (SELECT value FROM json_each(?)) ORDER BY f.name, m.t_start""",
        (chosen,),
    ):
        maneuvers.setdefault(one["run"], []).append(one)
    estimates: dict[int, dict[str, StoredEstimate]] = {}
    for one in catalog.query(
        """SELECT * FROM estimates WHERE run IN (SELECT value FROM json_each(?))
        ORDER BY rowid""",
        (chosen,),
    ):
        estimates.setdefault(one["run"], {})[one["name"]] = StoredEstimate(
            confounded_with=tuple(_parsed(catalog, one["confounded_with"])),
            **{key: one[key] for key in ("value", "std", "cramer_rao", "status", "why")},
        )
    return tuple(
        _run(catalog, row, maneuvers.get(row["id"], ()), estimates.get(row["id"], {}))
        for row in rows
    )


def list_estimated(catalog: Catalog) -> tuple[str, ...]:
    """Return the names of all that was estimated, in alphabetical order."""
    return tuple(
        row["name"] for row in catalog.query("SELECT DISTINCT name FROM estimates ORDER BY name")
    )


def list_flights(catalog: Catalog) -> tuple[str, ...]:
    """Return the names of the stored flights, by date and name."""
    rows = catalog.query("SELECT name FROM flights ORDER BY date IS NULL, date, name")
    return tuple(row["name"] for row in rows)


def _run(
    catalog: Catalog, row: Any, maneuvers: Sequence[Any], estimates: Mapping[str, StoredEstimate]
) -> EstimationRun:
    return EstimationRun(
        id=row["id"],
        maneuvers=tuple((one["flight"], one["name"]) for one in maneuvers),
        edges=tuple((one["t_start"], one["t_end"]) for one in maneuvers),
        campaign_run_id=row["kept"],
        estimates=estimates,
        settings=_parsed(catalog, row["settings"]),
        fit=_parsed(catalog, row["fit"]),
        model=row["model_name"],
        converged=bool(row["converged"]),
        warnings=tuple(_parsed(catalog, row["warnings"])),
        **{key: row[key] for key in ("method", "axis", "iterations", "message", "made_at")},
    )


def _conditions(catalog: Catalog, chosen: str) -> dict[int, dict[str, FlightCondition]]:
    found: dict[int, dict[str, FlightCondition]] = {}
    rows = catalog.query(
        """SELECT * FROM conditions WHERE maneuver IN (SELECT value FROM json_each(?))
        ORDER BY maneuver, rowid""",
        (chosen,),
    )
    for row in rows:
        found.setdefault(row["maneuver"], {})[row["channel"]] = FlightCondition(
            mean=row["mean"], minimum=row["least"], maximum=row["most"]
        )
    return found


def _runs_by_maneuver(catalog: Catalog, chosen: str) -> dict[int, list[int]]:
    found: dict[int, list[int]] = {}
    rows = catalog.query(
        f"""SELECT rm.maneuver, rm.run FROM run_maneuvers rm JOIN runs r ON r.id = rm.run
        WHERE rm.maneuver IN (SELECT value FROM json_each(?)) AND {NOT_DELETED}
        ORDER BY rm.run""",  # noqa: S608 - own clause
        (chosen,),
    )
    for row in rows:
        found.setdefault(row["maneuver"], []).append(row["run"])
    return found


def _parsed(catalog: Catalog, text: str) -> Any:
    if text == "[]":  # Most lists of most estimates.
        return []
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FlightError(
            f"an entry of the catalog {catalog.path} is damaged ({error}); restore a copy"
        ) from error


def maneuvers_csv(found: Sequence[StoredManeuver]) -> str:
    """Return what a search gave as CSV: one line for each maneuver, conditions as columns."""
    channels = [name for name in CONDITION_CHANNELS if any(name in one.conditions for one in found)]
    columns = ["flight", "id", "t_start", "t_end", "inputs", "kind", "amplitude", "grade"]
    columns += ["reasons", "verdict", "note", *channels]
    rows: list[Sequence[object]] = [columns]
    for one in found:
        maneuver = one.maneuver
        cells = {
            **maneuver.to_json(),
            "flight": one.flight,
            "inputs": "+".join(maneuver.inputs),
            "reasons": "; ".join(maneuver.reasons),
            "verdict": one.verdict,
            "note": maneuver.note,
            **{name: one.conditions[name].mean for name in channels if name in one.conditions},
        }
        rows.append([cells.get(column, "") for column in columns])
    return delimited_text(rows)
