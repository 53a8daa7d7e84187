"""What a method of estimation is given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gsapp.dynamics.model import Model
from gsapp.identification.axes import Axis
from gsapp.identification.campaign.settings import CampaignSettings
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.missing_channels import AssumedConstant


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EstimationTask:
    """Maneuvers of one axis, and what to estimate from them together."""

    maneuvers: tuple[Maneuver, ...]
    axis: Axis
    settings: CampaignSettings  # About the CG as flown.
    free: tuple[str, ...]  # Derivatives to estimate; none of them is in `held`.
    held: Mapping[str, float]  # Derivatives and parameters of effects that are known.
    start: Mapping[str, float]  # Start values, where some are known.
    assumed_constants: Mapping[str, AssumedConstant]
    """For channels that a maneuver lacks and the user gave no constant for, SI."""

    @property
    def model(self) -> Model | None:
        """Return the model whose values and effects are taken as known."""
        return self.settings.known_model

    @property
    def stand_ins(self) -> dict[str, float]:
        """Return a constant for each channel that a maneuver lacks, SI."""
        assumed = {name: one.value for name, one in self.assumed_constants.items()}
        return {**assumed, **self.settings.stand_ins}
