"""Fetching a log into a flight: over the link, to the disk, and in force."""

from __future__ import annotations

import contextlib
import json
import shutil
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import IO, Final, Self

from gsapp.decoding.framing import frame_system
from gsapp.decoding.health import LinkHealth
from gsapp.decoding.notices import NoticeLog
from gsapp.decoding.sender_filter import SenderFilter
from gsapp.flight.events import events_path, read_selected_system
from gsapp.flight.file_names import FRAMES_FILE, SENDERS_FILE
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files import FrameFile, read_tlog
from gsapp.flight.raw_files.record_files import SendersFile
from gsapp.foundation import FlightError, LinkError, write_atomically
from gsapp.foundation.errors import format_os_error
from gsapp.foundation.file_lock import FileLock, lock_holder
from gsapp.foundation.files import flush_to_disk, move_into_place
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.log_download.log_protocol import (
    DownloadState,
    LogDownloadProtocol,
    LogEntry,
    MissingRanges,
)
from gsapp.telemetry.recorder_control import (
    RecorderHandle,
    find_recorder,
    find_recorders,
    start_recorder,
)
from gsapp.telemetry.send_queue import request_send
from gsapp.telemetry.settings import TELEMETRY

_MAGICS = ((b"\xa3\x95", ".bin"), (b"ULog\x01\x12\x35", ".ulg"))
_TLOG_MAGICS = (0xFD, 0xFE)


class PartialLog:
    """The bytes that have come, and a note of those that have not.

    The note is never ahead of the bytes: it is written after they are on the disk. Whatever kills
    the program, at most the last seconds are asked for again. What lies in the folder of the very
    same log is gone on with. Raise FlightError if the folder cannot be written to.
    """

    def __init__(self, folder: Path, entry: LogEntry) -> None:
        self.entry = entry
        self.path = folder / f"onboard-{entry.id}.part"
        self._note = folder / f"onboard-{entry.id}.json"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.missing = self._found()
            mode = "r+b" if self.path.exists() else "w+b"
            self._stream: IO[bytes] = self.path.open(mode, buffering=0)
            self._stream.truncate(entry.size)
        except OSError as error:
            raise self._refusal(error) from error

    def write(self, offset: int, data: bytes) -> None:
        """Write bytes at their place.

        Raise FlightError if the disk refuses.
        """
        try:
            self._stream.seek(offset)
            self._stream.write(data)
        except OSError as error:
            raise self._refusal(error) from error

    def save(self) -> None:
        """See what came onto the disk, then note it.

        Raise FlightError if the disk refuses.
        """
        try:
            flush_to_disk(self._stream.fileno())
            write_atomically(
                self._note,
                json.dumps({"log": self._identity(), "missing": self.missing.ranges}),
            )
        except OSError as error:
            raise self._refusal(error) from error

    def close(self) -> None:
        """Give the file back. May be called twice."""
        self._stream.close()

    def finish(self) -> Path:
        """Give the whole log its name, with the ending that its first bytes call for.

        Raise FlightError if it is of no kind that can be read, or the disk refuses.
        """
        self.save()
        self.close()
        ending = log_file_suffix(self.path)
        if not ending:
            raise FlightError(
                f"log {self.entry.id} of the autopilot is of no kind that can be read; its "
                f"bytes are in {self.path}"
            )
        whole = self.path.with_suffix(ending)
        try:
            move_into_place(self.path, whole)
        except OSError as error:
            raise self._refusal(error) from error
        with contextlib.suppress(OSError):
            self._note.unlink(missing_ok=True)
        return whole

    def _identity(self) -> list[int]:
        entry = self.entry
        return [entry.id, entry.size, entry.time_utc, entry.system]

    def _found(self) -> MissingRanges:
        """Return what is missing of what lies there; all where it is of another log."""
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
            note = json.loads(self._note.read_bytes())
            if note["log"] == self._identity() and self.path.stat().st_size == self.entry.size:
                return MissingRanges(self.entry.size, note["missing"])
        self._note.unlink(missing_ok=True)
        return MissingRanges(self.entry.size)

    def _refusal(self, error: OSError) -> FlightError:
        return FlightError(
            f"{self.path} cannot be written ({error.strerror or error}); check the permissions "
            "and the space on the disk"
        )


def log_file_suffix(path: Path) -> str:
    """Return the ending that a log's first bytes call for; empty where their kind is not known."""
    with path.open("rb") as stream:
        head = stream.read(16)
    for magic, ending in _MAGICS:
        if head.startswith(magic):
            return ending
    return ".tlog" if len(head) > 8 and head[8] in _TLOG_MAGICS else ""


DOWNLOAD_LOCK: Final = "lock"
"""Held by a download at work, beside what it fetches."""
LINK_FOLDER: Final = "line"
"""Where a recorder that is started for a download records to."""


