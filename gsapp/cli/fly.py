"""``gsapp fly``: the virtual aircraft, over a link, on the bench, or into a flight folder."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from gsapp.cli._commands import takes_settings
from gsapp.cli._options import JsonFile

if TYPE_CHECKING:
    import numpy as np

    from gsapp.cli._console import PlainConsole
    from gsapp.telemetry.clock import Clock
    from gsapp.telemetry.sources import LinkSource
    from gsapp.virtual.downlink.commanded_downlinks import CommandConsole
    from gsapp.virtual.downlink.downlink_transmitter import TransmitLink, TransmitProgress
    from gsapp.virtual.downlink.flight_downlink import FlightDownlink
    from gsapp.virtual.downlink.flight_settings import FlightSettings
    from gsapp.virtual.flight_plan import FlightPlan
    from gsapp.virtual.human_pilot import AircraftHandling
    from gsapp.virtual.keyboard_pilot import KeyboardPilot

_FLIGHT_OPTIONS = (
    "--plan", "--cards", "--hide", "--dirt", "--model", "--turbulence", "--position", "--onboard",
    "--truth", "--sticks", "--airborne", "--json",
)  # fmt: skip
"""What the bench has no use for."""
_PEER_TIMEOUT = 300.0
"""Seconds without a request after which a thin box, landed, stops offering its log."""


@takes_settings("gsapp.virtual.downlink.flight_settings:FlightSettings")
def fly(
    to: Annotated[str | None, typer.Option(metavar="LINK", help="Transmit over this link")] = None,
    out: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FLIGHT", help="Write a flight folder at full speed"),
    ] = None,
    speed: Annotated[float, typer.Option(metavar="X", help="Times real time")] = 1.0,
    onboard: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="FILE",
            help="File for the full on-board record of a thin flight",
        ),
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FILE", help="Write the true motion as a Flight CSV"),
    ] = None,
    bench: Annotated[
        bool,
        typer.Option("--bench", help="Bench mode on the ground, for calibration; see --control"),
    ] = False,
    control: Annotated[
        str | None,
        typer.Option(
            metavar="udpin:HOST:PORT|-",
            help="Bench commands from this port, or from standard input (-): 'elevator_left "
            "10' (deg), 'turn p 45', 'lie z_down', 'pitot covered', 'pitot blow', 'help'",
        ),
    ] = None,
    sticks: Annotated[
        bool,
        typer.Option(
            "--sticks",
            help="Fly it yourself by lines on the standard input: 'take', 'sticks PITCH ROLL YAW "
            "[THROTTLE]' (-1 to 1: pulled, right, right; throttle 0 to 1) at least every 2 s, "
            "'size 0.5', 'rate low', 'click throttle 0.05', 'give', 'land', 'help'; the built-in "
            "pilot flies whenever you do not",
        ),
    ] = False,
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Fly the virtual aircraft, or calibrate it on the ground.

    Example: gsapp fly --to udpout:127.0.0.1:14550 --plan short

    Example: gsapp fly --out flights/real --plan short --dirt all --seed 5

    Example: gsapp fly --to udpout:127.0.0.1:14550 --sticks --airborne --turbulence 0.3

    Example: gsapp fly --bench --to udpout:127.0.0.1:14550 --control - --fault rudder:reversed
    """
    from gsapp.aircraft import load_aircraft
    from gsapp.cli._console import PlainConsole, write_json
    from gsapp.cli._flight_text import print_aircraft_warnings
    from gsapp.cli._usage_errors import as_usage_error, check_speed
    from gsapp.dynamics.model import load_model
    from gsapp.foundation.settings import command_arguments
    from gsapp.virtual.downlink.flight_settings import FlightSettings
    from gsapp.virtual.instruments import parse_sensor_fault
    from gsapp.virtual.virtual_flight import add_hidden_effects

    with as_usage_error():
        chosen = FlightSettings(**settings)
    console = PlainConsole(stderr=True)
    if bench:
        if to is None or out is not None:
            raise typer.BadParameter("the bench sends over a link; give --to LINK, no --out")
        given = {
            **dict.fromkeys(command_arguments(chosen), True), "--onboard": onboard is not None,
            "--truth": truth is not None, "--sticks": sticks, "--json": json is not None,
        }  # fmt: skip
        if needless := [one for one in _FLIGHT_OPTIONS if given.get(one)]:
            raise typer.BadParameter(f"the bench does not fly; leave out {', '.join(needless)}")
        _run_bench(chosen, to, speed=speed, control=control, console=console)
        return
    if (to is None) == (out is None):
        raise typer.BadParameter("give either --to LINK or --out FLIGHT")
    if control is not None:
        raise typer.BadParameter("--control belongs to --bench")
    if onboard is not None and (to is None or not chosen.thin):
        raise typer.BadParameter(
            "--onboard belongs to --thin --to LINK; the folder of --out holds its record itself"
        )
    if sticks and (to is None or onboard is not None):
        raise typer.BadParameter("--sticks fly over a link; give --to LINK, no --onboard")
    if chosen.airborne and not sticks:
        raise typer.BadParameter("--airborne belongs to --sticks")
    check_speed(speed)
    flown, believed = load_aircraft(chosen.aircraft), load_model(chosen.model)
    with as_usage_error():
        for text in chosen.faults:
            parse_sensor_fault(text)
        add_hidden_effects(flown, believed, chosen.hide)
    print_aircraft_warnings(console, [flown])
    if to is None:
        reached = write_folder(chosen, cast("Path", out), truth=truth, console=console)
    elif sticks:
        reached = _fly_with_sticks(chosen, to, speed=speed, truth=truth, console=console)
    else:
        reached = _transmit_flight(
            chosen, to, speed=speed, onboard=onboard, truth=truth, console=console
        )
    content = {
        "flight": None if out is None else str(out),
        "link": to,
        "truth": None if truth is None else str(truth),
        **dict(chosen),
        "dirt": chosen.draw_dirt().as_dict() if chosen.dirt else None,
        "duration": None if reached is None else reached.time,
        "sent_bytes": 0 if reached is None else reached.sent_bytes,
    }
    write_json(json, content)


