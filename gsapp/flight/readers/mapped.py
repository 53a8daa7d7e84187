"""From the tables of a foreign log to channels on the grid, by a channel map.

The rules are those of the live decoder, and its grid, merging and derivations are used: linear
interpolation, nothing across more than 2.5 sample periods, the better source while it lives,
derived channels where nobody measures them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calibration.certificate import Certificate
from gsapp.decoding.channel_map import TABLE, ChannelMap, FieldRef, MapEntry
from gsapp.decoding.conversions import CONVERSIONS
from gsapp.decoding.decoder import CIRCULAR, STEPWISE, ChannelSource
from gsapp.decoding.derived import SlowInput, derivations_for
from gsapp.decoding.grid import Grid, Gridder, Rows
from gsapp.decoding.merging import Merger
from gsapp.flight.readers.log_table import Log, LogTable
from gsapp.flight.uniform import union
from gsapp.foundation import FlightError, UnitError
from gsapp.quantities import Block, FloatArray, base_id, channel, normalize_unit, to_si

_EXCITATION = "excitation"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """The samples of one channel from one source, at the source's own times.

    Attributes
    ----------
    times : ndarray, shape (n,)
        s, increasing.
    values : ndarray, shape (n,)
        SI; NaN where missing.
    """

    times: FloatArray
    values: FloatArray


Tracks = Mapping[str, Sequence[Track]]
"""Channel to its sources, the better first."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MappedLog:
    """What a map finds in a log."""

    tracks: dict[str, list[Track]]
    sources: dict[str, ChannelSource]
    remarks: tuple[str, ...]


def map_log(
    log: Log, channel_map: ChannelMap, certificates: Mapping[str, Certificate]
) -> MappedLog:
    """Find the channels of a map in a log.

    Parameters
    ----------
    log : Log
        The log.
    channel_map : ChannelMap
        Names messages and fields. Where the log states a unit itself, and the map neither scales
        nor converts, the log is believed.
    certificates : mapping of str to Certificate
        For the entries that give volts.

    Returns
    -------
    MappedLog
        Channels that the log lacks are absent.

    Raises
    ------
    FlightError
        If the log holds nothing of what the map names.
    """
    finder = _Finder(log, certificates)
    excitation = [
        finder.field(entry)
        for entry in channel_map.by_channel.get(_EXCITATION, ())
        if entry.calibration is None
    ]
    finder.excitation = next((track for track in excitation if track is not None), None)
    for name, entries in channel_map.by_channel.items():
        for entry in entries:
            finder.take(name, entry)
    if not finder.tracks:
        messages = ", ".join(log.messages[:20]) + (" ..." if len(log.messages) > 20 else "")
        raise FlightError(
            f"{log.path} holds nothing of what the channel map '{channel_map.name}' names; give "
            f"another with --map. It holds: {messages or 'no messages'}"
        )
    return MappedLog(
        tracks=finder.tracks, sources=finder.sources, remarks=tuple(dict.fromkeys(finder.remarks))
    )


