"""What the record keeps from a search: clipped samples, channels that lack, a CG that moved."""

from __future__ import annotations

from collections.abc import Sequence

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.effect_catalog import excluded_effects
from gsapp.discrepancy.search_checks import moving_inputs
from gsapp.discrepancy.settings import SEARCH
from gsapp.foundation.name_suggestions import format_names
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import channel

_NAMED = 3
"""Effects named in a sentence; the others are counted."""
_NEEDS = "needs "
"""How the catalog begins a reason that lies in the record, not in the effect."""


def record_remarks(maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> tuple[str, ...]:
    """Return a sentence for each channel that is clipped or lacks, and for a CG that moved."""
    return (
        *_clipping_remarks(maneuvers),
        *_missing_channel_remarks(maneuvers, aircraft),
        *_cg_remarks(maneuvers),
    )


def _cg_remarks(maneuvers: Sequence[Maneuver]) -> list[str]:
    """Return what another CG than the aircraft file's means for moments."""
    ahead = [1e3 * one.cg_shift[0] for one in maneuvers]
    if not ahead or max(map(abs, ahead)) < SEARCH.cg_tolerance:
        return []
    mean = sum(ahead) / len(ahead)
    found = [
        f"the CG was {abs(mean):.0f} mm {'ahead' if mean > 0.0 else 'aft'} of the aircraft file's: "
        "moments are about the CG as flown, those of a model about the file's"
    ]
    apart = max(ahead) - min(ahead)
    if apart >= SEARCH.cg_tolerance:
        found.append(
            f"the maneuvers were flown with CGs up to {apart:.0f} mm apart: this alone may "
            "explain differences in moments; search flights of one loading separately"
        )
    return found


def _clipping_remarks(maneuvers: Sequence[Maneuver]) -> list[str]:
    places: dict[str, list[str]] = {}
    for one in maneuvers:
        for name, flags in one.clipped.items():
            share = float(flags.mean())
            if share > 0.0:
                places.setdefault(name, []).append(f"{one.id} ({max(share, 0.01):.0%})")
    return [
        f"{channel(name).symbol} is clipped in maneuver{'s' if len(where) > 1 else ''} "
        f"{', '.join(where)}: those samples are ignored; use smaller inputs or a wider-range "
        "instrument"
        for name, where in places.items()
    ]


def _missing_channel_remarks(maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> list[str]:
    channels = {name for one in maneuvers for name in one.block.channels if one.has(name)}
    effects: dict[str, list[str]] = {}
    for effect, reason in excluded_effects(
        aircraft, channels, moving=moving_inputs(maneuvers)
    ).items():
        if reason.startswith(_NEEDS):
            effects.setdefault(reason, []).append(effect)
    return [
        f"{format_names(names, _NAMED)} cannot be evaluated: "
        f"{'each ' if len(names) > 1 else 'it '}{reason}"
        for reason, names in effects.items()
    ]
