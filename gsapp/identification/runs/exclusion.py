"""The same results with some maneuvers left out of the means by hand."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from gsapp.identification.runs.outcome import RunOutcome
from gsapp.identification.summary import summarize_campaign
from gsapp.identification.summary.campaign_linear_models import (
    NO_LINEAR_MODEL_PREFIX,
    build_linear_models,
)


def exclude_maneuvers(outcome: RunOutcome, maneuvers: Collection[str]) -> RunOutcome:
    """Return an outcome with other maneuvers left out of its means; no maneuver is fitted again.

    `maneuvers`: ids as in its result; empty takes all of them in.
    """
    summary = summarize_campaign(outcome.result, without=maneuvers)
    models, why_not = build_linear_models(outcome.result, summary)
    rest = tuple(one for one in outcome.remarks if not one.startswith(NO_LINEAR_MODEL_PREFIX))
    return replace(
        outcome,
        request=outcome.request.with_changes(without=tuple(sorted(summary.excluded_maneuvers))),
        summary=summary,
        models=models,
        remarks=(*rest, *why_not),
    )
