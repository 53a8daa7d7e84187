"""The report on a missing effect: complete, self-contained, readable, and the same every time."""

import base64
import itertools
import re
from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from io import StringIO
from pathlib import Path
from typing import get_args
from unittest.mock import patch

import numpy as np
import pytest
from matplotlib import style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, FigureBase
from matplotlib.text import Text

from gsapp.cli._console import PlainConsole
from gsapp.cli._discrepancy_text import print_discrepancy
from gsapp.discrepancy.results import DiscrepancyVerdict
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.flight.provenance import hash_input_file
from gsapp.foundation import GroundStationError
from gsapp.report.discrepancy_report import discrepancy_document, write_discrepancy_report
from gsapp.report.discrepancy_text import HEADLINES, residual_map
from gsapp.report.document import (
    FIGURE_WIDTH,
    MATPLOTLIB_STYLE,
    MAX_FIGURE_HEIGHT,
    Document,
    DocumentFigure,
    DocumentSection,
    DocumentTable,
    Paragraph,
    render_png,
)
from gsapp.report.document_writer import render_html, write_document
from gsapp.report.pdf_writer import render_pdf
from gsapp.report.provenance import search_provenance
from tests.report.discrepancy_kit import adequate, answer

NOON = datetime(2026, 5, 12, 12, 0, tzinfo=UTC)


