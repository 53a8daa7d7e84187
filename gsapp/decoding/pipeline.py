"""From samples of messages to blocks on the grid: streams, choice of source, derived channels.

Channels are gathered in groups that share their rows: those of one message that have no other
source, those for which the same sources compete, and those derived from inputs of several groups.
A group yields blocks of its own, so no message waits for another.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from calibration import Certificate
from gsapp.aircraft import Aircraft
from gsapp.decoding.channel_map import ChannelMap, MapEntry
from gsapp.decoding.derived import LONGEST_HOLD, Derivation, SlowInput, derivations_for
from gsapp.decoding.grid import (
    LONGEST_FILL,
    ColumnIndex,
    Grid,
    Gridder,
    Rows,
    Samples,
    columns_at,
)
from gsapp.decoding.merging import Merger
from gsapp.decoding.stream import Columns, Converter, Stream
from gsapp.quantities import Block, FloatArray

_FORGET = 4 * LONGEST_HOLD
_LONGEST_WAIT = 2 * round(LONGEST_FILL * 1e6)
_AT_ONCE = 1024  # samples: so many that the cost of a step is spread, so few that they are cached


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSource:
    """Where a channel comes from.

    Attributes
    ----------
    source : str
        Source in the map, the better first where there are several; or the formula and inputs.
    kind : {"measured", "estimated", "derived"}
        What the best source does for it.
    calibrated : bool
        Whether a certificate is in force for it, or for all that it is derived from.
    timing : {"vehicle", "arrival"}
        Whether its samples carry the vehicle's time. Those timed by arrival stay out of
        identification unless asked for.
    samples : int or None
        How many arrived, before the grid: of the source that gave most, or of the input of a
        derived channel that gave least. None where nobody counted.
    rate : float or None
        Their rate, Hz: one over the median period of late.
    gaps : int or None
        How often they were further apart than the grid bridges.
    """

    source: str
    kind: Literal["measured", "estimated", "derived"]
    calibrated: bool
    timing: Literal["vehicle", "arrival"] = "vehicle"
    samples: int | None = None
    rate: float | None = None
    gaps: int | None = None


@dataclass(slots=True)
class _Step:
    """One derived column of a group: inputs are columns, or slow inputs from elsewhere."""

    derivation: Derivation
    inputs: list[int | SlowInput]


@dataclass(slots=True)
class _Group:
    """Channels that share their rows: its own, then the derived ones.

    A group with `join` takes its own channels from other groups, and emits the derived ones only.
    """

    channels: tuple[str, ...]
    width: int
    join: _Join | None = None
    steps: list[_Step] = field(default_factory=list)
    ready: list[Rows] = field(default_factory=list)

    @property
    def emitted(self) -> tuple[str, ...]:
        """Return the channels of its blocks."""
        return self.channels if self.join is None else self.channels[self.width :]

    def derive(self, grid: Grid, rows: Rows) -> Rows:
        """Add the derived columns."""
        if not self.steps:
            return rows
        # Each channel in a row of its own: a function may round differently on a strided one.
        table = np.empty((len(self.channels), len(rows.values)))
        table[: self.width] = rows.values.T
        micros: FloatArray | None = None
        for place, step in enumerate(self.steps, start=self.width):
            inputs = []
            for each in step.inputs:
                if isinstance(each, SlowInput):
                    if micros is None:
                        micros = grid.micros(rows.first, len(rows.values))
                    inputs.append(each.at(micros))
                else:
                    inputs.append(table[each])
            table[place] = step.derivation.compute(*inputs)
        return Rows(rows.first, table.T)

    def block(self, grid: Grid, rows: Rows) -> Block:
        """Return rows, derived columns included, as a block."""
        return Block.trusted(
            self.emitted,
            grid.times(rows.first, len(rows.values)),
            rows.values if self.join is None else rows.values[:, self.width :],
        )


@dataclass(slots=True)
class _Join:
    """Rows of several groups, where all of them have one."""

    parents: list[tuple[_Group, int]]
    waiting: list[deque[Rows]]

    def pull(self) -> list[Rows]:
        """Return the rows that all parents have by now."""
        for queue, (parent, column) in zip(self.waiting, self.parents, strict=True):
            # A copy: what waits may wait long, and should not hold the other columns.
            queue += [Rows(rows.first, rows.values[:, column].copy()) for rows in parent.ready]
        found = []
        while all(self.waiting):
            heads = [queue[0] for queue in self.waiting]
            first = max(head.first for head in heads)
            end = min(head.end for head in heads)
            if first < end:
                parts = [head.values[first - head.first : end - head.first] for head in heads]
                found.append(Rows(first, np.column_stack(parts)))
            self.drop(end)
        return found

    def drop(self, end: int) -> None:
        """Let go of rows before one."""
        for queue in self.waiting:
            while queue and queue[0].end <= end:
                queue.popleft()


class Pipeline:
    """Everything after framing and timing.

    Parameters
    ----------
    channel_map : ChannelMap
        Sources of channels.
    certificates : mapping of str to Certificate
        In force, by channel.
    aircraft : Aircraft or None
        For the ranges of its instruments.
    rate : float
        Rows per second.
    vehicle_time : callable
        Whether the message of an entry carries the vehicle's time.

    Attributes
    ----------
    grid : Grid
        The grid.
    streams : tuple of Stream
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
    ) -> None:
        self.grid = Grid(rate)
        self._fallback = round(channel_map.fallback * 1e6)
        self.streams = _streams(channel_map, certificates, vehicle_time)
        self._converter = Converter(self.streams, {} if aircraft is None else _ranges(aircraft))
        self._gridder = Gridder(
            self.grid,
            circular=[stream.circular for stream in self.streams],
            stepwise=[stream.stepwise for stream in self.streams],
            fallback=self._fallback,
        )
        self.sources: dict[str, ChannelSource] = {}
        self._groups: list[_Group] = []
        self._direct: list[tuple[ColumnIndex | None, _Group] | None] = [None] * len(self.streams)
        self._mergers: list[tuple[Merger, _Group]] = []
        self._merged: list[list[tuple[Merger, int, ColumnIndex]]] = [[] for _ in self.streams]
        self._inputs: dict[str, tuple[str, ...]] = {}
        self._slow: dict[str, SlowInput] = {}
        self._slow_feeds: list[list[tuple[SlowInput, int, int]]] = [[] for _ in self.streams]
        self._candidates = self._find_candidates()
        self._arrange()
        self._add_derived()

    @property
    def clipped(self) -> dict[str, int]:
        """Return how many samples lay outside calibration or instrument range, by channel."""
        totals: dict[str, int] = {}
        for stream in self.streams:
            for name, count in stream.clipped.items():
                totals[name] = totals.get(name, 0) + count
        return totals

    @property
    def duplicates(self) -> int:
        """Return how many samples had the stamp of their predecessor."""
        return sum(track.duplicates for track in self._gridder.tracks)

    @property
    def overtaken(self) -> int:
        """Return how many samples came after a later one of the same message."""
        return sum(track.overtaken for track in self._gridder.tracks)

    def push(
        self, stream: int, times: Sequence[int], nows: Sequence[int], columns: Columns
    ) -> None:
        """Take samples of one stream, given by columns.

        Parameters
        ----------
        stream : int
            Place in `streams`.
        times : sequence of int
            Flight times, us.
        nows : sequence of int
            Latest flight time of any message when each came, us.
        columns : mapping
            Fields of the message by name, each of shape (n,) or (n, k).
        """
        numbers = self.streams[stream].numbers(columns, len(times))
        for start in range(0, len(times), _AT_ONCE):
            piece = slice(start, start + _AT_ONCE)
            part = numbers[piece]
            samples = Samples(stream, 0, len(part), times[piece], nows[piece])
            self.take((samples,), part)

    def take(self, batch: Sequence[Samples], raw: FloatArray) -> None:
        """Take samples of several streams.

        Parameters
        ----------
        batch : sequence of Samples
            Whose rows of `raw` are whose: each stream once at most.
        raw : ndarray, shape (n, n_wanted)
            The numbers that each stream wants, zeros beyond them. Written to.
        """
        values = self._converter.convert(batch, raw)
        for number, start, stop, times, nows in batch:
            for slow, source, column in self._slow_feeds[number]:
                slow.push(source, times, nows, values[start:stop, column].tolist())
        for number, rows in self._gridder.feed(batch, values):
            direct = self._direct[number]
            if direct is not None:
                own, group = direct
                group.ready.append(rows if own is None else rows.of(own))
            for merger, source, chosen in self._merged[number]:
                merger.push(source, rows.of(chosen))

    def pull(self, first: int | None, now: int, *, final: bool = False) -> list[Block]:
        """Return the blocks that are complete; see `Merger.pull` for the parameters."""
        for merger, group in self._mergers:
            group.ready += merger.pull(first, now, final=final)
        blocks: list[Block] = []
        for group in self._groups:
            if group.join is not None:
                group.ready += group.join.pull()
            if group.ready:
                group.ready = [group.derive(self.grid, rows) for rows in group.ready]
                blocks += [group.block(self.grid, rows) for rows in group.ready]
        for group in self._groups:
            group.ready = []
        for slow in self._slow.values():
            slow.forget(now - _FORGET)
        return blocks

    def give_up(self, now: int) -> None:
        """Let go of rows that have waited too long for another input of a derived channel.

        Two minutes longer than a better source is waited for: an input that comes later still,
        or never, is not waited for. To be called at moments that depend on the record alone.
        """
        oldest = self.grid.at_or_after(now - _LONGEST_WAIT - self._fallback)
        for group in self._groups:
            if group.join is not None:
                group.join.drop(oldest)

    def counted_sources(self) -> dict[str, ChannelSource]:
        """Return `sources` with what arrived of each so far."""
        counted: dict[str, ChannelSource] = {}
        for name, source in self.sources.items():
            inputs = self._inputs.get(name)
            counted[name] = (
                self._counted(name, source)
                if inputs is None
                # Derivations stand after their inputs.
                else _like(source, min((counted[each] for each in inputs), key=_samples_of))
            )
        return counted

    def _counted(self, name: str, source: ChannelSource) -> ChannelSource:
        tracks = self._gridder.tracks
        samples, track = max(
            (
                (tracks[number].samples - int(tracks[number].missing[column]), tracks[number])
                for number, column in self._candidates[name]
            ),
            key=lambda each: each[0],
        )
        rate = round(1e6 / track.period, 3) if samples > 1 else None
        return replace(source, samples=samples, rate=rate, gaps=track.gaps)

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
            self._direct[number] = (None if every else columns_at(own), group)
        for numbers, names in competing.items():
            group = self._new_group(names)
            merger = Merger(
                self.grid,
                [self._gridder.tracks[number] for number in numbers],
                len(names),
                self._fallback,
            )
            self._mergers.append((merger, group))
            for source, number in enumerate(numbers):
                columns = [self._candidates[name][source][1] for name in names]
                self._merged[number].append((merger, source, columns_at(columns)))

    def _new_group(self, names: Sequence[str], join: _Join | None = None) -> _Group:
        group = _Group(channels=tuple(names), width=len(names), join=join)
        self._groups.append(group)
        return group

    def _add_derived(self) -> None:
        for derivation in derivations_for(list(self._candidates)):
            group = self._group_with(derivation.quick)
            inputs: list[int | SlowInput] = [group.channels.index(n) for n in derivation.quick]
            inputs += [
                group.channels.index(name) if name in group.channels else self._slow_input(name)
                for name in derivation.slow
            ]
            group.steps.append(_Step(derivation, inputs))
            group.channels += (derivation.output,)
            self._inputs[derivation.output] = tuple(derivation.quick)
            used = [self.sources[name] for name in derivation.inputs]
            arrival = any(self.sources[name].timing == "arrival" for name in derivation.quick)
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


