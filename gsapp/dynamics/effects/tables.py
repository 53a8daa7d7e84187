"""Tables of one or two variables: ``unnamed.Cm.table_alpha_q`` in a model file.

Structure that was found and is not understood can be kept as what it is where it was flown:
values at equidistant nodes, linear between them, constant beyond.
"""

# ruff: noqa: ARG002 - overridden methods, which use their arguments or not

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from gsapp.dynamics.arithmetic import Value
from gsapp.dynamics.terms import Parameter, Term, TermJacobian, Values
from gsapp.quantities import FloatArray

NODES = {1: 9, 2: 7}
"""Nodes along each variable, for tables of one and of two."""
_BOUND = 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class TableTerm(Term):
    """Linear interpolation between nodes; its parameters are first and last nodes, then values."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        weights, _, _ = self._weights(reads, parameters)
        return _as_read((weights * self._values(parameters)).sum(axis=-1), reads)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        weights, slopes, shares = self._weights(reads, parameters)
        values = self._values(parameters)
        by_read = [(one * values).sum(axis=-1) for one in slopes]
        by_end = [
            part
            for slope, share in zip(by_read, shares, strict=True)
            for part in (slope * (share - 1.0), -slope * share)
        ]
        return TermJacobian(
            reads=tuple(_as_read(one, reads) for one in by_read),
            parameters=tuple(_as_read(one, reads) for one in (*by_end, *weights.T)),
        )

    def _values(self, parameters: Values) -> FloatArray:
        """Return the values at the nodes, shape (n_nodes,), or (n, n_nodes)."""
        return np.stack(np.broadcast_arrays(*parameters[2 * len(self.reads) :]), axis=-1)

    def _weights(
        self, reads: Values, parameters: Values
    ) -> tuple[FloatArray, list[FloatArray], list[FloatArray]]:
        """Return the weight of each node and its slopes over the variables, shape (n, n_nodes).

        With them, shape (n,), how far between its ends each variable is.
        """
        n = NODES[len(self.reads)]
        hats, slopes, shares = [], [], []
        for index, read in enumerate(reads):
            low, high = parameters[2 * index], parameters[2 * index + 1]
            share = np.atleast_1d(np.asarray((read - low) / (high - low), dtype=np.float64))
            step = np.asarray((n - 1) / (high - low))[..., None]
            inside = ((share > 0.0) & (share < 1.0))[:, None]
            away = (n - 1) * np.clip(share, 0.0, 1.0)[:, None] - np.arange(n)
            near = np.abs(away) < 1.0
            hats.append(np.where(near, 1.0 - np.abs(away), 0.0))
            slopes.append(np.where(near & inside, -np.sign(away) * step, 0.0))
            shares.append(share)
        if len(hats) == 1:
            return hats[0], slopes, shares
        across = [_outer(slopes[0], hats[1]), _outer(hats[0], slopes[1])]
        return _outer(hats[0], hats[1]), across, shares


def _outer(first: FloatArray, second: FloatArray) -> FloatArray:
    return (first[:, :, None] * second[:, None, :]).reshape(len(first), -1)


def _as_read(values: FloatArray, reads: Values) -> Value:
    return values if any(np.ndim(one) for one in reads) else float(values[0])


def node_names(variables: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the values at the nodes, the last variable changing fastest."""
    count = NODES[len(variables)]
    numbers = product(range(1, count + 1), repeat=len(variables))
    return tuple("_".join(("at", *map(str, one))) for one in numbers)


def create_table_term(
    term_id: str, target: str, variables: Sequence[str], reads: Sequence[str]
) -> Term:
    """Return the table of a coefficient over one or two variables, all its values zero."""
    ends = [
        Parameter(
            name=f"{name}_{end}", unit="", default=value, bounds=(-_BOUND, _BOUND), free=False,
            neutral=value, description=f"{end} node of {name}, SI",
        )
        for name in variables
        for end, value in (("first", -1.0), ("last", 1.0))
    ]  # fmt: skip
    values = [
        Parameter(
            name=name, unit="", default=0.0, bounds=(-_BOUND, _BOUND), free=False,
            description="value at a node",
        )
        for name in node_names(variables)
    ]  # fmt: skip
    return TableTerm(
        id=term_id,
        title=f"{target} needs a table over {' and '.join(variables)}",
        equation=f"{target} += table({', '.join(variables)})",
        target=target,
        reads=tuple(reads),
        parameters=(*ends, *values),
    )
