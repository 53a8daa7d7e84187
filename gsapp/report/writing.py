"""A document written to disk: as a page, as a PDF, or as a folder with both and every picture."""

from __future__ import annotations

from pathlib import Path

from gsapp.foundation import GroundStationError, write_atomically
from gsapp.report.document import Document, picture_png
from gsapp.report.html import html_page
from gsapp.report.pdf import pdf_pages


def check_place(out: Path) -> None:
    """See that a report can be written there, before anything is worked out for it.

    Raises
    ------
    GroundStationError
        If a file has another ending than ``.html`` or ``.pdf``.
    """
    if out.suffix not in ("", ".html", ".pdf") and not out.is_dir():
        raise GroundStationError(
            f"a report cannot be written as '{out.name}'; give a folder, or a file that ends in "
            ".html or .pdf"
        )


def write_document(document: Document, out: Path) -> tuple[Path, ...]:
    """Write a document; each file whole or not at all.

    Parameters
    ----------
    document : Document
    out : Path
        A folder for ``report.html``, ``report.pdf`` and ``figures/*.png``; or one file that ends in
        ``.html`` or ``.pdf``.

    Returns
    -------
    tuple of Path
        The files written.

    Raises
    ------
    GroundStationError
        If a file has another ending.
    OSError
        If the disk refuses.
    """
    check_place(out)
    if out.suffix == ".pdf":
        return (write_atomically(out, pdf_pages(document)),)
    images = {one.name: picture_png(one) for one in document.pictures}
    if out.suffix == ".html":
        return (write_atomically(out, html_page(document, images)),)
    return (
        write_atomically(out / "report.html", html_page(document, images)),
        write_atomically(out / "report.pdf", pdf_pages(document)),
        *(
            write_atomically(out / "figures" / f"{number:02d}-{name}.png", png)
            for number, (name, png) in enumerate(images.items(), start=1)
        ),
    )
