"""A campaign of maneuvers by maximum likelihood, and the same fits as others would make them.

40 longitudinal and 38 lateral-directional maneuvers of 10 s at 100 Hz: known derivatives, every
one varied, white instrument noise, 12-bit converter. Each is fitted by itself with all bounds; the
unknowns are 12 (18) derivatives, the initial states and the bias of the accelerometer.

Two peers get one maneuver of each kind, with the same unknowns, responses, start values and input
signals, and the weights that our fit arrived at: `scipy.optimize.least_squares` over
`solve_ivp` with the equations written out below, and output error by the package aeroid. Ratios
count only where all arrive at the same values.

    python likelihood.py [--quick]
"""

import contextlib
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

# Read by numpy when it is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import load_model
from gsapp.dynamics.propulsion import thrust
from gsapp.identification import equation_error
from gsapp.identification.axes import AXIS_RESPONSES, AXIS_STATES
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood import MLSettings, estimate
from gsapp.identification.motion import measured_motion
from gsapp.identification.results import Estimate
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY
from tests.identification.virtual_maneuvers import AXES, fly

AEROID = "aeroid==0.5.0"
CAMPAIGN = {"lon": 40, "lat": 38}
KINDS = {"lon": "longitudinal", "lat": "lateral-directional"}
BIASED = {"lon": "an", "lat": "ay"}
FIRST_SEED = 7000
GOAL = 2.0
GOALS = {"least_squares + solve_ivp": 300.0, "aeroid": 500.0}
APART = 0.1
"""Of a bound: beyond it two fits did not do the same."""
REPETITIONS = 8
PATIENCE = 120.0
"""CPU seconds that a peer gets for one maneuver."""
STEP = 1e-4
"""Of the peers' difference quotients, relative; aeroid's own."""


# --- the campaign -----------------------------------------------------------------------------


def load() -> str:
    if not hasattr(os, "getloadavg"):
        return f"{os.cpu_count()} cores"
    return f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"


def campaign(aircraft: Aircraft, counts: Mapping[str, int]) -> None:
    """Fly and fit the maneuvers; print what it took."""
    flown = {
        kind: [fly(FIRST_SEED + n, kind, aircraft=aircraft) for n in range(count)]
        for kind, count in counts.items()
    }
    for kind, virtual in flown.items():
        estimate([virtual[0].maneuver], MLSettings(axis=AXES[kind]))
    totals = []
    for repetition in range(3):
        each = {}
        for kind, virtual in flown.items():
            started = time.process_time()
            found = [estimate([one.maneuver], MLSettings(axis=AXES[kind])) for one in virtual]
            each[kind] = (time.process_time() - started) / len(virtual)
            if repetition == 0:
                describe(kind, virtual, found)
        totals.append(sum(each[kind] * CAMPAIGN[kind] for kind in each))
        shown = ", ".join(f"{1e3 * spent:.0f} ms each {kind}" for kind, spent in each.items())
        scaled = "" if counts == CAMPAIGN else f" (from {sum(counts.values())} maneuvers)"
        print(f"campaign of 40 + 38{scaled}: {totals[-1]:.2f} s of CPU, {shown}; {load()}")
    print(
        f"campaign: {min(totals):.2f} to {max(totals):.2f} s of CPU; goal {GOAL:g} s "
        f"({min(totals) / GOAL:.2f} to {max(totals) / GOAL:.2f} of it)"
    )


def describe(kind: str, virtual: Sequence[Any], found: Sequence[Estimate]) -> None:
    """Print what became of the fits of one kind."""
    iterations = [one.iterations for one in found]
    errors = [
        (one.derivatives[name].value - true) / one.derivatives[name].std
        for one, flown in zip(found, virtual, strict=True)
        for name, true in flown.truth.items()
        if one.derivatives[name].value is not None
    ]
    print(
        f"{KINDS[kind]:20} {len(found)} fits of {len(virtual[0].maneuver.block)} samples, "
        f"{len(found[0].free) + len(found[0].nuisance)} unknowns; "
        f"{100 * np.mean([one.converged for one in found]):.0f} % converged, "
        f"{np.mean(iterations):.1f} iterations (most {max(iterations)}); "
        f"{len(errors)} of {sum(len(one.truth) for one in virtual)} values earned, "
        f"rms of error over bound {np.sqrt(np.mean(np.square(errors))):.2f}"
    )


