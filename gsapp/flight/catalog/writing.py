"""Putting flights, maneuvers, grades, runs and models into a catalog."""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from gsapp.flight.catalog.records import Condition, Run, StoredModel, conditions_of
from gsapp.flight.catalog.store import Catalog
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers.found import GRADES, FoundManeuver
from gsapp.foundation import FlightError, UnknownNameError


def store_flight(catalog: Catalog, flight: Flight, *, aircraft: str = "") -> int:
    """Store the facts of a flight, or renew them; return its number in the catalog."""
    with catalog.writing() as connection:
        return _flight(connection, flight, aircraft)


def store_maneuvers(
    catalog: Catalog,
    flight: Flight,
    maneuvers: Sequence[FoundManeuver],
    *,
    aircraft: str = "",
    graded_by: str = "program",
) -> None:
    """Store the maneuvers of a flight with their conditions and grades, all or none.

    Those of the same id are renewed. Others of this flight that are not among them no longer
    stand: searches leave them out, but what was estimated from them keeps its origin.

    Parameters
    ----------
    catalog : Catalog
    flight : Flight
        Stored as well.
    maneuvers : sequence of FoundManeuver
    aircraft : str
        Name of the aircraft.
    graded_by : str
        Who gave the grades. A grade that a person gave by `store_grade` is not overruled.
    """
    with catalog.writing() as connection:
        number = _flight(connection, flight, aircraft)
        connection.execute("UPDATE maneuvers SET stands = 0 WHERE flight = ?", (number,))
        for maneuver in maneuvers:
            place = _maneuver(connection, number, maneuver)
            _conditions(connection, place, conditions_of(flight, maneuver))
            latest = _latest_grade(connection, place)
            same = latest is not None and (latest["grade"], latest["reasons"]) == (
                maneuver.grade,
                _json(maneuver.reasons),
            )
            by_person = latest is not None and latest["given_by"] != graded_by
            if not (same or by_person):
                _grade(connection, place, maneuver.grade, maneuver.reasons, graded_by)


def store_grade(
    catalog: Catalog, flight: str, name: str, grade: str, reasons: Sequence[str] = (), *, by: str
) -> None:
    """Give a maneuver another grade; former ones stay in the history.

    Raises
    ------
    FlightError
        If there is no such grade.
    UnknownNameError
        If the catalog has no such maneuver.
    """
    if grade not in GRADES:
        raise FlightError(f"there is no grade '{grade}'; grades are {', '.join(GRADES)}")
    with catalog.writing() as connection:
        _grade(connection, _maneuver_number(connection, flight, name), grade, reasons, by)


def store_weights(catalog: Catalog, flight: str, weights: Mapping[str, float]) -> None:
    """Store the response weights that a flight is estimated with, in place of former ones.

    Parameters
    ----------
    catalog : Catalog
    flight : str
        A stored flight.
    weights : mapping of str to float
        By response, as in table 6.2.7.
    """
    with catalog.writing() as connection:
        number = _flight_number(connection, flight)
        connection.execute("DELETE FROM weights WHERE flight = ?", (number,))
        connection.executemany(
            "INSERT INTO weights (flight, response, weight) VALUES (?, ?, ?)",
            [(number, response, float(weight)) for response, weight in weights.items()],
        )


def store_model(catalog: Catalog, model: StoredModel) -> None:
    """Store a model under its name, or renew it."""
    with catalog.writing() as connection:
        connection.execute(
            """INSERT INTO models (name, parent, content, evidence, made_at)
            VALUES (?, ?, ?, ?, ?)
            ON CONFLICT (name) DO UPDATE SET parent = excluded.parent,
                content = excluded.content, evidence = excluded.evidence,
                made_at = excluded.made_at""",
            (model.name, model.parent, model.content, model.evidence, model.made_at or _now()),
        )


def store_run(catalog: Catalog, run: Run) -> int:
    """Store an estimation; return its number.

    Raises
    ------
    UnknownNameError
        If a maneuver or the model is not in the catalog.
    """
    with catalog.writing() as connection:
        cursor = connection.execute(
            """INSERT INTO runs (method, axis, settings, model, converged, iterations, fit,
                warnings, message, made_at) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)""",
            (
                run.method,
                run.axis,
                _json(run.settings),
                _model_number(connection, run.model),
                run.converged,
                run.iterations,
                _json(run.fit),
                _json(run.warnings),
                run.message,
                run.made_at or _now(),
            ),
        )
        number = int(cursor.lastrowid or 0)
        for flight, name in dict.fromkeys(run.maneuvers):
            place = _maneuver_number(connection, flight, name)
            connection.execute(
                """INSERT INTO run_maneuvers (run, maneuver, t_start, t_end)
                SELECT ?, id, t_start, t_end FROM maneuvers WHERE id = ?""",
                (number, place),
            )
        connection.executemany(
            """INSERT INTO estimates (run, name, value, std, cramer_rao, status, confounded_with,
                why) VALUES (?, ?, ?, ?, ?, ?, ?, ?)""",
            [
                (
                    number,
                    name,
                    _number(estimate.value),
                    _number(estimate.std),
                    _number(estimate.cramer_rao),
                    estimate.status,
                    _json(estimate.confounded_with),
                    estimate.why,
                )
                for name, estimate in run.estimates.items()
            ],
        )
        return number


