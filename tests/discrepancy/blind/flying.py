"""Blind cases flown: maneuvers, aircraft file and baseline model for the program, truth for us.

    from tests.discrepancy.blind.cases import Case, hidden
    from tests.discrepancy.blind.flying import fly_case

    flown = fly_case(hidden("aero.Cm.alpha2", -2.0, plan=0, seed=1))
    flown.maneuvers      # sixteen gsapp Maneuvers of flights A and B: what the program gets,
    flown.aircraft       # with the aircraft file
    flown.model          # and the baseline Model, or None where the program fits it
    flown.case           # what is right
    flown.truth          # true derivatives; flown.effects: true sizes
    flown.shown["3"]     # by maneuver: channels without noise, at the recorder's times
    flown.steady["3"]    # what a perfect model computes: still air, deflections as measured

A clean case: ``Case(id="clean", group="nothing", verdicts=("model-adequate",))``; gusts by
``gust=0.3`` and so on. Gusts are of the Dryden form at low altitude (MIL-HDBK-1797), by digital
filters: not the program's own turbulence.
"""

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import bilinear, lfilter

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.model import Model, load_model
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, FloatArray
from tests.discrepancy.blind.cases import MISSING, OUTSIDE_SENSOR, SENSOR, Case, neutral
from tests.discrepancy.blind.engine import (
    CONTROLS,
    RATE,
    SETTLING,
    STEPS_PER_SECOND,
    Engine,
    Stall,
    Trim,
)
from tests.discrepancy.blind.instruments import (
    AIR_BOX,
    SURFACES_BOX,
    Faults,
    exposed,
    recorded,
    with_faults,
    with_zeros,
)
from tests.discrepancy.blind.jsbsim_aircraft import AIR, ALTITUDE, FOOT, PROPULSION, STALL
from tests.discrepancy.blind.plan import (
    PLAN,
    SERVO_LAG,
    SERVO_ORDER,
    Planned,
    hands,
    lagged,
    sampled,
)
from tests.discrepancy.blind.virtual import flight_model, fly_equations

_GROUND = 200.0
"""Height of the field, m: maneuvers are flown 100 m above it."""


def lengths(rms: float) -> tuple[float, float, float]:
    height = (ALTITUDE - _GROUND) / FOOT
    shape = 0.177 + 0.000823 * height
    return height / shape**1.2 * FOOT, height * FOOT, rms / shape**0.4


def dryden(rms: float, V: float, count: int, seed: tuple[int, ...]) -> FloatArray:
    """Return motion of the air along, across and down, m/s, shape (count, 3).

    Parameters
    ----------
    rms : float
        Of the vertical gust, m/s; horizontal gusts are larger, as near the ground.
    V : float
        Airspeed at which the gusts are crossed, m/s.
    count : int
        Steps of JSBSim.
    seed : tuple of int
    """
    random = np.random.default_rng(seed)
    long, tall, wide = lengths(rms)
    past = 60 * STEPS_PER_SECOND
    noise = random.standard_normal((3, count + past)) * math.sqrt(STEPS_PER_SECOND)

    def first(x: FloatArray) -> FloatArray:
        tau = long / V
        gain = wide * math.sqrt(2.0 * tau)
        return np.asarray(lfilter(*bilinear([gain], [tau, 1.0], STEPS_PER_SECOND), x))

    def second(x: FloatArray, size: float, length: float) -> FloatArray:
        tau = length / V
        gain = size * math.sqrt(tau)
        above = [gain * math.sqrt(3.0) * tau, gain]
        return np.asarray(
            lfilter(*bilinear(above, [tau * tau, 2.0 * tau, 1.0], STEPS_PER_SECOND), x)
        )

    rows = (first(noise[0]), second(noise[1], wide, long), second(noise[2], rms, tall))
    return np.stack([row[past:] for row in rows], axis=-1)


CLOCK_OFFSET = 0.005
"""Of a box whose clock is off, s."""
_SURFACE_OF = {"elevator": "de", "aileron": "da", "rudder": "dr"}


@functools.lru_cache(maxsize=1)
def shipped_aircraft() -> Aircraft:
    return load_aircraft("b777")


@functools.lru_cache(maxsize=32)
def engine_for(effects: tuple[str, ...], airframe: str = "") -> Engine:
    return Engine(shipped_aircraft(), effects, airframe)


