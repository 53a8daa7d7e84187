"""The effects that a linear build-up leaves out, one family to a module.

Each effect is entered once, with its formula (`gsapp.dynamics.effect_terms`,
`gsapp.dynamics.signal_terms`) and with what tells it from others (`EffectGuidance`): a new one
touches one module. Other packages add theirs by entry points of the group ``gsapp.effects``.
"""
