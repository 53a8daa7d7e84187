"""Histories of a simulated aircraft: flown by a pilot, or of the bare equations, open loop."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.simulation import ControlCommands, Simulator
from gsapp.quantities import FloatArray

CommandSource = Callable[[Simulator], ControlCommands]
"""Looks at the simulator before each step and gives commands."""


def run_simulation(
    simulator: Simulator,
    commands: CommandSource | Mapping[str, FloatArray],
    duration: float | None = None,
) -> dict[str, FloatArray]:
    """Simulate and return the truth: channel -> array of shape (n,), ``time`` among them.

    The simulator is started, and stands at the last sample afterwards. Commands are a pilot, for a
    duration in s, or histories of the fields of `ControlCommands`, one value for each step; what
    they leave out stays as the simulator was started with.
    """
    if callable(commands):
        assert duration is not None
        count = round(duration / simulator.dt)
        pilot = commands
    else:
        histories = {name: np.asarray(x, dtype=float).tolist() for name, x in commands.items()}
        count = min(len(history) for history in histories.values())
        if duration is not None:
            count = min(count, round(duration / simulator.dt))
        base = {name: getattr(simulator.commands, name) for name in ControlCommands.__slots__}
        rows = iter(
            [
                ControlCommands(**{**base, **{name: h[k] for name, h in histories.items()}})
                for k in range(count)
            ]
        )

        def pilot(_: Simulator) -> ControlCommands:
            return next(rows)

    samples = [simulator.sample()]
    for _ in range(count):
        simulator.step(pilot(simulator))
        samples.append(simulator.sample())
    return {name: np.array([sample[name] for sample in samples]) for name in samples[0]}


def simulate_open_loop(
    model: FlightModel,
    start: Sequence[float],
    inputs: Mapping[str, FloatArray | float],
    dt: float,
    *,
    parameters: Sequence[float] | None = None,
) -> FloatArray:
    """Integrate the polar equations for given histories of the inputs (RK4, plain floats).

    Return the states, shape (n, n_states); NaN from where the motion left all bounds. `start` holds
    the nine polar states; the terms' own may follow, else they start settled. For the inputs see
    `input_columns`; `dt` in s.
    """
    rows = list(zip(*(column.tolist() for column in input_columns(model, inputs)), strict=True))
    state = [float(x) for x in start]
    if len(state) == len(POLAR_STATES):
        state += [float(x) for x in model.steady_states(state, rows[0])]
    values = model.defaults if parameters is None else tuple(float(x) for x in parameters)
    out = np.full((len(rows), len(model.state_names)), np.nan)
    out[0] = state
    half, sixth = 0.5 * dt, dt / 6.0
    rates = model.rates
    try:
        for index in range(1, len(rows)):
            before, after = rows[index - 1], rows[index]
            middle = tuple([0.5 * (x + y) for x, y in zip(before, after, strict=True)])
            k1 = rates(state, before, values)
            k2 = rates([x + half * k for x, k in zip(state, k1, strict=True)], middle, values)
            k3 = rates([x + half * k for x, k in zip(state, k2, strict=True)], middle, values)
            k4 = rates([x + dt * k for x, k in zip(state, k3, strict=True)], after, values)
            state = [
                float(x + sixth * (a + 2.0 * (b + c) + d))
                for x, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)
            ]
            if not -1e3 < state[4] < 1e3:
                break
            out[index] = state
    except (ArithmeticError, ValueError):
        # Overflow, or the sine of infinity: the motion has left all bounds, and NaN says so.
        pass
    return out


def input_columns(
    model: FlightModel, inputs: Mapping[str, FloatArray | float]
) -> tuple[FloatArray, ...]:
    """Return histories of inputs as arrays of equal length, in the order of `MODEL_INPUTS`.

    What is left out is zero, `rho` that of sea level, `mass` the aircraft file's.
    """
    defaults = dict.fromkeys(MODEL_INPUTS, 0.0)
    defaults.update(rho=SEA_LEVEL_DENSITY, mass=model.aircraft.mass.mass)
    columns = [np.atleast_1d({**defaults, **inputs}[name]) for name in MODEL_INPUTS]
    return tuple(np.array(column, dtype=float) for column in np.broadcast_arrays(*columns))
