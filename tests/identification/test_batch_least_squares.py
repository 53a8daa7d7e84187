"""Batch least squares on measured states: truth within its own uncertainty."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.foundation import FlightError
from gsapp.identification.linear_models.linear_model_files import load_linear_model
from gsapp.identification.linear_models.model_comparison import batch_least_squares
from gsapp.identification.linear_models.signals import LinearModelSignals, discretize

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
