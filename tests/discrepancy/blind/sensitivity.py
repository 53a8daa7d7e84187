"""How many standard deviations a hidden effect shows in the flights of a plan.

The plan is flown by JSBSim with every linear derivative and initial state changed a little, and
with every effect at a small size. Differences of what faultless instruments show, whitened by the
known noise, are columns; the columns of derivatives, initial states of every maneuver and zero
errors of every flight are projected out of those of the effects. What is left of a column is an
effect's size in standard deviations.

Whitening is by a Kalman filter of the aircraft about trim, that knows the gusts' spectrum and the
noise of the surface pots. The pots matter: who simulates with measured deflections integrates
their noise, and 0.05 deg of it triples the noise of speed and a_n at low frequency. Rounding to
12 bits is left out.

By Monte Carlo (`test_blind_cases`, and by hand with colored noise) the best linear estimate finds
ten sigmas as ten with a spread of one. In gusts of 1 m/s flights leave the range in which they are
linear about trim: there the sizes are those of a filter that follows the motion closely, and an
estimate from plain simulations scatters several times as much. Effects of 30 sigma and 10 sigma are
scaled from one column: at 10 they are within 6 % in calm air, at 30 a few show a quarter more.

Flying a plan with all that takes two minutes; the columns are kept in a folder (`cache_folder`).
"""

import functools
import hashlib
import json
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import platformdirs
from scipy.linalg import expm, solve_continuous_lyapunov

from gsapp.quantities import FloatArray
from tests.discrepancy.blind.cases import (
    CONTROL,
    MISSING,
    WHOLE,
    Case,
    Recording,
    known_effects,
    neutral,
    typical,
)
from tests.discrepancy.blind.engine import RATE, STATE, Engine
from tests.discrepancy.blind.flying import (
    controls_of,
    engine_for,
    faults_of,
    lengths,
    shipped_aircraft,
    true_derivatives,
    truth_of,
)
from tests.discrepancy.blind.instruments import (
    COLOR_TIME,
    COLORED,
    NOISE,
    ZERO,
    exposed,
    with_faults,
)
from tests.discrepancy.blind.jsbsim_aircraft import AIR, DERIVATIVES, PROPULSION, aircraft_xml
from tests.discrepancy.blind.plan import PLAN, SERVO_ORDER, Planned

CHANNELS = (
    "alpha", "beta", "p", "q", "r", "ax", "ay", "an", "dynamic_pressure", "phi", "theta",
)  # fmt: skip
ATTITUDE = 2
"""The last channels, that not every recorder has."""
UNKNOWN_ZEROS = ("p", "q", "r", "ax", "ay", "an")
"""Instruments whose zero error, common to a flight, is not known at all; of others (`ZERO`) it is
known how large it may be."""
STATE_STEPS = (0.1, 1e-3, 1e-3, 2e-3, 2e-3, 2e-3, 2e-3, 2e-3)
AIMED = 10.0
"""Sigmas at which the column of an effect is taken."""
_VERSION = 1
_WHITENING = 6
"""Numbers that make what is kept stale: raised with how columns are flown, or whitened."""


def cache_folder() -> Path:
    named = os.environ.get("GSAPP_BLIND_CACHE")
    folder = Path(named) if named else Path(platformdirs.user_cache_dir("gsapp-blind", False))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _fingerprint(plan: int, *more: object) -> str:
    parts = (
        _VERSION,
        PLAN,
        SERVO_ORDER,
        true_derivatives(plan),
        NOISE,
        CHANNELS,
        STATE_STEPS,
        *more,
    )
    # The last digits of numbers may differ between machines.
    text = re.sub(r"\d+\.\d+(e-?\d+)?", lambda found: f"{float(found[0]):.8g}", repr(parts))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _scaled(shown: Mapping[str, FloatArray]) -> FloatArray:
    return np.column_stack([shown[name] / NOISE[name] for name in CHANNELS])


