"""The blind cases: what is hidden, how it is flown and recorded, and which answers are right.

A `Case` says it all in small frozen records; `blind.flying.fly_case` flies it. Effects go by the
ids of the program's catalog where it has them; ``outside.*`` are in no catalog. `all_cases` lists
the benchmark: 30 kinds x 3 sizes x 5 seeds with one effect, 600 flights with nothing hidden, 120
with an effect outside the catalog, 60 with two effects, 50 with a large one and one or two small
ones. Air, noise, recorder and baseline model
go round with kind, size and seed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Literal

from tests.discrepancy.blind.jsbsim_aircraft import AIR, PROPULSION, STALL

Group = Literal["hidden", "nothing", "outside", "pair"]
Baseline = Literal["fitted", "given", "wrong"]
Recorded = Literal["position", "servo", "command"]
Series = Literal["report", "tune"]

SEEDS = 5
FIRST_PLAN: Mapping[Series, int] = {"report": 1, "tune": 50}
"""Plans (and all seeds) of cases that are reported, and of cases to try things on."""
SIZES = (5.0, 10.0, 30.0)

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
    "sensor.beta.lag": 0.03,
    "sensor.q.lag": 0.03,
    "sensor.q.delay": 0.03,
    "sensor.ay.reversed": 1.0,
    "sensor.ax.scale": 1.05,
    "sensor.p_r.swapped": 1.0,
}
MISSING: Mapping[str, float] = {"aero.Cn.da": 0.01, "aero.Cl.dr": 0.01, "aero.CY.p": -0.1}
"""Linear derivatives that the baseline model lacks."""
OUTSIDE_SENSOR: Mapping[str, float] = {"outside.an.flexing": 0.1}

KINDS: tuple[str, ...] = (
    "aero.Cm.alpha2", "aero.CN.alpha2", "aero.CA.alpha2", "aero.Cm.alphadot", "aero.Cm.beta2",
    "aero.CX.speed", "aero.CZ.speed", "aero.Cm.speed", "aero.Cl.alpha_beta",
    "aero.Cn.alpha_beta", "aero.Cn.beta3", "aero.Cl.beta3", "aero.Cm.de3", "aero.Cl.da3",
    "aero.Cm.alpha_de", "aero.Cm.alpha_q", "aero.Cm.flap", "aero.CN.flap", "aero.CA.flap",
    "aero.Cl.alpha", "aero.Cl.dr", "aero.CY.p", "propulsion.Cm.throttle",
    "propulsion.Cn.asymmetry", "propulsion.thrust.scale", "control.elevator.backlash",
    "control.elevator.lag", "control.elevator.delay", "sensor.alpha.scale", "sensor.q.scale",
    "sensor.beta.delay", "sensor.alpha.bias", "sensor.alpha.lag", "sensor.ay.reversed",
    "sensor.p_r.swapped",
)  # fmt: skip
"""Kinds that are hidden one at a time."""
OUTSIDE: tuple[str, ...] = (
    "outside.Cm.alpha3", "outside.Cm.alpha_de2", "outside.Cm.de_deadzone",
    "outside.Cl.da_abs_beta", "outside.Cn.memory", "outside.an.flexing", "outside.Cm.p2",
    "outside.CN.p2", "outside.Cm.r2", "outside.Cn.da_de", "outside.Cl.beta_de",
    "outside.Cm.abs_q_q",
)  # fmt: skip
PAIRS: tuple[tuple[str, str], ...] = (
    ("aero.Cm.alpha2", "propulsion.Cn.asymmetry"),
    ("aero.CN.alpha2", "aero.Cl.alpha_beta"),
    ("aero.Cm.alphadot", "aero.Cn.beta3"),
    ("aero.Cm.flap", "aero.Cl.da3"),
    ("aero.CZ.speed", "aero.Cn.alpha_beta"),
    ("propulsion.Cm.throttle", "aero.Cl.alpha"),
    ("propulsion.Cm.throttle", "aero.CN.flap"),
    ("sensor.alpha.scale", "aero.Cl.beta3"),
    ("sensor.beta.delay", "aero.Cm.alpha_q"),
    ("control.elevator.lag", "aero.Cn.alpha_beta"),
    ("aero.CA.alpha2", "aero.Cm.beta2"),
    ("aero.Cm.de3", "propulsion.thrust.scale"),
)
LARGE_AND_SMALL: tuple[tuple[str, ...], ...] = (
    ("aero.Cm.alpha2", "aero.Cn.beta3"),
    ("sensor.beta.delay", "aero.CA.alpha2"),
    ("propulsion.Cm.throttle", "aero.Cl.alpha_beta"),
    ("aero.CN.alpha2", "control.elevator.lag"),
    ("aero.Cl.beta3", "sensor.alpha.scale"),
    ("aero.CX.speed", "aero.Cm.beta2"),
    ("aero.CN.alpha2", "propulsion.Cn.asymmetry", "aero.Cm.alphadot"),
    ("propulsion.Cm.throttle", "sensor.beta.delay", "aero.Cl.alpha_beta"),
    ("aero.Cm.alpha2", "aero.Cl.beta3", "propulsion.thrust.scale"),
    ("aero.CZ.speed", "aero.Cn.beta3", "aero.Cm.de3"),
)
"""Two and three effects at once; the first is large, the others are a third of it."""
WHOLE = ("reversed", "swapped")
"""Kinds that have no size."""
SIBLINGS: Mapping[str, tuple[str, ...]] = {
    "aero.Cm.de3": ("aero.Cm.de_falloff",),
    "aero.Cl.da3": ("aero.Cl.da_falloff",),
}
"""Finer shapes of the same physics, as right as the plain one."""
CLOCKS: Mapping[str, tuple[str, ...]] = {
    "air": ("sensor.airdata.delay", "sensor.alpha.delay", "sensor.beta.delay"),
    "surfaces": ("sensor.surfaces.delay", "sensor.de.delay", "sensor.da.delay", "sensor.dr.delay"),
}
"""Names that are right when the clock of a box is off."""


def neutral(effect: str) -> float:
    return 1.0 if effect.endswith(".scale") and effect.startswith("sensor.") else 0.0


def typical(effect: str) -> float:
    for known in (AIR, STALL):
        if effect in known:
            return known[effect].typical
    for table in (PROPULSION, CONTROL, SENSOR, MISSING, OUTSIDE_SENSOR):
        if effect in table:
            return table[effect]
    raise KeyError(effect)


def known_effects() -> tuple[str, ...]:
    tables = (AIR, PROPULSION, CONTROL, SENSOR, MISSING, OUTSIDE_SENSOR)
    return tuple(dict.fromkeys(name for table in tables for name in table))


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """How a case is flown and recorded."""

    gust: float = 0.0  # rms of vertical gusts, m/s.
    noise: float = 1.0  # Times the source's.
    colored: bool = False
    rate: int = 100  # 100 or 50 Hz.
    attitude: bool = True  # Whether phi and theta are recorded.


ROUND: tuple[tuple[Recording, Baseline], ...] = (
    (Recording(), "fitted"),
    (Recording(gust=0.3), "fitted"),
    (Recording(noise=0.5, colored=True), "given"),
    (Recording(gust=0.1, noise=2.0, rate=50, attitude=False), "fitted"),
    (Recording(gust=1.0, colored=True), "given"),
    (Recording(noise=2.0, rate=50), "wrong"),
)
"""What goes round with kind, size and seed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case(Recording):
    """One blind case."""

    id: str
    group: Group
    kind: str = ""  # By which results are gathered.
    effects: Mapping[str, float] = field(default_factory=dict)
    """Hidden effects and their sizes, SI."""
    verdicts: tuple[str, ...] = ()  # Verdicts that are right.
    accepted: tuple[tuple[str, ...], ...] = ()
    """One entry for each name that has to be found: the ids that are right for it."""
    baseline: Baseline = "fitted"
    """Fitted on the same data by the program, given with true values, or given with values 10 to 20
    % wrong."""
    plan: int = 0  # Seed of hands and of the true derivatives.
    seed: int = 0  # Of noise and gusts.
    clock: str = ""  # ``air`` or ``surfaces``: the box whose clock is late.
    sigma: float = 0.0
    """Standard deviations that each effect is to show; 0 where sizes are as given."""
    later_sigma: float = 0.0  # Of the effects after the first; 0: as of the first.
    airframe: str = ""  # An aircraft of JSBSim whose aerodynamics are flown; empty: the B777's.
    by: Literal["jsbsim", "virtual"] = "jsbsim"
    """Who flies the truth. The virtual aircraft flies in still air only."""

    @property
    def recorded(self) -> Mapping[str, Recorded]:
        channels = {"elevator": "de", "aileron": "da", "rudder": "dr"}
        return {
            channels[name.split(".")[1]]: "servo" if name.endswith("backlash") else "command"
            for name in self.effects
            if name.startswith("control.")
        }

    @property
    def recording(self) -> Recording:
        return Recording(**{name: getattr(self, name) for name in Recording.__slots__})

    def recorded_as(self, recording: Recording, baseline: Baseline) -> Case:
        return replace(self, **asdict(recording), baseline=baseline)

    @property
    def air(self) -> str:
        return f"gusts {self.gust:g} m/s" if self.gust else "calm"


