"""A document as one HTML file that needs nothing else: pictures and style are inside."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from gsapp.quantities import typeset
from gsapp.report.document import FIGURE_WIDTH, Document, DocumentFigure, DocumentTable, Paragraph


def render_html(document: Document, images: Mapping[str, bytes]) -> str:
    """Return a document as HTML.

    Parameters
    ----------
    document : Document
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
