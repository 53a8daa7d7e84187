"""The JSON of ``gsapp estimate`` and the fits of a campaign as a catalog holds them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from gsapp.flight.catalog import EstimationRun, StoredEstimate
from gsapp.identification.campaign import (
    CampaignResult,
    CampaignSettings,
    CampaignValue,
    ManeuverResult,
)
from gsapp.identification.results import DerivativeEstimate, Estimate


def campaign_json(result: CampaignResult) -> dict[str, Any]:
    """Return what a program needs of a campaign."""
    return {
        "method": result.settings.method,
        "axis": result.settings.axis,
        "maneuvers": [_maneuver(one) for one in result.results],
        "campaign": {name: value_json(one) for name, one in result.values.items()},
        "joint": _joint(result) if result.settings.joint else None,
        "remarks": list(result.remarks),
    }


def _maneuver(result: ManeuverResult) -> dict[str, Any]:
    maneuver, estimate = result.maneuver, result.estimate
    content: dict[str, Any] = {
        "id": maneuver.id,
        "flight": maneuver.flight,
        "t_start": round(maneuver.t_start, 6),
        "t_end": round(maneuver.t_end, 6),
        "input": "+".join(maneuver.inputs),
        "axis": None if estimate is None else estimate.axis,
        "method": None if estimate is None else estimate.method,
    }
    if estimate is None:
        return {
            **content,
            **{key: {} for key in ("derivatives", "cramer_rao", "fit")},
            "iterations": 0,
            "converged": False,
            "why": result.failure,
            "comparisons": {},
        }
    return {**content, **_estimate(estimate), "comparisons": _comparisons(result.comparisons)}


def _comparisons(others: Mapping[str, Estimate]) -> dict[str, Any]:
    """Return the derivatives and warnings of other methods, by the id of the method."""
    return {
        method: {
            "derivatives": {
                name: _derivative(one)
                for name, one in estimate.derivatives.items()
                if one.status != "held"
            },
            "warnings": list(estimate.warnings),
        }
        for method, estimate in others.items()
    }


def _estimate(estimate: Estimate) -> dict[str, Any]:
    return {
        "derivatives": {
            name: _derivative(one)
            for name, one in estimate.derivatives.items()
            if one.status != "held"
        },
        "held": {
            name: _number(one.value)
            for name, one in estimate.derivatives.items()
            if one.status == "held"
        },
        "cramer_rao": {
            name: _number(one.cramer_rao)
            for name, one in estimate.derivatives.items()
            if one.status == "estimated"
        },
        "fit": {
            name: {
                "rms": _number(one.rms),
                "rms_over_range_pct": _number(one.rms_over_range_pct),
                "r2": _number(one.r2),
                "theil": _number(one.theil),
            }
            for name, one in estimate.fit.items()
        },
        "nuisance": {
            name: {"value": _number(value), "std": _number(std)}
            for name, (value, std) in estimate.nuisance.items()
        },
        "correlation": {
            "names": list(estimate.free),
            "matrix": [[_number(one) for one in row] for row in estimate.correlation.tolist()],
        },
        "influences": [
            {
                "without": one.response,
                "derivative": one.name,
                "change": one.change,
                "sigmas": one.sigmas,
            }
            for one in estimate.influences
        ],
        "iterations": estimate.iterations,
        "converged": estimate.converged,
        "message": estimate.message,
        "warnings": list(estimate.warnings),
    }


def _derivative(one: DerivativeEstimate) -> dict[str, Any]:
    if one.status == "estimated":
        return {"value": _number(one.value), "std": _number(one.std)}
    return {
        "value": None,
        "std": None,
        "status": one.status,
        "with": list(one.confounded_with),
        "why": one.why,
    }


def value_json(one: CampaignValue) -> dict[str, Any]:
    """Return a mean with its standard error, scatter and count."""
    return {
        "mean": one.mean,
        "std": one.std,
        "systematic": one.systematic,
        "scatter": _number(one.scatter),
        "n": one.n,
    }


def _joint(result: CampaignResult) -> dict[str, Any] | None:
    """Return all joint fits in one: their derivatives are those of different axes."""
    if not result.joint:
        return None
    derivatives: dict[str, Any] = {}
    for estimate in result.joint:
        for name, one in estimate.derivatives.items():
            if one.status != "held" and derivatives.get(name, {}).get("value") is None:
                derivatives[name] = _derivative(one)
    return {
        "derivatives": derivatives,
        "fits": [
            {
                "axis": one.axis,
                "maneuvers": list(one.maneuvers),
                **_estimate(one),
                "comparisons": _comparisons(others),
            }
            for one, others in zip(result.joint, result.joint_comparisons, strict=True)
        ],
    }


def _number(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)


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