def respond(
    case: Case, planned: Planned, controls: FloatArray, state: Sequence[float]
) -> FloatArray:
    built = tuple(name for name in case.effects if name in AIR or name in PROPULSION)
    engine = engine_for(built)
    engine.set(truth_of(case), {name: case.effects[name] for name in built})
    mass = planned.condition(engine.aircraft).mass
    motion = engine.fly(mass, state, controls)
    return _scaled(with_faults(exposed(engine.aircraft, motion), faults_of(case)))


@functools.lru_cache(maxsize=64)
def _still(plan: int, planned: Planned) -> tuple[tuple[float, ...], FloatArray, FloatArray]:
    case = Case(id="", group="nothing", plan=plan)
    engine = engine_for(())
    engine.set(truth_of(case), {})
    trim = engine.trim(planned.condition(engine.aircraft))
    controls, _ = controls_of(case, planned, trim)
    return trim.state, controls, respond(case, planned, controls, trim.state)


def change_by(plan: int, planned: Planned, effect: str, size: float) -> FloatArray:
    """Return the change by an effect for the controls that trim the aircraft without it.

    Returns
    -------
    ndarray, shape (n, n_channels)
        In units of the source's noise.
    """
    state, controls, still = _still(plan, planned)
    case = Case(id="", group="hidden", plan=plan, effects={effect: size})
    if effect in CONTROL or effect in MISSING:
        engine = engine_for(())
        engine.set(truth_of(case), {})
        trim = engine.trim(planned.condition(engine.aircraft))
        controls, _ = controls_of(case, planned, trim)
        state = trim.state
    if effect in MISSING:
        # The baseline lacks it altogether: its whole value counts.
        still = respond(replace(case, effects={effect: 0.0}), planned, controls, state)
    return respond(case, planned, controls, state) - still


def baseline_change(plan: int, planned: Planned) -> FloatArray:
    """Return columns of derivatives and initial states, shape (n, n_channels, 38)."""
    state, controls, still = _still(plan, planned)
    engine = engine_for(())
    truth = true_derivatives(plan)
    mass = planned.condition(engine.aircraft).mass

    def show(values: Mapping[str, float], start: Sequence[float]) -> FloatArray:
        engine.set(values, {})
        return _scaled(exposed(engine.aircraft, engine.fly(mass, start, controls)))

    columns = []
    for name in DERIVATIVES:
        value = truth.get(name, 0.0)
        step = 0.01 * max(abs(value), 0.02 if name.endswith("_0") else 0.1)
        columns.append((show({**truth, name: value + step}, state) - still) / step)
    for index, step in enumerate(STATE_STEPS):
        moved = list(state)
        moved[index] += step
        columns.append((show(truth, moved) - still) / step)
    return np.stack(columns, axis=-1)


@functools.lru_cache(maxsize=1)
def baseline_columns(plan: int) -> tuple[FloatArray, ...]:
    path = cache_folder() / f"baseline-{plan}-{_fingerprint(plan)}.npz"
    if not path.exists():
        found = {one.id: baseline_change(plan, one).astype(np.float32) for one in PLAN}
        _keep(path, found)
    with np.load(path) as kept:
        return tuple(kept[planned.id].astype(np.float64) for planned in PLAN)


def _aimed(plan: int, effect: str) -> float:
    if effect.endswith(WHOLE):
        return typical(effect)
    calm = Recording()
    if in_table(0, calm):
        # All plans are of one kind: what holds for the first is near enough.
        return size_for(0, effect, calm, AIMED)
    rest = neutral(effect)
    away = typical(effect) - rest
    column = [change_by(plan, one, effect, rest + away)[:, :, None] for one in PLAN]
    total = gram(whitened(plan, PLAN, baseline_columns(plan), column, calm))
    shows = math.sqrt(float(remaining(total, (effect,), own=effect)[0, 0]))
    return rest + away * min(AIMED / max(shows, 1e-6), 20.0)


