"""What is known of one effect beyond its formula: what it is taken for, and what tells it apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gsapp.discrepancy.results import EffectClass
from gsapp.dynamics.terms import Parameter

EffectEntry = Literal[
    "coefficient", "propulsion", "control path", "instrument", "mass", "atmosphere"
]
"""Where in the chain from stick to record an effect enters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectGuidance:
    """What field experience and theory say of an effect; the rest of a record is in its term.

    Attributes
    ----------
    mistaken_for : tuple of str
        Effects that look alike in ordinary maneuvers, most alike first.
    separated_by : str
        The maneuver or record that tells them apart.
    effect_class : {"A", "B", "C"}
        See `gsapp.discrepancy.results.EffectClass`.
    remedy : str
        Class C: the measurement on the ground that settles it. Else empty.
    needs : tuple of str
        Channels that must be recorded (and, of inputs, must move) before it can be seen.
    source : str
    derivative : str
        Of the linear build-up, if the effect is one of its derivatives: a baseline that has it
        free leaves nothing to find.
    variant_of : str
        A plainer effect that this looks like in all but special maneuvers: the same physics in a
        finer shape, or other physics of the same shape.
    decoy : bool
        Whether it stands for structure without a name: where it wins, nothing was explained.
    """

    mistaken_for: tuple[str, ...]
    separated_by: str
    effect_class: EffectClass
    remedy: str = ""
    needs: tuple[str, ...] = ()
    source: str
    derivative: str = ""
    variant_of: str = ""
    decoy: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectRecord:
    """One effect of the catalog.

    Attributes
    ----------
    id : str
        ``group.target.kind``.
    title : str
        In a field engineer's words.
    equation : str
    entry : str
        Where it enters.
    target : str
        What its term adds to (`gsapp.dynamics.terms`); empty for the atmosphere.
    parameters : tuple of Parameter
        Name, unit, bounds, plausible size (`Parameter.default`), of the shipped aircraft;
        `plausible` gives the sizes of another one.
    mistaken_for, separated_by, effect_class, remedy, needs, source, derivative, variant_of, decoy
        As in `EffectGuidance`.
    disturbance : bool
        Whether it is no effect of the aircraft at all and is never named.
    """

    id: str
    title: str
    equation: str
    entry: EffectEntry
    target: str
    parameters: tuple[Parameter, ...]
    mistaken_for: tuple[str, ...]
    separated_by: str
    effect_class: EffectClass
    remedy: str
    needs: tuple[str, ...]
    source: str
    derivative: str = ""
    variant_of: str = ""
    decoy: bool = False
    disturbance: bool = False

    @property
    def group(self) -> str:
        """Return the first part of the id: aero, propulsion, control, sensor, mass, atmosphere."""
        return self.id.partition(".")[0]
