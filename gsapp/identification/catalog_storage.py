"""The fits of a campaign as a catalog holds them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from gsapp.flight.catalog import EstimationRun, StoredEstimate
from gsapp.identification.campaign import CampaignResult, CampaignSettings
from gsapp.identification.results import Estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class CatalogManeuver:
    """Where a maneuver of a campaign stands in a catalog."""

    flight: str
    name: str
    edges: tuple[float, float]  # First and last sample of the fit, s.


def catalog_runs(
    result: CampaignResult, places: Mapping[str, CatalogManeuver], *, kept: int | None = None
) -> tuple[EstimationRun, ...]:
    """Return every fit of a campaign, those of single maneuvers first.

    `places`: by the id of the maneuver in this campaign.
    `kept`: number of the run that they belong to.
    """
    settings = settings_json(result.settings)
    model = result.settings.known_model
    estimates = [one.estimate for one in result.results if one.estimate is not None]
    return tuple(
        EstimationRun(
            method=one.method,
            axis=one.axis,
            maneuvers=tuple((places[id_].flight, places[id_].name) for id_ in one.maneuvers),
            edges=tuple(places[id_].edges for id_ in one.maneuvers),
            estimates=stored_estimates(one),
            settings=settings,
            fit={name: _finite_or_none(asdict(found)) for name, found in one.fit.items()},
            model=None if model is None else model.name,
            converged=one.converged,
            iterations=one.iterations,
            warnings=one.warnings,
            message=one.message,
            campaign_run_id=kept,
        )
        for one in (*estimates, *result.joint)
    )


def stored_estimates(estimate: Estimate) -> dict[str, StoredEstimate]:
    """Return the derivatives of a fit as a catalog holds them."""
    return {
        name: StoredEstimate(
            value=one.value,
            std=one.std,
            cramer_rao=one.cramer_rao,
            status=one.status,
            confounded_with=one.confounded_with,
            why=one.why,
        )
        for name, one in estimate.derivatives.items()
    }


def _finite_or_none(figures: Mapping[str, float]) -> dict[str, float | None]:
    """Return figures with None for those that do not exist, as of a response that stood still."""
    return {name: one if math.isfinite(one) else None for name, one in figures.items()}


def settings_json(settings: CampaignSettings) -> dict[str, Any]:
    """Return settings as JSON can hold them; the model by its name."""
    model = settings.known_model
    content = settings.model_dump(mode="json", exclude={"known_model"})
    return {**content, "model": None if model is None else model.name}
