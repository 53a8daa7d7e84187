"""What a search needs before it begins, and what kinematics alone say of the instruments."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.effect_catalog import all_effects, excluded_effects, find_effect
from gsapp.discrepancy.results import InstrumentRemark
from gsapp.discrepancy.settings import SEARCH
from gsapp.foundation import FlightError
from gsapp.identification.compatibility import (
    CompatibilitySettings,
    InstrumentVerdict,
    check_compatibility,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.stuck_channels import check_sample_count


def check_instruments(
    maneuvers: Sequence[Maneuver], *, try_signs: bool = True
) -> tuple[InstrumentRemark, ...]:
    """Return what the data compatibility check says, of maneuvers from all over the flights.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
    try_signs : bool
        Whether reversed and exchanged axes are looked for: most of the work, and of no use where a
        model explains the flights down to the noise.
    """
    settings = CompatibilitySettings(try_signs=try_signs, iterations=SEARCH.max_check_iterations)
    flown = sorted(maneuvers, key=lambda one: (one.flight, one.block.times[0]))
    every = -(-len(flown) // SEARCH.max_checked_maneuvers)
    try:
        found = check_compatibility(flown[::every], settings=settings)
    except FlightError as error:
        return (InstrumentRemark(channel="", words=str(error), consistent=False),)
    if not found.verdicts:
        return (InstrumentRemark(channel="", words=found.summary, consistent=found.consistent),)
    return tuple(
        InstrumentRemark(
            channel=", ".join(one.channels),
            words=one.sentence,
            consistent=False,
            effect=_effect(one),
        )
        for one in found.verdicts
    )


def _effect(verdict: InstrumentVerdict) -> str:
    """Return the effect of the catalog that a verdict proves; empty if none."""
    known = {one.id for one in all_effects()}
    if verdict.kind == "reversed":
        names = [f"sensor.{verdict.channels[0]}.reversed"]
    elif verdict.kind == "exchanged":
        names = [
            f"sensor.{'_'.join(pair)}.swapped"
            for pair in (verdict.channels, verdict.channels[::-1])
        ]
    else:
        names = []
    return next((name for name in names if name in known), "")


_NEEDED = ("alpha", "q", "an")
_MIN_INPUT_RANGE = {"de": 0.01, "da": 0.01, "dr": 0.01, "flap": 0.05, "throttle": 0.08}
"""Ranges (rad; throttle 0 to 1) over all maneuvers from which an input counts as moved."""
_SUBSTITUTE_CHANNELS = {"throttle": "thrust"}


def check_maneuvers(maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> None:
    """Raise where nothing could be learned.

    Raise FlightError if there are too few maneuvers, one of them is too short, a channel lacks
    without which nothing can be said, or the flights are of another aircraft.
    """
    if len(maneuvers) == 1:
        raise FlightError(
            f"only one maneuver ({maneuvers[0].id} of '{maneuvers[0].flight}'): an effect could "
            f"not be validated on another; fly at least {SEARCH.min_maneuvers}, doublets on each "
            "surface, at two speeds"
        )
    if len(maneuvers) < SEARCH.min_maneuvers:
        raise FlightError(
            f"{len(maneuvers)} maneuvers are too few to hold any out; fly at least "
            f"{SEARCH.min_maneuvers}, better 16: doublets on each surface, small and large, at two "
            "speeds"
        )
    for one in maneuvers:
        check_sample_count(one)
        lacking = [name for name in _NEEDED if not one.has(name)]
        if lacking:
            raise FlightError(
                f"maneuver {one.id} of '{one.flight}' has no {', '.join(lacking)}; record flow "
                "angles, rates and accelerations, or exclude the maneuver"
            )
        if one.aircraft.name != aircraft.name:
            raise FlightError(
                f"maneuver {one.id} of '{one.flight}' was flown by '{one.aircraft.name}', and the "
                f"aircraft file is of '{aircraft.name}'; give the file that belongs to the flight"
            )


def moving_inputs(maneuvers: Sequence[Maneuver]) -> frozenset[str]:
    """Return the inputs that move enough in these maneuvers for their effects to be seen."""
    found = set()
    for name, least in _MIN_INPUT_RANGE.items():
        channel = name
        if not any(one.has(name) for one in maneuvers):
            channel = _SUBSTITUTE_CHANNELS.get(name, name)
        low, high = np.inf, -np.inf
        for one in maneuvers:
            if one.has(channel):
                samples = one.samples(channel)
                low = min(low, float(np.nanmin(samples)))
                high = max(high, float(np.nanmax(samples)))
        if (channel != name and high > low) or high - low >= least:
            found.add(name)
    return frozenset(found)


def check_forced_effects(
    forced: Sequence[str], aircraft: Aircraft, maneuvers: Sequence[Maneuver]
) -> None:
    """Raise where an effect was asked for that these flights cannot show.

    Raise FlightError: saying what to record or fly. Raise UnknownNameError if the catalog has no
    such effect.
    """
    channels: Collection[str] = {
        name for one in maneuvers for name in one.block.channels if one.has(name)
    }
    reasons = excluded_effects(aircraft, channels, moving=moving_inputs(maneuvers), variants=True)
    for effect in forced:
        wanted = find_effect(effect)
        if effect in reasons:
            raise FlightError(
                f"'{effect}' ({wanted.title}) cannot be evaluated: {reasons[effect]}; "
                f"{wanted.remedy or wanted.separated_by}"
            )
