"""Flight folder, import and export, cut and merge, maneuver detection, catalog.

Throughout, unless a docstring says otherwise: values are SI and radians, times are flight time in
s; `rate` is that of the samples and their grid ``k / rate``, Hz. Reading and writing raise
`FlightError` where the disk refuses, and `FileProblemsError` where a file holds mistakes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gsapp.flight.flight import Flight, FrameCounts
    from gsapp.flight.flight_loader import load_flight

__all__ = ["Flight", "FrameCounts", "load_flight"]

_HOMES = {
    "Flight": "gsapp.flight.flight",
    "FrameCounts": "gsapp.flight.flight",
    "load_flight": "gsapp.flight.flight_loader",
}


def __getattr__(name: str) -> Any:
    """Import on first use: the recorder needs the raw files only, and starts quickly."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
