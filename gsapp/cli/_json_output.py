"""Where ``--json`` goes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gsapp.identification.runs.flight_cache import FlightCache
    from gsapp.identification.runs.outcome import RunOutcome


def is_stdout(json: Path | None) -> bool:
    """Return whether the result for programs is to stand alone on the screen."""
    return json is not None and str(json) == "-"


def format_json(result: object) -> str:
    """Return a result as JSON: SI units, absent = null."""
    import json

    return json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def outcome_json(outcome: RunOutcome, flights: FlightCache) -> dict[str, Any]:
    """Return what a run gave, with the certificates that its flights were read with."""
    from gsapp.cli._flight_text import calibration_json
    from gsapp.identification.estimate_json import campaign_json
    from gsapp.identification.runs.inputs import flight_open_requests

    opened = [flights.open(one).opened for one in flight_open_requests(outcome.request)]
    content: dict[str, Any] = campaign_json(outcome.result)
    return content | {"calibration": calibration_json(one.flight for one in opened)}


def write_json(json: Path, text: str) -> None:
    """Write the result of a command for programs; ``-`` is the screen.

    Raises
    ------
    GroundStationError
        If the file cannot be written.
    """
    from gsapp.foundation import GroundStationError, write_atomically
    from gsapp.foundation.errors import format_os_error

    if is_stdout(json):
        if sys.stdout is None:
            raise GroundStationError("the standard output is closed; name a file instead of '-'")
        sys.stdout.write(text)
        return
    try:
        write_atomically(json, text)
    except OSError as error:
        raise GroundStationError(
            format_os_error(json, error, "choose a folder with write permission")
        ) from error
