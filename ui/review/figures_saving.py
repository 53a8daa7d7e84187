"""A figure on paper: saved as a file, or copied with its numbers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QGuiApplication, QImage
from PySide6.QtWidgets import QWidget

from ui.dialogs.saving import file_to_write
from ui.review.figure_drawing import Room
from ui.review.figures_kinds import FigureKind
from ui.review.figures_material import Material
from ui.settings import SettingsStore, first_folder
from ui.work import Progress, Work

if TYPE_CHECKING:
    from gsapp.report.document import Picture

_KINDS = "Picture (*.png);;Pages for print (*.pdf);;Drawing (*.svg);;Numbers shown (*.csv)"
_COPY_DPI = 200.0


def on_paper(kind: FigureKind, material: Material) -> Picture | str:
    """Return a figure as the report prints it."""
    from gsapp.report.document import WIDTH
    from gsapp.report.palette import PAPER

    return kind.make(material, PAPER, Room(width=WIDTH, height=0.0))


class FigureSaver(QObject):
    """Saves and copies figures as the report prints them, in a thread.

    Parameters
    ----------
    store : SettingsStore
        Remembers the folder.
    parent : QWidget
        Of the dialog.

    Attributes
    ----------
    told : Signal(str)
        What was done, or why not.
    """

    told = Signal(str)

    def __init__(self, store: SettingsStore, parent: QWidget) -> None:
        super().__init__(parent)
        self._store = store
        self._window = parent
        self._work: Work | None = None

    def ask(self, make: Callable[[], Any] | None) -> None:
        """Ask for a file and save the figure there, or its numbers."""
        if make is None:
            return
        start = first_folder(self._store.current) / "figure.png"
        path = file_to_write(self._window, "Save the figure", start, _KINDS)
        if path is not None:
            self.save(make, path)

    def save(self, make: Callable[[], Any], path: Path) -> None:
        """Save the figure, or its numbers, by the ending of the name."""

        def run(_progress: Progress) -> Path:
            from gsapp.report.picture_files import save_picture

            return save_picture(make(), path)

        self._begin("Saving the figure", run, lambda found: self.told.emit(f"Saved as {found}."))

    def copy(self, make: Callable[[], Any] | None) -> None:
        """Put the figure and its numbers on the clipboard."""
        if make is None:
            return

        def run(_progress: Progress) -> tuple[bytes, str]:
            from gsapp.report.document import picture_png
            from gsapp.report.picture_files import separated

            picture = make()
            numbers = "" if picture.numbers is None else separated(picture.numbers(), "\t")
            return picture_png(picture, dpi=_COPY_DPI), numbers

        self._begin("Copying the figure", run, self._copied)

    def _begin(
        self, title: str, run: Callable[[Progress], Any], done: Callable[[Any], None]
    ) -> None:
        work = Work(title, run, self)
        work.done.connect(done)
        work.failed.connect(lambda error: self.told.emit(f"{title} failed: {error}"))
        self._work = work
        work.start()

    def _copied(self, found: tuple[bytes, str]) -> None:
        png, numbers = found
        clipboard = QGuiApplication.clipboard()
        clipboard.setImage(QImage.fromData(png, "PNG"))
        if numbers:
            # Into what Qt made: content made here would be given back after Python has ended.
            clipboard.mimeData().setText(numbers)
        self.told.emit("The figure is on the clipboard, with its numbers as text.")