class _Finder:
    """Collects what the entries of a map find."""

    def __init__(self, log: Log, certificates: Mapping[str, Certificate]) -> None:
        self.tracks: dict[str, list[Track]] = {}
        self.sources: dict[str, ChannelSource] = {}
        self.remarks: list[str] = []
        self.excitation: Track | None = None
        self._log = log
        self._certificates = certificates

    def take(self, name: str, entry: MapEntry) -> None:
        """Add the track of one entry, if the log has it."""
        track = self.field(entry)
        if track is None:
            return
        if entry.calibration is None:
            self._add(name, entry, track, calibrated=False)
            return
        self._add(entry.volts_channel, entry, track, calibrated=False)
        certificate = self._certificates.get(entry.calibration)
        if certificate is None:
            self.remarks.append(
                f"there is no calibration certificate for {entry.calibration}: only its volts are "
                "shown"
            )
            return
        values = certificate.evaluate(track.values, self._excitation_at(track.times))
        self._add(name, entry, Track(times=track.times, values=values), calibrated=True)

    def field(self, entry: MapEntry) -> Track | None:
        """Return what an entry finds, SI or volts; None if the log does not have it."""
        table = self._table(entry)
        if table is None:
            return None
        inputs = [_input(table, ref, entry.convert is not None) for ref in entry.inputs]
        if any(found is None for found in inputs):
            return None
        raw = [values for found in inputs if found is not None for values in found]
        for missing in entry.missing:
            raw = [np.where(values == missing, np.nan, values) for values in raw]
        value = raw[0] if entry.convert is None else CONVERSIONS[entry.convert].compute(tuple(raw))
        key = "voltage" if entry.calibration else channel(entry.channel).quantity
        unit = self._unit(entry, table, key)
        return Track(times=table.times, values=to_si(entry.scale * value + entry.offset, unit, key))

    def _table(self, entry: MapEntry) -> LogTable | None:
        selector = entry.selector
        if entry.message == TABLE:
            return self._log.table(TABLE, entry.time or "")
        if selector is None or not selector.field:
            return self._log.table(entry.message, selector.value if selector else "")
        table = self._log.table(entry.message, "")
        if table is None or selector.field not in table.fields:
            return None
        rows = table.fields[selector.field] == float(selector.value)
        if not rows.any():
            return None
        return LogTable(
            times=table.times[rows],
            fields={name: values[rows] for name, values in table.fields.items()},
            units=table.units,
        )

    def _unit(self, entry: MapEntry, table: LogTable, key: str) -> str:
        plain = entry.scale == 1.0 and entry.offset == 0.0 and entry.convert is None
        stated = table.units.get(entry.inputs[0].field, "")
        if not (plain and stated):
            return entry.unit
        try:
            unit = normalize_unit(stated, key)
        except UnitError:
            return entry.unit
        if unit != entry.unit:
            self.remarks.append(
                f"the log gives {entry.source} in {unit}, the channel map in {entry.unit}; the log "
                "is believed"
            )
        return unit

    def _excitation_at(self, times: FloatArray) -> FloatArray | None:
        if self.excitation is None or not self.excitation.times.size:
            return None
        return np.interp(times, self.excitation.times, self.excitation.values)

    def _add(self, name: str, entry: MapEntry, track: Track, *, calibrated: bool) -> None:
        if np.isnan(track.values).all():
            return
        self.tracks.setdefault(name, []).append(track)
        self.sources.setdefault(
            name, ChannelSource(source=entry.source, kind=entry.kind, calibrated=calibrated)
        )


def _input(table: LogTable, ref: FieldRef, spread: bool) -> list[FloatArray] | None:
    """Return the numbers of a field: one array, or one for each element of an array field."""
    if ref.index is not None:
        element = table.fields.get(f"{ref.field}[{ref.index}]")
        if element is not None:
            return [element]
        whole = table.fields.get(ref.field)
        if whole is None:
            return None
        if whole.ndim == 1:
            return [whole] if ref.index == 0 else None
        return [whole[:, ref.index]] if ref.index < whole.shape[1] else None
    whole = table.fields.get(ref.field)
    if whole is not None and whole.ndim == 1:
        return [whole]
    if not spread:
        return None
    if whole is not None:
        return list(whole.T)
    elements: list[FloatArray] = []
    while (part := table.fields.get(f"{ref.field}[{len(elements)}]")) is not None:
        elements.append(part)
    return elements or None