def hidden(effect: str, size: float | None = None, **how: object) -> Case:
    value = typical(effect) if size is None else size
    content: dict[str, object] = {
        "id": f"{effect}-{value:g}",
        "group": "hidden",
        "kind": effect,
        "effects": {effect: value},
        "verdicts": ("effects-found",),
        "accepted": ((effect, *SIBLINGS.get(effect, ())),),
        **how,
    }
    return Case(**content)  # type: ignore[arg-type]


def _seed(group: int, plan: int, number: int, order: int = 0) -> int:
    return 10_000 * (100 * group + plan) + 10 * number + order


def _hidden_cases(plans: range) -> Iterator[Case]:
    for index, kind in enumerate(KINDS):
        for order, sigma in enumerate(SIZES):
            if kind.endswith(WHOLE) and order:
                continue
            for plan in plans:
                recording, baseline = ROUND[(index + 2 * order + plan) % len(ROUND)]
                if kind in MISSING:
                    baseline = "given"
                size = f"{sigma:g}" if not kind.endswith(WHOLE) else "whole"
                case = hidden(
                    kind, id=f"{kind}-{size}-{plan}", plan=plan, sigma=sigma,
                    seed=_seed(1, plan, index, order),
                )  # fmt: skip
                if kind in MISSING:
                    case = replace(case, verdicts=("effects-found", "values-wrong"))
                yield case.recorded_as(recording, baseline)


