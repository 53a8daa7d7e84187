"""From samples of messages to blocks on the grid: streams, choice of source, derived channels.

Channels are gathered in groups that share their rows: those of one message that have no other
source, those for which the same sources compete, and those derived from inputs of several groups.
A group yields blocks of its own, so no message waits for another.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from calibration import Certificate
from gsapp.aircraft import Aircraft
from gsapp.decoding.channel_map import ChannelMap, MapEntry
from gsapp.decoding.derived_channels import DeriveFunction, SlowInput, select_derivations
from gsapp.decoding.grid import ColumnIndex, Grid, GridRows, Numbers, RowBatch, column_index
from gsapp.decoding.gridder import Gridder, SourceSelector
from gsapp.decoding.message_stream import MessageColumns, MessageStream
from gsapp.decoding.settings import DECODING
from gsapp.foundation import FlightError
from gsapp.quantities import Block, FloatArray

IntArray = npt.NDArray[np.int64]
_FORGET = 4 * DECODING.max_hold
_LONGEST_WAIT = 2 * round(DECODING.max_filled_pause * 1e6)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSource:
    """Where a channel comes from."""

    source: str
    """Source in the map, the better first where there are several; or the formula and inputs."""
    kind: Literal["measured", "estimated", "derived"]  # What the best source does for it.
    calibrated: bool
    """Whether a certificate is in force for it, or for all that it is derived from."""
    uncalibrated_channel: str = ""
    """Of volts that want a certificate and have none: the channel that they would give. Empty for
    all others."""
    timing: Literal["vehicle", "arrival"] = "vehicle"
    """Whether its samples carry the vehicle's time. Those timed by arrival stay out of
    identification unless asked for."""
    samples: int | None = None
    """How many arrived, before the grid: of the source that most rows are from, or of the input of
    a derived channel that gave least. None where nobody counted."""
    rate: float | None = None  # Their mean rate, Hz, gaps left out.
    gaps: int | None = None  # How often they were further apart than the grid bridges.


class _ColumnStep(NamedTuple):
    """One more column of a group: a slow input, or what is computed from columns before it."""

    compute: DeriveFunction | None  # From the columns `inputs` to this one; None for a slow input.
    inputs: tuple[int, ...] = ()  # Places of columns.
    slow: SlowInput | None = None


@dataclass(slots=True)
class _Group:
    """Channels that share their rows: its own, then the derived ones.

    A group with `join` takes its own channels from other groups, and emits the derived ones only.
    """

    channels: tuple[str, ...]  # Its own and the derived ones.
    width: int  # Number of its own.
    join: _Join | None = None  # Where its own channels come from, if not from a stream.
    steps: list[_ColumnStep] = field(default_factory=list)
    """Columns that follow its own; some of them are derived channels, others lead to them."""
    derived: list[int] = field(default_factory=list)
    """Places of the derived channels among all columns."""
    ready: list[GridRows] = field(default_factory=list)  # What waits for the next pull.

    @property
    def emitted(self) -> tuple[str, ...]:
        return self.channels if self.join is None else self.channels[self.width :]

    def place(self, name: str) -> int:
        """Return the place of a channel among all columns."""
        index = self.channels.index(name)
        return index if index < self.width else self.derived[index - self.width]

    def add(self, step: _ColumnStep) -> int:
        """Add a column, unless it is there already; return its place."""
        if step not in self.steps:
            self.steps.append(step)
        return self.width + self.steps.index(step)

    def derive(self, grid: Grid, rows: GridRows) -> GridRows:
        found = self._derived_singly(grid, rows) if rows.few else None
        values = np.empty((len(rows.values), len(self.channels)))
        values[:, : self.width] = rows.values
        values.T[self.width :] = self._derived(grid, rows) if found is None else found
        return GridRows(rows.first, values)

    def _derived(self, grid: Grid, rows: GridRows) -> list[FloatArray]:
        # Each by itself: a function may round differently on one that is strided.
        columns = list(np.ascontiguousarray(rows.values.T))
        for compute, inputs, slow in self.steps:
            if compute is not None:
                columns.append(compute(*[columns[place] for place in inputs]))
            elif slow is not None:
                columns.append(slow.at(grid.times_us(rows.first, len(rows))))
        return [columns[place] for place in self.derived]

    def _derived_singly(self, grid: Grid, rows: GridRows) -> list[Numbers] | None:
        """Return the derived columns, computed number by number: quicker for a few rows.

        None where Python refuses what NumPy answers with infinity.
        """
        columns: list[Numbers] = rows.values.T.tolist()
        try:
            for compute, inputs, slow in self.steps:
                if compute is not None:
                    columns.append(list(map(compute, *map(columns.__getitem__, inputs))))
                elif slow is not None:
                    micros = grid.times_us(rows.first, len(rows)).tolist()
                    columns.append(slow.at_scalars(micros))
        except ArithmeticError:
            return None
        return [columns[place] for place in self.derived]

    def block(self, grid: Grid, rows: GridRows) -> Block:
        """Return rows, derived columns included, as a block."""
        values = rows.values
        times = grid.times(rows.first, len(values))
        if self.join is None:
            return Block.unchecked(self.channels, times, values)
        return Block.unchecked(self.emitted, times, values[:, self.width :])


@dataclass(slots=True)
class _Join:
    """Rows of several groups, where all of them have one."""

    parents: list[tuple[_Group, int]]
    waiting: list[deque[GridRows]]

    def pull(self) -> list[GridRows]:
        """Return the rows that all parents have by now."""
        for queue, (parent, column) in zip(self.waiting, self.parents, strict=True):
            # A copy: what waits may wait long, and should not hold the other columns.
            queue += [GridRows(rows.first, rows.values[:, column].copy()) for rows in parent.ready]
        found = []
        while all(self.waiting):
            heads = [queue[0] for queue in self.waiting]
            first = max(head.first for head in heads)
            end = min(head.end for head in heads)
            if first < end:
                parts = [head.values[first - head.first : end - head.first] for head in heads]
                found.append(GridRows(first, np.column_stack(parts)))
            self.drop(end)
        return found

    def drop(self, end: int) -> None:
        """Let go of the rows before one."""
        for queue in self.waiting:
            while queue and queue[0].end <= end:
                queue.popleft()
            if queue and queue[0].first < end:
                queue[0] = GridRows(end, queue[0].values[end - queue[0].first :])


class Pipeline:
    """Everything after framing and timing, at `rate` rows per second.

    `vehicle_time` says whether the message of an entry carries the vehicle's time. With
    `keep_samples` samples are kept for `native_samples`.

    Attributes
    ----------
    streams : tuple of MessageStream
        One for each message and sender; their numbers are those of `push`.
    sources : dict of str to ChannelSource
        Every channel that it can yield.
    """

    def __init__(
        self,
        channel_map: ChannelMap,
        *,
        certificates: Mapping[str, Certificate],
        aircraft: Aircraft | None,
        rate: float,
        vehicle_time: Callable[[MapEntry], bool],
        keep_samples: bool = False,
    ) -> None:
        self.grid = Grid(rate)
        self._kept: list[tuple[int, Sequence[int], FloatArray]] | None = (
            [] if keep_samples else None
        )
        self._fallback = round(channel_map.fallback * 1e6)
        self.streams = _streams(channel_map, certificates, vehicle_time)
        if aircraft is not None:
            for stream in self.streams:
                stream.set_instrument_ranges(_ranges(aircraft))
        self._gridders = tuple(
            Gridder(
                self.grid,
                circular=stream.circular,
                stepwise=stream.stepwise,
                fallback=self._fallback,
            )
            for stream in self.streams
        )
        self._sheet = RowBatch()
        self._rows: list[tuple[int, list[GridRows]]] = []  # completed since the last pull
        self.sources: dict[str, ChannelSource] = {}
        self._groups: list[_Group] = []
        self._direct: list[tuple[ColumnIndex | None, _Group] | None] = [None] * len(self.streams)
        self._mergers: list[tuple[SourceSelector, _Group]] = []
        self._merged: list[list[tuple[SourceSelector, int, ColumnIndex]]] = [
            [] for _ in self.streams
        ]
        self._selectors: dict[str, SourceSelector] = {}
        self._inputs: dict[str, tuple[str, ...]] = {}
        self._slow: dict[str, SlowInput] = {}
        self._slow_feeds: list[list[tuple[SlowInput, int, int]]] = [[] for _ in self.streams]
        self._candidates = self._find_candidates()
        self._arrange()
        self._add_derived()

    @property
    def clipped(self) -> dict[str, int]:
        totals: dict[str, int] = {}
        for stream in self.streams:
            for name, count in stream.clipped.items():
                totals[name] = totals.get(name, 0) + count
        return totals

    @property
    def duplicates(self) -> int:
        return sum(gridder.duplicates for gridder in self._gridders)

    @property
    def reordered(self) -> int:
        return sum(gridder.reordered for gridder in self._gridders)

    def push(
        self, stream: int, times: Sequence[int], nows: Sequence[int], columns: MessageColumns
    ) -> None:
        """Take samples of one of the `streams`.

        Beside the flight time of each (us) stands the latest flight time of any message when it
        came. Columns are the fields of the message, a structured array or a mapping.
        """
        values = self.streams[stream].convert(columns, len(times))
        for slow, source, column in self._slow_feeds[stream]:
            slow.push(source, times, nows, values[:, column].tolist())
        if self._kept is not None:
            self._kept.append((stream, list(times), values))
        self._rows.append((stream, self._gridders[stream].feed(times, nows, values)))

    def push_few(
        self, stream: int, times: Sequence[int], nows: Sequence[int], samples: Sequence[Numbers]
    ) -> None:
        """Take a few samples of one stream: `push`, with the same bits, quicker for some ten.

        Each sample holds the numbers that the stream has `wanted`.
        """
        values, complete = self.streams[stream].convert_scalars(samples)
        for slow, source, column in self._slow_feeds[stream]:
            slow.push(source, times, nows, [numbers[column] for numbers in values])
        if self._kept is not None:
            self._kept.append((stream, list(times), np.array(values)))
        gridder = self._gridders[stream]
        rows = gridder.feed_few(times, nows, values, self._sheet, complete=complete)
        self._rows.append((stream, rows))

    def _distribute(self) -> None:
        """Lay the rows that were completed, and hand them to the groups and mergers."""
        self._sheet.compute_rows()
        for stream, rows in self._rows:
            if not rows:
                continue
            direct = self._direct[stream]
            if direct is not None:
                own, group = direct
                group.ready += rows if own is None else [each.select_columns(own) for each in rows]
            for merger, source, chosen in self._merged[stream]:
                merger.push(source, [each.select_columns(chosen) for each in rows])
        self._rows.clear()

    def pull(self, first: int | None, now: int, *, final: bool = False) -> list[Block]:
        """Return the blocks that are complete; see `SourceSelector.pull` for the parameters."""
        self._distribute()
        for merger, group in self._mergers:
            group.ready += merger.pull(first, now, final=final)
        grid = self.grid
        blocks: list[Block] = []
        for group in self._groups:
            if group.join is not None:
                group.ready += group.join.pull()
            if group.derived:
                group.ready = [group.derive(grid, rows) for rows in group.ready]
        for group in self._groups:
            if group.ready:
                blocks += [group.block(grid, rows) for rows in group.ready]
                group.ready = []
        for slow in self._slow.values():
            slow.drop_before(now - _FORGET)
        return blocks

    def drop_overdue(self, now: int) -> None:
        """Let go of rows that have waited too long for another input of a derived channel.

        Two minutes longer than a better source is waited for: an input that comes later still,
        or never, is not waited for. To be called at moments that depend on the record alone.
        """
        oldest = self.grid.row_at_or_after(now - _LONGEST_WAIT - self._fallback)
        for group in self._groups:
            if group.join is not None:
                group.join.drop(oldest)

    def counted_sources(self) -> dict[str, ChannelSource]:
        counted: dict[str, ChannelSource] = {}
        for name, source in self.sources.items():
            inputs = self._inputs.get(name)
            counted[name] = (
                self._counted(name, source)
                if inputs is None
                # Derivations stand after their inputs.
                else _with_counts(source, min((counted[each] for each in inputs), key=_samples_of))
            )
        return counted

    def native_samples(self) -> Block:
        """Return all samples at their own times (s), beside the grid; NaN where a channel has none.

        Channels that were measured, none that is derived. A source that is not the best counts
        where no better one has a sample within the time after which it replaces it.
        """
        kept: dict[int, list[tuple[Sequence[int], FloatArray]]] = {}
        for stream, moments, values in self._kept or ():
            kept.setdefault(stream, []).append((moments, values))
        streams = {
            stream: (
                np.concatenate([np.array(moments, dtype=np.int64) for moments, _ in parts]),
                np.concatenate([part for _, part in parts]),
            )
            for stream, parts in kept.items()
        }
        samples = {
            name: _best_samples(
                [
                    (streams[number][0], streams[number][1][:, column])
                    for number, column in places
                    if number in streams
                ],
                self._fallback,
            )
            for name, places in self._candidates.items()
        }
        samples = {name: one for name, one in samples.items() if one[0].size}
        every = [times for times, _ in samples.values()]
        union = np.unique(np.concatenate(every)) if every else np.empty(0, dtype=np.int64)
        if union.size * len(samples) > DECODING.max_native_numbers:
            raise FlightError(
                f"{len(samples)} channels at {union.size} different times do not fit into memory; "
                "take fewer raw channels"
            )
        block = np.full((union.size, len(samples)), np.nan)
        for column, (times, values) in enumerate(samples.values()):
            block[np.searchsorted(union, times), column] = values
        return Block(channels=tuple(samples), times=union / 1e6, values=block)

    def _counted(self, name: str, source: ChannelSource) -> ChannelSource:
        places = self._candidates[name]
        selector = self._selectors.get(name)
        used = 0 if selector is None else max(range(len(places)), key=selector.laid.__getitem__)
        number, column = places[used]
        gridder = self._gridders[number]
        samples = gridder.samples - gridder.missing[column]
        rate = gridder.rate
        return replace(
            source,
            samples=samples,
            rate=None if rate is None else round(rate, 3),
            gaps=gridder.gaps,
        )

    def _find_candidates(self) -> dict[str, list[tuple[int, int]]]:
        """Return (stream, column) of every source of every channel, the better first."""
        found: dict[str, list[tuple[int, int, int]]] = {}
        for number, stream in enumerate(self.streams):
            for column, output in enumerate(stream.outputs):
                found.setdefault(output.channel, []).append((output.entry.priority, number, column))
        return {
            name: [(number, column) for _, number, column in sorted(places)]
            for name, places in found.items()
        }

    def _arrange(self) -> None:
        """Sort channels into groups that share their rows."""
        competing: dict[tuple[int, ...], list[str]] = {}
        alone: dict[int, list[str]] = {}
        for name, places in self._candidates.items():
            outputs = [self.streams[number].outputs[column] for number, column in places]
            best = outputs[0]
            self.sources[name] = ChannelSource(
                source=", else ".join(output.entry.source for output in outputs),
                kind=best.entry.kind,
                calibrated=best.calibrated,
                uncalibrated_channel=best.uncalibrated_channel,
                timing="vehicle" if self.streams[places[0][0]].vehicle_time else "arrival",
            )
            if len(places) == 1:
                alone.setdefault(places[0][0], []).append(name)
            else:
                competing.setdefault(tuple(number for number, _ in places), []).append(name)
        for number, names in sorted(alone.items()):
            group = self._new_group(names)
            own = [self._candidates[name][0][1] for name in names]
            every = len(own) == len(self.streams[number].outputs)
            self._direct[number] = (None if every else column_index(own), group)
        for numbers, names in competing.items():
            group = self._new_group(names)
            merger = SourceSelector(
                self.grid,
                [self._gridders[number] for number in numbers],
                len(names),
                self._fallback,
            )
            self._mergers.append((merger, group))
            self._selectors |= dict.fromkeys(names, merger)
            for source, number in enumerate(numbers):
                columns = [self._candidates[name][source][1] for name in names]
                self._merged[number].append((merger, source, column_index(columns)))

    def _new_group(self, names: Sequence[str], join: _Join | None = None) -> _Group:
        group = _Group(channels=tuple(names), width=len(names), join=join)
        self._groups.append(group)
        return group

    def _add_derived(self) -> None:
        for derivation in select_derivations(list(self._candidates)):
            group = self._group_with(derivation.fast_inputs)
            quick = [group.place(name) for name in derivation.fast_inputs]
            slow = [
                group.place(name)
                if name in group.channels
                else group.add(_ColumnStep(None, slow=self._slow_input(name)))
                for name in derivation.slow_inputs
            ]
            if derivation.density is not None:
                slow = [group.add(_ColumnStep(derivation.density, tuple(slow)))]
            if derivation.is_alias:
                group.derived += quick
            else:
                group.derived.append(group.add(_ColumnStep(derivation.compute, (*quick, *slow))))
            group.channels += (derivation.output,)
            self._inputs[derivation.output] = tuple(derivation.fast_inputs)
            used = [self.sources[name] for name in derivation.inputs]
            arrival = any(self.sources[name].timing == "arrival" for name in derivation.fast_inputs)
            self.sources[derivation.output] = ChannelSource(
                source=derivation.description,
                kind="derived",
                calibrated=all(source.calibrated for source in used),
                timing="arrival" if arrival else "vehicle",
            )

    def _group_with(self, names: Sequence[str]) -> _Group:
        """Return the group in which all of these channels stand in one row; make one if needed."""
        homes = [self._home(name) for name in names]
        if all(home is homes[0] for home in homes):
            return homes[0]
        parents = [
            (home, home.channels.index(name)) for home, name in zip(homes, names, strict=True)
        ]
        return self._new_group(names, _Join(parents=parents, waiting=[deque() for _ in parents]))

    def _home(self, name: str) -> _Group:
        return next(group for group in self._groups if name in group.emitted)

    def _slow_input(self, name: str) -> SlowInput:
        if name not in self._slow:
            places = self._candidates[name]
            slow = self._slow[name] = SlowInput(len(places))
            for source, (number, column) in enumerate(places):
                self._slow_feeds[number].append((slow, source, column))
        return self._slow[name]


def _best_samples(
    sources: Sequence[tuple[IntArray, FloatArray]], fallback: int
) -> tuple[IntArray, FloatArray]:
    """Return times (us), increasing, and values of what a channel's sources hold, best first."""
    times, values = np.empty(0, dtype=np.int64), np.empty(0)
    for own, numbers in sources:
        there = ~np.isnan(numbers)
        if times.size:
            after = np.searchsorted(times, own)
            before = np.maximum(after - 1, 0)
            after = np.minimum(after, times.size - 1)
            apart = np.minimum(abs(own - times[before]), abs(times[after] - own))
            there &= apart > fallback
        # What repeats a time is dropped here as on the grid.
        times, first = np.unique(np.concatenate((times, own[there])), return_index=True)
        values = np.concatenate((values, numbers[there]))[first]
    return times, values


def _samples_of(source: ChannelSource) -> int:
    return source.samples or 0


def _with_counts(source: ChannelSource, counted: ChannelSource) -> ChannelSource:
    return replace(source, samples=counted.samples, rate=counted.rate, gaps=counted.gaps)


def _streams(
    channel_map: ChannelMap,
    certificates: Mapping[str, Certificate],
    vehicle_time: Callable[[MapEntry], bool],
) -> tuple[MessageStream, ...]:
    gathered: dict[object, list[MapEntry]] = {}
    for entry in channel_map.entries:
        key = (entry.message, entry.selector, entry.time)
        gathered.setdefault(key, []).append(entry)
    return tuple(
        MessageStream(entries, certificates, vehicle_time=vehicle_time(entries[0]))
        for entries in gathered.values()
    )


def _ranges(aircraft: Aircraft) -> dict[str, tuple[float, float]]:
    """Return what each instrument can show, SI."""
    sensors = aircraft.sensors
    return {
        **{name: one.range for name, one in sensors.by_channel.items()},
        # Zero is where the pressure transducers rest, not where they clip.
        "dynamic_pressure": (-np.inf, sensors.air_data.range[1]),
        "static_pressure": (-np.inf, sensors.air_data.static_range[1]),
    }
