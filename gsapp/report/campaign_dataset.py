"""A campaign as a Parquet dataset, partitioned by flight, for DuckDB, pandas and Arrow.

Two folders, each with a folder ``flight=NAME`` for every flight: ``derivatives``, a row for each
derivative of each fit of one maneuver, per radian about the CG of the aircraft file; and
``samples``, those that were fitted, instruments corrected. SI units, in the metadata of the
columns; what is unknown is null.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

import numpy as np

from gsapp.flight.catalog import FlightEntry
from gsapp.flight.catalog.derived_conditions import DERIVED_CONDITIONS
from gsapp.flight.catalog.records import CONDITION_CHANNELS
from gsapp.flight.readers.parquet_file import load_pyarrow
from gsapp.foundation import FlightError
from gsapp.foundation.errors import format_os_error
from gsapp.foundation.files import atomic_folder, list_names
from gsapp.identification.campaign import ManeuverResult
from gsapp.identification.runs.run_execution import RunOutcome
from gsapp.quantities import channel

_PLACE: Final = {"flight_number": "int32", "maneuver": "string"}
_DERIVATIVES: Final = {
    **_PLACE, "date": "timestamp", "aircraft": "string", "airframe": "string",
    "t_start": "double", "t_end": "double", "inputs": "string", "kind": "string",
    "method": "string", "axis": "string", "converged": "bool", "derivative": "string",
    "value": "double", "std": "double", "cramer_rao": "double", "status": "string",
    **dict.fromkeys((*CONDITION_CHANNELS, *DERIVED_CONDITIONS), "double"),
}  # fmt: skip
"""Type of each column; the last are the conditions before the input."""


def check_dataset_folder(folder: Path) -> None:
    """Raise `FlightError` unless a dataset can be written: said before the work, not after it."""
    load_pyarrow()
    if folder.exists() and (not folder.is_dir() or list_names(folder)):
        raise FlightError(f"{folder} exists and is not empty; choose a new folder")


def write_campaign_dataset(outcome: RunOutcome, folder: Path) -> None:
    """Write all of a dataset or nothing; `folder` is new or empty.

    Raises
    ------
    FlightError
        If pyarrow is not installed, or the folder cannot be written.
    """
    check_dataset_folder(folder)
    try:
        with atomic_folder(folder) as made:
            _write(outcome, made)
    except OSError as error:
        raise FlightError(
            format_os_error(folder, error, "choose a folder with write permission and disk space")
        ) from error


def _write(outcome: RunOutcome, folder: Path) -> None:
    pyarrow, parquet = load_pyarrow()
    schemas = {
        "derivatives": _schema(pyarrow, _DERIVATIVES),
        "samples": _schema(pyarrow, {**_PLACE, "time": "double", **_channels(outcome)}),
    }
    several = len(outcome.request.flights) > 1

    def number_of(one: ManeuverResult) -> int:
        return int(one.maneuver.id.partition(":")[0]) if several else 1

    results = sorted(outcome.result.results, key=number_of)
    for number, own in groupby(results, key=number_of):
        entry, found = outcome.flights[number - 1], list(own)
        tables = {"derivatives": _derivatives(entry, found), "samples": _samples(found)}
        for name, columns in tables.items():
            place = folder / name / f"flight={quote(entry.name, safe=' ')}"
            place.mkdir(parents=True, exist_ok=True)
            columns["flight_number"] = [number] * len(columns["maneuver"])
            arrays = [
                pyarrow.array(
                    columns.get(one.name, [None] * len(columns["maneuver"])),
                    type=one.type,
                    from_pandas=True,
                )
                for one in schemas[name]
            ]
            with (place / f"{number}.parquet").open("wb") as stream:
                parquet.write_table(
                    pyarrow.Table.from_arrays(arrays, schema=schemas[name]), stream,
                    compression="zstd",
                )  # fmt: skip


def _schema(pyarrow: Any, columns: Mapping[str, str]) -> Any:
    types = {
        "int32": pyarrow.int32(), "string": pyarrow.string(), "double": pyarrow.float64(),
        "bool": pyarrow.bool_(), "timestamp": pyarrow.timestamp("us", tz="UTC"),
    }  # fmt: skip
    return pyarrow.schema(
        pyarrow.field(name, types[kind], metadata={"unit": _unit(name)} if kind == "double" else {})
        for name, kind in columns.items()
    )


def _unit(column: str) -> str:
    if column in ("t_start", "t_end", "time"):
        return "s"
    if column in ("value", "std", "cramer_rao"):
        return "per radian"
    known = DERIVED_CONDITIONS.get(column)
    return channel(column).unit if known is None else known.unit


def _channels(outcome: RunOutcome) -> dict[str, str]:
    """Return the channels of all maneuvers: files of one dataset have the same columns."""
    return {
        name: "double" for one in outcome.result.results for name in one.maneuver.block.channels
    }


def _derivatives(entry: FlightEntry, results: Sequence[ManeuverResult]) -> dict[str, list[Any]]:
    known = {
        one.id: (one, conditions)
        for one, conditions in zip(entry.maneuvers, entry.conditions, strict=True)
    }
    info = entry.info
    rows = [
        {
            "date": info and info.date,
            "aircraft": entry.aircraft,
            "airframe": (info and info.airframe) or entry.aircraft,
            **row,
            **{name: one.mean for name, one in conditions.items()},
        }
        for result in results
        for found, conditions in [known[result.maneuver.id.rpartition(":")[2]]]
        for row in _rows(result, found.kind)
    ]
    return {name: [row.get(name) for row in rows] for name in _DERIVATIVES}


def _rows(result: ManeuverResult, kind: str) -> Iterator[dict[str, Any]]:
    """Yield a row for each derivative that was free, by each method."""
    maneuver = result.maneuver
    for estimate in (result.estimate, *result.comparisons.values()):
        if estimate is None:
            continue
        for name, one in estimate.derivatives.items():
            if one.status == "held":
                continue
            yield {
                "maneuver": maneuver.id, "t_start": maneuver.t_start, "t_end": maneuver.t_end,
                "inputs": "+".join(maneuver.inputs), "kind": kind, "method": estimate.method,
                "axis": estimate.axis, "converged": estimate.converged, "derivative": name,
                "value": one.value, "std": one.std, "cramer_rao": one.cramer_rao,
                "status": one.status,
            }  # fmt: skip


def _samples(results: Sequence[ManeuverResult]) -> dict[str, Any]:
    blocks = [one.maneuver.block.in_memory() for one in results]
    names = dict.fromkeys(name for block in blocks for name in block.channels)
    return {
        "maneuver": [one.maneuver.id for one in results for _ in range(len(one.maneuver.block))],
        "time": np.concatenate([block.times for block in blocks]),
        **{
            name: np.concatenate(
                [block[name] if name in block else np.full(len(block), np.nan) for block in blocks]
            )
            for name in names
        },
    }