def _nothing_cases(plans: range) -> Iterator[Case]:
    rounds = [one for one, _ in ROUND if not one.gust]
    count = 150 // len(plans)
    for plan in plans:
        for k in range(count):
            seed = 1000 + 100 * plan + k
            calm = rounds[k % len(rounds)]
            base: Baseline = "given" if k % 2 else "fitted"
            clean = Case(
                id=f"clean-{plan}-{k}", group="nothing", kind="clean", plan=plan, seed=seed,
                verdicts=("model-adequate",),
            )  # fmt: skip
            yield clean.recorded_as(calm, base)
            yield replace(
                clean, id=f"wrong-{plan}-{k}", kind="values wrong", verdicts=("values-wrong",)
            ).recorded_as(calm, "wrong")
            if k % 2:
                box = "air" if k % 4 == 1 else "surfaces"
                yield replace(
                    clean, id=f"clock-{plan}-{k}", kind=f"clock of {box}", clock=box,
                    verdicts=("effects-found", "ambiguous"), accepted=(CLOCKS[box],),
                ).recorded_as(calm, "fitted")  # fmt: skip
            for gust in (0.1, 0.3, 1.0):
                # 45 of each plan in all
                if (k + round(10 * gust)) % 2:
                    blown = replace(calm, gust=gust)
                    yield replace(
                        clean, id=f"gust-{gust:g}-{plan}-{k}", kind=f"gusts {gust:g} m/s"
                    ).recorded_as(blown, base)


def _outside_cases(plans: range) -> Iterator[Case]:
    for index, kind in enumerate(OUTSIDE):
        for order, sigma in enumerate(SIZES[1:]):
            for plan in plans:
                recording, baseline = ROUND[(index + 2 * order + plan) % 5]
                yield Case(
                    id=f"{kind}-{sigma:g}-{plan}", group="outside", kind=kind,
                    effects={kind: typical(kind)}, verdicts=("unexplained",),
                    plan=plan, seed=_seed(2, plan, index, order), sigma=sigma,
                ).recorded_as(recording, baseline)  # fmt: skip


def _pair_cases(plans: range) -> Iterator[Case]:
    for index, pair in enumerate(PAIRS):
        for plan in plans:
            recording, baseline = ROUND[(index + plan) % 5]
            yield Case(
                id=f"{'+'.join(pair)}-{plan}", group="pair", kind="+".join(pair),
                effects={one: typical(one) for one in pair}, verdicts=("effects-found",),
                accepted=tuple((one, *SIBLINGS.get(one, ())) for one in pair),
                plan=plan, seed=_seed(3, plan, index), sigma=20.0,
            ).recorded_as(recording, baseline)  # fmt: skip


def _large_and_small_cases(plans: range) -> Iterator[Case]:
    for index, effects in enumerate(LARGE_AND_SMALL):
        for plan in plans:
            recording, baseline = ROUND[(index + plan) % 5]
            yield Case(
                id=f"large-{'+'.join(effects)}-{plan}", group="pair",
                kind=f"{effects[0]}, small {'+'.join(effects[1:])}",
                effects={one: typical(one) for one in effects}, verdicts=("effects-found",),
                accepted=tuple((one, *SIBLINGS.get(one, ())) for one in effects),
                plan=plan, seed=_seed(4, plan, index), sigma=30.0, later_sigma=10.0,
            ).recorded_as(recording, baseline)  # fmt: skip


