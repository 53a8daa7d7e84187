"""``gsapp fly``: the virtual aircraft, over a link or straight into a flight folder."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsapp.foundation import FlightError
from gsapp.foundation.files import files_of

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.quantities import Block
    from gsapp.telemetry.clock import Clock
    from gsapp.telemetry.sources import Source
    from gsapp.telemetry.virtual.downlink import Downlink
    from gsapp.telemetry.virtual.settings import FlightSettings
    from gsapp.telemetry.virtual.transmit import Line, Progress

_STAY = 300.0
"""Seconds without a request after which a thin box, landed, stops offering its log."""


def run(
    *,
    to: str | None = None,
    out: Path | None = None,
    plan: str = "default",
    hide: tuple[str, ...] = (),
    faults: tuple[str, ...] = (),
    seed: int = 0,
    speed: float = 1.0,
    thin: bool = False,
    aircraft: str = "b777",
    model: str = "b777",
    attitude: bool = True,
    position: bool = False,
    turbulence: float | None = None,
    onboard: Path | None = None,
    truth: Path | None = None,
    sticks: bool = False,
    airborne: bool = False,
    json: Path | None = None,
) -> None:
    """Fly the virtual aircraft.

    Parameters
    ----------
    to : str or None
        LINK over which the box sends.
    out : Path or None
        Flight folder to write instead, as fast as it goes.
    plan, aircraft, model : str
        Files, or names of shipped ones.
    hide : tuple of str
        Effects that the aircraft has and the model lacks, ``ID[:PARAM=VALUE,..]``.
    faults : tuple of str
        What goes wrong with the instruments besides what the plan says,
        ``CHANNEL:KIND[:PARAM=VALUE,..]``.
    seed : int
        Same seed, same flight.
    speed : float
        Times real time; counts for `to`.
    thin : bool
        For a 57,600-baud radio, with the full record kept on board.
    attitude, position : bool
        Whether the board knows and sends them.
    turbulence : float or None
        Standard deviation of the gusts, m/s; None leaves it to the plan.
    onboard : Path or None
        Where the on-board log of a thin flight goes; a file beside the work by default.
    truth : Path or None
        Where the true motion goes, as a Flight CSV.
    sticks : bool
        Whether lines of the standard input move the sticks; counts for `to`.
    airborne : bool
        Whether such a flight begins in the pattern.
    json : Path or None
        Where what was flown goes, for programs; ``-`` for the screen.

    Raises
    ------
    GroundStationError
        If a file holds mistakes, the link cannot be opened, or the place is taken.
    """
    from gsapp.aircraft import load_aircraft
    from gsapp.cli._aircraft_text import warn_of_aircraft
    from gsapp.cli._calls import WrongCallError, check_pace, wrong_call
    from gsapp.cli._results import result_text, write_result
    from gsapp.cli._screen import Screen
    from gsapp.dynamics.model import load_model
    from gsapp.dynamics.pilot.faults import parse_fault
    from gsapp.dynamics.pilot.hidden import flown_model
    from gsapp.telemetry.virtual.settings import FlightSettings

    console = Screen(stderr=True)
    check_pace(speed)
    flown, believed = load_aircraft(aircraft), load_model(model)
    with wrong_call():
        for text in faults:
            parse_fault(text)
        flown_model(flown, believed, hide)
    settings = FlightSettings(
        plan=plan,
        aircraft=aircraft,
        model=model,
        hide=hide,
        faults=faults,
        seed=seed,
        turbulence=turbulence,
        thin=thin,
        attitude=attitude,
        position=position,
        airborne=airborne,
    )
    warn_of_aircraft(console, [flown])
    if out is not None:
        reached = write_folder(settings, out, truth=truth, console=console)
    elif to is not None and sticks:
        from gsapp.cli import training

        reached = training.send(settings, to, speed=speed, truth=truth, console=console)
    elif to is not None:
        reached = send(settings, to, speed=speed, onboard=onboard, truth=truth, console=console)
    else:
        raise WrongCallError("nothing says where to fly to; give a link or a flight folder")
    if json is not None:
        content = {"flight": None if out is None else str(out), "link": to}
        content |= {"truth": None if truth is None else str(truth)}
        write_result(json, result_text(content | _account(settings, reached)))


def _account(settings: FlightSettings, reached: Progress | None) -> dict[str, Any]:
    """Return what was flown, and how far; nulls where it was left to the plan."""
    return {
        **asdict(settings),
        "duration": None if reached is None else reached.time,
        "sent_bytes": 0 if reached is None else reached.sent_bytes,
    }


def send(
    settings: FlightSettings,
    to: str,
    *,
    speed: float,
    onboard: Path | None,
    truth: Path | None,
    console: Console,
) -> Progress | None:
    """Fly over a link in real time, or `speed` times that; return how far it came."""
    from gsapp.telemetry.clock import HostClock
    from gsapp.telemetry.virtual.transmit import Transmitter

    clock = HostClock()
    with open_line(to, clock, speed) as line:
        started = clock.now_us()
        place = onboard or Path(f"onboard-{time.strftime('%Y%m%d-%H%M%S')}.tlog")
        downlink = settings.downlink(started)
        log, server = settings.keep_log(place, started)
        transmitter = Transmitter(
            downlink,
            line,
            clock=clock,
            speed=speed,
            thin=settings.thin,
            log=log,
            server=server,
        )
        try:
            with shown(console, f"Flying '{settings.plan}' over {to}") as show:
                transmitter.fly(show)
            tell_of_crash(downlink, console)
            console.print(
                f"The flight is over: {transmitter.sent_bytes / 1e6:.2f} MB sent.", highlight=False
            )
            if log is not None:
                console.print(
                    f"The full record is in {place} and can be fetched over the link with "
                    "'gsapp onboard FLIGHT --link LINK'; Ctrl-C ends.",
                    soft_wrap=True,
                )
                transmitter.stay(_STAY)
        finally:
            if log is not None:
                log.close()
            if truth is not None:
                write_truth(truth, downlink.truth())
    return show.reached


def write_folder(
    settings: FlightSettings, out: Path, *, truth: Path | None, console: Console
) -> Progress | None:
    """Write a flight folder as if the flight had been recorded, as fast as it goes.

    Nothing stands at `out` before all of it does; returns how far the flight came.

    Raises
    ------
    FlightError
        If something is there already, or cannot be written.
    """
    from gsapp.flight.replacing import making

    if out.exists() and (not out.is_dir() or files_of(out)):
        raise FlightError(f"{out} exists already; choose another name for the new flight")
    with making(out) as part:
        true_motion, reached = _fill(settings, part, name=out.name, console=console)
        if truth is not None:
            write_truth(truth, true_motion)
    console.print(f"Wrote the flight {out}.", highlight=False)
    return reached


def _fill(
    settings: FlightSettings, folder: Path, *, name: str, console: Console
) -> tuple[Block, Progress | None]:
    """Write the record and the copies; return the true motion, and how far the flight came."""
    from gsapp.flight.preparing import prepare_flight
    from gsapp.telemetry.virtual.record import write_record

    started = time.time_ns() // 1000
    downlink = settings.downlink(started)
    flight = prepare_flight(
        folder,
        name=name,
        aircraft=settings.aircraft,
        channel_map="b777-thin" if settings.thin else "b777",
        calibration=settings.certificates,
        source="virtual",
        notes=_notes(settings),
    )
    kept = folder / "onboard.tlog" if settings.thin else None
    with shown(console, f"Flying '{settings.plan}'") as show:
        write_record(downlink, flight.tlog_file, kept, seed=settings.seed, progress=show)
    tell_of_crash(downlink, console)
    if kept is not None:
        flight.update_info(onboard_log=kept.name)
    return downlink.truth(), show.reached


def _notes(settings: FlightSettings) -> str:
    return f"Virtual flight: plan {settings.plan}, seed {settings.seed}."


def tell_of_crash(downlink: Downlink, console: Console) -> None:
    """Say of a flight that ended before its plan that it did, and when."""
    if downlink.crashed:
        end = downlink.truth().times[-1]
        console.print(
            f"The aircraft crashed after {end:.1f} s; the flight ends there.",
            style="yellow",
            highlight=False,
        )


def write_truth(path: Path, block: Block) -> None:
    """Write the true motion as a Flight CSV."""
    from gsapp.flight.writers import write_flight_csv

    write_flight_csv(path, block, "us")


@contextlib.contextmanager
def open_line(to: str, clock: Clock, speed: float) -> Iterator[Line]:
    """Open a link to send over.

    Parameters
    ----------
    to : str
        LINK; a peer that is not there yet is waited for.
    clock : Clock
    speed : float
        At which is sent, times real time.

    Raises
    ------
    WrongCallError
        If it is no link to send over, or the speed leads nowhere.
    LinkError
        If it cannot be opened.
    """
    from gsapp.cli._calls import WrongCallError, check_pace, wrong_call
    from gsapp.telemetry.address import parse_link
    from gsapp.telemetry.sources import LinkAwaitedError, open_source

    check_pace(speed)
    with wrong_call():
        address = parse_link(to)
    if address.kind in ("virtual", "flight", "text"):
        raise WrongCallError(
            f"the virtual aircraft cannot send to '{to}'; give a network link or a serial port, "
            "for example udpout:127.0.0.1:14550"
        )
    source = open_source(address, clock=clock)
    with contextlib.closing(source):
        # A peer that is not there yet is waited for; anything else is for the user to mend.
        with contextlib.suppress(LinkAwaitedError):
            source.open()
        yield _SourceLine(source)


class _SourceLine:
    """A source, as the transmitter needs it."""

    def __init__(self, source: Source) -> None:
        self._source = source

    def send(self, data: bytes) -> None:
        self._source.write(data)

    def receive(self, timeout: float) -> bytes:
        return b"".join(chunk.data for chunk in self._source.read(timeout))


@contextlib.contextmanager
def shown(console: Console, title: str) -> Iterator[FlightLine]:
    """Show flight time and phase on one line while the flight goes on."""
    with console.status(title) as status:
        yield FlightLine(title, status.update)


class FlightLine:
    """One line that says how far a flight has come.

    Parameters
    ----------
    title : str
    show : callable
        Shows the line anew.

    Attributes
    ----------
    reached : Progress or None
        How far it came; None before anything was told.
    """

    def __init__(self, title: str, show: Callable[[str], None]) -> None:
        self._title = title
        self._show = show
        self.reached: Progress | None = None

    def __call__(self, progress: Progress) -> None:
        """Show where the flight is."""
        self.reached = progress
        minutes, seconds = divmod(int(progress.time), 60)
        self._show(f"{self._title}: {minutes}:{seconds:02d}  {progress.phase}")
