"""A document, a picture or its numbers as files: HTML, PDF, or a folder with both."""

from __future__ import annotations

import io
from base64 import b64encode
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gsapp.foundation import GroundStationError, write_atomically
from gsapp.foundation.delimited_text import delimited_text
from gsapp.quantities import typeset
from gsapp.report.document import (
    FIGURE_WIDTH,
    Document,
    DocumentFigure,
    DocumentTable,
    Paragraph,
    ReportProgress,
    figure_style,
    render_png,
)
from gsapp.report.pdf_writer import render_pdf

_METADATA = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
"""Without the hour of writing: the same picture gives the same bytes."""
_SEPARATORS = {".csv": ",", ".tsv": "\t"}


def render_html(document: Document, images: Mapping[str, bytes]) -> str:
    """Return a document as HTML.

    Parameters
    ----------
    images : mapping of str to bytes
        PNG of each picture by its name (`gsapp.report.document.render_png`).
    """
    template = _environment().get_template("document.html")
    return template.render(
        document=document, sources={name: data_uri(png) for name, png in images.items()}
    )


def data_uri(png: bytes) -> str:
    """Return a PNG as text that stands in place of its address."""
    return f"data:image/png;base64,{b64encode(png).decode('ascii')}"


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("gsapp.report"),
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    kinds = {Paragraph: "paragraph", DocumentTable: "table", DocumentFigure: "picture"}
    environment.filters["typeset"] = typeset
    environment.filters["kind_of_part"] = lambda part: kinds[type(part)]
    environment.globals["picture_width"] = FIGURE_WIDTH
    return environment


def export_figure(picture: DocumentFigure, ending: str) -> bytes:
    """Return a picture on white paper, or its numbers.

    Parameters
    ----------
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
        table = picture.numbers()
        return delimited_text([table.columns, *table.rows], _SEPARATORS[ending]).encode("utf-8")
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


def check_report_path(out: Path) -> None:
    """See that a report can be written there, before anything is worked out for it.

    Raises
    ------
    GroundStationError
        If a file has another ending than ``.html`` or ``.pdf``.
    """
    if out.suffix.casefold() not in ("", ".html", ".pdf") and not out.is_dir():
        raise GroundStationError(
            f"a report cannot be written as '{out.name}'; give a folder, or a file that ends in "
            ".html or .pdf"
        )


def is_folder_report(out: Path) -> bool:
    """Return whether a report there is a folder of files."""
    return out.is_dir() or not out.suffix


def write_document(
    document: Document,
    out: Path,
    *,
    beside: Mapping[str, bytes] | None = None,
    tell: ReportProgress | None = None,
) -> tuple[Path, ...]:
    """Write a document; each file whole or not at all.

    Everything is drawn before the first file is written: what is stopped leaves nothing behind.

    Parameters
    ----------
    out : Path
        A folder for ``report.html``, ``report.pdf`` and ``figures/*.png``; or one file that ends in
        ``.html`` or ``.pdf``.

    Returns
    -------
    tuple of Path
        The files written; in a folder the page comes last, so that where it is, all is.

    Raises
    ------
    GroundStationError
        If a file has another ending.
    OSError
        If the disk refuses.
    """
    check_report_path(out)
    contents = _rendered(document, out, beside or {}, tell or (lambda _share, _words: None))
    return tuple(write_atomically(path, content) for path, content in contents.items())


def _rendered(
    document: Document, out: Path, beside: Mapping[str, bytes], tell: ReportProgress
) -> dict[Path, bytes | str]:
    if out.suffix.casefold() == ".pdf":
        return {out: render_pdf(document, tell=tell)}
    folder = is_folder_report(out)
    # Pictures and pages of paper take about as long as each other.
    half = 0.5 if folder else 1.0
    images = {}
    for number, one in enumerate(document.figures):
        tell(half * number / len(document.figures), "drawing the figures")
        images[one.name] = render_png(one)
    if not folder:
        return {out: render_html(document, images)}
    figures = {
        out / "figures" / f"{number:02d}-{name}.png": png
        for number, (name, png) in enumerate(images.items(), start=1)
    }
    paper = render_pdf(document, tell=lambda share, text: tell(half + share * (1.0 - half), text))
    return {
        **{out / name: content for name, content in beside.items()},
        **figures,
        out / "report.pdf": paper,
        out / "report.html": render_html(document, images),
    }
