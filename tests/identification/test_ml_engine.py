"""The fast engine: kernels, trajectories and sensitivities against slower ways to the same."""

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.model import load_model
from gsapp.dynamics.trim import trim
from gsapp.identification.axes import AXIS_RESPONSES, AXIS_STATES, axis_derivatives
from gsapp.identification.maximum_likelihood.axis_kernels import build_axis_kernel
from gsapp.identification.maximum_likelihood.kernels import GeneralKernel
from gsapp.identification.maximum_likelihood.problem import shift_samples
from gsapp.identification.maximum_likelihood.trajectory_solver import (
    TrajectorySolver,
    build_segment_forcing,
)
from tests.dynamics.histories import input_columns, simulate_open_loop

DT = 0.02
COUNT = 300
AIRCRAFT = load_aircraft("b777")
EFFECTS = {
    "lon": ("aero.Cm.alpha2", "aero.CN.alpha2", "aero.CX.speed", "propulsion.Cm.throttle"),
    "lat": ("aero.Cl.alpha_beta", "aero.Cn.beta3", "aero.Cl.da3", "propulsion.Cn.asymmetry"),
}


def motion_of(model):
    start = trim(model, V=30.0)
    times = DT * np.arange(COUNT)
    inputs = {name: np.full(COUNT, value) for name, value in start.controls.items()}
    inputs["de"] = inputs["de"] + 0.05 * np.sin(3.0 * times) * (times > 0.5)
    inputs["da"] = inputs["da"] + 0.06 * np.sin(4.0 * times + 1.0)
    inputs["dr"] = inputs["dr"] + 0.08 * np.sin(2.0 * times)
    inputs["throttle_difference"] = np.full(COUNT, 0.05)
    states = simulate_open_loop(model, start.state, inputs, DT)
    return states.T.copy(), np.array(input_columns(model, inputs))


ATTITUDE = {"lon": ("theta",), "lat": ("phi",), "both": ()}


def kernels_for(axis, effects=(), attitude=()):
    base = load_model("b777")
    for effect in effects:
        base = base.with_effect(effect)
    model = FlightModel(AIRCRAFT, base)
    added = {
        f"{term.id}.{item.name}"
        for term, _ in model.terms
        if term.id in effects
        for item in term.parameters
        if item.free
    }
    wanted = {*axis_derivatives(axis), *added}
    free = tuple(name for name in model.parameter_names if name in wanted)
    states = (*AXIS_STATES[axis], *attitude)
    general = GeneralKernel(model, states, AXIS_RESPONSES[axis], free)
    return model, general, build_axis_kernel(model, axis, states, AXIS_RESPONSES[axis], free)


@pytest.mark.parametrize("axis", ["lon", "lat"])
@pytest.mark.parametrize("with_effects", [False, True])
@pytest.mark.parametrize("with_attitude", [False, True])
def test_the_written_out_kernels_are_the_general_one(axis, with_effects, with_attitude):
    attitude = ATTITUDE[axis] if with_attitude else ()
    model, general, lean = kernels_for(axis, EFFECTS[axis] if with_effects else (), attitude)
    assert lean is not None
    states, inputs = motion_of(model)
    values = np.array(model.defaults)
    rows = [POLAR_STATES.index(name) for name in (*AXIS_STATES[axis], *attitude)]
    found = []
    for kernel in (general, lean):
        engine = TrajectorySolver(kernel, "rk4")
        drives = build_segment_forcing(kernel, states, inputs, None, values)
        x = engine.trajectory(drives, DT, values, states[rows, 0], states[rows])
        S, _ = engine.sensitivities(drives, DT, values, x, np.eye(len(rows)))
        y, dy = kernel.output_sensitivities(drives.samples, x, values, S)
        np.testing.assert_allclose(y, kernel.outputs(drives.samples, x, values), rtol=1e-13)
        found.append((x, S, y, dy))
    for one, other in zip(*found, strict=True):
        assert np.abs(one - other).max() < 1e-12 * np.abs(one).max()


def test_cases_that_only_the_general_kernel_covers_are_left_to_it():
    for effect in ("aero.CN.memory", "aero.Cm.alphadot", "mass.cg.x"):
        assert kernels_for("lon", (effect,))[2] is None
    model = kernels_for("lon")[0]
    free = axis_derivatives("lon")
    assert build_axis_kernel(model, "lon", ("V", "alpha", "q"), AXIS_RESPONSES["lon"], free) is None
    assert build_axis_kernel(model, "lon", AXIS_STATES["lon"], ("alpha", "V"), free) is None
    assert (
        build_axis_kernel(model, "both", AXIS_STATES["both"], AXIS_RESPONSES["both"], free) is None
    )
    assert (
        build_axis_kernel(model, "lat", AXIS_STATES["lat"], AXIS_RESPONSES["lat"], ("CN_alpha",))
        is None
    )


