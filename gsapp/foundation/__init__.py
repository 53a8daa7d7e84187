"""What every part stands on: errors, atomic writes, locks, and TOML with good messages."""

from gsapp.foundation.errors import (
    FileProblem,
    FileProblemsError,
    FlightError,
    GroundStationError,
    LinkError,
    UnitError,
    UnknownNameError,
    UnmappedError,
)
from gsapp.foundation.files import write_atomically
from gsapp.foundation.toml import (
    StrictModel,
    read_toml,
    read_toml_table,
    toml_problems_error,
    toml_text,
    write_toml,
)

__all__ = [
    "FileProblem",
    "FileProblemsError",
    "FlightError",
    "GroundStationError",
    "LinkError",
    "StrictModel",
    "UnitError",
    "UnknownNameError",
    "UnmappedError",
    "read_toml",
    "read_toml_table",
    "toml_problems_error",
    "toml_text",
    "write_atomically",
    "write_toml",
]
