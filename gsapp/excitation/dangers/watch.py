"""`DangerWatch`: everything that comes before all other cues.

Whose alarm is whose: `gsapp.session.limits` alarms where one value stands beyond one figure, and
`gsapp.session.equipment` where link or recorder fail. Here is what takes more than one value, the
past, or the next seconds: instruments that contradict each other, the stall in a turn, the way out
of the fence, and what will run out.
"""

from __future__ import annotations

from functools import cache

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.excitation.dangers.clips import ClipRoom
from gsapp.excitation.dangers.danger import Danger
from gsapp.excitation.dangers.endurance import EnduranceRoom
from gsapp.excitation.dangers.fence import Fence, FenceRoom
from gsapp.excitation.dangers.frames import Frames
from gsapp.excitation.dangers.instruments import InstrumentRoom
from gsapp.excitation.dangers.stall import StallRoom
from gsapp.excitation.dangers.standing import Standing
from gsapp.excitation.rows import FlightRows


class DangerWatch:
    """Follows one flight.

    Parameters
    ----------
    aircraft : Aircraft or None
        Without it nothing is known of stall, ranges and how long it may fly; whether it flies is
        then judged by the figures of the usual aircraft.
    rate : float
        Of the rows, Hz.
    fence : Fence, optional
        The usual one by default; None for none.
    system : {"US", "SI"}
        Units of the words; others may be set at any time.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        rate: float,
        *,
        fence: Fence | None = Fence(),  # noqa: B008  frozen
        system: str = "US",
    ) -> None:
        self.system = system
        usual = _usual() if aircraft is None else aircraft
        self._frames = Frames(rate)
        self._instruments = InstrumentRoom(aircraft, usual, rate)
        self._clips = ClipRoom(aircraft, rate)
        self._stall = StallRoom(aircraft)
        self._fence = None if fence is None else FenceRoom(fence)
        self._endurance = EnduranceRoom(aircraft)
        self._standing = Standing()

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

    def take(self, rows: FlightRows) -> None:
        """Take in the next rows."""
        for frame in self._frames.cut(rows):
            self._judge(frame)

    @property
    def standing(self) -> tuple[Danger, ...]:
        """Return what calls for attention now, the most urgent first."""
        return self._standing.now

    @property
    def log(self) -> tuple[Danger, ...]:
        """Return each danger as it arose or grew worse, in order of time."""
        return self._standing.log

    @property
    def distrusted(self) -> tuple[str, ...]:
        """Return the channels that are not to be believed now."""
        return tuple(sorted({name for danger in self.standing for name in danger.channels}))

    def _judge(self, rows: FlightRows) -> None:
        frame, doubted, findings = self._instruments.judge(rows)
        doubted |= frozenset(self.distrusted)
        findings += self._clips.judge(frame, doubted)
        findings += self._stall.judge(frame, doubted, self.system)
        if self._fence is not None:
            findings += self._fence.judge(frame, self.system)
        findings += self._endurance.judge(frame)
        self._standing.note(frame.time, findings)


@cache
def _usual() -> Aircraft:
    return load_aircraft("b777")
