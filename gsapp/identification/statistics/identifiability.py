"""Which parameters the data cannot see, and which they cannot tell apart.

A parameter is *unknown* where its responses hardly move with it: even if all others were known,
its bound would exceed any plausible value. It is *not identifiable* where the responses do move
with it but other parameters move them alike: then a combination is known, the parts are not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.identification.results import DerivativeStatus
from gsapp.identification.statistics.bounds import invert_information
from gsapp.identification.statistics.correlation import STATISTICS
from gsapp.quantities import FloatArray

PLAUSIBLE_DERIVATIVES: Mapping[str, Mapping[str, float]] = {
    "CN": {"0": 1.0, "alpha": 7.0, "q": 20.0, "de": 1.5},
    "CA": {"0": 0.2, "alpha": 1.0, "q": 5.0, "de": 0.3},
    "Cm": {"0": 0.3, "alpha": 2.0, "q": 30.0, "de": 2.5},
    "CY": {"0": 0.2, "beta": 1.5, "p": 1.0, "r": 1.5, "da": 0.4, "dr": 0.5},
    "Cl": {"0": 0.1, "beta": 0.5, "p": 1.0, "r": 0.8, "da": 0.5, "dr": 0.15},
    "Cn": {"0": 0.1, "beta": 0.4, "p": 0.4, "r": 0.7, "da": 0.15, "dr": 0.25},
}
"""About the largest sizes found on airplanes, per radian: a bound beyond them says nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterVerdict:
    """On one parameter: as in `gsapp.identification.results.DerivativeEstimate`."""

    status: DerivativeStatus = "estimated"
    confounded_with: tuple[str, ...] = ()
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identifiability:
    """On all parameters of a fit."""

    verdicts: Mapping[str, ParameterVerdict]  # By name.
    condition: float
    """Largest over smallest eigenvalue of the scaled information; inf where it is singular."""
    correlated: tuple[tuple[str, str, float], ...]
    """Pairs of estimates correlated by more than 0.95, the strongest first."""

    def __getitem__(self, name: str) -> ParameterVerdict:
        return self.verdicts[name]


CORRELATION_WARNING_PREFIX = "strong correlation between "
"""Begins the sentence of `correlation_warning`."""
_MAX_PAIRS = 6


def correlation_warning(pairs: Sequence[tuple[str, str, float]]) -> str:
    """Return one sentence on the pairs of a fit that are correlated, the strongest first."""
    listed = [f"{one} and {other} ({value:+.3f})" for one, other, value in pairs[:_MAX_PAIRS]]
    more = len(pairs) - len(listed)
    return CORRELATION_WARNING_PREFIX + ", ".join(listed) + (f" and {more} more" if more else "")


def plausible_size(name: str) -> float | None:
    """Return the largest plausible size of a linear derivative; None for any other parameter."""
    coefficient, _, variable = name.partition("_")
    return PLAUSIBLE_DERIVATIVES.get(coefficient, {}).get(variable)


def withheld_std(name: str) -> float:
    """Return how far from zero a derivative may lie that a fit does not give, per radian.

    As a standard deviation, anything up to the largest plausible size being as likely: what it
    makes of the others widens their bounds. Zero for a parameter of which no size is known.
    """
    return (plausible_size(name) or 0.0) / math.sqrt(3.0)


