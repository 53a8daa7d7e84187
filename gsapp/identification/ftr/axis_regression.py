"""The regressions of one axis over a flight: records are opened, closed, forgotten."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.axis_dynamics import AxisDynamics
from gsapp.identification.ftr.channels import FTRAxis, axis_regressors
from gsapp.identification.ftr.regression import ScratchBuffer, solve_records
from gsapp.identification.ftr.regression_rows import RegressionRows
from gsapp.identification.ftr.settings import FTR_ALGORITHM, FrequencyBand, FTRSettings
from gsapp.identification.ftr.solution import (
    FTRSolution,
    RecordInformation,
    SolvableInformation,
    solve_estimates,
)
from gsapp.identification.ftr.state_file import ArrayTable, add_prefix, strip_prefix
from gsapp.identification.ftr.transform import RunningTransform


class AxisRegression:
    """The three regressions of one axis: open record, closed ones, latest solution.

    Parameters
    ----------
    dt : float
        Sample time, s.
    block : int
        Samples of a block.

    Attributes
    ----------
    closed_information, open_information : RecordInformation
        Of the closed records, and of the open one by itself.
    solution : FTRSolution or None
        The latest, U = 1.
    """

    def __init__(
        self, axis: FTRAxis, settings: FTRSettings, dt: float, block: int, body: AxisDynamics
    ) -> None:
        self.settings, self.body = settings, body
        self.band: FrequencyBand = settings.longitudinal if axis == "lon" else settings.lateral
        self.p = len(axis_regressors(axis))
        self.transform = RunningTransform(
            self.p, self.band, settings.spacing, settings.forgetting, dt, block
        )
        length = block * dt
        self._longest_gap = max(1, round(settings.longest_gap / length))
        self._fade = 1.0 if settings.forgetting is None else math.exp(-length / settings.forgetting)
        self._scratch = ScratchBuffer()
        self._record: int | None = None
        if settings.gate == "always" and settings.forgetting is None:
            seconds = settings.record_length or 1.0 / settings.spacing
            self._record = max(1, round(seconds / length))
        self.restart()

    def restart(self) -> None:
        self.closed_information = self.checkpoint = RecordInformation.zero(self.p)
        self.solution: FTRSolution | None = None
        self.begin_record()

    def open_window(self) -> None:
        """Begin a window, which may have to be gone through again."""
        self.checkpoint = self.closed_information
        self.begin_record()

    def rewind(self) -> None:
        """Go back to where the window began."""
        self.closed_information = self.checkpoint
        self.begin_record()

    def begin_record(self) -> None:
        """Begin a record; what the open one said is forgotten."""
        self.transform.start_record()
        self.open_information = RecordInformation.zero(self.p)
        self.open = False
        self.silent = 0

    def close_record(self) -> None:
        """Keep what the open record said, and begin another."""
        earned = self.open_information.degrees_of_freedom >= FTR_ALGORITHM.min_record_freedom
        if earned.any():
            self.closed_information = self.closed_information.add(
                self.open_information.select_equations(earned)
            )
        self.begin_record()

    def advance(self, first: int, rows: RegressionRows) -> FTRSolution:
        """Take in blocks from number `first` on; return the estimates after each."""
        heard = np.asarray((rows.valid[:, 1:] & rows.valid[:, :-1]).any(axis=1)).tolist()
        parts: list[SolvableInformation] = []
        start = 0
        for k, something in enumerate(heard):
            boundary = self._record is not None and (first + k) % self._record == 0
            lost = self.open and not something and self.silent + 1 >= self._longest_gap
            if boundary or lost:
                parts += self._stretch(rows, start, k)
                start = k
                self.close_record()
            self.open = self.open or something
            self.silent = 0 if something else self.silent + 1
        parts += self._stretch(rows, start, len(heard))
        together = solve_estimates(SolvableInformation.concatenate(parts), self.body)
        self.solution = together.select_moment(-1)
        return together

    def _stretch(self, rows: RegressionRows, start: int, stop: int) -> list[SolvableInformation]:
        """Take in blocks of one record."""
        if stop == start:
            return []
        part = slice(start, stop)
        transforms = self.transform.advance(
            rows.columns[part], rows.valid[part], rows.running[part]
        )
        before = [self.closed_information] * (stop - start)
        if self._fade < 1.0 and self.closed_information.effective_time.any():
            for place in range(len(before)):
                self.closed_information = before[place] = self.closed_information.discounted(
                    self._fade
                )
        found, self.open_information = solve_records(
            transforms,
            self.band,
            self.settings.spacing,
            RecordInformation.stacked(before),
            self.body,
            self._scratch,
        )
        return found

    def solve_closed_records(self) -> FTRSolution:
        """Return the estimates from closed records alone."""
        self.solution = solve_estimates(
            SolvableInformation.from_closed_records(
                RecordInformation.stacked([self.closed_information])
            ),
            self.body,
        )
        return self.solution

    def state(self) -> ArrayTable:
        table: ArrayTable = {
            "open": np.array(self.open),
            "silent": np.array(self.silent),
        }
        parts = {
            "transform": self.transform.state(),
            "past": self.closed_information.state(),
            "checkpoint": self.checkpoint.state(),
            "own": self.open_information.state(),
        }
        if self.solution is not None:
            parts["solution"] = self.solution.state()
        return {**table, **add_prefix(parts)}

    def restore(self, table: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self.open, self.silent = bool(table["open"]), int(table["silent"])
        self.transform.restore(strip_prefix("transform", table))
        self.closed_information = RecordInformation.from_state(strip_prefix("past", table), self.p)
        self.checkpoint = RecordInformation.from_state(strip_prefix("checkpoint", table), self.p)
        self.open_information = RecordInformation.from_state(strip_prefix("own", table), self.p)
        solution = strip_prefix("solution", table)
        self.solution = FTRSolution.from_state(solution) if solution else None
