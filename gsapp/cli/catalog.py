"""``gsapp catalog``: search a campaign or a fleet, and ask it for groups, trends and changes."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gsapp.cli._options import DISPLAY_UNITS, JsonFile, Units

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.flight.catalog import EstimationRun, StoredManeuver


def catalog(
    file: Annotated[
        Path, typer.Argument(metavar="CATALOG", readable=False, help="As --catalog wrote it")
    ],
    what: Annotated[
        Literal["maneuvers", "groups", "trend", "changes"], typer.Argument(help="Question")
    ] = "maneuvers",
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME", help="Derivatives, or errors of instruments: alpha.bias"),
    ] = None,
    flight: Annotated[str | None, typer.Option(help="Of this flight")] = None,
    aircraft: Annotated[str | None, typer.Option(help="Of this aircraft")] = None,
    airframe: Annotated[
        str | None, typer.Option(help="Of this airframe, as flight.toml names it")
    ] = None,
    since: Annotated[
        str | None, typer.Option(metavar="DATE", help="Flown on this day or later: 2026-05-12")
    ] = None,
    until: Annotated[
        str | None, typer.Option(metavar="DATE", help="Flown by this day, month or year: 2026-05")
    ] = None,
    inputs: Annotated[
        str | None, typer.Option(metavar="da+dr", help="Exactly these surfaces moved")
    ] = None,
    kind: Annotated[
        Literal["doublet", "3-2-1-1", "pulse", "multistep", "sweep", "retrim", "step", "none"]
        | None,
        typer.Option(help="Shape of the input"),
    ] = None,
    worst_grade: Annotated[
        Literal["A", "B", "C", "D"], typer.Option(help="Exclude worse grades")
    ] = "D",
    where: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CHANNEL=LEAST:MOST",
            help="Condition before the input, as 'V=90 ft/s:'; also mach, reynolds, wing_loading",
        ),
    ] = None,
    note: Annotated[str | None, typer.Option(help="Text in the note")] = None,
    derivative: Annotated[
        str | None, typer.Option(metavar="NAME", help="Show every estimate of this derivative")
    ] = None,
    limit: Annotated[
        int | None,
        typer.Option(min=1, help="Maneuvers at most; by default all; the table shows 100"),
    ] = None,
    by: Annotated[
        str,
        typer.Option(
            metavar="KEY",
            help="Groups of values: airframe, aircraft, flight, inputs, kind, grade, year, month",
        ),
    ] = "airframe",
    against: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CONDITION",
            help="Condition of the trend: a channel, mach, reynolds, wing_loading or date; of "
            "changes, one whose trend is taken out first; repeatable",
        ),
    ] = None,
    method: Annotated[
        Literal["ml", "fem", "ee", "ftr"] | None,
        typer.Option(help="Values of this method; by default that of most values"),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            readable=False, metavar="FILE", help="Draw the trend or the changes: .png, .pdf, .svg"
        ),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FILE", help="Write the result as a table"),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
) -> None:
    """Search a campaign: maneuvers, groups, trends, changes.

    maneuvers: those that fit. groups: how many there are of each airframe, aircraft, month ..., and
    the mean of the values named. trend: a value against conditions, with random effects between
    airframes. changes: steps and drifts of values over time, with dates; all values by default.

    A derivative that a maneuver did not earn is unknown and counts nowhere.

    Example: gsapp catalog campaign.sqlite --inputs da+dr --where "V=90 ft/s:110 ft/s"

    Example: gsapp catalog campaign.sqlite --airframe "SN 3" --since 2026-05 --derivative Cm_alpha

    Example: gsapp catalog fleet.sqlite groups Cm_alpha Cm_de --by month

    Example: gsapp catalog fleet.sqlite trend Cm_alpha --against mach --by airframe --figure t.png

    Example: gsapp catalog fleet.sqlite changes Cm_de Cn_dr alpha.bias --since 2026
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._fleet import FleetRequest, run_fleet_request
    from gsapp.cli._usage_errors import as_usage_error, check_is_catalog
    from gsapp.dynamics.buildup import derivative_names
    from gsapp.flight.catalog import (
        Catalog,
        ManeuverFilter,
        find_maneuvers,
        list_estimated,
        list_flights,
        load_maneuvers,
        maneuvers_csv,
        search_runs,
    )
    from gsapp.foundation import write_atomically
    from gsapp.quantities import channel

    check_is_catalog(file, "gsapp maneuvers --catalog makes one")
    request = FleetRequest(
        what=what, names=tuple(names or ()), by=by, against=tuple(against or ()),
        method=method or "", figure=figure,
    )  # fmt: skip
    request.check()
    console = PlainConsole(stderr=is_stdout(json))
    with as_usage_error():
        conditions = dict(_condition(text) for text in where or ())
        for name in () if inputs is None else inputs.split("+"):
            channel(name)
        dates = (_date(since, "--since"), _date(until, "--until"))
    wanted = ManeuverFilter(
        flight=flight, aircraft=aircraft, airframe=airframe, since=dates[0], until=dates[1],
        kind=kind, worst_grade=worst_grade, conditions=conditions, text=note,
        inputs=None if inputs is None else inputs.split("+"),
    )  # fmt: skip
    with Catalog(file) as store:
        _check_name(file, "flight", flight, list_flights(store))
        if what != "maneuvers":
            run_fleet_request(console, store, wanted, request, json)
            return
        _check_name(file, "estimate of", derivative, {*list_estimated(store), *derivative_names()})
        row_ids = find_maneuvers(store, wanted)
        only_printed = json is None and csv is None
        most = limit or (_PRINTED if only_printed else len(row_ids))
        found = load_maneuvers(store, row_ids[:most])
        runs = {
            one.id: one
            for one in search_runs(store, row_ids={run for one in found for run in one.runs})
        }
    if csv is not None:
        write_atomically(csv, maneuvers_csv(found))
    write_json(json, [_json(one, runs) for one in found])
    if not is_stdout(json):
        _describe(console, found[: limit or _PRINTED], runs, derivative, len(row_ids))


