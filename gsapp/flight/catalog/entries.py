"""Putting flights, their maneuvers and grades into a catalog."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from gsapp.flight.catalog.records import FlightCondition, FlightEntry
from gsapp.flight.catalog.store import (
    Catalog,
    finite_or_none,
    flight_row_id,
    maneuver_row_id,
    to_json_text,
    utc_timestamp,
)
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers.detected_maneuver import GRADED_BY_CREW, GRADES, DetectedManeuver
from gsapp.foundation import FlightError


def store_flight(catalog: Catalog, flight: Flight, *, aircraft: str = "") -> int:
    """Store the facts of a flight, or renew them; return its number in the catalog."""
    with catalog.transaction() as connection:
        return _flight(connection, FlightEntry.from_flight(flight, aircraft=aircraft))


def store_maneuvers(
    catalog: Catalog,
    flight: Flight,
    maneuvers: Sequence[DetectedManeuver],
    *,
    aircraft: str = "",
    graded_by: str = "program",
) -> None:
    """Store the maneuvers of a flight with their conditions and grades, all or none.

    Those of the same id are renewed. Others of this flight that are not among them no longer
    stand: searches leave them out, but what was estimated from them keeps its origin.

    Parameters
    ----------
    graded_by : str
        Who gave the grades that the crew did not give. A grade that a person gave by
        `store_grade` is not overruled by these.
    """
    store_entry(
        catalog, FlightEntry.from_flight(flight, maneuvers, aircraft=aircraft), graded_by=graded_by
    )


def store_entry(catalog: Catalog, entry: FlightEntry, *, graded_by: str = "program") -> None:
    """Store a flight with all its maneuvers; see `store_maneuvers`."""
    with catalog.transaction() as connection:
        number = _flight(connection, entry)
        connection.execute("UPDATE maneuvers SET stands = 0 WHERE flight = ?", (number,))
        for maneuver, conditions in zip(entry.maneuvers, entry.conditions, strict=True):
            place = _maneuver(connection, number, maneuver)
            _conditions(connection, place, conditions)
            latest = _get_latest_grade(connection, place)
            by = GRADED_BY_CREW if maneuver.graded_by == GRADED_BY_CREW else graded_by
            same = latest is not None and (
                latest["grade"], latest["reasons"], latest["given_by"]
            ) == (maneuver.grade, to_json_text(maneuver.reasons), by)  # fmt: skip
            # The crew's own grade stands among the flight's events, and falls with its change.
            by_person = latest is not None and latest["given_by"] not in (graded_by, GRADED_BY_CREW)
            if not same and (by == GRADED_BY_CREW or not by_person):
                _grade(connection, place, maneuver.grade, maneuver.reasons, by)


def add_entry(catalog: Catalog, entry: FlightEntry) -> tuple[str, ...]:
    """Store those maneuvers of a flight that the catalog lacks; return what each is called there.

    What the catalog has stays as it is. A maneuver whose id stands there for another stretch of
    the flight gets its times for a name, and searches leave it out.

    Parameters
    ----------
    entry : FlightEntry
        Not all of the flight's maneuvers, or named by hand.
    """
    with catalog.transaction() as connection:
        number = _flight(connection, entry)
        return tuple(
            _insert_maneuver(connection, number, maneuver, conditions)
            for maneuver, conditions in zip(entry.maneuvers, entry.conditions, strict=True)
        )


def _insert_maneuver(
    connection: sqlite3.Connection,
    flight: int,
    maneuver: DetectedManeuver,
    conditions: Mapping[str, FlightCondition],
) -> str:
    by_times = f"{maneuver.t_start:g}:{maneuver.t_end:g}"
    for name in (maneuver.id, by_times):
        row = connection.execute(
            "SELECT t_start, t_end FROM maneuvers WHERE flight = ? AND name = ?", (flight, name)
        ).fetchone()
        if row is None:
            place = _maneuver(connection, flight, replace(maneuver, id=name))
            _conditions(connection, place, conditions)
            _grade(connection, place, maneuver.grade, maneuver.reasons, "program")
            if name != maneuver.id:
                connection.execute("UPDATE maneuvers SET stands = 0 WHERE id = ?", (place,))
            return name
        if row["t_start"] < maneuver.t_end and maneuver.t_start < row["t_end"]:
            return name
    return by_times


def store_grade(
    catalog: Catalog, flight: str, name: str, grade: str, reasons: Sequence[str] = (), *, by: str
) -> None:
    """Give a maneuver another grade; former ones stay in the history."""
    if grade not in GRADES:
        raise FlightError(f"there is no grade '{grade}'; grades are {', '.join(GRADES)}")
    with catalog.transaction() as connection:
        _grade(connection, maneuver_row_id(connection, flight, name), grade, reasons, by)


def _flight(connection: sqlite3.Connection, flight: FlightEntry) -> int:
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
            flight.aircraft,
            flight.duration,
            None if info is None else info.takeoff_weight,
            None if info is None else info.landing_weight,
            None if info is None else info.fuel,
            "" if info is None else info.notes,
            "" if info is None else info.pilot_comments,
            to_json_text(facts),
        ),
    )
    return flight_row_id(connection, flight.name)


def _maneuver(connection: sqlite3.Connection, flight: int, maneuver: DetectedManeuver) -> int:
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
            finite_or_none(maneuver.amplitude),
            maneuver.note,
            to_json_text(maneuver.to_record()),
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
            (number, surface, finite_or_none(maneuver.amplitudes.get(surface)))
            for surface in maneuver.inputs
        ],
    )
    return number


def _conditions(
    connection: sqlite3.Connection, maneuver: int, conditions: Mapping[str, FlightCondition]
) -> None:
    connection.execute("DELETE FROM conditions WHERE maneuver = ?", (maneuver,))
    connection.executemany(
        "INSERT INTO conditions (maneuver, channel, mean, least, most) VALUES (?, ?, ?, ?, ?)",
        [(maneuver, name, one.mean, one.minimum, one.maximum) for name, one in conditions.items()],
    )


def _get_latest_grade(connection: sqlite3.Connection, maneuver: int) -> sqlite3.Row | None:
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
        (maneuver, grade, to_json_text(list(reasons)), by, utc_timestamp()),
    )
