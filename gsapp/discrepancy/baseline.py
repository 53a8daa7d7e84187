"""The baseline: the linear build-up fitted, or the given model freed, on the naming maneuvers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from gsapp.discrepancy.filtering.fitting import Fit
from gsapp.discrepancy.filtering.record import Record
from gsapp.discrepancy.filtering.tuning import choose_colors, tune
from gsapp.dynamics.model import Model, load_model
from gsapp.identification.axes import axis_derivatives

_PASSES = 5
_ROUNDS = 3
_SETTLED = 0.3
"""A move of every parameter below this share of its deviation ends the fit."""

Tick = Callable[[str], None]


def free_of(model: Model, fitted: bool) -> tuple[str, ...]:
    """Return what is free: the whole linear build-up, or what a given model has of it, and levels.

    A derivative that a given model does not have at all is a missing effect, not a wrong value.
    """
    names = axis_derivatives("both")
    if fitted:
        return names
    return tuple(name for name in names if name.endswith("_0") or name in model.derivatives)


def start_model() -> Model:
    """Return the linear build-up with values from which the fit finds its way."""
    shipped = load_model("b777")
    return Model(name="linear build-up", derivatives=shipped.derivatives)


def settle(fit: Fit, passes: int, tick: Tick, doing: str, *, fresh: bool = False) -> None:
    """Fit a model, and its noise with it, in place; what is fresh is moved once before."""
    for number in range(passes):
        tick(doing)
        fit.linearize()
        if number or not fresh:
            tune(fit, rounds=_ROUNDS)
        move = fit.step(fit.information())
        if number > 1 and move < _SETTLED:
            break
    fit.linearize()
    tune(fit, rounds=_ROUNDS)


def baseline_fit(records: Sequence[Record], model: Model | None, tick: Tick) -> Fit:
    """Return the baseline fitted to maneuvers."""
    start = start_model() if model is None else model
    fit = Fit.begin(records, start, free_of(start, model is None))
    settle(fit, 2, tick, "fitting the current model", fresh=True)
    choose_colors(fit, _ROUNDS)
    settle(fit, _PASSES - 2, tick, "fitting the current model")
    return fit
