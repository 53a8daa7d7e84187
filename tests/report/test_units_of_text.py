"""Sentences and paper follow the units that the reader chose."""

import io
import re
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.backends.backend_pdf import RendererPdf

from calibration import load_certificate
from calibration.certificate_store import evaluate_certificate
from calibration.certificate_toml import SHIPPED_CERTIFICATES_FOLDER
from gsapp.cli._console import PlainConsole
from gsapp.cli._discrepancy_text import print_discrepancy
from gsapp.cli._options import DISPLAY_UNITS
from gsapp.discrepancy.results import DiscrepancyResult, FlightRegion
from gsapp.quantities import convert_text_units, convert_value_and_std
from gsapp.report.certificate_report import certificate_document, write_certificate_report
from gsapp.report.discrepancy_report import discrepancy_document
from gsapp.report.document import (
    Document,
    DocumentFigure,
    DocumentSection,
    DocumentTable,
    Paragraph,
    convert_units,
)
from gsapp.report.document_writer import render_html
from gsapp.report.pdf_writer import render_pdf
from tests.foreign_units import CUSTOMARY, METRIC
from tests.report.discrepancy_kit import answer
from ui.gap.gap_text import parameter_text
from ui.gap.gap_view_models import describe_disagreement

SHEETS = {"US": (612.0, 792.0), "SI": (595.4, 841.7)}


@pytest.mark.parametrize(
    ("sentence", "shown"),
    [
        ("V below 26.2 m/s", "V below 86.0 ft/s"),
        ("arm 0.0501 ± 0.0020 m", "arm 0.164 ± 0.0066 ft"),
        ("between 20 to 30 m/s", "between 66 to 98 ft/s"),
        ("the CG was 26 mm aft, mass 20.5 kg", "the CG was 1.0 in aft, mass 45.2 lb"),
        ("off by −3.0 Pa", "off by −0.063 lbf/ft^2"),
        ("the air had 20.0 degC, at least -5 degC", "the air had 68.0 degF, at least 23 degF"),
        ("20.0 ± 1.5 degC, 0.5 K more", "68.0 ± 2.7 degF, 0.5 K more"),
        # No value with a unit: a name, a time, a unit of another system, a product.
        ("maneuver m3 of 12 s, 3 N-type", "maneuver m3 of 12 s, 3 N-type"),
        ("4 deg, 10 ft/s, 3 m/sec, 12 min, 5 ms", "4 deg, 10 ft/s, 3 m/sec, 12 min, 5 ms"),
    ],
)
def test_metric_values_of_a_sentence_are_converted(sentence: str, shown: str) -> None:
    assert convert_text_units(sentence, "US") == shown
    assert convert_text_units(shown, "US") == shown


def test_customary_values_of_a_sentence_are_converted() -> None:
    text = "from 80 to 120 ft/s, 12 lb each, 68 degF; 3 in 5 maneuvers"
    assert (
        convert_text_units(text, "SI")
        == "from 24 to 36.6 m/s, 5.4 kg each, 20 degC; 3 in 5 maneuvers"
    )
    assert convert_text_units(text, "US") == text
    metric = "26.2 m/s, 20 degC, 20.5 kg"
    assert convert_text_units(metric, "SI") == metric


def test_sizes_keep_their_spread() -> None:
    value, std, unit = convert_value_and_std(0.3048, 0.03048, "m", "US")
    assert (value, std, unit) == (pytest.approx(1.0), pytest.approx(0.1), "ft")
    assert convert_value_and_std(2.0, 0.1, "m", "SI") == (2.0, 0.1, "m")
    assert convert_value_and_std(2.0, 0.1, "1/s", "US") == (2.0, 0.1, "1/s")


