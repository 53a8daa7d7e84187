"""The same maneuvers flown by the program's own equations, effects from its own catalog.

These rows of the benchmark share code with the program and are printed apart.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import create_term
from gsapp.quantities import FloatArray
from tests.discrepancy.blind.engine import (
    CONTROLS,
    RATE,
    SETTLING,
    STATE,
    STEPS_PER_SECOND,
    SUBSTEPS,
)


def flight_model(
    aircraft: Aircraft, derivatives: Mapping[str, float], sizes: Mapping[str, float]
) -> FlightModel:
    model = Model(derivatives=dict(derivatives))
    for effect, size in sizes.items():
        free = next(one.name for one in create_term(effect, aircraft).parameters if one.free)
        model = model.with_effect(effect, {free: size})
    return FlightModel(aircraft, model)


def fly_equations(
    model: FlightModel,
    mass: float,
    density: float | FloatArray,
    state: Sequence[float],
    controls: FloatArray,
) -> dict[str, FloatArray]:
    """Fly control histories in still air of given density; as `blind.engine.Engine.fly`.

    Runge and Kutta at 100 Hz; the controls half way are those of the step half way.
    """
    count = len(controls)
    inputs = np.zeros((count, 8))
    inputs[:, : len(CONTROLS)] = controls
    inputs[:, 6], inputs[:, 7] = density, mass
    start = (*state, 0.0)
    now = np.array([*start, *model.steady_states(start, tuple(inputs[0]))], dtype=np.float64)

    def rates(x: FloatArray, given: FloatArray) -> FloatArray:
        return np.array([float(one) for one in model.rates(tuple(x), tuple(given))])

    dt, rows = 1.0 / RATE, [now]
    for step in range(0, count - SUBSTEPS, SUBSTEPS):
        middle, then = inputs[step + SUBSTEPS // 2], inputs[step + SUBSTEPS]
        a = rates(now, inputs[step])
        b = rates(now + 0.5 * dt * a, middle)
        c = rates(now + 0.5 * dt * b, middle)
        d = rates(now + dt * c, then)
        now = now + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        rows.append(now)
    ahead = round(SETTLING * STEPS_PER_SECOND)
    states = np.array(rows)[ahead // SUBSTEPS :]
    taken = inputs[ahead::SUBSTEPS][: len(states)]
    columns, given = tuple(states.T), tuple(taken.T)
    totals, moves = model.evaluate(columns, given), model.rates(columns, given)
    table = {name: states[:, column] for column, name in enumerate(STATE)}
    V, alpha, beta = (table[name] for name in ("V", "alpha", "beta"))
    table["u"] = V * np.cos(alpha) * np.cos(beta)
    table["v"] = V * np.sin(beta)
    table["w"] = V * np.sin(alpha) * np.cos(beta)
    still = np.zeros(len(states))
    for index, axis in enumerate("xyz"):
        table[f"f{axis}"] = np.asarray(totals.loads[index]) / totals.body.mass
    for index, rate in enumerate("pqr"):
        table[f"{rate}_dot"] = np.asarray(moves[3 + index])
    temperature = 286.2
    table["density"] = taken[:, 6]
    table["temperature"] = still + temperature
    table["static_pressure"] = taken[:, 6] * 287.05287 * temperature
    table["time"] = np.arange(len(states)) / RATE
    table.update({name: taken[:, column] for column, name in enumerate(CONTROLS)})
    return table