def _samples_of(source: ChannelSource) -> int:
    return source.samples or 0


def _like(source: ChannelSource, counted: ChannelSource) -> ChannelSource:
    return replace(source, samples=counted.samples, rate=counted.rate, gaps=counted.gaps)


def _streams(
    channel_map: ChannelMap,
    certificates: Mapping[str, Certificate],
    vehicle_time: Callable[[MapEntry], bool],
) -> tuple[Stream, ...]:
    gathered: dict[object, list[MapEntry]] = {}
    for entry in channel_map.entries:
        key = (entry.message, entry.selector, entry.time)
        gathered.setdefault(key, []).append(entry)
    return tuple(
        Stream(entries, certificates, vehicle_time=vehicle_time(entries[0]))
        for entries in gathered.values()
    )


def _ranges(aircraft: Aircraft) -> dict[str, tuple[float, float]]:
    """Return what each instrument can show, SI."""
    sensors = aircraft.sensors
    return {
        "alpha": sensors.alpha_vane.range,
        "beta": sensors.beta_vane.range,
        **dict.fromkeys(("p", "q", "r"), sensors.gyro.range),
        **dict.fromkeys(("ax", "ay", "an"), sensors.accelerometer.range),
        # Zero is where the pressure transducers rest, not where they clip.
        "dynamic_pressure": (-np.inf, sensors.air_data.range[1]),
        "static_pressure": (-np.inf, sensors.air_data.static_range[1]),
    }
