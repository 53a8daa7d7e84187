"""Runs over whole campaigns in a catalog: stored, listed, renamed, forgotten, called back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from gsapp.flight.catalog.records import CampaignRun, EstimationRun, StoredModel
from gsapp.flight.catalog.store import (
    Catalog,
    finite_or_none,
    flight_row_id,
    maneuver_row_id,
    model_row_id,
    to_json_text,
    utc_timestamp,
)
from gsapp.flight.provenance import InputFile
from gsapp.foundation import FlightError, UnknownNameError


def store_weights(catalog: Catalog, flight: str, weights: Mapping[str, float]) -> None:
    """Store the response weights that a flight is estimated with, in place of former ones.

    Parameters
    ----------
    weights : mapping of str to float
        By response, as in table 6.2.7.
    """
    with catalog.transaction() as connection:
        number = flight_row_id(connection, flight)
        connection.execute("DELETE FROM weights WHERE flight = ?", (number,))
        connection.executemany(
            "INSERT INTO weights (flight, response, weight) VALUES (?, ?, ?)",
            [(number, response, float(weight)) for response, weight in weights.items()],
        )


def store_model(catalog: Catalog, model: StoredModel) -> None:
    """Store a model under its name, or renew it."""
    with catalog.transaction() as connection:
        connection.execute(
            """INSERT INTO models (name, parent, content, evidence, made_at)
            VALUES (?, ?, ?, ?, ?)
            ON CONFLICT (name) DO UPDATE SET parent = excluded.parent,
                content = excluded.content, evidence = excluded.evidence,
                made_at = excluded.made_at""",
            (
                model.name,
                model.parent,
                model.content,
                model.evidence,
                model.made_at or utc_timestamp(),
            ),
        )


def store_run(catalog: Catalog, run: EstimationRun) -> int:
    """Store an estimation; return its number.

    Raises
    ------
    UnknownNameError
        If a maneuver or the model is not in the catalog.
    """
    with catalog.transaction() as connection:
        cursor = connection.execute(
            """INSERT INTO runs (method, axis, settings, model, converged, iterations, fit,
                warnings, message, made_at, kept) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)""",
            (
                run.method,
                run.axis,
                to_json_text(run.settings),
                model_row_id(connection, run.model),
                run.converged,
                run.iterations,
                to_json_text(run.fit),
                to_json_text(run.warnings),
                run.message,
                run.made_at or utc_timestamp(),
                run.campaign_run_id,
            ),
        )
        number = int(cursor.lastrowid or 0)
        edges = dict(zip(run.maneuvers, run.edges, strict=True)) if run.edges else {}
        for flight, name in dict.fromkeys(run.maneuvers):
            place = maneuver_row_id(connection, flight, name)
            start, stop = edges.get((flight, name), (None, None))
            connection.execute(
                """INSERT INTO run_maneuvers (run, maneuver, t_start, t_end)
                SELECT ?, id, coalesce(?, t_start), coalesce(?, t_end) FROM maneuvers
                WHERE id = ?""",
                (number, start, stop, place),
            )
        connection.executemany(
            """INSERT INTO estimates (run, name, value, std, cramer_rao, status, confounded_with,
                why) VALUES (?, ?, ?, ?, ?, ?, ?, ?)""",
            [
                (
                    number,
                    name,
                    finite_or_none(estimate.value),
                    finite_or_none(estimate.std),
                    finite_or_none(estimate.cramer_rao),
                    estimate.status,
                    to_json_text(estimate.confounded_with),
                    estimate.why,
                )
                for name, estimate in run.estimates.items()
            ],
        )
        return number


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
            f"the run {row['id']} in the catalog {catalog.path} is damaged ({error}); restore a "
            "copy of the catalog"
        ) from error
