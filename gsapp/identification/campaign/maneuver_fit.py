"""One maneuver, or several of one axis together, fitted as a campaign asks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gsapp.foundation import FlightError
from gsapp.identification import equation_error, ftr
from gsapp.identification import maximum_likelihood as ml
from gsapp.identification.axes import AXIS_SURFACES, Axis, axis_derivatives, free_derivatives
from gsapp.identification.campaign.results import CampaignValue, ManeuverResult
from gsapp.identification.campaign.settings import CampaignSettings
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.missing_channels import AssumedConstant, required_constants
from gsapp.identification.moment_reference import (
    NO_CG_SHIFT,
    common_cg_shift,
    derivatives_about_flown_cg,
    estimate_about_file_cg,
    model_about_flown_cg,
)
from gsapp.identification.results import DerivativeEstimate, Estimate

_MIN_DEFLECTION = 0.01
"""Peak-to-peak deflection (rad) from which a surface counts as moved."""
_NO_EXCITATION_TEXT = (
    "no surface moved as an input here: nothing excites the aircraft, and hardly a derivative can "
    "be earned; fly a doublet, or choose another stretch"
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
    by_equations = replace(settings, method="ee")
    try:
        beside = fit_maneuvers_jointly((maneuver,), axis, by_equations, means, known)
    except FlightError as error:
        told = f"equation error gives nothing to compare with: {error}"
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

    Parameters
    ----------
    maneuvers : sequence of Maneuver
    axis : {"lon", "lat", "both"}
    settings : CampaignSettings
    means : mapping of str to CampaignValue
        Of the maneuvers that were fitted before.
    known : mapping of str to AssumedConstant
        For what was not measured.

    Raises
    ------
    FlightError
        If nothing can be estimated from them.
    """
    shift = common_cg_shift(maneuvers)
    if shift == NO_CG_SHIFT:
        return _estimate_about_cg(maneuvers, axis, settings, means, known)
    geometry = maneuvers[0].aircraft.geometry
    model = settings.model
    values = {name: one.mean for name, one in means.items()} if model is None else model.derivatives
    likelihood = settings.likelihood
    priors = derivatives_about_flown_cg(
        {name: value for name, (value, _) in likelihood.priors.items()}, shift, geometry, values
    )
    likelihood = replace(
        likelihood,
        model=None if model is None else model_about_flown_cg(model, shift, geometry),
        priors={name: (value, likelihood.priors[name][1]) for name, value in priors.items()},
    )
    held = derivatives_about_flown_cg(settings.held, shift, geometry, values)
    held_means = {
        name: replace(means[name], mean=mean)
        for name, mean in derivatives_about_flown_cg(
            {name: one.mean for name, one in means.items()}, shift, geometry
        ).items()
    }
    found = _estimate_about_cg(
        maneuvers, axis, replace(settings, held=held, likelihood=likelihood), held_means, known
    )
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
    free = tuple(name for name in free if name not in settings.held)
    held = dict(settings.held)
    if settings.model is None:
        rest = (name for name in axis_derivatives(axis) if name not in free)
        held = {**{name: means[name].mean for name in rest if name in means}, **held}
    derivatives = tuple(name for name in free if name in axis_derivatives(axis))
    if settings.method == "ftr":
        return ftr.estimate(
            maneuvers, axis, model=settings.model, given=tuple(settings.likelihood.stand_ins)
        )
    needed = required_constants(maneuvers, known, settings.likelihood.stand_ins)
    if settings.method == "ee":
        constants = {name: one.value for name, one in needed.items()}
        return equation_error.estimate(
            maneuvers, axis, free=derivatives, held=held, model=settings.model,
            stand_ins={**constants, **settings.likelihood.stand_ins},
        )  # fmt: skip
    weights = None
    if settings.weights is not None:
        weights = {
            one.id: settings.weights.get(one.flight, settings.weights.get("", {}))
            for one in maneuvers
        }
    # Equation error begins poorly where a flow angle is missing; the others' means begin well.
    start = {name: means[name].mean for name in derivatives if needed and name in means}
    beside: tuple[str, ...] = ()
    if settings.model is None and settings.free is None:
        beside = secondary_input_derivatives(maneuvers, axis, (*free, *held))

    likelihood = replace(
        settings.likelihood,
        axis=axis,
        free=(*derivatives, *beside),
        # Derivatives of the other axis are no effects of this one.
        free_effects=(
            *settings.likelihood.free_effects,
            *(name for name in free if name not in axis_derivatives("both")),
        ),
        held=held,
        joint_weights=weights,
        start={**start, **settings.likelihood.start},
    )
    return _without(ml.estimate(maneuvers, likelihood, assumed=needed), beside)


def secondary_input_derivatives(
    maneuvers: Sequence[Maneuver], axis: Axis, settled: Sequence[str]
) -> tuple[str, ...]:
    """Return derivatives of surfaces that moved though not as the input, not settled otherwise.

    A pilot holds the wings level with the ailerons through a rudder doublet: without their share
    the rest would bend.
    """
    moved = []
    for surface in AXIS_SURFACES[axis]:
        spans = [np.ptp(one.samples(surface)) for one in maneuvers if one.has(surface)]
        if spans and max(spans) > _MIN_DEFLECTION:
            moved.append(surface)
    return tuple(
        name
        for name in axis_derivatives(axis)
        if name.partition("_")[2] in moved and name not in settled
    )


def _without(estimate: Estimate, names: Sequence[str]) -> Estimate:
    """Return an estimate that does not report some of what it fitted."""
    if not names:
        return estimate
    derivatives = dict(estimate.derivatives)
    for name in names:
        derivatives[name] = DerivativeEstimate(
            value=None,
            status="unknown",
            why="its surface moved, but not as the input; its share was fitted beside the rest",
        )
    kept = [place for place, name in enumerate(estimate.free) if name not in names]
    return replace(
        estimate,
        derivatives=derivatives,
        free=tuple(estimate.free[place] for place in kept),
        covariance=estimate.covariance[np.ix_(kept, kept)],
    )
