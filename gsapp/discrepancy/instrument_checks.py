"""What kinematics alone say of the instruments, before a model is blamed."""

from __future__ import annotations

from collections.abc import Sequence

from gsapp.discrepancy.effect_catalog import all_effects
from gsapp.discrepancy.results import InstrumentRemark
from gsapp.foundation import FlightError
from gsapp.identification.compatibility import (
    CompatibilitySettings,
    InstrumentVerdict,
    check_compatibility,
)
from gsapp.identification.maneuver import Maneuver

_MAX_MANEUVERS = 6
"""Maneuvers that the check takes: errors of instruments are common to all."""
_MAX_ITERATIONS = 8


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
    settings = CompatibilitySettings(try_signs=try_signs, iterations=_MAX_ITERATIONS)
    flown = sorted(maneuvers, key=lambda one: (one.flight, one.block.times[0]))
    every = -(-len(flown) // _MAX_MANEUVERS)
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
