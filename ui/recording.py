"""What begins a live flight: the folder with all that is in force, recorders, the aircraft."""

from __future__ import annotations

import socket
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from calibration import load_certificates
from calibration.reading import FOLDER as CERTIFICATES
from gsapp.aircraft import load_aircraft
from gsapp.aircraft.reading import SHIPPED as AIRCRAFT
from gsapp.decoding.channel_map import SHIPPED as CHANNEL_MAPS
from gsapp.decoding.channel_map import load_channel_map
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.foundation import LinkError
from gsapp.telemetry.recorder_control import RecorderHandle, find_recorders
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
    """Make the flight folder with copies of everything in force, before the first byte comes.

    A folder that has them already keeps what the flight began with.

    Raises
    ------
    GroundStationError
        If the folder cannot be made, or one of the files holds mistakes.
    """
    aircraft = AIRCRAFT.find(request.aircraft)
    channel_map = CHANNEL_MAPS.find(request.channel_map)
    load_aircraft(aircraft)
    load_channel_map(channel_map)
    folder = FlightFolder.create(
        request.folder,
        FlightInfo(
            name=request.folder.name,
            source=request.link,
            aircraft=aircraft.stem,
            channel_map=channel_map.stem,
        ),
    )
    if not folder.aircraft_file.exists():
        folder.keep_aircraft(aircraft)
    if not folder.channel_map_file.exists():
        folder.keep_channel_map(channel_map)
    if request.calibration and not folder.certificate_files():
        folder.keep_certificates(certificate_files(request.calibration))
    return folder.path


def certificate_files(calibration: str) -> tuple[Path, ...]:
    """Return the certificates of a shipped set or of a folder."""
    load_certificates(calibration)
    folder = Path(calibration)
    if not folder.is_dir():
        folder = CERTIFICATES / calibration
    return tuple(sorted(folder.glob("*.toml")))


def free_port() -> int:
    """Return a UDP port of this machine that nobody listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class AircraftProcess:
    """The virtual aircraft, flown by a process of its own over a real link.

    Parameters
    ----------
    request : VirtualRequest
        How it flies.
    port : int
        UDP port of this machine that it sends to.

    Raises
    ------
    LinkError
        If the process cannot be started.
    """

    def __init__(self, request: VirtualRequest, port: int) -> None:
        command = [
            sys.executable, "-m", "gsapp.cli", "fly",
            "--to", f"udpout:127.0.0.1:{port}",
            "--seed", str(request.seed),
            "--speed", f"{request.speed:g}",
        ]  # fmt: skip
        if request.plan:
            command += ["--plan", request.plan]
        if request.thin:
            command.append("--thin")
        for effect in request.hidden:
            command += ["--hide", effect]
        words = request.folder / "virtual-aircraft.log"
        try:
            request.folder.mkdir(parents=True, exist_ok=True)
            with words.open("wb") as log:
                self._process = subprocess.Popen(
                    command,
                    cwd=request.folder,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=log,
                    start_new_session=sys.platform != "win32",
                )
        except OSError as error:
            raise LinkError(
                f"the virtual aircraft cannot be started ({error.strerror}); see {words}"
            ) from error
        self._words: Path = words
        self._told = False

    def complaint(self) -> str:
        """Return, once, why it ended if it failed; empty otherwise."""
        code = self._process.poll()
        if code in (None, 0) or self._told:
            return ""
        self._told = True
        lines = self._words.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        why = lines[-1] if lines else f"code {code}"
        return f"The virtual aircraft ended: {why}"

    def stop(self) -> None:
        """End the flight."""
        if self._process.poll() is None:
            self._told = True
            self._process.terminate()
            try:
                self._process.wait(timeout=5.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
