"""One picture, or its numbers, as a file."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gsapp.foundation import GroundStationError, write_atomically
from gsapp.report.document import WIDTH, Picture, Table, drawing, picture_png

_METADATA = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
"""Without the hour of writing: the same picture gives the same bytes."""


def save_picture(picture: Picture, path: Path) -> Path:
    """Write a picture on white paper, or its numbers.

    Parameters
    ----------
    picture : Picture
    path : Path
        Ends in ``.png``, ``.pdf`` or ``.svg`` for the picture, in ``.csv`` for its numbers.

    Returns
    -------
    Path
        The file written, whole or not at all.

    Raises
    ------
    GroundStationError
        If the ending is another, or the picture has no numbers.
    OSError
        If the disk refuses.
    """
    kind = path.suffix.casefold()
    if kind == ".png":
        return write_atomically(path, picture_png(picture))
    if kind == ".csv":
        if picture.numbers is None:
            raise GroundStationError(
                f"the picture '{picture.name}' has no numbers to write; save it as .png, .pdf or "
                ".svg"
            )
        return write_atomically(path, separated(picture.numbers(), ",").encode("utf-8"))
    if kind not in _METADATA:
        raise GroundStationError(
            f"a picture cannot be written as '{path.name}'; give a name that ends in .png, .pdf, "
            ".svg, or .csv for its numbers"
        )
    with drawing():
        figure = Figure(figsize=(WIDTH, picture.height))
        FigureCanvasAgg(figure)
        picture.draw(figure)
        content = io.BytesIO()
        figure.savefig(content, format=kind[1:], metadata=_METADATA[kind])
    return write_atomically(path, content.getvalue())


def separated(table: Table, between: str) -> str:
    """Return a table as lines of text: separated by commas for a file, by tabs for a clipboard."""
    lines = io.StringIO()
    writer = csv.writer(lines, delimiter=between, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows(table.rows)
    return lines.getvalue()