def all_cases(series: Series = "report") -> tuple[Case, ...]:
    first = FIRST_PLAN[series]
    plans = range(first, first + SEEDS)
    makers = (
        _hidden_cases, _nothing_cases, _outside_cases, _pair_cases, _large_and_small_cases,
    )  # fmt: skip
    return tuple(case for make in makers for case in make(plans))


def virtual_cases(series: Series = "report") -> tuple[Case, ...]:
    """Return cases flown by the program's own equations: every kind at 10 sigma, and clean ones."""
    first = FIRST_PLAN[series]
    found = []
    for index, kind in enumerate(KINDS):
        plan = first + index % SEEDS
        found.append(
            hidden(
                kind, id=f"virtual-{kind}-{plan}", plan=plan, seed=plan, sigma=10.0, by="virtual"
            )
        )
        if kind in MISSING:
            found[-1] = replace(
                found[-1], baseline="given", verdicts=("effects-found", "values-wrong")
            )
    for k in range(4 * SEEDS):
        clean = Case(
            id=f"virtual-clean-{k}", group="nothing", kind="clean", plan=first + k % SEEDS,
            seed=2000 + k, verdicts=("model-adequate",), by="virtual",
        )  # fmt: skip
        found.append(clean)
    return tuple(found)


AIRFRAMES: Mapping[str, tuple[str, ...]] = {
    "T37": (
        "aero.CN.flap", "aero.CA.flap", "aero.CA.de2", "aero.CA.alpha2", "aero.CA.beta2",
        "aero.CN.alpha2", "aero.Cm.alphadot", "aero.CN.alphadot", "aero.Cm.memory",
        "aero.CN.memory", "aero.Cm.flap", "aero.CY.alpha_beta",
    ),
    "c172p": (
        "aero.CN.flap", "aero.CA.flap", "aero.Cm.flap", "aero.CA.de2", "aero.CA.alpha2",
        "aero.CA.beta2", "aero.CN.alpha2", "aero.Cm.alphadot", "aero.CN.alphadot",
        "aero.Cm.memory", "aero.CN.memory", "aero.Cm.beta2", "aero.CY.alpha_beta",
    ),
    "Concorde": (
        "aero.CA.alpha2", "aero.CA.beta2", "aero.CA.de2", "aero.CN.alpha2", "aero.Cm.alphadot",
        "aero.Cm.memory", "aero.CY.alpha_beta", "aero.Cn.alpha_beta",
    ),
}  # fmt: skip
"""JSBSim's own aircraft: effects of the catalog that its model has, beside kinks that have no name.

Read off their files: drag by |beta| and |elevator|, lift, drag and moment by the flap, damping by
alpha'; their lift and drag are of wind axes, and bend axial and normal force over alpha, and side
force over alpha beta: with it yawing moment, where the Concorde's forces act. The single's
elevator works with the square of u, not of V, which its trim shows over beta^2. A jet trainer, a
light single, and a delta without a tail whose elevons trim and steer."""
_AIRFRAME_SIZES: tuple[tuple[str, float], ...] = (
    ("aero.Cm.alpha2", -2.5),
    ("aero.Cn.beta3", 2.5),
    ("aero.Cl.alpha_beta", -1.5),
    ("propulsion.Cm.throttle", 0.05),
    ("control.elevator.backlash", 0.0175),
    ("control.aileron.backlash", 0.0175),
)


def airframe_cases(series: Series = "report") -> tuple[Case, ...]:
    """Return cases flown with other aircraft's aerodynamics, in still air: hidden and clean ones.

    Sizes are as given: another aircraft shows other sigmas.
    """
    first = FIRST_PLAN[series]
    found = []
    for airframe, own in AIRFRAMES.items():
        for plan in range(first, first + 2):
            found.append(
                Case(
                    id=f"{airframe}-clean-{plan}", group="nothing", kind=f"{airframe} clean",
                    plan=plan, seed=3000 + plan, verdicts=("effects-found", "unexplained"),
                    accepted=(own,), airframe=airframe,
                )
            )  # fmt: skip
            for effect, size in _AIRFRAME_SIZES:
                case = hidden(
                    effect, size, id=f"{airframe}-{effect}-{plan}", plan=plan, seed=3100 + plan,
                    airframe=airframe,
                )  # fmt: skip
                found.append(case)
    return tuple(found)


def tenth(cases: tuple[Case, ...]) -> tuple[Case, ...]:
    by_kind: dict[tuple[str, str], list[Case]] = {}
    for case in cases:
        by_kind.setdefault((case.group, case.kind), []).append(case)
    taken = []
    for index, group in enumerate(by_kind.values()):
        every = 10
        taken += group[index % min(every, len(group)) :: every]
    return tuple(taken)
