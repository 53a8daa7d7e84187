"""What the commands that fly the virtual aircraft share: link, status line, end of the flight."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.quantities import Block
    from gsapp.telemetry.clock import Clock
    from gsapp.telemetry.sources import LinkSource
    from gsapp.virtual.downlink.downlink_transmitter import TransmitLink, TransmitProgress
    from gsapp.virtual.downlink.flight_downlink import FlightDownlink


def print_crash(downlink: FlightDownlink, console: Console) -> None:
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
def open_link(to: str, clock: Clock, speed: float) -> Iterator[TransmitLink]:
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


@contextlib.contextmanager
def flight_status(console: Console, title: str) -> Iterator[FlightStatusLine]:
    """Show flight time and phase on one line while the flight goes on."""
    with console.status(title) as status:
        yield FlightStatusLine(title, status.update)


class FlightStatusLine:
    """One line that says how far a flight has come.

    Parameters
    ----------
    title : str
    show : callable
        Shows the line anew.

    Attributes
    ----------
    progress : TransmitProgress or None
        How far it came; None before anything was told.
    """

    def __init__(self, title: str, show: Callable[[str], None]) -> None:
        self._title = title
        self._show = show
        self.progress: TransmitProgress | None = None

    def __call__(self, progress: TransmitProgress) -> None:
        """Show where the flight is."""
        self.progress = progress
        minutes, seconds = divmod(int(progress.time), 60)
        self._show(f"{self._title}: {minutes}:{seconds:02d}  {progress.phase}")
