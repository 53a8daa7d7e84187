"""Finding a turn of the turntable as it happens: rest, turn, rest.

Judged in stretches of a tenth of a second, counted from time zero, so that the result does not
depend on how the samples were cut. Any gyro that moves makes a turn, since the one that is asked
for may be dead or swapped.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from calibration.inertial.gyros import GYROS, Turn, evaluate_turn
from calibration.inertial.straight_line import FactoryCalibration, factory_calibrations
from calibration.points import CalibrationError
from calibration.rest_detection import SampleSegment, SampleSegmenter
from calibration.settings import INERTIAL

TurnState = Literal["unsettled", "ready", "turning", "stopping", "turned"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnStatus:
    """How a turn goes on."""

    state: TurnState
    """Not yet at rest; at rest, so turn now; turning; at rest after it; over."""
    angle: float = 0.0
    """By the factory's scale of the gyro that moves most, deg, unsigned."""
    rate: float = 0.0
    """Now, deg/s, likewise."""
    seconds: float = 0.0
    """Since the turn began."""


class TurnMonitor:
    """Watches gyros until the table was turned and stands still again.

    Parameters
    ----------
    channels : sequence of str
        All gyros that are recorded.
    least : float
        What counts as a turn, deg by the factory's scale. By default more than the quarter turn
        by which the aircraft is laid on its table; to be lowered where less is asked for.
    factory : mapping of str to FactoryCalibration, optional
        Volts per unit; of the model airliner by default.
    """

    def __init__(
        self,
        channels: Sequence[str] = GYROS,
        *,
        least: float = INERTIAL.min_turn,
        factory: Mapping[str, FactoryCalibration] | None = None,
    ) -> None:
        self._factory = factory or factory_calibrations()
        self._channels = tuple(channels)
        self._least = least
        self._cutter = SampleSegmenter(self._channels, INERTIAL.averaging)
        self._per_unit = np.array([abs(self._factory[name].sensitivity) for name in channels])
        self.restart()

    def restart(self) -> None:
        """Forget what was; the table must rest before the next turn."""
        self._cutter.restart()
        self._kept: deque[SampleSegment] = deque()
        self._state: TurnState = "unsettled"
        self._quiet = self._onset = 0
        self._rest: list[npt.NDArray[np.float64]] = []
        self._zero = np.zeros(len(self._channels))
        self._swept = np.zeros(len(self._channels))
        self._rate = 0.0
        self._began = self._ended = 0.0

    def feed(self, times: npt.ArrayLike, volts: Mapping[str, npt.ArrayLike]) -> None:
        for stretch in self._cutter.feed(times, volts):
            if self._over:
                return
            self._judge(stretch)
            self._kept.append(stretch)
            while (
                self._state in ("unsettled", "ready")
                and len(self._kept) > INERTIAL.max_rest_segments
            ):
                self._kept.popleft()

    @property
    def _over(self) -> bool:
        return self._state == "turned"

    @property
    def status(self) -> TurnStatus:
        if self._state in ("unsettled", "ready"):
            return TurnStatus(state=self._state, rate=self._rate)
        return TurnStatus(
            state=self._state,
            angle=float(np.max(np.abs(self._swept))),
            rate=self._rate,
            seconds=self._ended - self._began,
        )

    def detected_turn(self, channel: str, angle: float) -> Turn:
        """Return the turn that was seen, about the axis of a gyro, through a known angle (deg).

        Raises
        ------
        CalibrationError
            If the turn is not over, or its record has gaps.
        """
        if self._state != "turned":
            raise CalibrationError("the turn is not finished; turn the table and hold it still")
        times = np.concatenate([stretch.times for stretch in self._kept])
        volts = np.concatenate([stretch.volts for stretch in self._kept])
        return evaluate_turn(
            channel,
            times,
            {name: volts[:, index] for index, name in enumerate(self._channels)},
            angle=angle,
            turning=(self._began, self._ended),
            factory=self._factory,
        )

    def _judge(self, stretch: SampleSegment) -> None:
        start = stretch.number * INERTIAL.averaging
        # A gyro without samples stands still, as far as anybody can tell.
        mean = np.where(np.isfinite(stretch.mean), stretch.mean, self._zero)
        if self._state == "unsettled":
            self._settle(mean)
            return
        rates = (mean - self._zero) / self._per_unit
        self._rate = float(rates[np.argmax(np.abs(rates))])
        quiet = bool(np.all(np.abs(rates) <= INERTIAL.turn_edge_rate))
        if self._state != "ready":
            self._follow(start, rates, quiet=quiet)
        elif quiet:
            self._onset = 0
            self._swept[:] = 0.0
            self._settle(mean)
        else:
            self._begin(start, rates)

    def _begin(self, start: float, rates: npt.NDArray[np.float64]) -> None:
        """Take a stretch that is no rest any more, and may be the beginning of a turn."""
        if self._onset == 0:
            self._began = start
        self._onset += 1
        self._follow(start, rates, quiet=False)
        if np.max(np.abs(rates)) <= INERTIAL.turning_rate:
            self._state = "ready" if self._onset < INERTIAL.ready_segments else "unsettled"
        if self._state == "unsettled":
            self._rest = []

    def _follow(self, start: float, rates: npt.NDArray[np.float64], *, quiet: bool) -> None:
        self._swept += rates * INERTIAL.averaging
        if not quiet:
            self._state, self._quiet = "turning", 0
            self._ended = start + INERTIAL.averaging
            return
        self._state = "stopping"
        self._quiet += 1
        if self._quiet >= INERTIAL.stopped_segments:
            if np.max(np.abs(self._swept)) >= self._least:
                self._state = "turned"
            else:
                self._state, self._rest = "unsettled", []

    def _settle(self, mean: npt.NDArray[np.float64]) -> None:
        """Take a stretch of rest; one that differs begins the rest anew."""
        if self._rest:
            off = np.abs(mean - np.mean(self._rest, axis=0)) / self._per_unit
            if np.any(off > 2.0 * INERTIAL.turn_edge_rate):
                self._rest = []
        self._rest = [*self._rest[-(INERTIAL.max_rest_segments - 1) :], mean]
        if len(self._rest) >= INERTIAL.ready_segments:
            self._zero = np.mean(self._rest, axis=0)
            self._onset = 0
            self._state = "ready"
