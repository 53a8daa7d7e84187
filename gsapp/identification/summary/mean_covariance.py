"""Covariance of the means of a campaign: what the fits of single maneuvers say of them together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gsapp.identification.campaign import CampaignResult, CampaignValue
from gsapp.quantities import FloatArray


def mean_covariance(
    result: CampaignResult, values: Mapping[str, CampaignValue], names: Sequence[str]
) -> FloatArray:
    """Return the covariance of means, shape (n_names, n_names).

    Their bounds are those of `values`; their correlations follow from the covariances of the fits,
    each weighted as it counts in the means.

    `names`: all of them in `values`.
    """
    estimates = [
        one.estimate
        for one in result.results
        if one.estimate is not None and one.estimate.converged
    ]
    weights = np.array(
        [
            [1.0 / found[name][1] ** 2 if name in found else 0.0 for name in names]
            for found in (one.estimated for one in estimates)
        ]
    )
    total = weights.sum(axis=0) if estimates else np.zeros(len(names))
    together = np.zeros((len(names), len(names)))
    for one, own in zip(estimates, weights, strict=True):
        rows = [place for place, name in enumerate(names) if name in one.free]
        columns = [one.free.index(names[place]) for place in rows]
        share = np.divide(own[rows], total[rows], out=np.zeros(len(rows)), where=total[rows] > 0.0)
        together[np.ix_(rows, rows)] += (
            np.outer(share, share) * one.covariance[np.ix_(columns, columns)]
        )
    scale = np.sqrt(np.maximum(together.diagonal(), 1e-300))
    correlation = together / scale / scale[:, None]
    np.fill_diagonal(correlation, 1.0)
    stds = np.array([values[name].std for name in names])
    return np.asarray(correlation * stds * stds[:, None], dtype=np.float64)
