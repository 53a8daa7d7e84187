"""How much of the gap that could be closed was closed, by the truth.

The floor is what a perfect answer would leave: the baseline with the effects that are hidden, at
their true sizes, fitted and held against the maneuvers kept out in the same way. Sums of squares of
whitened innovations under the baseline, the program's last model and the perfect one are compared:
what noise, gusts and estimated derivatives leave is in all three of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gsapp.discrepancy.held_out_maneuvers import HeldOutManeuvers
from gsapp.dynamics.terms import create_term
from gsapp.identification.filter_error.noise_tuning import fit_to_convergence
from tests.discrepancy.blind.cases import WHOLE
from tests.discrepancy.blind.flying import FlownCase

if TYPE_CHECKING:
    from gsapp.discrepancy.investigation import Investigation
    from gsapp.discrepancy.results import DiscrepancyResult
    from gsapp.dynamics.model import Model
    from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit

VISIBLE = 10.0
"""Reducible sum of squares below which maneuvers kept out show no gap: three sigmas of chance."""
_PASSES = 4


def closed_gap(search: Investigation, flown: FlownCase, found: DiscrepancyResult) -> float | None:
    """Return the share of the reducible gap that an answer closes on maneuvers kept out.

    None where nothing is hidden that the catalog can express, or where even the perfect model
    leaves these maneuvers as they are.
    """
    if not flown.effects or any(one.startswith("outside.") for one in flown.effects):
        return None
    baseline = search.baseline(found.gap.on, lambda _: None)
    perfect = baseline.revised_model()
    for effect, size in flown.effects.items():
        perfect = perfect.with_effect(effect, _parameters(search, effect, size))
    free = {f"{one.effect}.{name}" for one in found.effects for name in one.parameters}
    fits = [
        baseline,
        _fitted(baseline, found.steps[-1].model, free) if found.effects else baseline,
        _fitted(baseline, perfect, set()),
    ]
    held = HeldOutManeuvers(search.records, found.gap.on, fits)
    reducible = 2.0 * held.gain(0, 2)
    return 2.0 * held.gain(0, 1) / reducible if reducible > VISIBLE else None


def _parameters(search: Investigation, effect: str, size: float) -> dict[str, float]:
    if effect.endswith(WHOLE):
        return {}
    term = create_term(effect, search.aircraft)
    own = next(item.name for item in term.parameters if item.free)
    return {**term.defaults, own: size}


def _fitted(baseline: FilterErrorFit, model: Model, more: set[str]) -> FilterErrorFit:
    fit = baseline.with_model(model, (*baseline.free, *sorted(more)))
    fit_to_convergence(fit, _PASSES, lambda _: None, "", fresh=True)
    return fit