def lay_on_grid(tracks: Tracks, rate: float, fallback: float = 1.0) -> Block:
    """Lay channels on the grid ``k / rate``, each from its best source.

    Parameters
    ----------
    tracks : mapping of str to sequence of Track
        The samples.
    rate : float
        Rows per second.
    fallback : float
        Seconds that a better source may be silent before the next one counts.

    Returns
    -------
    Block
        NaN across more than 2.5 sample periods of a source.
    """
    grid = Grid(rate)
    alone: dict[tuple[int, bytes], list[str]] = {}
    blocks: list[Block] = []
    for name, sources in tracks.items():
        if len(sources) == 1:
            # Channels sampled together are laid on the grid together: many times quicker.
            missing = np.isnan(sources[0].values)
            alone.setdefault((id(sources[0].times), np.packbits(missing).tobytes()), []).append(
                name
            )
        else:
            blocks.extend(_merged(grid, name, sources, round(fallback * 1e6)))
    for names in alone.values():
        track = tracks[names[0]][0]
        there = ~np.isnan(track.values)
        values = np.column_stack([tracks[name][0].values[there] for name in names])
        _, rows = _gridded(grid, names, track.times[there], values)
        blocks.extend(_block(grid, names, each) for each in rows)
    block = union(blocks, grid.rate)
    order = [name for name in tracks if name in block.channels]
    return block.select(order) if list(block.channels) != order else block


def _gridded(
    grid: Grid, names: Sequence[str], times: FloatArray, values: FloatArray
) -> tuple[Gridder, list[Rows]]:
    gridder = Gridder(
        grid,
        circular=np.array([base_id(name) in CIRCULAR for name in names]),
        stepwise=np.array([base_id(name) in STEPWISE for name in names]),
    )
    micros = np.rint(times * 1e6).astype(np.int64).tolist()
    return gridder, gridder.feed(micros, micros, values)


def _merged(grid: Grid, name: str, sources: Sequence[Track], fallback: int) -> list[Block]:
    gridders, laid = [], []
    for track in sources:
        there = ~np.isnan(track.values)
        gridder, rows = _gridded(grid, [name], track.times[there], track.values[there, np.newaxis])
        gridders.append(gridder)
        laid.append(rows)
    merger = Merger(grid, gridders, 1, fallback)
    for place, rows in enumerate(laid):
        merger.push(place, rows)
    first = min(gridder.first[0] for gridder in gridders if gridder.first is not None)
    last = max(gridder.last for gridder in gridders if gridder.last is not None)
    return [_block(grid, [name], rows) for rows in merger.pull(first, last, final=True)]


def _block(grid: Grid, names: Sequence[str], rows: Rows) -> Block:
    times = grid.times(rows.first, len(rows.values))
    return Block(channels=tuple(names), times=times, values=rows.values)


def with_derived(block: Block, tracks: Tracks) -> tuple[Block, dict[str, ChannelSource]]:
    """Add the channels that can be computed from those of a block.

    Parameters
    ----------
    block : Block
        On the grid.
    tracks : mapping of str to sequence of Track
        Where the slow inputs are taken from, at their own times.

    Returns
    -------
    Block
        With the derived channels behind the others.
    sources : dict
        Of the derived channels.
    """
    columns = {name: block[name] for name in block.channels}
    sources: dict[str, ChannelSource] = {}
    for derivation in derivations_for(columns):
        quick = [columns[name] for name in derivation.quick]
        slow = [_held(tracks[name], block.times) for name in derivation.slow]
        with np.errstate(invalid="ignore", divide="ignore"):
            columns[derivation.output] = derivation.compute(*quick, *slow)
        sources[derivation.output] = ChannelSource(
            source=f"{', '.join(derivation.inputs)}: {derivation.source}",
            kind="derived",
            calibrated=True,
        )
    values = np.column_stack(list(columns.values())) if columns else block.values
    return Block(channels=tuple(columns), times=block.times, values=values), sources


def _held(sources: Sequence[Track], times: FloatArray) -> FloatArray:
    """Return the latest sample of a slow channel before each time."""
    slow = SlowInput(len(sources))
    for place, track in enumerate(sources):
        there = ~np.isnan(track.values)
        micros = np.rint(track.times[there] * 1e6).astype(np.int64).tolist()
        slow.push(place, micros, micros, track.values[there].tolist())
    return slow.at(times * 1e6)
