"""Asking for files: flights to open, and files to be written."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QWidget

from gsapp.flight.flight_loader import LOG_SUFFIXES
from gsapp.foundation import write_atomically
from ui.disk_checks import nearest_folder
from ui.settings import Settings, initial_dialog_folder
from ui.translation import tr
from ui.widgets.message_boxes import show_warning

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


def ask_save_file(parent: QWidget | None, title: str, start: Path, kinds: str) -> Path | None:
    """Ask for a file to be written, and give it the ending of its kind if it has none.

    The dialog of Windows adds the ending by itself, others do not; what is called without is not
    found again by a dialog that opens files of this kind. A file that then has the name already is
    only replaced if the user says so.

    `kinds`: as Qt writes them, one ending each: ``Picture (*.png);;Drawing (*.svg)``.
    """
    endings = dict(re.findall(r"([^;]+\(\*(\.\w+)\))", kinds))
    start = nearest_folder(start.parent) / start.name
    while True:
        text, kind = QFileDialog.getSaveFileName(parent, title, str(start), kinds)
        if not text:
            return None
        path = Path(text)
        if path.suffix.casefold() in endings.values():
            return path
        start = path.with_name(f"{path.name}{endings.get(kind, next(iter(endings.values())))}")
        if not start.exists():
            return start


def ask_and_save(
    parent: QWidget, title: str, start: Path, kinds: str, content: Callable[[Path], bytes]
) -> None:
    """Ask for a file as `ask_save_file` does and write it, or say why it cannot be written.

    `content`: returns what is written, from the path chosen.
    """
    path = ask_save_file(parent, title, start, kinds)
    if path is None:
        return
    try:
        write_atomically(path, content(path))
    except OSError as error:
        show_warning(parent, title, tr("Not saved: {error}").format(error=error))
