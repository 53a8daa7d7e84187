"""The conversation about a log, without any link or disk: what came, and what to ask next.

Autopilots answer one request at a time, and a new one takes the place of the last. So the log is
asked for in pieces that take a second or two each; what was lost on the way is asked for again
when the rest has come, stretches that lie near each other as one.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Final, Literal

from gsapp.decoding.dialect import dialect
from gsapp.decoding.framing import frame_message_id
from gsapp.telemetry.send_queue import GROUND_COMPONENT, GROUND_SYSTEM
from gsapp.telemetry.settings import TELEMETRY

_HEARTBEAT: Final = 0
_LOG_ENTRY: Final = 118
_LOG_DATA: Final = 120
_ARMED: Final = 128
_NO_AUTOPILOT: Final = 8
LOG_DATA_BYTES: Final = 90
"""Bytes in one LOG_DATA."""

DownloadPhase = Literal["listening", "listing", "listed", "fetching", "done", "failed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LogEntry:
    """A log that the autopilot has."""

    id: int  # By which it is asked for.
    size: int  # Bytes.
    time_utc: int  # Seconds since 1970; 0 where the autopilot did not know the time.
    system: int = 0
    component: int = 0
    """Who has it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DownloadState:
    """How far a download has come."""

    phase: DownloadPhase
    """``listening``, ``listing``, ``listed``, ``fetching``, ``done`` or ``failed``."""
    received_bytes: int = 0
    size: int = 0
    """Bytes that are there, and of the whole log."""
    rate: float = 0.0  # New bytes per second over the last seconds.
    seconds_left: float | None = None  # At this rate; None while nothing comes.
    why: str = ""  # Why it failed.


class MissingRanges:
    """Stretches of bytes of a file that have not come, in order; at first all, or those given.

    A stretch is its first byte and the one after the last. Raise ValueError if they lie outside the
    file or over each other.
    """

    def __init__(self, size: int, stretches: Iterable[tuple[int, int]] | None = None) -> None:
        given = [(0, size)] if stretches is None else [(int(a), int(b)) for a, b in stretches]
        given = [(a, b) for a, b in given if a < b]
        ends = [edge for pair in given for edge in pair]
        if ends != sorted(ends) or (ends and not 0 <= ends[0] <= ends[-1] <= size):
            raise ValueError(f"{given} are no stretches of a file of {size} bytes")
        self._starts = [a for a, _ in given]
        self._stops = [b for _, b in given]
        self.missing_bytes = sum(b - a for a, b in given)

    @property
    def ranges(self) -> tuple[tuple[int, int], ...]:
        """Return them: first byte and the one after the last."""
        return tuple(zip(self._starts, self._stops, strict=True))

    def __bool__(self) -> bool:
        return bool(self._starts)

    def mark_received(self, start: int, stop: int) -> int:
        """Note that bytes have come; return how many of them had been missing."""
        if stop <= start:
            return 0
        first = bisect_right(self._stops, start)
        last = bisect_left(self._starts, stop)
        if first >= last:
            return 0
        left = self._starts[first], min(start, self._stops[first])
        right = max(stop, self._starts[last - 1]), self._stops[last - 1]
        before = sum(self._stops[k] - self._starts[k] for k in range(first, last))
        kept = [pair for pair in (left, right) if pair[0] < pair[1]]
        self._starts[first:last] = [pair[0] for pair in kept]
        self._stops[first:last] = [pair[1] for pair in kept]
        came = before - sum(b - a for a, b in kept)
        self.missing_bytes -= came
        return came

    def is_missing_any(self, start: int, stop: int) -> bool:
        return start < stop and bisect_right(self._stops, start) < bisect_left(self._starts, stop)

    def next_range(self, position: int, most: int, join: int) -> tuple[int, int] | None:
        """Return what to ask for next: the first missing stretch at or after a position, or None.

        It begins anew where nothing is missing beyond, and is at most `most` bytes long. Missing
        stretches no farther apart than `join` are asked for as one.
        """
        if not self._starts:
            return None
        place = bisect_right(self._stops, position)
        if place == len(self._starts):
            place, position = 0, 0
        start = max(self._starts[place], position)
        stop = self._stops[place]
        while place + 1 < len(self._starts) and self._starts[place + 1] - stop <= join:
            place += 1
            stop = self._stops[place]
        return start, min(stop, start + most)


