"""Derivatives that this flight has earned so far, from the maneuvers judged.

The regression listens to the rows that the verdicts look at, in whole seconds of flight time, so
that what is known at a moment depends on the flight alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import (
    FAST_CHANNELS,
    SLOW_CHANNEL_DELAY,
    FlightRows,
    concatenate_rows,
)
from gsapp.foundation import FlightError
from gsapp.identification.ftr.channels import FTR_CHANNELS
from gsapp.identification.ftr.estimates import LiveEstimate
from gsapp.identification.ftr.online_regression import FTR
from gsapp.identification.ftr.settings import FTRSettings
from gsapp.quantities import Block

_LEARNED_FROM: Final = ("good", "too-small", "too-fast", "too-slow", "not-trimmed")
"""Verdicts whose maneuvers still say something true, if little; what clipped or was spoiled
does not."""

_HEARD_AFTER: Final = 3.0
"""Seconds after a maneuver when all of it was surely heard, late channels too."""

_SETTINGS: Final = FTRSettings(gate="maneuvers", updates=2.0)

_PROMPT: Final = tuple(name for name in FTR_CHANNELS if name in FAST_CHANNELS)
_LATE: Final = tuple(
    name for name in FTR_CHANNELS if name not in FAST_CHANNELS and name != "thrust"
)


class FlightEstimates:
    """Follows one flight.

    Parameters
    ----------
    rate : float
        Of the grid, Hz.

    Attributes
    ----------
    estimates : mapping of str to LiveEstimate
        By derivative; those with enough excitation only.
    revision : int
        Grows with every change of them.

    Raises
    ------
    FlightError
        If the rate is too low for the regression.
    """

    def __init__(self, aircraft: Aircraft, rate: float) -> None:
        self._ftr = FTR(aircraft, _SETTINGS, rate=rate)
        self._second = max(1, round(rate))
        self.restart()

    def restart(self) -> None:
        """Forget everything; the flight begins anew."""
        self._ftr.reset()
        self._held: list[FlightRows] = []
        self._waiting: list[InputVerdict] = []
        self._due: float | None = None
        self.estimates: Mapping[str, LiveEstimate] = {}
        self.revision = 0

    def add_verdict(self, verdict: InputVerdict) -> None:
        """Learn from a maneuver, as soon as its rows were listened to."""
        if verdict.result in _LEARNED_FROM:
            self._waiting.append(verdict)

    def process_rows(self, rows: FlightRows) -> None:
        """Take in the next rows, which end at or before a whole second."""
        self._held.append(rows)
        if (rows.first_index + len(rows)) % self._second == 0:
            self.process_pending_rows()

    def process_pending_rows(self) -> None:
        """Hear the rows held, and learn from what was judged meanwhile."""
        held, self._held = self._held, []
        if not held:
            return
        self._feed(concatenate_rows(held))
        self._ftr.process_step()
        self._conclude(float(held[-1].times[-1]))

    def _feed(self, rows: FlightRows) -> None:
        prompt = np.column_stack([rows[name] for name in _PROMPT])
        late = np.column_stack([rows[name] for name in _LATE])
        self._ftr.feed(Block.unchecked(_PROMPT, rows.times, prompt))
        self._ftr.feed(Block.unchecked(_LATE, rows.times - SLOW_CHANNEL_DELAY, late))

    def _conclude(self, now: float) -> None:
        if self._due is not None and now >= self._due:
            self._due = None
            found = self._ftr.estimates().items()
            self.estimates = {name: one for name, one in found if one.status == "estimated"}
            self.revision += 1
        if self._waiting and self._due is None:
            verdict = self._waiting.pop(0)
            try:
                self._ftr.begin_window(verdict.t_start)
                self._ftr.end_window(verdict.t_end)
            except FlightError:
                return  # a pause lies between, and its rows are forgotten
            self._due = verdict.t_end + _HEARD_AFTER
