"""Records of inputs and outputs as discrete linear models see them, and their simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg, signal

from gsapp.dynamics.linearization import LinearModel
from gsapp.quantities import FloatArray


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
