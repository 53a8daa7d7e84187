"""`AlertMonitor`: everything that comes before all other cues.

Whose alarm is whose: `gsapp.session.limits` alarms where one value stands beyond one figure, and
`gsapp.session.equipment_monitor` where link or recorder fail. Here is what takes more than one
value, the past, or the next seconds: instruments that contradict each other, the stall in a turn,
the way out of the fence, and what will run out.
"""

from __future__ import annotations

from functools import cache

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.excitation.alerts.active_alerts import ActiveAlerts
from gsapp.excitation.alerts.alert import Alert
from gsapp.excitation.alerts.clipping_monitor import ClippingMonitor
from gsapp.excitation.alerts.endurance_monitor import EnduranceMonitor
from gsapp.excitation.alerts.geofence import Geofence, GeofenceMonitor
from gsapp.excitation.alerts.instrument_monitor import InstrumentMonitor
from gsapp.excitation.alerts.row_frames import FrameSplitter
from gsapp.excitation.alerts.stall_monitor import StallMonitor
from gsapp.excitation.flight_rows import FlightRows


class AlertMonitor:
    """Follows one flight.

    Parameters
    ----------
    aircraft : Aircraft or None
        Without it nothing is known of stall, ranges and how long it may fly; whether it flies is
        then judged by the figures of the usual aircraft.
    rate : float
        Of the rows, Hz.
    fence : Geofence, optional
        The usual one by default; None for none.
    system : {"US", "SI"}
        Units of the words; others may be set at any time.
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
        """Forget everything."""
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
        """Take in the next rows."""
        for frame in self._frames.split(rows):
            self._judge(frame)

    @property
    def active_alerts(self) -> tuple[Alert, ...]:
        """Return what calls for attention now, the most urgent first."""
        return self._standing.alerts

    @property
    def log(self) -> tuple[Alert, ...]:
        """Return each danger as it arose or grew worse, in order of time."""
        return self._standing.log

    @property
    def invalid_channels(self) -> tuple[str, ...]:
        """Return the channels that are not to be believed now."""
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
