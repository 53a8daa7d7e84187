"""A document written to disk: as a page, as a PDF, or as a folder with both and every picture."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from gsapp.foundation import GroundStationError, write_atomically
from gsapp.report.document import Document, ReportProgress, render_png
from gsapp.report.html_writer import render_html
from gsapp.report.pdf_writer import render_pdf


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
    document : Document
    out : Path
        A folder for ``report.html``, ``report.pdf`` and ``figures/*.png``; or one file that ends in
        ``.html`` or ``.pdf``.
    beside : mapping of str to bytes, optional
        Further files of a folder, by name.
    tell : callable, optional

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
    paper = render_pdf(document, tell=lambda share, words: tell(half + share * (1.0 - half), words))
    return {
        **{out / name: content for name, content in beside.items()},
        **figures,
        out / "report.pdf": paper,
        out / "report.html": render_html(document, images),
    }
