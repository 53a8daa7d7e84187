"""Putting weights, models and runs into a catalog."""

from __future__ import annotations

from collections.abc import Mapping

from gsapp.flight.catalog.records import EstimationRun, StoredModel
from gsapp.flight.catalog.row_ids import (
    finite_or_none,
    flight_row_id,
    maneuver_row_id,
    model_row_id,
    to_json_text,
    utc_timestamp,
)
from gsapp.flight.catalog.store import Catalog


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
