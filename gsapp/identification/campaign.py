"""A whole campaign: every maneuver by itself, the means over all, and joint fits.

Each maneuver goes to the axis that its surfaces excite. What a maneuver does not free (tables
6.2.5 and 6.2.6) is held at the model's value; without a model, at the campaign's own: maneuvers
that move fewer surfaces come second and hold the means of those that moved more. Those that lack
airspeed or angle of attack come after the others of their kind and start from their means.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from pydantic import Field, NonNegativeFloat

from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError, GroundStationError
from gsapp.foundation.executors import WorkerLostError, WorkerPool, map_tasks
from gsapp.identification import equation_error, ftr
from gsapp.identification import maximum_likelihood as ml
from gsapp.identification.aircraft_uncertainty import AircraftUncertainty, aircraft_uncertainty
from gsapp.identification.axes import (
    AXIS_SURFACES,
    Axis,
    axis_derivatives,
    axis_of,
    free_derivatives,
)
from gsapp.identification.channel_faults import (
    sign_warnings,
    suspicious_signs,
    unmeasured_surfaces,
)
from gsapp.identification.estimate_corrections import (
    NO_CG_SHIFT,
    AssumedConstant,
    campaign_assumed_constants,
    common_cg_shift,
    derivatives_about_flown_cg,
    estimate_about_file_cg,
    model_about_flown_cg,
    required_constants,
)
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.identification.filter_error import estimator as filter_error
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.settings import ML_ALGORITHM
from gsapp.identification.methods import (
    DEFAULT_METHOD,
    compares_coefficients,
    estimation_method,
    estimation_methods,
    short_method_title,
)
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.results import DerivativeEstimate, Estimate
from gsapp.identification.statistics.correlation import STATISTICS
from gsapp.quantities import FloatArray


class CampaignSettings(EstimateSettings):
    """The settings of a campaign, which no longer depend on a file."""

    known_model: Model | None = Field(
        None, description="Content of `model`: its values and effects are taken as known."
    )
    response_weights: Mapping[str, Mapping[str, NonNegativeFloat]] | None = Field(
        None,
        description="Content of `weights`: of the responses (SI), by name of the flight; '' for "
        "all others.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignValue:
    """One derivative over a campaign."""

    mean: float  # Weighted by inverse variance.
    std: float
    """Standard error of the mean; what comes from the zero of an instrument does not shrink with
    the number of maneuvers."""
    scatter: float | None  # Sample deviation; None for one value.
    n: int
    systematic: float = 0.0
    """The part of `std` that all maneuvers have in common: instruments and the aircraft file."""
    disagreement: float = 0.0
    """The part of `std` by which maneuvers, or methods, differ beyond their own bounds."""

    @property
    def noise(self) -> float:
        """Return the part of `std` that comes from noise."""
        return math.sqrt(max(self.std**2 - self.systematic**2 - self.disagreement**2, 0.0))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverResult:
    """What became of one maneuver."""

    maneuver: Maneuver
    estimate: Estimate | None  # None where it failed.
    failure: str = ""  # Why, in words.
    comparisons: Mapping[str, Estimate] = field(default_factory=dict)
    """The same derivatives by other methods, by the id of the method."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignResult:
    """Results of all maneuvers, in their order."""

    settings: CampaignSettings
    results: tuple[ManeuverResult, ...]
    values: Mapping[str, CampaignValue]  # Of the derivatives that at least one maneuver earned.
    joint: tuple[Estimate, ...] = ()  # One for each axis, if asked for.
    joint_comparisons: tuple[Mapping[str, Estimate], ...] = ()
    """For each of `joint` the same derivatives by other methods, by the id of the method."""
    remarks: tuple[str, ...] = ()
    """Maneuvers left out, aircraft that flew with another mass or CG than their file's, failures of
    joint fits."""


def campaign_values(estimates: Sequence[Estimate | None]) -> dict[str, CampaignValue]:
    """Return the means over the estimates that converged, by derivative."""
    collected: dict[str, list[tuple[float, float, float]]] = {}
    for estimate in estimates:
        if estimate is None or not estimate.converged:
            continue
        for name, (value, std) in estimate.estimated.items():
            offset = estimate.derivatives[name].offset
            collected.setdefault(name, []).append((value, std, offset))
    return {name: weighted_mean(*np.array(found).T) for name, found in collected.items()}


