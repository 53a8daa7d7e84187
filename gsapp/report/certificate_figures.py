"""The curve of a certificate, and what its points leave over, side by side."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from calibration.points import DIRECTION_TEXT, Direction
from calibration.polynomial_fit import evaluate_polynomial
from gsapp.quantities import unit_text
from gsapp.report.document import set_margins
from gsapp.report.palette import PRINT_PALETTE

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


def draw_certificate(container: FigureBase, standing: CertificateStatus) -> None:
    """Draw curve and residuals of a certificate.

    Parameters
    ----------
    container : FigureBase
        A figure, or a part of one.
    standing : CertificateStatus
        The certificate, its quality, and the one before.
    """
    left, right = container.subplots(1, 2, width_ratios=(1.0, 1.25))
    set_margins(container, left=0.55, right=0.1, top=0.28, bottom=0.42, wspace=0.26)
    _draw_curve(left, standing)
    _draw_residuals(right, standing)
    for axes in (left, right):
        axes.grid(True, color=PRINT_PALETTE.faint, linewidth=0.4)
        axes.xaxis.set_major_locator(MaxNLocator(nbins=6))
        axes.yaxis.set_major_locator(MaxNLocator(nbins=7))
        axes.set_xlabel("volts [V]")
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
