"""Proves that the blind cases are what they say: truth flown by JSBSim, sizes in true sigmas."""

from dataclasses import asdict, replace
from itertools import pairwise

import numpy as np
import pytest

from gsapp.discrepancy.effect_catalog import all_effects
from gsapp.dynamics.effect_terms import StallTerm
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.signal_terms import SignalTerm
from gsapp.dynamics.terms import create_term
from gsapp.quantities import FloatArray
from tests.discrepancy.blind import cases, flying, instruments, sensitivity
from tests.discrepancy.blind.cases import Case, Recording, hidden
from tests.discrepancy.blind.engine import (
    CONTROLS,
    RATE,
    SETTLING,
    STEPS_PER_SECOND,
    Engine,
    Stall,
)
from tests.discrepancy.blind.jsbsim_aircraft import AIR, PROPULSION, STALL
from tests.discrepancy.blind.plan import PLAN, STALL_APPROACHES, Planned

NOTHING = Case(id="nothing", group="nothing")
ELEVATOR, BOTH, THROTTLE, SLIPPING = PLAN[2], PLAN[15], PLAN[8], PLAN[13]
POLAR = ("V", "alpha", "beta", "p", "q", "r", "phi", "theta")


def model_inputs(planned: Planned, motion: dict[str, FloatArray]) -> FloatArray:
    mass = planned.condition(flying.shipped_aircraft()).mass
    names = ("de", "da", "dr", "flap", "throttle")
    still = np.zeros(len(motion["time"]))
    return np.column_stack(
        [*(motion[name] for name in names), still, motion["density"], still + mass]
    )


def fly_ours(model: FlightModel, start: list[float], inputs: FloatArray) -> FloatArray:
    """Integrate our equations by Runge and Kutta at 100 Hz, inputs on straight lines."""

    def rates(state: FloatArray, given: FloatArray) -> FloatArray:
        return np.array([float(one) for one in model.rates(tuple(state), tuple(given))])

    state, dt = np.array(start), 1.0 / RATE
    rows = [state]
    for now, then in pairwise(inputs):
        middle = 0.5 * (now + then)
        a = rates(state, now)
        b = rates(state + 0.5 * dt * a, middle)
        c = rates(state + 0.5 * dt * b, middle)
        d = rates(state + dt * c, then)
        state = state + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        rows.append(state)
    return np.array(rows)


@pytest.mark.parametrize("planned", [ELEVATOR, BOTH], ids=["elevator", "both"])
def test_without_effects_jsbsim_and_our_equations_fly_alike(planned: Planned) -> None:
    """With nothing hidden there is nothing to find: flights agree within 2 % of the noise."""
    motion, _ = flying.fly_motion(NOTHING, planned)
    model = FlightModel(
        flying.shipped_aircraft(), Model(derivatives=flying.true_derivatives(NOTHING.plan))
    )
    inputs = model_inputs(planned, motion)
    flown = fly_ours(model, [*(float(motion[name][0]) for name in POLAR), 0.0], inputs)
    for column, name in enumerate(POLAR):
        size = instruments.NOISE.get(name, 0.1)
        gap = flown[:, column] - motion[name]
        assert np.sqrt(np.mean(gap * gap)) < 0.02 * size, name

    states = np.column_stack([*(motion[name] for name in POLAR), 0.0 * motion["time"]])
    totals = model.evaluate(tuple(states.T), tuple(inputs.T))
    rates = model.rates(tuple(states.T), tuple(inputs.T))
    for index, axis in enumerate("xyz"):
        ours = np.asarray(totals.loads[index]) / inputs[:, 7]
        np.testing.assert_allclose(ours, motion[f"f{axis}"], atol=1e-5)
    for index, axis in enumerate("pqr"):
        np.testing.assert_allclose(np.asarray(rates[3 + index]), motion[f"{axis}_dot"], atol=2e-3)


def flown_with(effect: str) -> Planned:
    if effect.endswith(".stall"):
        return STALL_APPROACHES[0]
    if "flap" in effect:
        return PLAN[14]
    if effect.startswith("propulsion") or effect.endswith(".speed"):
        return THROTTLE
    return SLIPPING


