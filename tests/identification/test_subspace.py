"""Subspace start and prediction error refinement, against systems that are known."""

import numpy as np
import pytest

from gsapp.foundation import FlightError
from gsapp.identification.linear_models.linear_model_files import load_linear_model
from gsapp.identification.linear_models.prediction_error import (
    _apply_step,
    _cost,
    _normal_equations,
    refine_by_prediction_error,
)
from gsapp.identification.linear_models.signals import (
    DiscreteModel,
    InputOutputRecord,
    discretize,
)
from gsapp.identification.linear_models.subspace import identify_subspace_model

DT = 0.02


def b777(axis: str) -> DiscreteModel:
    return discretize(load_linear_model(f"seanor-bls-{axis}").model(), DT)


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
    found = identify_subspace_model(data, DT, order=order)
    assert np.allclose(poles(found.model), poles(truth), rtol=1e-5)
    for record, start in zip(data, found.initial_states, strict=True):
        error = record.outputs - found.model.simulate(record.inputs, start)
        assert np.max(np.abs(error)) < 1e-6 * np.ptp(record.outputs)


@pytest.mark.parametrize(("axis", "order"), [("longitudinal", 2), ("lateral", 3)])
def test_order_is_chosen_from_the_data(axis: str, order: int) -> None:
    truth = b777(axis)
    for seed in range(4):
        data = records(truth, np.random.default_rng(seed), maneuvers=6, noise=0.01)
        assert identify_subspace_model(data, DT).order == order


def test_slopes_of_the_prediction_errors_are_exact() -> None:
    rng = np.random.default_rng(3)
    truth = b777("lateral")
    data = records(truth, rng, maneuvers=2, noise=0.02, count=80)
    model = DiscreteModel(
        A=truth.A, B=truth.B, C=truth.C, D=truth.D + 0.01, dt=DT,
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
        start = identify_subspace_model(data, DT, order=3)
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
    start = identify_subspace_model(data, DT, order=2)
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
        identify_subspace_model(data, DT, order=2)
