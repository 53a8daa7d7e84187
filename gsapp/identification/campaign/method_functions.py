"""What a method is given, and the methods of this program as the registry runs them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gsapp.dynamics.model import Model
from gsapp.identification import equation_error, ftr
from gsapp.identification import maximum_likelihood as ml
from gsapp.identification.axes import AXIS_SURFACES, Axis, axis_derivatives
from gsapp.identification.campaign.results import CampaignSettings
from gsapp.identification.estimate_corrections import AssumedConstant
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.results import DerivativeEstimate, Estimate


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EstimationTask:
    """Maneuvers of one axis, and what to estimate from them together."""

    maneuvers: tuple[Maneuver, ...]
    axis: Axis
    settings: CampaignSettings  # About the CG as flown.
    free: tuple[str, ...]  # Derivatives to estimate; none of them is in `held`.
    held: Mapping[str, float]  # Derivatives and parameters of effects that are known.
    start: Mapping[str, float]  # Start values, where some are known.
    assumed_constants: Mapping[str, AssumedConstant]
    """For channels that a maneuver lacks and the user gave no constant for, SI."""

    @property
    def model(self) -> Model | None:
        """Return the model whose values and effects are taken as known."""
        return self.settings.known_model

    @property
    def stand_ins(self) -> dict[str, float]:
        """Return a constant for each channel that a maneuver lacks, SI."""
        assumed = {name: one.value for name, one in self.assumed_constants.items()}
        return {**assumed, **self.settings.stand_ins}


def estimate_by_ftr(task: EstimationTask) -> Estimate:
    """Estimate by Fourier transform regression."""
    given = tuple(task.settings.stand_ins)
    return ftr.estimate(task.maneuvers, task.axis, model=task.model, given=given)


def estimate_by_equation_error(task: EstimationTask) -> Estimate:
    """Estimate by equation error."""
    return equation_error.estimate(
        task.maneuvers, task.axis, free=task.free, held=task.held, model=task.model,
        stand_ins=task.stand_ins,
    )  # fmt: skip


def estimate_by_maximum_likelihood(task: EstimationTask) -> Estimate:
    """Estimate by maximum likelihood (output error)."""
    settings = task.settings
    weights = None
    if settings.response_weights is not None:
        others = settings.response_weights.get("", {})
        weights = {
            one.id: settings.response_weights.get(one.flight, others) for one in task.maneuvers
        }
    beside: tuple[str, ...] = ()
    if task.model is None and settings.free is None:
        beside = secondary_input_derivatives(task.maneuvers, task.axis, (*task.free, *task.held))
    # Derivatives of the other axis are no effects of this one.
    known = (*axis_derivatives("both"), *settings.held)
    effects = [name for name in settings.free or () if name not in known]
    likelihood = ml.MLSettings(
        **{
            **settings.fit_values(),
            "free": (*task.free, *beside),
            "free_effects": (*settings.free_effects, *effects),
            "held": task.held,
            "start": task.start,
        },
        axis=task.axis,
        model=task.model,
        joint_weights=weights,
    )

    found = ml.estimate(task.maneuvers, likelihood, assumed=task.assumed_constants)
    return _without(found, beside)


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
        if spans and max(spans) > PREPARATION.min_deflection:
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
            why="its surface moved, but not as the input; its effect was also fitted",
        )
    kept = [place for place, name in enumerate(estimate.free) if name not in names]
    return replace(
        estimate,
        derivatives=derivatives,
        free=tuple(estimate.free[place] for place in kept),
        covariance=estimate.covariance[np.ix_(kept, kept)],
    )
