"""A flight to try things on: the virtual aircraft, with an effect that its model lacks or without.

No Qt.
"""

from __future__ import annotations

import contextlib
import shutil
import subprocess
import tempfile
import time
from datetime import date
from pathlib import Path

from gsapp.foundation import GroundStationError
from gsapp.foundation.files import create_sibling_folder, move_into_place
from gsapp.foundation.process_control import module_command
from ui.job_process.job_server import JobProgressCallback
from ui.translation import tr

HIDDEN_EFFECT = "propulsion.Cm.throttle"
"""What the pilot of the first flight described: the nose follows the throttle."""
BASELINE_MODEL = SIMULATED_AIRCRAFT = "b777"
_FLIGHT_PLAN = "default"


def find_virtual_flight_folder(flights: Path, today: date) -> Path:
    """Return a folder for the trial flight that does not exist yet."""
    number = 1
    while (folder := flights / f"{today.isoformat()} trial {number}").exists():
        number += 1
    return folder


def simulate_virtual_flight(
    folder: Path, tell: JobProgressCallback, *, hide: str = HIDDEN_EFFECT
) -> Path:
    """Let the virtual aircraft fly, as fast as it goes.

    `folder`: flight folder to write; not there yet. A flight that is stopped leaves none. `tell`:
    told what is being done; what it raises stops the flight. `hide`: effect that the aircraft has
    and its model lacks; empty for none.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    # A flight that is stopped leaves what it was about: in a folder that can be taken away.
    scratch = create_sibling_folder(folder)
    written = scratch / folder.name
    effect = ("--hide", hide) if hide else ()
    command = module_command(
        "gsapp.cli", "fly", "--out", str(written), "--plan", _FLIGHT_PLAN, "--seed", "1", *effect
    )
    words_of_it = tr("simulating the flight")
    if hide:
        words_of_it += tr(" with a hidden effect")
    with contextlib.ExitStack() as stack:
        stack.callback(shutil.rmtree, scratch, ignore_errors=True)
        text = stack.enter_context(tempfile.TemporaryFile())
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=text
        )
        try:
            while process.poll() is None:
                tell(None, words_of_it)
                time.sleep(0.1)
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait(5.0)
        if process.returncode != 0:
            text.seek(0)
            said = text.read().decode("utf-8", "replace").strip().splitlines()
            raise GroundStationError(
                tr("the virtual flight was not written: {reason}").format(
                    reason=said[-1] if said else tr("no word from it")
                )
            )
        move_into_place(written, folder)
    return folder