class LogDownloadProtocol:
    """Asks for the list of logs (`entries`, by number), then for one of them.

    Nothing happens by itself: `receive_frame` is given what comes, `pending_requests` returns what
    is to be sent. `keep` is called with offset and bytes of what came new.
    """

    def __init__(self, keep: Callable[[int, bytes], None]) -> None:
        self.phase: DownloadPhase = "listening"
        self.entries: dict[int, LogEntry] = {}
        self.missing = MissingRanges(0)
        self._keep = keep
        self._names = dialect()
        self._packer = self._names.MAVLink(
            None, srcSystem=GROUND_SYSTEM, srcComponent=GROUND_COMPONENT
        )
        self._why = ""
        self._begun = -1.0
        self._target = (0, 0)
        self._armed = False
        self._announced = -1
        self._asked_at = -1.0
        self._heard_at = -1.0
        self._entry: LogEntry | None = None
        self._request: tuple[int, int] | None = None
        self._listed: set[int] = set()
        self._cursor = 0
        self._cut_off = 0
        self._came: deque[tuple[float, int]] = deque()
        self._answered = 0
        self._pace: float | None = None
        self._trip = TELEMETRY.round_trip
        self._interval = 0.0

    def state(self, now: float) -> DownloadState:
        size = self._entry.size if self._entry is not None else 0
        rate = self._rate(now)
        return DownloadState(
            phase=self.phase,
            received_bytes=size - self.missing.missing_bytes,
            size=size,
            rate=rate,
            seconds_left=self.missing.missing_bytes / rate if rate > 0.0 else None,
            why=self._why,
        )

    def fetch(self, entry: LogEntry, missing: MissingRanges) -> None:
        """Go on with one of the logs, as far as it is missing."""
        self._entry, self.missing = entry, missing
        self._target = (entry.system, entry.component)
        self._request, self._cursor = None, 0
        self._heard_at = -1.0
        self.phase = "fetching" if missing else "done"

    def receive_frame(self, frame: bytes, now: float) -> None:
        kind = frame_message_id(frame)
        if kind not in (_HEARTBEAT, _LOG_ENTRY, _LOG_DATA):
            return
        try:
            message = self._names.MAVLink(None).decode(bytearray(frame))
        except self._names.MAVError:
            return
        if kind == _HEARTBEAT:
            self._hear_heartbeat(message)
        elif kind == _LOG_ENTRY:
            self._hear_entry(message, now)
        elif self._entry is not None and message.id == self._entry.id:
            self._hear_piece(message, now)

    def pending_requests(self, now: float) -> list[bytes]:
        if self._begun < 0.0:
            self._begun = now
        if self._armed and self.phase not in ("done", "failed"):
            self.fail("the aircraft is armed; land and disarm it first")
        if self.phase == "listening" and (
            self._target[0] or now - self._begun > TELEMETRY.listen_time
        ):
            self.phase = "listing"
        if self.phase == "listing":
            return self._ask_for_list(now)
        if self.phase == "fetching":
            return self._ask_for_data(now)
        return []

    def pack_request_end(self) -> bytes:
        return self._pack(self._names.MAVLink_log_request_end_message(*self._target))

    def fail(self, why: str) -> None:
        self.phase, self._why = "failed", why

    def _hear_heartbeat(self, message: Any) -> None:
        if message.autopilot == _NO_AUTOPILOT or message.get_srcSystem() == GROUND_SYSTEM:
            return
        sender = (message.get_srcSystem(), message.get_srcComponent())
        if self._target in ((0, 0), sender):
            self._target = sender
            self._armed = bool(message.base_mode & _ARMED)

    def _hear_entry(self, message: Any, now: float) -> None:
        self._heard_at = now
        self._announced = message.num_logs
        if message.num_logs and message.size:
            self.entries[message.id] = LogEntry(
                id=message.id,
                size=message.size,
                time_utc=message.time_utc,
                system=message.get_srcSystem(),
                component=message.get_srcComponent(),
            )
        self._listed.add(message.id)
        if self.phase == "listing" and len(self._listed) >= self._announced:
            self.phase = "listed"

    def _hear_piece(self, message: Any, now: float) -> None:
        entry = self._entry
        if entry is None:
            return
        offset, count = message.ofs, min(message.count, LOG_DATA_BYTES)
        count = max(min(count, entry.size - offset), 0)
        if self._request is not None:
            self._time(count, now)
        self._heard_at = now
        if self.missing.is_missing_any(offset, offset + count):
            # What could not be kept has not come.
            self._keep(offset, bytes(message.data[:count]))
            self._came.append((now, self.missing.mark_received(offset, offset + count)))
        if self._request is not None:
            start, stop = self._request
            if start <= offset < stop <= offset + count or not self.missing.is_missing_any(
                start, stop
            ):
                self._request = None
            elif start <= offset and message.count < LOG_DATA_BYTES and offset + count < stop:
                self._hear_end(offset + count)
        if not self.missing:
            self.phase = "done"

    def _time(self, count: int, now: float) -> None:
        """Take from a piece what asking costs, and how fast pieces follow each other."""
        if self._heard_at > self._asked_at:
            gap = min(now - self._heard_at, TELEMETRY.max_silence)
            self._interval += 0.1 * (gap - self._interval)
        else:
            self._trip = now - self._asked_at
        self._answered += count
        if self._answered >= TELEMETRY.min_measured_bytes and now > self._asked_at:
            self._pace = self._answered / (now - self._asked_at)

    def _hear_end(self, end: int) -> None:
        """Note that the log ended before the size that was announced."""
        self._cut_off += 1
        if self._cut_off >= TELEMETRY.max_cut_off and self._entry is not None:
            self.fail(
                f"the autopilot ends log {self._entry.id} at {end} bytes, though it announced "
                f"{self._entry.size}; power-cycle it and start again"
            )

    def _ask_for_list(self, now: float) -> list[bytes]:
        quiet = now - max(self._asked_at, self._heard_at)
        if self._asked_at >= 0.0 and quiet < TELEMETRY.list_retry:
            return []
        if (
            now - max(self._begun + TELEMETRY.listen_time, self._heard_at)
            > TELEMETRY.fetch_timeout / 2.0
        ):
            if self.entries:
                self.phase = "listed"  # the rest of the list does not come
                return []
            self.fail(
                "no answer to the log list request; check the link and that the autopilot logs"
            )
            return []
        self._asked_at = now
        return [self._pack(self._names.MAVLink_log_request_list_message(*self._target, 0, 0xFFFF))]

    def _ask_for_data(self, now: float) -> list[bytes]:
        entry = self._entry
        if entry is None:
            return []
        if self._heard_at < 0.0:
            self._heard_at = self._asked_at = now
            self._request = None
        if now - self._heard_at > TELEMETRY.fetch_timeout:
            self.fail(
                f"no data for {TELEMETRY.fetch_timeout:.0f} s; restore the link and start again: "
                "the download resumes"
            )
            return []
        if self._request is not None:
            if now - max(self._heard_at, self._asked_at) < self._silence():
                return []
            # The end of what was asked for is lost, or the request was.
            if self._heard_at <= self._asked_at:
                self._cursor = self._request[0]
            self._request = None
        most, join = self._window()
        wanted = self.missing.next_range(self._cursor, most, join)
        if wanted is None:
            return []
        start, stop = wanted
        self._cursor = stop
        self._request, self._asked_at, self._answered = wanted, now, 0
        return [
            self._pack(
                self._names.MAVLink_log_request_data_message(
                    *self._target, entry.id, start, stop - start
                )
            )
        ]

    def _window(self) -> tuple[int, int]:
        """Return how many bytes to ask for at once, and across how many that are there already.

        It follows the pace of the link, not of what comes new: that falls where little is missing,
        and each lost piece would be asked for by itself. Where the pace is not known yet, the first
        answer shall be long enough to tell it.
        """
        if self._pace is None:
            return TELEMETRY.min_window, TELEMETRY.min_window
        most = max(TELEMETRY.window_time * self._pace, TELEMETRY.min_window)
        return round(min(most, TELEMETRY.max_window) / LOG_DATA_BYTES) * LOG_DATA_BYTES, round(
            max(self._trip, TELEMETRY.round_trip) * self._pace
        )

    def _silence(self) -> float:
        """Return after how many seconds without a piece there will be none."""
        if self._heard_at <= self._asked_at:
            return TELEMETRY.first_silence
        usual = max(TELEMETRY.silent_pieces * self._interval, TELEMETRY.min_silence)
        return min(usual, TELEMETRY.max_silence)

    def _rate(self, now: float) -> float:
        while self._came and now - self._came[0][0] > TELEMETRY.rate_window:
            self._came.popleft()
        if not self._came:
            return 0.0
        over = max(now - self._came[0][0], 0.3)
        return sum(count for _, count in self._came) / over

    def _pack(self, message: Any) -> bytes:
        frame = bytes(message.pack(self._packer))
        self._packer.seq = (self._packer.seq + 1) % 256
        return frame
