"""``gsapp fly --bench``: the virtual aircraft on the ground, over a link."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.telemetry.clock import Clock
    from gsapp.virtual.downlink.commanded_downlinks import CommandConsole
    from gsapp.virtual.downlink.flight_settings import FlightSettings


def run(
    *, to: str, settings: FlightSettings, speed: float = 1.0, control: str | None = None
) -> None:
    """Send the volts of a virtual aircraft on the ground until it is switched off.

    Parameters
    ----------
    to : str
        LINK over which the box sends.
    settings : FlightSettings
        Its seed, faults, radio and aircraft count.
    speed : float
        Times real time.
    control : str or None
        Where lines to obey come from: ``udpin:HOST:PORT``, or ``-`` for what is typed; then the
        end of what is typed switches the box off.

    Raises
    ------
    GroundStationError
        If a link cannot be opened, or a fault is none.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.cli._virtual_flight import flight_status, open_link
    from gsapp.telemetry.clock import HostClock
    from gsapp.telemetry.link_registry import parse_link
    from gsapp.virtual.bench import VirtualBench, parse_bench_fault
    from gsapp.virtual.downlink.commanded_downlinks import BenchDownlink
    from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter

    console = PlainConsole(stderr=True)
    clock = HostClock()
    with as_usage_error():
        broken = [parse_bench_fault(fault) for fault in settings.faults]
        if control not in (None, "-"):
            parse_link(control)
    thin = settings.thin
    bench = VirtualBench(settings.seed, faults=broken, aircraft=settings.aircraft)
    with open_link(to, clock, speed) as line, _open_control(control, clock, console) as heard:
        downlink = BenchDownlink(bench, heard, thin=thin, unix_us=clock.now_us())
        transmitter = DownlinkTransmitter(downlink, line, clock=clock, speed=speed, thin=thin)
        with flight_status(console, f"On the ground, over {to}") as show:
            transmitter.transmit(show)


@contextlib.contextmanager
def _open_control(
    control: str | None, clock: Clock, console: Console
) -> Iterator[CommandConsole | None]:
    """Open where lines to obey come from."""
    from gsapp.virtual.downlink.commanded_downlinks import StdinConsole, UdpConsole

    if control is None:
        yield None
        return
    heard: CommandConsole
    if control == "-":
        heard = StdinConsole(sys.stdin, lambda text: console.print(text, highlight=False))
    else:
        heard = UdpConsole(control, clock=clock)
    with contextlib.closing(heard):
        yield heard
