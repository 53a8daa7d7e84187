"""The catalog put together: every registered effect with its lore, and the disturbances."""

from __future__ import annotations

from functools import cache

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.discrepancy.effect_catalog.aerodynamics import aerodynamic_guidance
from gsapp.discrepancy.effect_catalog.aircraft_systems import (
    control_guidance,
    mass_guidance,
    propulsion_guidance,
)
from gsapp.discrepancy.effect_catalog.effect_record import EffectEntry, EffectGuidance, EffectRecord
from gsapp.discrepancy.effect_catalog.instruments import instrument_guidance
from gsapp.dynamics.terms import Parameter, create_term, effect_ids
from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean

_ENTRIES: dict[str, EffectEntry] = {
    "aero": "coefficient",
    "propulsion": "propulsion",
    "control": "control path",
    "sensor": "instrument",
    "mass": "mass",
}

TURBULENCE = EffectRecord(
    id="atmosphere.turbulence",
    title="Gusts and turbulence",
    equation="u, v, w of the air add to the flow; Dryden spectra of rms gust",
    entry="atmosphere",
    target="",
    parameters=(
        Parameter(
            name="gust",
            unit="m/s",
            default=0.3,
            bounds=(0.0, 10.0),
            description="standard deviation of each component",
        ),
    ),
    mistaken_for=("aero.CN.memory", "aero.Cm.alphadot", "sensor.alpha.lag"),
    separated_by="the same maneuver repeated: what gusts do does not repeat; fly at dawn",
    effect_class="A",
    remedy="",
    needs=(),
    source="MIL-F-8785C, Dryden form; a disturbance of the flight, no lack of the model",
    disturbance=True,
)
"""Always a disturbance, never an effect to name."""


@cache
def all_effects() -> tuple[EffectRecord, ...]:
    """Return all records: registered effects in the order of their ids, then disturbances.

    Parameters are those of the shipped aircraft; `gsapp.discrepancy.effect_catalog.plausible`
    gives the sizes of another one.
    """
    aircraft = load_aircraft("b777")
    lore = _all_guidance()
    records = [_record(effect_id, lore[effect_id], aircraft) for effect_id in effect_ids()]
    return (*records, TURBULENCE)


def find_effect(effect_id: str) -> EffectRecord:
    """Return the record of one effect.

    Raises
    ------
    UnknownNameError
        If the catalog has no such effect; the nearest are named.
    """
    table = _table()
    if effect_id not in table:
        hint = did_you_mean(effect_id, table, "gsapp discrepancy --list lists all")
        raise UnknownNameError(f"the catalog has no effect '{effect_id}'; {hint}")
    return table[effect_id]


@cache
def _table() -> dict[str, EffectRecord]:
    return {one.id: one for one in all_effects()}


def _all_guidance() -> dict[str, EffectGuidance]:
    return {
        **aerodynamic_guidance(),
        **propulsion_guidance(),
        **control_guidance(),
        **instrument_guidance(),
        **mass_guidance(),
    }


def _record(effect_id: str, lore: EffectGuidance, aircraft: Aircraft) -> EffectRecord:
    term = create_term(effect_id, aircraft)
    return EffectRecord(
        id=effect_id,
        title=term.title,
        equation=term.equation,
        entry=_ENTRIES[effect_id.partition(".")[0]],
        target=term.target,
        parameters=term.parameters,
        mistaken_for=lore.mistaken_for,
        separated_by=lore.separated_by,
        effect_class=lore.effect_class,
        remedy=lore.remedy,
        needs=lore.needs,
        source=lore.source,
        derivative=lore.derivative,
        variant_of=lore.variant_of,
        decoy=lore.decoy,
    )
