"""Constants in place of an airspeed or an angle of attack that was not measured, with their error.

The source's flight B had lost both, and was analyzed with averages of the other flights. A constant
is wrong by as much as other maneuvers differ; what that does to each derivative is found by
fitting again with the constant moved by that much, and goes into the bounds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.results import DerivativeEstimate, Estimate
from gsapp.quantities import FloatArray, name_in_text
from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class AssumedConstant:
    """A constant and how wrong it may be, SI."""

    value: float
    std: float


def campaign_assumed_constants(maneuvers: Sequence[Maneuver]) -> dict[str, AssumedConstant]:
    """Return what stands in for airspeed (m/s) and angle of attack (rad) where they are missing.

    `maneuvers`: of a campaign: means and spread over those that measured them; where none did, what
    the aircraft file suggests, cruise speed and the middle of the linear range.
    """
    if not maneuvers:
        return {}
    limits = maneuvers[0].aircraft.limits
    low, high = limits.alpha_linear
    cruise = PREPARATION.cruise_speed_ratio * limits.stall_speed
    guessed = {
        "V": AssumedConstant(value=cruise, std=PREPARATION.speed_spread * cruise),
        "alpha": AssumedConstant(value=0.5 * (low + high), std=0.25 * (high - low)),
    }
    found = {}
    for name, guess in guessed.items():
        flown = [value for one in maneuvers if (value := _trim_mean(one, name)) is not None]
        if flown:
            found[name] = _mean_over_maneuvers(np.array(flown), guess.std)
        elif guess.std > 0.0:
            found[name] = guess
    return found


def _mean_over_maneuvers(flown: FloatArray, guess: float) -> AssumedConstant:
    """Return what another maneuver was flown at: the mean, as uncertain as they scatter."""
    center = float(flown.mean())
    squares = float(np.sum((flown - center) ** 2)) + PREPARATION.spread_prior_weight * guess**2
    variance = (
        squares / (PREPARATION.spread_prior_weight + flown.size - 1) * (1.0 + 1.0 / flown.size)
    )
    return AssumedConstant(value=center, std=float(np.sqrt(variance)))


def _trim_mean(maneuver: Maneuver, name: str) -> float | None:
    if not maneuver.has(name):
        return None
    early = maneuver.samples(name)[
        maneuver.block.times <= maneuver.t_start + PREPARATION.trim_duration
    ]
    early = early[np.isfinite(early)]
    return float(early.mean()) if early.size else None


def required_constants(
    maneuvers: Sequence[Maneuver], known: Mapping[str, AssumedConstant], given: Mapping[str, float]
) -> dict[str, AssumedConstant]:
    """Return which of the stand-ins some maneuver needs; a constant given by the user comes first.

    `maneuvers`: fitted together.
    `given`: by the user, who answers for them.
    """
    return {
        name: one
        for name, one in known.items()
        if name not in given and any(not maneuver.has(name) for maneuver in maneuvers)
    }


def _std_text(name: str, one: AssumedConstant) -> str:
    return f"{one.std:.1f} m/s" if name == "V" else f"{one.std / DEGREE:.1f} deg"


def widen_bounds(
    found: Estimate, moved: Sequence[Estimate], assumed: Mapping[str, AssumedConstant]
) -> Estimate:
    """Return an estimate with the squares of what each change made of it added to its bounds.

    `moved`: with each of the constants in `assumed` moved by its deviation.
    """
    covariance = np.array(found.covariance)
    derivatives = dict(found.derivatives)
    kept = []
    for place, name in enumerate(found.free):
        values = [one.value(name) for one in moved]
        if any(value is None for value in values):
            derivatives[name] = DerivativeEstimate(
                value=None,
                status="unknown",
                why="not estimable with another value of the substituted channel",
            )
        else:
            kept.append(place)
    names = [found.free[place] for place in kept]
    covariance = covariance[np.ix_(kept, kept)]
    for one in moved:
        change = np.array([(one.value(name) or 0.0) - (found.value(name) or 0.0) for name in names])
        covariance += np.outer(change, change)
    for place, name in enumerate(names):
        derivatives[name] = replace(derivatives[name], std=float(np.sqrt(covariance[place, place])))
    said = (
        f"the bounds allow for {_std_text(name, one)} of error in the {name_in_text(name)} used "
        "instead"
        for name, one in assumed.items()
    )
    return replace(
        found,
        derivatives=derivatives,
        free=tuple(names),
        covariance=covariance,
        warnings=(*found.warnings, *said),
    )
