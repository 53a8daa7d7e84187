"""A whole campaign: every maneuver by itself, the means over all, and joint fits.

Each maneuver goes to the axis that its surfaces excite. What a maneuver does not free (tables
6.2.5 and 6.2.6) is held at the model's value; without a model, at the campaign's own: maneuvers
that move fewer surfaces come second and hold the means of those that moved more. Those that lack
airspeed or angle of attack come after the others of their kind and start from their means.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError, GroundStationError
from gsapp.identification import equation_error, ftr
from gsapp.identification import maximum_likelihood as ml
from gsapp.identification.axes import SURFACES, Axis, axis_derivatives, axis_of, free_derivatives
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.moment_reference import (
    HERE,
    about_file_cg,
    about_flown_cg,
    common_shift,
    model_about_flown_cg,
)
from gsapp.identification.results import DerivativeEstimate, Estimate, Method
from gsapp.identification.stand_ins import StandIn, campaign_stand_ins, fit_with, lacking
from gsapp.quantities import FloatArray

_STIRRED = 0.01
"""Peak-to-peak deflection (rad) from which a surface counts as moved."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignSettings:
    """How to estimate.

    Attributes
    ----------
    method : {"ml", "ee", "ftr"}
    axis : {"lon", "lat", "both"}
        ``both``: each maneuver by its own surfaces, six degrees of freedom where it moved both
        the elevator and a lateral surface.
    six_degrees : bool
        Fit all six degrees of freedom in every maneuver.
    free : tuple of str, optional
        Free derivatives and effect parameters in place of the tables.
    held : mapping of str to float
    weights : mapping of str to mapping, optional
        Of the responses (SI), by name of the flight; ``""`` for all others.
    likelihood : MLSettings
        Everything else that maximum likelihood takes; its axis does not matter.
    joint : bool
        Whether to fit all maneuvers of an axis together, too.
    """

    method: Method = "ml"
    axis: Axis = "both"
    six_degrees: bool = False
    free: tuple[str, ...] | None = None
    held: Mapping[str, float] = field(default_factory=dict)
    weights: Mapping[str, Mapping[str, float]] | None = None
    likelihood: ml.MLSettings = field(default_factory=lambda: ml.MLSettings(axis="lon"))
    joint: bool = False

    @property
    def model(self) -> Model | None:
        """Return the model whose values and effects are taken as known."""
        return self.likelihood.model


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignValue:
    """One derivative over a campaign.

    Attributes
    ----------
    mean : float
        Weighted by inverse variance.
    std : float
        Standard error of the mean.
    scatter : float or None
        Sample deviation; None for one value.
    n : int
    """

    mean: float
    std: float
    scatter: float | None
    n: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverResult:
    """What became of one maneuver.

    Attributes
    ----------
    maneuver : Maneuver
    estimate : Estimate or None
        None where it failed.
    failure : str
        Why, in words.
    """

    maneuver: Maneuver
    estimate: Estimate | None
    failure: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignResult:
    """Results of all maneuvers, in their order.

    Attributes
    ----------
    settings : CampaignSettings
    results : tuple of ManeuverResult
    values : mapping of str to CampaignValue
        Of the derivatives that at least one maneuver earned.
    joint : tuple of Estimate
        One for each axis, if asked for.
    remarks : tuple of str
        Maneuvers left out, aircraft that flew with another mass or CG than their file's, failures
        of joint fits.
    """

    settings: CampaignSettings
    results: tuple[ManeuverResult, ...]
    values: Mapping[str, CampaignValue]
    joint: tuple[Estimate, ...] = ()
    remarks: tuple[str, ...] = ()


Step = Callable[[int, int, str], bool | None]
"""Called with fits done, fits in all, and what is next; returning False stops."""


class CanceledError(GroundStationError):
    """The user stopped a campaign."""