class RecorderLink:
    """Hear what a running recorder records from now on, and ask it to send.

    Only the flown system is heard, and only from where it is taken from in the flight: a stranger
    on the network would have its bytes in the log.

    One's `own` was started for this alone: it is then stopped, and its record thrown away.
    """

    def __init__(self, handle: RecorderHandle, *, own: bool) -> None:
        self._handle = handle
        self._own = own
        self._system, address = read_selected_system(events_path(handle.folder))
        self._health = LinkHealth()
        self._filter = SenderFilter(
            self._health, NoticeLog(lambda _stamp: None), self._system, address
        )
        self._senders = SendersFile(handle.folder / SENDERS_FILE)
        # Each system is where its first heartbeat was, in the flight as here.
        self._file = FrameFile(handle.folder / FRAMES_FILE)
        self._file.read(self._file.size(), blocks=1)
        self._take_accepted()
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
        frames = self._take_accepted()
        if not frames and not self._handle.is_alive():
            raise LinkError(
                f"the recorder in {self._handle.folder} has ended; start again: the download "
                "resumes"
            )
        return frames

    def _take_accepted(self) -> list[bytes]:
        labeled = self._senders.label(list(self._file.records))
        self._file.records.clear()
        frames = [record.data for record in self._filter.feed(labeled)]
        # The first that was pinned, where the crew chose none; none over a link without addresses.
        flown = self._system or next(iter(self._health.addresses), None)
        return [frame for frame in frames if flown in (None, frame_system(frame))]

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
    """Read a LINK over which an autopilot can be asked for its logs; raise LinkError for others."""
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


def _join(handle: RecorderHandle) -> RecorderLink:
    """Use a recorder at work; raise LinkError if it sends nothing."""
    status = handle.status()
    if status is not None and status.listen_only:
        raise LinkError(
            f"the recorder of {status.link} listens only, and logs have to be asked for; stop it, "
            "and record without listen-only"
        )
    return RecorderLink(handle, own=False)


def open_recorder_link(
    link: str, flight: Path, folder: Path, signing_key: str = ""
) -> RecorderLink:
    """Find the recorder that owns a link, or start one for as long as it is needed.

    An empty link is that of the recorder at work on the flight. A recorder that is started records
    inside the folder of the download, whose lock is held. Raise FlightError if no link is given and
    nothing records into the flight, LinkError if the link cannot be opened.
    """
    at_work = find_recorder(flight)
    if at_work is not None:
        status = at_work.status()
        if not link or (status is not None and status.link == link):
            return _join(at_work)
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
            return _join(handle)
    scratch = folder / LINK_FOLDER
    with contextlib.suppress(OSError):
        shutil.rmtree(scratch)
    # Many autopilots speak only to who gives a sign of life. A download that is killed takes its
    # recorder with it, so that the link is free.
    handle = start_recorder(
        link, scratch, heartbeat=True, signing_key=signing_key, while_held=folder / DOWNLOAD_LOCK
    )
    return RecorderLink(handle, own=True)


_FOLDER = "download"


@dataclass(frozen=True, slots=True, kw_only=True)
class DownloadedLog:
    """A whole log on the disk."""

    path: Path  # In the cache of the flight, to be put in force or thrown away.
    entry: LogEntry  # What the autopilot says of it.
    start_time: datetime | None
    """When it was begun, by the autopilot; None where that did not know the time."""