@pytest.mark.parametrize(
    "effect", [one for one in (*AIR, *STALL, *PROPULSION) if not one.startswith("outside")]
)
def test_an_effect_in_jsbsim_is_the_effect_of_that_name_in_the_catalog(effect: str) -> None:
    """Loads that JSBSim flew with the effect hidden fit our equations with that effect added."""
    planned = flown_with(effect)
    motion, _ = flying.fly_motion(hidden(effect), planned)
    aircraft = flying.shipped_aircraft()
    linear = Model(derivatives=flying.true_derivatives(0))
    term = create_term(effect, aircraft)
    name = next(one.name for one in term.parameters if one.free)
    parameters = {**term.defaults, name: cases.typical(effect)}
    if isinstance(term, StallTerm):
        parameters |= asdict(Stall.of_plan(0))
    inputs = model_inputs(planned, motion)
    states = np.column_stack([*(motion[one] for one in POLAR), 0.0 * motion["time"]])
    gaps = []
    reads = {"alpha": motion["alpha"], "V": motion["V"]}
    turned = np.gradient(motion["alpha"], 1.0 / RATE)
    reads["alpha_dot_hat"] = 0.5 * turned * aircraft.geometry.chord / motion["V"]
    own: tuple[FloatArray, ...] = ()
    if term.states:
        read = [reads[one] for one in term.reads]
        own = term.states_along(read, [*parameters.values()], 1.0 / RATE)
    for model, more in ((linear, ()), (linear.with_effect(effect, parameters), own)):
        flight = FlightModel(aircraft, model)
        totals = flight.evaluate((*states.T, *more), tuple(inputs.T))
        rates = flight.rates((*states.T, *more), tuple(inputs.T))
        ours = [*(np.asarray(one) / inputs[:, 7] for one in totals.loads[:3])]
        ours += [np.asarray(one) for one in rates[3:6]]
        theirs = [motion[one] for one in ("fx", "fy", "fz", "p_dot", "q_dot", "r_dot")]
        gaps.append(max(np.abs(a - b).max() for a, b in zip(ours, theirs, strict=True)))
    lacking, complete = gaps
    assert lacking > 0.005
    # JSBSim's rate of the angle of attack is a step old; its engines, when weak, push less on
    # their arm below the CG too.
    loose = {"aero.Cm.alphadot": 0.06, "propulsion.thrust.scale": 0.25}
    assert complete < loose.get(effect, 0.02) * lacking + 1e-3


@pytest.mark.parametrize("effect", [one for one in AIR if one.startswith("outside")])
def test_an_effect_outside_the_catalog_bends_the_flight(effect: str) -> None:
    """It is in no catalog, and JSBSim flies otherwise with it."""
    assert effect not in {one.id for one in all_effects()}
    change = sensitivity.change_by(0, SLIPPING, effect, cases.typical(effect))
    assert np.abs(change).max() > 0.5
    assert np.isfinite(change).all()


@pytest.mark.parametrize("effect", [*cases.SENSOR, *cases.OUTSIDE_SENSOR])
def test_a_faulty_instrument_shows_what_the_catalog_says(effect: str) -> None:
    motion, moved = flying.fly_motion(NOTHING, SLIPPING)
    true = instruments.exposed(flying.shipped_aircraft(), {**motion, **moved})
    seen = instruments.with_faults(true, flying.faults_of(hidden(effect)))
    channels = effect.split(".")[1].split("_")
    assert {name for name in seen if not np.array_equal(seen[name], true[name])} == set(channels)
    if effect.endswith("swapped"):
        assert np.array_equal(seen["p"], true["r"])
        assert np.array_equal(seen["r"], true["p"])
    elif not effect.startswith("outside"):
        term = create_term(effect, flying.shipped_aircraft())
        assert isinstance(term, SignalTerm)
        values = (cases.typical(effect),) if term.parameters else ()
        expected = term.respond(true[channels[0]], 1.0 / RATE, values).values
        reach = np.abs(seen[channels[0]] - true[channels[0]]).max()
        assert np.abs(seen[channels[0]] - expected).max() < 0.05 * reach


