"""``gsapp linear-models``: three linear models, judged on a flight that none of them saw."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import FlightPaths, JsonFile, Units

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.dynamics.model import Model
    from gsapp.identification.linear_models.linear_model_files import PublishedErrors
    from gsapp.identification.linear_models.model_comparison import EvaluatedModel
    from gsapp.identification.linear_models.signals import LinearAxis
    from gsapp.identification.maneuver import FlightWithManeuvers, Maneuver

    Judged = dict[LinearAxis, dict[str, EvaluatedModel]]


@takes_settings(MANEUVER_SETTINGS, "aircraft", "as_found", "channel_map", "calibration")
def linear_models(
    flights: FlightPaths,
    validate: Annotated[
        Path,
        typer.Option(readable=False, metavar="FLIGHT", help="Flight to validate the models on"),
    ],
    model: Annotated[
        str | None, typer.Option(metavar="FILE", help="Model whose effects are known")
    ] = None,
    order_lon: Annotated[
        str, typer.Option(metavar="N|auto", help="Order of the longitudinal subspace model")
    ] = "2",
    order_lat: Annotated[
        str, typer.Option(metavar="N|auto", help="Order of the lateral-directional subspace model")
    ] = "4",
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False, metavar="DIR", help="Write the models to this folder, one file each"
        ),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Fit three linear models, and judge them on another flight.

    Batch least squares, subspace with prediction error, and maximum likelihood derivatives
    through appendix A; RMS error over range as in tables 7.4.1 and 7.4.2 of the source.

    Example: gsapp linear-models flights/a --validate flights/b --aircraft b777
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import load_flown_flights, print_aircraft_warnings
    from gsapp.cli._usage_errors import CommandUsageError, is_same_path
    from gsapp.dynamics.model import load_model
    from gsapp.flight.flight import calibration_sentences
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.foundation import FlightError
    from gsapp.identification.axes import AXIS_TITLES
    from gsapp.identification.campaign import CampaignSettings, run_campaign
    from gsapp.identification.estimate_corrections import derivatives_about_flown_cg
    from gsapp.identification.instrument_effects import effective_records
    from gsapp.identification.linear_models.linear_model_files import (
        PUBLISHED_AIRCRAFT,
        published_errors,
    )
    from gsapp.identification.linear_models.signals import LINEAR_STATES
    from gsapp.identification.maneuver import no_maneuvers_text

    if any(is_same_path(one, validate) for one in flights):
        raise CommandUsageError(
            f"{validate} would validate models fitted to it; remove it from the flights, or "
            "validate on another"
        )
    orders: dict[LinearAxis, int | None] = {"lon": _order(order_lon), "lat": _order(order_lat)}
    console = PlainConsole(stderr=is_stdout(json))
    known = None if model is None else load_model(model)
    every = load_flown_flights([*flights, validate], ManeuverSettings(**settings), console)
    fitted = [one for flown in every[:-1] for one in flown.maneuvers]
    other = every[-1]
    if not other.maneuvers:
        raise FlightError(
            f"no maneuver to validate models on: {no_maneuvers_text(every[-1:])}; choose "
            "another flight"
        )
    if not fitted:
        raise FlightError(f"no maneuver to fit models to: {no_maneuvers_text(every[:-1])}")
    with console.status("maximum likelihood"):
        campaign = run_campaign(fitted, CampaignSettings(known_model=known, single_method=True))
    # The models are those of the aircraft as it flew where they are judged.
    derivatives = derivatives_about_flown_cg(
        {name: one.mean for name, one in campaign.values.items()},
        other.cg_shift,
        other.aircraft.geometry,
    )
    reasons: list[str] = [
        *(one.assumed_aircraft_text for one in every if one.assumed_aircraft_text),
        *calibration_sentences(one.flight for one in every),
        *campaign.remarks,
    ]
    found: Judged = {}
    true, _ = effective_records(fitted, known)
    for axis in LINEAR_STATES:
        with console.status(f"{AXIS_TITLES[axis]} models"):
            try:
                found[axis] = _compare(axis, true, other, known, derivatives, orders[axis])
            except FlightError as error:
                reasons.append(f"no {AXIS_TITLES[axis]} models: {error}")
    if not found:
        raise FlightError(f"there are no linear models: {'; '.join(reasons)}")
    if json is not None:
        content: dict[str, Any] = {"lon": None, "lat": None}
        for axis, models in found.items():
            content[axis] = {name: _json(one) for name, one in models.items()}
        write_json(json, {**content, "remarks": reasons})
    if out is not None:
        _save(out, found, [one.flight.name for one in every[:-1]])
    print_aircraft_warnings(console, (one.file_aircraft for one in every))
    # What the source found is no measure for another aircraft.
    published = published_errors() if other.aircraft.name == PUBLISHED_AIRCRAFT else {}
    for axis, models in found.items():
        _describe(console, axis, models, published, other.flight.name)
    for sentence in reasons:
        console.print_sentence(sentence, "yellow")


def _compare(
    axis: LinearAxis,
    fitted: Sequence[Maneuver],
    other: FlightWithManeuvers,
    known: Model | None,
    derivatives: Mapping[str, float],
    order: int | None,
) -> dict[str, EvaluatedModel]:
    """Fit and judge the models of one axis on the maneuvers that move its surfaces alone."""
    from gsapp.identification.axes import AXIS_SURFACES
    from gsapp.identification.instrument_effects import effective_records
    from gsapp.identification.linear_models.model_comparison import evaluate_linear_models
    from gsapp.identification.maneuver import cut_maneuver

    own = set(AXIS_SURFACES[axis])
    whole = cut_maneuver(
        other.flight, other.aircraft, other.maneuvers[0].t_start, other.maneuvers[-1].t_end,
        id="whole", inputs=(),
    )  # fmt: skip
    (whole, *judged), _ = effective_records((whole, *other.maneuvers), known)
    on, against = (
        [one for one in group if one.inputs and set(one.inputs) <= own]
        for group in (fitted, judged)
    )
    return evaluate_linear_models(on, against, whole, axis, derivatives, order=order)


def _save(folder: Path, found: Judged, flights: Sequence[str]) -> None:
    """Write the models whose states the vocabulary knows; a subspace model's have no meaning."""
    from gsapp.identification.axes import AXIS_TITLES
    from gsapp.identification.linear_models.linear_model_files import save_linear_model
    from gsapp.identification.methods import DEFAULT_METHOD, linear_model_title

    folder.mkdir(parents=True, exist_ok=True)
    for axis, models in found.items():
        for name, one in models.items():
            if name != "subspace":
                save_linear_model(
                    one.model, folder / f"{name}-{axis}.toml",
                    name=f"{linear_model_title(name, DEFAULT_METHOD)}, {AXIS_TITLES[axis]}",
                    source=f"fitted on {', '.join(flights)}",
                )  # fmt: skip


