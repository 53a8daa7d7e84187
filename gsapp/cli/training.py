"""``gsapp fly --sticks``: the virtual aircraft, its sticks moved by lines from outside."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.dynamics.pilot.control import Feel
    from gsapp.dynamics.pilot.keyed import KeyedPilot
    from gsapp.dynamics.pilot.plan import FlightPlan
    from gsapp.telemetry.virtual.settings import FlightSettings
    from gsapp.telemetry.virtual.transmit import Progress


def send(
    settings: FlightSettings,
    to: str,
    *,
    speed: float,
    truth: Path | None,
    console: Console,
) -> Progress | None:
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
    from gsapp.cli.fly import open_line, shown, tell_of_crash, write_truth
    from gsapp.dynamics.pilot.keyed import KeyedPilot
    from gsapp.telemetry.clock import HostClock
    from gsapp.telemetry.virtual.bench import TypedControl
    from gsapp.telemetry.virtual.training import TrainingDownlink
    from gsapp.telemetry.virtual.transmit import Transmitter

    clock = HostClock()
    pilots: list[KeyedPilot] = []

    def make(plan: FlightPlan, feel: Feel, random: np.random.Generator, dt: float) -> KeyedPilot:
        pilots.append(KeyedPilot(plan, feel, random, dt, airborne=settings.airborne))
        return pilots[-1]

    downlink = settings.downlink(clock.now_us(), make)
    control = TypedControl(
        sys.stdin,
        lambda text: console.print(text, highlight=False, soft_wrap=True),
    )
    with open_line(to, clock, speed) as line, contextlib.closing(control):
        stream = TrainingDownlink(downlink, pilots[0], control)
        transmitter = Transmitter(stream, line, clock=clock, speed=speed, thin=settings.thin)
        try:
            with shown(console, f"Flying with keys over {to}") as show:
                transmitter.fly(show)
            tell_of_crash(downlink, console)
        finally:
            if truth is not None:
                write_truth(truth, downlink.truth())
    return show.reached
