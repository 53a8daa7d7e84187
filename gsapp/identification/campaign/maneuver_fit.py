"""One maneuver, or several of one axis together, fitted as a campaign asks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from gsapp.foundation import FlightError
from gsapp.identification.axes import Axis, axis_derivatives, free_derivatives
from gsapp.identification.campaign.estimation_task import EstimationTask
from gsapp.identification.campaign.results import CampaignValue, ManeuverResult
from gsapp.identification.campaign.settings import CampaignSettings
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.methods import estimation_method
from gsapp.identification.missing_channels import AssumedConstant, required_constants
from gsapp.identification.moment_reference import (
    NO_CG_SHIFT,
    common_cg_shift,
    derivatives_about_flown_cg,
    estimate_about_file_cg,
    model_about_flown_cg,
)
from gsapp.identification.results import Estimate

_NO_EXCITATION_TEXT = (
    "no surface moved as an input: no excitation; fly a doublet, or choose another time window"
)


def fit_maneuver(
    maneuver: Maneuver,
    axis: Axis,
    settings: CampaignSettings,
    means: Mapping[str, CampaignValue],
    known: Mapping[str, AssumedConstant],
) -> ManeuverResult:
    """Fit one maneuver; in gusts by equation error, too.

    Parameters as of `fit_maneuvers_jointly`.
    """
    try:
        estimate = fit_maneuvers_jointly((maneuver,), axis, settings, means, known)
    except FlightError as error:
        return ManeuverResult(maneuver=maneuver, estimate=None, failure=str(error))
    if not maneuver.inputs:
        estimate = replace(estimate, warnings=(_NO_EXCITATION_TEXT, *estimate.warnings))
    if not estimate.gusty_maneuvers:
        return ManeuverResult(maneuver=maneuver, estimate=estimate)
    by_equations = settings.with_changes(method="ee")
    try:
        beside = fit_maneuvers_jointly((maneuver,), axis, by_equations, means, known)
    except FlightError as error:
        told = f"no equation-error comparison: {error}"
        estimate = replace(estimate, warnings=(*estimate.warnings, told))
        return ManeuverResult(maneuver=maneuver, estimate=estimate)
    return ManeuverResult(maneuver=maneuver, estimate=estimate, equation_error_estimate=beside)


def fit_maneuvers_jointly(
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    settings: CampaignSettings,
    means: Mapping[str, CampaignValue],
    known: Mapping[str, AssumedConstant],
) -> Estimate:
    """Estimate from maneuvers of one axis; what is known and what is found are about the file's CG.

    The fit itself balances moments about the CG as flown.

    `means`: of the maneuvers that were fitted before.
    `known`: for what was not measured.

    Raises
    ------
    FlightError
        If nothing can be estimated from them.
    """
    shift = common_cg_shift(maneuvers)
    if shift == NO_CG_SHIFT:
        return _estimate_about_cg(maneuvers, axis, settings, means, known)
    geometry = maneuvers[0].aircraft.geometry
    model = settings.known_model
    values = {name: one.mean for name, one in means.items()} if model is None else model.derivatives
    priors = derivatives_about_flown_cg(
        {name: value for name, (value, _) in settings.priors.items()}, shift, geometry, values
    )
    about_flown_cg = settings.with_changes(
        known_model=None if model is None else model_about_flown_cg(model, shift, geometry),
        priors={name: (value, settings.priors[name][1]) for name, value in priors.items()},
        held=derivatives_about_flown_cg(settings.held, shift, geometry, values),
    )
    held_means = {
        name: replace(means[name], mean=mean)
        for name, mean in derivatives_about_flown_cg(
            {name: one.mean for name, one in means.items()}, shift, geometry
        ).items()
    }
    found = _estimate_about_cg(maneuvers, axis, about_flown_cg, held_means, known)
    return estimate_about_file_cg(found, shift, geometry)


def _estimate_about_cg(
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    settings: CampaignSettings,
    means: Mapping[str, CampaignValue],
    known: Mapping[str, AssumedConstant],
) -> Estimate:
    inputs = {surface for one in maneuvers for surface in one.inputs}
    free = free_derivatives(axis, inputs) if settings.free is None else settings.free
    names = axis_derivatives(axis)
    held = dict(settings.held)
    if settings.known_model is None:
        held = {**{n: means[n].mean for n in names if n in means and n not in free}, **held}
    derivatives = tuple(name for name in free if name in names and name not in settings.held)
    needed = required_constants(maneuvers, known, settings.stand_ins)
    # Equation error begins poorly where a flow angle is missing; the others' means begin well.
    start = {name: means[name].mean for name in derivatives if needed and name in means}
    return estimation_method(settings.method).estimate(
        EstimationTask(
            maneuvers=tuple(maneuvers),
            axis=axis,
            settings=settings,
            free=derivatives,
            held=held,
            start={**start, **settings.start},
            assumed_constants=needed,
        )
    )
