"""Runs kept in the catalog: what it takes to do them again, with what came of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from gsapp.flight.catalog import (
    CampaignRun,
    Catalog,
    StoredModel,
    add_entry,
    delete_campaign_run,
    get_campaign_run,
    list_campaign_runs,
    restore_campaign_run,
    set_campaign_run_label,
    store_campaign_run,
    store_entry,
    store_model,
    store_run,
    update_campaign_run,
)
from gsapp.flight.provenance import InputFile
from gsapp.foundation import FlightError
from gsapp.foundation.toml import toml_text
from gsapp.identification.campaign import CampaignValue, campaign_values
from gsapp.identification.estimate_json import CatalogManeuver, catalog_runs
from gsapp.identification.runs.request import (
    RunRequest,
    describe_settings,
    request_from_json,
    request_json,
)
from gsapp.identification.runs.run_execution import RunOutcome


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredRun:
    """A run in the catalog."""

    number: int
    label: str  # What the user calls it; may be empty.
    created_at: datetime
    method: str
    axis: str
    aircraft: str
    flights: tuple[str, ...]  # Names.
    maneuver_count: int  # Of the maneuvers that were fitted, well or not.
    settings: Mapping[str, str]  # All of them in words.
    values: Mapping[str, CampaignValue]
    """Means as in the report: values that lie far off are left out, and what values scatter beyond
    their bounds is in the weights."""
    campaign: Mapping[str, CampaignValue]
    """Means weighted by the bounds alone, as `gsapp estimate` gives them. A run that was kept
    before these were has those of the report."""
    failures: Mapping[str, str]  # Why, by id of the maneuver that gave nothing.
    outlying_maneuvers: tuple[str, ...]
    """Maneuvers whose values lie far off in several derivatives."""
    bounds_ratio: float | None
    """Scatter over bounds, 1 if they are honest; None where nothing was flown three times."""
    remarks: tuple[str, ...]
    inputs: tuple[InputFile, ...]
    versions: Mapping[str, str]
    content: Mapping[str, Any]  # Its request as the catalog holds it.
    folder: Path  # Of the catalog.

    @property
    def name(self) -> str:
        """Return how to call it: its label, else its number."""
        return self.label or f"run {self.number}"

    @property
    def request(self) -> RunRequest:
        """Return what it was asked for: every maneuver with its edges, every setting.

        Raises `FlightError` if this program cannot read all of it.
        """
        return request_from_json(self.content, self.folder).with_changes(label=self.label)


def save_run(catalog: Catalog, outcome: RunOutcome) -> int:
    """Keep a run, whole or not at all; return its number.

    Its flights and maneuvers are stored with it. Where the run used all that stands in a flight,
    these are then the maneuvers of that flight; otherwise those that the catalog has stay as they
    are.

    Raises `FlightError` if the catalog cannot be written, or the run was made with other
    certificates than the flights' own.
    """
    check_storable(catalog.path, outcome.request.calibration)
    record = _run_record(catalog, outcome)
    model = outcome.request.known_model
    with catalog.transaction():
        places = _store_flights(catalog, outcome)
        if model is not None:
            text = toml_text(model.model_dump(exclude_none=True))
            store_model(
                catalog,
                StoredModel(
                    name=model.name, content=text, parent=model.parent, evidence=model.evidence
                ),
            )
        number = store_campaign_run(catalog, record)
        for fit in catalog_runs(outcome.result, places, kept=number):
            store_run(catalog, fit)
    return number


def update_run_means(catalog: Catalog, outcome: RunOutcome) -> None:
    """Keep other means of a kept run, of the same fits; see `excluding`.

    `outcome`: with its number.

    Raises `UnknownNameError` if there is no such run. Raises `FlightError` if the catalog cannot be
    written.
    """
    update_campaign_run(catalog, _run_record(catalog, outcome), outcome.number or 0)


def check_storable(catalog: Path, calibration: str) -> None:
    """Raise `FlightError` where results with other certificates would go into a catalog.

    A catalog keeps one set of maneuvers and estimates of a flight: those of its own certificates.
    """
    if calibration:
        raise FlightError(
            f"{catalog} keeps what the flights' own certificates give; leave out the catalog, or "
            f"the certificates of '{calibration}'"
        )


def stored_runs(catalog: Catalog) -> tuple[StoredRun, ...]:
    """Return the runs that were not forgotten, the oldest first."""
    return tuple(_stored_run(catalog, one) for one in list_campaign_runs(catalog))


def load_run(catalog: Catalog, number: int) -> StoredRun:
    """Return one run.

    Raises `UnknownNameError` if there is none of that number, or it was forgotten.
    """
    return _stored_run(catalog, get_campaign_run(catalog, number))


def rename_run(catalog: Catalog, number: int, label: str) -> None:
    """Call a run something else; see `load_run`."""
    set_campaign_run_label(catalog, number, label.strip())


def forget_run(catalog: Catalog, number: int) -> None:
    """Leave a run and its fits out of everything; `recall_run` brings it back. See `load_run`."""
    delete_campaign_run(catalog, number)


def recall_run(catalog: Catalog, number: int) -> None:
    """Bring back a run that was forgotten.

    Raises `UnknownNameError` if there never was one of that number.
    """
    restore_campaign_run(catalog, number)


def _run_record(catalog: Catalog, outcome: RunOutcome) -> CampaignRun:
    request = outcome.request
    return CampaignRun(
        label=request.label,
        method=_method_used(outcome),
        axis=request.axis,
        aircraft=outcome.aircraft,
        flights=tuple(one.name for one in outcome.flights),
        request=request_json(request, catalog.path.absolute().parent),
        settings=describe_settings(request),
        inputs=outcome.inputs,
        versions=outcome.versions,
        result=_result_json(outcome),
    )


def _method_used(outcome: RunOutcome) -> str:
    """Return the method that gave the values: in gusts filter error, where another was asked."""
    results = outcome.result.results
    used = {one.estimate.method for one in results if one.estimate is not None}
    return used.pop() if len(used) == 1 else outcome.request.method


def _store_flights(catalog: Catalog, outcome: RunOutcome) -> dict[str, CatalogManeuver]:
    """Store the flights with their maneuvers; return where each maneuver of the run stands."""
    names: dict[tuple[int, str], str] = {}
    for number, entry in enumerate(outcome.flights):
        if entry.complete:
            store_entry(catalog, entry)
            called = tuple(one.id for one in entry.maneuvers)
        else:
            called = add_entry(catalog, entry)
        names |= {(number, one.id): name for one, name in zip(entry.maneuvers, called, strict=True)}
    request = outcome.request
    numbers = {path: number for number, path in enumerate(request.flights)}
    found = {}
    for one in request.maneuvers:
        number = numbers[one.flight]
        id_ = f"{number + 1}:{one.id}" if len(request.flights) > 1 else one.id
        found[id_] = CatalogManeuver(
            flight=outcome.flights[number].name,
            name=names[number, one.id],
            edges=(one.t_start, one.t_end),
        )
    return found


def _result_json(outcome: RunOutcome) -> dict[str, Any]:
    summary = outcome.summary
    campaign = campaign_values(
        [
            one.estimate
            for one in outcome.result.results
            if one.maneuver.id not in summary.excluded_maneuvers
        ]
    )
    return {
        "maneuvers": len(outcome.result.results),
        "values": {name: asdict(one.value) for name, one in summary.derivatives.items()},
        "campaign": {name: asdict(one) for name, one in campaign.items()},
        "failures": {
            one.maneuver.id: one.failure for one in outcome.result.results if one.estimate is None
        },
        "wild": [one.maneuver for one in summary.outlying_maneuvers],
        "bounds_ratio": summary.bounds_ratio,
        "remarks": [*outcome.remarks, *outcome.result.remarks],
    }


def _stored_run(catalog: Catalog, record: CampaignRun) -> StoredRun:
    try:
        return StoredRun(
            number=record.number or 0,
            label=record.label,
            created_at=datetime.fromisoformat(record.made_at),
            method=record.method,
            axis=record.axis,
            aircraft=record.aircraft,
            flights=record.flights,
            maneuver_count=int(record.result["maneuvers"]),
            settings=record.settings,
            values=_campaign_values(record.result["values"]),
            campaign=_campaign_values(record.result.get("campaign", record.result["values"])),
            failures=record.result["failures"],
            outlying_maneuvers=tuple(record.result["wild"]),
            bounds_ratio=record.result["bounds_ratio"],
            remarks=tuple(record.result["remarks"]),
            inputs=record.inputs,
            versions=record.versions,
            content=record.request,
            folder=catalog.path.absolute().parent,
        )
    except (KeyError, TypeError, ValueError) as error:
        raise FlightError(
            f"the run {record.number} in the catalog {catalog.path} cannot be read ({error}); "
            "restore a copy of the catalog"
        ) from error


def _campaign_values(content: Mapping[str, Any]) -> dict[str, CampaignValue]:
    return {name: CampaignValue(**one) for name, one in content.items()}