def effect_columns(plan: int, effect: str) -> tuple[float, tuple[FloatArray, ...]]:
    """Return the size at which columns of an effect were taken, and its column by maneuver.

    The columns hold the whole change at that size, which shows about `AIMED` sigmas.
    """
    xml = aircraft_xml(shipped_aircraft(), (effect,)) if effect in AIR else f"{effect} 2"
    path = cache_folder() / f"{effect}-{plan}-{_fingerprint(plan, xml, typical(effect))}.npz"
    if not path.exists():
        size = _aimed(plan, effect)
        columns = (change_by(plan, one, effect, size) for one in PLAN)
        found = {one.id: each.astype(np.float32) for one, each in zip(PLAN, columns, strict=True)}
        _keep(path, {**found, "size": np.array(size)})
    with np.load(path) as kept:
        return float(kept["size"]), tuple(kept[one.id].astype(np.float64) for one in PLAN)


def _keep(path: Path, arrays: Mapping[str, FloatArray]) -> None:
    waiting = path.with_name(f"{path.stem}.{os.getpid()}.npz")
    np.savez(waiting, **arrays)  # type: ignore[arg-type]
    waiting.replace(path)


def _share(air: Recording) -> FloatArray:
    colored = math.exp(-1.0 / (air.rate * COLOR_TIME)) if air.colored else 0.0
    return np.array([colored if name in COLORED else 0.0 for name in CHANNELS])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Gusty:
    """What moves an aircraft in steady flight: x' = A x + B w + G n, y = C x + D n + v.

    States: u, v, w, p, q, r, phi, theta, then those of the gusts; w gusts, n noise of the pots on
    de, da, dr in units of the source's, y scaled by the source's noise.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    G: FloatArray
    D: FloatArray


def _steady(
    engine: Engine, planned: Planned
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return A, C, G, D of the aircraft about trim, by differences of JSBSim's accelerations."""
    condition = planned.condition(engine.aircraft)
    trim = engine.trim(condition)
    V, alpha, beta, p, q, r, phi, theta = trim.state
    flow = [
        V * math.cos(alpha) * math.cos(beta),
        V * math.sin(beta),
        V * math.sin(alpha) * math.cos(beta),
    ]
    center = np.array([*flow, p, q, r, phi, theta, *trim.controls])

    def look(x: FloatArray) -> FloatArray:
        speed = float(np.linalg.norm(x[:3]))
        state = (speed, math.atan2(x[2], x[0]), math.asin(x[1] / speed), *x[3:8])
        rates, motion = engine.look(condition.mass, state, tuple(x[8:]))
        turning = x[4] * math.sin(x[6]) + x[5] * math.cos(x[6])
        rolling = x[3] + turning * math.tan(x[7])
        pitching = x[4] * math.cos(x[6]) - x[5] * math.sin(x[6])
        seen = _scaled(exposed(engine.aircraft, motion))[0]
        return np.concatenate((rates, (rolling, pitching), seen))

    slopes = []
    for column, step in enumerate((0.05, 0.05, 0.05, *[1e-3] * 8)):
        ahead, behind = center.copy(), center.copy()
        ahead[column] += step
        behind[column] -= step
        slopes.append((look(ahead) - look(behind)) / (2.0 * step))
    table = np.column_stack(slopes)
    pots = -np.array([NOISE[name] for name in ("de", "da", "dr")])
    return table[:8, :8], table[8:, :8], table[:8, 8:] * pots, table[8:, 8:] * pots


def _gusty(plan: int, planned: Planned, gust: float) -> Gusty:
    """Return the aircraft with Dryden gusts before it and pots on its surfaces."""
    engine = engine_for(())
    engine.set(true_derivatives(plan), {})
    A, C, G, D = _steady(engine, planned)
    V = planned.condition(engine.aircraft).V
    long, tall, wide = lengths(gust)
    n = 13
    full, drive, out = np.zeros((n, n)), np.zeros((n, 3)), np.zeros((3, n))
    tau = long / V
    full[8, 8], drive[8, 0], out[0, 8] = -1.0 / tau, wide * math.sqrt(2.0 / tau), 1.0
    for axis, (first, size, length) in enumerate(((9, wide, long), (11, gust, tall)), start=1):
        # size sqrt(tau) (1 + sqrt(3) tau s)/(1 + tau s)^2 in controllable form
        tau = length / V
        full[first, first + 1] = 1.0
        full[first + 1, first : first + 2] = -1.0 / tau**2, -2.0 / tau
        drive[first + 1, axis] = 1.0
        gain = size * math.sqrt(tau)
        out[axis, first : first + 2] = gain / tau**2, gain * math.sqrt(3.0) / tau
    full[:8, :8] = A
    # Air that moves acts as a change of the flow; of attitude and of turning it knows nothing.
    full[:6, 8:] = -A[:6, :3] @ out[:, 8:]
    seen = np.hstack([C, -C[:, :3] @ out[:, 8:]])
    slow = np.vstack([G, np.zeros((5, 3))])
    return Gusty(A=full, B=drive, C=seen, G=slow, D=D)