def _run_bench(
    settings: FlightSettings, to: str, *, speed: float, control: str | None, console: PlainConsole
) -> None:
    """Send the volts of a virtual aircraft on the ground until it is switched off."""
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.telemetry.clock import HostClock
    from gsapp.telemetry.link_registry import parse_link
    from gsapp.virtual.bench import VirtualBench, parse_bench_fault
    from gsapp.virtual.downlink.commanded_downlinks import BenchDownlink
    from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter

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
        with _flight_status(console, f"On the ground, over {to}") as show:
            transmitter.transmit(show)


@contextmanager
def _open_control(
    control: str | None, clock: Clock, console: PlainConsole
) -> Iterator[CommandConsole | None]:
    """Open where lines to obey come from."""
    from gsapp.virtual.downlink.commanded_downlinks import StdinConsole, UdpConsole

    if control is None:
        yield None
        return
    heard: CommandConsole
    if control == "-":
        heard = StdinConsole(sys.stdin, console.print)
    else:
        heard = UdpConsole(control, clock=clock)
    with contextlib.closing(heard):
        yield heard


def _transmit_flight(
    settings: FlightSettings,
    to: str,
    *,
    speed: float,
    onboard: Path | None,
    truth: Path | None,
    console: PlainConsole,
) -> TransmitProgress | None:
    """Fly over a link in real time, or `speed` times that; return how far it came."""
    from gsapp.flight.writers import write_flight_csv
    from gsapp.telemetry.clock import HostClock
    from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter

    clock = HostClock()
    with open_link(to, clock, speed) as line:
        started = clock.now_us()
        place = onboard or Path(f"onboard-{time.strftime('%Y%m%d-%H%M%S')}.tlog")
        downlink = settings.create_downlink(started)
        log, server = settings.create_onboard_log(place, started)
        transmitter = DownlinkTransmitter(
            downlink, line, clock=clock, speed=speed, thin=settings.thin, log=log, server=server
        )
        try:
            with _flight_status(console, f"Flying '{settings.plan}' over {to}") as show:
                transmitter.transmit(show)
            _print_crash(downlink, console)
            console.print(f"The flight is over: {transmitter.sent_bytes / 1e6:.2f} MB sent.")
            if log is not None:
                console.print(
                    f"The full record is in {place} and can be fetched over the link with "
                    "'gsapp onboard FLIGHT --link LINK'; Ctrl-C ends.",
                    soft_wrap=True,
                )
                transmitter.serve_log_requests(_PEER_TIMEOUT)
        finally:
            if log is not None:
                log.close()
            if truth is not None:
                write_flight_csv(truth, downlink.truth(), "us")
    return show.progress


