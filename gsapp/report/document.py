"""What a report holds, apart from how it is printed: sections of paragraphs, tables, pictures.

Written once, a `Document` becomes a page for a browser (`gsapp.report.document_writer`) and
pages for paper (`gsapp.report.pdf_writer`).
"""

from __future__ import annotations

import contextlib
import io
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

from matplotlib import style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, FigureBase

from gsapp.quantities import convert_text_units
from gsapp.report.palette import PRINT_PALETTE, Palette

FIGURE_WIDTH = 7.1
"""Of every picture, inches: a sheet of A4 or Letter less its margins."""
MAX_FIGURE_HEIGHT = 9.6
"""Height of a picture that fills a page, inches."""

# Whatever the user's own matplotlibrc says, a report looks the same everywhere.
MATPLOTLIB_STYLE = (
    "default",
    {
        "font.family": "DejaVu Sans",
        "font.size": 8.0,
        "axes.titlesize": 8.5,
        "axes.labelsize": 8.0,
        "axes.linewidth": 0.6,
        "axes.axisbelow": True,
        "xtick.labelsize": 7.0,
        "ytick.labelsize": 7.0,
        "xtick.major.size": 2.0,
        "ytick.major.size": 2.0,
        "legend.fontsize": 7.5,
        "legend.frameon": False,
        "lines.linewidth": 0.9,
        # A dollar sign in a flight's name is no mathematics.
        "text.parse_math": False,
        # Symbols of channels and derivatives, which are, look like the text around them.
        "mathtext.default": "regular",
        "pdf.fonttype": 42,
        "path.simplify_threshold": 0.2,
        # Names of things in vector files are the same in every run.
        "svg.hashsalt": "gsapp",
    },
)

_DRAWING = threading.RLock()
"""Matplotlib keeps its look in one place for all threads: one draws at a time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Paragraph:
    """A few sentences."""

    text: str
    kind: Literal["plain", "lead", "note"] = "plain"
    """A lead is what to read if nothing else; a note is smaller."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DocumentTable:
    """Rows of text under headings."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""
    numeric: frozenset[int] = frozenset()
    """Columns that stand flush right."""

    def without_empty_columns(self) -> DocumentTable:
        """Return the table without the columns in which no row has text."""
        kept = [place for place in range(len(self.columns)) if any(row[place] for row in self.rows)]
        return replace(
            self,
            columns=tuple(self.columns[place] for place in kept),
            rows=tuple(tuple(row[place] for place in kept) for row in self.rows),
            numeric=frozenset(new for new, place in enumerate(kept) if place in self.numeric),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DocumentFigure:
    """A figure that has not been drawn yet."""

    name: str
    caption: str
    """What it shows, in words; stands below it."""
    height: float
    """Inches; at most `MAX_FIGURE_HEIGHT`."""
    draw: Callable[[FigureBase], None]
    """Draws into a figure or a part of one."""
    numbers: Callable[[], DocumentTable] | None = None
    """Returns the numbers that are drawn, in full, under headings with units; None for a picture
    that has none to give."""

    def to_figure(self, dpi: float = 150.0) -> Figure:
        """Return the figure as Matplotlib has it, drawn."""
        with figure_style():
            figure = Figure(figsize=(FIGURE_WIDTH, self.height), dpi=dpi)
            FigureCanvasAgg(figure)
            self.draw(figure)
        return figure

    def _repr_png_(self) -> bytes:
        return render_png(self)


DocumentPart = Paragraph | DocumentTable | DocumentFigure

ReportProgress = Callable[[float, str], None]
"""Told how far one is (0 to 1) and what comes next, in words; raises to stop."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DocumentSection:
    """A heading and what stands under it."""

    title: str
    parts: tuple[DocumentPart, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Document:
    """A report."""

    title: str
    sections: tuple[DocumentSection, ...]
    units: Literal["US", "SI"] = "US"
    """Decides the paper, too: Letter or A4."""
    facts: tuple[tuple[str, str], ...] = ()
    written: str = ""
    """When; the only line that differs between two reports on the same."""

    @property
    def figures(self) -> tuple[DocumentFigure, ...]:
        """Return all pictures in order."""
        return tuple(
            part
            for section in self.sections
            for part in section.parts
            if isinstance(part, DocumentFigure)
        )


def convert_units(document: Document, units: Literal["US", "SI"]) -> Document:
    """Return a document with the metric values of its sentences in a system of units."""

    def convert(part: DocumentPart) -> DocumentPart:
        if isinstance(part, Paragraph):
            return replace(part, text=convert_text_units(part.text, units))
        part = replace(part, caption=convert_text_units(part.caption, units))
        if isinstance(part, DocumentTable):
            rows = tuple(
                tuple(convert_text_units(cell, units) for cell in row) for row in part.rows
            )
            return replace(part, rows=rows)
        return part

    sections = tuple(
        replace(section, parts=tuple(convert(part) for part in section.parts))
        for section in document.sections
    )
    return replace(document, sections=sections, units=units)


@contextlib.contextmanager
def figure_style(palette: Palette = PRINT_PALETTE) -> Iterator[None]:
    """Draw in the look of the reports and the colors of a palette; one thread at a time."""
    colors = {
        "text.color": palette.ink,
        "axes.labelcolor": palette.ink,
        "axes.titlecolor": palette.ink,
        "axes.facecolor": palette.background,
        "axes.edgecolor": palette.faint,
        "axes.linewidth": 0.6 * palette.line_scale,
        "figure.facecolor": palette.background,
        "savefig.facecolor": palette.background,
        "lines.linewidth": 0.9 * palette.line_scale,
        "xtick.color": palette.ink,
        "ytick.color": palette.ink,
        "grid.color": palette.faint,
        "grid.linewidth": 0.4 * palette.line_scale,
    }
    with _DRAWING, style.context([*MATPLOTLIB_STYLE, colors]):
        yield


def render_png(picture: DocumentFigure, *, dpi: float = 150.0) -> bytes:
    """Return a picture as PNG; the same picture gives the same bytes."""
    with figure_style():
        content = io.BytesIO()
        picture.to_figure(dpi).savefig(content, format="png", metadata={"Software": None})
    return content.getvalue()


def set_margins(
    container: FigureBase,
    *,
    left: float = 0.6,
    right: float = 0.12,
    top: float = 0.3,
    bottom: float = 0.45,
    hspace: float = 0.25,
    wspace: float = 0.3,
) -> None:
    """Set the margins around the axes of a figure or a part of one, in inches.

    The spaces between axes are in heights and widths of an axes.
    """
    width = container.bbox.width / container.dpi  # type: ignore[attr-defined]
    height = container.bbox.height / container.dpi  # type: ignore[attr-defined]
    container.subplots_adjust(
        left=left / width, right=1.0 - right / width, top=1.0 - top / height,
        bottom=bottom / height, hspace=hspace, wspace=wspace,
    )  # fmt: skip