@pytest.mark.parametrize("integration", ["rk4", "euler"])
@pytest.mark.parametrize("axis", ["lon", "lat", "both"])
def test_all_samples_at_once_give_what_stepping_through_time_gives(axis, integration):
    model, general, lean = kernels_for(axis)
    kernel = lean or general
    states, inputs = motion_of(model)
    values = np.array(model.defaults)
    rows = [POLAR_STATES.index(name) for name in AXIS_STATES[axis]]
    engine = TrajectorySolver(kernel, integration)
    drives = build_segment_forcing(kernel, states, inputs, None, values)
    guess = states[rows] + 0.02 * np.random.default_rng(0).standard_normal((len(rows), COUNT))
    x = engine.trajectory(drives, DT, values, states[rows, 0], guess)
    stepped = engine._in_sequence(drives, DT, values, states[rows, 0])
    assert np.abs(x - stepped).max() < 1e-9
    # Slopes of another point near by, where exact ones are dear.
    other = 1.03 * values
    moved = engine.trajectory(drives, DT, other, states[rows, 0], x)
    _, Phi = engine.sensitivities(drives, DT, other, moved, np.zeros((len(rows), 0)))
    again = engine.trajectory(drives, DT, values, states[rows, 0], moved, Phi=Phi)
    assert np.abs(again - stepped).max() < 1e-9
    if axis == "both" and integration == "rk4":
        # All states are computed: this is the open-loop simulation itself.
        assert np.abs(x - states[rows]).max() < 1e-9


@pytest.mark.parametrize("axis", ["lon", "lat"])
def test_sensitivities_are_the_derivatives_of_the_discretized_motion(axis):
    """Central differences of whole trajectories agree, by parameters and initial states."""
    model, _, kernel = kernels_for(axis, EFFECTS[axis])
    states, inputs = motion_of(model)
    values = np.array(model.defaults)
    rows = [POLAR_STATES.index(name) for name in AXIS_STATES[axis]]
    start = states[rows, 0]
    engine = TrajectorySolver(kernel, "rk4")
    drives = build_segment_forcing(kernel, states, inputs, None, values)
    x = engine.trajectory(drives, DT, values, start, states[rows])
    S, _ = engine.sensitivities(drives, DT, values, x, np.eye(len(rows)))
    _, dy = kernel.output_sensitivities(drives.samples, x, values, S)

    def responses(values, start):
        moved = engine.trajectory(drives, DT, values, start, x)
        return kernel.outputs(drives.samples, moved, values)

    for column, name in enumerate(kernel.free):
        index = model.parameter_names.index(name)
        step = 1e-4 * max(1.0, abs(values[index]))
        up, down = values.copy(), values.copy()
        up[index] += step
        down[index] -= step
        numeric = (responses(up, start) - responses(down, start)) / (2.0 * step)
        assert np.abs(dy[:, column] - numeric).max() < 2e-5 * np.abs(numeric).max() + 1e-7, name
    for column in range(len(rows)):
        step = 1e-4 * np.eye(len(rows))[column]
        numeric = (responses(values, start + step) - responses(values, start - step)) / 2e-4
        assert np.abs(dy[:, len(kernel.free) + column] - numeric).max() < 1e-5 * max(
            1.0, np.abs(numeric).max()
        )


def test_an_explosive_model_is_recognized():
    model, _, kernel = kernels_for("lon")
    states, inputs = motion_of(model)
    values = np.array(model.defaults)
    values[model.parameter_names.index("Cm_q")] = 2000.0
    engine = TrajectorySolver(kernel, "rk4")
    drives = build_segment_forcing(kernel, states, inputs, None, values)
    start = states[[1, 4], 0]
    assert engine.trajectory(drives, DT, values, start, states[[1, 4]]) is None
    assert engine.trajectory(drives, DT, values, start, states[[1, 4]], at_any_rate=True) is None


def test_control_path_derivatives_come_through_the_inputs():
    model = FlightModel(AIRCRAFT, load_model("b777"))
    states, inputs = motion_of(model)
    values = np.array(model.defaults)
    kernel = GeneralKernel(model, AXIS_STATES["lon"], AXIS_RESPONSES["lon"], (), ("gearing",))
    engine = TrajectorySolver(kernel, "rk4")
    by_path = np.zeros((3, 1, COUNT))
    by_path[0, 0] = inputs[MODEL_INPUTS.index("de")]
    start = states[[1, 4], 0]

    def drives_for(gearing):
        driven = inputs.copy()
        driven[0] *= gearing
        return build_segment_forcing(kernel, states, driven, by_path, values)

    def responses(gearing):
        drives = drives_for(gearing)
        x = engine.trajectory(drives, DT, values, start, states[[1, 4]])
        return kernel.outputs(drives.samples, x, values)

    drives = drives_for(1.0)
    x = engine.trajectory(drives, DT, values, start, states[[1, 4]])
    S, _ = engine.sensitivities(drives, DT, values, x, np.zeros((2, 0)))
    _, dy = kernel.output_sensitivities(drives.samples, x, values, S)
    numeric = (responses(1.0 + 1e-4) - responses(1.0 - 1e-4)) / 2e-4
    assert np.abs(dy[:, 0] - numeric).max() < 1e-6 * np.abs(numeric).max()


@pytest.mark.parametrize("samples", [-3.7, -0.2, 0.0, 0.5, 2.0, 6.3])
def test_a_time_shift_is_exact_for_parabolas_and_knows_its_slope(samples):
    k = np.arange(60.0)
    signal = np.array([0.3 * k * k - 2.0 * k + 1.0, np.sin(0.2 * k)])
    moved, slope = shift_samples(signal, samples)
    inside = slice(10, 50)
    late = k - samples
    assert np.allclose(moved[0, inside], (0.3 * late * late - 2.0 * late + 1.0)[inside])
    assert np.allclose(moved[1, inside], np.sin(0.2 * late)[inside], atol=2e-4)
    step = 1e-6
    up, _ = shift_samples(signal, samples + step)
    down, _ = shift_samples(signal, samples - step)
    assert np.allclose(slope[:, inside], ((up - down) / (2.0 * step))[:, inside], atol=1e-6)
