"""Derivatives, their report, and the effect that a model lacks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from gsapp.api.result import FlightSource, Result, request_values, table_of, unit_system
from gsapp.discrepancy.flight_search import check_effects, search_flights
from gsapp.discrepancy.results import DiscrepancyResult, discrepancy_json
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.dynamics.model import load_model
from gsapp.flight.flight_loader import find_flights
from gsapp.flight.info import local_timestamp
from gsapp.identification.results import Estimate
from gsapp.identification.runs.inputs import FlightCache
from gsapp.identification.runs.request import RunRequest, check_names
from gsapp.identification.runs.run_execution import RunOutcome, check_fitted, execute_run
from gsapp.quantities import channel, convert_text_units, convert_value_and_std
from gsapp.report.campaign_report import write_campaign_report
from gsapp.report.discrepancy_folder import (
    MODEL_FILE,
    check_output_folder,
    write_discrepancy_folder,
)
from gsapp.report.discrepancy_report import discrepancy_document
from gsapp.report.discrepancy_text import HEADLINES
from gsapp.report.document_writer import check_report_path
from gsapp.report.estimate_export import outcome_json
from gsapp.report.estimate_text import estimate_headline, outcome_remarks
from gsapp.report.fit_figures import fit_figure
from gsapp.report.linear_text import compare_linear_models, validation_flight_numbers
from gsapp.report.provenance import search_provenance


def estimate(
    flights: FlightSource | Sequence[FlightSource], *, units: str = "us", **settings: Any
) -> Result[RunOutcome]:
    """Estimate stability and control derivatives, with bounds, as ``gsapp estimate``.

    Parameters
    ----------
    flights : Flight, str, Path, or sequence of them
        Open flights, or the paths of flights.
    units : {"us", "si"}, optional
        Of the figures; derivatives are per radian.
    **settings
        aircraft, method, axis, model, free, held and so on; see the table.

    Returns
    -------
    Result
        Tables ``derivatives`` (a row for each maneuver and derivative; ``std`` counts that
        residuals are colored, ``cramer_rao`` does not) and ``means`` (over all maneuvers). A
        figure for each maneuver: measured against computed responses.
    """
    system = unit_system(units)
    outcome = _run(flights, settings, FlightCache())
    return Result(
        summary=estimate_headline(outcome.summary, outcome.result),
        outcome=outcome,
        content=outcome_json(outcome),
        tables={
            "derivatives": table_of(
                "flight maneuver t_start t_end inputs method derivative value std cramer_rao "
                "status",
                _derivative_rows(outcome),
                t_start="s", t_end="s",
            ),
            "means": table_of(
                "derivative mean std noise systematic disagreement scatter n",
                (
                    (name, value.mean, value.std, value.noise, value.systematic,
                     value.disagreement, value.scatter, value.n)
                    for name, value in (
                        (name, one.value) for name, one in outcome.summary.derivatives.items()
                    )
                ),
            ),
        },
        figures={
            one.maneuver.id: figure
            for one in outcome.result.results
            if (figure := fit_figure(one, units=system)) is not None
        },
        remarks=tuple(convert_text_units(one, system) for one in outcome_remarks(outcome)),
    )  # fmt: skip


def _run(
    flights: FlightSource | Sequence[FlightSource], settings: dict[str, Any], cache: FlightCache
) -> RunOutcome:
    paths, values = request_values(flights, settings)
    request = RunRequest(flights=find_flights(paths), **values)
    check_names(request, load_model(request.model) if request.model else None)
    outcome = execute_run(request, flights=cache)
    check_fitted(outcome)
    return outcome


def _derivative_rows(outcome: RunOutcome) -> Iterator[tuple[Any, ...]]:
    for one in outcome.result.results:
        maneuver = one.maneuver
        where = (maneuver.flight, maneuver.id, maneuver.t_start, maneuver.t_end)
        if one.estimate is not None:
            yield from _rows((*where, "+".join(maneuver.inputs)), one.estimate)
    for joint in outcome.result.joint:
        yield from _rows(("", f"joint {joint.axis}", None, None, ""), joint)


def _rows(where: tuple[Any, ...], found: Estimate) -> Iterator[tuple[Any, ...]]:
    for name, one in found.derivatives.items():
        yield (*where, found.method, name, one.value, one.std, one.cramer_rao, one.status)


def report(
    flights: FlightSource | Sequence[FlightSource] | Result[RunOutcome],
    out: str | Path,
    *,
    validate: FlightSource | Sequence[FlightSource] = (),
    units: str = "us",
    dated: bool = True,
    **settings: Any,
) -> tuple[Path, ...]:
    """Write the report on one flight or a campaign, as ``gsapp report``.

    Parameters
    ----------
    flights : Flight, str, Path, sequence of them, or Result
        Flights, folders with flights, or what `gsapp.estimate` returned.
    out : str or Path
        A ``.html`` or ``.pdf`` file; or a folder for both, figures and results as files.
    validate : Flight, str, Path, or sequence of them, optional
        Flights to validate linear models on; by default the last.
    units : {"us", "si"}, optional
        Of the report.
    dated : bool, optional
        Whether it has the date.
    **settings
        As for `gsapp.estimate`; none where its result is given.

    Returns
    -------
    tuple of Path
        The files written.
    """
    place, system = Path(out), unit_system(units)
    check_report_path(place)
    cache = FlightCache()
    if isinstance(flights, Result):
        if settings:
            raise TypeError(f"settings belong to gsapp.estimate: {', '.join(settings)}")
        outcome = flights.outcome
    else:
        outcome = _run(flights, settings, cache)
    others = request_values(validate, {})[0]
    linear = None
    if others:
        validation_flight_numbers(outcome.request.flights, others)
        linear = compare_linear_models(outcome, others, flights=cache)
    return write_campaign_report(
        outcome, place, units=system, written=local_timestamp() if dated else None, linear=linear,
        flights=cache,
    )  # fmt: skip


def discrepancy(
    flights: FlightSource | Sequence[FlightSource],
    out: str | Path = "",
    *,
    units: str = "us",
    **settings: Any,
) -> Result[DiscrepancyResult]:
    """Name and add the effect that a model lacks, as ``gsapp discrepancy``.

    Parameters
    ----------
    flights : Flight, str, Path, or sequence of them
        Open flights, or the paths of flights, of one aircraft.
    out : str or Path, optional
        Folder for the revised model, the report and its figures; nothing is written without.
    units : {"us", "si"}, optional
        Of tables, figures and report.
    **settings
        aircraft, model, held_out and so on; see the table.

    Returns
    -------
    Result
        Tables ``effects``, ``ranking``, ``gap`` (residuals held out, rms, before and after),
        ``disagreements`` and ``values``; the figures of the report. ``outcome.model`` is the
        revised model.
    """
    system, folder = unit_system(units), Path(out) if out else None
    if folder is not None:
        check_output_folder(folder)
    paths, values = request_values(flights, settings)
    request = DiscrepancySettings(**{"check_instruments": True, **values})
    check_effects(request)
    flown, found = search_flights(paths, request)
    aircraft = flown[0].aircraft.name
    if folder is not None:
        write_discrepancy_folder(
            found, folder, aircraft=aircraft, provenance=search_provenance(paths, request),
            units=system,
        )  # fmt: skip
    figures = discrepancy_document(found, aircraft=aircraft, units=system).figures
    return Result(
        summary=f"{HEADLINES[found.verdict]} {found.why}",
        outcome=found,
        content=discrepancy_json(found, model=folder and folder / MODEL_FILE),
        tables={
            "effects": table_of(
                "effect title parameter value std confidence",
                (
                    (one.effect, one.title, name, value, std, one.confidence)
                    for one in found.effects
                    for name, (value, std) in one.parameters.items()
                ),
            ),
            "ranking": table_of(
                "effect title score evidence held_out sigma",
                (
                    (one.effect, one.title, one.score, one.evidence, one.held_out, one.sigma)
                    for one in found.ranking
                ),
            ),
            "gap": table_of("channel unit before after floor", _gap_rows(found, system)),
            "disagreements": table_of(
                "coefficient channel maneuver t_start t_end rms_over_noise p_value",
                (
                    (one.coefficient, one.channel, one.maneuver, one.t_start, one.t_end,
                     one.rms / one.noise_floor if one.noise_floor else None, one.p_value)
                    for one in found.disagreements
                ),
                t_start="s", t_end="s",
            ),
            "values": table_of(
                "derivative before after std",
                ((name, one.before, one.after, one.std) for name, one in found.values.items()),
            ),
        },
        figures={one.name: one for one in figures},
        remarks=tuple(
            convert_text_units(one, system)
            for one in dict.fromkeys(
                (*found.warnings, *(text for one in flown for text in one.remarks))
            )
        ),
    )  # fmt: skip


def _gap_rows(found: DiscrepancyResult, system: str) -> Iterator[tuple[Any, ...]]:
    for name, one in found.gap.channels.items():
        unit = channel(name).unit
        before, after, shown = convert_value_and_std(one.before, one.after, unit, system)
        yield name, shown, before, after, convert_value_and_std(one.floor, 0.0, unit, system)[0]
