"""Where a session's blocks come from: raw records through the decoder, or a flight read whole."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, islice
from pathlib import Path

from calibration import Certificate
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.pipeline import ChannelSource
from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import guess_channel_map
from gsapp.flight.raw_files import RAW_FILES, RawDamage, RawTail, read_nonempty_tlog
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.flight.read_settings import FlightReadSettings
from gsapp.foundation import FlightError
from gsapp.quantities import Block
from gsapp.session.feeds import ReadResult
from gsapp.session.file_worker import FileWorker, RecordBuffer
from gsapp.session.monitor_settings import MONITORS

_FLIGHT_ROWS = 4  # rows of a flight that weigh as much as one record


class RecordReader:
    """Decodes raw records as they come.

    Without a channel map the first records are held until they tell which one fits.

    Parameters
    ----------
    poll : callable
        Gives at most so many of the next records; none where none are waiting.
    progress : callable
        Gives the share of the records read, 0 to 1.
    waits : callable
        Returns whether the last poll gave fewer than there are, since the disk has them still.

    Attributes
    ----------
    decoder : Decoder or None
        None until a map is found.
    problem : str
        Why nothing is decoded, in words; empty otherwise.
    """

    def __init__(
        self,
        poll: Callable[[int], list[RawRecord]],
        progress: Callable[[], float],
        setting: FlightReadSettings,
        path: Path,
        *,
        grows: bool,
        waits: Callable[[], bool] = lambda: False,
    ) -> None:
        self._waits = waits
        self._poll = poll
        self._progress = progress
        self._setting = setting
        self._path = path
        self._grows = grows
        self._held: list[RawRecord] = []
        self._next_guess = 0
        self.problem = ""
        self.decoder: Decoder | None = None
        self.certificates: Mapping[str, Certificate] = setting.certificates or {}
        if setting.channel_map is not None:
            self._begin(setting)

    @property
    def sources(self) -> Mapping[str, ChannelSource]:
        """Return every channel that may come, and from where."""
        return self.decoder.sources if self.decoder is not None else {}

    @property
    def progress(self) -> float:
        return self._progress()

    def read(self, limit: int) -> ReadResult:
        records = self._poll(limit)
        waits = self._waits()
        more = waits or len(records) >= limit
        if self.decoder is None:
            records = self._hold_until_mapped(records, more)
        if self.decoder is None or not records:
            return ReadResult((), more, waits)
        return ReadResult(self.decoder.feed(records), more, waits)

    def finish(self) -> Sequence[Block]:
        if self.decoder is None and self._held:
            records = self._decide()
            if self.decoder is not None:
                return [*self.decoder.feed(records), *self.decoder.finish()]
        return self.decoder.finish() if self.decoder is not None else ()

    def _hold_until_mapped(self, records: list[RawRecord], more: bool) -> list[RawRecord]:
        """Keep records until they tell which map fits; then return all of them."""
        if len(self._held) >= MONITORS.map_guess_records and self.problem:
            return []  # enough was seen to know that none fits
        self._held += records
        if len(self._held) <= self._next_guess:
            return []
        enough = len(self._held) >= MONITORS.map_guess_records
        if self._grows and not enough:
            # A finished file is judged by as much as there is; a link by its first seconds.
            enough = self._held[-1].stamp_us - self._held[0].stamp_us >= MONITORS.map_guess_us
        elif not more:
            enough = True
        return self._decide() if enough else []

    def _decide(self) -> list[RawRecord]:
        try:
            channel_map = guess_channel_map(
                self._held[: MONITORS.map_guess_records], self._path, self._setting
            )
        except FlightError as error:
            if not self._grows:
                raise
            self.problem = str(error)
            self._next_guess = len(self._held) * 3 // 2
            return []
        self.problem = ""
        self._begin(replace(self._setting, channel_map=channel_map))
        held, self._held = self._held, []
        return held

    def _begin(self, setting: FlightReadSettings) -> None:
        if setting.channel_map is not None:
            self.certificates = setting.certificates_for(setting.channel_map)
            # Read once: the decoder takes those that were found here.
            found = replace(setting, certificates=self.certificates)
            self.decoder = found.decoder(setting.channel_map)


def create_folder_reader(
    folder: Path, setting: FlightReadSettings, *, grows: bool, worker: FileWorker | None = None
) -> tuple[RecordReader, RawTail, Callable[[], bool]]:
    """Return a reader of a flight folder's raw files, the tail it reads with, and what tells news.

    With a worker the files are read in its thread.
    """
    tail = RawTail(folder)

    def progress() -> float:
        whole = sum(path.stat().st_size for name in RAW_FILES if (path := folder / name).is_file())
        return min(sum(tail.position) / whole, 1.0) if whole else 0.0

    if worker is None:
        return RecordReader(tail.poll, progress, setting, folder, grows=grows), tail, tail.has_grown
    buffer = RecordBuffer(worker, tail.poll, tail.has_grown if grows else None, progress)
    return _create_buffered_reader(buffer, setting, folder, grows=grows), tail, buffer.has_grown


def _create_buffered_reader(
    buffer: RecordBuffer, setting: FlightReadSettings, path: Path, *, grows: bool
) -> RecordReader:
    return RecordReader(
        buffer.poll, lambda: buffer.progress, setting, path, grows=grows,
        waits=lambda: buffer.is_waiting,
    )  # fmt: skip


def create_tlog_reader(
    path: Path, setting: FlightReadSettings, worker: FileWorker | None = None
) -> tuple[RecordReader, RawDamage]:
    """Return a reader of a ``.tlog`` of any ground station, and what it had to step over.

    With a worker the file is read in its thread.

    Raises
    ------
    FlightError
        If the file cannot be read, or holds no message at all.
    """
    damage = RawDamage(name=path.name)
    log = read_nonempty_tlog(path, damage)
    # The first is read now: what is no log at all does not open.
    records: Iterator[RawRecord] = chain(list(islice(log, 1)), log)
    whole = max(path.stat().st_size, 1)
    read = 0

    def poll(limit: int) -> list[RawRecord]:
        nonlocal read
        taken = list(islice(records, limit))
        read += sum(len(record.data) + 8 for record in taken)
        return taken

    def progress() -> float:
        return min(read / whole, 1.0)

    if worker is None:
        return RecordReader(poll, progress, setting, path, grows=False), damage
    buffer = RecordBuffer(worker, poll, None, progress)
    return _create_buffered_reader(buffer, setting, path, grows=False), damage


class FlightReader:
    """Gives a flight that was read whole, in time order, a stretch at a time."""

    def __init__(self, flight: Flight) -> None:
        self._block = flight.block
        self._position = 0
        self.sources: Mapping[str, ChannelSource] = flight.sources

    @property
    def progress(self) -> float:
        return self._position / max(len(self._block), 1)

    def read(self, limit: int) -> ReadResult:
        block = self._block
        first = self._position
        last = min(first + limit * _FLIGHT_ROWS, len(block))
        self._position = last
        part = Block(
            channels=block.channels, times=block.times[first:last], values=block.values[first:last]
        )
        return ReadResult((part,), last < len(block))

    def finish(self) -> Sequence[Block]:
        """Give nothing: everything was given."""
        return ()
