"""Stall margin: speed with load factor, and angle of attack.

Limits (`gsapp.session.limits`) alarm at fixed figures of `Vc` and `alpha`, each for itself. They do
not know that a turn stalls earlier, nor which of the two instruments still deserves belief; that is
said here: the least speed grows with the square root of the load factor, and a few tenths of
a second of what comes are added.
"""

from __future__ import annotations

import math

from gsapp.aircraft import Aircraft
from gsapp.excitation.alerts.alert import Alert, AlertLevel, caution, format_amount, warning
from gsapp.excitation.alerts.row_frames import FlightFrame
from gsapp.excitation.settings import ALERTS
from gsapp.quantities.constants import GRAVITY


class StallMonitor:
    """Watches the margin in the air; without stall figures nothing is said."""

    def __init__(self, aircraft: Aircraft | None) -> None:
        self._limits = None if aircraft is None else aircraft.limits
        self._full_flap = 0.0 if aircraft is None else aircraft.controls.flap.travel[1]
        self.restart()

    def restart(self) -> None:
        self._before: float | None = None
        self._slow = {AlertLevel.CAUTION: 0, AlertLevel.WARNING: 0}

    def evaluate(
        self, frame: FlightFrame, distrusted: frozenset[str], system: str = "US"
    ) -> list[Alert]:
        """Return how near the stall is, by what is not distrusted."""
        limits = self._limits
        if limits is None or frame.time_since_takeoff < ALERTS.takeoff_time or frame.near_ground:
            self.restart()
            return []
        speed, least = self._speeds(frame, distrusted, limits.stall_speed)
        nearness = [
            one
            for one in (
                self._by_speed(frame, speed, least, self._calm(frame, distrusted), system),
                # So fast for its load it cannot be near the stall, whatever a vane shows.
                None
                if speed > ALERTS.far_from_stall_ratio * least
                else _evaluate_alpha(frame, distrusted, limits.alpha_linear[1], limits.alpha_stall),
            )
            if one is not None
        ]
        worst = max((each for each, _ in nearness), default=None)
        for urgency, count in self._slow.items():
            beyond = worst is not None and worst >= urgency
            self._slow[urgency] = count + 1 if beyond else 0
        if self._slow[AlertLevel.WARNING] >= ALERTS.stall_frames:
            why = _stall_text(nearness, AlertLevel.WARNING)
            return [warning("stall", f"Stall: {why}; push", "stall: push")]
        if self._slow[AlertLevel.CAUTION] >= ALERTS.stall_frames:
            why = _stall_text(nearness, AlertLevel.CAUTION)
            return [caution("stall", f"Near the stall: {why}; ease the pull", "slow")]
        return []

    def _speeds(
        self, frame: FlightFrame, distrusted: frozenset[str], stall_speed: float
    ) -> tuple[float, float]:
        """Return the airspeed and the least one at this load, m/s; NaN where not believed."""
        speed = frame.mean("Vc")
        speed = frame.mean("V") if math.isnan(speed) else speed
        if "V" in distrusted or stall_speed <= 0.0:
            return math.nan, math.nan
        load = frame.mean("an") / GRAVITY
        load = 1.0 if math.isnan(load) or "an" in distrusted else max(load, ALERTS.min_load_factor)
        flap = frame.mean("flap")
        share = flap / self._full_flap if flap == flap and self._full_flap > 0.0 else 0.0
        flapped = 1.0 - ALERTS.flap_gain * min(max(share, 0.0), 1.0)
        return speed, stall_speed * flapped * math.sqrt(load)

    def _calm(self, frame: FlightFrame, distrusted: frozenset[str]) -> float:
        alpha = frame.mean("alpha")
        linear = 0.0 if self._limits is None else self._limits.alpha_linear[1]
        return ALERTS.alpha_valid_factor if "alpha" not in distrusted and alpha < linear else 1.0

    def _by_speed(
        self, frame: FlightFrame, speed: float, least: float, calm: float, system: str
    ) -> tuple[AlertLevel, str] | None:
        before, self._before = self._before, speed
        if math.isnan(speed):
            return None
        slope = (
            0.0
            if before is None or math.isnan(before)
            else (speed - before) / ALERTS.frame_duration
        )
        coming = speed + ALERTS.prediction_time * min(slope, 0.0)
        if min(speed, coming) >= ALERTS.caution_ratio * calm * least:
            return None
        urgency = (
            AlertLevel.WARNING
            if speed < ALERTS.warning_ratio * calm * least
            else AlertLevel.CAUTION
        )
        side = "above" if speed > least else "below"
        text = f"{format_amount('V', abs(speed - least), system)} {side}"
        return urgency, f"{text} the stall speed at {frame.mean('an') / GRAVITY:.1f} g"


def _evaluate_alpha(
    frame: FlightFrame, distrusted: frozenset[str], linear: float, stall: float
) -> tuple[AlertLevel, str] | None:
    alpha = frame.mean("alpha")
    if "alpha" in distrusted or math.isnan(alpha):
        return None
    if alpha < linear + ALERTS.caution_alpha_share * (stall - linear):
        return None
    urgency = AlertLevel.WARNING if alpha >= stall else AlertLevel.CAUTION
    return urgency, f"alpha {math.degrees(alpha):.0f} deg, stall at {math.degrees(stall):.0f}"


def _stall_text(nearness: list[tuple[AlertLevel, str]], least: AlertLevel) -> str:
    return " and ".join(words for urgency, words in nearness if urgency >= least)