# --- the equations, written out -----------------------------------------------------------------


class Longitudinal:
    """alpha', q' and what the instruments show."""

    drives = ("V", "beta", "p", "r", "phi", "theta", "de", "thrust", "rho", "mass")

    def __init__(self, aircraft: Aircraft) -> None:
        geometry, self.mass = aircraft.geometry, aircraft.mass
        self.area, self.chord = geometry.wing_area, geometry.chord
        engines = aircraft.propulsion.position
        self.height = sum(z for _, _, z in engines) / len(engines)
        self.vane = aircraft.sensors.alpha_vane
        self.box = aircraft.sensors.accelerometer.position

    def loads(self, x: Any, u: Any, given: Mapping[str, float]) -> tuple[Any, Any, Any]:
        """Return ax, an (m/s^2) and q' at the center of gravity."""
        alpha, q = x
        V, _, p, r, _, _, de, pull, rho, mass = u
        body = self.mass
        qS = 0.5 * rho * V * V * self.area
        q_hat = 0.5 * q * self.chord / V
        CN, CA, Cm = (
            given[f"{name}_0"]
            + given[f"{name}_alpha"] * alpha
            + given[f"{name}_q"] * q_hat
            + given[f"{name}_de"] * de
            for name in ("CN", "CA", "Cm")
        )
        spin = (body.ixx - body.izz) * p * r + body.ixz * (p * p - r * r)
        moment = qS * self.chord * Cm + self.height * pull - spin
        return (pull - qS * CA) / mass, qS * CN / mass, moment / body.iyy

    def rates(
        self, x: Sequence[float], u: Sequence[float], given: Mapping[str, float]
    ) -> tuple[float, ...]:
        alpha, q = x
        V, beta, p, r, phi, theta = u[:6]
        ax, an, q_dot = self.loads(x, u, given)
        sa, ca = math.sin(alpha), math.cos(alpha)
        down = GRAVITY * math.cos(theta) * math.cos(phi) - an
        ahead = ax - GRAVITY * math.sin(theta)
        turned = (p * ca + r * sa) * math.tan(beta)
        return q - turned + (ca * down - sa * ahead) / (V * math.cos(beta)), q_dot

    def responses(self, x: Any, u: Any, given: Mapping[str, float]) -> tuple[Any, ...]:
        alpha, q = x
        V, beta, p, r = u[:4]
        ax, an, q_dot = self.loads(x, u, given)
        along, across, below = self.vane.position
        speed = V * np.cos(beta)
        forward = speed * np.cos(alpha) + q * below - r * across
        downward = speed * np.sin(alpha) + p * across - q * along
        ahead, _, under = self.box
        return (
            self.vane.upwash * np.arctan2(downward, forward),
            q,
            an - (p * r - q_dot) * ahead + (p * p + q * q) * under + given["bias_an"],
            ax - (q * q + r * r) * ahead + (p * r + q_dot) * under,
        )


