"""What was prepared for a flight before its folder is there: card, test cards, ticks.

It lies in a folder of its own under the same names as in a flight folder, and goes into the
flight's when recording starts.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any, Final

from gsapp.flight.atomic_files import copy_atomically
from gsapp.flight.events import read_events
from gsapp.flight.file_names import CARDS_FILE
from gsapp.flight.flight_info_file import FlightInfoFile
from gsapp.flight.folder import FlightFolder
from gsapp.flight.toml_document import KeyPath

CARRIED_OVER_KEYS: Final = ("crew", "flap", "loading", "transmitter")
"""What the card of the flight after begins with."""


def apply_draft(
    waiting: Path, folder: FlightFolder, *, keep: bool = False, named: bool = True
) -> bool:
    """Put what waits for the next flight into its folder, and begin the one after.

    What the folder knows already stays; a flight that has a record began with its own card and
    gets nothing.

    Parameters
    ----------
    waiting : Path
        Where it waits; it need not be there.
    keep : bool
        Whether it waits for another flight all the same: this one is only for trial.
    named : bool
        Whether the flight takes the name that waits.

    Returns
    -------
    bool
        Whether anything was handed over.

    Raises
    ------
    FileProblemsError
        If a card holds mistakes; nothing was handed over then.
    FlightError
        If the disk refuses.
    """
    if not waiting.is_dir() or folder.nonempty_raw_files:
        return False
    prepared = FlightInfoFile(FlightFolder(path=waiting))
    card = FlightInfoFile(folder)
    named_by_itself = card.value(("name",)) in (None, folder.path.resolve().name)
    values: dict[KeyPath, Any] = {
        (key,): value
        for key, value in prepared.content.items()
        if (named and named_by_itself if key == "name" else key not in card.content)
    }
    card.change(values)
    card.save()
    ticks = read_events(FlightFolder(path=waiting).events.path).events
    for event in ticks:
        folder.events.append(event)
    plan = waiting / CARDS_FILE
    planned = plan.is_file() and not (folder.path / CARDS_FILE).exists()
    if planned:
        copy_atomically(plan, folder.path / CARDS_FILE)
    if not keep:
        reset_draft(waiting)
    return bool(values or ticks or planned)


def reset_draft(waiting: Path) -> None:
    """Leave of what waits only what stays from flight to flight: the rest was handed over.

    Raises
    ------
    FileProblemsError
        If a card holds mistakes.
    FlightError
        If the disk refuses.
    """
    prepared = FlightInfoFile(FlightFolder(path=waiting))
    prepared.restore(
        {key: value for key, value in prepared.content.items() if key in CARRIED_OVER_KEYS}
    )
    prepared.save()
    with contextlib.suppress(FileNotFoundError):
        prepared.folder.events.path.unlink()
