"""Engines: the formula of the design, lag, fan speed."""

import numpy as np
import pytest

from gsapp.aircraft import Aircraft
from gsapp.dynamics.propulsion import Engines, fan_speed, throttle_for, thrust

FT = 0.3048
LBF = 4.4482216152605
RPM = 2.0 * np.pi / 60.0


def test_thrust_of_the_design(aircraft: Aircraft) -> None:
    assert thrust(aircraft, 1.0, 1.225, 0.0) == pytest.approx(24.0 * LBF)
    assert thrust(aircraft, 0.5, 1.1, 100 * FT) == pytest.approx(
        24.0 * LBF * 0.5 * (1.1 / 1.225) * (1.0 - 100.0 / 250.0)
    )


def test_throttle_from_a_measured_thrust(aircraft: Aircraft) -> None:
    throttle = np.array([0.1, 0.6, 1.0])
    force = thrust(aircraft, throttle, 1.1, 30.0)
    assert np.allclose(throttle_for(aircraft, force, 1.1, 30.0), throttle)


def test_fan_speed_between_idle_and_full(aircraft: Aircraft) -> None:
    assert fan_speed(aircraft, 0.0) / RPM == pytest.approx(7000.0)
    assert fan_speed(aircraft, 1.0) / RPM == pytest.approx(19000.0)
    speeds = fan_speed(aircraft, np.linspace(0.0, 1.0, 11))
    assert np.all(np.diff(speeds) > 0.0)


def test_engines_follow_the_lever_with_their_lag(aircraft: Aircraft) -> None:
    engines = Engines(aircraft, 0.01)
    steps = round(aircraft.propulsion.lag / 0.01)
    for _ in range(steps):
        state = engines.step(1.0, 1.0)
    assert state.throttle == pytest.approx(1.0 - np.exp(-1.0), abs=1e-9)
    assert state.difference == pytest.approx(0.0)


def test_engines_may_differ(aircraft: Aircraft) -> None:
    engines = Engines(aircraft, 0.01)
    for _ in range(500):
        state = engines.step(0.8, 0.4)
    assert (state.throttle, state.difference) == pytest.approx((0.6, 0.2), abs=1e-4)
    assert state.rpm_left > state.rpm_right


def test_stopped_engines_run_down_and_burn_nothing(aircraft: Aircraft) -> None:
    engines = Engines(aircraft, 0.01, throttle=0.5)
    assert engines.state.fuel_flow > aircraft.mass.fuel_flow_idle
    for _ in range(1000):
        state = engines.step(0.5, 0.5, running=False)
    assert state.fuel_flow == 0.0
    assert state.rpm_left < 10.0 * RPM
    assert state.throttle < 1e-6
