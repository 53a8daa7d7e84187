"""A small campaign with known derivatives, estimated once: elevator doublets of two flights.

The maneuvers are those of `virtual_maneuvers`, so they cost little; one of them was flown by
another aircraft than the rest, which makes it wild.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

from gsapp.dynamics.model import load_model
from gsapp.identification.campaign import CampaignResult, CampaignSettings, run_campaign
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_execution import RunOutcome
from gsapp.identification.summary import summarize_campaign
from gsapp.identification.summary.campaign_linear_models import build_linear_models
from tests.identification.virtual_maneuvers import fly

TRUTH = load_model("b777")
SEEDS = (41, 42, 43, 44, 45, 46)
WILD = "2:M5"
"""The maneuver of the other aircraft."""


@cache
def maneuvers() -> tuple[Maneuver, ...]:
    other = TRUTH.with_derivatives(
        {"Cm_de": -2.2, "Cm_q": -60.0, "Cm_alpha": -0.9, "CN_alpha": 3.0}
    )
    found = []
    for index, seed in enumerate(SEEDS):
        number, flight = (1, "A") if index < 4 else (2, "B")
        name = f"{number}:M{index + 1}"
        model = other if name == WILD else TRUTH
        flown = fly(seed, "lon", dt=0.02, duration=6.0, model=model).maneuver
        found.append(replace(flown, id=name, flight=flight))
    return tuple(found)


@cache
def outcome() -> RunOutcome:
    """Return what maximum likelihood makes of them, with the truth as what was known before."""
    settings = CampaignSettings(known_model=TRUTH)
    return _outcome(run_campaign(maneuvers(), settings))


@cache
def together() -> RunOutcome:
    """Return what comes of the four maneuvers of flight A, fitted together, too."""
    settings = CampaignSettings(known_model=TRUTH, joint=True)
    return _outcome(run_campaign(maneuvers()[:4], settings))


def regressed(count: int) -> RunOutcome:
    return _outcome(run_campaign(maneuvers()[:count], CampaignSettings(method="ee", axis="lon")))


@cache
def unearned() -> RunOutcome:
    still = fly(47, "lon", dt=0.02, duration=4.0, model=TRUTH, still=("de",)).maneuver
    settings = CampaignSettings(axis="lon")
    return _outcome(run_campaign([replace(still, id="M1", flight="A", inputs=("de",))], settings))


@cache
def gusty() -> RunOutcome:
    flown = [
        replace(
            fly(51, "lon", dt=0.02, duration=8.0, gust=gust, model=TRUTH).maneuver,
            id=name, flight="A",
        )
        for name, gust in (("M1", 1.0), ("M2", 0.0))
    ]  # fmt: skip
    return _outcome(run_campaign(flown, CampaignSettings()))


def _outcome(result: CampaignResult) -> RunOutcome:
    summary = summarize_campaign(result)
    models, why_not = build_linear_models(result, summary)
    return RunOutcome(
        request=RunRequest(**dict(result.settings, flights=(Path("A"), Path("B")), label="trial")),
        aircraft="B777",
        result=result,
        summary=summary,
        models=models,
        remarks=why_not,
    )
