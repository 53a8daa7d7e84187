"""Engines: thrust, the lag from lever to thrust (any first-order lag), fan speed, fuel.

thrust = max_thrust * throttle * rho/rho0 * (1 - V/zero_thrust_speed) along x, shared equally
among the engines; each acts at its own position. The equations get the throttle *as the engines
follow it*; `Engines` supplies it.
"""

from __future__ import annotations

import math
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.arithmetic import Value, array_namespace
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.settings import SIMULATION
from gsapp.quantities import FloatArray


def thrust(aircraft: Aircraft, throttle: Value, rho: Value, V: Value) -> Value:
    """Return the thrust of all engines (N) for the throttle that they follow."""
    engine = aircraft.propulsion
    return (
        engine.max_thrust
        * throttle
        * (rho / SEA_LEVEL_DENSITY)
        * (1.0 - V / engine.zero_thrust_speed)
    )


def throttle_for(aircraft: Aircraft, thrust: Value, rho: Value, V: Value) -> Value:
    """Return the throttle that gives a thrust (N): lets a measured thrust stand in for it."""
    engine = aircraft.propulsion
    full = engine.max_thrust * (rho / SEA_LEVEL_DENSITY) * (1.0 - V / engine.zero_thrust_speed)
    return thrust / full


def fan_speed(aircraft: Aircraft, throttle: Value) -> Value:
    """Return the fan speed (rad/s): thrust goes with its square, between idle and full."""
    idle, full = aircraft.propulsion.rpm_idle, aircraft.propulsion.rpm_full
    root = array_namespace(throttle).sqrt
    return root(idle * idle + (full * full - idle * idle) * throttle)  # type: ignore[no-any-return]


class EngineState(NamedTuple):
    """What the engines do now."""

    throttle: float
    difference: float
    """As followed: mean of left and right, and half of left minus right."""
    left: float
    right: float
    """As followed, 0 to 1."""
    rpm_left: float
    rpm_right: float
    """Fan speed, rad/s."""
    fuel_flow: float  # kg/s.


class Engines:
    """The engines of one aircraft, stepped every `dt` s; first settled at `throttle`."""

    def __init__(
        self, aircraft: Aircraft, dt: float, *, throttle: float = 0.0, running: bool = True
    ) -> None:
        self._aircraft = aircraft
        lag = aircraft.propulsion.lag
        self._share = 1.0 - math.exp(-dt / lag) if lag > 0.0 else 1.0
        self._stopping = math.exp(-dt / SIMULATION.spool_down_time)
        self._left = self._right = throttle if running else 0.0
        self._spin = 1.0 if running else 0.0
        self._running = running

    def step(self, left: float, right: float, *, running: bool = True) -> EngineState:
        """Follow the throttle levers (0 to 1) for one sample."""
        self._running = running
        left = min(max(left, 0.0), 1.0) if running else 0.0
        right = min(max(right, 0.0), 1.0) if running else 0.0
        self._left += self._share * (left - self._left)
        self._right += self._share * (right - self._right)
        goal = 1.0 if running else 0.0
        self._spin = goal + self._stopping * (self._spin - goal)
        return self.state

    @property
    def state(self) -> EngineState:
        left, right = self._left, self._right
        mean = 0.5 * (left + right)
        mass = self._aircraft.mass
        flow = mass.fuel_flow_idle + (mass.fuel_flow_full - mass.fuel_flow_idle) * mean
        return EngineState(
            throttle=mean,
            difference=0.5 * (left - right),
            left=left,
            right=right,
            rpm_left=self._spin * float(fan_speed(self._aircraft, left)),
            rpm_right=self._spin * float(fan_speed(self._aircraft, right)),
            fuel_flow=flow if self._running else 0.0,
        )


def filter_first_order(inputs: FloatArray, decay: float, before: float) -> FloatArray:
    """Return what follows inputs, shape (n,), that are held between the samples, with a lag.

    ``(1 - decay) * input + decay * output before`` at every sample, with `before` one sample before
    the first; `decay` is exp(-dt / tau), what is left of a step after one sample. Number by number:
    a filter by SciPy would load a package that takes a third of a second, which a window waits for
    before its charts stand.
    """
    steps = ((1.0 - decay) * inputs).tolist()
    outputs = accumulate(steps, lambda output, step: step + decay * output, initial=before)
    next(outputs)
    return np.fromiter(outputs, np.float64, len(steps))