def _order(text: str) -> int | None:

    from gsapp.cli._usage_errors import CommandUsageError

    if text == "auto":
        return None
    if not text.isdigit() or int(text) < 1:
        raise CommandUsageError(f"'{text}' is not an order; give a whole number from 1, or auto")
    return int(text)


def _json(judged: EvaluatedModel) -> dict[str, Any]:
    from gsapp.report.linear_text import linear_model_json, number_or_none

    return {
        **linear_model_json(judged.model),
        "rms_over_range_pct": {
            name: number_or_none(value) for name, value in judged.rms_over_range_pct.items()
        },
        "by_maneuver_pct": {
            name: number_or_none(value) for name, value in judged.by_maneuver_pct.items()
        },
        "remarks": list(judged.remarks),
    }


def _describe(
    console: PlainConsole,
    axis: LinearAxis,
    models: Mapping[str, EvaluatedModel],
    published: Mapping[str, PublishedErrors],
    flight: str,
) -> None:

    from gsapp.identification.axes import AXIS_TITLES
    from gsapp.identification.methods import DEFAULT_METHOD, linear_model_title

    table = console.create_table(
        title=f"{AXIS_TITLES[axis]}: RMS error over range in {flight}, %",
        caption="whole flight; its maneuvers, each from its own start"
        + ("; the source's (tables 7.4.1, 7.4.2)" if published else ""),
        caption_justify="left",
    )
    table.add_column("", no_wrap=True)
    for name in models:
        table.add_column(linear_model_title(name, DEFAULT_METHOD), justify="right")
    first = next(iter(models.values()))
    for channel in first.rms_over_range_pct:
        table.add_row(
            channel,
            *(
                f"{_shown(one.rms_over_range_pct.get(channel))}; "
                f"{_shown(one.by_maneuver_pct.get(channel))}"
                + (f"; {getattr(published[channel], name):z.2f}" if published else "")
                for name, one in models.items()
            ),
        )
    console.print_unwrapped(table)
    for name, one in models.items():
        modes = ", ".join(
            f"{mode.name} {mode.pole.real:z.3f}"
            + (f" ± {mode.pole.imag:z.3f}i" if mode.pole.imag else "")
            for mode in one.model.modes()
        )
        remarks = f" ({'; '.join(one.remarks)})" if one.remarks else ""
        console.print_sentence(f"{linear_model_title(name, DEFAULT_METHOD)}{remarks}: {modes}  1/s")


def _shown(value: float | None) -> str:
    if value is None:
        return "none"
    return f"{value:z.2f}" if math.isfinite(value) else "diverges"