def boxes(pdf: bytes) -> set[tuple[float, float]]:
    found = re.findall(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", pdf)
    return {(round(float(wide), 1), round(float(high), 1)) for wide, high in found}


def document() -> Document:
    tall = DocumentFigure(
        name="tall", caption="Gusts of 1.50 m/s. " * 20, height=9.6, draw=lambda _: None
    )
    table = DocumentTable(columns=("where", "V [ft/s]"), rows=(("V above 30.0 m/s", "98"),))
    parts = (Paragraph(text="The CG was 26 mm aft."), table, tall)
    return Document(title="Test", sections=(DocumentSection(title="One", parts=parts),))


@pytest.mark.parametrize("units", ["US", "SI"])
def test_a_document_has_the_paper_and_the_units_of_its_reader(units: str) -> None:
    shown = convert_units(document(), units)
    page = render_html(shown, {"tall": b"\x89PNG"})
    assert bool(re.search(r"\d (m/s|mm)\b", page)) == (units == "SI")
    assert ("1.0 in aft" in page) == (units == "US")
    (sheet,) = boxes(render_pdf(shown))
    assert sheet == pytest.approx(SHEETS[units], abs=0.2)


def test_captions_have_symbols_as_figures_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """In HTML and PDF alike; names in tables stay as files write them."""
    table = DocumentTable(columns=("name",), rows=(("Cm_alpha",),), caption="Cn_dr by flight")
    picture = DocumentFigure(name="one", caption="Cm_alpha over V", height=1.0, draw=lambda _: None)
    made = Document(title="Test", sections=(DocumentSection(title="One", parts=(table, picture)),))
    page = render_html(made, {"one": b""})
    assert "<figcaption>Cmα over V</figcaption>" in page
    assert "<caption>Cnδr by flight</caption>" in page
    assert "Cm_alpha</td>" in page
    assert {"Cmα over V", "Cnδr by flight", "Cm_alpha"} <= set(texts_of_pdf(made, monkeypatch))


def test_no_number_of_a_wide_table_is_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sentences beside them take more lines; columns without any text are left out."""
    numbers = tuple(f"-0.000010{place:04}" for place in range(5))
    table = DocumentTable(
        columns=("derivative", *(f"column {place}" for place in range(5)), "empty", "why", "how"),
        rows=(
            ("Cm_alpha", *numbers, "", *(2 * ("in gusts of 1 m/s it is off by 3 of its bounds",))),
        ),
    )
    shown = table.without_empty_columns()
    assert shown.columns == (*table.columns[:6], "why", "how")
    made = Document(title="Test", sections=(DocumentSection(title="One", parts=(shown,)),))
    assert {"Cm_alpha", *numbers} <= set(texts_of_pdf(made, monkeypatch))


def texts_of_pdf(document: Document, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the texts that are drawn, line by line."""
    written: list[str] = []
    draw = RendererPdf.draw_text
    monkeypatch.setattr(
        RendererPdf,
        "draw_text",
        lambda self, gc, x, y, s, *a, **k: written.append(s) or draw(self, gc, x, y, s, *a, **k),
    )
    render_pdf(document)
    return written


@pytest.mark.parametrize("units", ["US", "SI"])
def test_certificates_are_printed_on_the_same_paper(tmp_path: Path, units: str) -> None:
    file = SHIPPED_CERTIFICATES_FOLDER / "b777" / "rudder.toml"
    standing = evaluate_certificate(load_certificate(file), file)
    (sheet,) = boxes(
        write_certificate_report(standing, tmp_path / "c.pdf", units=units).read_bytes()
    )
    assert sheet == pytest.approx(SHEETS[units], abs=0.2)
    taken = dict(certificate_document(standing, units=units).facts)["Taken"]
    assert ("68 degF" in taken, "20 degC" in taken) == (units == "US", units == "SI")
    other = evaluate_certificate(replace(standing.certificate, temperature=None), file)
    assert "not noted" in dict(certificate_document(other, units=units).facts)["Taken"]


@pytest.fixture(scope="module")
def found() -> DiscrepancyResult:
    made = answer(maneuvers=3, samples=40)
    region = FlightRegion(variable="V", low=20.0, high=26.2, words="V below 26.2 m/s")
    return replace(
        made,
        why=f"{made.why} Turbulence of about 0.3 m/s disturbed the flights.",
        warnings=(*made.warnings, "the CG was 26 mm aft of the aircraft file's, mass 20.5 kg"),
        disagreements=tuple(replace(one, region=region) for one in made.disagreements),
    )


@pytest.mark.parametrize(("units", "foreign"), [("US", METRIC), ("SI", CUSTOMARY)])
def test_no_foreign_unit_stands_in_report_command_or_page(
    found: DiscrepancyResult, units: str, foreign: re.Pattern[str]
) -> None:
    shown = discrepancy_document(found, units=units, overlays=[])
    page = re.sub(r"<[^>]+>", " ", render_html(shown, {one.name: b"" for one in shown.figures}))
    console = PlainConsole(file=io.StringIO(), width=160)
    shown_in = DISPLAY_UNITS.set("SI" if units == "SI" else "US")
    print_discrepancy(console, found)
    DISPLAY_UNITS.reset(shown_in)
    words = [
        *(describe_disagreement(one, units) for one in found.disagreements),
        *(parameter_text(*size, "m", units) for one in found.effects
          for size in one.parameters.values()),
    ]  # fmt: skip
    own = METRIC if units == "SI" else CUSTOMARY
    for text in (page, console.file.getvalue(), "\n".join(words)):
        assert not foreign.search(text), foreign.search(text)
        assert own.search(text)
