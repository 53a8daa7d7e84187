"""The blind cases: what is hidden, how it is flown and recorded, and which answers are right.

A `Case` says it all in small frozen records; `blind.flying.fly_case` flies it. Effects go by the
ids of the program's catalog where it has them; ``outside.*`` are in no catalog.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from blind.jsbsim_aircraft import AIR, PROPULSION

Group = Literal["hidden", "nothing", "outside", "pair"]
Baseline = Literal["fitted", "given", "wrong"]
Recorded = Literal["position", "servo", "command"]

CONTROL: Mapping[str, float] = {
    "control.elevator.backlash": 0.01,
    "control.elevator.lag": 0.03,
    "control.elevator.delay": 0.02,
    "control.aileron.backlash": 0.02,
    "control.aileron.lag": 0.03,
    "control.rudder.delay": 0.03,
}
"""Id: a size from which scaling starts; rad, s."""
SENSOR: Mapping[str, float] = {
    "sensor.alpha.scale": 1.05,
    "sensor.q.scale": 1.05,
    "sensor.beta.scale": 1.05,
    "sensor.alpha.bias": 0.01,
    "sensor.beta.delay": 0.03,
    "sensor.alpha.delay": 0.03,
    "sensor.alpha.lag": 0.03,
    "sensor.q.lag": 0.03,
    "sensor.ay.reversed": 1.0,
    "sensor.ax.scale": 1.05,
    "sensor.p.r.swapped": 1.0,
}
MISSING: Mapping[str, float] = {"aero.Cn.da": 0.01, "aero.Cl.dr": 0.01, "aero.CY.p": -0.1}
"""Linear derivatives that the baseline model lacks."""
OUTSIDE_SENSOR: Mapping[str, float] = {"outside.an.flexing": 0.1}
CLASSES: Mapping[str, str] = {"propulsion.thrust.scale": "C"}
"""Of effects that are not seen with the baseline's own derivatives free."""


def effect_class(effect: str) -> str:
    """Return A, B or C (`gsapp.discrepancy.results.EffectClass`)."""
    return CLASSES.get(effect, "B" if effect.startswith("sensor.") else "A")


def neutral(effect: str) -> float:
    """Return the size at which an effect does nothing."""
    return 1.0 if effect.endswith(".scale") and effect.startswith("sensor.") else 0.0


def typical(effect: str) -> float:
    """Return a size from which scaling starts."""
    if effect in AIR:
        return AIR[effect].typical
    for table in (PROPULSION, CONTROL, SENSOR, MISSING, OUTSIDE_SENSOR):
        if effect in table:
            return table[effect]
    raise KeyError(effect)


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One blind case.

    Attributes
    ----------
    id : str
    group : {"hidden", "nothing", "outside", "pair"}
    effects : mapping of str to float
        Hidden effects and their sizes, SI.
    verdicts : tuple of str
        Verdicts that are right.
    accepted : tuple of str
        Names that are right where an effect has to be named; for two effects both are needed.
    ambiguity : bool
        Whether "cannot be told apart" is right if it lists the truth.
    gust : float
        rms of vertical gusts, m/s.
    noise : float
        Times the source's.
    colored : bool
    rate : int
        100 or 50 Hz.
    attitude : bool
        Whether phi and theta are recorded.
    baseline : {"fitted", "given", "wrong"}
        Fitted on the same data by the program, given with true values, or given with values
        10 to 20 % wrong.
    plan : int
        Seed of hands and of the true derivatives.
    seed : int
        Of noise and gusts.
    clock : str
        ``air`` or ``surfaces``: the box whose clock is off.
    sigma : float
        Standard deviations that the effect is to show; 0 where sizes are as given.
    """

    id: str
    group: Group
    effects: Mapping[str, float] = field(default_factory=dict)
    verdicts: tuple[str, ...] = ()
    accepted: tuple[str, ...] = ()
    ambiguity: bool = False
    gust: float = 0.0
    noise: float = 1.0
    colored: bool = False
    rate: int = 100
    attitude: bool = True
    baseline: Baseline = "fitted"
    plan: int = 0
    seed: int = 0
    clock: str = ""
    sigma: float = 0.0

    @property
    def recorded(self) -> Mapping[str, Recorded]:
        """Return where controls are recorded, of those that are not recorded on the surface."""
        channels = {"elevator": "de", "aileron": "da", "rudder": "dr"}
        return {
            channels[name.split(".")[1]]: "servo" if name.endswith("backlash") else "command"
            for name in self.effects
            if name.startswith("control.")
        }


def hidden(effect: str, size: float | None = None, **how: object) -> Case:
    """Return a case with one effect hidden, by default of a typical size."""
    value = typical(effect) if size is None else size
    content: dict[str, object] = {
        "id": f"{effect}-{value:g}",
        "group": "hidden",
        "effects": {effect: value},
        "verdicts": ("effects-found",),
        "accepted": (effect,),
        **how,
    }
    return Case(**content)  # type: ignore[arg-type]
