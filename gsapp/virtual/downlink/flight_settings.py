"""What is flown and how the box is set: everything that another process needs to start."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gsapp.aircraft import load_aircraft
from gsapp.virtual.downlink.flight_downlink import FlightDownlink
from gsapp.virtual.downlink.log_server import LogServer
from gsapp.virtual.downlink.onboard_log import OnboardLog
from gsapp.virtual.flight_plan import load_flight_plan
from gsapp.virtual.virtual_flight import FlightSimulation, StickSourceFactory


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightSettings:
    """Settings of one virtual flight, all by name or as plain numbers.

    Attributes
    ----------
    plan, aircraft, model, certificates : str
        Files, or names of shipped ones.
    hide : tuple of str
        Effects that the aircraft has and the model lacks, each ``ID[:PARAM=VALUE,..]``.
    faults : tuple of str
        What goes wrong with the instruments besides what the plan says, each
        ``CHANNEL:KIND[:PARAM=VALUE,..]``.
    seed : int
        Same seed, same flight.
    turbulence : float or None
        Standard deviation of the gusts, m/s; None leaves it to the plan.
    thin : bool
        For a 57,600-baud radio, with the full record on board.
    attitude, position : bool
        Whether the board knows and sends them.
    airborne : bool
        Begin in the pattern; for whoever knows to fly on from there.
    """

    plan: str = "default"
    aircraft: str = "b777"
    model: str = "b777"
    certificates: str = "b777"
    hide: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    seed: int = 0
    turbulence: float | None = None
    thin: bool = False
    attitude: bool = True
    position: bool = False
    airborne: bool = False

    def check(self) -> None:
        """Raise the error that `create_flight` would, quickly.

        Raises
        ------
        GroundStationError
            If a file is missing or holds mistakes, or an effect is unknown.
        """
        self.create_flight()

    def create_flight(self, hands: StickSourceFactory | None = None) -> FlightSimulation:
        """Return the flight, about to begin, flown by the human pilot or by other hands."""
        return FlightSimulation(
            load_flight_plan(self.plan),
            aircraft=load_aircraft(self.aircraft),
            model=self.model,
            seed=self.seed,
            hide=self.hide,
            faults=self.faults,
            turbulence=self.turbulence,
            certificates=self.certificates,
            hands=hands,
            airborne=self.airborne,
        )

    def create_downlink(
        self, unix_us: int, hands: StickSourceFactory | None = None
    ) -> FlightDownlink:
        """Return the flight as a stream; the box is switched on at that time of day."""
        return FlightDownlink(
            self.create_flight(hands),
            thin=self.thin,
            attitude=self.attitude,
            position=self.position,
            unix_us=unix_us,
        )

    def create_onboard_log(
        self, path: Path, unix_us: int
    ) -> tuple[OnboardLog | None, LogServer | None]:
        """Return the on-board log and what hands it out; none where all goes over the link."""
        if not self.thin:
            return None, None
        return OnboardLog(path), LogServer(path, started=unix_us // 1_000_000)
