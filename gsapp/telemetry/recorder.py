"""The black box: whatever a source gives is framed and written, whatever else happens.

Four threads share the work, so that a slow disk never makes the system drop what arrives: one
reads and stamps, one (the caller's) frames and hands every batch to the operating system at once,
one flushes to the disk and tells the state, and one sends, which may wait for a port that is full.
"""

from __future__ import annotations

import contextlib
import os
import queue
import shutil
import threading
import time
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal

from gsapp.decoding.framing import (
    Framer,
    LineFramer,
    MavlinkFrame,
    Residue,
    TextLine,
    frame_message_id,
)
from gsapp.decoding.health import RADIO_MESSAGES
from gsapp.decoding.sender_filter import FrameOrigin
from gsapp.flight.file_names import FRAMES_FILE, LINES_FILE, STATUS_FILE, STOP_FILE
from gsapp.flight.raw_files import RawWriter
from gsapp.foundation import FlightError
from gsapp.foundation.errors import format_os_error
from gsapp.telemetry.clock import Clock
from gsapp.telemetry.flight_notes import EventExchange
from gsapp.telemetry.link_diagnosis import ContentSample
from gsapp.telemetry.recorder_status import RecorderStatus, write_status
from gsapp.telemetry.send_queue import GroundPacker, SendQueue
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.signing import SignatureVerifier
from gsapp.telemetry.sources import Chunk, LinkSource
from gsapp.telemetry.sources.link_source import RecordedChunk
from gsapp.telemetry.stream_server import StreamServer, pop_share_request

StreamItem = MavlinkFrame | Residue | TextLine


class PeerStream:
    """The framing of one peer of a link.

    Peers may send by turns and cut their frames anywhere; each is framed for itself. Offsets are
    those of the bytes in the order in which they came from all of them.
    """

    def __init__(self, framer: Framer | LineFramer, address: str = "") -> None:
        self.address = address  # of the peer; empty for a link without any
        self._framer = framer
        self._fed = 0
        self._starts: deque[tuple[int, int]] = deque()  # in the peer's stream, in the link's
        self.last_data = 0.0
        self.is_flushed = True

    @property
    def pending(self) -> int:
        return self._framer.pending

    def feed(self, data: bytes, offset: int) -> list[StreamItem]:
        """Take bytes that lie at an offset of the link; return what is decided."""
        last = self._starts[-1] if self._starts else None
        if last is None or offset - last[1] != self._fed - last[0]:
            self._starts.append((self._fed, offset))
        self._fed += len(data)
        return self._placed(self._framer.feed(data))

    def flush_complete(self) -> list[StreamItem]:
        return self._placed(self._framer.flush_complete())

    def flush(self) -> list[StreamItem]:
        return self._placed(self._framer.flush())

    def _placed(self, items: Sequence[StreamItem]) -> list[StreamItem]:
        placed: list[StreamItem] = []
        for item in items:
            self._forget(item.offset)
            if not isinstance(item, Residue):
                placed.append(item)
                continue
            start, stop = item.offset, item.offset + len(item.data)
            while start < stop:
                self._forget(start)
                local, offset = self._starts[0]
                end = min(stop, self._starts[1][0]) if len(self._starts) > 1 else stop
                part = item.data[start - item.offset : end - item.offset]
                placed.append(Residue(offset + start - local, part))
                start = end
        return placed

    def _forget(self, position: int) -> None:
        """Drop the stretches that lie before a position of the peer's stream."""
        while len(self._starts) > 1 and self._starts[1][0] <= position:
            self._starts.popleft()


