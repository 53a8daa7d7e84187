"""Putting an on-board log in the place of the live record, in flight time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from gsapp.flight.cache import DecodedFlight
from gsapp.flight.onboard_log.clock_alignment import ClockAlignmentError, align_clocks
from gsapp.flight.onboard_log.log_state import LogClock, OnboardLogState
from gsapp.flight.settings import ALIGNMENT
from gsapp.flight.uniform_grid import overlay_on_grid
from gsapp.quantities import CIRCULAR_CHANNELS, STEPWISE_CHANNELS, Block, FloatArray, base_id


def merge_onboard_log(
    live: DecodedFlight, log: DecodedFlight, rate: float, name: str
) -> DecodedFlight:
    """Replace a live record by the on-board log of the same flight, on the same grid.

    The channels of both, from the log where it has a sample, in flight time. If the two cannot be
    aligned, the live record alone, and a remark that says so.
    """
    by_arrival = {
        channel
        for channel in live.block.channels
        if (source := live.sources.get(channel)) is not None and source.timing == "arrival"
    }
    try:
        clock = align_clocks(live.block, log.block, rate, leave_out=by_arrival)
    except ClockAlignmentError as error:
        return reject_onboard_log(
            live,
            name,
            f"it could not be aligned with the live record, since {error}; the live record is "
            "used. Check that it is the log of this flight",
        )
    state = OnboardLogState(file=name, in_place=True, channels=len(log.block.channels), clock=clock)
    return DecodedFlight(
        block=overlay_on_grid((live.block, resample_to_flight_time(log.block, clock, rate)), rate),
        sources={
            **live.sources,
            **{
                channel: replace(source, source=f"on-board log: {source.source}")
                for channel, source in log.sources.items()
            },
        },
        frames=live.frames,
        vehicle_messages=live.vehicle_messages,
        remarks=(*live.remarks, state.remark(), *log.remarks),
        onboard=state,
    )


def merge_native_samples(
    live: DecodedFlight, log: DecodedFlight, state: OnboardLogState | None
) -> DecodedFlight:
    """Replace the samples of a live record by those of the on-board log, in flight time.

    Both at their own times; `state` says how the two clocks are aligned. A log that is not in place
    is left out.
    """
    if state is None or state.clock is None:
        return live
    clock = state.clock
    times = log.block.times
    shifted = Block(
        channels=log.block.channels,
        times=times + clock.offset - clock.applied_drift * (times - clock.at),
        values=log.block.values,
    )
    only_live = [name for name in live.block.channels if name not in log.block.channels]
    parts = [shifted, live.block.select(only_live)]
    union = np.unique(np.concatenate([part.times for part in parts]))
    values = np.full((union.size, sum(len(part.channels) for part in parts)), np.nan)
    column = 0
    for part in parts:
        rows = np.searchsorted(union, part.times)
        values[rows, column : column + len(part.channels)] = part.values
        column += len(part.channels)
    present = ~np.isnan(values).all(axis=1)
    return replace(
        live,
        block=Block(
            channels=tuple(name for part in parts for name in part.channels),
            times=union[present],
            values=values[present],
        ),
        sources={**live.sources, **log.sources},
        onboard=state,
    )


def reject_onboard_log(live: DecodedFlight, name: str, why: str) -> DecodedFlight:
    """Return a live record, and that its log is left out for some reason."""
    state = OnboardLogState(file=name, in_place=False, why=why)
    return replace(live, remarks=(*live.remarks, state.remark()), onboard=state)


def resample_to_flight_time(log: Block, clock: LogClock, rate: float) -> Block:
    """Lay a log on the grid of flight time; NaN where it has no sample.

    Without a drift it moves by whole rows: its samples stay as they were measured, at most half a
    row beside their time, all channels alike. That one row or less is none at all: both then carry
    the vehicle's own clock. With a drift each row lies elsewhere between two of the log's, and a
    cubic through four of them keeps what moves slowly as it is.
    """
    if not log.times.size:
        return log
    index = np.rint(log.times * rate).astype(np.int64)
    drift = clock.applied_drift
    moved = (clock.offset - drift * (log.times[[0, -1]] - clock.at)) * rate
    if np.abs(moved).max() <= 1.0:
        return log
    if drift == 0.0:
        return Block(
            channels=log.channels,
            times=(index + round(clock.offset * rate)) / rate,
            values=log.values,
        )
    first, last = np.ceil(log.times[[0, -1]] * rate + moved).astype(np.int64).tolist()
    rows = np.arange(first, last + 1)
    at = clock.at
    # Of flight time = t + offset - drift (t - at), the t.
    own = at + (rows / rate - at - clock.offset) / (1.0 - drift)
    values = _interpolate_rows(log, index, own * rate)
    held = ~np.isnan(values).all(axis=1)
    return Block(channels=log.channels, times=rows[held] / rate, values=values[held])


def _interpolate_rows(log: Block, index: npt.NDArray[np.int64], places: FloatArray) -> FloatArray:
    """Return the values of a block at places between its rows, shape (m, n_channels).

    `index` has the numbers of its rows, increasing, with gaps. NaN where one of the two rows beside
    has no sample.
    """
    near = np.rint(places)
    exact = np.abs(places - near) < ALIGNMENT.row_tolerance
    before = np.where(exact, near, np.floor(places)).astype(np.int64)
    part = np.where(exact, 0.0, places - before)[:, np.newaxis]
    four = [_take_rows(log.values, index, before + step) for step in (-1, 0, 1, 2)]
    left, here, there, right = four
    values: FloatArray = here + part * (there - here)
    cubic = (
        -part * (part - 1.0) * (part - 2.0) / 6.0 * left
        + (part + 1.0) * (part - 1.0) * (part - 2.0) / 2.0 * here
        - (part + 1.0) * part * (part - 2.0) / 2.0 * there
        + (part + 1.0) * part * (part - 1.0) / 6.0 * right
    )
    values = np.where(np.isnan(cubic), values, cubic)
    values[exact] = here[exact]
    for column, name in enumerate(log.channels):
        base = base_id(name)
        if base in STEPWISE_CHANNELS:
            values[:, column] = here[:, column]
        elif base in CIRCULAR_CHANNELS:
            # The short way round, and back between half turns.
            way = np.remainder(there[:, column] - here[:, column] + np.pi, 2.0 * np.pi) - np.pi
            turned = here[:, column] + part[:, 0] * way
            turned = np.remainder(turned + np.pi, 2.0 * np.pi) - np.pi
            values[:, column] = np.where(exact, here[:, column], turned)
    return values


def _take_rows(
    values: FloatArray, index: npt.NDArray[np.int64], wanted: npt.NDArray[np.int64]
) -> FloatArray:
    place = np.minimum(np.searchsorted(index, wanted), index.size - 1)
    rows: FloatArray = np.where((index[place] == wanted)[:, np.newaxis], values[place], np.nan)
    return rows
