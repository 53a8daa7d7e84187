"""JSBSim with one aircraft loaded: trims and flies whole maneuvers from given control histories.

A run takes about 10 microseconds a step. Gusts are winds of JSBSim. The controls of a flown
maneuver are kept, so that the same maneuver can be flown again with something else changed.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import jsbsim
import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.quantities import FloatArray
from tests.discrepancy.blind.jsbsim_aircraft import (
    ALTITUDE,
    DERIVATIVES,
    FOOT,
    POUND,
    PSF,
    SLUG,
    STALL,
    SURFACES,
    place_of,
    write_aircraft,
)

STEPS_PER_SECOND = 400
RATE = 100
SUBSTEPS = STEPS_PER_SECOND // RATE
SETTLING = 0.2
"""Seconds that JSBSim flies before the record begins: its integrators need a past."""
ADAMS_BASHFORTH_2 = 3
HEADING = 0.7
MEMORY = 0.15
"""Time constant of effects with memory, s."""

STATE = ("V", "alpha", "beta", "p", "q", "r", "phi", "theta")
"""Initial states."""
CONTROLS = ("de", "da", "dr", "flap", "throttle")
"""Surfaces (rad) and throttle as the engines follow it, in the columns of control histories."""

_RECORDED: Mapping[str, tuple[str, float]] = {
    **{one: (f"velocities/{one}-aero-fps", FOOT) for one in "uvw"},
    **{one: (f"velocities/{one}-rad_sec", 1.0) for one in "pqr"},
    **{f"{one}_dot": (f"accelerations/{one}dot-rad_sec2", 1.0) for one in "pqr"},
    **{f"f{one}": (f"forces/fb{one}-total-lbs", POUND) for one in "xyz"},
    "phi": ("attitude/phi-rad", 1.0),
    "theta": ("attitude/theta-rad", 1.0),
    "density": ("atmosphere/rho-slugs_ft3", SLUG / FOOT**3),
    "static_pressure": ("atmosphere/P-psf", PSF),
    "temperature": ("atmosphere/T-R", 5.0 / 9.0),
}
"""Our name: JSBSim's property, and its unit in SI."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """Steady flight in which a maneuver starts."""

    V: float  # m/s.
    throttle: float | None = None
    """None: level flight. A number: climb or descent, whatever it gives."""
    flap: float = 0.0
    beta: float = 0.0
    """rad."""
    mass: float  # kg.


@dataclass(frozen=True, slots=True, kw_only=True)
class Stall:
    """Kirchhoff's separation point x, from 1 (attached) to 0, as Goman and Khrabrov move it."""

    a1: float = 20.0  # Per radian.
    alpha_star: float = 0.245  # rad.
    tau1: float = 0.25
    tau2: float = 0.12
    """s."""

    @classmethod
    def of_plan(cls, plan: int) -> Stall:
        random = np.random.default_rng([plan, 7])
        return cls(
            a1=20.0 * float(random.uniform(0.7, 1.4)),
            alpha_star=0.245 * float(random.uniform(0.9, 1.1)),
            tau1=0.25 * float(random.uniform(0.6, 1.6)),
            tau2=0.12 * float(random.uniform(0.5, 1.6)),
        )

    def settled(self, alpha: float, alpha_dot: float) -> float:
        return 0.5 - 0.5 * math.tanh(self.a1 * (alpha - self.tau2 * alpha_dot - self.alpha_star))

    def moved(self, x: float, alpha: float, alpha_dot: float) -> float:
        step = math.exp(-1.0 / (STEPS_PER_SECOND * self.tau1))
        return step * x + (1.0 - step) * self.settled(alpha, alpha_dot)

    @staticmethod
    def lost_lift(x: float) -> float:
        """Return the share of the lift that is lost."""
        return 1.0 - 0.25 * (1.0 + math.sqrt(x)) ** 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Trim:
    state: tuple[float, ...]
    controls: tuple[float, ...]


