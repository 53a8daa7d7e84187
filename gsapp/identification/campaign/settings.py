"""How a campaign is estimated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from gsapp.dynamics.model import Model
from gsapp.identification import maximum_likelihood as ml
from gsapp.identification.axes import Axis
from gsapp.identification.results import EstimationMethod


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignSettings:
    """How to estimate.

    Attributes
    ----------
    method : {"ml", "ee", "ftr"}
    axis : {"lon", "lat", "both"}
        ``both``: each maneuver by its own surfaces, six degrees of freedom where it moved both
        the elevator and a lateral surface.
    six_degrees : bool
        Fit all six degrees of freedom in every maneuver.
    free : tuple of str, optional
        Free derivatives and effect parameters in place of the tables.
    held : mapping of str to float
    weights : mapping of str to mapping, optional
        Of the responses (SI), by name of the flight; ``""`` for all others.
    likelihood : MLSettings
        Everything else that maximum likelihood takes; its axis does not matter.
    joint : bool
        Whether to fit all maneuvers of an axis together, too.
    """

    method: EstimationMethod = "ml"
    axis: Axis = "both"
    six_degrees: bool = False
    free: tuple[str, ...] | None = None
    held: Mapping[str, float] = field(default_factory=dict)
    weights: Mapping[str, Mapping[str, float]] | None = None
    likelihood: ml.MLSettings = field(default_factory=lambda: ml.MLSettings(axis="lon"))
    joint: bool = False

    @property
    def model(self) -> Model | None:
        """Return the model whose values and effects are taken as known."""
        return self.likelihood.model