@pytest.mark.parametrize("effect", list(cases.CONTROL))
def test_a_fault_of_the_control_path_lies_between_record_and_surface(effect: str) -> None:
    case = hidden(effect)
    (channel, kind), *_ = case.recorded.items()
    condition = BOTH.condition(flying.shipped_aircraft())
    planned = ELEVATOR if channel == "de" else BOTH
    trim = flying.engine_for(()).trim(condition)
    controls, _ = flying.controls_of(case, planned, trim)
    clean, _ = flying.controls_of(NOTHING, planned, trim)
    column = CONTROLS.index(channel)
    term = create_term(effect, flying.shipped_aircraft())
    assert isinstance(term, SignalTerm)
    path = term.respond(clean[:, column], 1.0 / STEPS_PER_SECOND, (cases.typical(effect),))
    moved = np.abs(controls[:, column] - clean[:, column]).max()
    assert moved > 1e-3
    assert np.abs(path.values - controls[:, column]).max() < 0.1 * moved
    others = [k for k in range(len(CONTROLS)) if k != column]
    assert np.array_equal(controls[:, others], clean[:, others])
    control = getattr(flying.aircraft_of(case).controls, channel)
    assert control.kind == kind
    assert (control.lag, control.delay, control.slop) == (0.0, 0.0, 0.0)


def test_trim_is_steady_flight() -> None:
    engine = flying.engine_for(())
    engine.set(flying.true_derivatives(0), {})
    for planned in (PLAN[0], THROTTLE, SLIPPING):
        condition = planned.condition(engine.aircraft)
        trim = engine.trim(condition)
        motion = engine.fly(condition.mass, trim.state, np.tile(trim.controls, (800, 1)))
        assert np.ptp(motion["V"]) < 2e-3
        assert np.abs(motion["q"]).max() < 1e-4


def test_gusts_have_the_size_asked_for() -> None:
    found = flying.dryden(0.3, 30.0, 600 * STEPS_PER_SECOND, (7,))
    assert found[:, 2].std() == pytest.approx(0.3, rel=0.15)
    wide = flying.lengths(0.3)[2]
    assert found[:, :2].std(axis=0) == pytest.approx([wide, wide], rel=0.25)
    # Slow: a tenth of a second changes little.
    assert np.std(np.diff(found[::40, 2])) < 0.15


