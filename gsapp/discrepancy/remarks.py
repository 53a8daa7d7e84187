"""What the record keeps from a search: clipped samples, channels that lack or never moved."""

from __future__ import annotations

from collections.abc import Sequence

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.catalog import left_out
from gsapp.discrepancy.checking import moving_inputs
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import channel

_NAMED = 3
"""Effects named in a sentence; the others are counted."""
_NEEDS = "needs "
"""How the catalog begins a reason that lies in the record, not in the effect."""


def record_remarks(maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> tuple[str, ...]:
    """Return a sentence for each channel that is clipped or lacks, with what follows from it.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
    aircraft : Aircraft
    """
    return (*_clipped(maneuvers), *_lacking(maneuvers, aircraft))


def _clipped(maneuvers: Sequence[Maneuver]) -> list[str]:
    places: dict[str, list[str]] = {}
    for one in maneuvers:
        for name, flags in one.clipped.items():
            share = float(flags.mean())
            if share > 0.0:
                places.setdefault(name, []).append(f"{one.id} ({max(share, 0.01):.0%})")
    return [
        f"{channel(name).symbol} is clipped in maneuver{'s' if len(where) > 1 else ''} "
        f"{', '.join(where)}: those samples do not count; smaller inputs, or an instrument of "
        "wider range, would keep them"
        for name, where in places.items()
    ]


def _lacking(maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> list[str]:
    channels = {name for one in maneuvers for name in one.block.channels if one.has(name)}
    effects: dict[str, list[str]] = {}
    for effect, reason in left_out(aircraft, channels, moving=moving_inputs(maneuvers)).items():
        if reason.startswith(_NEEDS):
            effects.setdefault(reason, []).append(effect)
    return [
        f"{', '.join(names[:_NAMED])}"
        + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
        + f" cannot be judged: {'each ' if len(names) > 1 else 'it '}{reason}"
        for reason, names in effects.items()
    ]