class Recorder:
    """Record a source into a flight folder until told to stop.

    Parameters
    ----------
    heartbeat : bool
        Whether to send the ground station's sign of life once a second.
    listen_only : bool
        Whether to send nothing at all, whatever asks for it.
    signing_key : bytes, optional
        With it, signatures of what arrives are checked and noted, and what is sent is signed.
    signing_key_file : str
        Where it came from, for the status.
    on_status : callable
        Called with every status besides writing it into the folder.
    disk_free : callable
        Gives the room on the disk of a folder, bytes.
    server : StreamServer, optional
        Passes on what arrives; by default to nobody, until that is asked for in the folder.
    relocate : callable, optional
        Moves the writer to another folder, once its own was removed, renamed, replaced or made
        read-only; returns whether all that was recorded so far is there. Raises OSError or
        FlightError where that fails; it is tried again.
    """

    def __init__(
        self,
        source: LinkSource,
        writer: RawWriter,
        *,
        clock: Clock,
        heartbeat: bool = False,
        listen_only: bool = False,
        signing_key: bytes | None = None,
        signing_key_file: str = "",
        on_status: Callable[[RecorderStatus], None] = lambda _: None,
        disk_free: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        server: StreamServer | None = None,
        relocate: Callable[[], bool] | None = None,
    ) -> None:
        self.source = source
        self.writer = writer
        self.clock = clock
        self.received_bytes = 0
        self.last_data_us: int | None = None
        self._sample = ContentSample()
        self._sends_heartbeats = heartbeat and not listen_only
        self._listen_only = listen_only
        self._signing_key_file = signing_key_file
        self._heartbeats = 0
        self._verifier = (
            None if signing_key is None else SignatureVerifier(signing_key, clock.now_us())
        )
        self._packer = GroundPacker(self._verifier)
        self._signatures: Counter[str] = Counter()
        self._on_status = on_status
        self._disk_free = disk_free
        self._streams: OrderedDict[str, PeerStream] = OrderedDict()
        self._arrived: queue.SimpleQueue[list[Chunk]] = queue.SimpleQueue()
        self._outgoing: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._ended = threading.Event()
        self._written = threading.Event()
        self._started_us = clock.now_us()
        self._first_folder = writer.folder
        self._outbox = SendQueue(writer.folder)
        self._exchange = EventExchange(source)
        self._server = StreamServer(source.address) if server is None else server
        self._server.folder = writer.folder
        self._relocate = relocate
        self._relocation = ""
        self._folder_error = ""
        self._next_folder_check = 0.0
        self._rate = _Rate()
        self._last_batch_us = writer.last_stamp
        self._next_heartbeat = 0.0
        self._next_retry = 0.0

    def run(self, stop: threading.Event, give_up: threading.Event | None = None) -> None:
        """Record until `stop` is set, the stop file appears, or the source has finished.

        `stop` is set in the end. Where the disk does not take the last data, it is tried on until
        `give_up` is set, or the stop file appears again; without it that is given up at once.
        """
        reading = threading.Thread(target=self._read, name="reading", daemon=True)
        keeping = threading.Thread(target=self._keep, name="keeping", daemon=True)
        sending = threading.Thread(target=self._send, name="sending", daemon=True)
        self._remove_stop_file()
        pop_share_request(self.writer.folder)  # of a recorder before
        reading.start()
        keeping.start()
        sending.start()
        next_look = 0.0
        while not stop.is_set():
            with contextlib.suppress(queue.Empty):
                unsettled = any(not stream.is_flushed for stream in self._streams.values())
                self.write_chunks(
                    self._arrived.get(
                        timeout=TELEMETRY.flush_pause if unsettled else TELEMETRY.check_interval
                    )
                )
            now = time.monotonic()
            self.flush_idle_streams(now)
            self._tend(now)
            if now >= next_look:
                next_look = now + TELEMETRY.check_interval
                for frame in self._outbox.pop_frames():
                    self._ask_to_send(self._packer.repack(frame, self.clock.now_us()))
                if self._stop_file.exists() or (not reading.is_alive() and self._arrived.empty()):
                    break
        self._ended.set()
        self._outgoing.put(None)
        sending.join(timeout=TELEMETRY.final_sending_time)
        reading.join(timeout=10 * TELEMETRY.read_timeout)
        self.source.close()
        with contextlib.suppress(queue.Empty):
            while True:
                self.write_chunks(self._arrived.get_nowait())
        self._flush_streams()
        self._server.close()
        stop.set()
        self._check_folder()
        if give_up is not None:
            self._wait_for_room(give_up)
        self._written.set()
        keeping.join(timeout=5.0)
        self.finish()
        self._outbox.close()
        self._remove_stop_file()

    @property
    def _stop_file(self) -> Path:
        return self.writer.folder / STOP_FILE

    def _remove_stop_file(self) -> None:
        with contextlib.suppress(OSError):
            self._stop_file.unlink()

    def write_chunks(self, chunks: Sequence[Chunk]) -> None:
        for chunk in chunks:
            if isinstance(chunk, RecordedChunk):
                self._write_recorded(chunk)
                continue
            stamp, data, peer = chunk
            stream = self._streams.get(peer)
            if not data:
                if stream is not None:
                    del self._streams[peer]
                    self._write(stamp, stream.flush(), peer)
                continue
            if stream is None:
                stream = self._new_stream(stamp, peer)
            items = stream.feed(data, self.received_bytes)
            self.received_bytes += len(data)
            self.last_data_us = stamp
            self._sample.feed(data)
            stream.last_data = time.monotonic()
            stream.is_flushed = False
            self._write(stamp, items, peer)

    def _write_recorded(self, chunk: RecordedChunk) -> None:
        """Write what another recorder wrote under its stamp, which later items may share."""
        self.received_bytes += len(chunk.data)
        self.last_data_us = chunk.stamp_us
        self._sample.feed(chunk.data)
        self._last_batch_us = max(chunk.stamp_us, self._last_batch_us)
        self.writer.append(self._last_batch_us, chunk.items, chunk.origin)
        self._server.send(chunk.items)

    def flush_idle_streams(self, now: float) -> None:
        """Bring out what is whole of every peer that pauses."""
        for stream in self._streams.values():
            if not stream.is_flushed and now - stream.last_data > TELEMETRY.flush_pause:
                stream.is_flushed = True
                if stream.pending:
                    # It came with the last data; what waits to be taken may have come since.
                    self._write(self._last_batch_us + 1, stream.flush_complete(), stream.address)

    def finish(self) -> None:
        """Write what is pending, flush and close the files."""
        self._flush_streams()
        self.writer.close()

    def status(self, state: Literal["starting", "recording", "stopped"]) -> RecorderStatus:
        written, request = self.writer.state, self._server.request
        rate = self._rate.update(time.monotonic(), self.received_bytes)
        free: int | None = None
        with contextlib.suppress(OSError):
            free = self._disk_free(self.writer.folder)
        offset = self.source.clock_offset_us
        seconds = free / rate if free is not None and rate > 0.0 else None
        return RecorderStatus(
            pid=os.getpid(),
            link=str(self.source.address),
            folder=str(self.writer.folder.absolute()),
            moved_from=str(self._first_folder.absolute()) if self._relocation else "",
            state=state,
            started_us=self._started_us + offset,
            updated_us=self.clock.now_us() + offset,
            source_state="; ".join(filter(None, (self.source.state, self.source.unsent))),
            connected=self.source.connected,
            received_bytes=self.received_bytes,
            frames=written.frames,
            lines=written.lines,
            residue_bytes=written.residue_bytes,
            content=self._sample.kind,
            byte_rate=rate,
            last_data_us=self.last_data_us,
            disk_free_bytes=free,
            seconds_until_full=seconds,
            waiting_bytes=written.waiting_bytes,
            dropped_bytes=written.dropped_bytes + written.lost_bytes,
            unwritten_frames=written.unwritten[FRAMES_FILE],
            unwritten_lines=written.unwritten[LINES_FILE],
            error=self._error(),
            unconfirmed=written.is_unconfirmed,
            warnings=[*_disk_warnings(free, seconds), *_signature_warnings(self._signatures)],
            notes=[*written.notes, *filter(None, (self._relocation,))],
            listen_only=self._listen_only,
            sends_heartbeats=self._sends_heartbeats,
            heartbeats=self._heartbeats,
            signing_key="" if state == "stopped" else self._signing_key_file,
            signatures=dict(self._signatures),
            shares=self._server.status(),
            share_open=request.is_open,
            share_notes=request.takes_notes,
            sends_notes=self.source.sends_notes if self.source.connected else None,
            share_key="" if state == "stopped" else request.key_file,
            parent=os.getppid(),
            ahead_us=self.clock.correction_us + offset,
            clock_offset_us=offset,
        )

    def _error(self) -> str:
        written = self.writer.state
        if written.lost_bytes:
            return (
                f"The disk of {self.writer.folder} rejected the last {written.lost_records} "
                f"records, nor could {written.dropped_records} before them were lost."
                if written.dropped_bytes
                else f"The disk of {self.writer.folder} rejected the last "
                f"{written.lost_records} records."
            )
        sentences = [self._folder_error or written.error]
        if written.dropped_bytes:
            sentences = [
                written.error or "The disk was full for long.",
                f"{written.dropped_records} of the oldest records were lost.",
            ]
        if self._ended.is_set() and self._folder_error:
            sentences.append(
                "The recording ended but has no folder; stopping the recorder now discards "
                "unwritten data."
            )
        elif self._ended.is_set() and written.waiting_bytes:
            sentences.append(
                f"The record has ended, and {written.waiting_bytes / 1e3:.0f} kB are unwritten; "
                "stopping the recorder now discards them."
            )
        return " ".join(filter(None, sentences)) or written.sync_error

    def _flush_streams(self) -> None:
        for stream in self._streams.values():
            self._write(self._last_batch_us + 1, stream.flush(), stream.address)
        self._streams.clear()

    def _wait_for_room(self, give_up: threading.Event) -> None:
        """Go on trying to write what waits, until that is given up."""
        self._remove_stop_file()
        while not (self.writer.retry() and self._check_folder()):
            if self._stop_file.exists() or give_up.wait(TELEMETRY.retry_interval):
                return

    def _check_folder(self) -> bool:
        """Go on in another folder if this one is gone; return whether data reach the disk."""
        former = self.writer.folder
        if self._relocate is None or self.writer.is_folder_writable():
            self._folder_error = ""
            return True
        gone = f"The flight folder {former} was removed, renamed or made read-only."
        try:
            whole = self._relocate()
        except (OSError, FlightError) as error:
            cause = error.__cause__ if isinstance(error, FlightError) else error
            why = str(error)
            if isinstance(cause, OSError):
                why = format_os_error(
                    "A folder beside it", cause, "correct the permissions there", verb="made"
                )
            self._folder_error = f"{gone} {why}."
            return False
        here = self.writer.folder
        kept = "everything recorded so far" if whole else "what is received from now on"
        self._relocation = f"{gone} Recording continues in {here} with {kept}."
        self._folder_error = ""
        self._outbox = SendQueue(here)
        self._server.folder = here
        return True

    def _new_stream(self, stamp: int, peer: str) -> PeerStream:
        if len(self._streams) >= TELEMETRY.max_streams:
            _, oldest = self._streams.popitem(last=False)
            self._write(stamp, oldest.flush(), oldest.address)
        stream = PeerStream(self.source.new_framer(), peer)
        self._streams[peer] = stream
        return stream

    def _write(self, stamp: int, items: Sequence[StreamItem], peer: str) -> None:
        """Write what came at one time from a peer, in batches whose stamps rise.

        In a batch the residue comes first; where it came later, another batch begins, and so it
        does where the signature of a frame is found otherwise than that of the one before.
        """
        start = 0
        signatures = [self._verify(item) for item in items]
        for index in range(1, len(items) + 1):
            ends = index == len(items)
            if (
                ends
                or (isinstance(items[index], Residue) and not isinstance(items[index - 1], Residue))
                or (signatures[index] != signatures[index - 1])
            ):
                self._last_batch_us = max(stamp, self._last_batch_us + 1)
                origin = FrameOrigin(peer, signatures[index - 1])
                self.writer.append(self._last_batch_us, items[start:index], origin)
                self._server.send(items[start:index])
                start = index

    def _verify(self, item: StreamItem) -> str:
        """Return the state of the signature of a frame; empty where it is not checked."""
        if self._verifier is None or not isinstance(item, MavlinkFrame):
            return ""
        found = self._verifier.verify(item.data)
        if not (found == "unsigned" and frame_message_id(item.data) in RADIO_MESSAGES):
            self._signatures[found] += 1
        return found

    def _tend(self, now: float) -> None:
        if self._sends_heartbeats and now >= self._next_heartbeat:
            self._next_heartbeat = now + TELEMETRY.heartbeat_interval
            self._heartbeats += 1
            self._ask_to_send(self._packer.pack_heartbeat(self.clock.now_us()))
        if now >= self._next_folder_check:
            self._next_folder_check = now + TELEMETRY.folder_interval
            self._check_folder()
            if (request := pop_share_request(self.writer.folder)) is not None:
                self._server.change(request)
        if self.writer.state.error and now >= self._next_retry:
            self._next_retry = now + TELEMETRY.retry_interval
            self.writer.retry()

    def _ask_to_send(self, frame: bytes) -> None:
        if frame and not self._listen_only and self._outgoing.qsize() < TELEMETRY.max_unsent:
            self._outgoing.put(frame)

    def _send(self) -> None:
        while True:
            try:
                frame = self._outgoing.get(timeout=TELEMETRY.unsent_time)
            except queue.Empty:
                self.source.unsent = ""
                continue
            if frame is None:
                return
            try:
                self.source.write(frame)
            except Exception as error:  # as of reading
                self.source.unsent = f"cannot send ({error})"

    def _read(self) -> None:
        """Take from the source, and nothing else."""
        while not self._ended.is_set() and not self.source.finished:
            try:
                chunks = self.source.read(TELEMETRY.read_timeout)
            except Exception as error:  # a fault of a driver must not end the record
                self.source.state = f"{self.source.address}: {error}; retrying"
                self._ended.wait(TELEMETRY.retry_interval)
                continue
            if chunks:
                self._arrived.put(chunks)

    def _keep(self) -> None:
        """Flush to the disk, and tell the state."""
        next_sync = time.monotonic() + TELEMETRY.sync_interval
        while True:
            # Whatever goes wrong in telling, the flushing below goes on, and everyone else is told.
            with contextlib.suppress(Exception):
                status = self.status("recording")
                # A library for screens ends the program where nobody reads its words any more.
                with contextlib.suppress(Exception, SystemExit):
                    self._on_status(status)
                # The file in the folder comes last: who sees it finds the recorder everywhere.
                write_status(self.writer.folder / STATUS_FILE, status)
            with contextlib.suppress(OSError, FlightError):
                self._exchange.update(self.writer.folder)
            if self._written.wait(TELEMETRY.status_interval):
                return
            if time.monotonic() >= next_sync:
                next_sync = time.monotonic() + TELEMETRY.sync_interval
                self.writer.sync()


def _disk_warnings(free: int | None, seconds: float | None) -> list[str]:
    if free is None or (
        free >= TELEMETRY.low_disk_bytes and (seconds is None or seconds >= TELEMETRY.low_disk_time)
    ):
        return []
    lasts = f", enough for about {seconds / 60.0:.0f} minutes" if seconds is not None else ""
    return [f"The disk has only {free / 1e6:.0f} MB left{lasts}; free disk space."]


def _signature_warnings(signatures: Mapping[str, int]) -> list[str]:
    words = {
        "unsigned": "are not signed",
        "false": "have a false signature",
        "replayed": "have a signature out of date (replayed, or a clock is wrong)",
    }
    return [
        f"{signatures[state]} frames {text}: recorded, not decoded."
        for state, text in words.items()
        if signatures.get(state)
    ]


class _Rate:
    """Bytes per second over the last few seconds."""

    def __init__(self) -> None:
        self._past: deque[tuple[float, int]] = deque(maxlen=6)

    def update(self, now: float, count: int) -> float:
        self._past.append((now, count))
        since, before = self._past[0]
        return (count - before) / (now - since) if now > since else 0.0
