"""The log of all estimates of a flight: a few arrays that grow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.estimate_evaluation import VerdictArray
from gsapp.identification.ftr.solution import FTRSolution
from gsapp.quantities import FloatArray

Float32Array = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EstimateSnapshot:
    """Estimates at U moments in the order of the log, D derivatives, constants first."""

    values: FloatArray
    stds: FloatArray
    plains: FloatArray
    """Shape (U, D)."""
    verdicts: VerdictArray
    companions: VerdictArray
    """Shape (U, D)."""
    qualities: Float32Array
    """Shape (U, D, 4). Signal to noise, amplitude, uncertain share, seconds listened."""

    @staticmethod
    def from_axis_arrays(
        solution: FTRSolution, verdicts: VerdictArray, companions: VerdictArray
    ) -> EstimateSnapshot:
        """Return a solution laid out by derivative."""
        many = len(solution.theta)
        shape = solution.bias.shape

        def lay(bias: npt.NDArray[np.generic], rest: npt.NDArray[np.generic]) -> object:
            return np.concatenate((bias[..., np.newaxis], rest), axis=2).reshape(many, -1)

        qualities = np.empty((*verdicts.shape, 4), dtype=np.float32)
        with np.errstate(over="ignore"):
            qualities[..., 1:, 0] = solution.signal_to_noise
            qualities[..., 1:, 1] = solution.amplitude
            qualities[..., 1:, 2] = solution.uncertain[..., :-1]
            qualities[..., 0, 2] = solution.uncertain[..., -1]
        qualities[..., 0, :2] = 0.0
        qualities[..., 3] = solution.listened[..., np.newaxis]
        return EstimateSnapshot(
            values=np.asarray(lay(solution.bias, solution.theta)),
            stds=np.asarray(lay(solution.bias_std, solution.std)),
            plains=np.asarray(lay(solution.bias_std, solution.plain)),
            verdicts=np.asarray(lay(verdicts[..., -1], verdicts[..., :-1])),
            companions=np.asarray(lay(np.full(shape, -1, dtype=np.int8), companions)),
            qualities=qualities.reshape(many, -1, 4),
        )

    @staticmethod
    def concatenate(parts: Sequence[EstimateSnapshot]) -> EstimateSnapshot:
        """Return the derivatives of several axes together."""
        return EstimateSnapshot(
            **{
                one.name: np.concatenate([getattr(part, one.name) for part in parts], axis=1)
                for one in fields(EstimateSnapshot)
            }
        )


class EstimateLog:
    """Estimates of D derivatives at all moments so far; see `EstimateSnapshot` for the arrays."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._count = 0
        self._make(256)

    def _make(self, size: int) -> None:
        D = len(self.names)
        self._times = np.empty(size)
        self._table: dict[str, npt.NDArray[Any]] = {
            "values": np.empty((size, D)),
            "stds": np.empty((size, D)),
            "plains": np.empty((size, D)),
            "verdicts": np.empty((size, D), dtype=np.int8),
            "companions": np.empty((size, D), dtype=np.int8),
            "qualities": np.empty((size, D, 4), dtype=np.float32),
        }

    def append(self, times: FloatArray, moment: EstimateSnapshot) -> None:
        """Add moments; those at or before the last one take its place."""
        at = int(np.searchsorted(self.times, times[0] - 1e-9))
        need = at + times.size
        if need > self._times.size:
            old_times, old = self._times, self._table
            self._make(2 * need)
            self._times[:at] = old_times[:at]
            for name, array in old.items():
                self._table[name][:at] = array[:at]
        self._times[at:need] = times
        for name, array in self._table.items():
            array[at:need] = getattr(moment, name)
        self._count = need

    @property
    def times(self) -> FloatArray:
        return self._times[: self._count]

    @property
    def last_time(self) -> float | None:
        return float(self._times[self._count - 1]) if self._count else None

    def row_at(self, time: float | None) -> int | None:
        """Return the row of the last moment at or before a time; None if there is none."""
        if time is None:
            return self._count - 1 if self._count else None
        row = int(np.searchsorted(self.times, time + 1e-9, side="right")) - 1
        return row if row >= 0 else None

    @property
    def values(self) -> FloatArray:
        return self._table["values"][: self._count]

    @property
    def stds(self) -> FloatArray:
        return self._table["stds"][: self._count]

    @property
    def plains(self) -> FloatArray:
        return self._table["plains"][: self._count]

    @property
    def verdicts(self) -> VerdictArray:
        return np.asarray(self._table["verdicts"][: self._count], dtype=np.int8)

    @property
    def companions(self) -> VerdictArray:
        return np.asarray(self._table["companions"][: self._count], dtype=np.int8)

    @property
    def qualities(self) -> Float32Array:
        return np.asarray(self._table["qualities"][: self._count], dtype=np.float32)

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {
            "times": self.times,
            **{name: array[: self._count] for name, array in self._table.items()},
        }

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        times = np.asarray(state["times"], dtype=np.float64)
        self._make(max(256, 2 * times.size))
        self._times[: times.size] = times
        for name, array in self._table.items():
            array[: times.size] = state[name]
        self._count = times.size
