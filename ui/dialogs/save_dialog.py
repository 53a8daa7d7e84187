"""Asking for a file to be written."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from gsapp.foundation import write_atomically
from ui.disk_checks import nearest_folder
from ui.translation import tr


def ask_save_file(parent: QWidget | None, title: str, start: Path, kinds: str) -> Path | None:
    """Ask for a file to be written, and give it the ending of its kind if it has none.

    The dialog of Windows adds the ending by itself, others do not; what is called without is not
    found again by a dialog that opens files of this kind. A file that then has the name already is
    only replaced if the user says so.

    Parameters
    ----------
    kinds : str
        As Qt writes them, one ending each: ``Picture (*.png);;Drawing (*.svg)``.
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

    Parameters
    ----------
    content : callable
        Returns what is written, from the path chosen.
    """
    path = ask_save_file(parent, title, start, kinds)
    if path is None:
        return
    try:
        write_atomically(path, content(path))
    except OSError as error:
        QMessageBox.warning(parent, title, tr("Not saved: {error}").format(error=error))
