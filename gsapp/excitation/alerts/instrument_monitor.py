"""Instruments that die or lie in flight, and what that means for the flight.

Three judges, each sure of itself: signs of life (`signs`), votes of what measures one rate
(`gyros`), and the motion that rates and accelerations make (`kinematic`). Plausibility of single
values is the affair of `gsapp.session.limits`.
"""

from __future__ import annotations

from typing import Final

from gsapp.aircraft import Aircraft
from gsapp.excitation.alerts.active_alerts import AlertCondition
from gsapp.excitation.alerts.alert import AlertLevel
from gsapp.excitation.alerts.alert_text import INSTRUMENT_TITLES
from gsapp.excitation.alerts.flight_phase import FlightPhaseMonitor
from gsapp.excitation.alerts.gyro_monitor import GyroMonitor
from gsapp.excitation.alerts.kinematic_monitor import KinematicMonitor
from gsapp.excitation.alerts.row_frames import FlightFrame
from gsapp.excitation.alerts.sensor_activity_monitor import SensorActivityMonitor
from gsapp.excitation.flight_rows import FlightRows

NOSE_SENSORS: Final = ("alpha", "beta", "V")
_DERIVED: Final = ("V", "Vc", "qbar", "dynamic_pressure")
"""Channels that fall with the airspeed."""
_SETTLED: Final = 1.0
"""Seconds in the air from which on instruments are spoken of."""
_TOLD_AFTER: Final = 2
"""Frames for which a doubt must last to be told; nothing is believed meanwhile."""

_MEANING: Final = {
    "alpha": "no test point by alpha, and no lift or pitching moment from this flight",
    "beta": "no side force, rolling or yawing moment from this flight",
    "V": "keep the speed up by eye",
    "p": "no aileron inputs",
    "q": "no elevator inputs",
    "r": "no rudder inputs",
}


class InstrumentMonitor:
    """Judges the instruments, and with those believed the phase of the flight.

    Parameters
    ----------
    aircraft : Aircraft or None
        Knows ranges, noise, and where the instruments sit.
    usual : Aircraft
        Tells how fast it must be to fly; the same unless that is None.
    rate : float
        Hz.
    """

    def __init__(self, aircraft: Aircraft | None, usual: Aircraft, rate: float) -> None:
        self._signs = SensorActivityMonitor(aircraft)
        self._gyros = GyroMonitor()
        self._motion = KinematicMonitor(aircraft, rate)
        self._phase = FlightPhaseMonitor(usual)
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        for part in (self._signs, self._gyros, self._motion, self._phase):
            part.restart()
        self._since: dict[str, int] = {}

    def evaluate(
        self, rows: FlightRows
    ) -> tuple[FlightFrame, frozenset[str], list[AlertCondition]]:
        """Return the frame with the state of the flight, what is not believed, and what to tell."""
        doubts = self._signs.evaluate(rows)
        for name, why in self._gyros.evaluate(rows).items():
            doubts.setdefault(name, why)
        frame = self._phase.evaluate(rows, frozenset(doubts))
        for name, why in self._motion.evaluate(frame, frozenset(doubts)).items():
            doubts.setdefault(name, why)
        self._since = {name: self._since.get(name, 0) + 1 for name in doubts}
        told = {name: why for name, why in doubts.items() if self._since[name] >= _TOLD_AFTER}
        findings = _instrument_conditions(told) if frame.time_since_takeoff >= _SETTLED else []
        return frame, frozenset(doubts), findings


def _instrument_conditions(doubts: dict[str, str]) -> list[AlertCondition]:
    found = []
    if all(name in doubts for name in NOSE_SENSORS):
        found.append(
            AlertCondition(
                key="nose",
                level=AlertLevel.WARNING,
                text="Nose sensors lost: alpha, beta and airspeed; land",
                spoken_text="nose sensors lost: land",
                channels=("alpha", "beta", *_DERIVED),
            )
        )
        doubts = {name: why for name, why in doubts.items() if name not in NOSE_SENSORS}
    for name, why in doubts.items():
        base = name.partition(".")[0]
        second = name != base
        title = INSTRUMENT_TITLES[base] + (f" {name.partition('.')[2]}" if second else "")
        meaning = "the first is used" if second else _MEANING[base]
        found.append(
            AlertCondition(
                key={"alpha": "alpha", "beta": "beta", "V": "airspeed"}.get(name, f"gyro.{name}"),
                level=AlertLevel.CAUTION,
                text=f"The {title} {why}: {meaning}",
                spoken_text=f"{title} lost",
                channels=_DERIVED if name == "V" else (name,),
            )
        )
    return found
