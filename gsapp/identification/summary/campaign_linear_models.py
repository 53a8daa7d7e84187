"""Linear models with the means of a campaign, the bounds of their modes, and their validation.

Batch least squares, subspace and prediction error, and the derivatives through appendix A are made
from some of a campaign's maneuvers and driven by the measured inputs of the others (section 7.4).
The derivatives are estimated anew for it, so that nothing of the others is in them.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from gsapp.dynamics.linearization import LinearModel
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_SURFACES, AXIS_TITLES
from gsapp.identification.campaign import (
    CampaignProgressCallback,
    CampaignResult,
    CampaignSettings,
    run_campaign,
)
from gsapp.identification.estimate_corrections import derivatives_about_flown_cg
from gsapp.identification.linear_models.derivative_conversion import SteadyCondition
from gsapp.identification.linear_models.model_comparison import (
    DRAG_DERIVATIVES,
    FittedModel,
    errors_over_range,
    fit_models,
    mean_condition,
    model_from_derivatives,
    simulate_outputs,
)
from gsapp.identification.linear_models.signals import (
    LINEAR_INPUTS,
    LINEAR_OUTPUTS,
    LinearAxis,
    LinearModelSignals,
    linear_model_signals,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.methods import DEFAULT_METHOD
from gsapp.identification.summary.campaign_summary import CampaignSummary, summarize_campaign
from gsapp.identification.summary.settings import SUMMARY
from gsapp.quantities import FloatArray

_REQUIRED_DERIVATIVES: Final[dict[LinearAxis, tuple[str, ...]]] = {
    "lon": ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"),
    "lat": ("CY_beta", "Cl_beta", "Cl_p", "Cl_da", "Cn_beta", "Cn_r"),
}
"""Without these there is no model: zero in their place would be another aircraft."""


NO_LINEAR_MODEL_PREFIX: Final = "no linear"
"""Begins each remark on a linear model that could not be made."""


def known_derivatives(settings: CampaignSettings, means: Mapping[str, float]) -> dict[str, float]:
    """Return what is known of the derivatives: means, then what was held, then a model's values."""
    model = settings.known_model
    return {**({} if model is None else model.derivatives), **settings.held, **means}


def check_required_derivatives(axis: LinearAxis, values: Mapping[str, float]) -> None:
    """See that the derivatives without which a linear model is none are known.

    Raises
    ------
    FlightError
        Names those that are not.
    """
    missing = [name for name in _REQUIRED_DERIVATIVES[axis] if name not in values]
    if missing:
        raise FlightError(f"{', '.join(missing)} not known")


def build_linear_models(
    result: CampaignResult, summary: CampaignSummary
) -> tuple[dict[LinearAxis, LinearModel], tuple[str, ...]]:
    """Return the linear models about the mean condition of the maneuvers of each axis.

    `summary`: whose means are taken; what is held or known from a model stands in for the others.

    Returns
    -------
    models : dict of str to LinearModel
        By axis, SI; those that cannot be made are left out.
    remarks : tuple of str
        Why not, in words.
    """
    means = {name: one.value.mean for name, one in summary.derivatives.items()}
    values = known_derivatives(result.settings, means)
    found: dict[LinearAxis, LinearModel] = {}
    remarks = []
    for axis in _REQUIRED_DERIVATIVES:
        flown = [
            one.maneuver
            for one in result.results
            if one.estimate is not None
            and not set(AXIS_SURFACES[axis]).isdisjoint(one.maneuver.inputs)
        ]
        if not flown:
            continue
        text = AXIS_TITLES[axis]
        try:
            found[axis] = model_about_flown_cg(flown[0], mean_condition(flown), axis, values)
        except FlightError as error:
            remarks.append(f"{NO_LINEAR_MODEL_PREFIX} {text} model: {error}")
            continue
        if axis == "lon" and "V" not in found[axis].states:
            missing = ", ".join(name for name in DRAG_DERIVATIVES if name not in values)
            remarks.append(
                f"{NO_LINEAR_MODEL_PREFIX} model of speed and pitch angle: {missing} not known"
            )
    return found, tuple(remarks)


