"""What the form of the estimate holds, as it was typed; kept from one start to the next. No Qt."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, Field

from gsapp.foundation import StrictModel
from gsapp.identification.estimate_settings import EstimateSettings

DerivativeTreatment = Literal["tables", "free", "held"]
"""By tables 6.2.5 and 6.2.6, estimated whatever moved, or held at a value."""


class DerivativeEntry(StrictModel):
    """The entry of one derivative; texts are empty where nothing was typed."""

    treated: DerivativeTreatment = "tables"
    value: str = ""  # That it is held at.
    start: str = ""  # Where the fit begins.
    # A-priori value and its standard deviation.
    prior: str = ""
    deviation: str = ""


class EstimateForm(EstimateSettings):
    """Everything on the form: the settings, some of them as they were typed."""

    # Those in use, the one that is chosen, or all that were found.
    maneuvers: Literal["used", "chosen", "all"] = "used"
    # Those with an entry: in place of the settings `free`, `held`, `start` and `priors`.
    derivatives: dict[str, DerivativeEntry] = Field(default_factory=dict)
    bound_factor: str = ""  # type: ignore[assignment]
    stand_ins: str = ""  # type: ignore[assignment]

    def __init__(self, **values: Any) -> None:
        # What was typed is parsed later: not as `EstimateSettings` does.
        BaseModel.__init__(self, **values)

    def derivative(self, name: str) -> DerivativeEntry:
        return self.derivatives.get(name, DerivativeEntry())

    def with_derivative(self, name: str, entry: DerivativeEntry) -> EstimateForm:
        others = {known: own for known, own in self.derivatives.items() if known != name}
        if entry != DerivativeEntry():
            others[name] = entry
        return self.model_copy(update={"derivatives": others})

    def with_changes(self, **values: object) -> EstimateForm:
        """Return the form with other values, which nothing checks yet."""
        return self.model_copy(update=values)