class Lateral:
    """beta', p', r' and what the instruments show."""

    drives = ("V", "alpha", "q", "phi", "theta", "da", "dr", "ax", "an", "rho", "mass")

    def __init__(self, aircraft: Aircraft) -> None:
        geometry, self.mass = aircraft.geometry, aircraft.mass
        self.area, self.span = geometry.wing_area, geometry.span
        self.vane = aircraft.sensors.beta_vane
        self.box = aircraft.sensors.accelerometer.position

    def loads(self, x: Any, u: Any, given: Mapping[str, float]) -> tuple[Any, Any, Any]:
        """Return ay (m/s^2), p' and r'."""
        beta, p, r = x
        V, _, q, _, _, da, dr, _, _, rho, mass = u
        body = self.mass
        ixx, iyy, izz, ixz = body.ixx, body.iyy, body.izz, body.ixz
        qS = 0.5 * rho * V * V * self.area
        half = 0.5 * self.span / V
        CY, Cl, Cn = (
            given[f"{name}_0"]
            + given[f"{name}_beta"] * beta
            + given[f"{name}_p"] * (p * half)
            + given[f"{name}_r"] * (r * half)
            + given[f"{name}_da"] * da
            + given[f"{name}_dr"] * dr
            for name in ("CY", "Cl", "Cn")
        )
        roll = qS * self.span * Cl + ixz * p * q - (izz - iyy) * q * r
        yaw = qS * self.span * Cn - ixz * q * r - (iyy - ixx) * p * q
        whole = ixx * izz - ixz * ixz
        return qS * CY / mass, (izz * roll + ixz * yaw) / whole, (ixz * roll + ixx * yaw) / whole

    def rates(
        self, x: Sequence[float], u: Sequence[float], given: Mapping[str, float]
    ) -> tuple[float, ...]:
        beta, p, r = x
        V, alpha, _, phi, theta, _, _, ax, an = u[:9]
        ay, p_dot, r_dot = self.loads(x, u, given)
        sa, ca, ct = math.sin(alpha), math.cos(alpha), math.cos(theta)
        side = ay + GRAVITY * ct * math.sin(phi)
        ahead = ax - GRAVITY * math.sin(theta)
        down = GRAVITY * ct * math.cos(phi) - an
        pushed = math.cos(beta) * side - math.sin(beta) * (ca * ahead + sa * down)
        return p * sa - r * ca + pushed / V, p_dot, r_dot

    def responses(self, x: Any, u: Any, given: Mapping[str, float]) -> tuple[Any, ...]:
        beta, p, r = x
        V, alpha, q = u[:3]
        ay, p_dot, r_dot = self.loads(x, u, given)
        along, across, below = self.vane.position
        forward = V * np.cos(beta) * np.cos(alpha) + q * below - r * across
        sideward = V * np.sin(beta) + r * along - p * below
        ahead, right, under = self.box
        shown = ay + (p * q + r_dot) * ahead - (p * p + r * r) * right
        return (
            self.vane.upwash * np.arctan2(sideward, forward),
            p,
            r,
            shown + (q * r - p_dot) * under + given["bias_ay"],
        )


EQUATIONS = {"lon": Longitudinal, "lat": Lateral}


# --- one maneuver, three ways -------------------------------------------------------------------