def model_about_flown_cg(
    maneuver: Maneuver, condition: SteadyCondition, axis: LinearAxis, values: Mapping[str, float]
) -> LinearModel:
    """Return the linear model of derivatives that are about the aircraft file's CG.

    Raises `FlightError` if derivatives are missing that no model can do without.
    """
    check_required_derivatives(axis, values)
    aircraft = maneuver.aircraft
    about_cg = derivatives_about_flown_cg(values, maneuver.cg_shift, aircraft.geometry)
    return model_from_derivatives(aircraft, condition, axis, about_cg)


SUBSPACE_ORDERS: Final[Mapping[LinearAxis, int]] = {"lon": 2, "lat": 4}
"""States of the subspace models: as many as the rigid airplane has without the path it flies."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ValidationTrace:
    """A stretch of a maneuver that was kept out, measured and computed."""

    maneuver: str
    flight: str
    times: FloatArray  # Shape (n,). s of flight time.
    inputs: FloatArray  # Shape (n, n_inputs). As measured, SI.
    measured: FloatArray
    """Shape (n, n_outputs). SI; flow angles at the center of gravity, accelerations where the
    instrument sits."""
    computed: Mapping[str, FloatArray]
    """Shape (n, n_outputs). By model, from the inputs alone, with a level and a start of its
    own."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisValidation:
    """The models of one axis."""

    axis: LinearAxis
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    """Channels of the traces."""
    models: Mapping[str, FittedModel]
    """``bls``, ``subspace``, ``ml``; the last are the derivatives of the campaign's own method."""
    errors: Mapping[str, Mapping[str, float]]
    """RMS error over range, percent, by model and output, over the traces; infinite where a model
    runs away."""
    traces: tuple[ValidationTrace, ...]
    fitted_maneuvers: tuple[str, ...]
    validation_maneuvers: tuple[str, ...]
    """Maneuvers."""
    flights: tuple[str, ...] = ()
    """Names of whole flights that were kept out; empty where single maneuvers were."""
    whole_flight_errors: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """The same over the whole of the flights kept out, each from its first to its last maneuver
    without a start of its own (tables 7.4.1 and 7.4.2); empty where no flight was."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearModelValidation:
    """The models of a campaign."""

    axes: Mapping[LinearAxis, AxisValidation] = field(default_factory=dict)
    """Those that could be compared."""
    method: str = DEFAULT_METHOD  # Of the derivatives.
    remarks: tuple[str, ...] = ()
    """Why an axis is missing, or a judgment of it; which maneuvers were no use."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _ValidationSplit:
    """What models are fitted on and what they are judged on."""

    fitted: tuple[Maneuver, ...]
    judged: tuple[Maneuver, ...]
    flights: tuple[str, ...]


ExtractedManeuver = Callable[[str, float, float], Maneuver]
"""Cuts a flight by its number (empty where there is only one) from one time to another, s."""


