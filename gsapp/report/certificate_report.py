"""A calibration certificate on one page, as HTML or PDF: points, curve, what it is worth.

The TOML file is the certificate; the page is for the folder of the aircraft and the eye.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from calibration import Certificate
from calibration.certificate_store import CertificateStatus
from calibration.polynomial_fit import evaluate_polynomial
from calibration.quality import CalibrationQuality
from calibration.settings import FIT_ORDER_TITLES
from gsapp.flight.info import current_versions
from gsapp.flight.provenance import hash_input_file
from gsapp.foundation import GroundStationError, write_atomically
from gsapp.foundation.os_error_text import format_os_error
from gsapp.quantities import channel, from_si
from gsapp.report.certificate_figures import CERTIFICATE_FIGURE_HEIGHT, draw_certificate
from gsapp.report.document import (
    Document,
    DocumentFigure,
    DocumentSection,
    DocumentTable,
    Paragraph,
    render_png,
)
from gsapp.report.html_writer import render_html
from gsapp.report.pdf_writer import render_pdf

_MOST_ROWS = 7
"""Settings one below the other in the table of points, so that all of it fits on one page."""


def write_certificate_report(
    standing: CertificateStatus, path: Path, *, written: str = "", units: Literal["US", "SI"] = "US"
) -> Path:
    """Write the page of a certificate.

    Parameters
    ----------
    standing : CertificateStatus
        The certificate with its quality and the one before (`calibration.certificate_store`).
    path : Path
        Ends in ``.html`` or ``.pdf``.
    written : str
        When, for the head of the page; the only words that differ between two writings.
    units : {"US", "SI"}
        Of the paper and of the temperature; all else is in the certificate's own unit.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    GroundStationError
        If the name ends otherwise, or the file cannot be written.
    """
    check_report_suffix(path)
    document = certificate_document(standing, written=written, units=units)
    if path.suffix.casefold() == ".html":
        images = {picture.name: render_png(picture) for picture in document.figures}
        content = render_html(document, images).encode()
    else:
        content = render_pdf(document)
    try:
        return write_atomically(path, content)
    except OSError as error:
        raise GroundStationError(
            format_os_error(path, error, "choose a folder with write permission")
        ) from error


def check_report_suffix(path: Path) -> None:
    """Raise `GroundStationError` where the name of a page does not say what it is to be."""
    if path.suffix.casefold() not in (".html", ".pdf"):
        raise GroundStationError(f"{path.name} has no report ending; end the name in .html or .pdf")


def certificate_document(
    standing: CertificateStatus, *, written: str = "", units: Literal["US", "SI"] = "US"
) -> Document:
    """Return the page of a certificate.

    Parameters
    ----------
    standing : CertificateStatus
    written : str
        When.
    units : {"US", "SI"}
    """
    certificate = standing.certificate
    spec = channel(certificate.channel)
    picture = DocumentFigure(
        name=certificate.channel,
        caption=_caption(standing),
        # A sheet of Letter is shorter: the page stays one.
        height=CERTIFICATE_FIGURE_HEIGHT - (0.5 if units == "US" else 0.0),
        draw=lambda container: draw_certificate(container, standing),
    )
    worth = DocumentSection(
        title="Quality",
        parts=(*_summary_text(standing), picture, _quality_table(standing)),
    )
    points = DocumentSection(
        title="Points", parts=(_points_table(certificate), _made_from(standing))
    )
    return Document(
        title=f"Calibration certificate: {spec.title}",
        facts=_facts(certificate, units),
        units=units,
        written=written,
        sections=(worth, points) if certificate.points else (worth,),
    )


def _facts(certificate: Certificate, units: str) -> tuple[tuple[str, str], ...]:
    unit = certificate.unit
    ends = evaluate_polynomial(certificate.coefficients, np.array(certificate.range))
    low, high = (_number(value, _decimals(certificate)) for value in sorted(ends.tolist()))
    supply = certificate.excitation_voltage
    follows = "ratiometric" if certificate.ratiometric else "not ratiometric"
    found = {
        "Instrument": certificate.instrument,
        "Channel": f"{certificate.channel}. {channel(certificate.channel).description}",
        "Taken": f"{certificate.stamp:%Y-%m-%d %H:%M:%S} by {certificate.who or 'nobody named'}"
        + _ambient_conditions(certificate.temperature, units),
        "Supply": "" if supply is None else f"{supply:.3f} V, {follows}",
        "Curve": f"{FIT_ORDER_TITLES.get(certificate.degree, '')}, {_formula(certificate)}",
        "Range": f"{certificate.range[0]:.4f} to {certificate.range[1]:.4f} V, "
        f"{low} to {high} {unit}".rstrip(),
        "Notes": certificate.notes,
    }
    return tuple((label, value) for label, value in found.items() if value)


def _ambient_conditions(temperature: float | None, units: str) -> str:
    if temperature is None:
        return ", temperature not noted"
    unit = channel("temperature").display_unit(units)
    return f", at {from_si(temperature, unit, 'temperature'):.0f} {unit}"


def _formula(certificate: Certificate) -> str:
    terms = []
    for power, coefficient in enumerate(certificate.coefficients):
        volts = {0: "", 1: " v"}.get(power, f" v^{power}")
        sign = ("- " if coefficient < 0.0 else "+ ") if power else ("-" if coefficient < 0 else "")
        terms.append(f"{sign}{abs(coefficient):.6g}{volts}")
    return f"{' '.join(terms)} {certificate.unit}, v in volts"


def _summary_text(standing: CertificateStatus) -> tuple[Paragraph, Paragraph]:
    """Return what to read if nothing else, and how the instrument moved."""
    certificate, quality = standing.certificate, standing.quality
    unit, places = certificate.unit, _decimals(certificate) + 1
    if quality is None or quality.uncertainty is None:
        first = "The points do not allow an uncertainty estimate."
    else:
        width = f"{quality.uncertainty:.{places}f} {unit}".rstrip()
        first = f"The 95 % uncertainty is at most {width}."
    if standing.drift is not None:
        second = f"{standing.drift.sentence[:1].upper()}{standing.drift.sentence[1:]}."
    elif standing.former is not None:
        second = "The previous certificate cannot be compared with this one."
    else:
        second = "No previous certificate."
    return Paragraph(text=first, kind="lead"), Paragraph(text=second)


def _caption(standing: CertificateStatus) -> str:
    directions = {point.direction for point in standing.certificate.points}
    loop = (
        "The hysteresis is the distance between increasing and decreasing points; the curve is "
        "the mean."
        if {"up", "down"} <= directions
        else "Points were taken in one direction only: hysteresis not measured."
    )
    former = " Dashed: previous certificate." if standing.former is not None else ""
    return f"{loop} Shaded: 95 % band.{former}"


def _quality_table(standing: CertificateStatus) -> DocumentTable:
    """Return the figures, two beside each other to spare room."""
    rows = quality_rows(standing.quality, standing.certificate)
    if len(rows) % 2:
        rows = (*rows, ("", ""))
    half = len(rows) // 2
    return DocumentTable(
        columns=("", "", "", ""),
        rows=tuple((*one, *other) for one, other in zip(rows[:half], rows[half:], strict=True)),
        numeric=frozenset({1, 3}),
    )


def quality_rows(
    quality: CalibrationQuality | None, certificate: Certificate
) -> tuple[tuple[str, str], ...]:
    """Return the figures of a calibration with their names, in the unit of its certificate."""
    unit = certificate.unit
    places = _decimals(certificate) + 1

    def shown(value: float | None) -> str:
        return "not known" if value is None else f"{value:.{places}f} {unit}".rstrip()

    off = (
        ("residuals, rms", shown(certificate.rms_residual)),
        ("residuals, maximum", shown(certificate.max_residual)),
    )
    if quality is None:
        return (*off, ("hysteresis", shown(certificate.hysteresis)))
    width = shown(quality.hysteresis)
    if quality.hysteresis_uncertainty is not None and quality.hysteresis is not None:
        width = f"{quality.hysteresis:.{places}f} ± {shown(quality.hysteresis_uncertainty)}"
    covered = (
        "travel not known" if quality.coverage is None else f"{100.0 * quality.coverage:.0f} %"
    )
    return (
        ("uncertainty, 95 %, maximum", shown(quality.uncertainty)),
        ("hysteresis, width of the loop", width),
        ("return to zero", shown(quality.return_to_zero)),
        ("linearity", shown(quality.linearity)),
        ("repeatability, std", shown(quality.scatter)),
        *off,
        ("ADC resolution", shown(quality.resolution)),
        ("of the travel covered", covered),
        ("outliers", str(len(quality.outliers))),
    )


def _points_table(certificate: Certificate) -> DocumentTable:
    """Return every point, those of one setting in a row; long lists in two columns."""
    rows = _setting_rows(certificate)
    heads: tuple[str, ...] = ("set to", "V, increasing", "off", "V, decreasing", "off")
    if all(point.direction == "single" for point in certificate.points):
        rows, heads = [row[:3] for row in rows], ("set to", "volts", "off")
    if len(rows) > _MOST_ROWS:
        half = (len(rows) + 1) // 2
        rest = [*rows[half:], *[("",) * len(heads)] * (2 * half - len(rows))]
        rows = [(*one, *other) for one, other in zip(rows[:half], rest, strict=True)]
        heads = (*heads, *heads)
    return DocumentTable(
        columns=heads,
        rows=tuple(rows),
        numeric=frozenset(range(len(heads))),
        caption=f"Setting and residual, in {certificate.unit or '1'}; measured in V",
    )


def _setting_rows(certificate: Certificate) -> list[tuple[str, ...]]:
    places = _decimals(certificate)
    upward: dict[str, list[tuple[str, str]]] = {}
    downward: dict[str, list[tuple[str, str]]] = {}
    order: dict[str, float] = {}
    for point in certificate.points:
        setting = f"{point.value:.{places}f}"
        order.setdefault(setting, point.value)
        off = point.value - float(
            evaluate_polynomial(certificate.coefficients, np.array(point.volts))
        )
        side = downward if point.direction == "down" else upward
        side.setdefault(setting, []).append((f"{point.volts:.4f}", f"{off:+.{places + 1}f}"))
    rows: list[tuple[str, ...]] = []
    for setting in sorted(order, key=lambda one: order[one]):
        up, down = upward.get(setting, []), downward.get(setting, [])
        for place in range(max(len(up), len(down))):
            first = up[place] if place < len(up) else ("", "")
            second = down[place] if place < len(down) else ("", "")
            rows.append((setting, *first, *second))
    return rows


def _made_from(standing: CertificateStatus) -> Paragraph:
    """Return what the page was made from: file, sum, versions."""
    versions = ", ".join(f"{name} {version}" for name, version in current_versions().items())
    source = ""
    if standing.file.is_file():
        file = hash_input_file("certificate", standing.file, name=standing.file.name)
        source = f"{file.name}, SHA-256 {file.sha256}; "
    return Paragraph(text=f"Made from {source}{versions}.", kind="note")


def _decimals(certificate: Certificate) -> int:
    """Return the digits that the instrument's channel earns in the unit of the certificate."""
    spec = channel(certificate.channel)
    return spec.decimals(certificate.unit)


def _number(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}"
