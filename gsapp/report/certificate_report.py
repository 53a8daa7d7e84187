"""A calibration certificate on one page, as HTML or PDF: points, curve, what it is worth.

The TOML file is the certificate; the page is for the folder of the aircraft and the eye.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.ticker import MaxNLocator

from calibration import Certificate
from calibration.certificate_store import CertificateStatus
from calibration.points import DIRECTION_TEXT, Direction
from calibration.polynomial_fit import evaluate_polynomial
from calibration.quality import CalibrationQuality
from calibration.settings import FIT_ORDER_TITLES
from calibration.signals import find_signal
from gsapp.flight.info import current_versions
from gsapp.flight.provenance import hash_input_file
from gsapp.foundation import GroundStationError, write_atomically
from gsapp.foundation.errors import format_os_error
from gsapp.quantities import channel, from_si, unit_text
from gsapp.report.document import (
    Document,
    DocumentFigure,
    DocumentSection,
    DocumentTable,
    Paragraph,
    render_png,
    set_margins,
)
from gsapp.report.document_writer import render_html
from gsapp.report.palette import PRINT_PALETTE
from gsapp.report.pdf_writer import render_pdf

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase
    from matplotlib.typing import FillStyleType

    from calibration import Certificate
    from calibration.certificate_store import CertificateStatus
    from calibration.quality import CalibrationQuality

CERTIFICATE_FIGURE_HEIGHT = 2.6
_BRANCHES: tuple[tuple[Direction, str, FillStyleType], ...] = (
    ("up", "^", "full"),
    ("down", "v", "none"),
    ("single", "o", "none"),
)
"""Directions with the marker of their points; their color is the channel's."""
_MOST_ROWS = 7
"""Settings one below the other in the table of points, so that all of it fits on one page."""


def draw_certificate(container: FigureBase, standing: CertificateStatus) -> None:
    """Draw curve and residuals of a certificate."""
    left, right = container.subplots(1, 2, width_ratios=(1.0, 1.25))
    set_margins(container, left=0.55, right=0.1, top=0.28, bottom=0.42, wspace=0.26)
    _draw_curve(left, standing)
    _draw_residuals(right, standing)
    for axes in (left, right):
        axes.grid(True)
        axes.xaxis.set_major_locator(MaxNLocator(nbins=6))
        axes.yaxis.set_major_locator(MaxNLocator(nbins=7))
        signal = find_signal(standing.certificate.signal_unit)
        axes.set_xlabel(f"{signal.name} [{signal.unit}]")
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)


def _draw_curve(axes: Axes, standing: CertificateStatus) -> None:
    certificate = standing.certificate
    volts = np.linspace(*certificate.range, 200)
    axes.plot(
        volts,
        evaluate_polynomial(certificate.coefficients, volts),
        color=PRINT_PALETTE.ink,
        linewidth=0.9,
    )
    former = standing.former
    if former is not None:
        old = np.linspace(*former.range, 200)
        axes.plot(
            old * _ratio(certificate, former), evaluate_polynomial(former.coefficients, old),
            color=PRINT_PALETTE.previous, linestyle="--", linewidth=0.9,
        )  # fmt: skip
    color = PRINT_PALETTE.channel(certificate.channel)
    for direction, marker, fill in _BRANCHES:
        taken = [point for point in certificate.points if point.direction == direction]
        axes.plot(
            [point.volts for point in taken], [point.value for point in taken],
            linestyle="none", marker=marker, markersize=4.0, color=color, fillstyle=fill,
        )  # fmt: skip
    axes.set_title("Set and measured values", loc="left")
    axes.set_ylabel(_label("set to", certificate.unit))


def _draw_residuals(axes: Axes, standing: CertificateStatus) -> None:
    certificate, quality = standing.certificate, standing.quality
    axes.axhline(0.0, color=PRINT_PALETTE.ink, linewidth=0.9)
    if quality is not None and quality.uncertainty_volts:
        width = np.array(quality.half_widths)
        axes.fill_between(
            quality.uncertainty_volts, -width, width, color=PRINT_PALETTE.band, linewidth=0.0,
            zorder=0,
            label="95 % of one reading",
        )  # fmt: skip
    _draw_former(axes, standing)
    color = PRINT_PALETTE.channel(certificate.channel)
    for direction, marker, fill in _BRANCHES:
        taken = sorted(
            (point.volts, point.value - _curve(certificate, point.volts))
            for point in certificate.points
            if point.direction == direction
        )
        if taken:
            axes.plot(
                *zip(*taken, strict=True), color=color, marker=marker, markersize=4.0,
                linewidth=0.6, fillstyle=fill,
                label=DIRECTION_TEXT[direction] or "points",
            )  # fmt: skip
    _ring_outliers(axes, certificate, quality)
    axes.set_title("Residuals", loc="left")
    axes.set_ylabel(_label("off the curve", certificate.unit))
    low, high = axes.get_ylim()
    # The legend stands above the traces, not on them.
    axes.set_ylim(low, high + 0.3 * (high - low))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", ncols=2, handlelength=1.6, columnspacing=1.2)


