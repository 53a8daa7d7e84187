"""Finding maneuvers, runs and models in a catalog; a catalog for other programs."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
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

_NOT_DELETED: Final = """(r.kept IS NULL
    OR r.kept IN (SELECT id FROM kept_runs WHERE forgotten_at IS NULL))"""
"""Of the rows of `runs`: those that were not forgotten with the run they belong to."""


def search_maneuvers(
    catalog: Catalog,
    *,
    flight: str | None = None,
    inputs: Collection[str] | None = None,
    kind: str | None = None,
    worst_grade: Grade = "D",
    conditions: Mapping[str, tuple[float | None, float | None]] | None = None,
    text: str | None = None,
) -> tuple[StoredManeuver, ...]:
    """Return the maneuvers that fit, by flight and time.

    Parameters
    ----------
    flight : str, optional
        Name of the flight.
    inputs : collection of str, optional
        Exactly these surfaces moved.
    kind : str, optional
        ``doublet``, ``3-2-1-1`` ...
    worst_grade : {"A", "B", "C", "D"}
        Worse ones are left out.
    conditions : mapping of str to (float or None, float or None), optional
        Least and greatest mean of a channel before the input, SI: ``{"V": (27.0, 32.0)}``. A
        maneuver without that channel does not fit.
    text : str, optional
        Occurs in the note, whatever the case.
    """
    if worst_grade not in GRADES:
        raise FlightError(f"there is no grade '{worst_grade}'; grades are {', '.join(GRADES)}")
    wanted, values = select_where(
        {
            "f.name = ?": flight,
            "m.kind = ?": kind,
            "instr(lower(m.note), lower(?)) > 0": text,
            "g.grade <= ?": worst_grade,
        }
    )
    rows = catalog.query(
        f"""SELECT m.id, f.name AS flight, m.record, g.grade, g.reasons, g.given_by,
            (SELECT v.result FROM verdicts v WHERE v.flight = m.flight
            AND v.t_input >= m.t_start AND v.t_input < m.t_end ORDER BY v.t_input LIMIT 1) AS said
        FROM maneuvers m JOIN flights f ON f.id = m.flight
        JOIN grades g ON g.id = (SELECT max(id) FROM grades WHERE maneuver = m.id)
        WHERE m.stands = 1 AND {wanted} ORDER BY f.name, m.t_start""",  # noqa: S608 - own clauses
        values,
    )
    states = _by_maneuver(catalog)
    runs = _runs_by_maneuver(catalog)
    found = []
    for row in rows:
        maneuver = replace(
            DetectedManeuver.from_record(_parsed(catalog, row["record"])),
            grade=row["grade"],
            reasons=tuple(_parsed(catalog, row["reasons"])),
        )
        held = states.get(row["id"], {})
        if inputs is not None and set(maneuver.inputs) != set(inputs):
            continue
        if not all(_within(held.get(name), span) for name, span in (conditions or {}).items()):
            continue
        found.append(
            StoredManeuver(
                flight=row["flight"],
                maneuver=maneuver,
                conditions=held,
                graded_by=row["given_by"],
                runs=tuple(runs.get(row["id"], ())),
                verdict=row["said"] or "",
            )
        )
    return tuple(found)


def search_runs(
    catalog: Catalog,
    *,
    method: str | None = None,
    axis: str | None = None,
    flight: str | None = None,
    derivative: str | None = None,
    kept: int | None = None,
) -> tuple[EstimationRun, ...]:
    """Return the estimations that fit, the oldest first; not those of runs that were forgotten.

    A maneuver of `flight` took part, `derivative` has a value, and they are part of the campaign
    run of the number `kept`.
    """
    wanted, values = select_where(
        {
            "r.kept = ?": kept,
            "r.method = ?": method,
            "r.axis = ?": axis,
            """r.id IN (SELECT rm.run FROM run_maneuvers rm JOIN maneuvers m ON m.id = rm.maneuver
            JOIN flights f ON f.id = m.flight WHERE f.name = ?)""": flight,
            "r.id IN (SELECT run FROM estimates WHERE name = ? AND value IS NOT NULL)": derivative,
        }
    )
    rows = catalog.query(
        f"""SELECT r.*, o.name AS model_name FROM runs r LEFT JOIN models o ON o.id = r.model
        WHERE {_NOT_DELETED} AND {wanted} ORDER BY r.id""",  # noqa: S608 - own clauses
        values,
    )
    return tuple(_run(catalog, row) for row in rows)


def list_flights(catalog: Catalog) -> tuple[str, ...]:
    """Return the names of the stored flights, by date and name."""
    rows = catalog.query("SELECT name FROM flights ORDER BY date IS NULL, date, name")
    return tuple(row["name"] for row in rows)


def _run(catalog: Catalog, row: Any) -> EstimationRun:
    maneuvers = catalog.query(
        """SELECT f.name AS flight, m.name, rm.t_start, rm.t_end FROM run_maneuvers rm
        JOIN maneuvers m ON m.id = rm.maneuver JOIN flights f ON f.id = m.flight
        WHERE rm.run = ? ORDER BY f.name, m.t_start""",
        (row["id"],),
    )
    estimates = catalog.query("SELECT * FROM estimates WHERE run = ? ORDER BY rowid", (row["id"],))
    return EstimationRun(
        id=row["id"],
        maneuvers=tuple((one["flight"], one["name"]) for one in maneuvers),
        edges=tuple((one["t_start"], one["t_end"]) for one in maneuvers),
        campaign_run_id=row["kept"],
        estimates={
            one["name"]: StoredEstimate(
                confounded_with=tuple(_parsed(catalog, one["confounded_with"])),
                **{key: one[key] for key in ("value", "std", "cramer_rao", "status", "why")},
            )
            for one in estimates
        },
        settings=_parsed(catalog, row["settings"]),
        fit=_parsed(catalog, row["fit"]),
        model=row["model_name"],
        converged=bool(row["converged"]),
        warnings=tuple(_parsed(catalog, row["warnings"])),
        **{key: row[key] for key in ("method", "axis", "iterations", "message", "made_at")},
    )


def _by_maneuver(catalog: Catalog) -> dict[int, dict[str, FlightCondition]]:
    found: dict[int, dict[str, FlightCondition]] = {}
    for row in catalog.query("SELECT * FROM conditions ORDER BY maneuver, rowid"):
        found.setdefault(row["maneuver"], {})[row["channel"]] = FlightCondition(
            mean=row["mean"], minimum=row["least"], maximum=row["most"]
        )
    return found


def _runs_by_maneuver(catalog: Catalog) -> dict[int, list[int]]:
    found: dict[int, list[int]] = {}
    rows = catalog.query(
        f"""SELECT rm.maneuver, rm.run FROM run_maneuvers rm JOIN runs r ON r.id = rm.run
        WHERE {_NOT_DELETED} ORDER BY rm.run"""  # noqa: S608 - own clause
    )
    for row in rows:
        found.setdefault(row["maneuver"], []).append(row["run"])
    return found


def _within(condition: FlightCondition | None, span: Sequence[float | None]) -> bool:
    if condition is None:
        return False
    least, most = span
    return (least is None or condition.mean >= least) and (most is None or condition.mean <= most)


def _parsed(catalog: Catalog, text: str) -> Any:
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