def _flight(connection: sqlite3.Connection, flight: Flight, aircraft: str) -> int:
    info = flight.info
    facts: dict[str, Any] = {}
    if info is not None:
        facts = info.model_dump(
            mode="json", include={"weather", "crew", "source", "channel_map", "versions"}
        )
    connection.execute(
        """INSERT INTO flights (name, path, date, aircraft, duration, takeoff_weight,
            landing_weight, fuel, notes, pilot_comments, facts)
        VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)
        ON CONFLICT (name) DO UPDATE SET path = excluded.path, date = excluded.date,
            aircraft = excluded.aircraft, duration = excluded.duration,
            takeoff_weight = excluded.takeoff_weight, landing_weight = excluded.landing_weight,
            fuel = excluded.fuel, notes = excluded.notes,
            pilot_comments = excluded.pilot_comments, facts = excluded.facts""",
        (
            flight.name,
            str(flight.path),
            None if info is None or info.date is None else info.date.isoformat(),
            aircraft or (info.aircraft if info else ""),
            flight.duration,
            None if info is None else info.takeoff_weight,
            None if info is None else info.landing_weight,
            None if info is None else info.fuel,
            "" if info is None else info.notes,
            "" if info is None else info.pilot_comments,
            _json(facts),
        ),
    )
    return _flight_number(connection, flight.name)


def _maneuver(connection: sqlite3.Connection, flight: int, maneuver: FoundManeuver) -> int:
    connection.execute(
        """INSERT INTO maneuvers (flight, name, t_start, t_end, kind, amplitude, note, record)
        VALUES (?, ?, ?, ?, ?, ?, ?, ?)
        ON CONFLICT (flight, name) DO UPDATE SET t_start = excluded.t_start,
            t_end = excluded.t_end, kind = excluded.kind, amplitude = excluded.amplitude,
            note = excluded.note, record = excluded.record, stands = 1""",
        (
            flight,
            maneuver.id,
            maneuver.t_start,
            maneuver.t_end,
            maneuver.kind,
            _number(maneuver.amplitude),
            maneuver.note,
            _json(maneuver.to_record()),
        ),
    )
    row = connection.execute(
        "SELECT id FROM maneuvers WHERE flight = ? AND name = ?", (flight, maneuver.id)
    ).fetchone()
    number = int(row["id"])
    connection.execute("DELETE FROM inputs WHERE maneuver = ?", (number,))
    connection.executemany(
        "INSERT INTO inputs (maneuver, surface, amplitude) VALUES (?, ?, ?)",
        [
            (number, surface, _number(maneuver.amplitudes.get(surface)))
            for surface in maneuver.inputs
        ],
    )
    return number


def _conditions(
    connection: sqlite3.Connection, maneuver: int, conditions: Mapping[str, Condition]
) -> None:
    connection.execute("DELETE FROM conditions WHERE maneuver = ?", (maneuver,))
    connection.executemany(
        "INSERT INTO conditions (maneuver, channel, mean, least, most) VALUES (?, ?, ?, ?, ?)",
        [(maneuver, name, one.mean, one.least, one.most) for name, one in conditions.items()],
    )


def _latest_grade(connection: sqlite3.Connection, maneuver: int) -> sqlite3.Row | None:
    row: sqlite3.Row | None = connection.execute(
        "SELECT * FROM grades WHERE maneuver = ? ORDER BY id DESC LIMIT 1", (maneuver,)
    ).fetchone()
    return row


def _grade(
    connection: sqlite3.Connection, maneuver: int, grade: str, reasons: Iterable[str], by: str
) -> None:
    connection.execute(
        """INSERT INTO grades (maneuver, grade, reasons, given_by, given_at)
        VALUES (?, ?, ?, ?, ?)""",
        (maneuver, grade, _json(list(reasons)), by, _now()),
    )


def _flight_number(connection: sqlite3.Connection, name: str) -> int:
    row = connection.execute("SELECT id FROM flights WHERE name = ?", (name,)).fetchone()
    if row is None:
        raise UnknownNameError(f"the catalog has no flight '{name}'; store it first")
    return int(row["id"])


def _maneuver_number(connection: sqlite3.Connection, flight: str, name: str) -> int:
    number = _flight_number(connection, flight)
    row = connection.execute(
        "SELECT id FROM maneuvers WHERE flight = ? AND name = ?", (number, name)
    ).fetchone()
    if row is None:
        raise UnknownNameError(
            f"the catalog has no maneuver '{name}' of the flight '{flight}'; store it first"
        )
    return int(row["id"])


def _model_number(connection: sqlite3.Connection, name: str | None) -> int | None:
    if name is None:
        return None
    row = connection.execute("SELECT id FROM models WHERE name = ?", (name,)).fetchone()
    if row is None:
        raise UnknownNameError(f"the catalog has no model '{name}'; store it first")
    return int(row["id"])


def _json(content: Any) -> str:
    try:
        return json.dumps(
            dict(content) if isinstance(content, Mapping) else content,
            ensure_ascii=False,
            allow_nan=False,
        )
    except (TypeError, ValueError) as error:
        raise FlightError(
            f"the catalog cannot hold {content!r} ({error}); give numbers, texts, lists and tables"
        ) from error


def _number(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
