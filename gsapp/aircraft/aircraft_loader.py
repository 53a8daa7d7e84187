"""Finding and reading aircraft files."""

from __future__ import annotations

from pathlib import Path

from gsapp.aircraft.config import Aircraft
from gsapp.foundation import read_toml
from gsapp.foundation.files import ShippedFiles

SHIPPED_AIRCRAFT = ShippedFiles(folder=Path(__file__).parent / "files", kind="aircraft")


def shipped_aircraft() -> tuple[str, ...]:
    """Return the names of the aircraft that come with the program."""
    return SHIPPED_AIRCRAFT.names()


def load_aircraft(name_or_path: str | Path) -> Aircraft:
    """Read an aircraft file: a path, or the name of a shipped aircraft such as ``b777``.

    Raise FileProblemsError if the file holds mistakes; all are named. Raise UnknownNameError if
    there is neither such a file nor such a shipped aircraft.
    """
    return read_toml(SHIPPED_AIRCRAFT.find(name_or_path), Aircraft)


def file_warnings(aircraft: Aircraft) -> tuple[str, ...]:
    """Return the warnings about an aircraft file; none about a shipped one.

    The values of a shipped aircraft are those of its source, which no user can measure again.
    """
    shipped = any(aircraft == load_aircraft(name) for name in shipped_aircraft())
    return () if shipped else aircraft.warnings()
