"""Asking for flights that are there: files and flight folders."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QWidget

from gsapp.flight.loading import LOG_ENDINGS
from ui.settings import Settings, first_folder

# ArduPilot calls its logs 00000012.BIN, and some dialogs tell capitals from small letters.
_ENDINGS = " ".join(f"*{ending}" for ending in (*LOG_ENDINGS, ".BIN"))
LOGS = f"Logs ({_ENDINGS});;All files (*)"
"""Kinds of a file dialog for on-board logs, as Qt writes them."""
FLIGHTS = f"Flights ({_ENDINGS});;All files (*)"
"""Kinds of a file dialog for flights, as Qt writes them."""


def file_to_open(parent: QWidget, settings: Settings) -> Path | None:
    """Ask for one file that is a flight; return None where none was chosen."""
    start = str(first_folder(settings))
    path, _kind = QFileDialog.getOpenFileName(parent, "Open a flight", start, FLIGHTS)
    return Path(path) if path else None


def files_to_add(parent: QWidget, settings: Settings) -> list[Path]:
    """Ask for files that are flights, to be added to others; return an empty list for none."""
    start = str(first_folder(settings))
    paths, _kind = QFileDialog.getOpenFileNames(parent, "Add flights", start, FLIGHTS)
    return [Path(path) for path in paths]


def flight_folder(parent: QWidget, title: str, settings: Settings) -> Path | None:
    """Ask for a flight folder; return None where none was chosen."""
    path = QFileDialog.getExistingDirectory(parent, title, str(first_folder(settings)))
    return Path(path) if path else None
