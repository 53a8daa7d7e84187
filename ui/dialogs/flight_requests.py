"""What the dialogs ask for, checked while it is typed. No Qt."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import date
from itertools import product
from pathlib import Path
from string import ascii_lowercase
from typing import Literal

from gsapp.foundation import GroundStationError
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.link_registry import kind_of
from gsapp.telemetry.recording_settings import RecordingSettings
from gsapp.virtual.downlink.flight_settings import FlightSettings
from ui.disk_checks import path_kind
from ui.number_format import bytes_text, sanitize_file_name
from ui.settings import unwritable_reason
from ui.translation import tr

InputState = Literal["", "good", "caution", "warning"]

# A full MAVLink stream of the B777 box.
_BYTES_PER_HOUR = 65e6


@dataclass(frozen=True, slots=True, kw_only=True)
class InputCheck:
    """Whether something typed will do, and a sentence about it."""

    message: str
    state: InputState = ""

    @property
    def is_valid(self) -> bool:
        return self.state != "warning"


class ConnectRequest(RecordingSettings):
    """An aircraft to be recorded and shown."""

    link: str  # LINK text.
    folder: Path  # Flight folder to record into.
    # The flown MAVLink system; None for that of the map, or the first autopilot heard.
    system: int | None = None
    address: str = ""  # Network address that it sends from; empty for that of its first heartbeat.
    title: str = ""  # What the crew calls the flight; empty for the name of its folder.


class VirtualFlightRequest(FlightSettings):
    """A flight of the virtual aircraft."""

    speed: float = 1.0  # Times real time.
    folder: Path  # Flight folder to record into.
    append: bool = False  # Whether to append to the flight if it is already finished.
    title: str = ""  # What the crew calls the flight; empty for the name of its folder.


def check_link(text: str, parse: Callable[[str], LinkAddress], ports: Iterable[str]) -> InputCheck:
    """Return what is to be said of a LINK as it is typed.

    `parse`: reads a LINK; raises `GroundStationError` with a sentence if it is none.
    """
    text = text.strip()
    if not text:
        return InputCheck(
            message=tr("Choose above, or type a LINK such as udpin:127.0.0.1:14550."),
            state="warning",
        )
    try:
        address = parse(text)
    except GroundStationError as error:
        return InputCheck(message=str(error), state="warning")
    except ValueError as error:
        return InputCheck(message=tr("Invalid link: {error}.").format(error=error), state="warning")
    kind = kind_of(address)
    if caution := kind.caution(address, ports):
        return InputCheck(message=caution, state="caution")
    return InputCheck(message=kind.description(address), state="good")


def next_flight_name(parent: Path, today: date, kind: str = "") -> str:
    """Return ``2026-05-12-c``, or ``2026-05-12-training-c``: the first that is not there yet."""
    letters = (
        "".join(word) for size in (1, 2, 3) for word in product(ascii_lowercase, repeat=size)
    )
    first = f"{today.isoformat()}-{kind}" if kind else today.isoformat()
    names = (f"{first}-{letter}" for letter in letters)
    return next(name for name in names if path_kind(parent / name) in ("missing", "stuck"))


def check_folder(parent: str, name: str) -> InputCheck:
    """Return what is to be said of the place where a flight shall be recorded."""
    if not name.strip():
        return InputCheck(message=tr("The flight needs a name."), state="warning")
    if sanitize_file_name(name) != name.strip():
        return InputCheck(
            message=tr("Invalid folder name; use {name!r}.").format(name=sanitize_file_name(name)),
            state="warning",
        )
    if not parent.strip():
        return InputCheck(message=tr("Choose the folder for flights."), state="warning")
    path = Path(parent).expanduser()
    if why := unwritable_reason(path):
        return InputCheck(
            message=tr("{why} Choose another folder.").format(why=why), state="warning"
        )
    existing = next(one for one in (path, *path.parents) if one.exists())
    free = shutil.disk_usage(existing).free
    room = tr("{free} free").format(free=bytes_text(free))
    if free < _BYTES_PER_HOUR:
        return InputCheck(
            message=tr("Only {room}: less than an hour of flight. Make room first.").format(
                room=room
            ),
            state="caution",
        )
    target = path / name.strip()
    if target.exists():
        if why := unwritable_reason(target):
            return InputCheck(
                message=tr("{why} Choose another name.").format(why=why), state="warning"
            )
        return InputCheck(
            message=tr(
                "This flight exists. Continuing it keeps its channel map, aircraft and "
                "calibration. {room}."
            ).format(room=room),
            state="caution",
        )
    return InputCheck(
        message=tr("Recorded in {target}. {room}.").format(target=target, room=room), state="good"
    )
