"""One picture, or its numbers, as the content of a file."""

from __future__ import annotations

import csv
import io

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gsapp.foundation import GroundStationError
from gsapp.report.document import (
    FIGURE_WIDTH,
    DocumentFigure,
    DocumentTable,
    figure_style,
    render_png,
)

_METADATA = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
"""Without the hour of writing: the same picture gives the same bytes."""
_SEPARATORS = {".csv": ",", ".tsv": "\t"}


def export_figure(picture: DocumentFigure, ending: str) -> bytes:
    """Return a picture on white paper, or its numbers.

    Parameters
    ----------
    picture : DocumentFigure
    ending : str
        ``.png``, ``.pdf`` or ``.svg`` for the picture; for its numbers ``.csv``, or ``.tsv`` with
        tabs.

    Raises
    ------
    GroundStationError
        If the ending is another, or the picture has no numbers.
    """
    if ending == ".png":
        return render_png(picture)
    if ending in _SEPARATORS:
        if picture.numbers is None:
            raise GroundStationError(
                f"the picture '{picture.name}' has no numbers; save it as .png, .pdf or .svg"
            )
        return format_delimited_table(picture.numbers(), _SEPARATORS[ending]).encode("utf-8")
    if ending not in _METADATA:
        raise GroundStationError(
            f"a figure cannot be written as '{ending}'; give a name that ends in .png, .pdf, "
            ".svg, or .csv for its numbers"
        )
    with figure_style():
        figure = Figure(figsize=(FIGURE_WIDTH, picture.height))
        FigureCanvasAgg(figure)
        picture.draw(figure)
        content = io.BytesIO()
        figure.savefig(content, format=ending[1:], metadata=_METADATA[ending])
    return content.getvalue()


def format_delimited_table(table: DocumentTable, between: str) -> str:
    """Return a table as lines of text: separated by commas for a file, by tabs for a clipboard."""
    lines = io.StringIO()
    writer = csv.writer(lines, delimiter=between, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows(table.rows)
    return lines.getvalue()
