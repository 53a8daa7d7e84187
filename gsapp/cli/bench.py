"""``gsapp fly --bench``: the virtual aircraft on the ground, over a link."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.telemetry.clock import Clock
    from gsapp.telemetry.virtual.bench import Control


def run(
    *,
    to: str,
    seed: int = 0,
    faults: tuple[str, ...] = (),
    speed: float = 1.0,
    thin: bool = False,
    aircraft: str = "b777",
    control: str | None = None,
) -> None:
    """Send the volts of a virtual aircraft on the ground until it is switched off.

    Parameters
    ----------
    to : str
        LINK over which the box sends.
    seed : int
        Same seed, same aircraft.
    faults : tuple of str
        What is wrong with it, ``CHANNEL:KIND``.
    speed : float
        Times real time.
    thin : bool
        For a 57,600-baud radio.
    aircraft : str
        File, or name of a shipped one.
    control : str or None
        Where lines to obey come from: ``udpin:HOST:PORT``, or ``-`` for what is typed; then the
        end of what is typed switches the box off.

    Raises
    ------
    GroundStationError
        If a link cannot be opened, or a fault is none.
    """
    from gsapp.cli._calls import wrong_call
    from gsapp.cli._screen import Screen
    from gsapp.cli.fly import open_line, shown
    from gsapp.dynamics.pilot.bench import VirtualBench, parse_bench_fault
    from gsapp.telemetry.address import parse_link
    from gsapp.telemetry.clock import HostClock
    from gsapp.telemetry.virtual.bench import BenchDownlink
    from gsapp.telemetry.virtual.transmit import Transmitter

    console = Screen(stderr=True)
    clock = HostClock()
    with wrong_call():
        broken = [parse_bench_fault(fault) for fault in faults]
        if control not in (None, "-"):
            parse_link(control)
    bench = VirtualBench(seed, faults=broken, aircraft=aircraft)
    with open_line(to, clock, speed) as line, _listening(control, clock, console) as heard:
        downlink = BenchDownlink(bench, heard, thin=thin, unix_us=clock.now_us())
        transmitter = Transmitter(downlink, line, clock=clock, speed=speed, thin=thin)
        with shown(console, f"On the ground, over {to}") as show:
            transmitter.fly(show)


@contextlib.contextmanager
def _listening(control: str | None, clock: Clock, console: Console) -> Iterator[Control | None]:
    """Open where lines to obey come from."""
    from gsapp.telemetry.virtual.bench import LinkControl, TypedControl

    if control is None:
        yield None
        return
    heard: Control
    if control == "-":
        heard = TypedControl(sys.stdin, lambda text: console.print(text, highlight=False))
    else:
        heard = LinkControl(control, clock=clock)
    with contextlib.closing(heard):
        yield heard
