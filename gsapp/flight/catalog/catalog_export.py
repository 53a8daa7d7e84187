"""A catalog for other programs: JSON of everything, CSV of one table or of a search."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

from gsapp.flight.catalog.records import CONDITION_CHANNELS, StoredManeuver
from gsapp.flight.catalog.schema import TABLES
from gsapp.flight.catalog.store import Catalog
from gsapp.foundation import UnknownNameError


def export_catalog(catalog: Catalog) -> dict[str, Any]:
    """Return everything: ``{"version", "tables": {name: [row, ...]}}``, SI, absent = None."""
    return {
        "version": catalog.version,
        "tables": {name: _rows(catalog, name) for name in TABLES},
    }


def table_csv(catalog: Catalog, table: str) -> str:
    """Return one table as CSV with its column names.

    Raises
    ------
    UnknownNameError
        If there is no such table.
    """
    if table not in TABLES:
        raise UnknownNameError(f"a catalog has no table '{table}'; it has {', '.join(TABLES)}")
    columns = [row["name"] for row in catalog.query(f"PRAGMA table_info({table})")]
    return _csv(columns, _rows(catalog, table))


def maneuvers_csv(found: Sequence[StoredManeuver]) -> str:
    """Return what a search gave as CSV: one line for each maneuver, conditions as columns."""
    channels = [name for name in CONDITION_CHANNELS if any(name in one.conditions for one in found)]
    columns = ["flight", "id", "t_start", "t_end", "inputs", "kind", "amplitude", "grade"]
    columns += ["reasons", "verdict", "note", *channels]
    rows = []
    for one in found:
        maneuver = one.maneuver
        rows.append(
            {
                **maneuver.to_json(),
                "flight": one.flight,
                "inputs": "+".join(maneuver.inputs),
                "reasons": "; ".join(maneuver.reasons),
                "verdict": one.verdict,
                "note": maneuver.note,
                **{name: one.conditions[name].mean for name in channels if name in one.conditions},
            }
        )
    return _csv(columns, rows)


def _rows(catalog: Catalog, table: str) -> list[dict[str, Any]]:
    rows = catalog.query(f"SELECT * FROM {table} ORDER BY rowid")  # noqa: S608 - from TABLES
    return [dict(row) for row in rows]


def _csv(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
