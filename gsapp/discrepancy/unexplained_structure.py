"""What was found without a name, as an equation and a surface over where it was flown.

A table of the surface can stand for the products in the model: between its nodes it says the same,
and beyond what was flown it does not grow.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.results import DiscrepancyResult, FoundEffect, UnexplainedStructure
from gsapp.dynamics.effects.tables import NODES, node_names
from gsapp.dynamics.effects.unnamed_terms import (
    LATERAL_VARIABLES,
    create_unnamed_term,
    static_variables,
    table_id,
)
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import Term
from gsapp.identification.filter_error.motion_linearization import ManeuverRecord
from gsapp.quantities import FloatArray

_FLOWN = (0.005, 0.995)
"""Quantiles of a variable between which it counts as flown."""


def with_structures(
    found: DiscrepancyResult,
    records: Sequence[ManeuverRecord],
    aircraft: Aircraft,
    *,
    tables: bool,
) -> DiscrepancyResult:
    """Return an answer with its structure without a name described, and kept in tables if asked."""
    structures = find_unexplained_structures(found.effects, records, aircraft)
    steps = found.steps
    if tables and structures:
        last = steps[-1]
        steps = (*steps[:-1], replace(last, model=with_tables(last.model, structures)))
    return replace(found, structures=structures, steps=steps)


def find_unexplained_structures(
    effects: Sequence[FoundEffect], records: Sequence[ManeuverRecord], aircraft: Aircraft
) -> tuple[UnexplainedStructure, ...]:
    """Return the structure of each coefficient that has products without a name."""
    by_coefficient: dict[str, list[tuple[Term, float, float]]] = {}
    for one in effects:
        term = create_unnamed_term(one.effect) if static_variables(one.effect) else None
        if term is not None:
            size, std = one.parameters[term.parameters[0].name]
            by_coefficient.setdefault(term.target, []).append((term, size, std))
    if not by_coefficient:
        return ()
    flown = _flown_variables(records, aircraft)
    return tuple(_structure(name, parts, flown) for name, parts in by_coefficient.items())


def _flown_variables(
    records: Sequence[ManeuverRecord], aircraft: Aircraft
) -> Mapping[str, FloatArray]:
    motions = [one.motion for one in records]
    found = {
        name: np.concatenate([one.state(name) for one in motions])
        for name in ("V", "alpha", "beta", "p", "q", "r")
    }
    for name in ("de", "da", "dr", "flap", "throttle"):
        found[name] = np.concatenate([one.input(name) for one in motions])
    span, chord = aircraft.geometry.span, aircraft.geometry.chord
    for name, length in (("p", span), ("q", chord), ("r", span)):
        found[f"{name}_hat"] = found[name] * length / (2.0 * found["V"])
    return found


def _structure(
    coefficient: str,
    parts: Sequence[tuple[Term, float, float]],
    flown: Mapping[str, FloatArray],
) -> UnexplainedStructure:
    names = tuple(dict.fromkeys(name for term, _, _ in parts for name in term.reads))

    def evaluate(at: Mapping[str, FloatArray | float]) -> FloatArray:
        total: FloatArray = np.zeros(())
        for term, size, _ in parts:
            total = total + term.value([at[name] for name in term.reads], (), (size,))
        return total

    middle = {name: float(np.median(flown[name])) for name in names}
    whole = evaluate(flown)
    moved = {name: float(np.std(whole - evaluate({**flown, name: middle[name]}))) for name in names}
    most = sorted(names, key=lambda name: moved[name], reverse=True)[: max(NODES)]
    variables = tuple(name for name in names if name in most)
    nodes = tuple(
        _equidistant(*_flown_range(name, flown[name]), NODES[len(variables)]) for name in variables
    )
    grid = dict(zip(variables, np.meshgrid(*nodes, indexing="ij"), strict=True))
    values = np.broadcast_to(evaluate({**middle, **grid}), [one.size for one in nodes])
    return UnexplainedStructure(
        coefficient=coefficient,
        effects=tuple(term.id for term, _, _ in parts),
        equation=_equation(coefficient, parts),
        variables=variables,
        nodes=nodes,
        values=np.array(values, dtype=np.float64),
        flown=_share_at_nodes([flown[name] for name in variables], nodes),
    )


def _equidistant(low: float, high: float, count: int) -> FloatArray:
    nodes = np.linspace(low, high, count)
    return np.where(np.abs(nodes) < 1e-9 * (high - low), 0.0, nodes)


def _flown_range(name: str, samples: FloatArray) -> tuple[float, float]:
    low, high = map(float, np.quantile(samples, _FLOWN))
    if name.removesuffix("_hat") in LATERAL_VARIABLES:
        # A node at zero, where what depends on the side has its kink.
        return -max(-low, high), max(-low, high)
    return low, high


def _equation(coefficient: str, parts: Sequence[tuple[Term, float, float]]) -> str:
    products = (
        f"({size:.3g} +-{std:.2g}) {term.equation.partition(' * ')[2]}" for term, size, std in parts
    )
    return f"{coefficient} += {' + '.join(products)}"


def _share_at_nodes(samples: Sequence[FloatArray], nodes: Sequence[FloatArray]) -> FloatArray:
    edges = [np.concatenate(([-np.inf], 0.5 * (one[1:] + one[:-1]), [np.inf])) for one in nodes]
    counts, _ = np.histogramdd(np.column_stack(samples), bins=edges)
    return np.asarray(counts / max(samples[0].size, 1), dtype=np.float64)


def with_tables(model: Model, structures: Sequence[UnexplainedStructure]) -> Model:
    """Return a model with a table in the place of each structure's products.

    A node that nobody flew near has the value of the nearest that was flown.
    """
    for one in structures:
        for effect in one.effects:
            model = model.without_effect(effect)
        ends = {
            f"{name.removesuffix('_hat')}_{end}": float(value)
            for name, nodes in zip(one.variables, one.nodes, strict=True)
            for end, value in (("first", nodes[0]), ("last", nodes[-1]))
        }
        values = dict(zip(node_names(one.variables), _held(one).ravel().tolist(), strict=True))
        model = model.with_effect(table_id(one.coefficient, one.variables), {**ends, **values})
    return model


def _held(one: UnexplainedStructure) -> FloatArray:
    flown = np.argwhere(one.flown > 0.0)
    held = one.values.copy()
    for place in product(*(range(size) for size in one.values.shape)):
        nearest = flown[np.argmin(((flown - place) ** 2).sum(axis=1))]
        held[place] = one.values[tuple(nearest)]
    return held
