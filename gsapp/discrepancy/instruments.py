"""What kinematics alone say of the instruments, before a model is blamed."""

from __future__ import annotations

from collections.abc import Sequence

from gsapp.discrepancy.results import InstrumentRemark
from gsapp.foundation import FlightError
from gsapp.identification.compatibility import check
from gsapp.identification.maneuver import Maneuver

_ENOUGH = 6
"""Maneuvers that the check takes: errors of instruments are common to all."""


def instrument_remarks(maneuvers: Sequence[Maneuver]) -> tuple[InstrumentRemark, ...]:
    """Return what the data compatibility check says, of maneuvers from all over the flights."""
    flown = sorted(maneuvers, key=lambda one: (one.flight, one.block.times[0]))
    every = -(-len(flown) // _ENOUGH)
    try:
        found = check(flown[::every])
    except FlightError as error:
        return (InstrumentRemark(channel="", words=str(error), consistent=False),)
    if not found.verdicts:
        return (InstrumentRemark(channel="", words=found.summary, consistent=True),)
    return tuple(
        InstrumentRemark(channel=", ".join(one.channels), words=one.sentence, consistent=False)
        for one in found.verdicts
    )
