"""The volts of one instrument, live: at rest or moving, and the mean while at rest.

States are judged at ticks of the samples' own clock, so they depend on what was sampled and not on
how the samples were cut into pieces on their way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from calibration.adc import ADC_RESOLUTION, is_clipped
from calibration.settings import CALIBRATION
from gsapp.quantities import FloatArray

VoltageState = Literal["absent", "moving", "steady", "noisy", "clipped"]


@dataclass(frozen=True, slots=True, kw_only=True)
class VoltageReading:
    """What is known of an instrument's volts at this moment."""

    state: VoltageState
    """``absent``: no samples. ``clipped``: at an end of the converter. ``noisy``: at rest, but
    single samples scatter so much that the contact must be bad."""
    volts: float = float("nan")
    """Mean over the window, V; NaN where absent."""
    std: float = float("nan")
    """Of single samples about their mean, V."""
    uncertainty: float = float("nan")
    """Standard deviation of the mean, V; samples that resemble their neighbors count for less.
    While the instrument moves, that of single samples."""
    steady_for: float = 0.0
    """Seconds since the instrument came to rest; 0 while it is not at rest, and after `restart`
    until it has been seen to move."""
    moved: bool = False
    """Whether it was seen to move since the beginning or the last `restart`. A point is taken by
    itself only where this is so."""
    excitation: float | None = None
    """Mean supply over the same window, V."""
    time: float = float("nan")
    """When that was judged, s; NaN before the first time."""


