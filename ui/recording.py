"""What begins a live flight: the folder with all that is in force, recorders, the aircraft."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gsapp.flight.preparing import prepare_flight
from gsapp.telemetry.recorder_control import RecorderHandle, find_recorders
from gsapp.telemetry.virtual.process import AircraftProcess
from ui.dialogs.requests import ConnectRequest, VirtualRequest


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningRecorder:
    """A recorder found running.

    Attributes
    ----------
    handle : RecorderHandle
        To attach to.
    name : str
        Of the flight.
    link : str
        What it records.
    """

    handle: RecorderHandle
    name: str
    link: str


def running_recorders() -> tuple[RunningRecorder, ...]:
    """Return the recorders of this user that run now, the newest first."""
    found = []
    for handle in reversed(find_recorders()):
        status = handle.status()
        link = status.link if status is not None else "its link"
        found.append(RunningRecorder(handle=handle, name=handle.folder.name, link=link))
    return tuple(found)


def prepare_folder(request: ConnectRequest) -> Path:
    """Make the flight folder with copies of everything in force; see `prepare_flight`."""
    return prepare_flight(
        request.folder,
        aircraft=request.aircraft,
        channel_map=request.channel_map,
        calibration=request.calibration,
        source=request.link,
    ).path


def launch(request: VirtualRequest, port: int) -> AircraftProcess:
    """Let the virtual aircraft fly as asked for, sending to a UDP port of this machine."""
    return AircraftProcess(
        request.folder,
        port,
        plan=request.plan,
        seed=request.seed,
        speed=request.speed,
        hidden=request.hidden,
        thin=request.thin,
    )