class TimeUpError(Exception):
    """A peer has used what it gets."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """One maneuver, ready for anybody's fit.

    Attributes
    ----------
    times : ndarray, shape (n,)
        From zero, s.
    drives : ndarray, shape (n, n_drives)
        What enters the equations from measurement.
    measured : ndarray, shape (n, n_responses)
    start : dict of str to float
        All unknowns, none smaller than its bound: peers scale by these numbers.
    weights : ndarray, shape (n_responses,)
        One over the standard deviation of the noise.
    ours, bounds : dict of str to float
        What our fit found.
    again : callable
        Makes our fit.
    """

    kind: str
    equations: Any
    times: FloatArray
    drives: FloatArray
    measured: FloatArray
    start: dict[str, float]
    weights: FloatArray
    ours: dict[str, float]
    bounds: dict[str, float]
    again: Callable[[], Estimate]

    @property
    def states(self) -> tuple[str, ...]:
        return AXIS_STATES[AXES[self.kind]]


def starts(kind: str) -> list[str]:
    return [f"start_{name}" for name in AXIS_STATES[AXES[kind]]]


def lay_out(kind: str, maneuver: Maneuver, aircraft: Aircraft) -> Case:
    """Fit a maneuver our way and prepare it for the peers."""
    axis, model = AXES[kind], load_model("b777")
    settings = MLSettings(axis=axis, model=model)
    found = estimate([maneuver], settings)
    motion = measured_motion(maneuver)
    whole = FlightModel(aircraft, model).evaluate(list(motion.states.T), list(motion.inputs.T))
    rho, throttle = motion.input("rho"), motion.input("throttle")
    signals = {
        **{name: motion.state(name) for name in ("V", "alpha", "beta", "p", "q", "r")},
        **{name: motion.state(name) for name in ("phi", "theta")},
        **{name: motion.input(name) for name in ("de", "da", "dr", "rho", "mass")},
        "thrust": thrust(aircraft, throttle, rho, motion.state("V")),
        "ax": whole.loads.X / maneuver.mass,
        "an": -whole.loads.Z / maneuver.mass,
    }
    equations = EQUATIONS[kind](aircraft)
    history = found.histories[0]
    names = {
        **{f"start_{name}": f"{maneuver.id}.initial.{name}" for name in AXIS_STATES[axis]},
        f"bias_{BIASED[kind]}": f"{maneuver.id}.bias.{BIASED[kind]}",
    }
    first = dict(equation_error.estimate_start_values([maneuver], found.free, model=model))
    first |= {f"start_{name}": float(motion.state(name)[:5].mean()) for name in AXIS_STATES[axis]}
    first |= {f"bias_{BIASED[kind]}": 0.0}
    ours = {name: found.derivatives[name].value for name in found.free}
    ours |= {short: found.nuisance[long][0] for short, long in names.items()}
    bounds = {name: found.derivatives[name].cramer_rao for name in found.free}
    bounds |= {short: found.nuisance[long][1] for short, long in names.items()}
    return Case(
        kind=kind,
        equations=equations,
        times=motion.times - motion.times[0],
        drives=np.column_stack([signals[name] for name in equations.drives]),
        measured=np.column_stack([maneuver.samples(name) for name in AXIS_RESPONSES[axis]]),
        start={
            name: math.copysign(max(abs(value), bounds[name]), value)
            for name, value in first.items()
        },
        weights=1.0 / np.sqrt(np.mean((history.measured - history.computed) ** 2, axis=0)),
        ours=ours,
        bounds=bounds,
        again=partial(estimate, [maneuver], settings),
    )


def integration(case: Case) -> dict[str, float]:
    return {"max_step": float(case.times[1] - case.times[0]), "rtol": 1e-3, "atol": 1e-6}


def by_scipy(case: Case) -> dict[str, float]:
    """Fit as anybody would with scipy."""
    names, first = list(case.start), np.array([*case.start.values()])
    rate, last = 1.0 / (case.times[1] - case.times[0]), len(case.times) - 2
    changes = np.diff(case.drives, axis=0)
    deadline = time.process_time() + PATIENCE

    def residuals(scaled: FloatArray) -> FloatArray:
        if time.process_time() > deadline:
            raise TimeUpError
        given = dict(zip(names, (first * scaled).tolist(), strict=True))

        def slope(t: float, x: FloatArray) -> tuple[float, ...]:
            k = min(int(t * rate), last)
            u = case.drives[k] + (t * rate - k) * changes[k]
            return case.equations.rates(x.tolist(), u.tolist(), given)

        begin = [given[name] for name in starts(case.kind)]
        flown = solve_ivp(
            slope, (0.0, case.times[-1]), begin, t_eval=case.times, **integration(case)
        )
        if not flown.success:
            return np.full(case.measured.size, 1e3)
        computed = np.column_stack(case.equations.responses(flown.y, case.drives.T, given))
        return ((computed - case.measured) * case.weights).ravel()

    solved = least_squares(residuals, np.ones(len(names)), x_scale="jac", diff_step=STEP)
    return dict(zip(names, (first * solved.x).tolist(), strict=True))


def by_aeroid(case: Case, aeroid: ModuleType) -> dict[str, float]:
    """Fit with aeroid's output error.

    It holds the initial state; the states are therefore counted from a start that is a parameter.
    With its own tolerances (1e-8, 1e-10) a simulation takes eight times as long: see `integration`.
    """
    names, origins = list(case.start), starts(case.kind)
    deadline = time.process_time() + PATIENCE

    def at(x: FloatArray, given: Mapping[str, float]) -> list[float]:
        return [a + given[b] for a, b in zip(x.tolist(), origins, strict=True)]

    def dynamics(t: float, x: FloatArray, u: FloatArray, given: Mapping[str, float]) -> Any:
        if time.process_time() > deadline:
            raise TimeUpError
        # The package tries the equations once with zeros.
        return case.equations.rates(at(x, given), u.tolist(), given) if u.any() else 0.0 * x

    def measurement(t: float, x: FloatArray, u: FloatArray, given: Mapping[str, float]) -> Any:
        if not u.any():
            return np.zeros(len(responses))
        return case.equations.responses(at(x, given), u.tolist(), given)

    responses = [f"{name}_shown" for name in AXIS_RESPONSES[AXES[case.kind]]]
    drives = [f"{name}_in" for name in case.equations.drives]
    model = aeroid.Model(
        states=case.states, controls=drives, parameters=case.start, dynamics=dynamics,
        outputs=responses, measurement=measurement,
    )  # fmt: skip
    channels = dict(zip(drives, case.drives.T, strict=True))
    channels |= dict(zip(responses, case.measured.T, strict=True))
    data = aeroid.FlightData(time=case.times, channels=channels)
    found = aeroid.identify(
        model, data, names, x0=np.zeros(len(origins)),
        weights=dict(zip(responses, case.weights.tolist(), strict=True)),
        optimizer_options={"x_scale": "jac", "diff_step": STEP},
        simulate_options=integration(case),
    )  # fmt: skip
    return dict(found.parameters)


def own_times(case: Case) -> list[float]:
    spent = []
    for _ in range(REPETITIONS):
        started = time.process_time()
        case.again()
        spent.append(time.process_time() - started)
    return spent


def compare(case: Case, title: str, work: Callable[[Case], dict[str, float]]) -> None:
    """Run a peer on a case, our fit before and after, and print how they compare."""
    before = own_times(case)
    started, found = time.process_time(), None
    with contextlib.suppress(TimeUpError):
        found = work(case)
    spent = time.process_time() - started
    own = float(np.median(before + own_times(case)))
    line = (
        f"{KINDS[case.kind]:20} {len(case.start)} unknowns, ours {1e3 * own:.0f} ms, {title} "
        f"{spent:.1f} s: "
    )
    ratio = f"{spent / own:,.0f} times ours (goal {GOALS[title]:g})"
    if found is None:
        print(f"{line}not done by then, more than {ratio}; values not compared; {load()}")
        return
    apart = {name: abs(found[name] - case.ours[name]) / case.bounds[name] for name in case.ours}
    worst = max(apart, key=apart.__getitem__)
    if apart[worst] > APART:
        ratio = f"VOID, other values (would be {ratio})"
    print(f"{line}{ratio}; values within {apart[worst]:.4f} of a bound ({worst}); {load()}")


def install(folder: Path) -> ModuleType | str:
    done = subprocess.run(
        [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--target", folder, AEROID],
        capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode:
        return (done.stderr.strip().splitlines() or ["pip failed"])[-1]
    sys.path.insert(0, str(folder))
    try:
        import aeroid
    except ImportError as error:
        return str(error)
    finally:
        sys.path.remove(str(folder))
    return aeroid


def main(*options: str) -> None:
    quick = "--quick" in options
    aircraft = load_aircraft("b777")
    campaign(aircraft, {"lon": 10, "lat": 10} if quick else CAMPAIGN)
    with tempfile.TemporaryDirectory() as scratch:
        aeroid = install(Path(scratch))
        for kind in ("lon",) if quick else KINDS:
            case = lay_out(kind, fly(FIRST_SEED, kind, aircraft=aircraft).maneuver, aircraft)
            compare(case, "least_squares + solve_ivp", by_scipy)
            if isinstance(aeroid, str):
                print(f"{KINDS[kind]:20} no ratio to {AEROID}, it cannot be installed: {aeroid}")
            else:
                compare(case, "aeroid", partial(by_aeroid, aeroid=aeroid))


if __name__ == "__main__":
    main(*sys.argv[1:])
