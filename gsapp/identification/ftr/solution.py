"""Estimates with their bounds and qualities, from what records say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.axis_dynamics import AxisDynamics
from gsapp.identification.ftr.batched_linalg import invert_normal_matrices as inverse_of
from gsapp.identification.ftr.batched_linalg import subtract_white_noise
from gsapp.identification.ftr.information import RecordInformation
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FTRSolution:
    """Estimates at U moments, from one axis's three equations."""

    theta: FloatArray
    """Shape (U, 3, p)."""
    covariance: FloatArray
    """Shape (U, 3, p, p). Honest."""
    std: FloatArray
    """Shape (U, 3, p). Square roots of its diagonal."""
    plain: FloatArray
    """Shape (U, 3, p). Standard deviation if residuals were white."""
    bias: FloatArray
    bias_std: FloatArray
    """Shape (U, 3). The constant part of the coefficient; the zero offset of its accelerometer is
    in its bound."""
    bias_slopes: FloatArray
    """Shape (U, 3, p). Derivatives of the bias by theta: minus the mean of each variable."""
    signal_to_noise: FloatArray
    """Shape (U, 3, p). What each variable did on its own (not explained by the others), over its
    noise."""
    alone: FloatArray
    """Shape (U, 3, p). Share of its energy that a variable had on its own, 0 to 1."""
    amplitude: FloatArray
    """Shape (U, 3, p). Rms of each variable in the band over the time listened to, in its unit."""
    uncertain: FloatArray
    """Shape (U, 3, p + 1). Bound times what the variable did, over what the coefficient did; of the
    bias, last."""
    freedom: FloatArray
    """Shape (U, 3). Real equations less unknowns."""
    listened: FloatArray
    """Shape (U, 3). Effective time, s."""
    correlation: FloatArray
    """Shape (U, 3, p, p). Of the regressors in the band."""

    def covariance_with_bias(self, equation: int) -> FloatArray:
        """Return the last covariance of an equation, bias first, shape (p + 1, p + 1)."""
        inner = self.covariance[-1, equation]
        cross = inner @ self.bias_slopes[-1, equation]
        p = len(inner)
        out = np.empty((p + 1, p + 1))
        out[1:, 1:] = inner
        out[0, 1:] = out[1:, 0] = cross
        out[0, 0] = self.bias_std[-1, equation] ** 2
        return out

    def select_moment(self, moment: int) -> FTRSolution:
        """Return one moment (U = 1)."""
        place = moment % len(self.theta)
        return FTRSolution(
            **{one.name: getattr(self, one.name)[place : place + 1].copy() for one in fields(self)}
        )

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @staticmethod
    def from_state(state: Mapping[str, npt.NDArray[np.generic]]) -> FTRSolution:
        names = (one.name for one in fields(FTRSolution))
        return FTRSolution(**{name: np.array(state[name], dtype=np.float64) for name in names})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SolvableInformation:
    """What there is to conclude from at U moments."""

    information: RecordInformation
    """Of all records, arrays of shape (U, 3, ...)."""
    inverse: FloatArray
    """Shape (U, 3, p, p). Of its G, white noise of the regressors taken off."""

    @staticmethod
    def from_closed_records(past: RecordInformation) -> SolvableInformation:
        """Return what closed records alone say, at U moments."""
        return SolvableInformation(
            information=past, inverse=subtract_white_noise(inverse_of(past.G), past.white)
        )

    @staticmethod
    def concatenate(parts: Sequence[SolvableInformation]) -> SolvableInformation:
        """Return moments one after the other."""
        if len(parts) == 1:
            return parts[0]
        tables = np.concatenate([part.information.table for part in parts])
        return SolvableInformation(
            information=RecordInformation(tables, parts[0].information.p),
            inverse=np.concatenate([part.inverse for part in parts]),
        )


def solve_estimates(evidence: SolvableInformation, body: AxisDynamics) -> FTRSolution:
    """Return estimates and their qualities."""
    information, inverse = evidence.information, evidence.inverse
    G = information.G
    p = G.shape[-1]
    theta = np.matvec(inverse, information.b)
    diagonal: FloatArray = np.diagonal(G, axis1=2, axis2=3)
    wide = _bound_inflation(diagonal**2 / np.maximum(information.squared_weight, 1e-300))
    covariance = inverse @ information.meat @ inverse
    covariance *= wide[..., np.newaxis] * wide[..., np.newaxis, :]
    there = diagonal > 0.0
    natural = np.where(there, diagonal, 1.0)
    variance = np.diagonal(inverse, axis1=2, axis2=3)
    own = np.where(there, np.minimum(1.0 / np.where(there, variance, 1.0), diagonal), 0.0)
    base = information.mean[..., p]
    safe = np.where(base > 0.0, base, 1.0)
    slopes = np.divide(-information.mean[..., :p], safe[..., np.newaxis], order="C")
    bias = information.mean[..., p + 1] / safe + np.vecdot(slopes, theta)
    through = np.vecdot(np.matvec(covariance, slopes), slopes)
    # The mean square of qbar over the time listened to.
    square = information.pressure_energy / np.maximum(information.effective_time, 1e-300)
    zero = body.accelerometer_offset**2 / np.where(square > 0.0, square, 1.0)
    bias_std = np.sqrt(np.maximum(through + information.mean_noise / safe**2 + zero, 0.0))
    std = np.sqrt(np.maximum(np.diagonal(covariance, axis1=2, axis2=3), 0.0))
    variation = np.sqrt(np.maximum(information.coefficient_energy, 1e-300))
    uncertain = np.concatenate(
        (
            std * np.sqrt(information.regressor_energy) / variation[..., np.newaxis],
            (bias_std * np.sqrt(information.pressure_energy) / variation)[..., np.newaxis],
        ),
        axis=-1,
    )
    noise = np.maximum(information.noise, 1e-300)
    # What white noise made of G is taken off already.
    left = information.noise - information.white
    scale = np.sqrt(natural)
    return FTRSolution(
        theta=theta,
        covariance=covariance,
        std=std,
        # Records are weighted by one over the variance of their residuals.
        plain=np.sqrt(np.maximum(variance, 0.0)),
        bias=bias,
        bias_std=bias_std,
        bias_slopes=slopes,
        signal_to_noise=np.sqrt(np.maximum(own - left, 0.0) / noise),
        alone=np.where(there, own / natural, 0.0),
        amplitude=np.sqrt(
            information.regressor_energy
            / np.maximum(information.pressure_energy, 1e-300)[..., np.newaxis]
        ),
        uncertain=uncertain,
        freedom=information.degrees_of_freedom,
        listened=information.effective_time,
        correlation=G / (scale[..., np.newaxis] * scale[..., np.newaxis, :]),
    )


def _bound_inflation(freedom: FloatArray) -> FloatArray:
    """Return what widens bounds so that three of them hold as much as of a normal distribution.

    The level of the residuals is itself estimated, around each frequency from its neighbors: as
    if from two thirds of all residuals. (Student's quantile over three, expanded.)
    """
    levels = np.maximum(2.0 / 3.0 * freedom, 4.0)
    return np.asarray(1.0 + 2.5 / levels + 5.75 / levels**2, dtype=np.float64)
