"""The shape of one surface's input: where it begins and ends, how large it is, what it is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.quantities import BoolArray, FloatArray

InputKind = Literal["doublet", "3-2-1-1", "pulse", "multistep", "sweep", "retrim", "step"]
"""Shape of an input; see `classify_input`. A step is one of a lever that stayed where it went."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceInput:
    """What one surface did."""

    surface: str
    t_start: float
    t_end: float
    """When it left its trim and when it was back, s."""
    amplitude: float
    """Half the peak-to-peak deflection, rad; of a pulse its height."""
    trim_before: float
    trim_after: float
    """Where it stood, rad."""
    excursions: tuple[tuple[int, float], ...]
    """Side (+1, -1) and duration (s) of each excursion."""
    motion_before: float
    """Peak-to-peak in the stretch before, rad."""
    max_excursion: float
    max_step: float
    """Its largest excursion from trim, and the most it went within `DETECTION.look_back`, rad."""
    side_ratio: float
    """The smaller side over the larger one."""
    kind: InputKind

    @property
    def abruptness(self) -> float:
        """Return its quickest move over its largest excursion: steering builds up, inputs step."""
        return self.max_step / self.max_excursion

    @property
    def has_returned_to_trim(self) -> bool:
        return abs(self.trim_after - self.trim_before) < 0.5 * self.amplitude

    @property
    def is_from_calm(self) -> bool:
        """Return whether the surface stood still before: steering never does."""
        return self.motion_before < DETECTION.calm_before * self.amplitude

    @property
    def is_unmistakable(self) -> bool:
        """Return whether it stepped from side to side as no steering does.

        About its trim, that is: a surface that is retrimmed in one step crosses the line between
        old and new trim as well, but ends twice its amplitude away.
        """
        return (
            self.kind in ("doublet", "3-2-1-1", "multistep")
            and self.abruptness
            > DETECTION.sudden_share * (DETECTION.calm_abrupt_ratio if self.is_from_calm else 1.0)
            and self.side_ratio > 0.4
            and abs(self.trim_after - self.trim_before) < self.amplitude
            and self.motion_before < 1.2 * self.amplitude
        )


def smooth_samples(samples: FloatArray, dt: float) -> FloatArray:
    """Return the centered mean over about 0.05 s; NaN where a sample is missing."""
    half = round(0.5 * DETECTION.smoothing / dt)
    if half < 1 or samples.size < 2 * half + 1:
        return samples
    padded = np.concatenate((np.full(half, samples[0]), samples, np.full(half, samples[-1])))
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
    return np.asarray(windows.mean(axis=1))


def measure_surface_input(
    surface: str,
    times: FloatArray,
    samples: FloatArray,
    first: float,
    last: float,
    noise: float,
    *,
    left: bool = False,
) -> SurfaceInput | None:
    """Measure an input around the quick moves of its surface.

    Parameters
    ----------
    times, samples : ndarray, shape (n,)
        s and rad, from a good second before to a good second after the moves.
    first, last : float
        Times of the first and the last quick move, s; each looks back over `DETECTION.look_back`.
    noise : float
        Standard deviation of the surface's signal, rad.
    left : bool
        Whether its last quick move left it away from trim: it counts from where it stood before
        until then, and from where it was left afterwards.

    Returns
    -------
    SurfaceInput or None
        None where samples are missing, or nothing stands out.
    """
    there = np.isfinite(samples)
    times, samples = times[there], samples[there]
    if times.size < 8:
        return None
    level = smooth_samples(samples, float(np.median(np.diff(times))))
    begin = first - DETECTION.look_back
    calm = (times >= begin - DETECTION.trim_before_input) & (times < begin - 0.02)
    rest = (times > last + 0.2) & (times <= last + 1.0)
    moved = (times >= begin - 0.1) & (times <= last + 0.3)
    if calm.sum() < 3 or moved.sum() < 4:
        return None
    before = float(np.median(level[calm]))
    after = float(np.median(level[rest])) if rest.sum() >= 3 else float(level[-1])
    inside, at = level[moved], times[moved]
    # The trim need not come back to where it was: half way between is fair to both ends.
    trim = np.linspace(before, after, inside.size)
    if left:
        trim = np.where(at < last - DETECTION.look_back, before, after)
    away = inside - trim
    largest = float(np.max(np.abs(away)))
    if not largest > 4.0 * noise:
        return None
    return _shape(surface, times, level, moved, away, (before, after), calm, noise)


def measure_plain_input(
    surface: str, times: FloatArray, samples: FloatArray
) -> SurfaceInput | None:
    """Measure how a surface moved in a stretch about which nothing is known; None for nothing.

    It is in trim where it begins and ends, but for a record that was cut while it was displaced: an
    end far from the middle counts for nothing where the other is close to it.
    """
    there = np.isfinite(samples)
    times, samples = times[there], samples[there]
    if times.size < 8:
        return None
    level = smooth_samples(samples, float(np.median(np.diff(times))))
    edge = max(round(DETECTION.trim_at_edge / float(np.median(np.diff(times)))), 2)
    before, after = float(np.median(level[:edge])), float(np.median(level[-edge:]))
    middle, half = 0.5 * float(level.max() + level.min()), 0.5 * float(np.ptp(level))
    ends = sorted((before, after), key=lambda end: abs(end - middle))
    if abs(ends[0] - middle) < DETECTION.displaced_share * half < abs(ends[1] - middle):
        before = after = ends[0]
    away = level - np.linspace(before, after, level.size)
    largest = float(np.max(np.abs(away)))
    if not largest > 0.0:
        return None
    whole = slice(None)
    one = _shape(surface, times, level, whole, away, (before, after), slice(edge), 0.0)
    return replace(one, kind="multistep") if one is not None and one.kind == "retrim" else one


