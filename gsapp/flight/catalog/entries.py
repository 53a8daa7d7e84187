"""Putting flights, their maneuvers and grades into a catalog."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from gsapp.aircraft import Aircraft
from gsapp.flight.catalog.records import FlightCondition, FlightEntry
from gsapp.flight.catalog.store import (
    Catalog,
    flight_row_id,
    insert_row,
    maneuver_row_id,
    to_json_text,
    utc_timestamp,
)
from gsapp.flight.flight import Flight
from gsapp.flight.info import FlightInfo
from gsapp.flight.maneuvers.detected_maneuver import GRADED_BY_CREW, GRADES, DetectedManeuver
from gsapp.foundation import FlightError

_MANEUVER_COLUMNS: Final = ("t_start", "t_end", "kind", "amplitude", "note")


def store_flight(catalog: Catalog, flight: Flight, *, aircraft: Aircraft | str = "") -> int:
    """Store the facts of a flight, or renew them; return its number in the catalog."""
    with catalog.transaction() as connection:
        return _flight(connection, FlightEntry.from_flight(flight, aircraft=aircraft))


def store_maneuvers(
    catalog: Catalog,
    flight: Flight,
    maneuvers: Sequence[DetectedManeuver],
    *,
    aircraft: Aircraft | str = "",
    graded_by: str = "program",
) -> None:
    """Store the maneuvers of a flight with their conditions and grades, all or none.

    Those of the same id are renewed. Others of this flight that are not among them no longer stand:
    searches leave them out, but what was estimated from them keeps its origin. `graded_by` gave the
    grades that the crew did not give; they do not overrule those that a person gave by
    `store_grade`.
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

    What the catalog has stays as it is. A maneuver whose id stands there for another stretch of the
    flight gets its times for a name, and searches leave it out.
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


def store_instrument_errors(
    catalog: Catalog, flight: str, errors: Mapping[str, tuple[float | None, float | None, str]]
) -> None:
    """Store value and bound (SI) and status of the errors of a flight's instruments, by name.

    They take the place of all that were stored of this flight. See `store_flight`.
    """
    with catalog.transaction() as connection:
        number = flight_row_id(connection, flight)
        connection.execute("DELETE FROM instrument_errors WHERE flight = ?", (number,))
        for name, (value, std, status) in errors.items():
            values = {"value": value, "std": std, "status": status}
            insert_row(connection, "instrument_errors", {"flight": number, "name": name, **values})


def _flight(connection: sqlite3.Connection, flight: FlightEntry) -> int:
    info = flight.info or FlightInfo()
    known = ("airframe", "takeoff_weight", "landing_weight", "fuel", "notes", "pilot_comments")
    facts = {"weather", "crew", "source", "channel_map", "versions"}
    values = {
        "name": flight.name,
        "path": str(flight.path),
        "date": info.date.isoformat() if info.date else None,
        "aircraft": flight.aircraft,
        "duration": flight.duration,
        **{name: getattr(info, name) for name in known},
        "facts": info.model_dump(mode="json", include=facts) if flight.info else {},
    }
    insert_row(connection, "flights", values, key=("name",))
    return flight_row_id(connection, flight.name)


def _maneuver(connection: sqlite3.Connection, flight: int, maneuver: DetectedManeuver) -> int:
    values = {
        "flight": flight,
        "name": maneuver.id,
        **{name: getattr(maneuver, name) for name in _MANEUVER_COLUMNS},
        "record": maneuver.to_record(),
        "stands": 1,
    }
    insert_row(connection, "maneuvers", values, key=("flight", "name"))
    row = connection.execute(
        "SELECT id FROM maneuvers WHERE flight = ? AND name = ?", (flight, maneuver.id)
    ).fetchone()
    number = int(row["id"])
    connection.execute("DELETE FROM inputs WHERE maneuver = ?", (number,))
    for surface in maneuver.inputs:
        size = maneuver.amplitudes.get(surface)
        insert_row(
            connection, "inputs", {"maneuver": number, "surface": surface, "amplitude": size}
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
    values = {"maneuver": maneuver, "grade": grade, "reasons": list(reasons)}
    insert_row(connection, "grades", {**values, "given_by": by, "given_at": utc_timestamp()})