def _draw_former(axes: Axes, standing: CertificateStatus) -> None:
    """Draw what the certificate before would have said, less what this one says."""
    certificate, former = standing.certificate, standing.former
    if former is None:
        return
    ratio = _ratio(certificate, former)
    low = max(certificate.range[0], former.range[0] * ratio)
    high = min(certificate.range[1], former.range[1] * ratio)
    if low >= high:
        return
    volts = np.linspace(low, high, 100)
    apart = evaluate_polynomial(former.coefficients, volts / ratio) - evaluate_polynomial(
        certificate.coefficients, volts
    )
    axes.plot(
        volts, apart, color=PRINT_PALETTE.previous, linestyle="--", linewidth=0.9,
        label=f"certificate of {former.stamp:%Y-%m-%d}",
    )  # fmt: skip


def _ring_outliers(
    axes: Axes, certificate: Certificate, quality: CalibrationQuality | None
) -> None:
    for place, index in enumerate(() if quality is None else quality.outliers):
        point = certificate.points[index]
        axes.plot(
            [point.volts], [point.value - _curve(certificate, point.volts)],
            linestyle="none", marker="o", markersize=9.0, color=PRINT_PALETTE.ink, fillstyle="none",
            label="" if place else "does not fit",
        )  # fmt: skip


def _curve(certificate: Certificate, volts: float) -> float:
    return float(evaluate_polynomial(certificate.coefficients, np.array(volts)))


def _ratio(new: Certificate, former: Certificate) -> float:
    """Return what the volts of the former become at the supply of the new one."""
    if not (new.ratiometric and former.ratiometric):
        return 1.0
    if new.excitation_voltage is None or former.excitation_voltage is None:
        return 1.0
    return new.excitation_voltage / former.excitation_voltage


def _label(what: str, unit: str) -> str:
    return f"{what} [{unit_text(unit)}]" if unit else what


def write_certificate_report(
    standing: CertificateStatus, path: Path, *, written: str = "", units: Literal["US", "SI"] = "US"
) -> Path:
    """Write the page of a certificate.

    Parameters
    ----------
    standing : CertificateStatus
        The certificate with its quality and the one before (`calibration.certificate_store`).
    written : str
        When, for the head of the page; the only words that differ between two writings.
    units : {"US", "SI"}
        Of the paper and of the temperature; all else is in the certificate's own unit.

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
    """Return the page of a certificate."""
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
    low, high = (f"{value:.{_decimals(certificate)}f}" for value in sorted(ends.tolist()))
    supply = certificate.excitation_voltage
    follows = "ratiometric" if certificate.ratiometric else "not ratiometric"
    found = {
        "Instrument": certificate.instrument,
        "Channel": f"{certificate.channel}. {channel(certificate.channel).description}",
        "Taken": f"{certificate.stamp:%Y-%m-%d %H:%M:%S} by {certificate.who or 'unknown'}"
        + _ambient_conditions(certificate.temperature, units),
        "Supply": "" if supply is None else f"{supply:.3f} V, {follows}",
        "Curve": f"{FIT_ORDER_TITLES.get(certificate.degree, '')}, {_formula(certificate)}",
        "Range": f"{certificate.range[0]:.4f} to {certificate.range[1]:.4f} "
        f"{certificate.signal_unit}, "
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
    return f"{' '.join(terms)} {certificate.unit}, v in {find_signal(certificate.signal_unit).name}"


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
    signal = find_signal(certificate.signal_unit)
    heads: tuple[str, ...] = (
        "set to", f"{signal.unit}, increasing", "off", f"{signal.unit}, decreasing", "off",
    )  # fmt: skip
    if all(point.direction == "single" for point in certificate.points):
        rows, heads = [row[:3] for row in rows], ("set to", signal.name, "off")
    if len(rows) > _MOST_ROWS:
        half = (len(rows) + 1) // 2
        rest = [*rows[half:], *[("",) * len(heads)] * (2 * half - len(rows))]
        rows = [(*one, *other) for one, other in zip(rows[:half], rest, strict=True)]
        heads = (*heads, *heads)
    return DocumentTable(
        columns=heads,
        rows=tuple(rows),
        numeric=frozenset(range(len(heads))),
        caption=f"Setting and residual, in {certificate.unit or '1'}; measured in {signal.unit}",
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
