"""Linear models in a report: error tables 7.4.1 and 7.4.2 of the source, modes, and their JSON."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from gsapp.dynamics.linearization import LinearModel, Mode
from gsapp.foundation import FlightError
from gsapp.identification.campaign import Step
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.results import Method
from gsapp.identification.runs.outcome import Outcome
from gsapp.identification.summary.linear_comparison import (
    AxisComparison,
    LinearComparison,
    compare_linear,
)
from gsapp.quantities import channel
from gsapp.report.document import Paragraph, Part, Section, Table
from gsapp.report.linear_figures import MODEL_NAMES, linear_picture

__all__ = [
    "LinearComparison",
    "compare_linear_models",
    "comparison_json",
    "error_table",
    "kept_out_words",
    "linear_model_json",
    "linear_section",
    "mode_table",
    "model_name",
]

AXIS_TITLES: Final[Mapping[LinearAxis, str]] = {
    "lon": "longitudinal",
    "lat": "lateral-directional",
}
_DERIVATIVES: Final[Mapping[Method, str]] = {
    "ml": "maximum likelihood, appendix A",
    "ee": "equation error, appendix A",
    "ftr": "FTR, appendix A",
}


def compare_linear_models(
    outcome: Outcome, validate: Collection[Path] = (), *, progress: Step | None = None
) -> LinearComparison:
    """Compare three linear models on flights or maneuvers that were not used to fit them.

    Parameters
    ----------
    outcome : Outcome
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
    numbers = kept_out_numbers(outcome.request.flights, validate)
    return compare_linear(outcome.result, keep_out=numbers, progress=progress)


def kept_out_numbers(flights: Sequence[Path], validate: Collection[Path]) -> tuple[str, ...]:
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
            f"linear models cannot be judged on {', '.join(unknown)}, which is not among the "
            "flights of this report; name one of these"
        )
    if wanted and wanted == set(known):
        raise FlightError(
            "all flights are to judge the linear models and none is left to fit them on; name "
            "fewer of them"
        )
    return tuple(str(number) for number, path in enumerate(known, start=1) if path in wanted)


def model_name(name: str, method: Method) -> str:
    """Return what a model is called: the third is made from derivatives of some method."""
    return _DERIVATIVES[method] if name == "ml" else MODEL_NAMES[name]


def kept_out_words(one: AxisComparison) -> str:
    """Return in a sentence what the models of an axis were fitted on, and judged on."""
    judged = (
        f"flight {' and '.join(one.flights)}"
        if one.flights
        else "every other maneuver of each kind"
    )
    return (
        f"The {AXIS_TITLES[one.axis]} models were fitted on {_count(one.fitted)} and judged on "
        f"{_count(one.judged)} that none of them saw ({judged}): driven by the measured inputs "
        "alone, each maneuver with a level and a start of its own."
    )


def _count(maneuvers: tuple[str, ...]) -> str:
    number = len(maneuvers)
    return f"{number} maneuver{'' if number == 1 else 's'}"


def error_table(one: AxisComparison, method: Method) -> Table:
    """Return RMS error over range in percent by variable and model; the least of each is marked."""
    rows = []
    for name in one.outputs:
        errors = {model: one.errors[model][name] for model in one.models}
        least = min(errors.values())
        rows.append((channel(name).symbol, *(_error(value, least) for value in errors.values())))
    return Table(
        caption=f"RMS error over range, percent, of the {AXIS_TITLES[one.axis]} models; "
        "* the least of each row",
        columns=("variable", *(model_name(name, method) for name in one.models)),
        rows=tuple(rows),
        numeric=frozenset(range(1, 1 + len(one.models))),
    )


def _error(value: float, least: float) -> str:
    if not math.isfinite(value):
        return "runs away"
    return f"{value:.2f} *" if value == least else f"{value:.2f}"


def mode_table(models: Mapping[str, LinearModel], *, caption: str) -> Table:
    """Return the modes of models, by what each is called.

    A real mode has a time constant, negative where it grows; a pair has frequency and damping too.
    """
    rows = [
        (
            name,
            mode.name,
            f"{mode.pole.real:+.3f}" + (f" ± {mode.pole.imag:.3f}i" if mode.pole.imag else ""),
            f"{mode.frequency:.2f}" if mode.pole.imag else "",
            f"{mode.damping:.2f}" if mode.pole.imag else "",
            _time_constant(mode),
        )
        for name, model in models.items()
        for mode in model.modes()
    ]
    return Table(
        caption=caption,
        columns=(
            "model", "mode", "pole [1/s]", "frequency [rad/s]", "damping ratio",
            "time constant [s]",
        ),
        rows=tuple(rows),
        numeric=frozenset({2, 3, 4, 5}),
    )  # fmt: skip


def _time_constant(mode: Mode) -> str:
    if not math.isfinite(mode.time_constant):
        return "neutral"
    return f"{abs(mode.time_constant):.2f}" + (" (grows)" if mode.time_constant < 0.0 else "")


def linear_section(comparison: LinearComparison, *, units: str) -> Section:
    """Return the section on linear models: how well they follow what they never saw, their modes.

    Parameters
    ----------
    comparison : LinearComparison
    units : {"US", "SI"}
    """
    parts: list[Part] = []
    for axis, one in comparison.axes.items():
        parts.append(Paragraph(text=kept_out_words(one)))
        parts.append(error_table(one, comparison.method))
        parts.append(linear_picture(one, units=units))
        parts.append(
            mode_table(
                {
                    model_name(name, comparison.method): fitted.model
                    for name, fitted in one.models.items()
                },
                caption=f"Modes of the {AXIS_TITLES[axis]} models that were compared",
            )
        )
    parts += [Paragraph(text=f"{_sentence(text)}.", kind="note") for text in comparison.remarks]
    return Section(title="Linear models against flight", parts=tuple(parts))


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def comparison_json(comparison: LinearComparison) -> dict[str, Any]:
    """Return a comparison for programs: the JSON of ``gsapp linear-models``, less whole flights."""
    content: dict[str, Any] = {"lon": None, "lat": None}
    for axis, one in comparison.axes.items():
        content[axis] = {
            name: {
                **linear_model_json(fitted.model),
                "by_maneuver_pct": {
                    output: number_or_none(value) for output, value in one.errors[name].items()
                },
                "fitted_on": list(one.fitted),
                "judged_on": list(one.judged),
                "remarks": list(fitted.remarks),
            }
            for name, fitted in one.models.items()
        }
    content["remarks"] = list(comparison.remarks)
    return content


def linear_model_json(model: LinearModel) -> dict[str, Any]:
    """Return matrices, names and modes of a linear model, SI."""
    return {
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


def number_or_none(value: float) -> float | None:
    """Return a number as JSON has it: None for what is not finite."""
    return float(value) if math.isfinite(value) else None
