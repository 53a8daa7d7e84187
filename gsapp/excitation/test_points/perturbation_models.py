"""The aircraft's small motions about a test point, and what an input of one radian makes of them.

Everything is linear here: an answer per radian is found once, and scaled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics import linearization
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.trim import Trim, find_suspect_signs, find_unflyable_reasons, trim
from gsapp.excitation.settings import INPUTS
from gsapp.flight.maneuvers.input_shape import smooth_samples
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.identification.ftr.estimates import LiveEstimate
from gsapp.quantities import FloatArray
from gsapp.virtual.flight_plan import INPUT_SHAPES

_STATES: Final = {"alpha": "alpha at the CG", "beta": "beta at the CG"}
"""Flow angles of the aircraft itself, beside what its vanes show."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PerturbationModels:
    """Linear models about level flight at a test point."""

    trim: Trim
    longitudinal: LinearModel
    lateral: LinearModel
    """SI and radians."""

    def model_for(self, surface: str) -> LinearModel:
        """Return the model that a surface (``de``, ``da``, ``dr``) acts on."""
        return self.longitudinal if surface == "de" else self.lateral


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InputResponse:
    """What an input of one surface does, for each radian of its amplitude."""

    times: FloatArray
    """Shape (n,). Since the input began, s."""
    histories: Mapping[str, FloatArray]
    """Shape (n,). Deviations from trim: measured channels by id, and `_STATES`; SI per rad."""
    duration: float
    """Of the input, s."""

    def peak_to_peak(self, channel: str) -> float:
        """Return the peak-to-peak answer as the grader measures it, SI per rad; 0 for none."""
        if channel not in self.histories:
            return 0.0
        heard = self.times <= self.duration + DETECTION.response_time
        return float(
            np.ptp(smooth_samples(self.histories[channel][heard], INPUTS.response_time_step))
        )


def linearize_level_flight(
    aircraft: Aircraft,
    model: Model,
    *,
    speed: float,
    density: float | None = None,
    mass: float | None = None,
    flap: float = 0.0,
) -> PerturbationModels:
    """Return the small motions about level flight; `FlightError` if the aircraft cannot fly so.

    At sea level and with the mass of the aircraft file by default.
    """
    flying = FlightModel(aircraft, model)
    rho = SEA_LEVEL_DENSITY if density is None else density
    level = trim(flying, V=speed, rho=rho, mass=mass, flap=flap)
    return PerturbationModels(
        trim=level,
        longitudinal=linearization.linearize_longitudinal(flying, level),
        lateral=linearization.linearize_lateral(flying, level),
    )


def simulate_input_response(
    motions: PerturbationModels, surface: str, *, kind: str, width: float, lag: float, listen: float
) -> InputResponse:
    """Return the answer to an input of one surface.

    Parameters
    ----------
    kind : str
        Shape; those without steps of their own are taken as doublets.
    width : float
        Of one step, s.
    lag : float
        Time constant of the servo, s.
    listen : float
        How long the answer is followed after the input, s.
    """
    linear = motions.model_for(surface)
    steps = INPUT_SHAPES.get(kind, INPUT_SHAPES["doublet"])
    count = int(np.ceil((len(steps) * width + listen) / INPUTS.response_time_step))
    states, outputs = _step_response(linear, surface, max(lag, INPUTS.response_time_step), count)
    one = {
        **{name: outputs[:, k] for k, name in enumerate(linear.outputs)},
        **{
            text: states[:, linear.states.index(name)]
            for name, text in _STATES.items()
            if name in linear.states
        },
    }
    edges = np.diff([0.0, *steps, 0.0])
    starts = [round(k * width / INPUTS.response_time_step) for k in range(edges.size)]
    return InputResponse(
        times=INPUTS.response_time_step * np.arange(count, dtype=np.float64),
        histories={name: _superposed(line, edges, starts) for name, line in one.items()},
        duration=len(steps) * width,
    )


def _superposed(line: FloatArray, edges: FloatArray, starts: Sequence[int]) -> FloatArray:
    found = np.zeros_like(line)
    for edge, start in zip(edges, starts, strict=True):
        found[start:] += edge * line[: line.size - start]
    return found


def _step_response(
    linear: LinearModel, surface: str, lag: float, count: int
) -> tuple[FloatArray, FloatArray]:
    """Return states and outputs, shape (count, ...), after a step of 1 rad through the servo."""
    column = linear.inputs.index(surface)
    size = len(linear.states)
    # States, the servo, and the constant one that drives it.
    matrix = np.zeros((size + 2, size + 2))
    matrix[:size, :size] = linear.A
    matrix[:size, size] = linear.B[:, column]
    matrix[size, size:] = -1.0 / lag, 1.0 / lag
    from scipy.linalg import expm  # a tenth of a second

    forward = expm(INPUTS.response_time_step * matrix)
    found = np.empty((count, size + 2))
    state = np.zeros(size + 2)
    state[-1] = 1.0
    for row in range(count):
        found[row] = state
        state = forward @ state
    states, servo = found[:, :size], found[:, size]
    return states, states @ linear.C.T + np.outer(servo, linear.D[:, column])


def update_model(
    model: Model, estimates: Mapping[str, LiveEstimate] | None, *, aircraft: Aircraft
) -> Model:
    """Return a model with the derivatives that this flight has earned; the same if there are none.

    An estimate takes the place of a derivative if it is earned, its bound is below
    `INPUTS.max_relative_bound` of its value, and the model with it flies with no sign reversed that
    was right before. Biases stay: they belong to trim and to how the instruments were zeroed.
    """
    changed: dict[str, float] = {}
    doubts = len(find_suspect_signs(model))
    for name, estimate in (estimates or {}).items():
        if name not in model.derivatives or not _is_reliable(estimate):
            continue
        old, new = model.derivative(name), estimate.value
        if new is None or (old and not 1.0 / INPUTS.max_ratio < new / old < INPUTS.max_ratio):
            continue
        trial = model.with_derivatives({**changed, name: new})
        if not find_unflyable_reasons(aircraft, trial) and len(find_suspect_signs(trial)) <= doubts:
            changed[name] = new
    if not changed:
        return model
    return model.with_derivatives(changed, name=f"{model.name}, as flown")


def _is_reliable(estimate: LiveEstimate) -> bool:
    value, std = estimate.value, estimate.std
    if estimate.name.endswith("_0") or value is None or std is None:
        return False
    return 0.0 < std < INPUTS.max_relative_bound * abs(value)