def validate_linear_models(
    result: CampaignResult,
    *,
    keep_out: Collection[str] = (),
    without: Collection[str] = (),
    cut: ExtractedManeuver | None = None,
    progress: CampaignProgressCallback | None = None,
) -> LinearModelValidation:
    """Fit the linear models on a part of a campaign's maneuvers and judge them on the rest.

    Parameters
    ----------
    keep_out : collection of str
        Numbers of the flights to judge on, as the ids of their maneuvers begin. Empty: for each
        axis the last flight that flew it; where only one did, every other maneuver of each kind.
    without : collection of str
        Maneuvers that count nowhere.
    cut : callable, optional
        With it the models are judged on the whole of the flights kept out, too.
    progress : callable, optional
        As of `run_campaign`.

    Raises
    ------
    CanceledError
        If `progress` returned False.
    """
    every = [one.maneuver for one in result.results if one.maneuver.id not in without]
    splits: dict[LinearAxis, _ValidationSplit] = {}
    remarks = []
    for axis in LINEAR_INPUTS:
        text = AXIS_TITLES[axis]
        flown = [one for one in every if one.inputs and set(one.inputs) <= set(AXIS_SURFACES[axis])]
        own, lacking = _complete_maneuvers(flown, axis)
        if lacking:
            remarks.append(
                f"{', '.join(lacking)}: left out of the {text} models, which need "
                f"{', '.join(dict.fromkeys((*LINEAR_INPUTS[axis], *LINEAR_OUTPUTS[axis])))} in "
                "every maneuver"
            )
        if not own:
            continue
        split = _split_maneuvers(own, keep_out)
        if split is None:
            remarks.append(f"no {text} models are compared: {_too_few_text(own, keep_out)}")
        else:
            splits[axis] = split
    if not splits:
        return LinearModelValidation(method=result.settings.method, remarks=tuple(remarks))
    out = {one.id for split in splits.values() for one in split.judged}
    means = _reestimate_means(result, [one for one in every if one.id not in out], progress)
    found: dict[LinearAxis, AxisValidation] = {}
    for axis, split in splits.items():
        try:
            check_required_derivatives(axis, means)
            found[axis] = _validate_axis(axis, split, means)
        except FlightError as error:
            remarks.append(f"no {AXIS_TITLES[axis]} models are compared: {error}")
            continue
        if cut is not None and split.flights:
            try:
                found[axis] = replace(
                    found[axis],
                    whole_flight_errors=_whole_flight_errors(found[axis], every, split, cut),
                )
            except FlightError as error:
                remarks.append(
                    f"no {AXIS_TITLES[axis]} models are validated on whole flights: {error}"
                )
    return LinearModelValidation(axes=found, method=result.settings.method, remarks=tuple(remarks))


def _complete_maneuvers(
    flown: Sequence[Maneuver], axis: LinearAxis
) -> tuple[list[Maneuver], tuple[str, ...]]:
    """Return the maneuvers in which everything was measured, and the ids of the others.

    An instrument that shows next to nothing of what it shows elsewhere is broken.
    """
    stretches: dict[str, tuple[LinearModelSignals, ...]] = {}
    for one in flown:
        # What lacks a channel stays without a stretch.
        with contextlib.suppress(FlightError):
            stretches[one.id] = linear_model_signals(one, axis)
    moves = {
        name: np.ptp(np.vstack([part.outputs for part in parts]), axis=0)
        for name, parts in stretches.items()
        if parts
    }
    usual = np.median(np.array(list(moves.values())), axis=0) if moves else 0.0
    own = [
        one
        for one in flown
        if one.id in moves and bool(np.all(moves[one.id] > SUMMARY.min_range_share * usual))
    ]
    return own, tuple(one.id for one in flown if one not in own)


def maneuver_flight_number(maneuver: str) -> str:
    """Return the number of the flight in the id of a maneuver; empty where there is only one."""
    return maneuver.rpartition(":")[0]


def _split_maneuvers(own: Sequence[Maneuver], keep_out: Collection[str]) -> _ValidationSplit | None:
    flights = list(dict.fromkeys(maneuver_flight_number(one.id) for one in own))
    chosen = set(keep_out) & set(flights)
    if not keep_out and len(flights) > 1:
        chosen = {flights[-1]}
    if chosen:
        judged = [one for one in own if maneuver_flight_number(one.id) in chosen]
        names = tuple(dict.fromkeys(one.flight for one in judged))
    elif keep_out:
        return None
    else:
        judged, names = _every_other(own), ()
    fitted = tuple(one for one in own if one not in judged)
    # A model is judged on what it was made for: a surface that no fitted maneuver moved is none.
    known = {surface for one in fitted for surface in one.inputs}
    judged = [one for one in judged if set(one.inputs) <= known]
    return (
        _ValidationSplit(fitted=fitted, judged=tuple(judged), flights=names)
        if fitted and judged
        else None
    )


