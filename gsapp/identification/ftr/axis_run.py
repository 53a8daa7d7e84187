"""The regressions of one axis over a flight: records are opened, closed, forgotten."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.axis_rows import AxisRows
from gsapp.identification.ftr.body import AxisBody
from gsapp.identification.ftr.channels import FTRAxis, axis_regressors
from gsapp.identification.ftr.information import Information
from gsapp.identification.ftr.regression import weigh
from gsapp.identification.ftr.residuals import Scratch
from gsapp.identification.ftr.saving import Table, beneath, under
from gsapp.identification.ftr.settings import Band, FTRSettings
from gsapp.identification.ftr.solution import Evidence, Solution, conclude
from gsapp.identification.ftr.transform import RunningTransform

_LEAST_FREEDOM = 4.0
"""Real equations beyond the unknowns that a record needs for its information to be kept."""


class AxisRun:
    """The three regressions of one axis: open record, closed ones, latest solution.

    Parameters
    ----------
    axis : {"lon", "lat"}
    settings : FTRSettings
    dt : float
        Sample time, s.
    block : int
        Samples of a block.
    body : AxisBody

    Attributes
    ----------
    past, own : Information
        Of the closed records, and of the open one by itself.
    solution : Solution or None
        The latest, U = 1.
    """

    def __init__(
        self, axis: FTRAxis, settings: FTRSettings, dt: float, block: int, body: AxisBody
    ) -> None:
        self.settings, self.body = settings, body
        self.band: Band = settings.longitudinal if axis == "lon" else settings.lateral
        self.p = len(axis_regressors(axis))
        self.transform = RunningTransform(
            self.p, self.band, settings.spacing, settings.forgetting, dt, block
        )
        length = block * dt
        self._longest_gap = max(1, round(settings.longest_gap / length))
        self._fade = 1.0 if settings.forgetting is None else math.exp(-length / settings.forgetting)
        self._scratch = Scratch()
        self._record: int | None = None
        if settings.gate == "always" and settings.forgetting is None:
            seconds = settings.record_length or 1.0 / settings.spacing
            self._record = max(1, round(seconds / length))
        self.restart()

    def restart(self) -> None:
        """Forget all records."""
        self.past = self.checkpoint = Information.none(self.p)
        self.solution: Solution | None = None
        self.begin()

    def open_window(self) -> None:
        """Begin a window, which may have to be gone through again."""
        self.checkpoint = self.past
        self.begin()

    def rewind(self) -> None:
        """Go back to where the window began."""
        self.past = self.checkpoint
        self.begin()

    def begin(self) -> None:
        """Begin a record; what the open one said is forgotten."""
        self.transform.start()
        self.own = Information.none(self.p)
        self.open = False
        self.silent = 0

    def close(self) -> None:
        """Keep what the open record said, and begin another."""
        earned = self.own.freedom >= _LEAST_FREEDOM
        if earned.any():
            self.past = self.past.plus(self.own.of(earned))
        self.begin()

    def advance(self, first: int, rows: AxisRows) -> Solution:
        """Take in blocks from number `first` on; return the estimates after each."""
        heard = np.asarray((rows.valid[:, 1:] & rows.valid[:, :-1]).any(axis=1)).tolist()
        parts: list[Evidence] = []
        start = 0
        for k, something in enumerate(heard):
            boundary = self._record is not None and (first + k) % self._record == 0
            lost = self.open and not something and self.silent + 1 >= self._longest_gap
            if boundary or lost:
                parts += self._stretch(rows, start, k)
                start = k
                self.close()
            self.open = self.open or something
            self.silent = 0 if something else self.silent + 1
        parts += self._stretch(rows, start, len(heard))
        together = conclude(Evidence.joined(parts), self.body)
        self.solution = together.at(-1)
        return together

    def _stretch(self, rows: AxisRows, start: int, stop: int) -> list[Evidence]:
        """Take in blocks of one record."""
        if stop == start:
            return []
        part = slice(start, stop)
        transforms = self.transform.advance(
            rows.columns[part], rows.valid[part], rows.running[part]
        )
        before = [self.past] * (stop - start)
        if self._fade < 1.0 and self.past.listened.any():
            for place in range(len(before)):
                self.past = before[place] = self.past.faded(self._fade)
        found, self.own = weigh(
            transforms,
            self.band,
            self.settings.spacing,
            Information.stacked(before),
            self.body,
            self._scratch,
        )
        return found

    def conclude(self) -> Solution:
        """Return the estimates from closed records alone."""
        self.solution = conclude(Evidence.of_past(Information.stacked([self.past])), self.body)
        return self.solution

    def state(self) -> Table:
        """Return all that is remembered, for `restore`."""
        table: Table = {
            "open": np.array(self.open),
            "silent": np.array(self.silent),
        }
        parts = {
            "transform": self.transform.state(),
            "past": self.past.state(),
            "checkpoint": self.checkpoint.state(),
            "own": self.own.state(),
        }
        if self.solution is not None:
            parts["solution"] = self.solution.state()
        return {**table, **beneath(parts)}

    def restore(self, table: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Go on from what `state` gave."""
        self.open, self.silent = bool(table["open"]), int(table["silent"])
        self.transform.restore(under("transform", table))
        self.past = Information.from_state(under("past", table), self.p)
        self.checkpoint = Information.from_state(under("checkpoint", table), self.p)
        self.own = Information.from_state(under("own", table), self.p)
        solution = under("solution", table)
        self.solution = Solution.from_state(solution) if solution else None
