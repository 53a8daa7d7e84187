"""One maneuver fitted by maximum likelihood, in whichever process."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection

from gsapp.dynamics.model import Model
from gsapp.foundation import GroundStationError
from gsapp.foundation.process_control import lower_priority
from gsapp.identification.campaign import CampaignSettings, ManeuverResult, run_campaign
from gsapp.identification.maneuver import Maneuver

_WORKER_NICENESS = 10
"""By how much a worker stands back behind the stream and the window."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitRequest:
    """What is to be fitted."""

    maneuver: Maneuver
    model: Model | None
    """Values known before: held where the maneuver does not free them."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitResponse:
    """What came of it."""

    result: ManeuverResult
    """Its estimate is None where the fit failed."""
    seconds: float
    """That it took; says nothing of the flight."""


def run_fit_request(request: FitRequest) -> FitResponse:
    """Fit one maneuver as ``gsapp estimate`` does."""
    started = time.perf_counter()
    settings = CampaignSettings(known_model=request.model)
    try:
        (result,) = run_campaign([request.maneuver], settings).results
    except GroundStationError as error:
        result = ManeuverResult(maneuver=request.maneuver, estimate=None, failure=str(error))
    return FitResponse(result=result, seconds=time.perf_counter() - started)


def initialize_fit_worker(wanted: Connection) -> None:
    """Make a worker process yield to all else and leave Ctrl+C to its parent.

    Parameters
    ----------
    wanted : Connection
        The process ends at once when the other end is closed, or its parent was killed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    lower_priority(_WORKER_NICENESS)
    threading.Thread(target=_end_when_closed, args=(wanted,), name="wanted", daemon=True).start()


def _end_when_closed(wanted: Connection) -> None:
    with contextlib.suppress(EOFError, OSError):
        wanted.recv_bytes()
    os._exit(1)
