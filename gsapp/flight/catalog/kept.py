"""Runs over whole campaigns in a catalog: stored, listed, renamed, forgotten, called back."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from gsapp.flight.catalog.places import as_json, now
from gsapp.flight.catalog.records import KeptRecord
from gsapp.flight.catalog.store import Catalog
from gsapp.flight.provenance import InputFile
from gsapp.foundation import FlightError, UnknownNameError


def store_kept(catalog: Catalog, record: KeptRecord) -> int:
    """Store a run over a campaign; return its number.

    Raises
    ------
    FlightError
        If the catalog cannot be written, or the record is not JSON.
    """
    with catalog.writing() as connection:
        cursor = connection.execute(
            """INSERT INTO kept_runs (label, made_at, method, axis, aircraft, flights, request,
                settings, inputs, versions, result) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)""",
            (
                record.label,
                record.made_at or now(),
                record.method,
                record.axis,
                record.aircraft,
                as_json(record.flights),
                as_json(record.request),
                as_json(record.settings),
                as_json([asdict(one) for one in record.inputs]),
                as_json(record.versions),
                as_json(record.result),
            ),
        )
        return int(cursor.lastrowid or 0)


def kept_records(catalog: Catalog) -> tuple[KeptRecord, ...]:
    """Return the runs that were not forgotten, the oldest first."""
    rows = catalog.query("SELECT * FROM kept_runs WHERE forgotten_at IS NULL ORDER BY id")
    return tuple(_record(catalog, row) for row in rows)


def kept_record(catalog: Catalog, number: int) -> KeptRecord:
    """Return one run.

    Raises
    ------
    UnknownNameError
        If there is none of that number, or it was forgotten.
    """
    rows = catalog.query("SELECT * FROM kept_runs WHERE id = ? AND forgotten_at IS NULL", (number,))
    if not rows:
        raise _unknown(catalog, number)
    return _record(catalog, rows[0])


def renew_record(catalog: Catalog, record: KeptRecord, number: int) -> None:
    """Put other settings and results of the same fits in place; label and date stay.

    See `kept_record` for the errors.
    """
    with catalog.writing() as connection:
        done = connection.execute(
            """UPDATE kept_runs SET request = ?, settings = ?, result = ?
            WHERE id = ? AND forgotten_at IS NULL""",
            (as_json(record.request), as_json(record.settings), as_json(record.result), number),
        )
        if not done.rowcount:
            raise _unknown(catalog, number)


def change_label(catalog: Catalog, number: int, label: str) -> None:
    """Give a run another label; see `kept_record`."""
    _change(catalog, number, "label = ?", label)


def forget_record(catalog: Catalog, number: int) -> None:
    """Leave a run and its fits out of everything; `recall_record` brings them back."""
    _change(catalog, number, "forgotten_at = ?", now())


def recall_record(catalog: Catalog, number: int) -> None:
    """Bring back a run that was forgotten.

    Raises
    ------
    UnknownNameError
        If there never was one of that number.
    """
    with catalog.writing() as connection:
        done = connection.execute(
            "UPDATE kept_runs SET forgotten_at = NULL WHERE id = ?", (number,)
        )
        if not done.rowcount:
            raise _unknown(catalog, number)


def _change(catalog: Catalog, number: int, change: str, value: str) -> None:
    with catalog.writing() as connection:
        done = connection.execute(
            f"UPDATE kept_runs SET {change} WHERE id = ? AND forgotten_at IS NULL",  # noqa: S608
            (value, number),
        )
        if not done.rowcount:
            raise _unknown(catalog, number)


def _unknown(catalog: Catalog, number: int) -> UnknownNameError:
    rows = catalog.query("SELECT id FROM kept_runs WHERE forgotten_at IS NULL ORDER BY id")
    there = ", ".join(str(row["id"]) for row in rows) or "none"
    return UnknownNameError(f"the catalog {catalog.path} has no run {number}; it has {there}")


def _record(catalog: Catalog, row: Any) -> KeptRecord:
    try:
        return KeptRecord(
            number=row["id"],
            label=row["label"],
            made_at=row["made_at"],
            method=row["method"],
            axis=row["axis"],
            aircraft=row["aircraft"],
            flights=tuple(json.loads(row["flights"])),
            request=json.loads(row["request"]),
            settings=json.loads(row["settings"]),
            inputs=tuple(InputFile(**one) for one in json.loads(row["inputs"])),
            versions=json.loads(row["versions"]),
            result=json.loads(row["result"]),
        )
    except (ValueError, TypeError) as error:
        raise FlightError(
            f"the run {row['id']} in the catalog {catalog.path} is damaged ({error}); bring back "
            "a copy of the catalog"
        ) from error