class Page(HTMLParser):
    """What a browser would find: text, addresses, and whether tags close in order."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.text = ""
        self.addresses: list[str] = []
        self.headings: list[str] = []
        self.open: list[str] = []
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in ("meta", "img", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text += f" {data.strip()}"
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)


@pytest.fixture(scope="module")
def small() -> Document:
    found = answer(maneuvers=3, samples=60)
    return discrepancy_document(found, overlays=["3"])


def page_of(document: Document) -> str:
    return render_html(document, {one.name: b"\x89PNG" for one in document.figures})


def test_a_folder_gets_html_pdf_and_every_picture(tmp_path: Path) -> None:
    found = answer(maneuvers=3, samples=60)
    paths = write_discrepancy_report(found, tmp_path, overlays=[], written=NOON)
    assert sorted(path for path in tmp_path.rglob("*") if path.is_file()) == sorted(paths)
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert page.open == []
    # Self-contained: every address is the picture itself, the same as the file beside it.
    files = sorted((tmp_path / "figures").glob("*.png"))
    assert [base64.b64decode(one.partition(",")[2]) for one in page.addresses] == [
        path.read_bytes() for path in files
    ]
    assert all(one.startswith("data:image/png;base64,") for one in page.addresses)
    pdf = (tmp_path / "report.pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", pdf)) >= 4


def test_same_answer_gives_the_same_page_but_for_its_date(small: Document) -> None:
    later = replace(small, written="2030-01-01 00:00 UTC")
    first, second = page_of(replace(small, written="2026-05-12 12:00 UTC")), page_of(later)
    differing = [
        (one, other)
        for one, other in zip(first.splitlines(), second.splitlines(), strict=True)
        if one != other
    ]
    assert len(differing) == 1
    assert "2026-05-12 12:00 UTC" in differing[0][0]
    picture = small.figures[0]
    assert render_png(picture) == render_png(picture)


def test_the_story_has_four_steps_and_says_what_was_found(small: Document) -> None:
    page = Page(page_of(small))
    steps = [title for title in page.headings if title[0].isdigit()]
    assert [title.partition(":")[0] for title in steps] == [
        "1. Find",
        "2. Name",
        "3. Add",
        "4. Show",
    ]
    for text in (
        "The model lacks a named effect.",
        "arm = 0.1617 ± 0.0069 ft; confidence 97 %",
        "forced",
        "94 ± 3 % of the gap was closed",
        "gusts of 1.0 ± 0.13 ft/s",
        "a_y reads 0.02 g high",
        "weigh the aircraft on two scales",
        "q was clipped",
    ):
        assert text in page.text, text


@pytest.mark.parametrize("verdict", get_args(DiscrepancyVerdict))
def test_every_verdict_is_told_in_words(verdict: DiscrepancyVerdict) -> None:
    found = replace(answer(maneuvers=3, samples=60), verdict=verdict)
    page = Page(page_of(discrepancy_document(found, overlays=[])))
    console = PlainConsole(width=100, file=StringIO())
    print_discrepancy(console, found)
    for text in (page.text, console.file.getvalue()):
        assert HEADLINES[verdict] in text
        assert verdict not in text
    assert len(set(HEADLINES.values())) == len(HEADLINES)


def test_what_could_not_show_stands_apart_with_what_to_fly(small: Document) -> None:
    (section,) = (one for one in small.sections if one.title == "Observability")
    clear, faint = (part for part in section.parts if isinstance(part, DocumentTable))
    assert clear.rows == (("propulsion.Cm.throttle", "A", "22", "aero.Cm.speed (0.71)"),)
    assert faint.rows == (("aero.Cm.flap (A)", "an elevator doublet with the flap at 20 deg"),)


def test_nothing_found_is_a_whole_report_too(tmp_path: Path) -> None:
    found = adequate()
    (path,) = write_discrepancy_report(found, tmp_path / "a.html", overlays=[])
    page = Page(path.read_text(encoding="utf-8"))
    assert "adequate" in page.text
    assert "after" not in page.text.partition("4. Show")[2].partition("Observability")[0]
    assert "None" not in page.text
    assert "nan" not in page.text


def test_names_of_strangers_are_text_and_not_markup() -> None:
    found = answer(maneuvers=2, samples=60)
    odd = "<script>alert(1)</script> $x^{2$"
    views = tuple(replace(one, flight=odd) for one in found.maneuvers)
    document = discrepancy_document(replace(found, maneuvers=views), overlays=["1"])
    html = page_of(document)
    assert "<script" not in html
    assert odd in Page(html).text
    (section,) = (one for one in document.sections if one.title.startswith("4."))
    drawn = replace(document, sections=(replace(section, parts=section.parts[-1:]),))
    assert render_pdf(drawn).startswith(b"%PDF")


def test_only_known_maneuvers_and_endings_are_taken(tmp_path: Path) -> None:
    found = answer(maneuvers=2, samples=60)
    with pytest.raises(GroundStationError, match="no maneuver '9'"):
        discrepancy_document(found, overlays=["9"])
    with pytest.raises(GroundStationError, match=r"\.html or \.pdf"):
        write_discrepancy_report(found, tmp_path / "a.doc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "begin"), [("A.PDF", b"%PDF"), ("a.Html", b"<!DOCTYPE html>")])
def test_an_ending_may_be_written_in_capitals(tmp_path: Path, name: str, begin: bytes) -> None:
    document = Document(
        title="t", sections=(DocumentSection(title="s", parts=(Paragraph(text="p"),)),)
    )
    (path,) = write_document(document, tmp_path / name)
    assert path.read_bytes().startswith(begin)


def test_the_map_of_channels_is_measured_less_computed_over_the_noise() -> None:
    """Noise alone gives 1, the part that the model lacks stands out in its channel alone."""
    found = answer(maneuvers=3, samples=600)
    before, after = residual_map(found, 0), residual_map(found, -1)
    assert before.shape == (3, len(found.channels))
    q = found.channels.index("q")
    assert (before[:, q] > 3.0).all()
    others = [place for place in range(len(found.channels)) if place != q]
    assert before[:, others] == pytest.approx(np.ones((3, len(others))), abs=0.12)
    assert after == pytest.approx(np.ones(after.shape), abs=0.12)
    few = replace(
        found.maneuvers[0], channels=("alpha",), measured=found.maneuvers[0].measured[:, :1]
    )
    lacking = residual_map(replace(found, maneuvers=(few,)), 0)
    assert np.isnan(lacking[0, 1:]).all()


def test_maneuvers_drawn_are_those_kept_out_that_were_worst() -> None:
    found = answer(maneuvers=12, samples=60)
    document = discrepancy_document(found)
    drawn = [one.name for one in document.figures if one.name.startswith("overlay")]
    assert drawn == ["overlay-6", "overlay-9", "overlay-12"]


def test_no_text_of_a_picture_overlaps_another_or_leaves_the_sheet() -> None:
    found = answer(maneuvers=4, samples=120)
    document = discrepancy_document(found, overlays=["3"])
    for picture in document.figures:
        assert 1.0 < picture.height <= MAX_FIGURE_HEIGHT
        assert clashes(picture) == [], picture.name


def test_the_overlap_check_sees_an_overlap() -> None:
    def draw(container: FigureBase) -> None:
        container.text(0.5, 0.5, "one")
        container.text(0.51, 0.5, "two")
        container.text(0.99, 0.2, "beyond")

    told = clashes(DocumentFigure(name="bad", caption="", height=2.0, draw=draw))
    assert told == ["'beyond' leaves the sheet", "'one' on 'two'"]


def clashes(picture: DocumentFigure) -> list[str]:
    """Return the texts of a picture, as really drawn, that overlap or leave it."""
    drawn: dict[int, Text] = {}
    draw = Text.draw

    def note(text: Text, renderer: object) -> None:
        if text.get_visible() and text.get_text().strip():
            drawn[id(text)] = text
        draw(text, renderer)

    with style.context(list(MATPLOTLIB_STYLE)), patch.object(Text, "draw", note):
        figure = Figure(figsize=(FIGURE_WIDTH, picture.height), dpi=100.0)
        canvas = FigureCanvasAgg(figure)
        picture.draw(figure)
        canvas.draw()
        boxes = [(text.get_text(), text.get_window_extent()) for text in drawn.values()]
    assert boxes
    sheet = figure.bbox
    found = [
        f"{words!r} leaves the sheet"
        for words, box in boxes
        if box.x0 < -1 or box.y0 < -1 or box.x1 > sheet.x1 + 1 or box.y1 > sheet.y1 + 1
    ]
    for (words, box), (others, other) in itertools.combinations(boxes, 2):
        wide = min(box.x1, other.x1) - max(box.x0, other.x0)
        high = min(box.y1, other.y1) - max(box.y0, other.y0)
        if wide > 1.0 and high > 1.0:
            found.append(f"{words!r} on {others!r}")
    return found


def test_a_long_table_breaks_and_keeps_every_row() -> None:
    rows = tuple((f"row {number}", "x" * 300, f"{number}") for number in range(60))
    table = DocumentTable(columns=("a", "b", "c"), rows=rows, numeric=frozenset({2}))
    document = Document(
        title="t", sections=(DocumentSection(title="s", parts=(Paragraph(text="p"), table)),)
    )
    pdf = render_pdf(document)
    assert len(re.findall(rb"/Type /Page\b", pdf)) >= 3
    assert Page(page_of(document)).text.count("x" * 300) == 60


def test_a_hash_tells_content_and_not_caches(tmp_path: Path) -> None:
    folder = tmp_path / "flight"
    (folder / "cache").mkdir(parents=True)
    (folder / "raw.tlog").write_bytes(b"abc")
    (folder / "cache" / "block.npy").write_bytes(b"1")
    first = hash_input_file("flight", folder)
    (folder / "cache" / "block.npy").write_bytes(b"2")
    assert hash_input_file("flight", folder) == first
    (folder / "raw.tlog").write_bytes(b"abd")
    assert hash_input_file("flight", folder).sha256 != first.sha256
    # The sum of a file is the one that everybody's tools give.
    known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    (tmp_path / "file").write_bytes(b"abc")
    assert hash_input_file("model", tmp_path / "file", name="b777").sha256 == known


def test_the_last_page_says_what_went_in(tmp_path: Path) -> None:
    (tmp_path / "day.csv").write_bytes(b"abc")
    settings = DiscrepancySettings(
        model="b777", maneuver_windows=("2:12",), refused=("aero.Cm.speed",),
        forced=("propulsion.Cm.throttle",),
    )  # fmt: skip
    made = search_provenance([tmp_path / "day.csv"], settings)
    assert [(one.role, one.name) for one in made.inputs] == [
        ("flight", str(tmp_path / "day.csv")), ("model", "b777"),
    ]  # fmt: skip
    found = answer(maneuvers=2, samples=60)
    text = Page(page_of(discrepancy_document(found, provenance=made, overlays=[]))).text
    for words in (
        "2:12",
        "aero.Cm.speed",
        "propulsion.Cm.throttle",
        "numpy",
        made.inputs[1].sha256,
    ):
        assert words in text, words
    without = discrepancy_document(found, overlays=[])
    assert "made from" not in " ".join(one.title for one in without.sections)


def test_missing_samples_and_runaway_models_leave_gaps_and_no_errors() -> None:
    """A channel without a sample is left out, a cell without a number is a dash, no axis explodes.

    The model before may run away to infinity in a maneuver; measured is still seen beside it.
    """
    found = answer(maneuvers=2, samples=80)
    view = found.maneuvers[0]
    measured, computed = view.measured.copy(), view.computed[0].copy()
    measured[:, 0] = np.nan
    computed[:, 2] = np.exp(np.linspace(0.0, 700.0, 80))
    computed[-1, 2] = np.inf
    odd = np.full_like(found.steps[0].coefficient_map, np.nan)
    odd[0, 1] = np.inf
    changed = discrepancy_document(
        replace(
            found,
            maneuvers=(
                replace(view, measured=measured, computed=(computed, *view.computed[1:])),
                found.maneuvers[1],
            ),
            steps=(replace(found.steps[0], coefficient_map=odd), *found.steps[1:]),
        ),
        overlays=["1"],
    )
    whole = discrepancy_document(found, overlays=["1"])
    overlay = changed.figures[-1]
    assert overlay.height < whole.figures[-1].height
    assert clashes(changed.figures[0]) == []
    with style.context(list(MATPLOTLIB_STYLE)):
        figure = Figure(figsize=(FIGURE_WIDTH, overlay.height))
        overlay.draw(figure)
    an = measured[:, 2] / 9.80665
    left, right = figure.axes[2:4]
    assert left.get_ylabel().startswith("$a_{n}$")
    for chart in (left, right):
        assert np.ptp(chart.get_ylim()) < 4.0 * np.ptp(an)
