"""Where things stand in a catalog, and how values are written there."""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from gsapp.foundation import FlightError, UnknownNameError


def flight_row_id(connection: sqlite3.Connection, name: str) -> int:
    """Return the number of a flight.

    Raises
    ------
    UnknownNameError
        If the catalog does not have it.
    """
    row = connection.execute("SELECT id FROM flights WHERE name = ?", (name,)).fetchone()
    if row is None:
        raise UnknownNameError(f"the catalog has no flight '{name}'; store it first")
    return int(row["id"])


def maneuver_row_id(connection: sqlite3.Connection, flight: str, name: str) -> int:
    """Return the number of a maneuver; see `flight_row_id`."""
    number = flight_row_id(connection, flight)
    row = connection.execute(
        "SELECT id FROM maneuvers WHERE flight = ? AND name = ?", (number, name)
    ).fetchone()
    if row is None:
        raise UnknownNameError(
            f"the catalog has no maneuver '{name}' of the flight '{flight}'; store it first"
        )
    return int(row["id"])


def model_row_id(connection: sqlite3.Connection, name: str | None) -> int | None:
    """Return the number of a model, None for none; see `flight_row_id`."""
    if name is None:
        return None
    row = connection.execute("SELECT id FROM models WHERE name = ?", (name,)).fetchone()
    if row is None:
        raise UnknownNameError(f"the catalog has no model '{name}'; store it first")
    return int(row["id"])


def to_json_text(content: Any) -> str:
    """Return what JSON can hold as text.

    Raises
    ------
    FlightError
        If it cannot.
    """
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


def finite_or_none(value: float | None) -> float | None:
    """Return a number as a catalog holds it: None for what is none."""
    return None if value is None or not math.isfinite(value) else float(value)


def utc_timestamp() -> str:
    """Return the present time, UTC, as a catalog writes it."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")
