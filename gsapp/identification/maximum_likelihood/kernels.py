"""The equations of a segment as the engine needs them: active states only, all samples at once.

A *kernel* gives rates and responses with their derivatives by the active states and the free
parameters. `GeneralKernel` runs on `FlightModel` and knows every effect; those of
`gsapp.identification.maximum_likelihood.axis_kernels` are written out for the linear build-up and
several times faster. Time is the last axis here, so that every operation runs along the samples.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.sensors import OutputModel
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Forcing:
    """What drives the equations at a row of instants."""

    states: FloatArray  # Shape (9, n). Measured polar states; the rows of active ones are ignored.
    inputs: FloatArray  # Shape (8, n).
    path_derivatives: FloatArray | None
    """Shape (3, n_path, n). Derivatives of de, da, dr by the free parameters of control paths."""
    precomputed: FloatArray  # Shape (n_rows, n). What a kernel works out beforehand.

    def select_instants(self, which: slice) -> Forcing:
        """Return a row of these instants."""
        return Forcing(
            states=self.states[:, which],
            inputs=self.inputs[:, which],
            path_derivatives=None
            if self.path_derivatives is None
            else self.path_derivatives[:, :, which],
            precomputed=self.precomputed[:, which],
        )


class GradientFactor(NamedTuple):
    """A share of the derivatives of the rates by the free parameters, in factors.

    The rate of state `row` has the derivatives ``factor * basis`` by the parameters of `columns`,
    for each pair of `factors`. What carries them through a step is so multiplied with the factors
    alone, once for all these parameters.
    """

    columns: slice  # Of the free parameters.
    factors: tuple[tuple[int, FloatArray], ...]  # Shape (n,).
    basis: FloatArray  # Shape (n_columns, n).


Gradient = FloatArray | list[GradientFactor]
"""Derivatives of the rates by the free parameters: (n_states, n_free, n), or a sum of shares."""


class Kernel(ABC):
    """Rates and responses of the active states.

    Attributes
    ----------
    jacobian_is_expensive : bool
        Whether derivatives by the states cost much more than the rates themselves.
    """

    jacobian_is_expensive = False
    state_names: tuple[str, ...]  # Active states, those of terms last.
    responses: tuple[str, ...]
    free: tuple[str, ...]
    """Free parameters of the equations and of control paths: the columns of derivatives."""

    @abstractmethod
    def build_forcing(
        self, states: FloatArray, inputs: FloatArray, by_path: FloatArray | None, values: FloatArray
    ) -> Forcing:
        """Return the drive for measured states (9, n) and inputs (8, n)."""

    @abstractmethod
    def rates(self, drive: Forcing, x: FloatArray, values: FloatArray) -> FloatArray:
        """Return the rates of the active states x, shape (n_states, n).

        `values` are all parameters of the flight model, in its order.
        """

    @abstractmethod
    def jacobian(
        self, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return rates and their derivatives by the states, shape (n_states, n_states, n)."""

    @abstractmethod
    def gradients(
        self, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray, Gradient]:
        """Return rates and their derivatives by the states, as `jacobian`, and by `free`."""

    @abstractmethod
    def outputs(self, drive: Forcing, x: FloatArray, values: FloatArray) -> FloatArray:
        """Return the responses, shape (n_responses, n)."""

    @abstractmethod
    def output_sensitivities(
        self, drive: Forcing, x: FloatArray, values: FloatArray, S: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the responses and their total derivatives.

        `S`, shape (n_states, m, n): derivatives of the states; the first n_free columns are those
        by `free`.

        Returns
        -------
        y : ndarray, shape (n_responses, n)
        dy : ndarray, shape (n_responses, m, n)
        """


class GeneralKernel(Kernel):
    """Any states, any effects: the chain rule of `FlightModel` and `OutputModel`.

    Parameters
    ----------
    states : sequence of str
        Active polar states; the states of terms are always active.
    free : sequence of str
        Of ``model.parameter_names``.
    path_free : sequence of str
        Free parameters of control paths, whose derivatives come with the drive.
    """

    jacobian_is_expensive = True

    def __init__(
        self,
        model: FlightModel,
        states: Sequence[str],
        responses: Sequence[str],
        free: Sequence[str],
        path_free: Sequence[str] = (),
    ) -> None:
        self.model = model
        self.responses = tuple(responses)
        self.free = (*free, *path_free)
        self._own = tuple(free)
        self.state_names = (*states, *model.state_names[len(POLAR_STATES) :])
        self._active = [model.state_names.index(name) for name in self.state_names]
        self._surfaces = len(model.state_names) + np.array(
            [MODEL_INPUTS.index(name) for name in ("de", "da", "dr")]
        )
        self._outputs = OutputModel(model, self.responses)

    def build_forcing(
        self, states: FloatArray, inputs: FloatArray, by_path: FloatArray | None, values: FloatArray
    ) -> Forcing:
        del values
        table = np.empty((0, states.shape[1]))
        return Forcing(states=states, inputs=inputs, path_derivatives=by_path, precomputed=table)

    def _state(self, drive: Forcing, x: FloatArray) -> list[Any]:
        state: list[Any] = [*drive.states, *([None] * (len(self.model.state_names) - 9))]
        for place, row in zip(self._active, x, strict=True):
            state[place] = row
        return state

    def rates(self, drive: Forcing, x: FloatArray, values: FloatArray) -> FloatArray:
        found = self.model.rates(self._state(drive, x), tuple(drive.inputs), tuple(values))
        out = np.empty_like(x)
        for row, place in enumerate(self._active):
            out[row] = found[place]
        return out

    def jacobian(
        self, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        found = self._differentiate(drive, x, values, ())
        f_x = found[:, :, self._active].transpose(1, 2, 0)
        return self.rates(drive, x, values), np.ascontiguousarray(f_x)

    def gradients(
        self, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        rows = self._differentiate(drive, x, values, self._own)
        f_x = np.ascontiguousarray(rows[:, :, self._active].transpose(1, 2, 0))
        own = len(self._own)
        f_p = np.empty((len(self.state_names), len(self.free), x.shape[1]))
        first = len(self.model.state_names) + len(MODEL_INPUTS)
        f_p[:, :own] = rows[:, :, first:].transpose(1, 2, 0)
        if drive.path_derivatives is not None:
            by_surface = rows[:, :, self._surfaces]
            f_p[:, own:] = np.einsum("nis,spn->ipn", by_surface, drive.path_derivatives)
        return self.rates(drive, x, values), f_x, f_p

    def _differentiate(
        self, drive: Forcing, x: FloatArray, values: FloatArray, free: tuple[str, ...]
    ) -> FloatArray:
        found = self.model.differentiate(
            self._state(drive, x), tuple(drive.inputs), tuple(values), free=free
        )
        rows: FloatArray = found.rates[:, self._active]
        return rows

    def outputs(self, drive: Forcing, x: FloatArray, values: FloatArray) -> FloatArray:
        found = self._outputs.values(self._state(drive, x), tuple(drive.inputs), tuple(values))
        out = np.empty((len(self.responses), x.shape[1]))
        for row, one in enumerate(found):
            out[row] = one
        return out

    def output_sensitivities(
        self, drive: Forcing, x: FloatArray, values: FloatArray, S: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        y, slopes, _ = self._outputs.jacobian(
            self._state(drive, x), tuple(drive.inputs), tuple(values), free=self._own
        )
        by_state = slopes[:, :, self._active]
        # Batches of small matrices, contiguous: (n, r, i) @ (n, i, m).
        total = np.ascontiguousarray(by_state) @ np.ascontiguousarray(S.transpose(2, 0, 1))
        own = len(self._own)
        first = len(self.model.state_names) + len(MODEL_INPUTS)
        total[:, :, :own] += slopes[:, :, first:]
        dy = np.ascontiguousarray(total.transpose(1, 2, 0))
        if drive.path_derivatives is not None:
            by_surface = slopes[:, :, self._surfaces]
            dy[:, own : len(self.free)] += np.einsum(
                "nrs,spn->rpn", by_surface, drive.path_derivatives
            )
        return np.ascontiguousarray(y.T), dy
