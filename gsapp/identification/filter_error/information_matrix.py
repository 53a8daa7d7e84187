"""Normal equations of whitened innovations: all that comparing models needs.

Rows and columns are named; the last one is the residual. Matrices of several maneuvers add up.
What belongs to one maneuver only (its initial state) was projected out before.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InformationMatrix:
    """Normal equations in named parameters."""

    names: tuple[str, ...]
    matrix: FloatArray  # Shape (m + 1, m + 1). Products of the columns, the residual last.
    samples: float  # Number of innovations behind it, less the degrees of freedom already spent.

    def __add__(self, other: InformationMatrix) -> InformationMatrix:
        """Return the sum; parameters that one lacks count as unseen by it."""
        samples = self.samples + other.samples
        if self.names == other.names:
            return InformationMatrix(
                names=self.names, matrix=self.matrix + other.matrix, samples=samples
            )
        names = tuple(dict.fromkeys((*self.names, *other.names)))
        table = {name: index for index, name in enumerate(names)}
        total = np.zeros((len(names) + 1, len(names) + 1))
        for one in (self, other):
            places = [*(table[name] for name in one.names), len(names)]
            total[np.ix_(places, places)] += one.matrix
        return InformationMatrix(names=names, matrix=total, samples=samples)

    def indices(self, names: Iterable[str]) -> list[int]:
        """Return where names stand."""
        table = {name: index for index, name in enumerate(self.names)}
        return [table[name] for name in names]

    def with_priors(self, priors: Mapping[str, tuple[float, float]]) -> InformationMatrix:
        """Return with a-priori knowledge: by name, value still missing and its deviation."""
        matrix = self.matrix.copy()
        for name, (value, std) in priors.items():
            if name in self.names:
                place = self.names.index(name)
                weight = 1.0 / std**2
                matrix[place, place] += weight
                matrix[place, -1] += weight * value
                matrix[-1, place] += weight * value
                matrix[-1, -1] += weight * value * value
        return InformationMatrix(names=self.names, matrix=matrix, samples=self.samples)

    def projected(self, nuisance: Sequence[str]) -> InformationMatrix:
        """Return what is left of all columns when the nuisance parameters have taken their part."""
        out = self.indices(nuisance)
        kept = [index for index in range(len(self.names)) if index not in set(out)]
        places = [*kept, len(self.names)]
        block = self.matrix[np.ix_(out, out)]
        cross = self.matrix[np.ix_(out, places)]
        scale = np.sqrt(np.maximum(block.diagonal(), 1e-300))
        normal = block / scale[:, None] / scale + FILTER_ERROR.ridge * np.eye(len(out))
        taken = np.linalg.solve(normal, cross / scale[:, None])
        left = self.matrix[np.ix_(places, places)] - (cross / scale[:, None]).T @ taken
        return InformationMatrix(
            names=tuple(self.names[index] for index in kept),
            matrix=0.5 * (left + left.T),
            samples=self.samples - len(out),
        )

    def solution(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Return values and covariance of these parameters, all others zero.

        One that nothing is known of is zero, with a bound beyond any other.
        """
        places = self.indices(names)
        block = self.matrix[np.ix_(places, places)]
        known = block.diagonal()
        scale = np.sqrt(np.where(known > 0.0, known, 1.0))
        normal = block / scale[:, None] / scale + FILTER_ERROR.ridge * np.eye(len(places))
        covariance = np.linalg.inv(normal) / scale[:, None] / scale
        return covariance @ self.matrix[places, -1], covariance

    def misfit(self, values: Mapping[str, float]) -> float:
        """Return the sum of squares that is left with these values, all others zero."""
        places = self.indices(values)
        x = np.array([*values.values()])
        block = self.matrix[np.ix_(places, places)]
        return float(self.matrix[-1, -1] - 2.0 * x @ self.matrix[places, -1] + x @ block @ x)

    def gains(self, of: InformationMatrix) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return, for every single parameter, gain in the sum of squares, value, and std.

        `of`: the same before projection: a column of which next to nothing is left gains nothing.
        """
        raw = of.matrix.diagonal()[of.indices(self.names)]
        own = self.matrix.diagonal()[:-1]
        seen = own > FILTER_ERROR.min_information_share * np.maximum(raw, 1e-300)
        safe = np.where(seen, own, 1.0)
        score = self.matrix[:-1, -1]
        return (
            np.where(seen, score**2 / safe, 0.0),
            np.where(seen, score / safe, 0.0),
            np.where(seen, safe**-0.5, np.inf),
        )

    def cosines(self, name: str) -> FloatArray:
        """Return how alike each parameter's column is to that of one, -1 to 1."""
        place = self.names.index(name)
        own = np.sqrt(np.maximum(self.matrix.diagonal()[:-1], 1e-300))
        return np.asarray(self.matrix[:-1, place] / own / own[place])
