"""The baseline: the linear build-up fitted, or the given model freed, on the naming maneuvers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from gsapp.dynamics.model import Model, load_model
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.maneuver_record import ManeuverRecord
from gsapp.identification.filter_error.noise_tuning import select_noise_correlation, tune_noise

_MAX_PASSES = 5
_NOISE_ROUNDS = 3
_MAX_STEP_SIGMAS = 0.3
"""A move of every parameter below this share of its deviation ends the fit."""

ActivityCallback = Callable[[str], None]


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


def fit_to_convergence(
    fit: FilterErrorFit, passes: int, tick: ActivityCallback, doing: str, *, fresh: bool = False
) -> None:
    """Fit a model, and its noise with it, in place; what is fresh is moved once before."""
    for number in range(passes):
        tick(doing)
        fit.linearize()
        if number or not fresh:
            tune_noise(fit, rounds=_NOISE_ROUNDS)
        move = fit.apply_step(fit.information())
        if number > 1 and move < _MAX_STEP_SIGMAS:
            break
    fit.linearize()
    tune_noise(fit, rounds=_NOISE_ROUNDS)


def fit_baseline(
    records: Sequence[ManeuverRecord], model: Model | None, tick: ActivityCallback
) -> FilterErrorFit:
    """Return the baseline fitted to maneuvers."""
    start = initial_model() if model is None else model
    fit = FilterErrorFit.create(records, start, free_parameters(start, model is None))
    fit_to_convergence(fit, 2, tick, "fitting the current model", fresh=True)
    select_noise_correlation(fit, _NOISE_ROUNDS)
    fit_to_convergence(fit, _MAX_PASSES - 2, tick, "fitting the current model")
    return fit
