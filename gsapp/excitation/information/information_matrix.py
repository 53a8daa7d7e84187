"""What maneuvers say of derivatives, and how it adds up: like one fit of all of them together.

A fit has the covariance H^-1 B H^-1 with the information H = sum S'WS and the covariance B of the
gradient sum S'W n under the noise there is (`gsapp.identification.statistics.bounds`). Both add up
over maneuvers once what each has for itself (initial states, biases; l) is projected out of what
they share (derivatives; s): with T = [I, -H_sl H_ll^-1] they become T H T' and T B T'.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.excitation.settings import INFORMATION
from gsapp.identification.axes import Axis, axis_derivatives
from gsapp.identification.statistics.bounds import invert_information
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverInformation:
    """What one maneuver says of derivatives, initial states and biases projected out."""

    names: tuple[str, ...]
    """Derivatives that it sees."""
    matrix: FloatArray
    gradient_covariance: FloatArray
    """Shape (n_names, n_names). H and B."""

    @property
    def stds(self) -> dict[str, float]:
        """Return the bound of each derivative by this maneuver alone."""
        return dict(
            zip(
                self.names,
                compute_bounds(self.matrix, self.gradient_covariance).tolist(),
                strict=True,
            )
        )


def marginalize_information(
    wanted: Sequence[str], names: Sequence[str], H: FloatArray, covariance: FloatArray
) -> ManeuverInformation:
    """Return the information of a fit over those of the wanted derivatives that it sees.

    Parameters
    ----------
    names : sequence of str
        All unknowns of the fit.
    H, covariance : ndarray, shape (n_names, n_names)
        Information, and honest covariance; infinite variances for what is not seen.
    """
    variances = covariance.diagonal()
    seen = np.isfinite(variances) & (variances > 0.0)
    shared = [
        place
        for place, name in enumerate(names)
        if name in wanted and seen[place] and variances[place] < INFORMATION.unobservable_bound**2
    ]
    local = [place for place, name in enumerate(names) if name not in wanted and seen[place]]
    order = [*shared, *local]
    H, covariance = H[np.ix_(order, order)], covariance[np.ix_(order, order)]
    B = H @ covariance @ H
    count = len(shared)
    T = np.eye(count, len(order))
    T[:, count:] = -np.linalg.solve(H[count:, count:], H[count:, :count]).T
    matrix, unrest = T @ H @ T.T, T @ B @ T.T
    return ManeuverInformation(
        names=tuple(names[place] for place in shared),
        matrix=0.5 * (matrix + matrix.T),
        gradient_covariance=0.5 * (unrest + unrest.T),
    )


def compute_bounds(matrix: FloatArray, unrest: FloatArray) -> FloatArray:
    """Return the bounds of a fit with information H and unrest B, shape (..., n, n) each."""
    scale = 1.0 / np.sqrt(np.einsum("...ii->...i", matrix))
    both = scale[..., :, None] * scale[..., None, :]
    inverted = np.linalg.inv(matrix * both)
    variances = (inverted @ (unrest * both) * inverted).sum(axis=-1)
    return np.asarray(scale * np.sqrt(np.maximum(variances, 0.0)), dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CombinedInformation:
    """All that the maneuvers of one axis said together."""

    names: tuple[str, ...]
    """All derivatives of the axis."""
    matrix: FloatArray
    gradient_covariance: FloatArray
    """Shape (n_names, n_names). Sums of H and B; zero rows for what none saw."""
    information_vector: FloatArray
    """Shape (n_names,). Sum of H times estimates."""

    @staticmethod
    def empty(axis: Axis) -> CombinedInformation:
        """Return what is known before the first maneuver."""
        names = axis_derivatives(axis)
        square = np.zeros((len(names), len(names)))
        return CombinedInformation(
            names=names,
            matrix=square,
            gradient_covariance=square,
            information_vector=np.zeros(len(names)),
        )

    def with_maneuver(
        self, information: ManeuverInformation, values: Mapping[str, float]
    ) -> CombinedInformation:
        """Return the total with another maneuver's information and estimates."""
        places = [self.names.index(name) for name in information.names]
        own = np.array([values[name] for name in information.names])
        matrix, unrest, pull = (
            self.matrix.copy(),
            self.gradient_covariance.copy(),
            self.information_vector.copy(),
        )
        matrix[np.ix_(places, places)] += information.matrix
        unrest[np.ix_(places, places)] += information.gradient_covariance
        pull[places] += information.matrix @ own
        return CombinedInformation(
            names=self.names, matrix=matrix, gradient_covariance=unrest, information_vector=pull
        )

    def estimates(self) -> dict[str, tuple[float, float]]:
        """Return value and bound of each derivative that was seen: those of one joint fit."""
        inverted = invert_information(self.matrix)
        seen = np.flatnonzero(np.isfinite(inverted.diagonal()))
        inverted = inverted[np.ix_(seen, seen)]
        values = inverted @ self.information_vector[seen]
        variances = (inverted @ self.gradient_covariance[np.ix_(seen, seen)] @ inverted).diagonal()
        return {
            self.names[place]: (float(value), math.sqrt(variance))
            for place, value, variance in zip(seen, values, variances, strict=True)
            if variance > 0.0
        }
