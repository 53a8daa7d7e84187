"""How a campaign is estimated: the user's settings with the content of the files they name."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field, NonNegativeFloat

from gsapp.dynamics.model import Model
from gsapp.identification.estimate_settings import EstimateSettings


class CampaignSettings(EstimateSettings):
    """The settings of a campaign, which no longer depend on a file."""

    known_model: Model | None = Field(
        None, description="Content of `model`: its values and effects are taken as known."
    )
    response_weights: Mapping[str, Mapping[str, NonNegativeFloat]] | None = Field(
        None,
        description="Content of `weights`: of the responses (SI), by name of the flight; '' for "
        "all others.",
    )
