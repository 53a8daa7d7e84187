"""The simulator: against the polar equations, on its wheels, in wind, through the stall."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import Atmosphere, DrydenTurbulence, Wind
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.linearization import linearize_lateral, linearize_longitudinal
from gsapp.dynamics.model import Model
from gsapp.dynamics.simulation import ControlCommands, Simulator
from gsapp.dynamics.trim import Trim, trim
from gsapp.foundation import FlightError
from gsapp.virtual.airframe import LandingGear
from tests.dynamics.histories import run_simulation, simulate_open_loop

FT = 0.3048
DEG = math.pi / 180.0


def commands_of(found: Trim, **changes: float) -> ControlCommands:
    c = found.controls
    names = ("de", "da", "dr", "flap", "throttle")
    return ControlCommands(**{**{name: c[name] for name in names}, **changes})


def begin(simulator: Simulator, found: Trim, height: float = 100.0) -> None:
    x = found.polar
    simulator.start_in_air(
        V=x.V, alpha=x.alpha, beta=x.beta, rates=(x.p, x.q, x.r),
        attitude=(x.phi, x.theta, x.psi), height=height, commands=commands_of(found),
    )  # fmt: skip


def trimmed(simulator: Simulator, V: float, **kind: float) -> Trim:
    rho = float(simulator.atmosphere.density(100.0))
    return trim(simulator.model, V=V, rho=rho, mass=simulator.mass, **kind)


def doublet(time: float, start: float, size: float, step: float = 0.5) -> float:
    if start <= time < start + step:
        return size
    return -size if start + step <= time < start + 2 * step else 0.0


def test_trimmed_flight_stays_where_it_is(aircraft: Aircraft, model: Model) -> None:
    simulator = Simulator(aircraft, model)
    found = trimmed(simulator, 29.0)
    begin(simulator, found)
    record = run_simulation(simulator, lambda _: commands_of(found), 5.0)
    # Fuel burns meanwhile: a few millimeters per second.
    assert np.ptp(record["V"]) < 0.02
    assert np.ptp(record["alpha"]) < 1e-3
    assert np.ptp(record["height"]) < 0.1


def test_turn_goes_around(aircraft: Aircraft, model: Model) -> None:
    simulator = Simulator(aircraft, model)
    found = trimmed(simulator, 31.0, bank=40.0 * DEG)
    begin(simulator, found)
    record = run_simulation(simulator, lambda _: commands_of(found), 8.0)
    turned = np.unwrap(record["psi"])[-1]
    assert turned == pytest.approx(8.0 * found.turn_rate, rel=0.01)
    assert np.ptp(record["phi"]) < 2.0 * DEG


def test_simulator_and_polar_equations_agree(aircraft: Aircraft, model: Model) -> None:
    """Body axes and quaternion against the polar form, same inputs, a maneuver on all axes.

    Both integrate with RK4 at 100 Hz; the surfaces come from the simulator's record.
    """
    hidden = model.with_effect("aero.Cm.alphadot").with_effect("aero.Cl.alpha_beta")
    simulator = Simulator(aircraft, hidden, stall=False)
    found = trimmed(simulator, 30.0)
    begin(simulator, found)

    def pilot(s: Simulator) -> ControlCommands:
        t = s.time
        return commands_of(
            found,
            de=found.controls["de"] + doublet(t, 0.5, 0.05),
            da=found.controls["da"] + doublet(t, 1.0, 0.08),
            dr=found.controls["dr"] + doublet(t, 2.0, 0.10),
        )

    record = run_simulation(simulator, pilot, 4.0)
    inputs = {name: record[name] for name in ("de", "da", "dr", "flap", "throttle", "mass")}
    states = simulate_open_loop(
        FlightModel(aircraft, hidden), [float(record[n][0]) for n in
        ("V", "alpha", "beta", "p", "q", "r", "phi", "theta", "psi")],
        {**inputs, "rho": record["density"]}, 0.01,
    )  # fmt: skip
    for column, name in enumerate(("V", "alpha", "beta", "p", "q", "r", "phi", "theta")):
        difference = np.abs(states[:, column] - record[name]).max()
        assert difference < 2e-5 * max(1.0, np.ptp(record[name])), (name, difference)
    assert np.ptp(record["p"]) > 0.5
    assert np.ptp(record["q"]) > 0.2


def test_accelerations_are_the_derivatives_of_the_record(aircraft: Aircraft, model: Model) -> None:
    simulator = Simulator(aircraft, model, wind=Wind(north=-4.0, east=2.0))
    found = trimmed(simulator, 30.0)
    begin(simulator, found)
    record = run_simulation(
        simulator,
        lambda s: commands_of(found, de=0.05 * math.sin(3 * s.time), dr=0.1 * math.sin(4 * s.time)),
        3.0,
    )
    for name in ("V", "alpha", "beta", "p", "q", "r"):
        numeric = (record[name][2:] - record[name][:-2]) / 0.02
        error = np.abs(numeric - record[f"{name}_dot"][1:-1])[5:]
        assert error.max() < 0.02 * np.ptp(record[f"{name}_dot"]) + 1e-4, name


def test_small_motions_follow_the_linear_model(aircraft: Aircraft, model: Model) -> None:
    built = FlightModel(aircraft, model)
    found = trim(built, V=30.0)
    start = np.array(found.state)
    short = linearize_longitudinal(built, found).modes()[0].pole
    dutch = next(m.pole for m in linearize_lateral(built, found).modes() if m.name == "dutch roll")
    for state, pole in ((4, short), (2, dutch)):
        disturbed = start.copy()
        disturbed[state] += 1e-3
        inputs = dict(zip(("de", "da", "dr", "flap", "throttle"), found.inputs, strict=False))
        history = simulate_open_loop(
            built, disturbed.tolist(), {**inputs, "de": np.full(300, inputs["de"])}, 0.01
        )
        moved = history - start
        A = (linearize_longitudinal if state == 4 else linearize_lateral)(built, found)
        columns = [built.state_names.index(name) for name in A.states]
        expected = expm(A.A * 2.99) @ moved[0, columns]
        assert np.allclose(moved[-1, columns], expected, atol=2e-5)
        assert pole.real < 0.0


def test_take_off_and_landing_on_wheels(aircraft: Aircraft, model: Model) -> None:
    """From rest: stands still, rolls, lifts off near the measured 60-73 ft/s, sits down again."""
    gear = LandingGear(aircraft)
    simulator = Simulator(aircraft, model, ground=gear)
    simulator.start_on_ground(height=gear.height, commands=ControlCommands(brake=1.0, throttle=0.0))
    standing = run_simulation(simulator, lambda _: ControlCommands(brake=1.0), 3.0)
    assert standing["on_ground"][-1] == 1.0
    assert abs(standing["ground_speed"][-1]) < 0.02
    assert abs(standing["theta"][-1]) < 5 * DEG

    def take_off(s: Simulator) -> ControlCommands:
        now = s.sample()
        goal = 0.0 if now["V"] < 60 * FT else 9 * DEG
        de = -1.0 * (goal - now["theta"]) + 0.25 * now["q"] if now["V"] > 60 * FT else 0.0
        return ControlCommands(throttle=1.0, de=de, da=-0.8 * now["phi"] - 0.2 * now["p"])

    rolling = run_simulation(simulator, take_off, 14.0)
    lifted = np.flatnonzero((rolling["on_ground"] < 0.5) & (rolling["V"] > 10.0))
    assert lifted.size
    speed = rolling["V"][lifted[0]] / FT
    assert 58.0 < speed < 80.0
    assert rolling["height"][-1] > 5.0

    def land(s: Simulator) -> ControlCommands:
        now = s.sample()
        if now["on_ground"]:
            return ControlCommands(throttle=0.0, brake=1.0)
        sink = -1.2 if now["height"] < 3.0 else -3.0
        goal = 6 * DEG + 0.06 * (sink - now["climb_rate"])
        return ControlCommands(
            throttle=0.25, de=-0.8 * (goal - now["theta"]) + 0.25 * now["q"],
            da=-0.8 * now["phi"] - 0.2 * now["p"],
        )  # fmt: skip

    landing = run_simulation(simulator, land, 40.0)
    assert landing["on_ground"][-1] == 1.0
    assert landing["V"][-1] < 1.0
    assert np.all(np.isfinite(landing["an"]))
    assert abs(landing["theta"][-1]) < 5 * DEG


def test_standing_in_gusty_wind_does_not_blow_up(aircraft: Aircraft, model: Model) -> None:
    gear = LandingGear(aircraft)
    simulator = Simulator(
        aircraft, model, ground=gear, wind=Wind(east=3.0), turbulence=DrydenTurbulence(0.5, seed=2)
    )
    simulator.start_on_ground(height=gear.height, commands=ControlCommands(brake=1.0))
    record = run_simulation(simulator, lambda _: ControlCommands(brake=1.0), 5.0)
    assert np.abs(record["phi"]).max() < 5 * DEG
    assert record["ground_speed"][-1] < 0.3
    assert np.isfinite(np.array(list(record.values()))).all()


def test_wind_drifts_the_aircraft_and_changes_nothing_in_the_air(
    aircraft: Aircraft, model: Model
) -> None:
    still, windy = (Simulator(aircraft, model, wind=w) for w in (Wind(), Wind(north=3.0, east=5.0)))
    found = trimmed(still, 30.0)
    records = []
    for simulator in (still, windy):
        begin(simulator, found)
        records.append(run_simulation(
            simulator, lambda s: commands_of(found, dr=doublet(s.time, 0.2, 0.1)), 3.0
        ))  # fmt: skip
    one, two = records
    for name in ("V", "alpha", "beta", "p", "q", "r", "phi", "ay", "V_dot", "beta_dot"):
        assert np.allclose(one[name], two[name], atol=1e-7), name
    assert two["east"][-1] - one["east"][-1] == pytest.approx(15.0, rel=1e-6)
    assert two["north"][-1] - one["north"][-1] == pytest.approx(9.0, rel=1e-6)


def test_gusts_shake_and_repeat(aircraft: Aircraft, model: Model) -> None:
    def flown(seed: int) -> np.ndarray:
        simulator = Simulator(aircraft, model, turbulence=DrydenTurbulence(0.5, seed=seed))
        found = trimmed(simulator, 30.0)
        begin(simulator, found)
        return run_simulation(simulator, lambda _: commands_of(found), 4.0)["an"]

    one, again, other = flown(1), flown(1), flown(2)
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)
    assert 0.2 < one.std() < 5.0


def test_rotational_gusts_roll_the_aircraft(aircraft: Aircraft, model: Model) -> None:
    """Gusts along the axes alone leave a symmetric aircraft all but level in roll."""

    def rolled(span: float | None) -> dict[str, np.ndarray]:
        air = DrydenTurbulence((0.0, 0.0, 0.5), span=span, seed=3)
        simulator = Simulator(aircraft, model, turbulence=air)
        found = trimmed(simulator, 30.0)
        begin(simulator, found)
        return run_simulation(simulator, lambda _: commands_of(found), 2.0)

    plain, turning = rolled(None), rolled(aircraft.geometry.span)
    assert plain["p"].std() < 1e-6
    assert turning["p"].std() > 0.02
    assert np.allclose(plain["gust_w"], turning["gust_w"], atol=0.01)
    assert turning["gust_q"].std() > 0.01


def test_stall_near_61_feet_per_second(aircraft: Aircraft, model: Model) -> None:
    """Power off, nose held up slowly: the slowest level flight is near the published 61 ft/s."""
    simulator = Simulator(aircraft, model, stall=True)
    extra = simulator.model
    alpha = np.linspace(0.0, 25 * DEG, 400)
    V = 61.0 * FT
    state = (V, alpha, *(0.0,) * 5, alpha, 0.0)
    totals = extra.evaluate(state, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.225, simulator.mass))
    lift = -totals.loads.Z * np.cos(alpha) + totals.loads.X * np.sin(alpha)
    weight = simulator.mass * 9.80665
    slowest = V * math.sqrt(weight / lift.max())
    assert slowest / FT == pytest.approx(61.0, abs=1.5)
    assert 11.0 < alpha[lift.argmax()] / DEG < 16.0


def test_stall_changes_nothing_in_the_linear_range(aircraft: Aircraft, model: Model) -> None:
    def flown(*, stall: bool) -> dict[str, np.ndarray]:
        simulator = Simulator(aircraft, model, stall=stall)
        found = trimmed(simulator, 30.0)
        begin(simulator, found)
        return run_simulation(
            simulator, lambda s: commands_of(found, de=doublet(s.time, 0.2, 0.05)), 2.0
        )

    with_stall, without = flown(stall=True), flown(stall=False)
    low, high = aircraft.limits.alpha_linear
    assert low < with_stall["alpha"].min() < with_stall["alpha"].max() < high
    for name, values in with_stall.items():
        assert np.array_equal(values, without[name]), name


def test_a_held_stall_stays_bounded(aircraft: Aircraft, model: Model) -> None:
    simulator = Simulator(aircraft, model)
    found = trimmed(simulator, 25.0)
    begin(simulator, found, height=400.0)
    record = run_simulation(
        simulator, lambda _: ControlCommands(de=-20 * DEG, da=0.02, throttle=0.3), 10.0
    )
    assert record["alpha"].max() > aircraft.limits.alpha_linear[1]
    assert np.abs(record["q"]).max() < 5.0
    assert record["V"].max() < 60.0


def test_fuel_burns_and_the_engines_stop_without_it(aircraft: Aircraft, model: Model) -> None:
    simulator = Simulator(aircraft, model)
    found = trimmed(simulator, 30.0)
    begin(simulator, found)
    before = simulator.mass
    record = run_simulation(simulator, lambda _: commands_of(found), 2.0)
    burned = before - record["mass"][-1]
    assert burned == pytest.approx(record["fuel"][0] - record["fuel"][-1])
    idle, full = aircraft.mass.fuel_flow_idle, aircraft.mass.fuel_flow_full
    expected = 2.0 * (idle + (full - idle) * found.controls["throttle"])
    assert burned == pytest.approx(expected, rel=1e-3)
    simulator.start_in_air(V=30.0, alpha=0.05, fuel=1e-4, commands=commands_of(found))
    record = run_simulation(simulator, lambda _: commands_of(found), 4.0)
    assert record["fuel"][-1] == 0.0
    assert record["thrust"][-1] < 0.1
    assert record["rpm_left"][-1] < 0.2 * record["rpm_left"][0]


def test_density_counts(aircraft: Aircraft, model: Model) -> None:
    cold, warm = (
        Simulator(aircraft, model, atmosphere=Atmosphere(ground_altitude=h, ground_temperature=t))
        for h, t in ((0.0, 273.15), (1500.0, 308.15))
    )
    for simulator in (cold, warm):
        simulator.start_in_air(V=30.0, alpha=0.06, attitude=(0.0, 0.06, 0.0))
    one, two = cold.sample(), warm.sample()
    assert two["an"] / one["an"] == pytest.approx(two["density"] / one["density"], rel=1e-6)
    assert two["density"] < 0.82 * one["density"]
    assert two["Vc"] < one["Vc"]


def test_servos_lag_and_linkages_play(aircraft: Aircraft, model: Model) -> None:
    simulator = Simulator(
        aircraft, model.with_effect("control.elevator.saturation", {"limit": 0.1})
    )
    found = trimmed(simulator, 30.0)
    begin(simulator, found)
    base = found.controls["de"]
    record = run_simulation(
        simulator, {"de": np.r_[np.full(20, base), np.full(40, 0.2), np.full(60, base)]}
    )
    assert record["de_command"].max() == pytest.approx(0.2)
    assert record["de_servo"].max() == pytest.approx(0.2, rel=1e-3)
    assert record["de"].max() == pytest.approx(0.1)
    control = aircraft.controls.de
    # The servo moves no sooner than its delay, no faster than its limit.
    moved = int(np.argmax(record["de_servo"] > record["de_servo"][0] + 1e-6))
    assert moved * 0.01 >= 0.2 + control.delay
    assert np.abs(np.diff(record["de_servo"])).max() <= control.rate_limit * 0.01 + 1e-12
    assert abs(record["de"][-1] - record["de_servo"][-1]) == pytest.approx(
        0.5 * control.slop, rel=0.1
    )


def test_commands_beyond_the_travel_stop_there(aircraft: Aircraft, model: Model) -> None:
    simulator = Simulator(aircraft, model)
    begin(simulator, trimmed(simulator, 30.0))
    record = run_simulation(simulator, {"dr": np.full(80, 2.0)})
    assert record["dr_servo"].max() == pytest.approx(aircraft.controls.dr.travel[1])


def test_an_unstable_model_is_said_to_be_one(aircraft: Aircraft, model: Model) -> None:
    wild = model.with_derivatives({"Cm_alpha": 30.0, "Cm_q": 500.0, "Cl_p": 50.0})
    simulator = Simulator(aircraft, wild, stall=False)
    simulator.start_in_air(V=30.0, alpha=0.05, rates=(0.1, 0.1, 0.1))
    with pytest.raises(FlightError, match="check the signs"):
        run_simulation(simulator, lambda _: ControlCommands(), 30.0)
