"""Asking for flights that are there: files and flight folders."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QWidget

from gsapp.flight.flight_loader import LOG_SUFFIXES
from ui.settings import Settings, initial_dialog_folder
from ui.translation import tr

# ArduPilot calls its logs 00000012.BIN, and some dialogs tell capitals from small letters.
_ENDINGS = " ".join(f"*{ending}" for ending in (*LOG_SUFFIXES, ".BIN"))


def log_name_filter() -> str:
    """Return the kinds of a file dialog for on-board logs, as Qt writes them."""
    return tr("Logs ({endings});;All files (*)").format(endings=_ENDINGS)


def flight_name_filter() -> str:
    """Return the kinds of a file dialog for flights, as Qt writes them."""
    return tr("Flights ({endings});;All files (*)").format(endings=_ENDINGS)


def ask_open_file(parent: QWidget, settings: Settings) -> Path | None:
    """Ask for one file that is a flight; return None where none was chosen."""
    start = str(initial_dialog_folder(settings))
    path, _kind = QFileDialog.getOpenFileName(
        parent, tr("Open a flight"), start, flight_name_filter()
    )
    return Path(path) if path else None


def ask_open_files(parent: QWidget, settings: Settings) -> list[Path]:
    """Ask for files that are flights, to be added to others; return an empty list for none."""
    start = str(initial_dialog_folder(settings))
    paths, _kind = QFileDialog.getOpenFileNames(
        parent, tr("Add flights"), start, flight_name_filter()
    )
    return [Path(path) for path in paths]


def ask_flight_folder(parent: QWidget, title: str, settings: Settings) -> Path | None:
    """Ask for a flight folder; return None where none was chosen."""
    path = QFileDialog.getExistingDirectory(parent, title, str(initial_dialog_folder(settings)))
    return Path(path) if path else None
