"""Whether it flies, for how long, and how high: told from what is still believed."""

from __future__ import annotations

from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.alerts.row_frames import ALERT_FRAME_DURATION, FlightFrame
from gsapp.excitation.flight_rows import FlightRows
from gsapp.flight.maneuvers.airborne_detection import FRAME_DURATION as AIRBORNE_FRAME
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS
from gsapp.quantities import FloatArray

_STANDING: Final = 40
"""Frames of standing whose median altitude is that of the field."""
_NEAR_GROUND: Final = 8.0
"""Height above the field, m, below which an aircraft may be slow because it lands."""
_ALTITUDE_FRAMES: Final = 4
"""Barometers are noisy: the median of so many frames counts."""
_PER_JUDGMENT: Final = round(AIRBORNE_FRAME / ALERT_FRAME_DURATION)


class FlightPhaseMonitor:
    """Follows one flight.

    Parameters
    ----------
    aircraft : Aircraft
        Tells how fast it must be to fly.
    """

    def __init__(self, aircraft: Aircraft) -> None:
        self._aircraft = aircraft
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._watch = AirborneDetector(self._aircraft)
        self._means: list[FloatArray] = []
        self._altitudes: list[float] = []
        self._standing: list[float] = []
        self._field = np.nan
        self._flown = 0.0

    def evaluate(self, rows: FlightRows, distrusted: frozenset[str]) -> FlightFrame:
        """Return a frame with the state of the flight.

        Parameters
        ----------
        distrusted : frozenset of str
            Channels that are not believed: an airspeed that fell to nothing is no landing.
        """
        means = _means(rows.values[:, : len(SIGNALS)])
        for name in distrusted & SIGNAL_COLUMNS.keys():
            means[SIGNAL_COLUMNS[name]] = np.nan
        self._means.append(means)
        if len(self._means) == _PER_JUDGMENT:
            began = float(rows.times[0]) - (_PER_JUDGMENT - 1) * ALERT_FRAME_DURATION
            self._watch.add(began, _means(np.array(self._means)))
            self._means = []
        airborne = self._watch.airborne
        if airborne:
            self._flown += ALERT_FRAME_DURATION
        height = self._height(rows, float(means[SIGNAL_COLUMNS["altitude"]]), airborne=airborne)
        return FlightFrame(
            rows=rows,
            time_since_takeoff=float(rows.times[-1]) - self._watch.since if airborne else -1.0,
            time_airborne=self._flown,
            height=height,
            near_ground=height < _NEAR_GROUND,
        )

    def _height(self, rows: FlightRows, altitude: float, *, airborne: bool) -> float:
        """Return the height above the field, m; NaN before it has stood anywhere."""
        measured = rows["height"]
        known = measured[np.isfinite(measured)]
        if known.size:
            return float(known.mean())
        if not airborne and altitude == altitude:
            self._standing = [*self._standing[1 - _STANDING :], altitude]
            self._field = float(np.median(self._standing))
        self._altitudes = [*self._altitudes[1 - _ALTITUDE_FRAMES :], altitude]
        return float(np.median(self._altitudes)) - self._field


def _means(values: FloatArray) -> FloatArray:
    """Return the mean of each column, NaN where it has no sample."""
    known = values == values
    counts = known.sum(axis=0)
    sums = np.where(known, values, 0.0).sum(axis=0)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
