"""Models on the way to an answer, and names that are taken back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gsapp.discrepancy.effect_selection import CandidateScreening, EffectDecision
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.model import Model, load_model
from gsapp.foundation import FlightError
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.motion_linearization import ManeuverRecord
from gsapp.identification.filter_error.noise_model import ROTATIONS
from gsapp.identification.filter_error.noise_tuning import (
    ActivityCallback,
    fit_to_convergence,
    select_noise_correlation,
)
from gsapp.identification.filter_error.settings import FILTER_ERROR


def free_parameters(model: Model, fitted: bool) -> tuple[str, ...]:
    """Return what is free: the whole linear build-up, or what a given model has of it, and levels.

    A derivative that a given model does not have at all is a missing effect, not a wrong value.
    """
    names = axis_derivatives("both")
    if fitted:
        return names
    return tuple(name for name in names if name.endswith("_0") or name in model.derivatives)


def initial_model() -> Model:
    """Return the linear build-up with values from which the fit finds its way."""
    shipped = load_model("b777")
    return Model(name="linear build-up", derivatives=shipped.derivatives)


def fit_baseline(
    records: Sequence[ManeuverRecord], model: Model | None, tick: ActivityCallback
) -> FilterErrorFit:
    """Return the baseline fitted to maneuvers."""
    start = initial_model() if model is None else model
    free = free_parameters(start, model is None)
    return fit_from_record(records, start, free, tick, "fitting the current model")


def fit_from_record(
    records: Sequence[ManeuverRecord],
    model: Model,
    free: Sequence[str],
    tick: ActivityCallback,
    doing: str,
    later: Sequence[str] = (),
) -> FilterErrorFit:
    """Return a model fitted to maneuvers of whose noise nothing is known.

    `later`: parameters that are free once the others have found their way.
    """
    fit = FilterErrorFit.create(records, model, free)
    fit_to_convergence(fit, 2, tick, doing, fresh=True)
    select_noise_correlation(fit, FILTER_ERROR.noise_rounds)
    fit_to_convergence(fit, SEARCH.max_passes - 2, tick, doing)
    if later:
        fit = fit.with_model(fit.revised_model(), (*free, *later))
        fit_to_convergence(fit, SEARCH.max_passes_far_start, tick, doing)
    return _with_rotating_air(fit, tick)


def _with_rotating_air(fit: FilterErrorFit, tick: ActivityCallback) -> FilterErrorFit:
    """Return the fit with gusts that turn the air, where these are likelier.

    Gusts that differ across the span roll it, those that differ along the flight path pitch and
    yaw it (MIL-F-8785C): in nature (gain 1), not in every simulation (0), in some with the other
    sign (-1). Left out, they move the derivatives of rates and controls by many bounds.
    """
    if max(_gust_rms(fit)) < SEARCH.min_gust_rms:
        return fit
    best, information = fit, fit.information()
    # G. Schwarz, Estimating the Dimension of a Model, Annals of Statistics 6, 1978.
    parameters = len(ROTATIONS) * len(fit.noise)
    least = fit.deviance() - parameters * float(np.log(information.samples))
    for gain in (1.0, 0.0, -1.0):
        trial = fit.with_model(fit.model, fit.free)
        trial.noise = {
            flight: replace(
                one,
                rotation_intensities=(FILTER_ERROR.initial_rotation_intensity,) * 3,
                gradient_gains=(gain, gain),
            )
            for flight, one in fit.noise.items()
        }
        try:
            fit_to_convergence(trial, SEARCH.effect_passes, tick, "looking for turning gusts")
        except FlightError:
            continue
        deviance = trial.deviance()
        if deviance < least:
            best, least = trial, deviance
    return best


def _gust_rms(fit: FilterErrorFit) -> list[float]:
    """Return the rms (m/s) of the gusts over all directions, of each maneuver."""
    found = []
    for one in fit.maneuvers:
        rms = fit.noise[one.record.flight].gust_rms(float(np.mean(one.motion.states[0])))
        found.append(float(np.sqrt(np.mean(np.square([*rms.values()])))))
    return found


def gust_of(fit: FilterErrorFit) -> dict[str, float]:
    """Return the rms of turbulence, ``gust`` with ``gust_std``, unless the air is still."""
    found = np.array(_gust_rms(fit))
    mean = float(np.sqrt(np.mean(found**2)))
    if mean < SEARCH.min_gust_rms:
        return {}
    return {"gust": mean, "gust_std": float(np.std(found) / np.sqrt(len(found)))}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SearchStage:
    """One model on the way, with the competition that it faced."""

    fit: FilterErrorFit
    added: str  # The effect that it has and the stage before has not; empty for the baseline.
    screening: CandidateScreening
    decision: EffectDecision
    forced: bool = False  # Whether the effect was put in by hand.
    proven: bool = False  # Whether kinematics alone prove it.
    equivalent_effects: tuple[str, ...] = ()
    """The set that the effect stands for, itself with it, where these flights cannot tell which."""

    def as_unexplained(self) -> SearchStage:
        """Return the stage with the answer that its best explanation is none."""
        return replace(self, decision=replace(self.decision, kind="unexplained"))


def equivalent_effects_of(stage: SearchStage) -> tuple[str, ...]:
    """Return the set that the best of a stage's decision can stand for; empty where it cannot.

    What cannot be told apart because it looks the same leaves the same behind, and the search can
    go on; a set of different things, or one whose input did not move, leaves its rests to be
    misnamed.
    """
    decision = stage.decision
    if decision.kind != "ambiguous" or decision.best is None:
        return ()
    if not all(one.excited for one in decision.alternatives):
        return ()
    cosines = np.abs(stage.screening.cosines(decision.best.id))
    ids = tuple(one.id for one in decision.alternatives)
    alike = all(cosines[stage.screening.index(one)] >= SEARCH.min_equivalence_cosine for one in ids)
    return ids if alike else ()


def remove_misnamed_effects(stages: Sequence[SearchStage], forced: int) -> list[SearchStage]:
    """Take back names that leave much of their own structure unexplained.

    The baseline comes first; so many `forced` stages after it were put in by hand, and stay.
    """
    kept = list(stages)
    crowded = _first_crowded_stage(kept)
    if crowded:
        return [*kept[: crowded - 1], kept[crowded - 1].as_unexplained()]
    while len(kept) > 1 + forced:
        before, last = kept[-2], kept[-1]
        if last.proven or last.decision.kind != "unexplained" or last.decision.best is None:
            break
        left = float(last.decision.gain.max())
        explained = float(before.decision.gain.max())
        if left < SEARCH.max_unexplained_share * explained or not _is_same_target(
            last.added, last.decision.best.id
        ):
            break
        kept = [*kept[:-2], before.as_unexplained()]
    return kept


def _first_crowded_stage(stages: Sequence[SearchStage]) -> int:
    """Return the first of many names for one coefficient; 0 if no coefficient has many.

    What takes so many terms of the catalog is something that is not in it.
    """
    places: dict[str, list[int]] = {}
    for number, one in enumerate(stages):
        if number and not one.forced and one.added.split(".")[0] != "sensor":
            places.setdefault(one.added.split(".")[1], []).append(number)
    return min(
        (found[0] for found in places.values() if len(found) >= SEARCH.max_effects_per_target),
        default=0,
    )


def _is_same_target(effect: str, other: str) -> bool:
    """Return whether structure without a name may be what an effect stood for."""
    group, target = effect.split(".")[:2]
    return group != "aero" or target == other.split(".")[1]
