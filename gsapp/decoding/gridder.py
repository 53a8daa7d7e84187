"""Samples at the vehicle's own moments on the grid k / rate of flight time; which source counts.

Between two samples the value is interpolated linearly (angles that go round, the shorter way;
counts and switches keep the former value). A row on a sample has exactly that sample's value. A
row is complete as soon as a sample at or after it has come.

Between samples that lie more than 2.5 sample periods apart there is nothing: NaN. The period of
a message is the lower median of its last nine intervals, the one in question included, so it
depends on the samples alone; until two intervals are known an interval of up to 2.5 s passes. A
pause longer than `LONGEST_FILL` is not filled at all: rows go on after it, and no memory is spent
on it. A sample that is not later than its predecessor (a duplicate, or one overtaken on the way)
is passed over and counted.

Where rows lie depends on the times of the samples alone. Their values are computed in one of two
ways that give the same bits: for the few rows that a live link gives at a time, on a sheet with
those of all other messages; for many, by matrices.

Of several sources of a channel the better counts while it lives. It falls silent when flight time
has gone on by more than its patience since its last sample; the rows since then are taken from the
next source, until the better one is back. What a row holds depends on the samples and on what
flight time it was when they came, so on the record alone: a row is handed out only when nothing
that may still come could change it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from gsapp.decoding.grid import BoolArray, Grid, GridRows, Numbers, RowBatch, column_index
from gsapp.decoding.row_plan import RowPlan, plan_rows
from gsapp.decoding.settings import DECODING
from gsapp.quantities import FloatArray

_FULL_TURN = 2.0 * math.pi
_FEW_ROWS = 20  # are quicker on a sheet
_FEW_BETWEEN = 4  # rows between two samples are quicker one by one
_MANY_SAMPLES = 50  # are quicker all at once


class Gridder:
    """Lays the samples of one message on the grid, as they come.

    Circular channels, shape (m,), are angles from -pi to pi and come out in that range; stepwise
    ones keep the former value. After `fallback` us of silence, at least 2.5 periods, another source
    counts.

    Attributes
    ----------
    first : tuple of int, or None
        Time of the first sample, and the latest flight time before it came, us.
    begin : int
        The first row at or after the first sample.
    last : int or None
        Time of the last sample, us.
    samples, duplicates, reordered : int
        How many samples were laid, and how many were not because they had the stamp of their
        predecessor or came after a later one.
    gaps : int
        How often samples lay further apart than the grid bridges.
    missing : list of int
        Samples without a number, by channel.
    """

    def __init__(
        self, grid: Grid, *, circular: BoolArray, stepwise: BoolArray, fallback: int = 1_000_000
    ) -> None:
        self.duplicates = 0
        self.reordered = 0
        self.samples = 0
        self.gaps = 0
        self._gap_time = 0
        self.missing = [0] * circular.size
        self.last: int | None = None
        self.first: tuple[int, int] | None = None
        self.begin = 0
        self._grid = grid
        self._longest = grid.max_filled_rows * grid.step
        self._angles: list[int] = np.flatnonzero(circular).tolist()
        self._steps: list[int] = np.flatnonzero(stepwise).tolist()
        self._circular = column_index(self._angles)
        self._stepwise = column_index(self._steps)
        self._fallback = fallback
        self._value: Numbers = [math.nan] * circular.size
        self._next = 0
        self._intervals: deque[int] = deque(maxlen=DECODING.period_window)
        self._least = 0  # none of these intervals is shorter
        # Flight time, us, by which a silence had been noticed: until then another source counts,
        # whatever comes late.
        self._silent_until = -1

    @property
    def period(self) -> int:
        ordered = sorted(self._intervals)
        return ordered[(len(ordered) - 1) // 2] if ordered else DECODING.unknown_period

    @property
    def rate(self) -> float | None:
        """Return how many samples came in a second, gaps left out, Hz; None where no two did."""
        count = self.samples - 1 - self.gaps
        if self.first is None or self.last is None or count < 1:
            return None
        return 1e6 * count / (self.last - self.first[0] - self._gap_time)

    @property
    def silence_timeout(self) -> int:
        """Return after what silence another source counts, us."""
        return max(self._fallback, self.period * 5 // 2)

    def feed(self, times: Sequence[int], nows: Sequence[int], values: FloatArray) -> list[GridRows]:
        """Take samples, shape (n, m), none infinite; return the rows that they complete.

        Beside the flight time of each sample (us) stands the latest flight time of any message when
        it came. Usually the rows are one piece, or none; more where a long pause parts them.
        """
        many = len(times) >= _MANY_SAMPLES
        plans, place, passed_over = (self._plan_many if many else self._plan)(times, nows)
        if not place:
            return []
        missing = np.isnan(values)
        if np.count_nonzero(missing):
            missing[[index - 1 for index in passed_over]] = False
            counts = missing.sum(axis=0).tolist()
            self.missing = [x + y for x, y in zip(self.missing, counts, strict=True)]
        known = np.empty((len(values) + 1, values.shape[1]))
        known[0], known[1:] = self._value, values
        self._value = known[place].tolist()
        return [self._laid(each, known) for each in plans if len(each.after)]

    def feed_few(
        self,
        times: Sequence[int],
        nows: Sequence[int],
        samples: Sequence[Numbers],
        sheet: RowBatch,
        *,
        complete: bool = False,
    ) -> list[GridRows]:
        """Take a few samples: as `feed`, with the same bits, quicker for some ten.

        The samples are kept: the caller writes to them no more. The values of the rows are there
        once the sheet is laid. `complete` says that no number is missing.
        """
        plans, place, passed_over = self._plan(times, nows)
        if not place:
            return []
        if not complete:
            for index, numbers in enumerate(samples, start=1):
                if math.isnan(sum(numbers)) and index not in passed_over:
                    for column, number in enumerate(numbers):
                        self.missing[column] += math.isnan(number)
        known = (self._value, *samples)
        self._value = known[place]
        return [self._put(each, known, sheet) for each in plans if len(each.after)]

    def _plan_many(
        self, times: Sequence[int], nows: Sequence[int]
    ) -> tuple[list[RowPlan], int, list[int]]:
        """Do what `_plan` does, for many samples."""
        found = plan_rows(
            self._grid,
            times,
            nows,
            last=self.last,
            intervals=self._intervals,
            fallback=self._fallback,
            silent_until=self._silent_until,
        )
        if found is None:
            return self._plan(times, nows)
        kept = found.kept
        self.duplicates += found.repeated
        self.reordered += len(times) - kept.size - found.repeated
        if not kept.size:
            return [], 0, []
        if self.last is None:
            self.first = (times[0], nows[0])
            self.begin = self._grid.row_at_or_after(times[0])
        self.samples += kept.size
        self.gaps += found.gaps
        self._gap_time += found.gap_time
        self.last = times[int(kept[-1])]
        self._next = found.next_row
        self._silent_until = found.silent_until
        self._intervals += found.intervals[-DECODING.period_window :].tolist()
        self._least = min(self._intervals, default=0)
        passed_over = np.ones(len(times), dtype=bool)
        passed_over[kept] = False
        return found.plans, int(kept[-1]) + 1, (np.flatnonzero(passed_over) + 1).tolist()

    def _plan(  # noqa: C901 - the hot loop stays in one piece
        self, times: Sequence[int], nows: Sequence[int]
    ) -> tuple[list[RowPlan], int, list[int]]:
        """Plan the rows that samples complete; return them, the last sample that counts, others.

        Place 0 is the last sample before these, if there is one; place 1 the first of these.
        """
        numerator, step, fallback = self._grid.numerator, self._grid.step, self._fallback
        until = self._silent_until * numerator
        place, last, least = 0, self.last, self._least
        at = 0 if last is None else last * numerator
        row = self._next
        befores, afters, weights, gaps, silents = _no_rows()
        plans = [RowPlan(row, befores, afters, weights, gaps, silents)]
        passed_over = []
        index = 0
        for time, now in zip(times, nows, strict=True):
            index += 1
            came = now if now > time else time
            gap = silent = False
            before = at
            if last is None:
                self.first = (time, now)
            elif time > last:
                passed = came - last
                silent = passed > fallback and passed > self.silence_timeout
                if silent and now * numerator > until:
                    self._silent_until, until = now, now * numerator
                interval = time - last
                self._intervals.append(interval)
                if interval < least:
                    self._least = least = interval
                elif 2 * interval > 5 * least:  # else no gap, told without the median
                    gap = self._is_gap(interval)
                    least = self._least
            else:
                passed_over.append(index)
                self._pass_over(repeated=time == last)
                continue
            at = time * numerator
            if last is None:
                self.begin = -(-at // step)
            if last is None or at - before > self._longest:
                # Rows begin, or go on after a pause too long to be filled.
                row = -(-at // step)
                befores, afters, weights, gaps, silents = _no_rows()
                plans.append(RowPlan(row, befores, afters, weights, gaps, silents))
            between, position, start = at - before, row * step - before, len(afters)
            if between - position > _FEW_BETWEEN * step:
                weights += [each / between for each in range(position, between, step)]
                count = len(weights) - start
                befores += [place] * count
                afters += [index] * count
                position += count * step
            else:
                while position < between:
                    weights.append(position / between)
                    befores.append(place)
                    afters.append(index)
                    position += step
            if gap:
                gaps += range(start, len(afters))
            if silent:
                silents += range(start, len(afters))
            elif before < until:
                silents += range(start, min(len(afters), start - row - -until // step))
            if position == between:
                if at < until:
                    silents.append(len(afters))
                befores.append(index)
                afters.append(index)
                weights.append(1.0)
            row += len(afters) - start
            place, last = index, time
        self.samples += index - len(passed_over)
        self.last = last
        self._next = row
        return plans, place, passed_over

    def _pass_over(self, *, repeated: bool) -> None:
        if repeated:
            self.duplicates += 1
        else:
            self.reordered += 1

    def _is_gap(self, interval: int) -> bool:
        if len(self._intervals) > 1:
            self._least = min(self._intervals)
        usual = self.period if len(self._intervals) > 1 else DECODING.unknown_period
        gap = 2 * interval > 5 * usual
        if gap:
            self.gaps += 1
            self._gap_time += interval
        return gap

    def _laid(self, plan: RowPlan, known: FloatArray) -> GridRows:
        result = self._between(plan, known)
        if self._angles:
            angles = result[:, self._circular]
            result[:, self._circular] = angles - _FULL_TURN * np.ceil(angles / _FULL_TURN - 0.5)
        return GridRows(plan.first, result, plan.silence())

    def _between(self, plan: RowPlan, known: FloatArray) -> FloatArray:
        """Return values of planned rows. On a sample both ends are that sample."""
        start, stop = known.take(plan.before, axis=0), known.take(plan.after, axis=0)
        share = np.array(plan.weights)[:, np.newaxis]
        values: FloatArray = start * (1.0 - share)
        values += stop * share
        if self._angles:
            turn = stop[:, self._circular] - start[:, self._circular]
            turn -= _FULL_TURN * np.rint(turn / _FULL_TURN)
            values[:, self._circular] = start[:, self._circular] + share * turn
        if self._steps:
            values[:, self._stepwise] = start[:, self._stepwise]
        if plan.gaps:
            values[plan.gaps] = np.nan
        return values

    def _put(self, plan: RowPlan, known: Sequence[Numbers], sheet: RowBatch) -> GridRows:
        """Put planned rows on a sheet, unless they are many."""
        count, width = len(plan.after), len(known[0])
        if count > _FEW_ROWS:
            return self._laid(plan, np.array(known))
        starts, stops, shares = sheet.starts, sheet.stops, sheet.shares
        begin = len(starts)
        for before, after, share in zip(plan.before, plan.after, plan.weights, strict=True):
            starts += known[before]
            stops += known[after]
            shares += [share] * width
        if self._angles or self._steps:
            self._mend(sheet, begin, count, width)
        for gap in plan.gaps:
            first = begin + gap * width
            starts[first : first + width] = [math.nan] * width
        silent = plan.silence() if plan.silent else None
        return sheet.add(plan.first, count, width, silent)

    def _mend(self, sheet: RowBatch, begin: int, count: int, width: int) -> None:
        """Replace what is not a straight line between two samples by what it is."""
        starts, stops, shares = sheet.starts, sheet.stops, sheet.shares
        end = begin + count * width
        for column in self._angles:
            for place in range(begin + column, end, width):
                stops[place] = _interpolate_angle(starts[place], stops[place], shares[place])
                starts[place], shares[place] = 0.0, 1.0
        for column in self._steps:
            for place in range(begin + column, end, width):
                stops[place], shares[place] = starts[place], 1.0


def _no_rows() -> tuple[list[int], list[int], list[float], list[int], list[int]]:
    return [], [], [], [], []


def _interpolate_angle(start: float, stop: float, share: float) -> float:
    """Return an angle between two, the shorter way round, from -pi to pi.

    The steps of `Gridder._between` and `Gridder._laid` for a single number.
    """
    turn = stop - start
    if not -3.0 < turn < 3.0:
        if math.isnan(turn):
            return math.nan
        turn -= _FULL_TURN * round(turn / _FULL_TURN)
    angle = start + share * turn
    if not -3.0 < angle < 3.0:
        angle -= _FULL_TURN * math.ceil(angle / _FULL_TURN - 0.5)
    # Where NumPy subtracts a negative zero, whole numbers have a positive one.
    return angle + 0.0


_FOREVER = 2**62


class SourceSelector:
    """Chooses among sources of the same `width` channels, the better first.

    Their rows go to `push`. A source has `fallback` us for its first sample. `laid` counts the rows
    that came from each.
    """

    def __init__(self, grid: Grid, sources: Sequence[Gridder], width: int, fallback: int) -> None:
        self._grid = grid
        self._sources = tuple(sources)
        self._rows: list[deque[GridRows]] = [deque() for _ in sources]
        self._width = width
        self._fallback = fallback
        self._next: int | None = None
        self._start = 0
        self._begun = False
        # By source, once it spoke: its first row, and whether it was given up before.
        self._first_rows: dict[int, tuple[int, bool]] = {}
        self.laid = [0] * len(self._sources)

    @property
    def pending_count(self) -> int:
        return sum(map(len, self._rows))

    def push(self, source: int, rows: Sequence[GridRows]) -> None:
        """Take rows of a source, with the columns of this merger's channels only."""
        self._rows[source].extend(rows)

    def pull(self, first: int | None, now: int, *, final: bool = False) -> list[GridRows]:
        """Return the rows that are decided.

        `first` is the flight time at which the record begins, `now` the latest one of any message
        (us); `final` says that nothing more will come.
        """
        if first is None or not (final or any(self._rows)):
            return []
        if self._next is None:
            self._start = first
            self._next = self._grid.row_at_or_after(first)
        found: list[GridRows] = []
        while True:
            piece, end = self._decide(self._next, now, final=final)
            if end == self._next:
                self._forget()
                return found
            if piece is not None:
                found.append(piece)
                self._begun = True
            self._next = end

    def _forget(self) -> None:
        for rows in self._rows:
            while rows and rows[0].end <= (self._next or 0):
                rows.popleft()

    def _decide(self, row: int, now: int, *, final: bool) -> tuple[GridRows | None, int]:
        """Return the rows from `row` on that are decided alike, and the row after them."""
        limit = settled = _FOREVER
        for index, source in enumerate(self._sources):
            rows = self._rows[index]
            while rows and rows[0].end <= row:
                rows.popleft()
            begin, late = self._first_row(index)
            if row < begin:
                limit = min(limit, begin)
                if late:
                    continue
                # It came in time; before its first sample there is nothing.
                return self._nothing(row, limit)
            if rows and rows[0].first <= row:
                piece = rows[0]
                offset = row - piece.first
                silent = piece.silent
                if silent is not None and silent[offset]:
                    limit = min(limit, row + _leading_false_count(~silent[offset:]))
                    continue
                limit = min(limit, settled)
                end = piece.end if silent is None else row + _leading_false_count(silent[offset:])
                end = min(end, limit)
                self.laid[index] += end - row
                if silent is None and not offset and end == piece.end:
                    return piece, end
                return piece.slice_rows(row, end), end
            if rows:
                # A pause too long to be filled.
                limit = min(limit, rows[0].first)
                continue
            since = self._start if source.last is None else source.last
            patience = self._fallback if source.last is None else source.silence_timeout
            # At the end a source that never spoke is given up; one that did keeps its place.
            if now > since + patience or (final and source.last is None):
                # What still comes counts from now on.
                settled = _FOREVER if final else self._grid.row_at_or_after(now)
                continue
            return None, row
        if limit == _FOREVER:
            return None, row
        return self._nothing(row, limit)

    def _first_row(self, number: int) -> tuple[int, bool]:
        """Return the first row of a source that spoke, and whether it was given up before."""
        known = self._first_rows.get(number)
        source = self._sources[number]
        if known is None and source.first is not None:
            late = max(source.first) > self._start + self._fallback
            # Until then another source counted, whatever came late.
            after = self._grid.row_at_or_after(source.first[1]) if late else 0
            known = self._first_rows[number] = (max(source.begin, after), late)
        return known or (0, False)

    def _nothing(self, row: int, end: int) -> tuple[GridRows | None, int]:
        if not self._begun or end - row > self._grid.max_filled_rows:
            return None, end
        return GridRows(row, np.full((end - row, self._width), np.nan)), end


def _leading_false_count(stops: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> int:
    place = int(np.argmax(stops)) if stops.size else 0
    return place if stops.size and stops[place] else int(stops.size)