def _discrete(gusty: Gusty, dt: float) -> tuple[FloatArray, FloatArray]:
    n = len(gusty.A)
    block = np.zeros((2 * n, 2 * n))
    block[:n, :n], block[:n, n:] = -gusty.A, gusty.B @ gusty.B.T
    block[n:, n:] = gusty.A.T
    whole = expm(block * dt)
    F = whole[n:, n:].T
    Q = F @ whole[:n, n:]
    return F, 0.5 * (Q + Q.T)


def _innovations(gusty: Gusty, columns: FloatArray, air: Recording) -> FloatArray:
    """Return columns (n, n_channels, m) as a Kalman filter of gusts and noise leaves them."""
    dt, share = 1.0 / air.rate, _share(air)
    kept = columns.shape[1]
    C, D = gusty.C[:kept] / air.noise, gusty.D[:kept]
    F, Q = _discrete(gusty, dt)
    # A pot's noise holds for a sample.
    G = air.noise * expm(0.5 * dt * gusty.A) @ gusty.G * dt
    P = np.zeros((13, 13))
    if air.gust:
        P[8:, 8:] = solve_continuous_lyapunov(gusty.A[8:, 8:], -gusty.B[8:] @ gusty.B[8:].T)
    R = np.eye(kept)
    if air.colored:
        # Noise with a past becomes states; a little white noise stays.
        past = np.diag(share[:kept])
        F = np.block([[F, np.zeros((13, kept))], [np.zeros((kept, 13)), past]])
        Q = np.block(
            [[Q, np.zeros((13, kept))], [np.zeros((kept, 13)), np.eye(kept) - past @ past]]
        )
        P = np.block([[P, np.zeros((13, kept))], [np.zeros((kept, 13)), np.eye(kept)]])
        C, R = np.hstack([C, np.eye(kept)]), 1e-4 * np.eye(kept)
        G = np.vstack([G, np.zeros((kept, 3))])
    R, Q, cross = R + D @ D.T, Q + G @ G.T, G @ D.T
    x = np.zeros((len(F), columns.shape[2]))
    out = np.empty_like(columns)
    gain, root, settled = np.empty(0), np.empty(0), False
    for k, y in enumerate(columns):
        if not settled:
            S = C @ P @ C.T + R
            root = np.linalg.inv(np.linalg.cholesky(S))
            gain = (F @ P @ C.T + cross) @ root.T @ root
            after = F @ P @ F.T + Q - gain @ S @ gain.T
            settled = k > 20 and bool(np.abs(after - P).max() < 1e-7 * np.abs(P).max())
            P = 0.5 * (after + after.T)
        difference = y - C @ x
        out[k] = root @ difference
        x = F @ x + gain @ difference
    return out


