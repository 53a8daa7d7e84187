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
    """Where a replay is and how it runs; times are flight times, s.

    Attributes
    ----------
    time, start, end : float
        Of the playhead, and of the first and last sample known.
    playing : bool
        Whether it moves.
    speed : float
        Times real time; infinite for as fast as it goes.
    complete : bool
        Whether `end` is the end of the flight; the record is read ahead.
    at_end : bool
        Whether the playhead has arrived there.
    """

    time: float
    start: float
    end: float
    playing: bool
    speed: float
    complete: bool
    at_end: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionSnapshot:
    """What the bar shows at one moment.

    Attributes
    ----------
    name : str
        Of the flight.
    path : Path
        Its folder or file.
    mode : {"live", "replay"}
        Whether it is happening.
    now : float or None
        Flight time, s; None before the first sample.
    is_up_to_date : bool
        Whether all that was recorded, or played, is in the history.
    monitored_fraction : float
        How much of it was looked through for alarms and cues, 0 to 1.
    progress : float
        Share of the record that was read, 0 to 1.
    link, recorder, disk
        The equipment. In a replay only the counts of the link mean anything.
    aircraft, channel_map : str
        Names; empty where there is none.
    calibration : tuple of str
        Instruments with a certificate in force, sorted.
    uncalibrated : tuple of str
        Channels whose instruments have none and give volts only, sorted.
    calibration_status : CalibrationStatus
        Whether they count.
    alarms : tuple of Alarm
        Those that stand, newest first.
    unacknowledged_count : int
        How many of them nobody has acknowledged.
    playhead : Playhead or None
        None while live, and before the first sample of a replay was read.
    problem : str
        Why nothing is decoded, or the record cannot be read, in words; empty otherwise.
    """

    name: str
    path: Path
    mode: SessionMode
    now: float | None
    is_up_to_date: bool
    monitored_fraction: float
    progress: float
    link: LinkSummary
    recorder: RecorderSummary
    disk: DiskSummary
    aircraft: str
    channel_map: str
    calibration: tuple[str, ...]
    uncalibrated: tuple[str, ...]
    calibration_status: CalibrationStatus
    alarms: tuple[Alarm, ...]
    unacknowledged_count: int
    playhead: Playhead | None
    problem: str
