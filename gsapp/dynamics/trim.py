"""Steady flight: level, climbing, turning. And what makes an aircraft unflyable, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.equations import PolarState, polar_rates
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.quantities import SURFACE_NAMES, FloatArray
from gsapp.quantities.constants import DEGREE, GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class Trim:
    """A steady condition."""

    state: tuple[float, ...]  # Polar states, then those of the terms, settled; psi = 0.
    inputs: tuple[float, ...]  # In the order of `gsapp.dynamics.flight_model.MODEL_INPUTS`.
    climb_angle: float  # rad.
    turn_rate: float  # psi', rad/s.

    @property
    def polar(self) -> PolarState:
        return PolarState(*self.state[:9])

    @property
    def controls(self) -> dict[str, float]:
        return dict(zip(MODEL_INPUTS, self.inputs, strict=True))


def trim(
    model: FlightModel,
    *,
    V: float,
    climb_angle: float = 0.0,
    bank: float = 0.0,
    rho: float = SEA_LEVEL_DENSITY,
    mass: float | None = None,
    flap: float = 0.0,
) -> Trim:
    """Return the controls and attitude of steady straight flight or of a coordinated turn.

    Raise FlightError if the aircraft cannot fly so; the sentence names what is wrong.

    Parameters
    ----------
    V, climb_angle : float
        True airspeed, m/s; rad.
    bank : float
        rad; zero is straight flight without sideslip (the wings may lean a little if the model
        is not symmetric), anything else a turn with the ball in the middle. Without a rudder
        (`has_rudder`) it flies with what sideslip there is.
    rho, mass, flap : float
        Air density (kg/m^3), mass (kg; the aircraft file's by default), flap (rad).
    """
    problems = find_unflyable_reasons(model.aircraft, model.model)
    if problems:
        raise FlightError(f"the model '{model.model.name}' cannot be flown: {'; '.join(problems)}")
    heavy = model.aircraft.mass.mass if mass is None else mass
    turning = bank != 0.0
    steered = has_rudder(model.model)

    def condition(x: FloatArray) -> tuple[tuple[float, ...], tuple[float, ...], float]:
        alpha, de, da, yaw, throttle, theta, free, turn = (float(value) for value in x)
        phi, beta = (bank, free) if turning else (free, 0.0)
        dr = yaw
        if not steered and not turning:
            beta, dr = yaw, 0.0
        state = (
            V,
            alpha,
            beta,
            -turn * math.sin(theta),
            turn * math.sin(phi) * math.cos(theta),
            turn * math.cos(phi) * math.cos(theta),
            phi,
            theta,
            0.0,
        )
        inputs = (de, da, dr, flap, throttle, 0.0, rho, heavy)
        return (*state, *(float(s) for s in model.steady_states(state, inputs))), inputs, turn

    def residual(x: FloatArray) -> FloatArray:
        state, inputs, turn = condition(x)
        totals = model.evaluate(state, inputs)
        rates = polar_rates(PolarState(*state[:9]), totals.loads, totals.body)
        climb = math.sin(_climb_angle(state)) - math.sin(climb_angle)
        ball = totals.loads.Y / (heavy * GRAVITY) if steered else inputs[2]
        last = ball if turning else turn
        return np.array([*rates[:6], climb, last], dtype=float)

    turn = GRAVITY * math.tan(bank) / V
    lift = heavy * GRAVITY / (0.5 * rho * V * V * model.area * math.cos(bank))
    slope = model.model.derivative("CN_alpha")
    alpha = min(max((lift - model.model.derivative("CN_0")) / slope, -0.2), 0.4)
    start = np.array([alpha, 0.0, 0.0, 0.0, 0.5, alpha + climb_angle, 0.0, turn])
    from scipy.optimize import root  # a fifth of a second

    solution = root(residual, start, method="hybr", tol=1e-12)
    worst = float(np.max(np.abs(residual(solution.x))))
    if not worst < 1e-7:
        raise FlightError(_no_solution(model, V, worst))
    state, inputs, turn_rate = condition(solution.x)
    _check_limits(model, state, inputs)
    return Trim(state=state, inputs=inputs, climb_angle=climb_angle, turn_rate=turn_rate)


def _climb_angle(state: Sequence[float]) -> float:
    _, alpha, beta, _, _, _, phi, theta = state[:8]
    ca, cb, sa, sb = math.cos(alpha), math.cos(beta), math.sin(alpha), math.sin(beta)
    up = ca * cb * math.sin(theta) - (sb * math.sin(phi) + sa * cb * math.cos(phi)) * math.cos(
        theta
    )
    return math.asin(min(1.0, max(-1.0, up)))


def has_rudder(model: Model) -> bool:
    """Return whether the rudder of a model does anything; a flying wing has none."""
    return any(model.derivative(name) != 0.0 for name in ("CY_dr", "Cl_dr", "Cn_dr"))


def find_unflyable_reasons(aircraft: Aircraft, model: Model) -> list[str]:
    """Return what makes it impossible to fly a model, one sentence part each; none if it flies.

    Only the signs and absences that no aircraft of the usual layout can have are named.
    """
    found = []
    if aircraft.propulsion.max_thrust <= 0.0:
        found.append("no thrust (set propulsion.max_thrust in the aircraft file)")
    rules = (
        ("CN_alpha", 1, "the wing must lift more with more angle of attack"),
        ("Cm_de", -1, "elevator trailing edge down must pitch the nose down"),
        ("Cl_da", 1, "positive aileron must roll the right wing down"),
        ("Cn_dr", -1, "rudder trailing edge left must turn the nose left"),
    )
    for name, sign, why in rules:
        value = model.derivative(name)
        if name == "Cn_dr" and not has_rudder(model):
            continue
        if value == 0.0:
            found.append(f"{name} is zero or missing ({why})")
        elif value * sign < 0.0:
            found.append(
                f"{name} = {value:g} appears reversed ({why}, so it is "
                f"{'positive' if sign > 0 else 'negative'})"
            )
    return found


def find_suspect_signs(model: Model) -> list[str]:
    """Return derivatives whose sign makes an aircraft unstable or undamped, in words.

    Such an aircraft can be trimmed; a pilot will hardly hold it.
    """
    rules = (
        ("Cm_alpha", -1, "the nose does not return after a gust"),
        ("Cm_q", -1, "pitching is not damped"),
        ("Cl_p", -1, "rolling is not damped"),
        ("Cn_r", -1, "yawing is not damped"),
        ("Cn_beta", 1, "the nose turns away from the wind"),
        ("CY_beta", -1, "sideslip pushes into the wind"),
    )
    return [
        f"{name} = {model.derivative(name):g} appears reversed: {what}"
        for name, sign, what in rules
        if model.derivative(name) * sign < 0.0
    ]


def _no_solution(model: FlightModel, V: float, worst: float) -> str:
    doubts = find_suspect_signs(model.model)
    hint = f"; {doubts[0]}" if doubts else "; check the derivatives and the speed"
    return (
        f"no steady flight was found for '{model.model.name}' at {V:.1f} m/s (an acceleration "
        f"of {worst:.2g} remains){hint}"
    )


def _check_limits(model: FlightModel, state: Sequence[float], inputs: Sequence[float]) -> None:
    aircraft = model.aircraft
    controls = dict(zip(MODEL_INPUTS, inputs, strict=True))
    V = state[0]
    found = []
    if state[1] > aircraft.limits.alpha_stall:
        found.append(
            f"it needs an angle of attack of {state[1] / DEGREE:.1f} deg, beyond the stall: "
            "fly faster or lighter"
        )
    throttle = controls["throttle"]
    if throttle > 1.0:
        found.append(
            f"it needs {100.0 * throttle:.0f} % throttle: the thrust is too small or CA too large"
        )
    elif throttle < 0.0:
        found.append(
            f"it needs negative throttle ({100.0 * throttle:.0f} %): the descent is too steep, "
            "or CA is too small"
        )
    for name, surface in SURFACE_NAMES.items():
        low, high = getattr(aircraft.controls, name).travel
        if not low <= controls[name] <= high:
            found.append(
                f"it needs {controls[name] / DEGREE:.1f} deg of {surface}, beyond its travel: "
                f"check the signs and sizes of the moments, and the CG"
            )
    if found:
        raise FlightError(
            f"'{model.model.name}' cannot be flown steadily at {V:.1f} m/s: {'; '.join(found)}"
        )