def _every_other(own: Sequence[Maneuver]) -> list[Maneuver]:
    """Return the second, fourth, ... maneuver of each set of inputs."""
    seen: dict[tuple[str, ...], int] = {}
    judged = []
    for one in own:
        kind = tuple(sorted(one.inputs))
        seen[kind] = seen.get(kind, 0) + 1
        if seen[kind] % 2 == 0:
            judged.append(one)
    return judged


def _too_few_text(own: Sequence[Maneuver], keep_out: Collection[str]) -> str:
    surfaces = " or ".join(dict.fromkeys(surface for one in own for surface in one.inputs))
    if keep_out:
        return f"the validation flights, or all others, contain no maneuver that moves {surfaces}"
    return f"validation needs a second maneuver that moves {surfaces}"


def _reestimate_means(
    result: CampaignResult, maneuvers: Sequence[Maneuver], progress: CampaignProgressCallback | None
) -> dict[str, float]:
    settings = result.settings.with_changes(joint=False)
    summary = summarize_campaign(
        run_campaign(maneuvers, settings.with_changes(single_method=True), progress=progress)
    )
    means = {name: one.value.mean for name, one in summary.derivatives.items()}
    return known_derivatives(settings, means)


def _validate_axis(
    axis: LinearAxis, split: _ValidationSplit, values: Mapping[str, float]
) -> AxisValidation:
    first = split.judged[0]
    # The models are those of the aircraft as it flew where they are judged.
    derivatives = derivatives_about_flown_cg(values, first.cg_shift, first.aircraft.geometry)
    models = fit_models(split.fitted, axis, derivatives, order=SUBSPACE_ORDERS[axis])
    traces = tuple(trace for one in split.judged for trace in _validation_traces(one, axis, models))
    if not traces:
        raise FlightError("the maneuvers to judge them on hold gaps throughout")
    stretch = linear_model_signals(split.fitted[0], axis)[0]
    measured = np.vstack([one.measured for one in traces])
    return AxisValidation(
        axis=axis,
        inputs=stretch.input_names,
        outputs=stretch.output_names,
        models=models,
        errors={
            name: errors_over_range(
                measured, np.vstack([one.computed[name] for one in traces]), stretch.output_names
            )
            for name in models
        },
        traces=traces,
        fitted_maneuvers=tuple(one.id for one in split.fitted),
        validation_maneuvers=tuple(one.id for one in split.judged),
        flights=split.flights,
    )


def _whole_flight_errors(
    one: AxisValidation, every: Sequence[Maneuver], split: _ValidationSplit, cut: ExtractedManeuver
) -> dict[str, dict[str, float]]:
    """Return the errors over the whole of the flights kept out, by model and output."""
    stretches: list[LinearModelSignals] = []
    for number in dict.fromkeys(maneuver_flight_number(judged.id) for judged in split.judged):
        flown = [maneuver for maneuver in every if maneuver_flight_number(maneuver.id) == number]
        start = min(maneuver.t_start for maneuver in flown)
        stop = max(maneuver.t_end for maneuver in flown)
        stretches += linear_model_signals(cut(number, start, stop), one.axis)
    if not stretches:
        raise FlightError("they hold gaps throughout")
    measured = np.vstack([part.outputs for part in stretches])
    return {
        name: errors_over_range(
            measured,
            np.vstack(
                [
                    simulate_outputs(model.discretized(part.dt), part, own_start=False)
                    for part in stretches
                ]
            ),
            one.outputs,
        )
        for name, model in one.models.items()
    }


def _validation_traces(
    maneuver: Maneuver, axis: LinearAxis, models: Mapping[str, FittedModel]
) -> list[ValidationTrace]:
    return [
        ValidationTrace(
            maneuver=maneuver.id,
            flight=maneuver.flight,
            times=one.times,
            inputs=one.inputs,
            measured=one.outputs,
            computed={
                name: simulate_outputs(model.discretized(one.dt), one, own_start=True)
                for name, model in models.items()
            },
        )
        for one in linear_model_signals(maneuver, axis)
    ]
