"""The link as a download needs it: through the recorder, which alone owns it."""

from __future__ import annotations

import contextlib
import shutil
from pathlib import Path
from typing import Final

from gsapp.flight.file_names import FRAMES_FILE
from gsapp.flight.raw_files import FrameFile
from gsapp.foundation import FlightError, LinkError
from gsapp.foundation.file_lock import lock_holder
from gsapp.foundation.os_error_text import format_os_error
from gsapp.telemetry.link_address import LinkAddress
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.recorder_control import (
    RecorderHandle,
    find_recorder,
    find_recorders,
    start_recorder,
)
from gsapp.telemetry.send_queue import request_send

DOWNLOAD_LOCK: Final = "lock"
"""Held by a download at work, beside what it fetches."""
LINK_FOLDER: Final = "line"
"""Where a recorder that is started for a download records to."""


class RecorderLink:
    """Hear what a recorder records from now on, and ask it to send.

    Parameters
    ----------
    handle : RecorderHandle
        It runs.
    own : bool
        Whether it was started for this alone: it is then stopped, and its record thrown away.
    """

    def __init__(self, handle: RecorderHandle, *, own: bool) -> None:
        self._handle = handle
        self._own = own
        self._file = FrameFile(handle.folder / FRAMES_FILE)
        size = self._file.size()
        self._file.seek_end(size)
        self._file.read(size)
        self._file.records.clear()

    def receive_frames(self) -> list[bytes]:
        """Return the frames that have come since the last call.

        Raise LinkError if the recorder has ended.
        """
        size = self._file.size()
        if size > self._file.position:
            self._file.read(size)
        frames = [record.data for record in self._file.records]
        self._file.records.clear()
        if not frames and not self._handle.is_alive():
            raise LinkError(
                f"the recorder in {self._handle.folder} has ended; start again: the download "
                "resumes"
            )
        return frames

    def send(self, frame: bytes) -> None:
        """Have a frame sent.

        Raise LinkError if the recorder cannot be asked.
        """
        try:
            request_send(self._handle.folder, frame)
        except OSError as error:
            what = f"a question to the recorder in {self._handle.folder}"
            raise LinkError(format_os_error(what, error, "check the permissions")) from error

    def link_state_text(self) -> str:
        status = self._handle.status()
        return status.source_state if status is not None else ""

    def close(self) -> None:
        """Leave a recorder of others running; end one's own and take its record away."""
        if self._own:
            self._own = False
            if self._handle.stop():
                shutil.rmtree(self._handle.folder, ignore_errors=True)


def parse_log_link(text: str) -> LinkAddress:
    """Read a LINK over which an autopilot can be asked for its logs.

    Parameters
    ----------
    text : str
        As typed.

    Raises
    ------
    LinkError
        If it is none, or one over which no such messages go.
    """
    address = parse_link(text)
    if not kind_of(address).accepts_commands:
        raise LinkError(
            f"no log can be requested over '{text}'; name a link for MAVLink, such as "
            "serial:/dev/ttyACM0:115200"
        )
    return address


def _is_orphaned(place: Path, ours: Path) -> bool:
    """Return whether a recorder was started for a download that was killed."""
    if place.name != LINK_FOLDER:
        return False
    lock = place.parent / DOWNLOAD_LOCK
    return place.parent == ours.absolute() or (lock.is_file() and lock_holder(lock) is None)


def open_recorder_link(link: str, flight: Path, folder: Path) -> RecorderLink:
    """Find the recorder that owns a link, or start one for as long as it is needed.

    Parameters
    ----------
    link : str
        The LINK; empty for that of the recorder at work on the flight.
    flight : Path
        The flight folder.
    folder : Path
        Of the download, whose lock is held; a recorder that is started records inside.

    Raises
    ------
    FlightError
        If no link is given and nothing records into the flight.
    LinkError
        If the link cannot be opened.
    """
    at_work = find_recorder(flight)
    if at_work is not None:
        status = at_work.status()
        if not link or (status is not None and status.link == link):
            return RecorderLink(at_work, own=False)
    if not link:
        raise FlightError(
            f"no recorder is writing {flight}; link unknown; name it, such as "
            "serial:/dev/ttyACM0:115200"
        )
    parse_log_link(link)
    for handle in find_recorders():
        status = handle.status()
        if status is not None and status.link == link:
            if _is_orphaned(handle.folder, folder) and handle.stop():
                continue  # it was about to end by itself
            return RecorderLink(handle, own=False)
    scratch = folder / LINK_FOLDER
    with contextlib.suppress(OSError):
        shutil.rmtree(scratch)
    # Many autopilots speak only to who gives a sign of life. A download that is killed takes its
    # recorder with it, so that the link is free.
    handle = start_recorder(link, scratch, heartbeat=True, while_held=folder / DOWNLOAD_LOCK)
    return RecorderLink(handle, own=True)