def weighted_mean(
    values: FloatArray, stds: FloatArray, offsets: FloatArray, between: float = 0.0
) -> CampaignValue:
    """Return the weighted mean of values.

    The weights are those of the bounds alone, whatever the values scatter beyond them: a weak
    maneuver that is off by more than it says does not move the mean (M. Henmi and J. B. Copas,
    Statistics in Medicine 29, 2010).

    `values`, `stds`, `offsets`, shape (n,): with their bounds, and the part of each bound that all
    have in common. `between`: standard deviation of what scatters beyond the bounds.
    """
    own = np.maximum(stds**2 - offsets**2, STATISTICS.min_own_variance_share * stds**2)
    weights = 1.0 / own
    weights /= weights.sum()
    systematic = float(weights @ offsets)
    return CampaignValue(
        mean=float(weights @ values),
        std=math.sqrt(float(weights**2 @ (own + between**2)) + systematic**2),
        systematic=systematic,
        scatter=float(np.std(values, ddof=1)) if len(values) > 1 else None,
        n=len(values),
    )


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
    values_only: bool = False
    """Whether bounds and judgment do not count, and what takes time for them can be left out."""

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
        cutoff=math.inf if task.settings.differentiator == "central" else None,
    )  # fmt: skip


def estimate_by_maximum_likelihood(task: EstimationTask) -> Estimate:
    """Estimate by maximum likelihood (output error)."""
    likelihood, beside = _likelihood_settings(task)
    found = ml.estimate(
        task.maneuvers,
        likelihood,
        assumed=task.assumed_constants,
        values_only=task.values_only,
    )
    return _without(found, beside)


def estimate_by_filter_error(task: EstimationTask) -> Estimate:
    """Estimate by the filter-error method: turbulence is estimated, too."""
    likelihood, beside = _likelihood_settings(task)
    found = filter_error.estimate(task.maneuvers, likelihood, assumed=task.assumed_constants)
    return _without(found, beside)


def _likelihood_settings(task: EstimationTask) -> tuple[ml.MLSettings, tuple[str, ...]]:
    """Return the settings of a fit of responses, and what it fits but is not to report."""
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
    return likelihood, beside


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


