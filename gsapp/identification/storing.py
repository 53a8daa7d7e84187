"""Runs of a campaign kept in the catalog, with the settings to repeat them."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

from gsapp.flight.catalog import Catalog, Run, StoredEstimate, StoredModel, store_model, store_run
from gsapp.foundation.toml import toml_text
from gsapp.identification.campaign import CampaignResult, CampaignSettings
from gsapp.identification.results import Estimate


def store_campaign(catalog: Catalog, result: CampaignResult) -> tuple[int, ...]:
    """Store every estimate of a campaign; return the numbers of the runs.

    The maneuvers must be in the catalog.

    Parameters
    ----------
    catalog : Catalog
    result : CampaignResult
    """
    model = result.settings.model
    if model is not None:
        text = toml_text(model.model_dump(exclude_none=True))
        store_model(catalog, StoredModel(name=model.name, content=text))
    settings = settings_json(result.settings)
    places = {
        one.maneuver.id: (one.maneuver.flight, one.maneuver.id.rpartition(":")[2])
        for one in result.results
    }
    estimates = [one.estimate for one in result.results if one.estimate is not None]
    return tuple(
        store_run(
            catalog,
            Run(
                method=one.method,
                axis=one.axis,
                maneuvers=tuple(places[name] for name in one.maneuvers),
                estimates=_stored(one),
                settings=settings,
                fit={name: asdict(found) for name, found in one.fit.items()},
                model=None if model is None else model.name,
                converged=one.converged,
                iterations=one.iterations,
                warnings=one.warnings,
                message=one.message,
            ),
        )
        for one in (*estimates, *result.joint)
    )


def settings_json(settings: CampaignSettings) -> dict[str, Any]:
    """Return settings as JSON can hold them; the model by its name."""
    content = asdict(replace(settings, likelihood=replace(settings.likelihood, model=None)))
    content["model"] = None if settings.model is None else settings.model.name
    return content


def _stored(estimate: Estimate) -> dict[str, StoredEstimate]:
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
