"""Errors of mass, inertia and center of gravity that move a model's values as they moved.

No motion shows such an error while derivatives are free: they take it up. With the inertia of the
file a fit finds C' = I_file I_true^-1 C in place of C, with its mass C' = (m_file / m_true) C, and
moments about the CG as it is. So each error moves many derivatives at once, by a pattern that
follows from their values; a product of inertia, for one, moves every yawing derivative by one
share of the rolling one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.effect_catalog import find_effect
from gsapp.discrepancy.results import Alternative
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.buildup import derivative_names
from gsapp.dynamics.model import Model
from gsapp.identification.estimate_corrections import derivatives_about_flown_cg
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MovedValues:
    """Derivatives of a given model that a fit to flights left free."""

    names: tuple[str, ...]
    before: FloatArray
    after: FloatArray
    """Shape (n_names,). Per radian."""
    covariance: FloatArray
    """Shape (n_names, n_names). Of `after`, with what any model may be off (1 %)."""

    @classmethod
    def of_fit(cls, model: Model, fit: FilterErrorFit) -> MovedValues:
        """Return what a fit made of a model's derivatives."""
        names = tuple(name for name in fit.free if name in derivative_names())
        every = (*fit.free, *fit.bias_names())
        _, covariance = fit.information().with_priors(fit.priors()).solution(every)
        places = [every.index(name) for name in names]
        before = np.array([model.derivative(name) for name in names])
        return cls(
            names=names,
            before=before,
            after=np.array([fit.values[name] for name in names]),
            covariance=covariance[np.ix_(places, places)]
            + np.diag((SEARCH.min_relative_change * before) ** 2),
        )

    @property
    def change(self) -> FloatArray:
        """Return what the fit added, shape (n_names,)."""
        return self.after - self.before

    def only(self, names: Sequence[str]) -> MovedValues:
        """Return some of them."""
        places = [self.names.index(name) for name in names]
        return MovedValues(
            names=tuple(names),
            before=self.before[places],
            after=self.after[places],
            covariance=self.covariance[np.ix_(places, places)],
        )

    def p_value(self, change: FloatArray, freedom: int) -> float:
        """Return the chance of so large a change of all of them together."""
        return float(chi2.sf(change @ np.linalg.solve(self.covariance, change), freedom))


def mass_errors(
    moved: MovedValues, aircraft: Aircraft, explained: Collection[str] = ()
) -> tuple[Alternative, ...]:
    """Return the errors of mass properties that explain, each alone, how values moved.

    `explained`: coefficients to which an effect was added, whose derivatives mean another thing
    since. Constants hold zeros of instruments and take no part.
    """
    own = moved.only(
        [
            name
            for name in moved.names
            if not name.endswith("_0") and name.partition("_")[0] not in explained
        ]
    )
    if not own.names or own.p_value(own.change, len(own.names)) > SEARCH.change_significance:
        return ()
    weights = np.linalg.inv(own.covariance)
    total = float(own.change @ weights @ own.change)
    values = dict(zip(own.names, own.before.tolist(), strict=True))
    found = []
    for effect, (reference, pattern) in _patterns(aircraft).items():
        moves = pattern(values)
        column = np.array([moves.get(name, 0.0) for name in own.names])
        seen = float(column @ weights @ column)
        if seen <= 0.0:
            continue
        size = float(column @ weights @ own.change) / seen
        left = own.change - size * column
        if (
            own.p_value(left, len(own.names) - 1) > SEARCH.change_significance
            or size**2 * seen > SEARCH.min_pattern_share * total
        ):
            found.append((size**2 * seen, _alternative(effect, size, reference, column, own)))
    return tuple(one for _, one in sorted(found, key=lambda pair: -pair[0]))


def _alternative(
    effect: str, size: float, reference: str, column: FloatArray, own: MovedValues
) -> Alternative:
    record = find_effect(effect)
    shown = np.abs(size * column) > np.sqrt(own.covariance.diagonal())
    names = [name for name, visible in zip(own.names, shown, strict=True) if visible]
    return Alternative(
        effects=(effect,),
        title=record.title,
        why=f"one error of {100.0 * size:+.1f} % of {reference} moves {', '.join(names)} as they "
        "moved",
        fly=record.remedy,
    )


_Pattern = Callable[[Mapping[str, float]], Mapping[str, float]]
_FORCES = ("CN", "CA", "CY")


def _patterns(aircraft: Aircraft) -> dict[str, tuple[str, _Pattern]]:
    """Return by effect what its size is a share of, and what a size of 1 moves."""
    mass = aircraft.mass
    roll_yaw = np.array([[mass.ixx, -mass.ixz], [-mass.ixz, mass.izz]])
    return {
        "mass.mass.error": ("the mass", _of_mass),
        "mass.inertia.ixx": ("ixx", _of_inertia(roll_yaw, [[mass.ixx, 0.0], [0.0, 0.0]])),
        "mass.inertia.iyy": ("iyy", _of_pitch_inertia),
        "mass.inertia.izz": ("izz", _of_inertia(roll_yaw, [[0.0, 0.0], [0.0, mass.izz]])),
        "mass.inertia.ixz": ("ixx", _of_inertia(roll_yaw, [[0.0, -mass.ixx], [-mass.ixx, 0.0]])),
        "mass.cg.x": ("the chord", _of_center(aircraft, 0)),
        "mass.cg.z": ("the chord", _of_center(aircraft, 2)),
    }


def _of_mass(values: Mapping[str, float]) -> dict[str, float]:
    return {name: -value for name, value in values.items() if name.partition("_")[0] in _FORCES}


def _of_pitch_inertia(values: Mapping[str, float]) -> dict[str, float]:
    return {name: -value for name, value in values.items() if name.startswith("Cm_")}


def _of_inertia(inertia: FloatArray, more: Sequence[Sequence[float]]) -> _Pattern:
    share = -np.array(more) @ np.linalg.inv(inertia)

    def pattern(values: Mapping[str, float]) -> dict[str, float]:
        moved: dict[str, float] = {}
        for regressor in dict.fromkeys(name.partition("_")[2] for name in values):
            names = (f"Cl_{regressor}", f"Cn_{regressor}")
            change = share @ np.array([values.get(name, 0.0) for name in names])
            moved.update(zip(names, change.tolist(), strict=True))
        return moved

    return pattern


def _of_center(aircraft: Aircraft, axis: int) -> _Pattern:
    chord = aircraft.geometry.chord
    shift = (chord if axis == 0 else 0.0, 0.0, chord if axis == 2 else 0.0)

    def pattern(values: Mapping[str, float]) -> dict[str, float]:
        moved = derivatives_about_flown_cg(values, shift, aircraft.geometry)
        return {name: moved[name] - value for name, value in values.items()}

    return pattern