_ROUGH_AIR_TEXT = (
    "the residuals of maximum likelihood show turbulence; the values are by filter error"
)
_TYPICAL_ACCURACY_TEXT = (
    "the aircraft file does not say how well it is known ([accuracy]): bounds allow for typical "
    "errors of mass, positions, delays, upwash and accelerometer zeros"
)
_NO_EXCITATION_TEXT = (
    "no surface moved as an input: no excitation; fly a doublet, or choose another time window"
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointFit:
    """Maneuvers of one axis to be fitted together; one maneuver by itself is such a fit, too."""

    maneuvers: tuple[Maneuver, ...]
    axis: Axis
    settings: CampaignSettings
    means: Mapping[str, CampaignValue]  # Of the maneuvers that were fitted before.
    known: Mapping[str, AssumedConstant]  # For what was not measured.
    values_only: bool = False  # As of `EstimationTask`.

    def by_all_methods(self) -> tuple[Estimate, dict[str, Estimate]]:
        """Return the estimate, in gusts by filter error, and those beside it by method.

        Bounds of the estimate allow for the accuracy of the aircraft file. Those beside it keep
        their own: what the file has wrong is wrong for all of them.

        Raises `FlightError` if nothing can be estimated.
        """
        found = self.estimate()
        if not any(one.inputs for one in self.maneuvers):
            return replace(found, warnings=(_NO_EXCITATION_TEXT, *found.warnings)), {}
        others, failures = self._by_other_methods()
        uncertainty = self._aircraft_uncertainty(found, others)
        calm = uncertainty.added_to(found)
        estimate = calm
        if found.gusty_maneuvers and not self.settings.single_method:
            try:
                estimate = uncertainty.added_to(self._in_gusts())
                others = {calm.method: calm, **others}
            except FlightError as error:
                failures = (*failures, f"no filter-error estimate: {error}")
        return replace(estimate, warnings=(*estimate.warnings, *failures)), others

    def estimate(self) -> Estimate:
        """Estimate; what is known and what is found are about the aircraft file's CG.

        The fit itself balances moments about the CG as flown.

        Raises `FlightError` if nothing can be estimated.
        """
        shift = common_cg_shift(self.maneuvers)
        if shift == NO_CG_SHIFT:
            return self._estimate_about_flown_cg()
        geometry = self.maneuvers[0].aircraft.geometry
        settings = self.settings
        model = settings.known_model
        values = (
            {name: one.mean for name, one in self.means.items()}
            if model is None
            else model.derivatives
        )
        priors = derivatives_about_flown_cg(
            {name: value for name, (value, _) in settings.priors.items()}, shift, geometry, values
        )
        about_flown_cg = settings.with_changes(
            known_model=None if model is None else model_about_flown_cg(model, shift, geometry),
            priors={name: (value, settings.priors[name][1]) for name, value in priors.items()},
            held=derivatives_about_flown_cg(settings.held, shift, geometry, values),
        )
        means = {
            name: replace(self.means[name], mean=mean)
            for name, mean in derivatives_about_flown_cg(
                {name: one.mean for name, one in self.means.items()}, shift, geometry
            ).items()
        }
        moved = replace(self, settings=about_flown_cg, means=means)
        return estimate_about_file_cg(moved._estimate_about_flown_cg(), shift, geometry)

    def _estimate_about_flown_cg(self) -> Estimate:
        settings, means, axis = self.settings, self.means, self.axis
        inputs = {surface for one in self.maneuvers for surface in one.inputs}
        free = free_derivatives(axis, inputs) if settings.free is None else settings.free
        names = axis_derivatives(axis)
        held = dict(settings.held)
        if settings.known_model is None:
            held = {**{n: means[n].mean for n in names if n in means and n not in free}, **held}
        derivatives = tuple(name for name in free if name in names and name not in settings.held)
        needed = required_constants(self.maneuvers, self.known, settings.stand_ins)
        # Equation error begins poorly where a flow angle is missing; the others' means begin well.
        start = {name: means[name].mean for name in derivatives if needed and name in means}
        task = EstimationTask(
            maneuvers=self.maneuvers,
            axis=axis,
            settings=settings,
            free=derivatives,
            held=held,
            start={**start, **settings.start},
            assumed_constants=needed,
            values_only=self.values_only,
        )
        return estimation_method(settings.method).estimate(task)

    def _with_settings(self, **changes: object) -> JointFit:
        return replace(self, settings=self.settings.with_changes(**changes))

    def _by_other_methods(self) -> tuple[dict[str, Estimate], tuple[str, ...]]:
        """Return estimates by method, and why a method gave none."""
        found: dict[str, Estimate] = {}
        failures = []
        for method in comparison_methods(self.settings):
            try:
                found[method] = self._with_settings(method=method).estimate()
            except FlightError as error:
                failures.append(f"no comparison with {short_method_title(method)}: {error}")
        return found, tuple(failures)

    def _in_gusts(self) -> Estimate:
        """Return the filter-error estimate that takes the place of maximum likelihood.

        Raises `FlightError` if there is none.
        """
        found = self._with_settings(method="fem").estimate()
        if not found.converged:
            raise FlightError(found.message)
        return replace(
            found,
            gusty_maneuvers=tuple(one.id for one in self.maneuvers),
            warnings=(_ROUGH_AIR_TEXT, *found.warnings),
        )

    def _aircraft_uncertainty(
        self, found: Estimate, others: Mapping[str, Estimate]
    ) -> AircraftUncertainty:
        """Return what the accuracy of the aircraft file does to the derivatives of an estimate.

        A method that takes long has it of maximum likelihood.
        """
        method = self.settings.method
        if not estimation_method(method).is_quick:
            method = DEFAULT_METHOD
            found = others.get(method) or self._with_settings(method=method).estimate()
        near = {name: value for name, (value, _) in found.estimated.items()}
        # These fits begin close to where they end: most take one step.
        again = replace(
            self._with_settings(method=method, start=near, tolerance=ML_ALGORITHM.repeat_tolerance),
            values_only=True,
        )
        return aircraft_uncertainty(
            found,
            self.maneuvers,
            lambda moved: replace(again, maneuvers=tuple(moved)).estimate(),
            compares_responses=not compares_coefficients(method),
        )


def comparison_methods(settings: CampaignSettings) -> tuple[str, ...]:
    """Return the methods whose values belong beside those of the method of the settings."""
    if settings.single_method:
        return ()
    given = {name for name in ("free", "held") if getattr(settings, name)}
    return tuple(
        one.id
        for one in estimation_methods().values()
        if one.is_quick and one.id != settings.method and given <= one.settings
    )


CampaignProgressCallback = Callable[[int, int, str], bool | None]
"""Called with fits done, fits in all, and what is next; returning False stops."""


class CanceledError(GroundStationError):
    """The user stopped a campaign."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Fit:
    """What a fit gave: estimates, or why there are none."""

    estimate: Estimate | None
    comparisons: Mapping[str, Estimate] = field(default_factory=dict)
    failure: str = ""

    def without_histories(self) -> _Fit:
        return replace(
            self,
            estimate=None if self.estimate is None else replace(self.estimate, histories=()),
            comparisons={
                method: replace(one, histories=()) for method, one in self.comparisons.items()
            },
        )


def _fit_maneuvers(fit: JointFit, keep_histories: bool) -> _Fit:
    maneuvers = tuple(replace(one, block=one.block.in_memory()) for one in fit.maneuvers)
    try:
        estimate, others = replace(fit, maneuvers=maneuvers).by_all_methods()
    except FlightError as error:
        return _Fit(estimate=None, failure=str(error))
    found = _Fit(estimate=estimate, comparisons=others)
    return found if keep_histories else found.without_histories()


def run_campaign(
    maneuvers: Sequence[Maneuver],
    settings: CampaignSettings,
    *,
    progress: CampaignProgressCallback | None = None,
    pool: WorkerPool | None = None,
    keep_histories: bool = True,
) -> CampaignResult:
    """Estimate from every maneuver.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one or several flights.
    progress : callable, optional
        Told of the fits; returning False stops.
    pool : WorkerPool, optional
        Where fits run; the numbers are the same to the last bit. In this process without it.
    keep_histories : bool
        Whether estimates hold `Estimate.histories`.

    Raises
    ------
    FlightError
        If there is no maneuver of the axis asked for.
    CanceledError
        If `progress` returned False.
    """
    if settings.inputs:
        maneuvers = [replace(one, inputs=settings.inputs) for one in maneuvers]
    jobs = [(one, _axis_to_fit(one, settings)) for one in maneuvers]
    chosen = [(one, axis) for one, axis in jobs if axis is not None]
    remarks = _exclusion_texts([one for one, axis in jobs if axis is None], settings)
    # Each sentence once, though all maneuvers of a flight share it.
    remarks += dict.fromkeys(
        f"{one.flight}: {sentence}" for one, _ in chosen for sentence in one.remarks
    )
    silent = dict.fromkeys(
        one.aircraft.name for one, _ in chosen if not one.aircraft.states_accuracy
    )
    remarks += [f"{name}: {_TYPICAL_ACCURACY_TEXT}" for name in silent]
    if any(one.cg_shift != NO_CG_SHIFT for one, _ in chosen):
        remarks.append("moment derivatives are given about the aircraft file's CG")
    if not chosen:
        what = "" if settings.axis == "both" else f" for axis {settings.axis}"
        why = "".join(f"; {remark}" for remark in remarks)
        raise FlightError(
            f"no maneuver to estimate from{what}{why}; give one by start and stop, or see "
            "'gsapp maneuvers'"
        )
    groups = _group_by_axis(chosen) if settings.joint else []
    total = len(chosen) + len(groups)
    found: dict[int, ManeuverResult] = {}
    joint: list[_Fit] = []
    means: Mapping[str, CampaignValue] = {}
    known = campaign_assumed_constants([one for one, _ in chosen])
    rounds = [_fitting_order(one, settings, known) for one, _ in chosen]
    work = partial(_fit_maneuvers, keep_histories=keep_histories)
    # A request names all flights and maneuvers, of which a fit needs none.
    own = CampaignSettings(
        **{name: getattr(settings, name) for name in CampaignSettings.model_fields}
    )

    def fits(parts: Iterable[tuple[Axis, tuple[Maneuver, ...]]]) -> Iterator[JointFit]:
        for axis, together in parts:
            several = len(together) > 1
            what = f"{len(together)} maneuvers jointly" if several else f"maneuver {together[0].id}"
            _report_progress(progress, len(found) + len(joint), total, what)
            yield JointFit(maneuvers=together, axis=axis, settings=own, means=means, known=known)

    for now in sorted(set(rounds)):
        places = [place for place, turn in enumerate(rounds) if turn == now]
        parts = [(chosen[place][1], (chosen[place][0],)) for place in places]
        for place, fit in zip(places, map_tasks(pool, work, fits(parts)), strict=True):
            found[place] = _maneuver_result(chosen[place][0], fit)
        means = campaign_values([result.estimate for result in found.values()])
    joint.extend(
        fit if isinstance(fit, _Fit) else _Fit(estimate=None, failure=str(fit))
        for fit in map_tasks(pool, work, fits(groups))
    )
    _report_progress(progress, total, total, "")
    remarks += [f"the joint fit failed: {fit.failure}" for fit in joint if fit.failure]
    fitted = [(fit.estimate, fit.comparisons) for fit in joint if fit.estimate is not None]
    estimates = tuple(estimate for estimate, _ in fitted)
    remarks += _sign_remarks(found.values(), means, estimates)
    return CampaignResult(
        settings=settings,
        results=tuple(found[place] for place in range(len(chosen))),
        values=means,
        joint=estimates,
        joint_comparisons=tuple(others for _, others in fitted),
        remarks=tuple(remarks),
    )


def _maneuver_result(maneuver: Maneuver, fit: _Fit | WorkerLostError) -> ManeuverResult:
    if isinstance(fit, WorkerLostError):
        return ManeuverResult(maneuver=maneuver, estimate=None, failure=str(fit))
    return ManeuverResult(
        maneuver=maneuver,
        estimate=fit.estimate,
        failure=fit.failure,
        comparisons=fit.comparisons,
    )


def _sign_remarks(
    results: Iterable[ManeuverResult],
    means: Mapping[str, CampaignValue],
    joint: Iterable[Estimate],
) -> list[str]:
    """Return which signs of means and joint fits appear wrong, where no single fit said it."""
    said = {
        sentence.partition(":")[0]
        for one in results
        if one.estimate is not None
        for sentence in one.estimate.warnings
    }
    found = [
        *sign_warnings({name: (one.mean, one.std) for name, one in means.items()}),
        *(sentence for one in joint for sentence in suspicious_signs(one)),
    ]
    return list(
        {one.partition(":")[0]: one for one in found if one.partition(":")[0] not in said}.values()
    )


def _report_progress(
    progress: CampaignProgressCallback | None, done: int, total: int, what: str
) -> None:
    if progress is not None and progress(done, total, what) is False:
        raise CanceledError("stopped; nothing was written")


def _exclusion_texts(maneuvers: Sequence[Maneuver], settings: CampaignSettings) -> list[str]:
    """Return why maneuvers take no part, each reason once."""
    reasons: dict[str, list[str]] = {}
    for one in maneuvers:
        reasons.setdefault(_exclusion_reason(one, settings), []).append(one.id)
    return [
        f"maneuver{'' if len(ids) == 1 else 's'} {', '.join(ids)}: {reason}"
        for reason, ids in reasons.items()
    ]


def _exclusion_reason(maneuver: Maneuver, settings: CampaignSettings) -> str:
    moved = " and ".join(maneuver.inputs) or "nothing"
    if _moved_levers_only(maneuver) and settings.axis != "lat":
        return (
            f"excluded, moved {moved}, which has no linear derivative: free an effect of it, as in "
            "--model with propulsion.Cm.throttle and --free propulsion.Cm.throttle.arm, or search "
            "for one with 'gsapp discrepancy'"
        )
    return f"moved {moved}, excluded from axis {settings.axis}" + (
        "".join(f": {text}" for text in _unmeasured_surfaces_text(maneuver, settings.axis))
    )


def _moved_levers_only(maneuver: Maneuver) -> bool:
    return bool(maneuver.inputs) and set(AXIS_SURFACES["both"]).isdisjoint(maneuver.inputs)


def _frees_lever_effects(maneuver: Maneuver, settings: CampaignSettings) -> bool:
    """Return whether an effect of its throttle or flap is to be estimated."""
    levers = {"propulsion" if name == "throttle" else name for name in maneuver.inputs}
    levers |= set(maneuver.inputs)
    return any(
        not levers.isdisjoint(name.split("."))
        for name in (*settings.free_effects, *(settings.free or ()))
    )


def _axis_to_fit(maneuver: Maneuver, settings: CampaignSettings) -> Axis | None:
    """Return the axis to fit a maneuver in; None to leave it out."""
    if _moved_levers_only(maneuver) and not _frees_lever_effects(maneuver, settings):
        return None
    if settings.six_degrees:
        return "both"
    if settings.axis == "both" or not maneuver.inputs:
        # Nothing moved: the axis asked for says why nothing can be earned.
        return axis_of(maneuver.inputs) if maneuver.inputs else settings.axis
    own = axis_of(maneuver.inputs)
    return settings.axis if own in (settings.axis, "both") else None


def _unmeasured_surfaces_text(maneuver: Maneuver, axis: Axis) -> tuple[str, ...]:
    return tuple(text for _, text in unmeasured_surfaces(maneuver, axis))


def _fitting_order(
    maneuver: Maneuver, settings: CampaignSettings, known: Mapping[str, AssumedConstant]
) -> tuple[int, bool]:
    """Return when a maneuver's turn is: what others know already helps it."""
    lacks = bool(required_constants((maneuver,), known, settings.stand_ins))
    return -len(maneuver.inputs), lacks


def _group_by_axis(
    chosen: Sequence[tuple[Maneuver, Axis]],
) -> list[tuple[Axis, tuple[Maneuver, ...]]]:
    axes = dict.fromkeys(axis for _, axis in chosen)
    return [(axis, tuple(one for one, own in chosen if own == axis)) for axis in axes]
