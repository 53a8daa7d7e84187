"""What a maximum likelihood fit is told."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pydantic import Field, NonNegativeFloat

from gsapp.dynamics.model import Model
from gsapp.identification.axes import Axis
from gsapp.identification.estimate_settings import FitSettings


class MLSettings(FitSettings):
    """Settings of a maximum likelihood (output error) fit."""

    axis: Axis
    model: Model | None = Field(
        None,
        description="Gives the effects beyond the linear build-up, and values of derivatives that "
        "are not free.",
    )
    weights: Mapping[str, NonNegativeFloat] | None = Field(
        None,
        description="Weight of each response (SI; diagonal of W1). By default the noise "
        "covariance is estimated from the residuals, for each maneuver its own, and iterated.",
    )
    joint_weights: Mapping[str, Mapping[str, NonNegativeFloat]] | None = Field(
        None, description="The same by maneuver id; comes before `weights`."
    )

    def with_stand_ins(self, values: Mapping[str, float]) -> MLSettings:
        """Return settings with constants for further channels; those of the settings count."""
        return self.with_changes(stand_ins={**values, **self.stand_ins})


@dataclass(frozen=True, slots=True, kw_only=True)
class FitProgress:
    """How far a fit has come."""

    iteration: int
    cost: float  # Mean square of the weighted residuals, over that at the start.
    change: float  # Share of the cost that the last step promised to take off.


FitProgressCallback = Callable[[FitProgress], bool | None]
"""Called after every iteration; returning False stops the fit where it is."""
