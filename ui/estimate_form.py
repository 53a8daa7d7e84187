"""What the panel of the estimate holds, as it was typed; kept from one start to the next. No Qt."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from gsapp.foundation import StrictModel

DerivativeTreatment = Literal["tables", "free", "held"]
"""By tables 6.2.5 and 6.2.6, estimated whatever moved, or held at a value."""


class DerivativeEntry(StrictModel):
    """What is wished for one derivative; texts are empty where nothing was typed.

    Attributes
    ----------
    treated : {"tables", "free", "held"}
    value : str
        That it is held at.
    start : str
        Where the fit begins.
    prior, deviation : str
        A-priori value and its standard deviation.
    """

    treated: DerivativeTreatment = "tables"
    value: str = ""
    start: str = ""
    prior: str = ""
    deviation: str = ""


class EstimateForm(StrictModel):
    """Everything on the panel.

    Attributes
    ----------
    maneuvers : {"used", "chosen", "all"}
        Those in use, the one that is chosen, or all that were found.
    axis, method, six_degrees, joint
        As in `gsapp.identification.campaign.CampaignSettings`.
    derivatives : dict of str to DerivativeEntry
        Those with a wish of their own.
    weights : str
        Name or path of a weights file; empty estimates the noise from the residuals.
    noise, integration
        As in `gsapp.identification.maximum_likelihood.MLSettings`.
    bound_factor : str
        In place of the correction for colored residuals.
    responses, biases, states : tuple of str, optional
        None for those of the axis.
    scale_factors, time_shifts : tuple of str
    stand_ins : str
        ``NAME=VALUE`` with commas between, SI.
    model, aircraft, calibration, channel_map : str
        Names or paths; empty for none, and for those of the flights.
    """

    maneuvers: Literal["used", "chosen", "all"] = "used"
    axis: Literal["both", "lon", "lat"] = "both"
    method: Literal["ml", "ee", "ftr"] = "ml"
    six_degrees: bool = False
    joint: bool = False
    derivatives: dict[str, DerivativeEntry] = Field(default_factory=dict)
    weights: str = ""
    noise: Literal["diagonal", "full"] = "diagonal"
    integration: Literal["rk4", "euler"] = "rk4"
    bound_factor: str = ""
    responses: tuple[str, ...] | None = None
    biases: tuple[str, ...] | None = None
    states: tuple[str, ...] | None = None
    scale_factors: tuple[str, ...] = ()
    time_shifts: tuple[str, ...] = ()
    stand_ins: str = ""
    model: str = ""
    aircraft: str = ""
    calibration: str = ""
    channel_map: str = ""

    def derivative(self, name: str) -> DerivativeEntry:
        """Return the wish for a derivative."""
        return self.derivatives.get(name, DerivativeEntry())

    def with_derivative(self, name: str, wish: DerivativeEntry) -> EstimateForm:
        """Return the wishes with another one for a derivative."""
        others = {known: own for known, own in self.derivatives.items() if known != name}
        if wish != DerivativeEntry():
            others[name] = wish
        return self.model_copy(update={"derivatives": others})

    def with_changes(self, **values: object) -> EstimateForm:
        """Return the wishes with other values."""
        return self.model_copy(update=values)