def write_folder(
    settings: FlightSettings, out: Path, *, truth: Path | None, console: PlainConsole
) -> TransmitProgress | None:
    """Write a flight folder, showing how far the flight is; see `record_virtual_flight`."""
    from gsapp.virtual.downlink.flight_recording import record_virtual_flight

    with _flight_status(console, f"Flying '{settings.plan}'") as show:
        downlink = record_virtual_flight(settings, out, truth=truth, progress=show)
    _print_crash(downlink, console)
    console.print(f"Wrote the flight {out}.")
    return show.progress


def _fly_with_sticks(
    settings: FlightSettings, to: str, *, speed: float, truth: Path | None, console: PlainConsole
) -> TransmitProgress | None:
    """Fly over a link as the lines of the standard input say, until they end."""
    from gsapp.flight.writers import write_flight_csv
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
    control = StdinConsole(sys.stdin, lambda text: console.print(text, soft_wrap=True))
    with open_link(to, clock, speed) as line, contextlib.closing(control):
        stream = TrainingDownlink(downlink, pilots[0], control)
        transmitter = DownlinkTransmitter(
            stream, line, clock=clock, speed=speed, thin=settings.thin
        )
        try:
            with _flight_status(console, f"Flying with keys over {to}") as show:
                transmitter.transmit(show)
            _print_crash(downlink, console)
        finally:
            if truth is not None:
                write_flight_csv(truth, downlink.truth(), "us")
    return show.progress


def _print_crash(downlink: FlightDownlink, console: PlainConsole) -> None:
    """Say of a flight that ended before its plan that it did, and when."""
    if downlink.crashed:
        end = downlink.truth().times[-1]
        console.print(
            f"The aircraft crashed after {end:.1f} s; the flight ends there.", style="yellow"
        )


@contextmanager
def open_link(to: str, clock: Clock, speed: float) -> Iterator[TransmitLink]:
    """Open a link to send over; a peer that is not there yet is waited for.

    Raises
    ------
    CommandUsageError
        If it is no link to send over, or the speed leads nowhere.
    LinkError
        If it cannot be opened.
    """
    from gsapp.cli._usage_errors import CommandUsageError, as_usage_error, check_speed
    from gsapp.telemetry.link_registry import kind_of, parse_link
    from gsapp.telemetry.sources import LinkUnavailableError, open_source

    check_speed(speed)
    with as_usage_error():
        address = parse_link(to)
    kind = kind_of(address)
    if not (kind.is_physical and kind.accepts_commands):
        raise CommandUsageError(
            f"the virtual aircraft cannot send to '{to}'; give a network link or a serial port, "
            "for example udpout:127.0.0.1:14550"
        )
    source = open_source(address, clock=clock)
    with contextlib.closing(source):
        # A peer that is not there yet is waited for; anything else is for the user to mend.
        with contextlib.suppress(LinkUnavailableError):
            source.open()
        yield _SourceLink(source)


class _SourceLink:
    """A source, as the transmitter needs it."""

    def __init__(self, source: LinkSource) -> None:
        self._source = source

    def send(self, data: bytes) -> None:
        self._source.write(data)

    def receive(self, timeout: float) -> bytes:
        return b"".join(chunk.data for chunk in self._source.read(timeout))


@contextmanager
def _flight_status(console: PlainConsole, title: str) -> Iterator[_FlightStatusLine]:
    """Show flight time and phase on one line while the flight goes on."""
    with console.status(title) as status:
        yield _FlightStatusLine(title, status.update)


class _FlightStatusLine:
    """One line that says how far a flight has come; `progress` is None before anything was told."""

    def __init__(self, title: str, show: Callable[[str], None]) -> None:
        self._title = title
        self._show = show
        self.progress: TransmitProgress | None = None

    def __call__(self, progress: TransmitProgress) -> None:
        self.progress = progress
        minutes, seconds = divmod(int(progress.time), 60)
        self._show(f"{self._title}: {minutes}:{seconds:02d}  {progress.phase}")
