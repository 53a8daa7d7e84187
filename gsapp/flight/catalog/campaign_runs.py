"""Runs over whole campaigns in a catalog: stored, listed, renamed, forgotten, called back."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any, Final

from gsapp.flight.catalog.records import CampaignRun, EstimationRun, StoredModel
from gsapp.flight.catalog.store import (
    Catalog,
    insert_row,
    maneuver_row_id,
    model_row_id,
    to_json_text,
    utc_timestamp,
)
from gsapp.flight.provenance import InputFile
from gsapp.foundation import FlightError, UnknownNameError

_RUN_COLUMNS: Final = (
    "method", "axis", "settings", "converged", "iterations", "fit", "warnings", "message",
)  # fmt: skip
"""Of a fit: called the same in `EstimationRun` and in its table."""
_PLAIN: Final = ("label", "made_at", "method", "axis", "aircraft")
_TABLES: Final = ("request", "settings", "versions", "result")
"""Of a campaign run: texts, and what is kept as JSON."""


def store_model(catalog: Catalog, model: StoredModel) -> None:
    """Store a model under its name, or renew it."""
    with catalog.transaction() as connection:
        values = {**asdict(model), "made_at": model.made_at or utc_timestamp()}
        insert_row(connection, "models", values, key=("name",))


def store_run(catalog: Catalog, run: EstimationRun) -> int:
    """Store an estimation; return its number. Its maneuvers and its model are in the catalog."""
    with catalog.transaction() as connection:
        values = {
            **{name: getattr(run, name) for name in _RUN_COLUMNS},
            "model": model_row_id(connection, run.model),
            "made_at": run.made_at or utc_timestamp(),
            "kept": run.campaign_run_id,
        }
        number = insert_row(connection, "runs", values)
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
        for name, estimate in run.estimates.items():
            insert_row(connection, "estimates", {"run": number, "name": name, **asdict(estimate)})
        return number


def store_campaign_run(catalog: Catalog, record: CampaignRun) -> int:
    """Store a run over a campaign; return its number."""
    with catalog.transaction() as connection:
        values = {name: getattr(record, name) for name in (*_PLAIN, *_TABLES, "flights")}
        values["inputs"] = [asdict(one) for one in record.inputs]
        values["made_at"] = record.made_at or utc_timestamp()
        return insert_row(connection, "kept_runs", values)


def list_campaign_runs(catalog: Catalog) -> tuple[CampaignRun, ...]:
    """Return the runs that were not forgotten, the oldest first."""
    rows = catalog.query("SELECT * FROM kept_runs WHERE forgotten_at IS NULL ORDER BY id")
    return tuple(_record(catalog, row) for row in rows)


def get_campaign_run(catalog: Catalog, number: int) -> CampaignRun:
    """Return one run; `UnknownNameError` if there is none of that number, or no more."""
    rows = catalog.query("SELECT * FROM kept_runs WHERE id = ? AND forgotten_at IS NULL", (number,))
    if not rows:
        raise _unknown(catalog, number)
    return _record(catalog, rows[0])


def update_campaign_run(catalog: Catalog, record: CampaignRun, number: int) -> None:
    """Put other settings and results of the same fits in place; label and date stay.

    See `get_campaign_run` for the errors.
    """
    changed = (record.request, record.settings, record.result)
    change = "request = ?, settings = ?, result = ?"
    _change(catalog, number, change, *map(to_json_text, changed))


def set_campaign_run_label(catalog: Catalog, number: int, label: str) -> None:
    """Give a run another label; see `get_campaign_run`."""
    _change(catalog, number, "label = ?", label)


def delete_campaign_run(catalog: Catalog, number: int) -> None:
    """Leave a run and its fits out of everything; `restore_campaign_run` brings them back."""
    _change(catalog, number, "forgotten_at = ?", utc_timestamp())


def restore_campaign_run(catalog: Catalog, number: int) -> None:
    """Bring back a run that was forgotten."""
    _change(catalog, number, "forgotten_at = NULL", only="1")


def _change(
    catalog: Catalog, number: int, change: str, *values: str, only: str = "forgotten_at IS NULL"
) -> None:
    with catalog.transaction() as connection:
        done = connection.execute(
            f"UPDATE kept_runs SET {change} WHERE id = ? AND {only}",  # noqa: S608
            (*values, number),
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
            flights=tuple(json.loads(row["flights"])),
            inputs=tuple(InputFile(**one) for one in json.loads(row["inputs"])),
            **{name: row[name] for name in _PLAIN},
            **{name: json.loads(row[name]) for name in _TABLES},
        )
    except (ValueError, TypeError, RecursionError) as error:
        raise FlightError(
            f"the run {row['id']} in the catalog {catalog.path} is damaged ({error}); restore a "
            "copy of the catalog"
        ) from error
