"""Runs over whole campaigns in a catalog: stored, listed, renamed, forgotten, called back."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from gsapp.flight.catalog.records import CampaignRun
from gsapp.flight.catalog.row_ids import to_json_text, utc_timestamp
from gsapp.flight.catalog.store import Catalog
from gsapp.flight.provenance import InputFile
from gsapp.foundation import FlightError, UnknownNameError


def store_campaign_run(catalog: Catalog, record: CampaignRun) -> int:
    """Store a run over a campaign; return its number.

    Raises
    ------
    FlightError
        If the catalog cannot be written, or the record is not JSON.
    """
    with catalog.transaction() as connection:
        cursor = connection.execute(
            """INSERT INTO kept_runs (label, made_at, method, axis, aircraft, flights, request,
                settings, inputs, versions, result) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)""",
            (
                record.label,
                record.made_at or utc_timestamp(),
                record.method,
                record.axis,
                record.aircraft,
                to_json_text(record.flights),
                to_json_text(record.request),
                to_json_text(record.settings),
                to_json_text([asdict(one) for one in record.inputs]),
                to_json_text(record.versions),
                to_json_text(record.result),
            ),
        )
        return int(cursor.lastrowid or 0)


def list_campaign_runs(catalog: Catalog) -> tuple[CampaignRun, ...]:
    """Return the runs that were not forgotten, the oldest first."""
    rows = catalog.query("SELECT * FROM kept_runs WHERE forgotten_at IS NULL ORDER BY id")
    return tuple(_record(catalog, row) for row in rows)


def get_campaign_run(catalog: Catalog, number: int) -> CampaignRun:
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


def update_campaign_run(catalog: Catalog, record: CampaignRun, number: int) -> None:
    """Put other settings and results of the same fits in place; label and date stay.

    See `get_campaign_run` for the errors.
    """
    with catalog.transaction() as connection:
        done = connection.execute(
            """UPDATE kept_runs SET request = ?, settings = ?, result = ?
            WHERE id = ? AND forgotten_at IS NULL""",
            (
                to_json_text(record.request),
                to_json_text(record.settings),
                to_json_text(record.result),
                number,
            ),
        )
        if not done.rowcount:
            raise _unknown(catalog, number)


def set_campaign_run_label(catalog: Catalog, number: int, label: str) -> None:
    """Give a run another label; see `get_campaign_run`."""
    _change(catalog, number, "label = ?", label)


def delete_campaign_run(catalog: Catalog, number: int) -> None:
    """Leave a run and its fits out of everything; `restore_campaign_run` brings them back."""
    _change(catalog, number, "forgotten_at = ?", utc_timestamp())


def restore_campaign_run(catalog: Catalog, number: int) -> None:
    """Bring back a run that was forgotten.

    Raises
    ------
    UnknownNameError
        If there never was one of that number.
    """
    with catalog.transaction() as connection:
        done = connection.execute(
            "UPDATE kept_runs SET forgotten_at = NULL WHERE id = ?", (number,)
        )
        if not done.rowcount:
            raise _unknown(catalog, number)


def _change(catalog: Catalog, number: int, change: str, value: str) -> None:
    with catalog.transaction() as connection:
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


def _record(catalog: Catalog, row: Any) -> CampaignRun:
    try:
        return CampaignRun(
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
