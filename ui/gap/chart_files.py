"""A chart of the window as a file, or on the clipboard."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QBuffer, QMarginsF, QSizeF
from PySide6.QtGui import QAction, QGuiApplication, QPageSize, QPdfWriter
from PySide6.QtSvg import QSvgGenerator

from ui.dialogs.saving import save_file
from ui.table_menu import separated
from ui.words import file_name

if TYPE_CHECKING:
    from ui.gap.chart import Chart

_KINDS = "Picture (*.png);;Drawing (*.svg);;PDF (*.pdf);;Numbers (*.csv)"
_EXACT = QPageSize.SizeMatchPolicy.ExactMatch
_POINTS_PER_INCH, _PIXELS_PER_INCH = 72.0, 96


class ChartFiles:
    """Copies and saves a chart as it looks, or its numbers.

    Parameters
    ----------
    chart : Chart

    Attributes
    ----------
    actions : tuple of QAction
        For the menu of the chart.
    """

    def __init__(self, chart: Chart) -> None:
        self._chart = chart
        entries = (
            ("Copy picture", self.copy_picture),
            ("Copy numbers", self.copy_numbers),
            ("Save picture or numbers…", self.ask),
        )
        self.actions = tuple(QAction(words, chart) for words, _ in entries)
        for action, (_, act) in zip(self.actions, entries, strict=True):
            action.triggered.connect(act)

    def copy_picture(self) -> None:
        """Put the chart on the clipboard."""
        QGuiApplication.clipboard().setPixmap(self._chart.grab())

    def copy_numbers(self) -> None:
        """Put what is drawn on the clipboard, for a spreadsheet."""
        QGuiApplication.clipboard().setText(self._numbers("\t"))

    def _numbers(self, between: str) -> str:
        columns, rows = self._chart.table
        return separated([columns, *rows], between)

    def ask(self) -> None:
        """Ask for a file and save the chart there."""
        start = Path.home() / f"{file_name(self._chart.title.text()) or 'chart'}.png"
        save_file(self._chart, "Save the chart", start, _KINDS, self.content)

    def content(self, path: Path) -> bytes:
        """Return the chart, or its numbers, as a file by the ending of its name."""
        ending = path.suffix.casefold()
        return self._numbers(",").encode() if ending == ".csv" else self._picture(ending)

    def _picture(self, ending: str) -> bytes:
        """Return the chart as it looks, as SVG or PDF (vectors), else as PNG."""
        chart = self._chart
        buffer = QBuffer()
        buffer.open(QBuffer.OpenModeFlag.WriteOnly)
        if ending == ".svg":
            drawing = QSvgGenerator()
            drawing.setOutputDevice(buffer)
            drawing.setSize(chart.size())
            drawing.setViewBox(chart.rect())
            chart.render(drawing)
        elif ending == ".pdf":
            page = QPdfWriter(buffer)
            page.setResolution(_PIXELS_PER_INCH)
            points = QSizeF(chart.size()) * _POINTS_PER_INCH / _PIXELS_PER_INCH
            page.setPageSize(QPageSize(points, QPageSize.Unit.Point, "", _EXACT))
            page.setPageMargins(QMarginsF())
            chart.render(page)
        else:
            chart.grab().save(buffer, "PNG")
        return buffer.data().data()