class Engine:
    """JSBSim for one aircraft and some effects.

    Parameters
    ----------
    aircraft : Aircraft
    effects : sequence of str
        Ids of `AIR` and `PROPULSION` that are built in; their sizes are set by `set`.
    airframe : str, optional
        An aircraft that JSBSim ships, whose aerodynamics are flown.
    """

    def __init__(self, aircraft: Aircraft, effects: Sequence[str] = (), airframe: str = "") -> None:
        self.aircraft = aircraft
        jsbsim.FGJSBBase().debug_lvl = 0
        with tempfile.TemporaryDirectory() as name:
            write_aircraft(Path(name), aircraft, effects, airframe)
            self.fdm = jsbsim.FGFDMExec(name)
            self.fdm.set_debug_level(0)
            assert self.fdm.load_planet(str(Path(name) / "planet.xml"), False)
            assert self.fdm.load_model_with_paths("hidden", name, name, name, True)
        self.fdm.set_dt(1.0 / STEPS_PER_SECOND)
        for kind in ("rotational", "translational"):
            self.fdm[f"simulation/integrator/rate/{kind}"] = ADAMS_BASHFORTH_2
            self.fdm[f"simulation/integrator/position/{kind}"] = ADAMS_BASHFORTH_2
        self.fdm["ic/h-sl-ft"] = ALTITUDE / FOOT
        self.fdm["ic/lat-geod-deg"] = 39.6
        self.fdm["ic/psi-true-rad"] = HEADING
        manager = self.fdm.get_property_manager()
        self._controls = [manager.get_node(one) for one in (*SURFACES.values(), "engines/throttle")]
        self._wind = [
            manager.get_node(f"atmosphere/wind-{one}-fps") for one in ("north", "east", "down")
        ]
        self._memory = manager.get_node("memory/q")
        self._pitch = manager.get_node("velocities/q-rad_sec")
        self._recorded = [manager.get_node(place) for place, _ in _RECORDED.values()]
        self._accelerations = [
            manager.get_node(f"accelerations/{one}")
            for one in (
                "udot-ft_sec2", "vdot-ft_sec2", "wdot-ft_sec2",
                "pdot-rad_sec2", "qdot-rad_sec2", "rdot-rad_sec2",
            )
        ]  # fmt: skip
        self._has_memory = any("memory" in one for one in effects)
        self.stall = None if STALL.keys().isdisjoint(effects) else Stall()
        self._flow = [manager.get_node(f"aero/{one}") for one in ("alpha-rad", "alphadot-rad_sec")]
        self._stall = [manager.get_node(f"stall/{one}") for one in ("lost-lift", "separated")]

    def set(self, derivatives: Mapping[str, float], sizes: Mapping[str, float]) -> None:
        for name in DERIVATIVES:
            self.fdm[f"known/{name}"] = derivatives.get(name, 0.0)
        for effect, size in sizes.items():
            self.fdm[place_of(effect)] = size

    def begin(self, mass: float, state: Sequence[float], controls: Sequence[float]) -> None:
        """Set mass (kg), state (V, alpha, beta, p, q, r, phi, theta; SI) and `CONTROLS`."""
        fdm = self.fdm
        fuel = mass - (self.aircraft.mass.mass - self.aircraft.mass.fuel)
        fdm["inertia/pointmass-weight-lbs"] = fuel * 9.80665 / POUND
        V, alpha, beta, p, q, r, phi, theta = state
        fdm["ic/u-fps"] = V * math.cos(alpha) * math.cos(beta) / FOOT
        fdm["ic/v-fps"] = V * math.sin(beta) / FOOT
        fdm["ic/w-fps"] = V * math.sin(alpha) * math.cos(beta) / FOOT
        fdm["ic/p-rad_sec"], fdm["ic/q-rad_sec"], fdm["ic/r-rad_sec"] = p, q, r
        fdm["ic/phi-rad"], fdm["ic/theta-rad"] = phi, theta
        for node in self._wind:
            node.set_double_value(0.0)
        self._memory.set_double_value(0.0)
        for node, value in zip(self._controls, controls, strict=True):
            node.set_double_value(value)
        if self.stall:
            self._separate(self.stall.settled(alpha, 0.0))
        assert fdm.run_ic()

    def _separate(self, x: float) -> float:
        self._stall[0].set_double_value(Stall.lost_lift(x))
        self._stall[1].set_double_value(1.0 - x)
        return x

    def trim(self, condition: Condition) -> Trim:
        """Return the controls and attitude of steady straight flight, by Newton's method."""
        level = condition.throttle is None

        def unpack(x: FloatArray) -> tuple[tuple[float, ...], tuple[float, ...]]:
            alpha, phi, de, da, dr, last = (float(one) for one in x)
            throttle = last if level else float(condition.throttle or 0.0)
            climb = 0.0 if level else last
            beta = condition.beta
            # sin(climb) = a sin(theta) - b cos(theta)
            a = math.cos(alpha) * math.cos(beta)
            b = math.sin(phi) * math.sin(beta) + math.cos(phi) * math.sin(alpha) * math.cos(beta)
            theta = math.asin(math.sin(climb) / math.hypot(a, b)) + math.atan2(b, a)
            state = (condition.V, alpha, beta, 0.0, 0.0, 0.0, phi, theta)
            return state, (de, da, dr, condition.flap, throttle)

        def rest(x: FloatArray) -> FloatArray:
            state, controls = unpack(x)
            self.begin(condition.mass, state, controls)
            return np.array([node.get_double_value() for node in self._accelerations])

        x = np.array([0.08, 0.0, -0.02, 0.0, 0.0, 0.4 if level else 0.0])
        for _ in range(20):
            now = rest(x)
            slope = np.empty((6, 6))
            for column in range(6):
                moved = x.copy()
                moved[column] += 1e-4
                slope[:, column] = (rest(moved) - now) / 1e-4
            change = np.linalg.solve(slope, now)
            x = x - np.clip(change, -0.1, 0.1)
            if np.abs(change).max() < 1e-8:
                break
        else:
            raise AssertionError(f"no steady flight at {condition}")
        state, controls = unpack(x)
        return Trim(state=state, controls=controls)

    def look(
        self, mass: float, state: Sequence[float], controls: Sequence[float]
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        self.begin(mass, state, controls)
        rates = np.array([node.get_double_value() for node in self._accelerations])
        rates[:3] *= FOOT
        return rates, self._table([[node.get_double_value() for node in self._recorded]], controls)

    def _table(
        self, rows: list[list[float]], controls: Sequence[float] | FloatArray
    ) -> dict[str, FloatArray]:
        recorded = np.array(rows)
        table = {
            name: recorded[:, column] * unit
            for column, (name, (_, unit)) in enumerate(_RECORDED.items())
        }
        own_mass = self.fdm["inertia/mass-slugs"] * SLUG
        for axis in "xyz":
            table[f"f{axis}"] = table[f"f{axis}"] / own_mass
        u, v, w = table["u"], table["v"], table["w"]
        table["V"] = np.sqrt(u * u + v * v + w * w)
        table["alpha"], table["beta"] = np.arctan2(w, u), np.arcsin(v / table["V"])
        table["time"] = np.arange(len(rows)) / RATE
        moved = np.broadcast_to(np.asarray(controls), (len(rows), len(CONTROLS)))
        table.update({name: moved[:, column] for column, name in enumerate(CONTROLS)})
        return table

    def fly(
        self,
        mass: float,
        state: Sequence[float],
        controls: FloatArray,
        gusts: FloatArray | None = None,
    ) -> dict[str, FloatArray]:
        """Fly control histories and return the truth at 100 Hz, SI.

        Parameters
        ----------
        mass : float
            kg.
        state : sequence of float
            `STATE`, `SETTLING` before the record.
        controls : ndarray, shape (n_steps, 5)
            `CONTROLS` at every step, the settling time included.
        gusts : ndarray, shape (n_steps, 3), optional
            Motion of the air along the first heading, to its right, and down, m/s.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            u, v, w through the air, p, q, r and their rates, specific force fx, fy, fz at the CG,
            attitude, air, V, alpha, beta, controls, time.
        """
        fdm = self.fdm
        self.begin(mass, state, controls[0])
        ahead = round(SETTLING * STEPS_PER_SECOND)
        north = east = down = [0.0] * len(controls)
        if gusts is not None:
            cos, sin = math.cos(HEADING), math.sin(HEADING)
            north = ((cos * gusts[:, 0] - sin * gusts[:, 1]) / FOOT).tolist()
            east = ((sin * gusts[:, 0] + cos * gusts[:, 1]) / FOOT).tolist()
            down = (gusts[:, 2] / FOOT).tolist()
        forget = math.exp(-1.0 / (STEPS_PER_SECOND * MEMORY))
        lagged = self._pitch.get_double_value()
        x = self.stall.settled(state[1], 0.0) if self.stall else 1.0
        rows = []
        for step, row in enumerate(controls.tolist()):
            for node, value in zip(self._controls, row, strict=True):
                node.set_double_value(value)
            if gusts is not None:
                air = (north[step], east[step], down[step])
                for node, value in zip(self._wind, air, strict=True):
                    node.set_double_value(value)
            if self._has_memory:
                lagged = forget * lagged + (1.0 - forget) * self._pitch.get_double_value()
                self._memory.set_double_value(lagged)
            if self.stall:
                x = self._separate(
                    self.stall.moved(x, *(node.get_double_value() for node in self._flow))
                )
            fdm.run()
            if step >= ahead and (step - ahead) % SUBSTEPS == 0:
                rows.append([node.get_double_value() for node in self._recorded])
        return self._table(rows, controls[ahead::SUBSTEPS][: len(rows)])