class LogFetcher:
    """Fetches logs of the autopilot into the cache of a flight.

    A context: on leaving, the conversation is ended and a recorder started for it is stopped.
    What came of a log that is not whole stays in the cache, so that the next one goes on. Raise
    FlightError or LinkError if there is no such flight, the link cannot be opened, or another
    download is at work on this flight.

    Parameters
    ----------
    link : str
        The LINK; empty for that of the recorder at work on the flight.
    signing_key : str
        File of the MAVLink signing key, for a link that no recorder owns; empty for none.
    stop : threading.Event, optional
        Set it, from any thread, to end what is going on.
    tell : callable
        Called a few times a second with a `DownloadState`.
    """

    def __init__(
        self,
        flight: Path | str,
        link: str = "",
        *,
        signing_key: str = "",
        stop: threading.Event | None = None,
        tell: Callable[[DownloadState], None] = lambda _: None,
    ) -> None:
        self._flight = FlightFolder.open(flight)
        self._scratch = self._flight.cache_folder / _FOLDER
        self._stop = stop or threading.Event()
        self._tell = tell
        self._next_tell = 0.0
        self._part: PartialLog | None = None
        self._conversation = LogDownloadProtocol(self._keep)
        self._lock = self._locked()
        try:
            self._line = open_recorder_link(
                link, self._flight.path.absolute(), self._scratch, signing_key
            )
        except BaseException:
            self._lock.release()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if self._part is not None:
                with contextlib.suppress(FlightError, ValueError):
                    self._part.save()
                self._part.close()
            with contextlib.suppress(LinkError):
                self._line.send(self._conversation.pack_request_end())
                time.sleep(5.0 * TELEMETRY.fetch_interval)  # until the recorder has passed it on
            self._line.close()
        finally:
            self._lock.release()

    @property
    def stopped(self) -> bool:
        return self._stop.is_set()

    def list_logs(self) -> tuple[LogEntry, ...]:
        """Return the logs that the autopilot has, the oldest first; none if stopped.

        Raise LinkError if nothing answers, or the aircraft is armed.
        """
        talk = self._conversation
        self._converse(("listed",))
        return tuple(talk.entries[number] for number in sorted(talk.entries))

    def select(self, number: int | None = None) -> LogEntry | None:
        """Return the log to fetch: that of a number, else the one begun nearest the flight.

        None if stopped. Autopilots that do not know the time have it on none of their logs; their
        last one counts. Raise LinkError if there is no such log, or none at all.
        """
        entries = self.list_logs()
        if self.stopped:
            return None
        if not entries:
            raise LinkError(
                "the autopilot holds no log; check that it logs (ArduPilot: LOG_BACKEND_TYPE), "
                "or remove the card and import the file"
            )
        if number is not None:
            for entry in entries:
                if entry.id == number:
                    return entry
            there = ", ".join(str(entry.id) for entry in entries)
            raise LinkError(f"the autopilot holds no log {number}; it has {there}")
        began = self._began()
        dated = [entry for entry in entries if entry.time_utc > TELEMETRY.clock_unset]
        if began is None or not dated:
            return entries[-1]
        return min(dated, key=lambda entry: (abs(entry.time_utc - began), -entry.id))

    def fetch(self, entry: LogEntry) -> DownloadedLog | None:
        """Fetch a log as far as it is not there yet; None if stopped.

        What came is always kept. Raise LinkError if nothing comes any more, or the recorder ends,
        FlightError if the disk refuses.
        """
        self._part = PartialLog(self._scratch, entry)
        self._conversation.fetch(entry, self._part.missing)
        self._converse(("done",))
        if self.stopped and self._part.missing:
            return None
        path = self._part.finish()
        self._part = None
        begun = None
        if entry.time_utc > TELEMETRY.clock_unset:
            begun = datetime.fromtimestamp(entry.time_utc, UTC)
        return DownloadedLog(path=path, entry=entry, start_time=begun)

    def _converse(self, until: tuple[str, ...]) -> None:
        """Hear and ask until a phase is reached, or all is stopped."""
        talk = self._conversation
        next_save = time.monotonic() + TELEMETRY.save_interval
        while talk.phase not in until and not self.stopped:
            now = time.monotonic()
            for frame in self._line.receive_frames():
                talk.receive_frame(frame, now)
            for frame in talk.pending_requests(now):
                self._line.send(frame)
            self._say(now)
            if talk.phase == "failed":
                raise LinkError(self._failure(talk.state(now).why))
            if self._part is not None and now >= next_save:
                next_save = now + TELEMETRY.save_interval
                self._part.save()
            if talk.phase not in until:
                self._stop.wait(TELEMETRY.fetch_interval)
        self._next_tell = 0.0
        self._say(time.monotonic())

    def _failure(self, why: str) -> str:
        text = self._line.link_state_text()
        return f"{why} ({text})" if text else why

    def _say(self, now: float) -> None:
        if now >= self._next_tell:
            self._next_tell = now + TELEMETRY.progress_interval
            self._tell(self._conversation.state(now))

    def _keep(self, offset: int, data: bytes) -> None:
        if self._part is not None:
            self._part.write(offset, data)

    def _began(self) -> float | None:
        """Return when the flight began, s since 1970."""
        if self._flight.tlog_file.is_file():
            first = next(iter(read_tlog(self._flight.tlog_file)), None)
            if first is not None:
                return first.stamp_us * 1e-6
        info = self._flight.info()
        return info.date.timestamp() if info is not None and info.date is not None else None

    def _locked(self) -> FileLock:
        try:
            self._scratch.mkdir(parents=True, exist_ok=True)
            lock = FileLock(self._scratch / DOWNLOAD_LOCK)
            free = lock.acquire(patience=0.2)
        except OSError as error:
            raise FlightError(
                f"{self._scratch} cannot be written ({error.strerror or error}); check the "
                "permissions"
            ) from error
        if not free:
            raise LinkError(
                f"a log is being fetched into {self._flight.path} already; wait for that, or "
                "cancel it there"
            )
        return lock
