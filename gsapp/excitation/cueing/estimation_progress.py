"""What the flight has learned: derivatives by regression, bounds and prospects from information."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FAST_CHANNELS, FlightRows, RecentRows, concatenate_rows
from gsapp.excitation.information.information_tracker import InformationTracker
from gsapp.excitation.information.outlook import Outlook
from gsapp.excitation.settings import CUES, INFORMATION
from gsapp.flight.cards import CardSetProgress, TestCard
from gsapp.foundation import FlightError
from gsapp.identification.ftr.channels import FTR_CHANNELS
from gsapp.identification.ftr.estimates import LiveEstimate
from gsapp.identification.ftr.online_regression import FTR
from gsapp.identification.ftr.settings import FTRSettings
from gsapp.quantities import Block

# Derivatives that this flight has earned so far, from the maneuvers judged.
# The regression listens to the rows that the verdicts look at, in whole seconds of flight time, so
# that what is known at a moment depends on the flight alone.

_LEARNED_FROM: Final = ("good", "too-small", "too-fast", "too-slow", "not-trimmed")
"""Verdicts whose maneuvers still say something true, if little; what clipped or was invalid
does not."""


_SETTINGS: Final = FTRSettings(gate="maneuvers", updates=2.0)

_PROMPT: Final = tuple(name for name in FTR_CHANNELS if name in FAST_CHANNELS)
_LATE: Final = tuple(
    name for name in FTR_CHANNELS if name not in FAST_CHANNELS and name != "thrust"
)


class FlightEstimates:
    """Follows one flight, at a rate that the regression can use.

    `estimates` has the derivatives with enough excitation; `revision` grows with every change of
    them.
    """

    def __init__(self, aircraft: Aircraft, rate: float) -> None:
        self._ftr = FTR(aircraft, _SETTINGS, rate=rate)
        self._second = max(1, round(rate))
        self.restart()

    def restart(self) -> None:
        self._ftr.reset()
        self._held: list[FlightRows] = []
        self._waiting: list[InputVerdict] = []
        self._due: float | None = None
        self.estimates: Mapping[str, LiveEstimate] = {}
        self.revision = 0

    def add_verdict(self, verdict: InputVerdict) -> None:
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
        self._ftr.feed(Block.unchecked(_LATE, rows.times - CUES.slow_channel_delay, late))

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
            self._due = verdict.t_end + CUES.maneuver_delay


class EstimationProgress:
    """Follows one flight; `outlook` is as of the last look, None before the first."""

    def __init__(
        self, aircraft: Aircraft | None, model: Model | None, rate: float, system: str = "US"
    ) -> None:
        self._foresees = aircraft is not None and model is not None
        self._book = InformationTracker(aircraft, model, rate, system=system)
        self._estimates = _estimates_of(aircraft, rate)
        self._settle_into()

    def restart(self) -> None:
        self._book.restart()
        if self._estimates is not None:
            self._estimates.restart()
        self._settle_into()

    def _settle_into(self) -> None:
        self.outlook: Outlook | None = None
        self._ticks = 0
        self._ready_at = 0.0
        self._revision = 0

    def use_units(self, system: str) -> None:
        """Say what cards would bring in these units, ``US`` or ``SI``, from the next look on."""
        self._book.use_units(system)

    @property
    def estimates(self) -> Mapping[str, LiveEstimate]:
        return {} if self._estimates is None else self._estimates.estimates

    def process_rows(self, rows: FlightRows) -> bool:
        """Take in the rows of a tick; return whether other derivatives were earned."""
        self._book.process_rows(rows)
        if self._estimates is None:
            return False
        self._estimates.process_rows(rows)
        if self._estimates.revision == self._revision:
            return False
        self._revision = self._estimates.revision
        self._book.set_estimates(self._estimates.estimates)
        return True

    def add_maneuver(
        self,
        verdict: InputVerdict,
        recent: RecentRows,
        card: TestCard | None,
        flown: CardSetProgress | None,
        doubted: Collection[str] = (),
    ) -> None:
        """Learn from a maneuver; the cards flown count it already.

        Channels that were not believed at some time of the maneuver are as good as missing.
        """
        rows = recent.segment(verdict.t_start - INFORMATION.noise_time, verdict.t_end)
        if rows is not None:
            rows = rows.mask_channels(doubted)
        self._book.add_maneuver(verdict, rows, card=card)
        # The cards as they stand now: else the look ahead would be worked out twice.
        self.outlook = self._book.outlook(verdict.given_at, flown)
        self._ready_at = verdict.given_at + INFORMATION.forecast_delay + CUES.forecast_margin
        if self._estimates is not None:
            self._estimates.add_verdict(verdict)

    def update_outlook(self, time: float, flown: CardSetProgress | None) -> bool:
        """Look ahead, twice a second of flight time (s); return whether that can be gone by.

        For some seconds after a maneuver, and at the beginning, it is still being worked out.
        """
        if self._ticks == 0:
            self._ready_at = time + INFORMATION.forecast_delay + CUES.forecast_margin
        if self._ticks % CUES.forecast_interval == 0:
            self.outlook = self._book.outlook(time, flown)
        self._ticks += 1
        return time >= self._ready_at or not self._foresees

    def has_pending_work(self, time: float) -> bool:
        return self._book.has_pending_work(time)

    def run_slice(self) -> None:
        self._book.run_slice(CUES.work_slice)


def _estimates_of(aircraft: Aircraft | None, rate: float) -> FlightEstimates | None:
    """Return the regression; None where no aircraft or too low a rate allows it."""
    if aircraft is None:
        return None
    try:
        return FlightEstimates(aircraft, rate)
    except FlightError:
        return None
