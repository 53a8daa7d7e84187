"""A flight, whatever file it came from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsapp.flight.certificates import (
    AppliedCertificates,
    calibration_remarks,
    count_samples_out_of_range,
    uncalibrated_channels,
)
from gsapp.flight.events import Event
from gsapp.flight.info import FlightInfo
from gsapp.flight.onboard_log.log_state import OnboardLogState
from gsapp.flight.uniform_grid import median_step
from gsapp.quantities import Block

if TYPE_CHECKING:
    from gsapp.decoding.decoder import ChannelSource


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameCounts:
    """What became of the frames of a record."""

    good: int
    """Frames with a good checksum and a known id."""
    damaged: int
    """Pieces of bytes that belong to no whole frame."""
    unknown: int
    """Whole frames of an id outside the dialect, so that they could not be checked."""
    lost: int
    """Frames missing by their sequence numbers."""
    lines: int = 0
    """Lines of text that were read."""
    bad_lines: int = 0
    """Lines of text that were left out."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Flight:
    """A whole flight in engineering units."""

    name: str
    """As the crew calls it; else the name of the file."""
    path: Path
    """The folder or file it was read from."""
    block: Block
    """All channels on one uniform grid. Pauses without any sample longer than
    `FLIGHT_DATA.max_filled_gap` are left out but for one missing row at either
    end."""
    sources: Mapping[str, ChannelSource]
    """Where each channel came from, and whether it was measured."""
    info: FlightInfo | None = None
    """From ``flight.toml``."""
    frames: FrameCounts | None = None
    """None where the flight was not recorded as frames."""
    events: tuple[Event, ...] = ()
    """Marks, notes and alarms, and what the vehicle said."""
    remarks: tuple[str, ...] = ()
    """What was lost or left out on reading, and how it was read, in words."""
    certificates: AppliedCertificates = field(default_factory=AppliedCertificates)
    """With which volts became engineering units."""
    onboard: OnboardLogState | None = None
    """What became of the on-board log; None where the flight has none, or only the live record was
    read."""
    native: bool = False
    """Whether `block` has the samples at their own times instead of a grid."""

    @property
    def uncalibrated_channels(self) -> tuple[str, ...]:
        return uncalibrated_channels(self.sources)

    @property
    def calibration_remarks(self) -> tuple[str, ...]:
        """Return what is to be said of the calibration behind the numbers; part of `remarks`."""
        return calibration_remarks(self.certificates, self.sources, self.block)

    def calibration_json(self) -> dict[str, Any]:
        """Return the certificates behind the numbers, and what lacks them, for programs.

        ``uncalibrated`` lists channels that had none, ``beyond`` counts the samples of channels
        outside the range that was calibrated.
        """
        return {
            **self.certificates.to_json(),
            "uncalibrated": list(self.uncalibrated_channels),
            "beyond": count_samples_out_of_range(self.certificates, self.sources, self.block),
        }

    @property
    def rate(self) -> float:
        """Return the samples per second of the grid; NaN for fewer than two samples, or no grid."""
        return math.nan if self.native else 1.0 / median_step(self.block.times)

    @property
    def duration(self) -> float:
        times = self.block.times
        return float(times[-1] - times[0]) if times.size else 0.0