def run_campaign(
    maneuvers: Sequence[Maneuver], settings: CampaignSettings, *, progress: Step | None = None
) -> CampaignResult:
    """Estimate from every maneuver.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one or several flights.
    settings : CampaignSettings
    progress : callable, optional

    Raises
    ------
    FlightError
        If there is no maneuver of the axis asked for.
    CanceledError
        If `progress` returned False.
    """
    jobs = [(one, _axis(one, settings)) for one in maneuvers]
    chosen = [(one, axis) for one, axis in jobs if axis is not None]
    remarks = [
        f"maneuver {one.id} moved {' and '.join(one.inputs) or 'nothing'} and is left out of "
        f"axis {settings.axis}"
        for one, axis in jobs
        if axis is None
    ]
    # Each sentence once, though all maneuvers of a flight share it.
    remarks += dict.fromkeys(
        f"{one.flight}: {sentence}" for one, _ in chosen for sentence in one.remarks
    )
    if any(one.cg_shift != HERE for one, _ in chosen):
        remarks.append("moment derivatives are given about the aircraft file's CG")
    if not chosen:
        what = "" if settings.axis == "both" else f" for axis {settings.axis}"
        raise FlightError(
            f"there is no maneuver to estimate from{what}; name one with its start and stop, or "
            "see what 'gsapp maneuvers' finds"
        )
    groups = _groups(chosen) if settings.joint else []
    total, done = len(chosen) + len(groups), 0
    found: dict[int, ManeuverResult] = {}
    means: Mapping[str, CampaignValue] = {}
    known = campaign_stand_ins([one for one, _ in chosen])
    rounds = [_round(one, settings, known) for one, _ in chosen]
    for now in sorted(set(rounds)):
        for place, (one, axis) in enumerate(chosen):
            if rounds[place] != now:
                continue
            _tell(progress, done, total, f"maneuver {one.id}")
            found[place] = _estimate_one(one, axis, settings, means, known)
            done += 1
        means = campaign_values([result.estimate for result in found.values()])
    joint: list[Estimate] = []
    for axis, together in groups:
        _tell(progress, done, total, f"{len(together)} maneuvers together")
        try:
            joint.append(_estimate(together, axis, settings, means, known))
        except FlightError as error:
            remarks.append(f"the joint fit failed: {error}")
        done += 1
    _tell(progress, done, total, "")
    return CampaignResult(
        settings=settings,
        results=tuple(found[place] for place in range(len(chosen))),
        values=means,
        joint=tuple(joint),
        remarks=tuple(remarks),
    )


def campaign_values(estimates: Sequence[Estimate | None]) -> dict[str, CampaignValue]:
    """Return the means over the estimates that converged, by derivative."""
    collected: dict[str, list[tuple[float, float]]] = {}
    for estimate in estimates:
        if estimate is None or not estimate.converged:
            continue
        for name, one in estimate.derivatives.items():
            if one.status == "estimated" and one.value is not None and one.std:
                collected.setdefault(name, []).append((one.value, one.std))
    return {name: mean_of(*np.array(pairs).T) for name, pairs in collected.items()}


def mean_of(values: FloatArray, stds: FloatArray) -> CampaignValue:
    """Return the weighted mean of values with their bounds, each of shape (n,)."""
    weights = 1.0 / stds**2
    return CampaignValue(
        mean=float(weights @ values / weights.sum()),
        std=float(1.0 / math.sqrt(weights.sum())),
        scatter=float(np.std(values, ddof=1)) if len(values) > 1 else None,
        n=len(values),
    )


def _tell(progress: Step | None, done: int, total: int, what: str) -> None:
    if progress is not None and progress(done, total, what) is False:
        raise CanceledError("stopped; nothing was written")


def _axis(maneuver: Maneuver, settings: CampaignSettings) -> Axis | None:
    """Return the axis to fit a maneuver in; None to leave it out."""
    if settings.six_degrees:
        return "both"
    if settings.axis == "both" or not maneuver.inputs:
        # Nothing moved: the axis asked for says why nothing can be earned.
        return axis_of(maneuver.inputs) if maneuver.inputs else settings.axis
    moved = not set(SURFACES[settings.axis]).isdisjoint(maneuver.inputs)
    return settings.axis if moved else None


