"""Looking at a path without waiting for its disk: a network drive may never answer."""

from __future__ import annotations

import stat
from pathlib import Path
from threading import Thread
from typing import Literal

PathKind = Literal["file", "folder", "special", "missing", "stuck"]

_DISK_TIMEOUT = 0.2
_SHORT_DISK_TIMEOUT = 0.03
"""Seconds that the window waits for a disk; little while another path is stuck already, since
all that is remembered often lies on one disk."""

_pending_checks: dict[Path, Thread] = {}  # Paths whose disk has not answered yet.


def path_kind(path: Path | str) -> PathKind:
    """Return what a path is, within a fifth of a second.

    Returns ``special`` for a pipe or a device, where a reader waits for the other end; ``stuck``
    where the disk does not answer. Such a path, and all below it, is not asked again until it does.
    """
    place = Path(path).expanduser().absolute()
    for known, asking in list(_pending_checks.items()):
        if not asking.is_alive():
            del _pending_checks[known]
    if not _pending_checks.keys().isdisjoint((place, *place.parents)):
        return "stuck"
    kinds: list[PathKind] = []
    thread = Thread(target=lambda: kinds.append(_stat_kind(place)), name="disk check", daemon=True)
    thread.start()
    thread.join(_SHORT_DISK_TIMEOUT if _pending_checks else _DISK_TIMEOUT)
    if not kinds:
        _pending_checks[place] = thread
        return "stuck"
    return kinds[0]


def _stat_kind(place: Path) -> PathKind:
    try:
        mode = place.stat().st_mode
    except (OSError, ValueError):
        return "missing"
    if stat.S_ISDIR(mode):
        return "folder"
    return "file" if stat.S_ISREG(mode) else "special"


def nearest_folder(path: Path) -> Path:
    """Return the nearest folder to a path that is there, for a file dialog to begin in.

    Home where the disk does not respond: a dialog that begins there waits for it.
    """
    for place in (path, *path.parents):
        kind = path_kind(place)
        if kind == "folder":
            return place
        if kind == "stuck":
            break
    return Path.home()


def may_block(path: Path | str) -> bool:
    """Return whether reading a path could hold up the window; not so for names of shipped files."""
    return path_kind(path) in ("special", "stuck")
