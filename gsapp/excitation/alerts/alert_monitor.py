"""`AlertMonitor`: everything that comes before all other cues.

Whose alarm is whose: `gsapp.session.limits` alarms where one value stands beyond one figure, and
`gsapp.session.equipment_monitor` where link or recorder fail. Here is what takes more than one
value, the past, or the next seconds: instruments that contradict each other, the stall in a turn,
the way out of the fence, and what will run out.
"""

from __future__ import annotations

import math
from functools import cache

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.excitation.alerts.alert import ActiveAlerts, Alert, caution, warning
from gsapp.excitation.alerts.geofence import Geofence, GeofenceMonitor
from gsapp.excitation.alerts.instrument_monitor import InstrumentMonitor
from gsapp.excitation.alerts.row_frames import FlightFrame, FrameSplitter
from gsapp.excitation.alerts.sensor_monitors import ClippingMonitor
from gsapp.excitation.alerts.stall_monitor import StallMonitor
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import ALERTS

# How long the flight can still last: time, fuel, battery.
# What stands below a fixed figure is the affair of `gsapp.session.limits` (battery and receiver in
# ``files/b777.toml``). Here is what they cannot say: that the time agreed on is nearly over, and
# that the battery, at the rate at which it sinks, will not last as long as the flight.


class EnduranceMonitor:
    """Watches what runs out, as far as the limits of the aircraft say when that is."""

    def __init__(self, aircraft: Aircraft | None) -> None:
        self._flight_time = None if aircraft is None else aircraft.limits.flight_time
        self._battery_empty = None if aircraft is None else aircraft.limits.battery_empty
        self.restart()

    def restart(self) -> None:
        self._battery: list[float] = []
        self._fuel_full = math.nan

    def evaluate(self, frame: FlightFrame) -> list[Alert]:
        """Return what runs out."""
        if not frame.airborne:
            return []
        return [*self._time(frame), *self._power(frame), *self._fuel(frame)]

    def _time(self, frame: FlightFrame) -> list[Alert]:
        if self._flight_time is None:
            return []
        left = self._flight_time - frame.time_airborne
        whole = f"the flight time of {self._flight_time / 60.0:.3g} min"
        if left <= 0.0:
            return [warning("time", f"T{whole[1:]} has expired; land", "time expired: land")]
        if left <= ALERTS.reserve_time:
            text = f"{ALERTS.reserve_time:.0f} s are left of {whole}; land"
            return [caution("time", text, "time: land")]
        return []

    def _power(self, frame: FlightFrame) -> list[Alert]:
        battery = frame.mean("battery")
        if self._battery_empty is None or math.isnan(battery):
            return []
        self._battery = [*self._battery[1 - ALERTS.battery_slope_frames :], battery]
        half = len(self._battery) // 2
        if len(self._battery) < ALERTS.battery_slope_frames:
            return []
        early = sum(self._battery[:half]) / half
        late = sum(self._battery[half:]) / (len(self._battery) - half)
        sink = (early - late) / (half * ALERTS.frame_duration)
        if sink < ALERTS.min_battery_slope:
            return []
        left = (late - self._battery_empty) / sink - 0.5 * half * ALERTS.frame_duration
        if left > ALERTS.reserve_time:
            return []
        text = (
            f"The battery drops by {60.0 * sink:.1f} V/min and will be empty within "
            f"{ALERTS.reserve_time:.0f} s; land"
        )
        return [warning("battery", text, "battery: land")]

    def _fuel(self, frame: FlightFrame) -> list[Alert]:
        fuel = frame.mean("fuel")
        if math.isnan(fuel):
            return []
        if not fuel <= self._fuel_full:
            self._fuel_full = fuel
        if self._fuel_full <= 0.0 or fuel > ALERTS.fuel_reserve * self._fuel_full:
            return []
        text = f"{100.0 * fuel / self._fuel_full:.0f} % of the fuel is left; land"
        return [warning("fuel", text, "fuel: land")]


class AlertMonitor:
    """Follows one flight, by default with the usual fence; None for none.

    Without an aircraft nothing is known of stall, ranges and how long it may fly; whether it flies
    is then judged by the figures of the usual aircraft.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        rate: float,
        *,
        fence: Geofence | None = Geofence(),  # noqa: B008  frozen
        system: str = "US",
    ) -> None:
        self.system = system
        usual = _default_aircraft() if aircraft is None else aircraft
        self._frames = FrameSplitter(rate)
        self._instruments = InstrumentMonitor(aircraft, usual, rate)
        self._clips = ClippingMonitor(aircraft, rate)
        self._stall = StallMonitor(aircraft)
        self._fence = None if fence is None else GeofenceMonitor(fence)
        self._endurance = EnduranceMonitor(aircraft)
        self._standing = ActiveAlerts()

    def restart(self) -> None:
        for part in (
            self._frames,
            self._instruments,
            self._clips,
            self._stall,
            self._fence,
            self._endurance,
            self._standing,
        ):
            if part is not None:
                part.restart()

    def process_rows(self, rows: FlightRows) -> None:
        for frame in self._frames.split(rows):
            self._judge(frame)

    @property
    def active_alerts(self) -> tuple[Alert, ...]:
        return self._standing.alerts

    @property
    def log(self) -> tuple[Alert, ...]:
        return self._standing.log

    @property
    def invalid_channels(self) -> tuple[str, ...]:
        return tuple(sorted({name for danger in self.active_alerts for name in danger.channels}))

    def _judge(self, rows: FlightRows) -> None:
        frame, doubted, findings = self._instruments.evaluate(rows)
        doubted |= frozenset(self.invalid_channels)
        findings += self._clips.evaluate(frame, doubted)
        findings += self._stall.evaluate(frame, doubted, self.system)
        if self._fence is not None:
            findings += self._fence.evaluate(frame, self.system)
        findings += self._endurance.evaluate(frame)
        self._standing.update(frame.time, findings)


@cache
def _default_aircraft() -> Aircraft:
    return load_aircraft("b777")
