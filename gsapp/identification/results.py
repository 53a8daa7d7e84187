"""What every method of estimation returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from gsapp.identification.axes import Axis
from gsapp.quantities import FloatArray

DerivativeStatus = Literal["estimated", "held", "unknown", "not-identifiable"]
"""``unknown``: no excitation; ``not-identifiable``: cannot be told apart from others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivativeEstimate:
    """One derivative.

    Attributes
    ----------
    value, std, cramer_rao : float or None
        Per radian. `std` is the honest bound (colored residuals corrected), `cramer_rao` the
        uncorrected one. All None unless `status` is ``estimated``; a held one has its value.
    offset : float
        The part of `std` that comes from the zero of an instrument, per radian: the same in every
        maneuver that it flew in.
    status : str
    confounded_with : tuple of str
        What it cannot be told apart from.
    why : str
        In words, where it was not earned.
    """

    value: float | None
    std: float | None = None
    cramer_rao: float | None = None
    offset: float = 0.0
    status: DerivativeStatus = "estimated"
    confounded_with: tuple[str, ...] = ()
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseFit:
    """How well one computed response follows the measured one.

    Attributes
    ----------
    rms : float
        Of the residuals, SI.
    rms_over_range_pct : float
        As in tables 7.4.1 and 7.4.2: over the range of the measured response.
    r2 : float
        1 - sum of squared residuals / sum of squares about the mean.
    theil : float
        Theil's inequality coefficient, 0 (equal) to 1.
    samples : int
        That counted.
    """

    rms: float
    rms_over_range_pct: float
    r2: float
    theil: float
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResponseHistory:
    """Measured and computed responses of one maneuver.

    Attributes
    ----------
    maneuver : str
    times : ndarray, shape (n,)
    channels : tuple of str
    measured, computed : ndarray, shape (n, n_channels)
        SI; NaN in `measured` where a sample did not count.
    """

    maneuver: str
    times: FloatArray
    channels: tuple[str, ...]
    measured: FloatArray
    computed: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Estimate:
    """Derivatives from one maneuver, or from several fitted together.

    Attributes
    ----------
    method : str
        Id of an `EstimationMethod`.
    axis : {"lon", "lat", "both"}
    maneuvers : tuple of str
        Ids.
    derivatives : mapping of str to DerivativeEstimate
        Every derivative of the axis and every freed parameter of an effect.
    free : tuple of str
        The estimated ones: rows of `covariance`.
    covariance : ndarray, shape (len(free), len(free))
        Honest; its diagonal is the square of `DerivativeEstimate.std`.
    nuisance : mapping of str to (float, float)
        Initial states, biases, scale factors and time shifts: value, std. Keyed
        ``<maneuver>.<kind>.<channel>``, kind of ``initial``, ``bias``, ``scale``, ``shift``.
    fit : mapping of str to ResponseFit
        By response, over all maneuvers.
    histories : tuple of ResponseHistory
        One for each maneuver (ML) or empty.
    iterations : int
    converged : bool
    warnings : tuple of str
        Sentences for the crew: turbulence, colored residuals, stand-ins, suspicious signs.
    message : str
        Why it stopped.
    gusty_maneuvers : tuple of str
        Ids of the maneuvers in whose residuals gusts were found; the warnings say more.
    """

    method: str
    axis: Axis
    maneuvers: tuple[str, ...]
    derivatives: Mapping[str, DerivativeEstimate]
    free: tuple[str, ...]
    covariance: FloatArray
    nuisance: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    fit: Mapping[str, ResponseFit] = field(default_factory=dict)
    histories: tuple[ResponseHistory, ...] = ()
    iterations: int = 0
    converged: bool = True
    warnings: tuple[str, ...] = ()
    message: str = ""
    gusty_maneuvers: tuple[str, ...] = ()

    def value(self, name: str) -> float | None:
        """Return the value of a derivative; None where it was not earned."""
        found = self.derivatives.get(name)
        return None if found is None else found.value

    @property
    def correlation(self) -> FloatArray:
        """Return the correlation matrix of the free parameters."""
        scale = self.covariance.diagonal() ** 0.5
        correlation: FloatArray = self.covariance / scale[:, None] / scale
        return correlation
