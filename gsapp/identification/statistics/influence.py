"""What each response does to an estimate: Hausman's test of one response against the others.

Left out of a fit, a response should move no derivative by more than its own noise explains
(J. A. Hausman, Specification Tests in Econometrics, Econometrica 46, 1978). With H = sum over
responses of H_k and the gradients g_k, which add up to zero at the estimate, the fit without
response j differs by

    d = (H - H_j)^-1 sum_(k != j) g_k

to first order. The gradients of different responses are independent, with covariances B_k from the
colored residuals (`gsapp.identification.statistics.bounds`), so that

    cov d = D (sum_(k != j) B_k) D' + H^-1 B_j H^-1,    D = (H - H_j)^-1 - H^-1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gsapp.identification.results import ResponseInfluence
from gsapp.identification.statistics.bounds import (
    ManeuverFitData,
    gradient_covariances,
    information_matrix,
    invert_information,
)
from gsapp.identification.statistics.correlation import STATISTICS
from gsapp.quantities import FloatArray


def influence_warnings(influences: Sequence[ResponseInfluence]) -> tuple[str, ...]:
    """Return in a sentence for each response what it contradicts the others in."""
    by_response: dict[str, list[ResponseInfluence]] = {}
    for one in influences:
        by_response.setdefault(one.response, []).append(one)
    return tuple(
        f"{response} contradicts the other responses: a fit without it changes "
        + ", ".join(
            f"{one.name} by {one.change:+.3g} ({one.sigmas:.0f} standard deviations)"
            for one in found[: STATISTICS.max_named]
        )
        for response, found in by_response.items()
    )


def response_influences(
    parts: Sequence[tuple[tuple[str, ...], ManeuverFitData]],
    stds: Mapping[str, tuple[int, float]],
    size: int,
    prior: FloatArray | None = None,
    shown_alone: Mapping[str, Sequence[int]] | None = None,
) -> tuple[ResponseInfluence, ...]:
    """Return where a response contradicts the others.

    Parameters
    ----------
    parts : sequence of (responses, ManeuverFitData)
        The maneuvers of a fit that has converged; their weights are diagonal.
    stds : mapping of str to (int, float)
        Place among the parameters, and bound, of the derivatives to look at.
    size : int
        Number of parameters.
    prior : ndarray, shape (size, size), optional
        Inverse covariance of a-priori values.
    shown_alone : mapping of str to sequence of int, optional
        Places of the parameters that are held in a fit without that response.

    Returns
    -------
    tuple of ResponseInfluence
        Those beyond chance and beyond the bound, the largest of each response first.
    """
    names = tuple(dict.fromkeys(name for responses, _ in parts for name in responses))
    if len(names) < 2:
        return ()
    H, B = (np.zeros((len(names), size, size)) for _ in range(2))
    g = np.zeros((len(names), size))
    for responses, part in parts:
        columns = np.arange(part.S.shape[2]) if part.columns is None else part.columns
        covariances = gradient_covariances(part)
        for own, name in enumerate(responses):
            k = names.index(name)
            counted = np.isfinite(part.v[:, own])
            S, v = part.S[counted, own], part.v[counted, own]
            weight = part.W[own, own]
            H[k][np.ix_(columns, columns)] += information_matrix(
                S[:, None, :], np.array([[weight]])
            )
            B[k][np.ix_(columns, columns)] += covariances[own]
            g[k][columns] += weight * (v @ S)
    whole = H.sum(axis=0) + (0.0 if prior is None else prior)
    inverted = invert_information(whole)
    found = []
    for k, response in enumerate(names):
        held = list((shown_alone or {}).get(response, ()))
        kept = np.setdiff1d(np.arange(size), held)
        rest = np.zeros((size, size))
        rest[np.ix_(kept, kept)] = invert_information((whole - H[k])[np.ix_(kept, kept)])
        lost = np.isinf(rest.diagonal()) | np.isinf(inverted.diagonal())
        with_all, without = (np.where(np.isfinite(one), one, 0.0) for one in (inverted, rest))
        change = without @ (g.sum(axis=0) - g[k])
        D = without - with_all
        covariance = D @ (B.sum(axis=0) - B[k]) @ D.T + with_all @ B[k] @ with_all
        own_found = [
            ResponseInfluence(
                response=response,
                name=name,
                change=float(change[place]),
                sigmas=float(abs(change[place]) / np.sqrt(covariance[place, place])),
            )
            for name, (place, std) in stds.items()
            if place not in held
            and not lost[place]
            and covariance[place, place] > 0.0
            and abs(change[place]) > std
        ]
        found += sorted(
            (one for one in own_found if one.sigmas > STATISTICS.contradiction_sigmas),
            key=lambda one: -one.sigmas,
        )
    return tuple(found)