def true_derivatives(plan: int) -> dict[str, float]:
    random = np.random.default_rng([plan, 2])
    return {
        name: value * (1.0 + 0.1 * float(random.uniform(-1.0, 1.0)))
        for name, value in load_model("b777").derivatives.items()
    }


def wrong_values(truth: Mapping[str, float], seed: int) -> dict[str, float]:
    random = np.random.default_rng([seed, 3])
    return {
        name: value * (1.0 + float(random.choice((-1.0, 1.0)) * random.uniform(0.1, 0.2)))
        for name, value in truth.items()
    }


def aircraft_of(case: Case) -> Aircraft:
    aircraft = shipped_aircraft()
    if not case.recorded:
        return aircraft
    ideal = {"lag": 0.0, "delay": 0.0, "slop": 0.0, "rate_limit": 1e9}
    changed = {
        channel: getattr(aircraft.controls, channel).model_copy(update={"kind": kind, **ideal})
        for channel, kind in case.recorded.items()
    }
    controls = aircraft.controls.model_copy(update=changed)
    return aircraft.model_copy(update={"controls": controls})


def faults_of(case: Case) -> Faults:
    """Return the errors of instruments that a case hides."""
    tables: dict[str, dict[str, float]] = {
        one: {} for one in ("scale", "bias", "delay", "lag", "flexing")
    }
    turned: list[str] = []
    swapped: list[tuple[str, str]] = []
    for effect, size in case.effects.items():
        words = effect.split(".")
        if effect not in SENSOR and effect not in OUTSIDE_SENSOR:
            continue
        if words[-1] == "reversed":
            turned.append(words[1])
        elif words[-1] == "swapped":
            one, other = words[1].split("_")
            swapped.append((one, other))
        else:
            tables[words[-1]][words[1]] = size
    if case.clock == "air":
        tables["delay"].update(dict.fromkeys(AIR_BOX, CLOCK_OFFSET))
    if case.clock == "surfaces":
        tables["delay"].update(dict.fromkeys(SURFACES_BOX, CLOCK_OFFSET))
    return Faults(**tables, reversed=tuple(turned), swapped=tuple(swapped))


def _play(history: FloatArray, width: float) -> FloatArray:
    out = np.empty_like(history)
    place, half = float(history[0]), 0.5 * width
    for index, wanted in enumerate(history.tolist()):
        if wanted > place + half:
            place = wanted - half
        elif wanted < place - half:
            place = wanted + half
        out[index] = place
    return out


def _late(history: FloatArray, delay: float) -> FloatArray:
    steps = np.arange(history.size, dtype=np.float64)
    return np.interp(steps - delay * STEPS_PER_SECOND, steps, history)