class VoltageMonitor:
    """Watch one instrument's volts.

    Parameters
    ----------
    shortest : float, optional
        Seconds that tell rest from movement, where they are fewer than those averaged over. The
        mean then grows with the rest, from `shortest` up to `CALIBRATION.averaging`, and leaves out
        how the rest began. By default it is judged over all that is averaged.
    """

    def __init__(self, *, shortest: float | None = None) -> None:
        self._shortest = CALIBRATION.averaging if shortest is None else shortest
        self._rows = np.empty((3, 0))
        self._last = -np.inf
        self._rest_began: float | None = None
        self._left = float("nan")
        self._moved = False
        self._reading = VoltageReading(state="absent")

    @property
    def reading(self) -> VoltageReading:
        return self._reading

    def restart(self) -> None:
        """Take the present place as left: `moved` is false until the instrument has moved away.

        To be called when a point was taken, so that the same rest is not taken twice.
        """
        self._moved = False
        self._rest_began = None
        self._left = self._reading.volts
        self._reading = replace(self._reading, moved=False, steady_for=0.0)

    def feed(
        self, times: FloatArray, volts: FloatArray, excitation: FloatArray | None = None
    ) -> None:
        """Take samples.

        Parameters
        ----------
        times : ndarray, shape (n,)
            s, ascending; where they begin before the last ones the clock began anew, and all that
            was before is forgotten.
        volts : ndarray, shape (n,)
            V; NaN is a missing sample.
        excitation : ndarray, shape (n,), optional
            Supply, V.
        """
        if not times.size:
            return
        if times[0] < self._last:
            self._rows = self._rows[:, :0]
            self._rest_began = None
        supply = np.full(times.size, np.nan) if excitation is None else excitation
        rows = np.hstack([self._rows, np.array([times, volts, supply], dtype=np.float64)])
        ticks = np.floor(np.concatenate([[self._last], times]) / CALIBRATION.evaluation_period)
        for now in times[np.flatnonzero(np.diff(ticks) != 0.0)].tolist():
            self._judge(rows[:, : np.searchsorted(rows[0], now)], now)
        self._last = float(times[-1])
        oldest = np.searchsorted(
            rows[0],
            self._last
            - CALIBRATION.max_window_factor * CALIBRATION.averaging
            - CALIBRATION.evaluation_period,
        )
        self._rows = rows[:, oldest:]

    def _judge(self, rows: FloatArray, now: float) -> None:
        """Judge the samples (times, volts, supply) before `now`."""
        rows = rows[
            :,
            np.searchsorted(rows[0], now - CALIBRATION.max_window_factor * CALIBRATION.averaging) :,
        ]
        rows = rows[:, np.isfinite(rows[1])]
        gaps = np.flatnonzero(np.diff(rows[0], append=now) > CALIBRATION.max_gap)
        if gaps.size:
            # What was before may have been anywhere since.
            forgotten = rows[0, gaps[-1]]
            rows = rows[:, gaps[-1] + 1 :]
            if self._rest_began is not None and self._rest_began <= forgotten:
                self._rest_began = None
        if rows.shape[1] < CALIBRATION.min_window_samples:
            self._rest_began = None
            self._reading = VoltageReading(state="absent", moved=self._moved, time=now)
            return
        at, volts, supply = _latest(rows, now - self._shortest)
        mean, std = _mean_and_std(volts)
        state = self._state(volts, std)
        if (
            state == "moving"
            or abs(mean - self._left) > 2.0 * CALIBRATION.still_counts * ADC_RESOLUTION
        ):
            self._moved = True
        rested = state in {"steady", "noisy"}
        if not rested:
            self._rest_began = None
        elif self._rest_began is None and self._moved:
            self._rest_began = float(at[0])
        steady_for = 0.0 if self._rest_began is None else now - self._rest_began
        length = min(steady_for - self._shortest, CALIBRATION.averaging)
        if rested and length > self._shortest:
            _, volts, supply = _latest(rows, now - length)
            mean, std = _mean_and_std(volts)
        known = supply[np.isfinite(supply)]
        self._reading = VoltageReading(
            state=state,
            volts=mean,
            std=std,
            uncertainty=mean_uncertainty(volts - mean, ADC_RESOLUTION) if rested else std,
            steady_for=steady_for,
            moved=self._moved,
            excitation=float(known.sum()) / known.size if known.size else None,
            time=now,
        )

    def _state(self, volts: FloatArray, std: float) -> VoltageState:
        """Return the state of a window whose samples have a standard deviation."""
        if np.count_nonzero(is_clipped(volts)) >= CALIBRATION.clipped_share * volts.size:
            return "clipped"
        # Noise by second differences: a steady movement does not count into it.
        bends = np.sort(np.abs(volts[2:] - 2.0 * volts[1:-1] + volts[:-2]))
        noise = float(bends[bends.size // 2]) / (0.6745 * np.sqrt(6.0))
        noise = max(noise, ADC_RESOLUTION / np.sqrt(12.0))
        # Medians, so that a contact lost for a sample is noise and not a movement.
        parts = min(CALIBRATION.window_segments, volts.size // 2)
        length = volts.size // parts
        medians = np.sort(volts[-parts * length :].reshape(parts, length))[:, length // 2]
        allowed = max(CALIBRATION.still_counts * ADC_RESOLUTION, 6.0 * noise / np.sqrt(length))
        if float(medians.max() - medians.min()) > allowed:
            return "moving"
        return "noisy" if std > CALIBRATION.noisy_counts * ADC_RESOLUTION else "steady"


def _latest(rows: FloatArray, since: float) -> FloatArray:
    count = rows.shape[1] - int(np.searchsorted(rows[0], since))
    return rows[:, -max(count, CALIBRATION.min_window_samples) :]


def _mean_and_std(volts: FloatArray) -> tuple[float, float]:
    mean = float(volts.sum()) / volts.size
    deviation = volts - mean
    return mean, float(np.sqrt(deviation @ deviation / (volts.size - 1)))


def mean_uncertainty(deviation: FloatArray, step: float) -> float:
    """Return the standard deviation of the mean of samples that resemble their neighbors.

    Parameters
    ----------
    deviation : ndarray, shape (n,)
        Of the samples from their mean, V.
    step : float
        Of the converter, V: where all samples fall on one count, the mean is no better than it.

    Returns
    -------
    float
        V.
    """
    n = deviation.size
    variance = float(deviation @ deviation) / n
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
    # The mean itself takes one of the independent samples.
    effective = max(min(n / total, float(n)) - 1.0, 0.5)
    return float(np.sqrt(variance / effective + (0.1 * step) ** 2))