_PRINTED = 100
"""Maneuvers that are printed where nobody says how many."""
_DATE = re.compile(r"\d{4}(-\d\d){0,2}")


def _date(text: str | None, option: str) -> str | None:
    from gsapp.foundation import FlightError

    if text is not None and not _DATE.fullmatch(text):
        raise FlightError(f"{option} '{text}' is no date; write 2026-05-12, 2026-05 or 2026")
    return text


def _check_name(catalog: Path, what: str, wanted: str | None, held: Collection[str]) -> None:
    """Raise `FlightError` where a catalog cannot hold a name: a slip, rather than nothing found."""
    from gsapp.foundation import FlightError
    from gsapp.foundation.name_suggestions import did_you_mean, format_names

    if wanted is None or wanted in held:
        return
    hint = did_you_mean(wanted, held, f"it holds {format_names(sorted(held), 12) or 'none'}")
    raise FlightError(f"{catalog} holds no {what} '{wanted}'; {hint}")


def _condition(text: str) -> tuple[str, tuple[float | None, float | None]]:
    """Read ``V=90 ft/s:110 ft/s``; either end may be empty."""
    from gsapp.flight.catalog.derived_conditions import condition_quantity
    from gsapp.foundation import FlightError
    from gsapp.quantities import units

    name, equals, span = text.partition("=")
    least, colon, most = span.partition(":")
    if not equals or not colon:
        raise FlightError(
            f"--where '{text}' cannot be read; write CHANNEL=LEAST:MOST, as 'V=90 ft/s:110 ft/s'"
        )
    quantity = condition_quantity(name.strip())

    def end(value: str) -> float | None:
        # A bare number is no speed in the units of the screen: it would find nothing, silently.
        return units.parse_quantity(value.strip(), quantity) if value.strip() else None

    return name.strip(), (end(least), end(most))


def _json(one: StoredManeuver, runs: dict[int | None, EstimationRun]) -> dict[str, Any]:
    return {
        "flight": one.flight,
        **one.maneuver.to_json(),
        "verdict": one.verdict or None,
        "note": one.maneuver.note,
        "conditions": {name: found.mean for name, found in one.conditions.items()},
        "runs": [
            {
                "id": number,
                "method": runs[number].method,
                "axis": runs[number].axis,
                "made_at": runs[number].made_at,
                "converged": runs[number].converged,
                "derivatives": {
                    name: {"value": found.value, "std": found.std, "status": found.status}
                    for name, found in runs[number].estimates.items()
                },
            }
            for number in one.runs
        ],
    }


def _describe(
    console: PlainConsole,
    found: Sequence[StoredManeuver],
    runs: dict[int | None, EstimationRun],
    derivative: str | None,
    count: int,
) -> None:
    from gsapp.cli._console import format_value_and_bound
    from gsapp.quantities import channel, from_si
    from gsapp.quantities.constants import DEGREE

    speed = channel("V").display_unit(DISPLAY_UNITS.get())

    columns = ("flight", "id", "start [s]", "inputs", "kind", "grade", "verdict", f"V [{speed}]")
    table = console.create_table(
        (f"{len(found)} of " if len(found) < count else "")
        + f"{count} maneuver{'' if count == 1 else 's'}",
        (*columns, "alpha [deg]", derivative or "runs"),
    )
    for one in found:
        maneuver = one.maneuver
        last = str(len(one.runs))
        if derivative is not None:
            shown = [
                f"{runs[number].method} {' ±'.join(format_value_and_bound(value.value, value.std))}"
                for number in one.runs
                if (value := runs[number].estimates.get(derivative)) is not None
                and value.value is not None
                and value.std is not None
            ]
            last = "\n".join(shown)
        table.add_row(
            one.flight, maneuver.id, f"{maneuver.t_start:z.2f}",
            "+".join(maneuver.inputs), maneuver.kind, maneuver.grade, one.verdict,
            "" if maneuver.V is None else f"{from_si(maneuver.V, speed, 'speed'):z.1f}",
            "" if maneuver.alpha is None else f"{maneuver.alpha / DEGREE:z.1f}",
            last,
        )  # fmt: skip
    console.print_unwrapped(table)
