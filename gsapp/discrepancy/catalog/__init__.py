"""The catalog of effects: one frozen record each, and which of them can compete for a flight.

Formulas, parameters and bounds are those of the registered terms (`gsapp.dynamics.effects`,
`gsapp.dynamics.signal_effects`); what each is mistaken for and what tells it apart stands here.
"""

from gsapp.discrepancy.catalog.competing import competitors, left_out, plausible
from gsapp.discrepancy.catalog.listing import TURBULENCE, catalog, record
from gsapp.discrepancy.catalog.records import EffectRecord, Entry

__all__ = [
    "TURBULENCE",
    "EffectRecord",
    "Entry",
    "catalog",
    "competitors",
    "left_out",
    "plausible",
    "record",
]