def controls_of(
    case: Case, planned: Planned, trim: Trim
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return what the controls did at every step, and what was recorded of them at 100 Hz."""
    asked = hands(planned, case.plan).levers(trim)
    controls = np.empty_like(asked)
    shown = {}
    for column, name in enumerate(CONTROLS):
        if name == "throttle":
            controls[:, column] = lagged(asked[:, column], shipped_aircraft().propulsion.lag)
            shown[name] = sampled(asked[:, column])
            continue
        servo = asked[:, column]
        for _ in range(SERVO_ORDER):
            servo = lagged(servo, SERVO_LAG)
        surface = servo
        for effect, size in case.effects.items():
            words = effect.split(".")
            if words[0] == "control" and _SURFACE_OF[words[1]] == name:
                does = {"backlash": _play, "lag": lagged, "delay": _late}[words[2]]
                surface = does(surface, size)
        controls[:, column] = surface
        shown[name] = sampled(servo)
    return controls, shown


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlownCase:
    """A case, flown: what the program gets, and what is true."""

    case: Case
    maneuvers: tuple[Maneuver, ...]
    aircraft: Aircraft
    model: Model | None  # The baseline, where it is given.
    truth: Mapping[str, float]  # Linear derivatives.
    effects: Mapping[str, float]  # Hidden effects and their true sizes.
    shown: Mapping[str, Mapping[str, FloatArray]]
    """By maneuver: what the instruments would have recorded without noise."""
    steady: Mapping[str, Mapping[str, FloatArray]]
    """The same in still air, flown with the deflections that were measured: what a model that lacks
    nothing computes."""


def truth_of(case: Case) -> dict[str, float]:
    truth = true_derivatives(case.plan)
    for effect, size in case.effects.items():
        if effect in MISSING:
            truth[effect.removeprefix("aero.").replace(".", "_")] = size
    return truth


def baseline_of(case: Case) -> Model | None:
    if case.baseline == "fitted":
        return None
    values = truth_of(case)
    if case.baseline == "wrong":
        values = wrong_values(values, case.seed)
    for effect in case.effects:
        if effect in MISSING:
            values[effect.removeprefix("aero.").replace(".", "_")] = 0.0
    return Model(name="before", source="from earlier flights", derivatives=values)


def fly_motion(
    case: Case, planned: Planned, *, measured: Mapping[str, FloatArray] | None = None
) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """Fly one maneuver of a case; return its motion and its recorded controls, 100 Hz.

    Parameters
    ----------
    case : Case
    planned : Planned
    measured : mapping of str to ndarray, optional
        Errors of measured deflections: these are flown too, in still air.
    """
    built = tuple(name for name in case.effects if name in (*AIR, *STALL, *PROPULSION))
    engine = engine_for(built, case.airframe)
    engine.set(truth_of(case), {name: case.effects[name] for name in built})
    if engine.stall:
        engine.stall = Stall.of_plan(case.plan)
    condition = planned.condition(engine.aircraft)
    trim = engine.trim(condition)
    controls, shown = controls_of(case, planned, trim)
    gusts = None
    for name, error in (measured or {}).items():
        times = np.arange(len(controls)) / STEPS_PER_SECOND - SETTLING
        moves = np.interp(times, np.arange(error.size) / case.rate, error)
        controls[:, CONTROLS.index(name)] += np.where(times < 0.0, 0.0, moves)
    if case.gust and measured is None:
        gusts = dryden(
            case.gust, condition.V, len(controls), (case.plan, case.seed, int(planned.id), 4)
        )
    if case.by == "virtual":
        sizes = {name: case.effects[name] for name in built}
        model = flight_model(engine.aircraft, truth_of(case), sizes)
        _, now = engine.look(condition.mass, trim.state, trim.controls)
        density = float(now["density"][0])
        return fly_equations(model, condition.mass, density, trim.state, controls), shown
    return engine.fly(condition.mass, trim.state, controls, gusts), shown


def fly_case(case: Case, planned_maneuvers: Sequence[Planned] = PLAN) -> FlownCase:
    """Fly the maneuvers of a case, by default all of the plan, and record them."""
    aircraft = aircraft_of(case)
    every = RATE // case.rate
    maneuvers, shown, steady = [], {}, {}
    for planned in planned_maneuvers:
        motion, moved = fly_motion(case, planned)
        zeros = np.random.default_rng([case.plan, case.seed, ord(planned.flight), 6])
        faults = with_zeros(faults_of(case), zeros)
        seen = with_faults(exposed(aircraft, {**motion, **moved}), faults)
        random = np.random.default_rng([case.plan, case.seed, int(planned.id), 5])
        taken = recorded(
            seen,
            random,
            noise=case.noise,
            colored=case.colored,
            rate=case.rate,
            attitude=case.attitude,
        )
        clean = recorded(seen, random, noise=0.0, rate=case.rate)
        start = 40.0 + 25.0 * ((int(planned.id) - 1) % 8)
        maneuvers.append(
            Maneuver(
                id=planned.id,
                flight=planned.flight,
                aircraft=aircraft,
                block=Block(
                    channels=tuple(taken),
                    times=start + motion["time"][::every],
                    values=np.column_stack([*taken.values()]),
                ),
                inputs=planned.inputs,
                mass=planned.condition(aircraft).mass,
                kind=planned.kind,
            )
        )
        shown[planned.id] = clean
        errors = {name: taken[name] - clean[name] for name in ("de", "da", "dr")}
        calm, moved = fly_motion(case, planned, measured=errors)
        seen = with_faults(exposed(aircraft, {**calm, **moved}), faults)
        steady[planned.id] = recorded(seen, random, noise=0.0, rate=case.rate)
    return FlownCase(
        case=case,
        maneuvers=tuple(maneuvers),
        aircraft=aircraft,
        model=baseline_of(case),
        truth=truth_of(case),
        effects={name: size for name, size in case.effects.items() if size != neutral(name)},
        shown=shown,
        steady=steady,
    )
