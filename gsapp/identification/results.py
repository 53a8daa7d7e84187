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
    """One derivative."""

    value: float | None
    std: float | None = None
    cramer_rao: float | None = None
    """Per radian. `std` is the honest bound (colored residuals corrected), `cramer_rao` the
    uncorrected one. All None unless `status` is ``estimated``; a held one has its value."""
    offset: float = 0.0
    """The part of `std` that comes from the zero of an instrument, per radian: the same in every
    maneuver that it flew in."""
    status: DerivativeStatus = "estimated"
    confounded_with: tuple[str, ...] = ()  # What it cannot be told apart from.
    why: str = ""  # In words, where it was not earned.


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseInfluence:
    """What a derivative would change by, were a response left out of the fit."""

    response: str
    name: str  # Of the derivative.
    change: float  # Per radian.
    sigmas: float
    """The change in standard deviations of what the noise of the responses explains."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseFit:
    """How well one computed response follows the measured one."""

    rms: float  # Of the residuals, SI.
    rms_over_range_pct: float
    """As in tables 7.4.1 and 7.4.2: over the range of the measured response."""
    r2: float  # 1 - sum of squared residuals / sum of squares about the mean.
    theil: float  # Theil's inequality coefficient, 0 (equal) to 1.
    samples: int  # That counted.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResponseHistory:
    """Measured and computed responses of one maneuver."""

    maneuver: str
    times: FloatArray  # Shape (n,).
    channels: tuple[str, ...]
    measured: FloatArray
    computed: FloatArray
    """Shape (n, n_channels). SI; NaN in `measured` where a sample did not count."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Estimate:
    """Derivatives from one maneuver, or from several fitted together."""

    method: str  # Id of an `EstimationMethod`.
    axis: Axis
    maneuvers: tuple[str, ...]  # Ids.
    derivatives: Mapping[str, DerivativeEstimate]
    """Every derivative of the axis and every freed parameter of an effect."""
    free: tuple[str, ...]  # The estimated ones: rows of `covariance`.
    covariance: FloatArray  # Honest; its diagonal is the square of `DerivativeEstimate.std`.
    nuisance: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Initial states, biases, scale factors and time shifts: value, std. Keyed
    ``<maneuver>.<kind>.<channel>``, kind of ``initial``, ``bias``, ``scale``, ``shift``."""
    fit: Mapping[str, ResponseFit] = field(default_factory=dict)  # By response, over all maneuvers.
    histories: tuple[ResponseHistory, ...] = ()  # One for each maneuver (ML) or empty.
    iterations: int = 0
    converged: bool = True
    warnings: tuple[str, ...] = ()
    """Sentences for the crew: turbulence, colored residuals, stand-ins, suspicious signs."""
    message: str = ""  # Why it stopped.
    gusty_maneuvers: tuple[str, ...] = ()
    """Ids of the maneuvers in whose residuals gusts were found; the warnings say more."""
    influences: tuple[ResponseInfluence, ...] = ()
    """Where a response contradicts the others (ML)."""

    @property
    def estimated(self) -> dict[str, tuple[float, float]]:
        """Return value and bound of every derivative that was earned."""
        return {
            name: (one.value, one.std)
            for name, one in self.derivatives.items()
            if one.status == "estimated" and one.value is not None and one.std
        }

    def value(self, name: str) -> float | None:
        """Return the value of a derivative; None where it was not earned."""
        found = self.derivatives.get(name)
        return None if found is None else found.value

    @property
    def correlation(self) -> FloatArray:
        scale = self.covariance.diagonal() ** 0.5
        correlation: FloatArray = self.covariance / scale[:, None] / scale
        return correlation
