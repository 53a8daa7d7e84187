"""``gsapp fly``: the virtual aircraft, over a link or straight into a flight folder."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsapp.cli._virtual_flight import flight_status, open_link, print_crash, write_truth
from gsapp.foundation import FlightError
from gsapp.foundation.files import list_files

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.quantities import Block
    from gsapp.virtual.downlink.downlink_transmitter import TransmitProgress
    from gsapp.virtual.downlink.flight_settings import FlightSettings

_PEER_TIMEOUT = 300.0
"""Seconds without a request after which a thin box, landed, stops offering its log."""


def run(
    *,
    to: str | None = None,
    out: Path | None = None,
    speed: float = 1.0,
    onboard: Path | None = None,
    truth: Path | None = None,
    sticks: bool = False,
    json: Path | None = None,
    **settings: Any,
) -> None:
    """Fly the virtual aircraft.

    Parameters
    ----------
    to : str or None
        LINK over which the box sends.
    out : Path or None
        Flight folder to write instead, as fast as it goes.
    speed : float
        Times real time; counts for `to`.
    onboard : Path or None
        Where the on-board log of a thin flight goes; a file beside the work by default.
    truth : Path or None
        Where the true motion goes, as a Flight CSV.
    sticks : bool
        Whether lines of the standard input move the sticks; counts for `to`.
    json : Path or None
        Where what was flown goes, for programs; ``-`` for the screen.
    **settings
        Fields of `gsapp.virtual.downlink.flight_settings.FlightSettings`.

    Raises
    ------
    GroundStationError
        If a file holds mistakes, the link cannot be opened, or the place is taken.
    """
    from gsapp.aircraft import load_aircraft
    from gsapp.cli._aircraft_text import print_aircraft_warnings
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._json_output import format_json, write_json
    from gsapp.cli._usage_errors import CommandUsageError, as_usage_error, check_speed
    from gsapp.dynamics.model import load_model
    from gsapp.virtual.downlink.flight_settings import FlightSettings
    from gsapp.virtual.instruments import parse_sensor_fault
    from gsapp.virtual.virtual_flight import add_hidden_effects

    console = PlainConsole(stderr=True)
    check_speed(speed)
    with as_usage_error():
        chosen = FlightSettings(**settings)
    flown, believed = load_aircraft(chosen.aircraft), load_model(chosen.model)
    with as_usage_error():
        for text in chosen.faults:
            parse_sensor_fault(text)
        add_hidden_effects(flown, believed, chosen.hide)
    print_aircraft_warnings(console, [flown])
    if out is not None:
        reached = write_folder(chosen, out, truth=truth, console=console)
    elif to is not None and sticks:
        from gsapp.cli import fly_sticks

        reached = fly_sticks.fly_with_sticks(chosen, to, speed=speed, truth=truth, console=console)
    elif to is not None:
        reached = transmit_flight(
            chosen, to, speed=speed, onboard=onboard, truth=truth, console=console
        )
    else:
        raise CommandUsageError("no destination; give a link or a flight folder")
    if json is not None:
        content = {"flight": None if out is None else str(out), "link": to}
        content |= {"truth": None if truth is None else str(truth)}
        write_json(json, format_json(content | _flight_json(chosen, reached)))


def _flight_json(settings: FlightSettings, reached: TransmitProgress | None) -> dict[str, Any]:
    """Return what was flown, and how far; nulls where it was left to the plan."""
    return {
        **dict(settings),
        "duration": None if reached is None else reached.time,
        "sent_bytes": 0 if reached is None else reached.sent_bytes,
    }


def transmit_flight(
    settings: FlightSettings,
    to: str,
    *,
    speed: float,
    onboard: Path | None,
    truth: Path | None,
    console: Console,
) -> TransmitProgress | None:
    """Fly over a link in real time, or `speed` times that; return how far it came."""
    from gsapp.telemetry.clock import HostClock
    from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter

    clock = HostClock()
    with open_link(to, clock, speed) as line:
        started = clock.now_us()
        place = onboard or Path(f"onboard-{time.strftime('%Y%m%d-%H%M%S')}.tlog")
        downlink = settings.create_downlink(started)
        log, server = settings.create_onboard_log(place, started)
        transmitter = DownlinkTransmitter(
            downlink,
            line,
            clock=clock,
            speed=speed,
            thin=settings.thin,
            log=log,
            server=server,
        )
        try:
            with flight_status(console, f"Flying '{settings.plan}' over {to}") as show:
                transmitter.transmit(show)
            print_crash(downlink, console)
            console.print(
                f"The flight is over: {transmitter.sent_bytes / 1e6:.2f} MB sent.", highlight=False
            )
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
                write_truth(truth, downlink.truth())
    return show.progress


def write_folder(
    settings: FlightSettings, out: Path, *, truth: Path | None, console: Console
) -> TransmitProgress | None:
    """Write a flight folder as if the flight had been recorded, as fast as it goes.

    Nothing stands at `out` before all of it does; returns how far the flight came.

    Raises
    ------
    FlightError
        If something is there already, or cannot be written.
    """
    from gsapp.flight.atomic_files import atomic_flight_folder

    if out.exists() and (not out.is_dir() or list_files(out)):
        raise FlightError(f"{out} exists already; choose another name for the new flight")
    with atomic_flight_folder(out) as part:
        true_motion, reached = _fill(settings, part, name=out.name, console=console)
        if truth is not None:
            write_truth(truth, true_motion)
    console.print(f"Wrote the flight {out}.", highlight=False)
    return reached


def _fill(
    settings: FlightSettings, folder: Path, *, name: str, console: Console
) -> tuple[Block, TransmitProgress | None]:
    """Write the record and the copies; return the true motion, and how far the flight came."""
    from gsapp.flight.folder_setup import prepare_flight_folder
    from gsapp.virtual.downlink.flight_downlink import write_record

    started = time.time_ns() // 1000
    downlink = settings.create_downlink(started)
    flight = prepare_flight_folder(
        folder,
        name=name,
        aircraft=settings.aircraft,
        channel_map="b777-thin" if settings.thin else "b777",
        calibration=settings.certificates,
        source="virtual",
        notes=_notes(settings),
    )
    kept = folder / "onboard.tlog" if settings.thin else None
    with flight_status(console, f"Flying '{settings.plan}'") as show:
        write_record(downlink, flight.tlog_file, kept, seed=settings.seed, progress=show)
    print_crash(downlink, console)
    if kept is not None:
        flight.update_info(onboard_log=kept.name)
    return downlink.truth(), show.progress


def _notes(settings: FlightSettings) -> str:
    return f"Virtual flight: plan {settings.plan}, seed {settings.seed}."
