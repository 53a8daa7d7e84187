"""Equation error on simulated maneuvers whose derivatives are known."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.flight_model import INPUTS, FlightModel
from gsapp.dynamics.model import load_model
from gsapp.dynamics.sensors import OutputModel
from gsapp.dynamics.simulation import input_columns, open_loop
from gsapp.dynamics.trim import trim
from gsapp.identification.equation_error import estimate
from gsapp.identification.maneuver import Maneuver, clipped_samples
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE

DT = 0.01
AIRCRAFT = load_aircraft("b777")
TRUTH = load_model("b777")


def pulse(count, edges, size, lag=0.05):
    """Return alternating pulses between the edges (s) after a servo of one lag."""
    times = np.arange(count) * DT
    asked = np.zeros(count)
    for index, (start, stop) in enumerate(itertools.pairwise(edges)):
        asked[(times >= start) & (times < stop)] = size * (-1.0) ** index
    moved = np.zeros(count)
    for k in range(1, count):
        moved[k] = moved[k - 1] + (1.0 - np.exp(-DT / lag)) * (asked[k - 1] - moved[k - 1])
    return moved


def fly(axis, *, seconds=10.0):
    """Return a maneuver without noise."""
    count = round(seconds / DT) + 1
    model = FlightModel(AIRCRAFT, TRUTH)
    steady = trim(model, V=29.0)
    inputs = {name: np.full(count, value) for name, value in steady.controls.items()}
    if axis == "lon":
        inputs["de"] = inputs["de"] + pulse(count, (1.0, 1.5, 2.0), 4.0 * DEGREE)
    else:
        inputs["da"] = inputs["da"] + pulse(count, (1.0, 1.5, 2.0), 5.0 * DEGREE)
        inputs["dr"] = inputs["dr"] + pulse(count, (3.5, 4.1, 4.7), 6.0 * DEGREE)
    states = open_loop(model, steady.state, inputs, DT)
    columns = input_columns(model, inputs)
    names = ("V", "alpha", "beta", "p", "q", "r", "phi", "theta", "ax", "ay", "an")
    values = OutputModel(model, names).values(tuple(states.T), columns)
    extra = ("de", "da", "dr", "throttle", "rho")
    block = Block(
        channels=(*names, "de", "da", "dr", "throttle", "density"),
        times=np.arange(count) * DT,
        values=np.column_stack([*values, *(columns[INPUTS.index(name)] for name in extra)]),
    )
    return Maneuver(
        id="1",
        flight="simulated",
        aircraft=AIRCRAFT,
        block=block,
        inputs=("de",) if axis == "lon" else ("da", "dr"),
        mass=float(inputs["mass"][0]),
        clipped=clipped_samples(block, AIRCRAFT),
    )


@pytest.mark.parametrize("axis", ["lon", "lat"])
def test_without_noise_the_truth_is_found(axis):
    """Proves that reconstruction and build-up are the inverse of the equations of motion."""
    found = estimate([fly(axis)], axis)
    for name, one in found.derivatives.items():
        truth = TRUTH.derivative(name)
        assert one.status == "estimated"
        assert one.value == pytest.approx(truth, rel=5e-3, abs=2e-3)
