"""Linear models in words, rows and JSON: error tables 7.4.1 and 7.4.2 of the source, modes."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

from gsapp.dynamics.linearization import LinearModel, Mode
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.campaign import CampaignProgressCallback
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.runs.inputs import FlightCache, flight_open_requests
from gsapp.identification.runs.run_execution import RunOutcome
from gsapp.identification.summary.campaign_linear_models import (
    AxisValidation,
    LinearModelValidation,
    validate_linear_models,
)
from gsapp.identification.summary.mode_uncertainty import ModeUncertainty
from gsapp.report.settings import REPORT

MODE_COLUMNS: Final = (
    "mode", "pole [1/s]", "frequency [rad/s]", "damping ratio", "time constant [s]",
)  # fmt: skip


MODE_BOUND_COLUMNS: Final = ("mode", "frequency [rad/s]", "damping ratio", "time constant [s]")


def compare_linear_models(
    outcome: RunOutcome,
    validate: Collection[Path] = (),
    *,
    flights: FlightCache | None = None,
    progress: CampaignProgressCallback | None = None,
) -> LinearModelValidation:
    """Compare three linear models on flights or maneuvers that were not used to fit them.

    Parameters
    ----------
    validate : collection of Path
        Flights of the outcome to judge on. Empty: for each axis the last flight that flew it;
        where only one did, every other maneuver of each kind.
    progress : callable, optional
        As of `gsapp.identification.campaign.run_campaign`.

    Raises
    ------
    FlightError
        If a flight is not one of the outcome, or all of them are named.
    CanceledError
        If `progress` returned False.
    """
    numbers = validation_flight_numbers(outcome.request.flights, validate)
    flight_cache = FlightCache() if flights is None else flights
    openings = flight_open_requests(outcome.request)

    def cut(number: str, start: float, stop: float) -> Maneuver:
        opened = flight_cache.open(openings[int(number or "1") - 1]).opened
        return opened.cut("whole", start, stop, (), "")

    return validate_linear_models(
        outcome.result,
        keep_out=numbers,
        without=outcome.summary.excluded_maneuvers,
        cut=cut,
        progress=progress,
    )


def validation_flight_numbers(
    flights: Sequence[Path], validate: Collection[Path]
) -> tuple[str, ...]:
    """Return the numbers of the flights to judge on among all.

    Raises
    ------
    FlightError
        If a flight is not among them, or all of them are named.
    """
    known = [path.absolute() for path in flights]
    wanted = {path.absolute() for path in validate}
    unknown = [path.name for path in validate if path.absolute() not in known]
    if unknown:
        raise FlightError(
            f"linear models cannot be validated on {', '.join(unknown)}, which is not among the "
            "flights of this report; name one of these"
        )
    if wanted and wanted == set(known):
        raise FlightError("all flights are for validation and none is left to fit; name fewer")
    return tuple(str(number) for number, path in enumerate(known, start=1) if path in wanted)


def validation_text(one: AxisValidation) -> str:
    """Return in a sentence what the models of an axis were fitted on, and judged on."""
    judged = (
        f"{_count(one.validation_maneuvers)} of {' and '.join(one.flights)}"
        if one.flights
        else f"{_count(one.validation_maneuvers)} (every other one of each kind)"
    )
    return (
        f"The {AXIS_TITLES[one.axis]} models were fitted on {_count(one.fitted_maneuvers)} and "
        f"validated on {judged} not used in the fit: driven by the measured inputs, with an "
        "initial state and offsets for each maneuver."
    )


def _count(maneuvers: tuple[str, ...]) -> str:
    number = len(maneuvers)
    return f"{number} maneuver{'' if number == 1 else 's'}"


def error_rows(
    outputs: Sequence[str], errors: Mapping[str, Mapping[str, float]]
) -> tuple[tuple[str, ...], ...]:
    """Return RMS error over range in percent, a row for each variable, a column for each model.

    The least of each row carries a star.

    Parameters
    ----------
    errors : mapping of str to mapping of str to float
        By model and output: `AxisValidation.errors`, or ``whole``.
    """
    rows = []
    for name in outputs:
        found = [own[name] for own in errors.values()]
        rows.append((name, *(_error(value, min(found)) for value in found)))
    return tuple(rows)


def _error(value: float, least: float) -> str:
    if not math.isfinite(value):
        return "diverges"
    return f"{value:.2f} *" if value == least else f"{value:.2f}"


def mode_rows(model: LinearModel) -> tuple[tuple[str, ...], ...]:
    """Return a row for each mode, as `MODE_COLUMNS` has them.

    A real mode has a time constant alone, a pair frequency and damping too; what grows is said.
    """
    return tuple(
        (
            mode.name,
            f"{mode.pole.real:+.3f}" + (f" ± {mode.pole.imag:.3f}i" if mode.pole.imag else ""),
            f"{mode.frequency:.2f}" if mode.pole.imag else "",
            f"{mode.damping:.2f}" if mode.pole.imag else "",
            _time_constant(mode),
        )
        for mode in model.modes()
    )


def _time_constant(mode: Mode, std: float = math.nan) -> str:
    if not abs(mode.time_constant) < REPORT.neutral_time_constant:
        return "neutral"
    shown = _with_bound(abs(mode.time_constant), std)
    return shown + (" (grows)" if mode.time_constant < 0.0 else "")


def mode_cells(one: ModeUncertainty) -> tuple[str, ...]:
    """Return the cells of a mode with its bounds, as `MODE_BOUND_COLUMNS` has them."""
    mode = one.mode
    return (
        mode.name,
        _with_bound(mode.frequency, one.frequency_std),
        _with_bound(mode.damping, one.damping_std) if mode.pole.imag else "",
        _time_constant(mode, one.time_constant_std),
    )


def _with_bound(value: float, std: float) -> str:
    if not math.isfinite(value):
        return ""
    if not math.isfinite(std) or std <= 0.0:
        return f"{value:.2f}"
    digits = min(max(0, 1 - math.floor(math.log10(std))), 4)
    return f"{value:.{digits}f} ± {std:.{digits}f}"


def comparison_json(comparison: LinearModelValidation) -> dict[str, Any]:
    """Return a comparison for programs: the JSON of ``gsapp linear-models``, and what judged."""
    content: dict[str, Any] = {"lon": None, "lat": None}
    for axis, one in comparison.axes.items():
        content[axis] = {
            name: {
                **linear_model_json(fitted.model),
                "rms_over_range_pct": _numbers(one.whole_flight_errors.get(name, {})),
                "by_maneuver_pct": _numbers(one.errors[name]),
                "fitted_on": list(one.fitted_maneuvers),
                "judged_on": list(one.validation_maneuvers),
                "remarks": list(fitted.remarks),
            }
            for name, fitted in one.models.items()
        }
    content["remarks"] = list(comparison.remarks)
    return content


def linear_model_json(model: LinearModel) -> dict[str, Any]:
    """Return matrices, names and modes of a linear model, and what it is about, SI."""
    return {
        "about": None if model.operating_point is None else asdict(model.operating_point),
        **{key: getattr(model, key).tolist() for key in ("A", "B", "C", "D")},
        "states": list(model.states),
        "inputs": list(model.inputs),
        "outputs": list(model.outputs),
        "modes": [
            {
                "name": mode.name,
                "real": mode.pole.real,
                "imag": mode.pole.imag,
                "frequency": mode.frequency,
                "damping": number_or_none(mode.damping),
                "time_constant": number_or_none(mode.time_constant),
            }
            for mode in model.modes()
        ],
    }


def _numbers(values: Mapping[str, float]) -> dict[str, float | None]:
    return {name: number_or_none(value) for name, value in values.items()}


def number_or_none(value: float) -> float | None:
    """Return a number as JSON has it: None for what is not finite."""
    return float(value) if math.isfinite(value) else None
