"""Settings of a virtual flight: options of ``gsapp fly``, form, and what its process is given."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import field_validator

from gsapp.foundation.settings import Names, SettingsModel, setting
from gsapp.foundation.translation import QT_TR_NOOP

if TYPE_CHECKING:
    # The window starts without the numerics behind a flight.
    from gsapp.virtual.dirt import Dirt
    from gsapp.virtual.downlink.flight_downlink import FlightDownlink
    from gsapp.virtual.downlink.onboard_log import LogServer, OnboardLog
    from gsapp.virtual.virtual_flight import FlightSimulation, StickSourceFactory


class FlightSettings(SettingsModel):
    """Settings of one virtual flight, all by name or as plain numbers."""

    # fmt: off
    plan: str = setting(
        "default", QT_TR_NOOP("Plan"),
        QT_TR_NOOP("Plan: a file, or the name of a shipped one."),
        option="--plan", metavar="FILE")
    cards: str = setting(
        "", QT_TR_NOOP("Test cards"),
        QT_TR_NOOP("Fly these test cards in place of the plan's maneuvers: a file, or the name of "
                   "a shipped set."),
        option="--cards", metavar="FILE")
    aircraft: str = setting(
        "b777", QT_TR_NOOP("Aircraft"),
        QT_TR_NOOP("Aircraft: a file, or the name of a shipped one."),
        option="--aircraft", metavar="FILE")
    model: str = setting(
        "b777", QT_TR_NOOP("Model"),
        QT_TR_NOOP("Model: a file, or the name of a shipped one."),
        option="--model", metavar="FILE")
    certificates: str = setting(
        "b777", QT_TR_NOOP("Certificates"),
        QT_TR_NOOP("A folder, or the name of a shipped set."))
    hide: Names = setting(
        (), QT_TR_NOOP("Hidden effects"),
        QT_TR_NOOP("Add a hidden effect. Hidden effects make the aircraft differ from its model."),
        option="--hide", metavar="ID[:PARAM=VALUE,..]", is_repeatable=True)
    faults: Names = setting(
        (), QT_TR_NOOP("Instrument faults"),
        QT_TR_NOOP("Instrument fault: dropout, stuck or clip; on the bench dead, reversed, "
                   "swapped:with=CHANNEL, noisy or clipped."),
        option="--fault", metavar="CHANNEL:KIND[:PARAM=VALUE,..]", is_repeatable=True)
    dirt: Names = setting(
        (), QT_TR_NOOP("Dirt"),
        QT_TR_NOOP("What real records suffer from, drawn by the seed: all, or some of the kinds. "
                   "Instruments elsewhere than the aircraft file says, lags, a flexible structure, "
                   "coarse converters, bursts, missing stamps, gusts and more."),
        option="--dirt", metavar="all|KIND,..")
    seed: int = setting(
        0, QT_TR_NOOP("Seed"),
        QT_TR_NOOP("The same seed gives the same gusts, noise and pilot."),
        option="--seed", metavar="N", ge=0)
    turbulence: float | None = setting(
        None, QT_TR_NOOP("Turbulence"),
        QT_TR_NOOP("Standard deviation of the gusts."),
        option="--turbulence", metavar="M/S", unit="m/s", default_text="that of the plan", ge=0.0)
    thin: bool = setting(
        False, QT_TR_NOOP("Radio"),
        QT_TR_NOOP("Limit the data to a 57,600-baud radio."),
        option="--thin")
    attitude: bool = setting(
        True, QT_TR_NOOP("Attitude"),
        QT_TR_NOOP("Send attitude."),
        option="--attitude/--no-attitude")
    position: bool = setting(
        False, QT_TR_NOOP("Position"),
        QT_TR_NOOP("Send position."),
        option="--position/--no-position")
    airborne: bool = setting(
        False, QT_TR_NOOP("Airborne"),
        QT_TR_NOOP("With --sticks, begin in the air, in the pattern."),
        option="--airborne")
    # fmt: on

    @field_validator("dirt")
    @classmethod
    def _check_dirt(cls, kinds: tuple[str, ...]) -> tuple[str, ...]:
        if kinds:
            from gsapp.virtual.dirt import parse_dirt_kinds

            parse_dirt_kinds(kinds)
        return kinds

    def check(self) -> None:
        """Raise the error that `create_flight` would, quickly.

        Raise GroundStationError if a file is missing or holds mistakes, or an effect is unknown.
        """
        self.create_flight()

    def draw_dirt(self) -> Dirt:
        """Return the dirt of this flight, as `create_flight` draws it."""
        from gsapp.aircraft import load_aircraft
        from gsapp.virtual.dirt import draw_dirt

        return draw_dirt(self.dirt, self.seed, load_aircraft(self.aircraft))

    def create_flight(self, hands: StickSourceFactory | None = None) -> FlightSimulation:
        """Return the flight, about to begin, flown by the human pilot or by other hands."""
        from gsapp.aircraft import load_aircraft
        from gsapp.flight.cards import load_cards
        from gsapp.virtual.flight_plan import load_flight_plan, with_cards
        from gsapp.virtual.virtual_flight import FlightSimulation

        plan, aircraft = load_flight_plan(self.plan), load_aircraft(self.aircraft)
        return FlightSimulation(
            with_cards(plan, load_cards(self.cards), aircraft) if self.cards else plan,
            aircraft=aircraft,
            model=self.model,
            seed=self.seed,
            hide=self.hide,
            faults=self.faults,
            turbulence=self.turbulence,
            dirt=self.dirt,
            certificates=self.certificates,
            hands=hands,
            airborne=self.airborne,
        )

    def create_downlink(
        self, unix_us: int, hands: StickSourceFactory | None = None
    ) -> FlightDownlink:
        """Return the flight as a stream; the box is switched on at that time of day."""
        from gsapp.virtual.downlink.flight_downlink import FlightDownlink

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
        from gsapp.virtual.downlink.onboard_log import LogServer, OnboardLog

        if not self.thin:
            return None, None
        return OnboardLog(path), LogServer(path, started=unix_us // 1_000_000)
