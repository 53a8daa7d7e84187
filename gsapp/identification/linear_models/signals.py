"""States, inputs and outputs of maneuvers as linear models need them, in stretches without gaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from scipy import linalg, signal

from gsapp.dynamics.linearization import LinearModel
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.identification.smoothing import contiguous_slices
from gsapp.quantities import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearModelSettings:
    """Engineering choices, checked by `tests/bench/linear_models.py`."""

    min_duration: float = 1.0  # Stretches shorter than this (s) are left out.

    # Subspace identification.
    max_order: int = 40  # Order of a model at most.
    max_tried_order: int = 12  # Orders tried where none is given.
    ridge: float = 1e-9  # Share of the mean variance that keeps the projection solvable.
    subspace_rate: float = 50.0  # Hz: faster samples only lengthen the horizon.

    # Prediction error method.
    max_iterations: int = 40  # Gauss-Newton steps at most.
    cost_tolerance: float = 1e-5  # Relative fall of the cost below which it counts as converged.


LINEAR_MODELS: Final = LinearModelSettings()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InputOutputRecord:
    """One stretch without a gap, about its own level."""

    inputs: FloatArray  # Shape (n, n_inputs).
    outputs: FloatArray  # Shape (n, n_outputs). Small changes, SI; none missing.

    def __len__(self) -> int:
        return int(self.inputs.shape[0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DiscreteModel:
    """x[k+1] = A x[k] + B u[k] + K e[k], y[k] = C x[k] + D u[k] + e[k]."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    K: FloatArray
    """Shape (n_states, n_outputs). Gain of the innovations; zero for a model of output error."""
    dt: float  # Sample time, s.

    @property
    def order(self) -> int:
        return int(self.A.shape[0])

    def simulate(self, inputs: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """Return the outputs (n, n_outputs) from the inputs alone, from rest or a start."""
        n = self.order
        state = np.zeros(n) if start is None else start
        driven = inputs @ self.B.T
        states = np.empty((inputs.shape[0], n))
        A = self.A
        for k in range(inputs.shape[0]):
            states[k] = state
            state = A @ state + driven[k]
        return np.asarray(states @ self.C.T + inputs @ self.D.T, dtype=np.float64)

    def predict(self, record: InputOutputRecord, start: FloatArray) -> FloatArray:
        """Return one-step predictions of the outputs, shape (n, n_outputs)."""
        held = DiscreteModel(
            A=self.A - self.K @ self.C,
            B=np.hstack([self.B - self.K @ self.D, self.K]),
            C=self.C,
            D=np.hstack([self.D, np.zeros((self.C.shape[0],) * 2)]),
            K=np.zeros_like(self.K),
            dt=self.dt,
        )
        return held.simulate(np.hstack([record.inputs, record.outputs]), start)

    def to_continuous(self, inputs: Sequence[str], outputs: Sequence[str]) -> LinearModel:
        """Return the model in continuous time, inputs held between samples.

        A pole at or below zero of the discrete model (a quick delay) has no real logarithm: the
        nearest real matrix is taken.
        """
        n, m = self.order, self.B.shape[1]
        block = np.zeros((n + m, n + m))
        block[:n, :n], block[:n, n:] = self.A, self.B
        block[n:, n:] = np.eye(m)
        grown = np.real(linalg.logm(block)) / self.dt
        return LinearModel(
            states=tuple(f"x{k + 1}" for k in range(n)),
            inputs=tuple(inputs),
            outputs=tuple(outputs),
            A=grown[:n, :n],
            B=grown[:n, n:],
            C=self.C,
            D=self.D,
        )


def discretize(model: LinearModel, dt: float) -> DiscreteModel:
    """Return a continuous model for inputs that are straight between samples."""
    A, B, C, D, _ = signal.cont2discrete((model.A, model.B, model.C, model.D), dt, method="foh")
    return DiscreteModel(A=A, B=B, C=C, D=D, K=np.zeros((A.shape[0], C.shape[0])), dt=dt)


LinearAxis = Literal["lon", "lat"]

LINEAR_STATES: Mapping[LinearAxis, tuple[str, ...]] = {
    "lon": ("alpha", "q"),
    "lat": ("beta", "p", "r"),
}
LINEAR_INPUTS: Mapping[LinearAxis, tuple[str, ...]] = {"lon": ("de",), "lat": ("da", "dr")}
LINEAR_OUTPUTS: Mapping[LinearAxis, tuple[str, ...]] = {
    "lon": ("an", "alpha", "q"),
    "lat": ("ay", "beta", "p", "r"),
}
"""As in (7.2.12)-(7.2.15)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearModelSignals:
    """One stretch without a missing sample."""

    maneuver: str
    times: FloatArray  # Shape (n,).
    states: FloatArray
    inputs: FloatArray
    outputs: FloatArray
    """Shape (n, ...). As measured, SI; flow angles at the center of gravity, accelerations where
    the instrument sits."""
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]

    def __len__(self) -> int:
        return int(self.times.size)

    @property
    def dt(self) -> float:
        return float(self.times[1] - self.times[0])


def linear_model_signals(maneuver: Maneuver, axis: LinearAxis) -> tuple[LinearModelSignals, ...]:
    """Return the stretches of a maneuver in which everything was measured.

    Raises `FlightError` if a state, input or output of the axis was not measured at all, or stood
    still.
    """
    known = measured_motion(maneuver)
    absent = [
        name for name in (*LINEAR_STATES[axis], *LINEAR_INPUTS[axis]) if name not in known.measured
    ]
    absent += [
        name
        for name in LINEAR_OUTPUTS[axis]
        if name not in absent and (not maneuver.has(name) or _is_constant(maneuver.samples(name)))
    ]
    if absent:
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}' has no {', '.join(absent)}, which a "
            f"{AXIS_TITLES[axis]} linear model needs"
        )
    states = np.column_stack([known.state(name) for name in LINEAR_STATES[axis]])
    inputs = np.column_stack([known.input(name) for name in LINEAR_INPUTS[axis]])
    outputs = np.column_stack(
        [
            known.state(name) if name in LINEAR_STATES[axis] else maneuver.samples(name)
            for name in LINEAR_OUTPUTS[axis]
        ]
    )
    good: BoolArray = np.asarray(np.isfinite(outputs).all(axis=1), dtype=np.bool_)
    for name in (*LINEAR_STATES[axis], *LINEAR_INPUTS[axis]):
        if name in known.interpolated:
            good &= np.logical_not(known.interpolated[name])
    least = LINEAR_MODELS.min_duration / maneuver.dt
    return tuple(
        LinearModelSignals(
            maneuver=maneuver.id,
            times=known.times[rows],
            states=states[rows],
            inputs=inputs[rows],
            outputs=outputs[rows],
            state_names=LINEAR_STATES[axis],
            input_names=LINEAR_INPUTS[axis],
            output_names=LINEAR_OUTPUTS[axis],
        )
        for rows in contiguous_slices(good)
        if rows.stop - rows.start >= least
    )


def _is_constant(samples: FloatArray) -> bool:
    known = samples[np.isfinite(samples)]
    return bool(known.size) and float(np.ptp(known)) == 0.0


def all_linear_model_signals(
    maneuvers: Sequence[Maneuver], axis: LinearAxis
) -> tuple[LinearModelSignals, ...]:
    """Return the stretches of several maneuvers.

    Raises `FlightError` if there is none.
    """
    found = tuple(one for maneuver in maneuvers for one in linear_model_signals(maneuver, axis))
    if not found:
        raise FlightError(
            f"no maneuver holds {LINEAR_MODELS.min_duration:g} s without a missing sample; "
            "nothing to fit"
        )
    return found
