"""What became of a flight's on-board log: in place, and by which clock, or left out, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from gsapp.flight.settings import ALIGNMENT

_PER_MILLION = 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class LogClock:
    """How the clock of an on-board log stands to flight time.

    Flight time is ``t + offset - drift * (t - at)``, with `t` the log's own.
    """

    offset: float
    """To be added to the log's time in the middle of what both hold, s."""
    offset_std: float
    """Its standard deviation, s."""
    drift: float
    """Seconds by which the log's clock gains in a second; 40e-6 is 40 ppm fast."""
    drift_std: float | None
    """Its standard deviation; None where the two share too little time to tell."""
    drifts: bool
    """Whether the drift is beyond doubt and corrected."""
    at: float
    """The log's own time in the middle, s."""
    correlation: float
    """Of the two records there, 0 to 1."""
    windows: int
    agreeing: int
    """Stretches of motion that were compared, and those that follow these clocks."""

    @property
    def applied_drift(self) -> float:
        """Return the drift that is corrected; 0 where it is in doubt."""
        return self.drift if self.drifts else 0.0

    def describe(self) -> str:
        """Return offset, drift and their uncertainties in a sentence."""
        if (
            abs(self.offset) < max(ALIGNMENT.reported_offset, self.offset_uncertainty)
            and not self.drifts
        ):
            within = f"{1e3 * self.offset_uncertainty:.1f} ms"
            text = f"its clock agrees with the live record's within {within}"
        else:
            text = (
                f"its clock differs by {self.offset:.3f} s (standard deviation "
                f"{1e3 * self.offset_std:.1f} ms)"
            )
        if self.drifts and self.drift_std is not None:
            way = "gains" if self.drift > 0.0 else "loses"
            text += (
                f" and {way} {abs(self.drift) * _PER_MILLION:.1f} ppm (standard deviation "
                f"{self.drift_std * _PER_MILLION:.1f}), which is corrected"
            )
        elif self.drift_std is not None:
            most = abs(self.drift) + 2.0 * self.drift_std
            text += f"; no drift beyond {most * _PER_MILLION:.1f} ppm is seen"
        else:
            text += "; too little motion to see a drift"
        stretches = "stretch" if self.windows == 1 else "stretches"
        return (
            f"{text}, found by comparing channels (correlation {self.correlation:.3f}, "
            f"{self.agreeing} of {self.windows} {stretches} of motion agree)"
        )

    @property
    def offset_uncertainty(self) -> float:
        """Return two standard deviations of the offset, s, but no less than a tenth of a ms."""
        return max(2.0 * self.offset_std, 1e-4)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnboardLogState:
    """What became of the on-board log of a flight."""

    file: str
    """Its name in the flight folder."""
    in_place: bool
    """Whether its samples stand in the flight."""
    why: str = ""
    """Why not; empty otherwise."""
    channels: int = 0
    """How many it holds."""
    clock: LogClock | None = None
    """None where it was left out, or there is no live record to compare it with."""

    def remark(self) -> str:
        """Return it in a sentence."""
        if not self.in_place:
            return f"the on-board log {self.file} is not used: {self.why}"
        text = (
            f"the on-board log {self.file} replaces the live record where it has samples "
            f"({self.channels} channels)"
        )
        return text if self.clock is None else f"{text}; {self.clock.describe()}"

    def to_json(self) -> dict[str, Any]:
        """Return it for programs: seconds; drifts as pure numbers, 40e-6 is 40 ppm."""
        return asdict(self)

    @staticmethod
    def from_json(content: Mapping[str, Any]) -> OnboardLogState:
        """Return what `to_json` gave."""
        clock = content["clock"]
        return OnboardLogState(**{**content, "clock": None if clock is None else LogClock(**clock)})