def _shape(
    surface: str,
    times: FloatArray,
    level: FloatArray,
    moved: BoolArray | slice,
    away: FloatArray,
    trim: tuple[float, float],
    calm: BoolArray | slice,
    noise: float,
) -> SurfaceInput | None:
    """Return the input of the samples that moved, `away` from trim; None for nothing."""
    largest = float(np.max(np.abs(away)))
    runs, edges = _find_excursions(times[moved], away, DETECTION.displaced_share * largest)
    if not runs:
        return None
    threshold = max(DETECTION.begin_share * largest, 3.0 * noise)
    t_start, t_end = _trim_departure_and_return(times, level, edges, *trim, threshold)
    both = len({side for side, _ in runs}) == 2
    return SurfaceInput(
        surface=surface,
        t_start=t_start,
        t_end=t_end,
        amplitude=0.5 * float(np.ptp(away)) if both else largest,
        trim_before=trim[0],
        trim_after=trim[1],
        excursions=tuple(runs),
        motion_before=float(np.ptp(level[calm])),
        max_excursion=largest,
        max_step=_max_step(times[moved], level[moved]),
        side_ratio=_side_ratio(away),
        kind=classify_input(runs),
    )


def _side_ratio(away: FloatArray) -> float:
    sides = sorted((max(float(away.max()), 0.0), max(float(-away.min()), 0.0)))
    return sides[0] / sides[1] if sides[1] > 0.0 else 0.0


def _max_step(times: FloatArray, level: FloatArray) -> float:
    """Return the most that a level changes within `DETECTION.look_back`."""
    earlier = np.searchsorted(times, times - DETECTION.look_back - 1e-9)
    return float(np.max(np.abs(level - level[earlier])))


def _find_excursions(
    times: FloatArray, away: FloatArray, threshold: float
) -> tuple[list[tuple[int, float]], tuple[float, float]]:
    """Return side and duration of each excursion, and when the first begins and the last ends."""
    side = np.where(away > threshold, 1, np.where(away < -threshold, -1, 0))
    cuts = np.flatnonzero(np.diff(side)) + 1
    bounds = [0, *cuts.tolist(), side.size]
    pieces = [
        (int(side[low]), float(times[low]), float(times[min(high, side.size - 1)]))
        for low, high in pairwise(bounds)
    ]
    held = [
        piece
        for piece in pieces
        if piece[0] and piece[2] - piece[1] >= DETECTION.min_displacement_time
    ]
    joined: list[tuple[int, float, float]] = []
    for piece in held:
        if joined and joined[-1][0] == piece[0] and piece[1] - joined[-1][2] < 0.15:
            joined[-1] = (piece[0], joined[-1][1], piece[2])
        else:
            joined.append(piece)
    # A side is left for good where the next one is reached: a short step is not lost in its edges.
    gaps = [later[1] - piece[2] for piece, later in pairwise(joined)]
    edge = min(gaps, default=0.0)
    runs = [
        (
            piece[0],
            (later[1] if later[1] - piece[2] < DETECTION.max_edge_time else piece[2] + edge)
            - piece[1],
        )
        for piece, later in pairwise(joined)
    ]
    runs += [
        (sign, stop + min(edge, DETECTION.max_edge_time) - start)
        for sign, start, stop in joined[-1:]
    ]
    ends = (joined[0][1], joined[-1][2]) if joined else (float("nan"), float("nan"))
    return runs, ends


def _trim_departure_and_return(
    times: FloatArray,
    level: FloatArray,
    edges: tuple[float, float],
    before: float,
    after: float,
    threshold: float,
) -> tuple[float, float]:
    early = np.flatnonzero((times <= edges[0]) & (np.abs(level - before) < threshold))
    late = np.flatnonzero((times >= edges[1]) & (np.abs(level - after) < 1.5 * threshold))
    start = float(times[early[-1]]) if early.size else edges[0]
    end = float(times[late[0]]) if late.size else edges[1]
    return start, end


def classify_input(runs: list[tuple[int, float]]) -> InputKind:
    """Name the shape of an input by its excursions.

    ``pulse`` (one side), ``doublet`` (one side, then the other), ``3-2-1-1`` (four in turn, as
    shares of the whole nearer to 3:2:1:1 than to equal ones), ``sweep`` (seven or more),
    ``multistep`` (all else), ``retrim`` where a side is held for long.
    """
    lengths = [length for _, length in runs]
    if max(lengths) > DETECTION.max_hold_time:
        return "retrim"
    if len(runs) == 1:
        return "pulse"
    in_turn = all(one[0] != other[0] for one, other in pairwise(runs))
    if len(runs) == 2 and in_turn:
        return "doublet" if min(lengths) > 0.25 * max(lengths) else "pulse"
    if len(runs) == 4 and in_turn:
        shares = np.array(lengths) / sum(lengths)
        misses = [
            float(np.linalg.norm(shares - np.array(shape) / sum(shape)))
            for shape in ((3, 2, 1, 1), (1, 1, 1, 1))
        ]
        if misses[0] < misses[1]:
            return "3-2-1-1"
    return "sweep" if len(runs) >= 7 else "multistep"
