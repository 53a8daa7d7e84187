"""What a window shows of a session at one moment."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from calibration.validity import CalibrationStatus
from gsapp.session.alarms import Alarm
from gsapp.session.equipment_monitor import DiskSummary, LinkSummary, RecorderSummary

SessionMode = Literal["live", "replay"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Playhead:
    """Where a replay is and how it runs; times are flight times, s."""

    time: float
    start: float
    end: float
    """Of the playhead, and of the first and last sample known."""
    playing: bool
    speed: float
    """Times real time; infinite for as fast as it goes."""
    complete: bool
    """Whether `end` is the end of the flight; the record is read ahead."""
    at_end: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionSnapshot:
    """What the bar shows at one moment."""

    name: str
    path: Path
    mode: SessionMode
    now: float | None
    """Flight time, s; None before the first sample."""
    is_up_to_date: bool
    """Whether all that was recorded, or played, is in the history."""
    monitored_fraction: float
    """How much of it was looked through for alarms and cues, 0 to 1."""
    progress: float
    link: LinkSummary
    recorder: RecorderSummary
    disk: DiskSummary
    """The equipment. In a replay only the counts of the link mean anything."""
    aircraft: str
    channel_map: str
    """Names; empty where there is none."""
    calibration: tuple[str, ...]
    """Instruments with a certificate in force, sorted."""
    uncalibrated: tuple[str, ...]
    """Channels whose instruments have none and give volts only, sorted."""
    calibration_status: CalibrationStatus
    alarms: tuple[Alarm, ...]
    """Those that stand, newest first."""
    unacknowledged_count: int
    playhead: Playhead | None
    """None while live, and before the first sample of a replay was read."""
    problem: str
    """Why nothing is decoded, or the record cannot be read, in words; empty otherwise."""
