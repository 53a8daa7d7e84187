"""After landing: the on-board log takes the place of what came over the radio.

The radio carries a fraction of what the box records. The log, at its full rate, is aligned in time
with the live record and replaces it; flight time stays that of the live record, so that marks and
grades stand where they stood. Where one of the two has nothing, the other fills in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import fft

from gsapp.flight.cache import Decoded
from gsapp.flight.uniform import overlay
from gsapp.quantities import Block, FloatArray

_LEAD = ("q", "p", "r", "alpha", "an", "ay", "phi", "theta", "de", "da", "dr", "qbar", "V")
_CHANNELS_COMPARED = 4
_LEAST_OVERLAP = 2.0
_LEAST_SHARE = 0.2
_LEAST_CORRELATION = 0.8
_MOST_ROWS = 1 << 22


@dataclass(frozen=True, slots=True, kw_only=True)
class Alignment:
    """How far one record lies behind another.

    Attributes
    ----------
    rows : int
        Rows to add to the log's, so that it lies on the live record.
    correlation : float
        Of the two there, 0 to 1.
    """

    rows: int
    correlation: float


def with_onboard_log(live: Decoded, log: Decoded, rate: float) -> Decoded:
    """Replace a live record by the on-board log of the same flight.

    Parameters
    ----------
    live, log : Decoded
        On the grid ``k / rate``.
    rate : float
        Rows per second.

    Returns
    -------
    Decoded
        The channels of both, from the log where it has a sample. If the two cannot be aligned,
        the live record alone, and a remark that says so.
    """
    found = align(live.block, log.block, rate)
    if found is None:
        return replace(
            live,
            remarks=(
                *live.remarks,
                "the on-board log could not be aligned with the live record, since no channel "
                "of both moves alike; the live record is shown. Open the log by itself to see it",
            ),
        )
    remarks = [
        f"the on-board log replaces the live record where it has samples "
        f"({len(log.block.channels)} channels)"
    ]
    if found.rows:
        remarks.append(
            f"its clock differs by {found.rows / rate:.2f} s, found by comparing channels "
            f"(correlation {found.correlation:.3f})"
        )
    return Decoded(
        block=overlay((live.block, _later(log.block, found.rows, rate)), rate),
        sources={
            **live.sources,
            **{
                name: replace(source, source=f"on-board log: {source.source}")
                for name, source in log.sources.items()
            },
        },
        frames=live.frames,
        said=live.said,
        remarks=(*live.remarks, *remarks, *log.remarks),
    )


def align(live: Block, log: Block, rate: float) -> Alignment | None:
    """Find how far a log lies behind a live record of the same motion.

    The masked, normalized cross-correlation of a few common channels, averaged, has its peak
    there.

    Parameters
    ----------
    live, log : Block
        On the grid ``k / rate``.
    rate : float
        Rows per second.

    Returns
    -------
    Alignment or None
        None if no channel of both moves alike anywhere. One row, or less, counts as none: it is
        the delay of interpolation, and both carry the vehicle's own clock.
    """
    names = _common(live, log)
    if not names:
        return None
    live_first, live_values = _dense(live, names, rate)
    log_first, log_values = _dense(log, names, rate)
    if max(len(live_values), len(log_values)) > _MOST_ROWS:
        return None
    correlation = _correlation(live_values, log_values, rate)
    best = int(np.argmax(correlation))
    if not correlation[best] >= _LEAST_CORRELATION:
        return None
    lag = best - (len(log_values) - 1) + live_first - log_first
    if abs(lag) <= 1:
        lag = 0
    return Alignment(rows=lag, correlation=float(correlation[best]))


def _common(live: Block, log: Block) -> list[str]:
    """Return channels of both that move, the telling ones first."""
    shared = [name for name in live.channels if name in log.channels]
    ordered = [name for name in _LEAD if name in shared]
    ordered += [name for name in shared if name not in ordered]
    moving = [name for name in ordered if all(_spread(block[name]) > 0.0 for block in (live, log))]
    return moving[:_CHANNELS_COMPARED]


def _spread(values: FloatArray) -> float:
    there = values[~np.isnan(values)]
    return float(np.ptp(there)) if there.size else 0.0


def _dense(block: Block, names: Sequence[str], rate: float) -> tuple[int, FloatArray]:
    """Return the first row and all rows without omissions; a pause is filled with NaN."""
    index = np.rint(block.times * rate).astype(np.int64)
    size = int(index[-1] - index[0]) + 1
    values = np.full((min(size, _MOST_ROWS + 1), len(names)), np.nan)
    inside = index - index[0] < len(values)
    for place, name in enumerate(names):
        values[index[inside] - index[0], place] = block[name][inside]
    return int(index[0]), values


def _correlation(live: FloatArray, log: FloatArray, rate: float) -> FloatArray:
    """Return the mean correlation at every lag, from the log's end on the live's beginning on."""
    size = len(live) + len(log) - 1
    padded = fft.next_fast_len(size, real=True)

    def sums(one: FloatArray, other: FloatArray) -> FloatArray:
        product = fft.rfft(one, padded) * fft.rfft(other[::-1], padded)
        result: FloatArray = fft.irfft(product, padded)[:size]
        return result

    total = np.zeros(size)
    for place in range(live.shape[1]):
        a, b = live[:, place], log[:, place]
        a_there, b_there = (~np.isnan(a)).astype(float), (~np.isnan(b)).astype(float)
        a, b = np.nan_to_num(a - np.nanmean(a)), np.nan_to_num(b - np.nanmean(b))
        energy = sums(a * a, b_there) * sums(a_there, b * b)
        both = sums(a_there, b_there)
        least = max(_LEAST_OVERLAP * rate, _LEAST_SHARE * min(a_there.sum(), b_there.sum()))
        # Rounding of the transform leaves a little where nothing is.
        usable = (both >= least) & (energy > 1e-12 * energy.max())
        total[usable] += sums(a, b)[usable] / np.sqrt(energy[usable])
    result: FloatArray = total / live.shape[1]
    return result


def _later(block: Block, rows: int, rate: float) -> Block:
    """Return a block moved by whole rows of the grid."""
    times = (np.rint(block.times * rate) + rows) / rate
    return Block(channels=block.channels, times=times, values=block.values)
