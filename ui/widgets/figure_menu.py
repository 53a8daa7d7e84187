"""The menu of a figure: copies and saves its picture and its numbers, and shows all of it again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from PySide6.QtCore import QBuffer, QMarginsF, QObject, QSizeF, Qt, Signal
from PySide6.QtGui import QAction, QGuiApplication, QImage, QPageSize, QPdfWriter
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QWidget

from gsapp.foundation import write_atomically
from ui.background_job import BackgroundJob
from ui.dialogs.file_dialogs import ask_save_file
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.message_boxes import show_warning

_KINDS = QT_TR_NOOP("Picture (*.png);;PDF (*.pdf);;Drawing (*.svg);;Numbers (*.csv)")
_EXACT = QPageSize.SizeMatchPolicy.ExactMatch
_POINTS_PER_INCH, _PIXELS_PER_INCH = 72.0, 96

ContentFunction = Callable[[], bytes]  # Makes the content of a file, in a thread.


class FigureMenu(QObject):
    """Adds the menu to the widget that shows a figure, whatever draws it.

    `content`: returns the `ContentFunction` for an ending: ``.png``, ``.pdf``, ``.svg``, or for the
    numbers ``.csv`` and ``.tsv``. Called only while the menu is enabled.
    """

    message_posted = Signal(str)  # What was copied or saved.

    def __init__(
        self,
        widget: QWidget,
        file: Callable[[], Path],
        content: Callable[[str], ContentFunction],
        reset: Callable[[], object],
    ) -> None:
        super().__init__(widget)
        self._widget = widget
        self._file = file
        self._content = content
        entries = (
            (tr("Copy picture"), self.copy_figure),
            (tr("Copy numbers"), self.copy_numbers),
            (tr("Save as…"), self.save_as),
            (tr("Reset zoom"), reset),
        )
        self._actions = [QAction(text, widget) for text, _ in entries]
        for action, (_, act) in zip(self._actions, entries, strict=True):
            action.triggered.connect(lambda _checked=False, act=act: act())
        self._actions[-1].setShortcut("Home")
        self._actions[-1].setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        widget.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        widget.addActions(self._actions)
        self.enable(False)

    def enable(self, is_drawn: bool) -> None:
        """Gray the menu where no figure is drawn."""
        for action in self._actions:
            action.setEnabled(is_drawn)

    def copy_figure(self) -> None:
        self._begin(tr("Copying the picture"), self._content(".png"), self._copied_picture)

    def _copied_picture(self, png: bytes) -> None:
        QGuiApplication.clipboard().setImage(QImage.fromData(png))
        self.message_posted.emit(tr("Picture copied."))

    def copy_numbers(self) -> None:
        self._begin(tr("Copying the numbers"), self._content(".tsv"), self._copied_numbers)

    def _copied_numbers(self, rows: bytes) -> None:
        QGuiApplication.clipboard().setText(rows.decode())
        self.message_posted.emit(tr("Numbers copied."))

    def save_as(self) -> None:
        """Ask for a file and save the figure there."""
        path = ask_save_file(self._widget, tr("Save the figure"), self._file(), tr(_KINDS))
        if path is not None:
            self.save(path)

    def save(self, path: Path) -> None:
        content = self._content(path.suffix.casefold())
        self._begin(
            tr("Saving the figure"),
            lambda: write_atomically(path, content()),
            lambda written: self.message_posted.emit(
                tr("Saved as {written}.").format(written=written)
            ),
        )

    def _begin(self, title: str, run: Callable[[], Any], done: Callable[[Any], None]) -> None:
        work = BackgroundJob(title, lambda _progress: run(), self)
        work.done.connect(done)
        work.failed.connect(
            lambda error: show_warning(
                self._widget, title, tr("{title} failed: {error}").format(title=title, error=error)
            )
        )
        work.start()


def render_widget(widget: QWidget, ending: str) -> bytes:
    """Return a widget as it looks, as SVG or PDF (vectors), else as PNG."""
    buffer = QBuffer()
    buffer.open(QBuffer.OpenModeFlag.WriteOnly)
    if ending == ".svg":
        drawing = QSvgGenerator()
        drawing.setOutputDevice(buffer)
        drawing.setSize(widget.size())
        drawing.setViewBox(widget.rect())
        widget.render(drawing)
    elif ending == ".pdf":
        page = QPdfWriter(buffer)
        page.setResolution(_PIXELS_PER_INCH)
        points = QSizeF(widget.size()) * _POINTS_PER_INCH / _PIXELS_PER_INCH
        page.setPageSize(QPageSize(points, QPageSize.Unit.Point, "", _EXACT))
        page.setPageMargins(QMarginsF())
        widget.render(page)
    else:
        widget.grab().save(buffer, "PNG")
    return bytes(buffer.data().data())
