"""``gsapp fly --sticks``: the virtual aircraft, its sticks moved by lines from outside."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.virtual.downlink.downlink_transmitter import TransmitProgress
    from gsapp.virtual.downlink.flight_settings import FlightSettings
    from gsapp.virtual.flight_plan import FlightPlan
    from gsapp.virtual.human_pilot import AircraftHandling
    from gsapp.virtual.keyboard_pilot import KeyboardPilot


def fly_with_sticks(
    settings: FlightSettings,
    to: str,
    *,
    speed: float,
    truth: Path | None,
    console: Console,
) -> TransmitProgress | None:
    """Fly over a link as the lines of the standard input say, until they end.

    Parameters
    ----------
    settings : FlightSettings
    to : str
        LINK over which the box sends.
    speed : float
        Times real time.
    truth : Path or None
        Where the true motion goes, as a Flight CSV.
    console : Console
        For the answers.

    Returns
    -------
    Progress or None
        How far it came.

    Raises
    ------
    GroundStationError
        If the link cannot be opened, or the aircraft cannot be flown.
    """
    from gsapp.cli._virtual_flight import flight_status, open_link, print_crash, write_truth
    from gsapp.telemetry.clock import HostClock
    from gsapp.virtual.downlink.commanded_downlinks import StdinConsole, TrainingDownlink
    from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter
    from gsapp.virtual.keyboard_pilot import KeyboardPilot

    clock = HostClock()
    pilots: list[KeyboardPilot] = []

    def make(
        plan: FlightPlan, feel: AircraftHandling, random: np.random.Generator, dt: float
    ) -> KeyboardPilot:
        pilots.append(KeyboardPilot(plan, feel, random, dt, airborne=settings.airborne))
        return pilots[-1]

    downlink = settings.create_downlink(clock.now_us(), make)
    control = StdinConsole(
        sys.stdin,
        lambda text: console.print(text, highlight=False, soft_wrap=True),
    )
    with open_link(to, clock, speed) as line, contextlib.closing(control):
        stream = TrainingDownlink(downlink, pilots[0], control)
        transmitter = DownlinkTransmitter(
            stream, line, clock=clock, speed=speed, thin=settings.thin
        )
        try:
            with flight_status(console, f"Flying with keys over {to}") as show:
                transmitter.transmit(show)
            print_crash(downlink, console)
        finally:
            if truth is not None:
                write_truth(truth, downlink.truth())
    return show.progress