def _round(
    maneuver: Maneuver, settings: CampaignSettings, known: Mapping[str, StandIn]
) -> tuple[int, bool]:
    """Return when a maneuver's turn is: what others know already helps it."""
    lacks = bool(lacking((maneuver,), known, settings.likelihood.stand_ins))
    return -len(maneuver.inputs), lacks


def _groups(
    chosen: Sequence[tuple[Maneuver, Axis]],
) -> list[tuple[Axis, tuple[Maneuver, ...]]]:
    axes = dict.fromkeys(axis for _, axis in chosen)
    return [(axis, tuple(one for one, own in chosen if own == axis)) for axis in axes]


def _estimate_one(
    maneuver: Maneuver,
    axis: Axis,
    settings: CampaignSettings,
    means: Mapping[str, CampaignValue],
    known: Mapping[str, StandIn],
) -> ManeuverResult:
    try:
        return ManeuverResult(
            maneuver=maneuver, estimate=_estimate((maneuver,), axis, settings, means, known)
        )
    except FlightError as error:
        return ManeuverResult(maneuver=maneuver, estimate=None, failure=str(error))


def _estimate(
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    settings: CampaignSettings,
    means: Mapping[str, CampaignValue],
    known: Mapping[str, StandIn],
) -> Estimate:
    """Estimate from maneuvers of one axis; what is known and what is found are about the file's CG.

    The fit itself balances moments about the CG as flown.
    """
    shift = common_shift(maneuvers)
    if shift == HERE:
        return _estimate_about_cg(maneuvers, axis, settings, means, known)
    geometry = maneuvers[0].aircraft.geometry
    model = settings.model
    values = {name: one.mean for name, one in means.items()} if model is None else model.derivatives
    likelihood = settings.likelihood
    priors = about_flown_cg(
        {name: value for name, (value, _) in likelihood.priors.items()}, shift, geometry, values
    )
    likelihood = replace(
        likelihood,
        model=None if model is None else model_about_flown_cg(model, shift, geometry),
        priors={name: (value, likelihood.priors[name][1]) for name, value in priors.items()},
    )
    held = about_flown_cg(settings.held, shift, geometry, values)
    held_means = {
        name: replace(means[name], mean=mean)
        for name, mean in about_flown_cg(
            {name: one.mean for name, one in means.items()}, shift, geometry
        ).items()
    }
    found = _estimate_about_cg(
        maneuvers, axis, replace(settings, held=held, likelihood=likelihood), held_means, known
    )
    return about_file_cg(found, shift, geometry)


def _estimate_about_cg(
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    settings: CampaignSettings,
    means: Mapping[str, CampaignValue],
    known: Mapping[str, StandIn],
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
        return ftr.estimate(maneuvers, axis, model=settings.model)
    needed = lacking(maneuvers, known, settings.likelihood.stand_ins)
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
        beside = moved_beside(maneuvers, axis, (*free, *held))

    def fit(constants: Mapping[str, float]) -> Estimate:
        return ml.estimate(
            maneuvers,
            replace(
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
                stand_ins={**constants, **settings.likelihood.stand_ins},
                start={**start, **settings.likelihood.start},
            ),
        )

    return _without(fit_with(needed, fit), beside)


def moved_beside(
    maneuvers: Sequence[Maneuver], axis: Axis, settled: Sequence[str]
) -> tuple[str, ...]:
    """Return derivatives of surfaces that moved though not as the input, not settled otherwise.

    A pilot holds the wings level with the ailerons through a rudder doublet: without their share
    the rest would bend.
    """
    moved = []
    for surface in SURFACES[axis]:
        spans = [np.ptp(one.samples(surface)) for one in maneuvers if one.has(surface)]
        if spans and max(spans) > _STIRRED:
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
