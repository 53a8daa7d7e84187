"""Processes that go on when the one that started them ends, or is interrupted."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO


def start_detached_process(
    command: Sequence[str],
    words: IO[bytes],
    *,
    folder: Path | None = None,
    listens: bool = False,
) -> subprocess.Popen[bytes]:
    """Start a process that no Ctrl-C and no closed terminal of this one reaches.

    Parameters
    ----------
    command : sequence of str
        Program and arguments.
    words : binary file
        Where its complaints go, a Python's as UTF-8; what it prints is dropped.
    folder : Path, optional
        Where it works.
    listens : bool
        Whether it hears what is written to it.

    Returns
    -------
    Popen
        The process.

    Raises
    ------
    OSError
        If it cannot be started.
    """
    flags = 0
    if sys.platform == "win32":
        # A console that nobody sees. Without any, Windows opens one on the screen for the Python
        # behind the launcher of a virtual environment, and closing that would end it.
        flags = subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP
    return subprocess.Popen(
        command,
        cwd=folder,
        env={**os.environ, "PYTHONUTF8": "1"},
        stdin=subprocess.PIPE if listens else subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=words,
        bufsize=0,
        creationflags=flags,
        start_new_session=sys.platform != "win32",
    )
