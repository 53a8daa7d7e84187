"""A document as pages of Letter or A4: text that flows, tables that break, pictures as vectors."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D
from matplotlib.textpath import TextToPath

from gsapp.quantities import typeset
from gsapp.report.document import (
    FIGURE_WIDTH,
    Document,
    DocumentFigure,
    DocumentTable,
    Paragraph,
    ReportProgress,
    figure_style,
)
from gsapp.report.strip_figure import FAINT, INK

_LEAST_PICTURE = 1.0
"""Height to which a picture may shrink to make room for its caption, inches."""
_POINT = 1.0 / 72.0
_QUIET = "#4a525d"
_LEADING = 1.38
_TYPESETTING_SHARE = 0.4
"""Share of the time that it takes to set all pages; printing them takes the rest."""
_UNDER_HEADING = 0.95
"""Inches that a heading and the first lines of a caption take."""
_GUTTER, _BETWEEN = 0.16, 0.03
"""Between columns and between rows of a table, inches."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Paper:
    """A sheet with its margins, inches."""

    width: float
    height: float
    top: float
    bottom: float

    @property
    def side(self) -> float:
        return (self.width - FIGURE_WIDTH) / 2.0

    @property
    def room(self) -> float:
        return self.height - self.top - self.bottom


_PAPERS = {
    "US": _Paper(width=8.5, height=11.0, top=0.4, bottom=0.55),
    "SI": _Paper(width=8.27, height=11.69, top=0.75, bottom=0.85),
}
"""Letter and A4, by system of units."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _TextStyle:
    """A size and weight of text, points."""

    size: float
    bold: bool = False
    color: str = INK

    @property
    def line(self) -> float:
        """Return the height of a line, inches."""
        return self.size * _LEADING * _POINT


_TITLE = _TextStyle(size=17.0, bold=True)
_HEADING = _TextStyle(size=12.5, bold=True)
_BODY = _TextStyle(size=9.0)
_CELL = _TextStyle(size=7.6)
_HEAD = _TextStyle(size=7.6, bold=True)
_NOTE = _TextStyle(size=7.8, color=_QUIET)
_FOOT = _TextStyle(size=7.0, color=_QUIET)
_FOOT_HEIGHT = 0.45
"""Of the last line of a page over its lower edge, inches."""
_KINDS = {"plain": _BODY, "lead": _TextStyle(size=10.5, bold=True), "note": _NOTE}


def render_pdf(document: Document, *, tell: ReportProgress | None = None) -> bytes:
    """Return a document as PDF."""
    said = tell or (lambda _share, _words: None)
    with figure_style():
        flow = _PageFlow(_PAPERS[document.units])
        flow.text(document.title, _TITLE)
        if document.written:
            flow.text(f"Written {document.written}", _NOTE)
        flow.space(0.08)
        for label, value in document.facts:
            flow.text(f"{label}: {value}", _BODY)
        for index, section in enumerate(document.sections):
            said(_TYPESETTING_SHARE * index / len(document.sections), "laying out the pages")
            first = section.parts[0] if section.parts else None
            flow.heading(
                section.title, before=first.height if isinstance(first, DocumentFigure) else 0.0
            )
            for part in section.parts:
                if isinstance(part, Paragraph):
                    flow.text(part.text, _KINDS[part.kind])
                    flow.space(0.07)
                elif isinstance(part, DocumentTable):
                    flow.table(part)
                else:
                    flow.picture(part)
        return flow.finish(
            document.title,
            lambda share: said(
                _TYPESETTING_SHARE + (1.0 - _TYPESETTING_SHARE) * share, "writing the PDF"
            ),
        )


class _PageText(Artist):
    """The lines of text of a page.

    Their places are known; a `matplotlib.text.Text` for each would measure it anew.
    """

    def __init__(self) -> None:
        super().__init__()
        self._lines: list[tuple[float, float, str, _TextStyle]] = []

    def add(self, x: float, y: float, text: str, kind: _TextStyle) -> None:
        """Add a line whose baseline starts `x`, `y` from the lower left corner, inches."""
        self._lines.append((x, y, text, kind))

    def draw(self, renderer: RendererBase) -> None:
        """Draw all lines."""
        for kind in dict.fromkeys(kind for *_, kind in self._lines):
            gc = renderer.new_gc()
            gc.set_foreground(to_rgba(kind.color), isRGBA=True)
            font = _font(kind.size, kind.bold)
            for x, y, text, its_kind in self._lines:
                if its_kind == kind:
                    # The PDF backend counts in points.
                    renderer.draw_text(gc, x / _POINT, y / _POINT, text, font, 0.0)
            gc.restore()


class _PageFlow:
    """Pages that fill from top to bottom."""

    def __init__(self, paper: _Paper) -> None:
        self._paper = paper
        self._pages: list[Figure] = []
        self._text = _PageText()
        self._y = 0.0
        self._new_page()

    def space(self, inches: float) -> None:
        """Leave a gap, unless at the top of a page."""
        if self._y > self._paper.top:
            self._y += inches

    def heading(self, title: str, *, before: float = 0.0) -> None:
        """Begin a section; a heading never stands alone at the foot of a page.

        Parameters
        ----------
        before : float
            Height of a picture that follows at once, inches.
        """
        self._need(max(1.6, min(before + _UNDER_HEADING, self._paper.room)))
        self.space(0.2)
        self.text(title, _HEADING)
        self._rule(0.0, FIGURE_WIDTH)
        self._y += 0.09

    def text(self, text: str, kind: _TextStyle) -> None:
        """Set a paragraph."""
        for line in _wrapped(text, kind, FIGURE_WIDTH):
            self._need(kind.line)
            self._put(line, 0.0, kind)
            self._y += kind.line

    def table(self, table: DocumentTable) -> None:
        """Set a table; the headings come again on every page."""
        widths = _column_widths(table)
        cells = [
            [_wrapped(cell, _CELL, width) for cell, width in zip(row, widths, strict=True)]
            for row in table.rows
        ]
        # Caption, headings and a row or two stay together.
        self._need(4.0 * _CELL.line + 0.3)
        if table.caption:
            self.text(typeset(table.caption), _TextStyle(size=8.6, bold=True))
            self._y += 0.02
        self._table_head(table, widths)
        for row in cells:
            height = max((len(lines) for lines in row), default=1) * _CELL.line + _BETWEEN
            if self._need(height):
                self._table_head(table, widths)
            self._row(row, widths, table.numeric, _CELL)
            self._y += height
        self._y += 0.16

    def picture(self, picture: DocumentFigure) -> None:
        """Set a picture with its caption below, both on one page."""
        caption = _wrapped(typeset(picture.caption), _NOTE, FIGURE_WIDTH)
        beside = len(caption) * _NOTE.line
        high = max(min(picture.height, self._paper.room - beside), _LEAST_PICTURE)
        self._need(high + beside)
        # A part of a figure fills a cell of a grid; the cells around it are the margins.
        grid = GridSpec(
            3, 3,
            height_ratios=(self._y, high, self._paper.height - self._y - high),
            width_ratios=(self._paper.side, FIGURE_WIDTH, self._paper.side),
        )  # fmt: skip
        picture.draw(self._page.add_subfigure(grid[1, 1]))
        self._y += high + 0.03
        for line in caption:
            self._put(line, 0.0, _NOTE)
            self._y += _NOTE.line
        self._y += 0.14

    def finish(self, title: str, tell: Callable[[float], None]) -> bytes:
        """Write all pages, with numbers; `tell` hears how far one is."""
        content = io.BytesIO()
        with PdfPages(content, metadata={"Title": title, "CreationDate": None}) as pages:
            for number, page in enumerate(self._pages, start=1):
                tell((number - 1) / len(self._pages))
                foot = _PageText()
                place = f"{number} of {len(self._pages)}"
                right = self._paper.width - self._paper.side - _width(place, _FOOT)
                foot.add(self._paper.side, _FOOT_HEIGHT, title, _FOOT)
                foot.add(right, _FOOT_HEIGHT, place, _FOOT)
                page.add_artist(foot)
                pages.savefig(page)
        return content.getvalue()

    @property
    def _page(self) -> Figure:
        return self._pages[-1]

    def _new_page(self) -> None:
        page = Figure(figsize=(self._paper.width, self._paper.height), facecolor="white")
        FigureCanvasPdf(page)
        self._pages.append(page)
        self._text = _PageText()
        page.add_artist(self._text)
        self._y = self._paper.top

    def _need(self, height: float) -> bool:
        """Turn the page if so much does not fit; return whether it was turned."""
        if (
            self._y + height <= self._paper.height - self._paper.bottom
            or self._y <= self._paper.top
        ):
            return False
        self._new_page()
        return True

    def _put(self, text: str, x: float, kind: _TextStyle, *, right: bool = False) -> None:
        start = self._paper.side + x - (_width(text, kind) if right else 0.0)
        self._text.add(start, self._paper.height - self._y - 0.78 * kind.line, text, kind)

    def _rule(self, start: float, stop: float) -> None:
        y = 1.0 - self._y / self._paper.height
        ends = [
            (self._paper.side + start) / self._paper.width,
            (self._paper.side + stop) / self._paper.width,
        ]
        self._page.add_artist(Line2D(ends, [y, y], color=FAINT, linewidth=0.6))

    def _table_head(self, table: DocumentTable, widths: Sequence[float]) -> None:
        heads = [
            _wrapped(name, _HEAD, width) for name, width in zip(table.columns, widths, strict=True)
        ]
        if any(table.columns):
            self._row(heads, widths, table.numeric, _HEAD)
            self._y += max(len(lines) for lines in heads) * _HEAD.line
        self._rule(0.0, sum(widths) + _GUTTER * (len(widths) - 1))
        self._y += 0.03

    def _row(
        self,
        cells: Sequence[Sequence[str]],
        widths: Sequence[float],
        numeric: frozenset[int],
        kind: _TextStyle,
    ) -> None:
        start, x = self._y, 0.0
        for index, (lines, width) in enumerate(zip(cells, widths, strict=True)):
            right = index in numeric
            for line in lines:
                self._put(line, x + width if right else x, kind, right=right)
                self._y += kind.line
            self._y = start
            x += width + _GUTTER


def _column_widths(table: DocumentTable) -> list[float]:
    """Return widths in inches: what the cells need, less where that is more than the page.

    The widest columns give way, and break their lines, to a common width; no word is cut for it
    unless the words alone are wider than the page.
    """
    cells = [
        [(name, _HEAD), *((row[place], _CELL) for row in table.rows)]
        for place, name in enumerate(table.columns)
    ]
    needs = np.array([max(_width(*cell) for cell in column) + 0.01 for column in cells])
    words = np.array(
        [
            max((_width(word, kind) for text, kind in column for word in text.split()), default=0.0)
            + 0.01
            for column in cells
        ]
    )
    room = FIGURE_WIDTH - _GUTTER * (len(cells) - 1)
    if needs.sum() <= room:
        return list(needs)
    least = words if words.sum() <= room else np.zeros_like(words)
    low, high = 0.0, room
    for _ in range(40):
        width = 0.5 * (low + high)
        fits = np.clip(width, least, needs).sum() <= room
        low, high = (width, high) if fits else (low, width)
    return list(np.clip(low, least, needs))


def _wrapped(text: str, kind: _TextStyle, width: float) -> list[str]:
    """Break a text into lines of a width in inches; a word that is too long is cut."""
    lines: list[str] = []
    current = ""
    for word in text.split():
        longer = f"{current} {word}" if current else word
        if _width(longer, kind) <= width:
            current = longer
            continue
        if current:
            lines.append(current)
        current = word
        while _width(current, kind) > width:
            fits = max(1, int(len(current) * width / _width(current, kind)))
            lines.append(current[:fits])
            current = current[fits:]
    return [*lines, current] if current or not lines else lines


@lru_cache(maxsize=20_000)
def _measure(text: str, size: float, bold: bool) -> float:
    font = _font(size, bold)
    return float(TextToPath().get_text_width_height_descent(text, font, ismath=False)[0])


@lru_cache(maxsize=100)
def _font(size: float, bold: bool) -> FontProperties:
    return FontProperties(family="DejaVu Sans", weight="bold" if bold else "normal", size=size)


def _width(text: str, kind: _TextStyle) -> float:
    # Word by word: few of them are new, while no two lines are alike.
    words = text.split(" ")
    space = _measure(" ", kind.size, kind.bold) * (len(words) - 1)
    return (sum(_measure(word, kind.size, kind.bold) for word in words) + space) * _POINT