def assess_identifiability(
    information: FloatArray,
    names: Sequence[str],
    *,
    covariance: FloatArray | None = None,
    plausible: Mapping[str, float] | None = None,
    inverted: FloatArray | None = None,
) -> Identifiability:
    """Judge each parameter of a fit by its information matrix.

    Parameters
    ----------
    information : ndarray, shape (n_parameters, n_parameters)
        sum S'R^-1 S, all parameters of the fit: derivatives, initial states, biases.
    names : sequence of str
        Of the parameters.
    covariance : ndarray, same shape, optional
        Honest one (colored residuals); the inverse of the information by default.
    plausible : mapping of str to float, optional
        Largest plausible sizes for parameters of which `PLAUSIBLE_DERIVATIVES` knows none, or
        other ones. A parameter without such a size is judged by whether the information is
        singular alone.
    inverted : ndarray, same shape, optional
        `statistics.bounds.invert_information` of it, where that is known already.
    """
    known = dict(plausible or {})
    sizes = [known.get(name, plausible_size(name)) for name in names]
    diagonal = np.maximum(information.diagonal(), 0.0)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(information * scale * scale[:, None])
    raw = invert_information(information) if inverted is None else inverted
    spread = np.sqrt(np.maximum((raw if covariance is None else covariance).diagonal(), 0.0))
    # What the bound would be were all other parameters known, widened alike for colored noise.
    with np.errstate(divide="ignore", invalid="ignore"):
        widening = np.where(np.isfinite(raw.diagonal()), spread / np.sqrt(raw.diagonal()), 1.0)
        alone = np.where(diagonal > 0.0, scale * np.nan_to_num(widening, nan=1.0), np.inf)
    verdicts = {
        name: _verdict(index, names, sizes[index], float(spread[index]), float(alone[index]),
                       values, vectors)
        for index, name in enumerate(names)
    }  # fmt: skip
    largest, smallest = float(values[-1]), float(values[0])
    singular = smallest <= STATISTICS.singular_tolerance * max(largest, 1e-300) or not bool(
        (diagonal > 0.0).all()
    )
    estimated = [index for index, name in enumerate(names) if verdicts[name].status == "estimated"]
    return Identifiability(
        verdicts=verdicts,
        condition=np.inf if singular else largest / smallest,
        correlated=_correlated(raw, names, estimated),
    )


def _verdict(
    index: int,
    names: Sequence[str],
    size: float | None,
    spread: float,
    alone: float,
    values: FloatArray,
    vectors: FloatArray,
) -> ParameterVerdict:
    name = names[index]
    if not np.isfinite(alone):
        return ParameterVerdict(
            status="unknown", why=f"no response depends on {name}: not excited by the maneuver"
        )
    if np.isfinite(spread) and (size is None or spread <= size):
        return ParameterVerdict()
    if size is not None and alone > size:
        return ParameterVerdict(
            status="unknown",
            why=f"too little excitation: the bound of {name}, {alone:.2g} even with all else "
            f"known, exceeds any plausible value ({size:.2g})",
        )
    others = _confounded(index, names, values, vectors)
    if not others:
        return ParameterVerdict(
            status="unknown",
            why=f"too little excitation: the bound of {name}, {spread:.2g}, exceeds any "
            f"plausible value ({size or 0.0:.2g})",
        )
    listed = others[0] if len(others) == 1 else f"{', '.join(others[:-1])} and {others[-1]}"
    return ParameterVerdict(
        status="not-identifiable",
        confounded_with=others,
        why=f"{name} cannot be distinguished from {listed} in this maneuver: their responses are "
        "collinear; fly an input that separates them, or hold one",
    )


def _confounded(
    index: int, names: Sequence[str], values: FloatArray, vectors: FloatArray
) -> tuple[str, ...]:
    """Return the parameters that share the badly seen combinations of one, the nearest first."""
    floor = STATISTICS.singular_tolerance * max(float(values[-1]), 1e-300)
    # Shares of the variance by combination (Belsley's variance decomposition).
    shares = vectors[index] ** 2 / np.maximum(values, floor)
    shares /= shares.sum()
    together = np.zeros(len(names))
    for column in np.flatnonzero(shares > 0.1):
        together = np.maximum(together, np.abs(vectors[:, column]) * np.sqrt(shares[column]))
    together[index] = 0.0
    largest = float(np.abs(vectors[:, shares > 0.1]).max(initial=0.0))
    order = np.argsort(-together)
    return tuple(names[other] for other in order if together[other] > 0.25 * largest)


def _correlated(
    covariance: FloatArray, names: Sequence[str], chosen: Sequence[int]
) -> tuple[tuple[str, str, float], ...]:
    own = covariance[np.ix_(chosen, chosen)]
    variance = own.diagonal()
    with np.errstate(invalid="ignore"):
        products = variance * variance[:, None]
    sound = (products > 0.0) & np.isfinite(products)
    correlations = np.where(sound, own, 0.0) / np.sqrt(np.where(sound, products, 1.0))
    strong = np.argwhere(np.triu(np.abs(correlations) > STATISTICS.strong_correlation, 1)).tolist()
    pairs = [
        (names[chosen[one]], names[chosen[other]], float(correlations[one, other]))
        for one, other in strong
    ]
    return tuple(sorted(pairs, key=lambda pair: -abs(pair[2])))
