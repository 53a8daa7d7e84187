"""Linear models: least squares, subspace, prediction error, and their validation."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from gsapp.dynamics.model import load_model
from gsapp.foundation import FlightError
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.linear_models.linear_model_files import load_linear_model
from gsapp.identification.linear_models.model_comparison import batch_least_squares
from gsapp.identification.linear_models.signals import (
    DiscreteModel,
    InputOutputRecord,
    LinearModelSignals,
    discretize,
)
from gsapp.identification.linear_models.subspace import (
    _apply_step,
    _cost,
    _normal_equations,
    identify_subspace_model,
    refine_by_prediction_error,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.summary.campaign_linear_models import validate_linear_models
from tests.identification.virtual_maneuvers import edited, fly

DT = 0.01


def stretches(
    axis: str, seed: int, *, noise: float, maneuvers: int = 4
) -> list[LinearModelSignals]:
    """Return maneuvers of a published least-squares model, each with a trim of its own."""
    rng = np.random.default_rng(seed)
    model = load_linear_model(f"seanor-bls-{axis}").model()
    sampled = discretize(model, DT)
    found = []
    for number in range(maneuvers):
        times = np.arange(800) * DT
        u = np.zeros((800, len(model.inputs)))
        for column in range(u.shape[1]):
            start, width = 100 + 150 * column, int(rng.integers(25, 50))
            u[start : start + width, column] = 0.08
            u[start + width : start + 2 * width, column] = -0.08
        kernel = np.hanning(9) / np.hanning(9).sum()
        u = np.column_stack([np.convolve(one, kernel, mode="same") for one in u.T])
        y = sampled.simulate(u)
        trim_u, trim_y = 0.05 * rng.standard_normal(u.shape[1]), rng.standard_normal(y.shape[1])
        y = y + trim_y + noise * np.ptp(y, axis=0) * rng.standard_normal(y.shape)
        found.append(
            LinearModelSignals(
                maneuver=str(number), times=times, states=y[:, 1:], inputs=u + trim_u, outputs=y,
                state_names=model.states, input_names=model.inputs, output_names=model.outputs,
            )
        )  # fmt: skip
    return found


@pytest.mark.parametrize("axis", ["longitudinal", "lateral"])
def test_without_noise_the_matrices_come_back(axis: str) -> None:
    truth = load_linear_model(f"seanor-bls-{axis}").model()
    found = batch_least_squares(stretches(axis, 0, noise=0.0)).model
    # What is left is the curvature of the input between samples, which no sample shows.
    assert np.linalg.norm(found.A - truth.A) < 0.02 * np.linalg.norm(truth.A)
    assert np.linalg.norm(found.B - truth.B) < 0.02 * np.linalg.norm(truth.B)
    assert np.allclose(found.C, truth.C, rtol=1e-6, atol=1e-6)
    assert np.allclose(found.D, truth.D, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("axis", ["longitudinal", "lateral"])
def test_uncertainty_is_honest_for_the_inputs(axis: str) -> None:
    truth = load_linear_model(f"seanor-bls-{axis}").model()
    ratios, misses = [], []
    for seed in range(30):
        found = batch_least_squares(stretches(axis, seed, noise=0.005))
        ratios.append((found.model.B - truth.B) / found.B_std)
        misses.append(np.linalg.norm(found.model.A - truth.A) / np.linalg.norm(truth.A))
    assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.5
    assert np.mean(misses) < 0.1


def test_input_that_never_moves_is_named() -> None:
    still = []
    for one in stretches("lateral", 1, noise=0.001):
        inputs = one.inputs.copy()
        inputs[:, 1] = 0.02
        still.append(
            LinearModelSignals(
                maneuver=one.maneuver, times=one.times, states=one.states, inputs=inputs,
                outputs=one.outputs, state_names=one.state_names, input_names=one.input_names,
                output_names=one.output_names,
            )
        )  # fmt: skip
    with pytest.raises(FlightError, match="dr does not move"):
        batch_least_squares(still)


def test_inputs_that_move_alike_are_told() -> None:
    alike = [
        replace(one, inputs=np.column_stack([one.inputs[:, 0], one.inputs[:, 0]]),
                input_names=("da", "dr"))
        for one in stretches("lateral", 1, noise=0.001)
    ]  # fmt: skip
    with pytest.raises(FlightError, match="move together"):
        batch_least_squares(alike)


STEP = 0.02


def b777(axis: str) -> DiscreteModel:
    return discretize(load_linear_model(f"seanor-bls-{axis}").model(), STEP)


def doublets(rng: np.random.Generator, count: int, inputs: int) -> np.ndarray:
    u = np.zeros((count, inputs))
    for column in range(inputs):
        start = 20 + 60 * column
        width = int(rng.integers(12, 30))
        size = rng.uniform(0.05, 0.12)
        u[start : start + width, column] = size
        u[start + width : start + 2 * width, column] = -size
    kernel = np.array([0.25, 0.5, 0.25])
    return np.column_stack([np.convolve(one, kernel, mode="same") for one in u.T])


def records(
    model: DiscreteModel,
    rng: np.random.Generator,
    *,
    maneuvers: int,
    noise: float,
    count: int = 500,
) -> list[InputOutputRecord]:
    found = []
    for _ in range(maneuvers):
        u = doublets(rng, count, model.B.shape[1])
        start = 0.02 * rng.standard_normal(model.order)
        y = model.simulate(u, start)
        y += noise * np.ptp(y, axis=0) * rng.standard_normal(y.shape)
        found.append(InputOutputRecord(inputs=u, outputs=y))
    return found


def poles(model: DiscreteModel) -> np.ndarray:
    return np.sort_complex(np.log(np.linalg.eigvals(model.A).astype(complex)) / model.dt)


@pytest.mark.parametrize(("axis", "order"), [("longitudinal", 2), ("lateral", 3)])
def test_without_noise_the_system_is_found_exactly(axis: str, order: int) -> None:
    truth = b777(axis)
    data = records(truth, np.random.default_rng(1), maneuvers=4, noise=0.0)
    found = identify_subspace_model(data, STEP, order=order)
    assert np.allclose(poles(found.model), poles(truth), rtol=1e-5)
    for record, start in zip(data, found.initial_states, strict=True):
        error = record.outputs - found.model.simulate(record.inputs, start)
        assert np.max(np.abs(error)) < 1e-6 * np.ptp(record.outputs)


@pytest.mark.parametrize(("axis", "order"), [("longitudinal", 2), ("lateral", 3)])
def test_order_is_chosen_from_the_data(axis: str, order: int) -> None:
    truth = b777(axis)
    for seed in range(2):
        data = records(truth, np.random.default_rng(seed), maneuvers=6, noise=0.01)
        assert identify_subspace_model(data, STEP).order == order


def test_slopes_of_the_prediction_errors_are_exact() -> None:
    rng = np.random.default_rng(3)
    truth = b777("lateral")
    data = records(truth, rng, maneuvers=2, noise=0.02, count=80)
    model = DiscreteModel(
        A=truth.A, B=truth.B, C=truth.C, D=truth.D + 0.01, dt=STEP,
        K=0.0005 * rng.standard_normal((3, 4)),
    )  # fmt: skip
    starts = [0.01 * rng.standard_normal(3) for _ in data]
    weight = np.array([1.0, 2.0, 0.5, 1.5])
    for innovations in (False, True):
        _, gradient = _normal_equations(data, model, starts, weight, innovations)
        count = sum(record.outputs.size for record in data)
        for index in rng.choice(gradient.size, 12, replace=False):
            step = np.zeros(gradient.size)
            step[index] = 1e-6
            up = _cost(data, *_apply_step(model, starts, step, innovations), weight)
            down = _cost(data, *_apply_step(model, starts, -step, innovations), weight)
            # The gradient of half the sum of squares, downhill.
            assert gradient[index] == pytest.approx(
                -0.5 * count * (up - down) / 2e-6, rel=1e-4, abs=1e-4 * np.abs(gradient).max()
            )


def test_refinement_comes_nearer_to_the_truth() -> None:
    """With 2 % noise the refined model simulates a held-out maneuver better, over 6 seeds."""
    truth = b777("lateral")
    before, after = [], []
    for seed in range(6):
        rng = np.random.default_rng(100 + seed)
        data = records(truth, rng, maneuvers=4, noise=0.02)
        start = identify_subspace_model(data, STEP, order=3)
        refined = refine_by_prediction_error(data, start.model, start.initial_states)
        assert refined.cost <= refined.cost_before
        assert refined.converged
        held_out = doublets(rng, 500, 2)
        expected = truth.simulate(held_out)
        for model, errors in ((start.model, before), (refined.model, after)):
            miss = (model.simulate(held_out) - expected) / np.ptp(expected, axis=0)
            errors.append(np.sqrt(np.mean(miss**2)))
    assert np.mean(after) < np.mean(before)
    assert np.mean(after) < 0.01


@pytest.mark.long
def test_innovations_gain_whitens_process_noise() -> None:
    rng = np.random.default_rng(5)
    truth = b777("longitudinal")
    u = doublets(rng, 1500, 1)
    state, outputs = np.zeros(2), []
    for k in range(len(u)):
        outputs.append(truth.C @ state + truth.D @ u[k])
        state = truth.A @ state + truth.B @ u[k] + 0.002 * rng.standard_normal(2)
    y = np.array(outputs) + 1e-4 * rng.standard_normal((len(u), 3))
    data = [InputOutputRecord(inputs=u, outputs=y)]
    start = identify_subspace_model(data, STEP, order=2)
    plain = refine_by_prediction_error(data, start.model, start.initial_states)
    gained = refine_by_prediction_error(data, plain.model, plain.initial_states, innovations=True)
    assert gained.cost < 0.2 * plain.cost
    error = y - gained.model.predict(data[0], gained.initial_states[0])
    for column in error[20:].T:
        correlation = np.corrcoef(column[1:], column[:-1])[0, 1]
        assert abs(correlation) < 0.15


def test_too_little_data_says_so() -> None:
    truth = b777("longitudinal")
    data = records(truth, np.random.default_rng(1), maneuvers=1, noise=0.0, count=24)
    with pytest.raises(FlightError, match="too few"):
        identify_subspace_model(data, STEP, order=2)


TRUTH = load_model("b777")
FEW = CampaignSettings(method="ee")
"""Quick: which method gives the derivatives does not matter here."""


@cache
def flown_once() -> tuple[Maneuver, ...]:
    kinds = zip(range(21, 29), ("lon", "lat") * 4, strict=True)
    return tuple(
        fly(seed, kind, dt=0.02, duration=4.0, model=TRUTH).maneuver for seed, kind in kinds
    )


def maneuvers(flights: int) -> tuple[Maneuver, ...]:
    found = []
    for index, one in enumerate(flown_once()):
        number = 1 if flights == 1 else 1 + index // 4
        name = f"{number}:M{index}" if flights > 1 else f"M{index}"
        found.append(replace(one, id=name, flight=f"flight {number}"))
    return tuple(found)


def test_the_last_flight_is_kept_out_and_nothing_of_it_is_in_the_models() -> None:
    """Models follow it within a few percent; another record of it leaves them the same, bit by bit.

    A gyro that shows half of the pitch rate there makes the error of q large: it is the flight
    that judges.
    """
    flown = maneuvers(2)
    found = validate_linear_models(run_campaign(flown, FEW))
    assert not found.remarks
    assert found.axes["lon"].validation_maneuvers == ("2:M4", "2:M6")
    assert found.axes["lat"].fitted_maneuvers == ("1:M1", "1:M3")
    assert found.axes["lat"].flights == ("flight 2",)
    for one in found.axes.values():
        assert set(one.errors) == {"bls", "subspace", "ml"}
        assert all(
            0.0 < error < 15.0 for errors in one.errors.values() for error in errors.values()
        )
    other = tuple(
        edited(one, q=lambda q: 0.5 * q) if one.id[0] == "2" else one
        for one in flown
        if "de" in one.inputs
    )
    wrong = validate_linear_models(run_campaign(other, FEW))
    for name, model in found.axes["lon"].models.items():
        assert np.array_equal(model.model.A, wrong.axes["lon"].models[name].model.A)
        assert np.array_equal(model.model.B, wrong.axes["lon"].models[name].model.B)
    assert wrong.axes["lon"].errors["ml"]["q"] > 2.0 * found.axes["lon"].errors["ml"]["q"]


def test_the_flight_that_judges_can_be_named_and_judges_as_a_whole() -> None:
    """The cut asked for runs from its first to its last maneuver; a start of one's own helps.

    A flight that cannot be opened is said.
    """
    flown = tuple(one for one in maneuvers(2) if "de" in one.inputs and one.id != "1:M2")
    asked: list[tuple[str, float, float]] = []

    def cut(number: str, start: float, stop: float) -> Maneuver:
        asked.append((number, start, stop))
        return flown[0]

    def gone(*_: object) -> Maneuver:
        raise FlightError("the flight is gone")

    found = validate_linear_models(run_campaign(flown, FEW), keep_out=("1",), cut=cut).axes["lon"]
    assert found.validation_maneuvers == ("1:M0",)
    assert asked == [("1", flown[0].t_start, flown[0].t_end)]
    for name, errors in found.errors.items():
        ratios = np.array(
            [errors[key] / found.whole_flight_errors[name][key] for key in found.outputs]
        )
        # All outputs together, each in units of what it missed without.
        assert 0.0 < np.mean(ratios**2) < 1.0
    closed = validate_linear_models(run_campaign(flown, FEW), keep_out=("1",), cut=gone)
    assert not closed.axes["lon"].whole_flight_errors
    assert ["flight is gone" in one for one in closed.remarks] == [True]


def test_one_flight_is_judged_on_every_other_maneuver_of_each_kind() -> None:
    found = validate_linear_models(run_campaign(maneuvers(1), FEW))
    assert found.axes["lon"].fitted_maneuvers == ("M0", "M4")
    assert found.axes["lon"].validation_maneuvers == ("M2", "M6")
    assert found.axes["lat"].validation_maneuvers == ("M3", "M7")
    assert found.axes["lat"].flights == ()
    trace = found.axes["lon"].traces[0]
    assert trace.measured.shape == trace.computed["bls"].shape == (trace.times.size, 3)
    assert trace.inputs.shape == (trace.times.size, 1)
    # The errors are those of the traces.
    measured = np.vstack([one.measured[:, 2] for one in found.axes["lon"].traces])
    computed = np.vstack([one.computed["bls"][:, 2] for one in found.axes["lon"].traces])
    error = 100.0 * np.sqrt(np.mean((measured - computed) ** 2)) / np.ptp(measured)
    assert found.axes["lon"].errors["bls"]["q"] == pytest.approx(error)


def test_what_was_left_out_by_hand_is_neither_fitted_nor_judged() -> None:
    found = validate_linear_models(
        run_campaign(maneuvers(2), FEW), without=("1:M0", "2:M6", "1:M1", "1:M3")
    )
    assert (found.axes["lon"].fitted_maneuvers, found.axes["lon"].validation_maneuvers) == (
        ("1:M2",),
        ("2:M4",),
    )
    assert found.axes["lat"].fitted_maneuvers == ("2:M5",)


def test_a_single_maneuver_of_a_kind_is_told_and_not_judged() -> None:
    flown = tuple(one for one in maneuvers(1) if one.id not in ("M2", "M4", "M6"))
    found = validate_linear_models(run_campaign(flown, FEW))
    assert set(found.axes) == {"lat"}
    (said,) = found.remarks
    assert "second maneuver" in said
