"""The volts of one instrument, live: at rest or moving, and the mean while at rest.

States are judged at ticks of the samples' own clock, so they depend on what was sampled and not on
how the samples were cut into pieces on their way.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gsapp.quantities import FloatArray

WatchState = Literal["absent", "moving", "steady", "noisy", "clipped"]

TICK = 0.05
"""How often the state is judged, s."""

SEGMENTS = 5
"""Parts of the window whose means are compared."""

STILL_COUNTS = 4.0
"""Counts of the converter by which the means of the parts may differ at rest."""

NOISY_COUNTS = 10.0
"""Standard deviation of single samples, in counts, from which an instrument is noisy."""

CLIPPED_SHARE = 0.2
"""Share of the window at an end of the converter from which an instrument is clipped."""

FEWEST = 5
"""Samples that a judgment needs; the window grows up to `STRETCH` times where they come slowly."""

STRETCH = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class WatchReading:
    """What is known of an instrument's volts at this moment.

    Attributes
    ----------
    state : {"absent", "moving", "steady", "noisy", "clipped"}
        ``absent``: no samples. ``clipped``: at an end of the converter. ``noisy``: at rest, but
        single samples scatter so much that the contact must be bad.
    volts : float
        Mean over the window, V; NaN where absent.
    std : float
        Of single samples about their mean, V.
    uncertainty : float
        Standard deviation of the mean, V; samples that resemble their neighbors count for less.
    steady_for : float
        Seconds since the instrument came to rest; 0 while it is not at rest, and after `restart`
        until it has been seen to move.
    moved : bool
        Whether it was seen to move since the beginning or the last `restart`. A point is taken by
        itself only where this is so.
    excitation : float or None
        Mean supply over the same window, V.
    time : float
        Of the last sample, s; NaN before the first.
    """

    state: WatchState
    volts: float = float("nan")
    std: float = float("nan")
    uncertainty: float = float("nan")
    steady_for: float = 0.0
    moved: bool = False
    excitation: float | None = None
    time: float = float("nan")


class VoltsWatch:
    """Watch one instrument's volts.

    Parameters
    ----------
    window : float
        Seconds at rest that a reading is averaged over.
    full_scale : float
        Of the converter, V.
    bits : int
        Of the converter.
    """

    def __init__(self, *, window: float = 0.7, full_scale: float = 5.0, bits: int = 12) -> None:
        self._window = window
        self._step = full_scale / 2**bits
        self._full_scale = full_scale
        self._samples: deque[tuple[float, float, float]] = deque()
        self._tick = 0
        self._rest_began: float | None = None
        self._reference = float("nan")
        self._moved = False
        self._reading = WatchReading(state="absent")

    @property
    def reading(self) -> WatchReading:
        """Return what is known at the last sample fed."""
        return self._reading

    def restart(self) -> None:
        """Take the present place as left: `moved` is false until the instrument has moved away.

        To be called when a point was taken, so that the same rest is not taken twice.
        """
        self._moved = False
        self._rest_began = None
        self._reference = self._reading.volts

    def feed(
        self, times: FloatArray, volts: FloatArray, excitation: FloatArray | None = None
    ) -> None:
        """Take samples.

        Parameters
        ----------
        times : ndarray, shape (n,)
            s, ascending; NaN in `volts` is a missing sample.
        volts : ndarray, shape (n,)
            V.
        excitation : ndarray, shape (n,), optional
            Supply, V.
        """
        supply = np.full(times.size, np.nan) if excitation is None else excitation
        for time, value, source in zip(
            times.tolist(), volts.tolist(), supply.tolist(), strict=True
        ):
            tick = int(time // TICK)
            if tick != self._tick:
                self._tick = tick
                self._judge(time)
            if value == value:
                self._samples.append((time, value, source))

    def _judge(self, time: float) -> None:
        """Judge the samples before `time`."""
        samples = self._samples
        while samples and samples[0][0] < time - STRETCH * self._window:
            samples.popleft()
        inside = [sample for sample in samples if sample[0] >= time - self._window]
        if len(inside) < FEWEST:
            inside = list(samples)[-FEWEST:]
        if len(inside) < FEWEST:
            self._rest_began = None
            self._reading = WatchReading(state="absent", moved=self._moved, time=time)
            return
        rows = np.array(inside)
        at, volts, supply = rows.T
        state, std = self._state(volts)
        mean = float(volts.mean())
        if state == "moving" or abs(mean - self._reference) > 2.0 * STILL_COUNTS * self._step:
            self._moved = True
        if state not in {"steady", "noisy"}:
            self._rest_began = None
        elif self._rest_began is None and self._moved:
            self._rest_began = float(at[0])
        known = supply[np.isfinite(supply)]
        self._reading = WatchReading(
            state=state,
            volts=mean,
            std=std,
            uncertainty=mean_uncertainty(volts, self._step),
            steady_for=0.0 if self._rest_began is None else time - self._rest_began,
            moved=self._moved,
            excitation=float(known.mean()) if known.size else None,
            time=time,
        )

    def _state(self, volts: FloatArray) -> tuple[WatchState, float]:
        """Return the state of a window, and the standard deviation of its samples."""
        std = float(volts.std(ddof=1))
        low, high = 1.5 * self._step, self._full_scale - 2.5 * self._step
        if np.mean((volts <= low) | (volts >= high)) >= CLIPPED_SHARE:
            return "clipped", std
        # Noise from one sample to the next: a movement does not count into it.
        noise = float(np.median(np.abs(np.diff(volts)))) / (0.6745 * np.sqrt(2.0))
        noise = max(noise, self._step / np.sqrt(12.0))
        parts = np.array_split(volts, min(SEGMENTS, volts.size // 2))
        means = np.array([part.mean() for part in parts])
        allowed = max(
            STILL_COUNTS * self._step, 5.0 * noise / np.sqrt(min(part.size for part in parts))
        )
        if float(np.ptp(means)) > allowed:
            return "moving", std
        return ("noisy" if std > NOISY_COUNTS * self._step else "steady"), std


def mean_uncertainty(volts: FloatArray, step: float) -> float:
    """Return the standard deviation of the mean of samples that resemble their neighbors.

    Parameters
    ----------
    volts : ndarray, shape (n,)
        V.
    step : float
        Of the converter, V: where all samples fall on one count, the mean is no better than it.

    Returns
    -------
    float
        V.
    """
    n = volts.size
    deviation = volts - volts.mean()
    variance = float(np.mean(deviation**2))
    if variance < (0.25 * step) ** 2:
        return step / float(np.sqrt(12.0))
    # Correlations add up in pairs for as long as a pair is positive.
    correlation = np.correlate(deviation, deviation, "full")[n - 1 :] / (n * variance)
    total = 1.0
    for lag in range(1, n - 1, 2):
        pair = float(correlation[lag] + correlation[lag + 1])
        if pair <= 0.0:
            break
        total += 2.0 * pair
    effective = min(max(n / total, 1.0), float(n))
    return float(np.sqrt(variance / effective + (0.1 * step) ** 2))
