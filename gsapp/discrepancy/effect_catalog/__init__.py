"""The catalog of effects: one frozen record each, and which of them can compete for a flight.

Formulas, parameters and bounds are those of the registered terms (`gsapp.dynamics.effects`,
`gsapp.dynamics.signal_effects`); what each is mistaken for and what tells it apart stands here.
"""

from gsapp.discrepancy.effect_catalog.effect_record import EffectEntry, EffectRecord
from gsapp.discrepancy.effect_catalog.eligibility import (
    eligible_effects,
    excluded_effects,
    plausible_sizes,
)
from gsapp.discrepancy.effect_catalog.registry import TURBULENCE, all_effects, find_effect

__all__ = [
    "TURBULENCE",
    "EffectEntry",
    "EffectRecord",
    "all_effects",
    "eligible_effects",
    "excluded_effects",
    "find_effect",
    "plausible_sizes",
]