def _whitened(plan: int, planned: Planned, columns: FloatArray, air: Recording) -> FloatArray:
    kept = len(CHANNELS) - (0 if air.attitude else ATTITUDE)
    taken = columns[:: RATE // air.rate, :kept] / air.noise
    white = _innovations(_gusty(plan, planned, air.gust), taken, air)
    return white.reshape(-1, columns.shape[2])


def _free(maneuvers: Sequence[Planned]) -> list[str]:
    flights = sorted({planned.flight for planned in maneuvers})
    zeros = [f"{flight}:{name}" for flight in flights for name in ZERO]
    return [*DERIVATIVES, *zeros]


def _known(name: str) -> float:
    channel = name.partition(":")[2]
    if channel in UNKNOWN_ZEROS or channel not in ZERO:
        return 0.0
    return (NOISE[channel] / ZERO[channel]) ** 2


def whitened(
    plan: int,
    maneuvers: Sequence[Planned],
    baseline: Sequence[FloatArray],
    columns: Sequence[FloatArray],
    air: Recording,
) -> list[FloatArray]:
    """Return whitened columns by maneuver, its initial state projected out.

    Parameters
    ----------
    plan : int
    maneuvers : sequence of Planned
    baseline : sequence of ndarray, shape (n, n_channels, 38)
        For each maneuver.
    columns : sequence of ndarray, shape (n, n_channels, m)
        Of the effects.
    air : Recording

    Returns
    -------
    list of ndarray, shape (samples, k + m)
        k global unknowns, then the effects.
    """
    names, found = _free(maneuvers), []
    for planned, own, column in zip(maneuvers, baseline, columns, strict=True):
        zeros = np.zeros((len(column), len(CHANNELS), len(names) - len(DERIVATIVES)))
        for k, name in enumerate(names[len(DERIVATIVES) :]):
            flight, _, channel = name.partition(":")
            if flight == planned.flight:
                zeros[:, CHANNELS.index(channel), k] = 1.0
        split = len(DERIVATIVES)
        stacked = np.concatenate([own[:, :, split:], own[:, :, :split], zeros, column], axis=2)
        white = _whitened(plan, planned, stacked, air)
        start, rest = white[:, : len(STATE)], white[:, len(STATE) :]
        basis, _ = np.linalg.qr(start)
        found.append(rest - basis @ (basis.T @ rest))
    return found


def gram(parts: Sequence[FloatArray]) -> FloatArray:
    return np.asarray(sum(part.T @ part for part in parts))


def remaining(
    total: FloatArray, effects: Sequence[str], *, own: str = "", maneuvers: Sequence[Planned] = PLAN
) -> FloatArray:
    names = _free(maneuvers)
    k = len(names)
    assert total.shape[0] == k + len(effects)
    shares = _shares(total, names, own)
    return total[k:, k:] - total[:k, k:].T @ shares


def _shares(total: FloatArray, names: Sequence[str], own: str) -> FloatArray:
    k = len(names)
    kept = [place for place, name in enumerate(names) if own != f"aero.{name.replace('_', '.')}"]
    known, cross = total[np.ix_(kept, kept)].copy(), total[kept, k:]
    known[np.diag_indices_from(known)] += [_known(names[place]) for place in kept]
    scale = np.sqrt(np.maximum(np.diag(known), 1e-30))
    inverse = np.linalg.pinv(known / np.outer(scale, scale), rcond=1e-11)
    found = np.zeros((k, total.shape[0] - k))
    found[kept] = inverse @ (cross / scale[:, None]) / scale[:, None]
    return found


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Showing:
    """What all known effects show in a plan that is flown and recorded one way."""

    per_size: Mapping[str, float]  # Standard deviations for each unit away from neutral.
    alike: Mapping[str, Mapping[str, float]]  # Cosines between effects, those above 0.6 in size.
    where: Mapping[str, Mapping[str, float]]  # By effect: share of each maneuver in what it shows.


_ALIKE = 0.6
_TABLE = Path(__file__).with_name("sigmas.json")


@functools.lru_cache(maxsize=1)
def _shipped() -> dict[str, dict[str, object]]:
    if not _TABLE.exists():
        return {}
    return dict(json.loads(_TABLE.read_text("utf-8")))


def has_table() -> bool:
    return _TABLE.exists()


def in_table(plan: int, air: Recording) -> bool:
    return showing_key(plan, air) in _shipped()


@functools.lru_cache(maxsize=256)
def showing_key(plan: int, air: Recording) -> str:
    effects = known_effects()
    xml = aircraft_xml(shipped_aircraft(), [one for one in effects if one in AIR])
    sizes = [typical(one) for one in effects]
    return _fingerprint(plan, _WHITENING, effects, sizes, xml, air)


@functools.lru_cache(maxsize=64)
def showing(plan: int, air: Recording) -> Showing:
    key = showing_key(plan, air)
    content = _shipped().get(key)
    if content is None:
        path = cache_folder() / f"showing-{key}.json"
        if not path.exists():
            waiting = path.with_suffix(f".{os.getpid()}")
            waiting.write_text(json.dumps(_show(plan, air)), "utf-8")
            waiting.replace(path)
        content = json.loads(path.read_text("utf-8"))
    return Showing(**content)  # type: ignore[arg-type]


def _show(plan: int, air: Recording) -> dict[str, dict[str, object]]:
    effects = known_effects()
    found = [effect_columns(plan, effect) for effect in effects]
    columns = [
        np.stack([each[number] for _, each in found], axis=-1) for number in range(len(PLAN))
    ]
    parts = whitened(plan, PLAN, baseline_columns(plan), columns, air)
    total, names = gram(parts), _free(PLAN)
    plain = remaining(total, effects)
    # Some effects are among the unknowns that are projected out of the others.
    unknown = [effect in MISSING for effect in effects]
    found_here: dict[str, dict[str, object]] = {"per_size": {}, "alike": {}, "where": {}}
    for index, (effect, (size, _)) in enumerate(zip(effects, found, strict=True)):
        own = effect if unknown[index] else ""
        info = remaining(total, effects, own=own) if own else plain
        shows = math.sqrt(max(float(info[index, index]), 0.0))
        found_here["per_size"][effect] = _rounded(shows / abs(size - neutral(effect)))
        norms = np.sqrt(np.maximum(np.diag(info), 1e-12)) * max(shows, 1e-6)
        cosines = info[index] / norms
        found_here["alike"][effect] = {
            other: _rounded(float(cosines[number]))
            for number, other in enumerate(effects)
            if number != index and not unknown[number] and abs(cosines[number]) > _ALIKE
        }
        taken = _shares(total, names, own)[:, index]
        left = [part[:, len(names) + index] - part[:, : len(names)] @ taken for part in parts]
        energy = np.array([float(one @ one) for one in left])
        found_here["where"][effect] = {
            planned.id: round(float(share), 3)
            for planned, share in zip(PLAN, energy / energy.sum(), strict=True)
        }
    return found_here


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")


def write_table(asked: Iterable[tuple[int, Recording]]) -> None:
    content = {showing_key(plan, air): _as_dict(showing(plan, air)) for plan, air in asked}
    rows = ",\n".join(
        f"{json.dumps(key)}: {json.dumps(content[key], sort_keys=True)}" for key in sorted(content)
    )
    _TABLE.write_text("{\n" + rows + "\n}\n", "utf-8")


def _as_dict(found: Showing) -> dict[str, object]:
    where = {
        effect: {
            one: share for one, share in shares.items() if share >= 0.45 * max(shares.values())
        }
        for effect, shares in found.where.items()
    }
    alike = {
        effect: {one: cosine for one, cosine in others.items() if abs(cosine) > _ALIKE}
        for effect, others in found.alike.items()
    }
    return {"per_size": found.per_size, "alike": alike, "where": where}


def size_for(plan: int, effect: str, air: Recording, sigma: float) -> float:
    rest = neutral(effect)
    sign = math.copysign(1.0, typical(effect) - rest)
    return rest + sign * sigma / showing(plan, air).per_size[effect]


def with_sizes(case: Case) -> Case:
    if not case.sigma:
        return case
    sizes = {
        effect: size
        if effect.endswith(WHOLE)
        else size_for(case.plan, effect, case.recording, (index and case.later_sigma) or case.sigma)
        for index, (effect, size) in enumerate(case.effects.items())
    }
    return replace(case, effects=sizes)


def distances(case: Case, effect: str) -> dict[str, float]:
    """Return how many sigmas part an effect of a case from others like it.

    Below 3 or so two effects cannot be told apart, whoever looks.
    """
    size = case.effects[effect]
    found = showing(case.plan, case.recording)
    shows = abs(size - neutral(effect)) * found.per_size[effect]
    return {
        other: shows * math.sqrt(max(1.0 - cosine * cosine, 0.0))
        for other, cosine in found.alike[effect].items()
    }