def test_the_recorder_adds_its_noise_and_no_more() -> None:
    """Noise as asked, white or colored, at 100 or 50 Hz, in steps of the 12-bit converter."""
    motion, moved = flying.fly_motion(NOTHING, ELEVATOR)
    true = instruments.exposed(flying.shipped_aircraft(), {**motion, **moved})
    clean = instruments.recorded(true, np.random.default_rng(0), noise=0.0)
    for noise, colored, rate in ((1.0, False, 100), (2.0, True, 100), (0.5, True, 50)):
        shown = instruments.recorded(
            true, np.random.default_rng(1), noise=noise, colored=colored, rate=rate
        )
        assert len(shown["q"]) == len(clean["q"]) * rate // 100
        for name in ("alpha", "q", "an", "ay"):
            error = (shown[name] - clean[name][:: 100 // rate]) / instruments.NOISE[name]
            assert error.std() == pytest.approx(noise, rel=0.2)
            again = float(np.corrcoef(error[1:], error[:-1])[0, 1])
            expected = {100: 0.7, 50: 0.49}[rate] if colored else 0.0
            assert again == pytest.approx(expected, abs=0.12)
            counts = shown[name] / instruments.STEPS[name]
            np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    bare = instruments.recorded(true, np.random.default_rng(1), attitude=False)
    assert "theta" not in bare
    assert "alpha" in bare


@pytest.mark.long
def test_a_flown_case_is_what_the_program_gets() -> None:
    case = hidden("aero.Cm.alpha2", rate=50, gust=0.3, seed=3)
    one, again = flying.fly_case(case), flying.fly_case(case, PLAN[:2])
    other = flying.fly_case(replace(case, seed=4, gust=0.0), PLAN[:1])
    assert [len(maneuver.block) for maneuver in one.maneuvers] == [500] * 16
    assert {maneuver.flight for maneuver in one.maneuvers} == {"A", "B"}
    for first, second in zip(one.maneuvers[:2], again.maneuvers, strict=True):
        np.testing.assert_allclose(first.block.values, second.block.values, rtol=1e-6, atol=1e-9)
    third = other.maneuvers[0]
    assert not np.array_equal(one.maneuvers[0].block["q"], third.block["q"])
    np.testing.assert_allclose(one.shown["1"]["de"], other.shown["1"]["de"], atol=1e-12)
    assert one.model is None
    assert one.steady["1"]["alpha"] is not one.shown["1"]["alpha"]
    speeds = [float(np.mean(maneuver.block["V"])) for maneuver in one.maneuvers]
    assert min(speeds) < 26.0
    assert max(speeds) > 33.0


def test_baselines_are_fitted_given_or_wrong() -> None:
    truth = flying.true_derivatives(2)
    wrong = flying.baseline_of(replace(NOTHING, plan=2, baseline="wrong"))
    for name, value in truth.items():
        if value:
            assert 0.0999 < abs(wrong.derivative(name) / value - 1.0) < 0.2001
    lacking = flying.baseline_of(hidden("aero.Cl.dr", baseline="given"))
    assert lacking.derivative("Cl_dr") == 0.0
    assert lacking.derivative("Cl_da") == flying.true_derivatives(0)["Cl_da"]


def test_the_benchmark_holds_what_was_asked_for() -> None:
    found = cases.all_cases()
    names = {one.id for one in all_effects()}
    by_group = {
        group: [one for one in found if one.group == group]
        for group in ("hidden", "nothing", "outside", "pair")
    }
    sized = [kind for kind in cases.KINDS if not kind.endswith(cases.WHOLE)]
    assert len(sized) >= 30
    assert len(by_group["hidden"]) == 5 * (3 * len(sized) + len(cases.KINDS) - len(sized))
    assert [len(by_group[one]) for one in ("nothing", "outside", "pair")] == [600, 120, 110]
    assert len({one.id for one in found}) == len(found)
    for case in by_group["hidden"] + by_group["pair"]:
        assert set(case.effects) <= names
        assert all(set(group) <= names for group in case.accepted)
    assert not {one for case in by_group["outside"] for one in case.effects} & names
    assert {(one.noise, one.colored, one.rate) for one in found} >= {
        (1.0, False, 100), (0.5, True, 100), (2.0, False, 50),
    }  # fmt: skip
    assert not {one.plan for one in found} & {one.plan for one in cases.all_cases("tune")}
    quick = cases.tenth(found)
    assert {one.kind for one in quick} == {one.kind for one in found}
    assert len(quick) < 0.12 * len(found)


@pytest.mark.parametrize("effect", ["aero.Cm.alphadot", "propulsion.Cm.throttle"])
def test_the_virtual_aircraft_flies_the_same_cases(effect: str) -> None:
    """Flown by our equations, a case is the one that JSBSim flies, within a tenth of the noise."""
    theirs, _ = flying.fly_motion(hidden(effect), THROTTLE)
    ours, _ = flying.fly_motion(hidden(effect, by="virtual"), THROTTLE)
    for name in ("alpha", "q", "theta", "fz"):
        gap = ours[name] - theirs[name]
        size = instruments.NOISE.get(name, 0.05)
        assert np.sqrt(np.mean(gap * gap)) < 0.1 * size, name


PAIR = (ELEVATOR, THROTTLE)


@pytest.fixture(scope="module")
def baseline() -> tuple[FloatArray, ...]:
    return tuple(sensitivity.baseline_change(0, planned) for planned in PAIR)


def shows(
    baseline: tuple[FloatArray, ...], columns: list[FloatArray], air: Recording
) -> FloatArray:
    parts = sensitivity.whitened(0, PAIR, baseline, columns, air)
    names = [str(k) for k in range(columns[0].shape[2])]
    return sensitivity.remaining(sensitivity.gram(parts), names, maneuvers=PAIR)


@pytest.mark.long
def test_sigmas_are_true_by_monte_carlo(baseline: tuple[FloatArray, ...]) -> None:
    """An effect of ten sigma, estimated from 4 noisy records, is found as ten with spread one.

    Records hold noise of instruments, of surface pots and gusts; what the baseline predicts is
    flown by JSBSim with the measured deflections. The estimate is the best there is.
    """
    effect, air, small = "propulsion.Cm.throttle", Recording(gust=0.1), 1e-3
    unit = [sensitivity.change_by(0, one, effect, small)[:, :, None] for one in PAIR]
    size = small * 10.0 / float(shows(baseline, unit, air)[0, 0]) ** 0.5
    found = []
    for seed in range(4):
        case = hidden(effect, size, seed=seed, gust=air.gust)
        columns = []
        for planned, one in zip(PAIR, unit, strict=True):
            residual = noisy_residual(case, planned)
            columns.append(np.concatenate([one * size / small, residual[:, :, None]], axis=2))
        products = shows(baseline, columns, air)
        found.append(float(products[0, 1] / products[0, 0]) * 10.0)
    assert np.mean(found) == pytest.approx(10.0, abs=1.6)
    assert np.std(found, ddof=1) == pytest.approx(1.0, abs=0.9)


def noisy_residual(case: Case, planned: Planned) -> FloatArray:
    """Return record minus prediction without the effect, from measured inputs, scaled."""
    motion, moved = flying.fly_motion(case, planned)
    aircraft = flying.shipped_aircraft()
    true = instruments.exposed(aircraft, {**motion, **moved})
    record = instruments.recorded(true, np.random.default_rng([case.seed, int(planned.id)]))
    engine = flying.engine_for(tuple(case.effects))
    engine.set(flying.truth_of(case), case.effects)
    condition = planned.condition(aircraft)
    trim = engine.trim(condition)
    controls, _ = flying.controls_of(case, planned, trim)
    times = np.arange(len(controls)) / STEPS_PER_SECOND - SETTLING
    for column, name in enumerate(("de", "da", "dr")):
        error = np.interp(times, motion["time"], record[name] - true[name])
        controls[:, column] += np.where(times >= 0.0, error, 0.0)
    engine = flying.engine_for(())
    engine.set(flying.true_derivatives(case.plan), {})
    predicted = instruments.exposed(aircraft, engine.fly(condition.mass, trim.state, controls))
    return np.column_stack(
        [(record[one] - predicted[one]) / instruments.NOISE[one] for one in sensitivity.CHANNELS]
    )


@pytest.mark.parametrize(
    "effect", ["propulsion.Cm.throttle", "aero.CX.speed", "sensor.alpha.scale"]
)
def test_sizes_scale_with_sigmas(baseline: tuple[FloatArray, ...], effect: str) -> None:
    rest = cases.neutral(effect)
    away = 0.05 * (cases.typical(effect) - rest)
    base = float(
        shows(
            baseline,
            [sensitivity.change_by(0, one, effect, rest + away)[:, :, None] for one in PAIR],
            Recording(),
        )[0, 0]
    )
    for sigma in (3.0, 10.0):
        size = rest + away * sigma / base**0.5
        columns = [sensitivity.change_by(0, one, effect, size)[:, :, None] for one in PAIR]
        assert float(shows(baseline, columns, Recording())[0, 0]) ** 0.5 == pytest.approx(
            sigma, rel=0.12
        )


def test_a_derivative_shows_nothing_beyond_itself(baseline: tuple[FloatArray, ...]) -> None:
    columns = [one[:, :, 2:3] for one in baseline]
    assert float(shows(baseline, columns, Recording())[0, 0]) < 1e-3


@pytest.mark.skipif(not sensitivity.has_table(), reason="the table of sizes was not made")
def test_the_table_of_sizes_is_up_to_date() -> None:
    """Every case of the benchmark finds its size in the table beside the cases."""
    for case in cases.all_cases():
        if case.sigma:
            assert sensitivity.in_table(case.plan, case.recording), case.id


@pytest.mark.parametrize("airframe", cases.AIRFRAMES)
def test_a_bend_over_alpha_and_beta_is_one_of_the_aircraft_if_jsbsim_flies_it(
    airframe: str,
) -> None:
    """The lateral coefficients' mixed derivative by alpha and beta, from JSBSim's own forces.

    A hundredth of the 0.5 to 1 that are hidden elsewhere parts what is there from rounding.
    """
    aircraft = flying.shipped_aircraft()
    engine = Engine(aircraft, airframe=airframe)
    fdm, alpha, step = engine.fdm, 0.08, 0.04

    def coefficients(alpha: float, beta: float) -> FloatArray:
        state = (29.0, alpha, beta, 0.0, 0.0, 0.0, 0.0, alpha)
        engine.begin(aircraft.mass.mass, state, (0.0,) * len(CONTROLS))
        force = fdm["aero/qbar-psf"] * fdm["metrics/Sw-sqft"]
        moment = force * fdm["metrics/bw-ft"]
        return np.array(
            [
                fdm["forces/fby-aero-lbs"] / force,
                fdm["moments/l-aero-lbsft"] / moment,
                fdm["moments/n-aero-lbsft"] / moment,
            ]
        )

    corners = [
        up * right * coefficients(alpha + up * step, right * step)
        for up in (1.0, -1.0)
        for right in (1.0, -1.0)
    ]
    mixed = np.sum(corners, axis=0) / (2.0 * step) ** 2
    for name, value in zip(("CY", "Cl", "Cn"), mixed, strict=True):
        assert (abs(value) > 0.01) == (f"aero.{name}.alpha_beta" in cases.AIRFRAMES[airframe])
