"""Natural motions of the linear models: poles in the complex plane, and a table of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase

from gsapp.identification.summary.mode_uncertainty import ModeUncertainty
from gsapp.quantities import channel
from gsapp.quantities.units import from_si
from gsapp.report.document import DocumentFigure, DocumentTable, set_margins
from gsapp.report.linear_text import MODE_BOUND_COLUMNS, mode_cells
from gsapp.report.palette import PRINT_PALETTE, Palette, flight_marker
from gsapp.report.plot_elements import exact_number_text, format_axes
from gsapp.report.settings import REPORT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DAMPING: Final = (0.2, 0.4, 0.6, 0.8)


def modes_figure(
    modes: Mapping[str, Sequence[ModeUncertainty]], *, palette: Palette = PRINT_PALETTE
) -> DocumentFigure:
    """Return the poles of the linear models, with lines of equal damping.

    Parameters
    ----------
    modes : mapping of str to sequence of ModeUncertainty
        By axis in words, ``longitudinal``.
    """

    def draw(container: FigureBase) -> None:
        charts = container.subplots(1, len(modes), squeeze=False)[0]
        set_margins(container, left=0.6, right=0.2, top=0.32, bottom=0.45, wspace=0.25)
        for chart, (axis, found) in zip(charts, modes.items(), strict=True):
            _draw_plane(chart, found, palette)
            chart.set_title(axis, loc="left", color=palette.ink, y=1.0)
            chart.set_xlabel("real part [1/s]", color=palette.ink)
        charts[0].set_ylabel("imaginary part [rad/s]", color=palette.ink)

    return DocumentFigure(
        name="modes",
        caption="Poles of the linear models from the means, with 95 % regions; lines of equal "
        "damping ratio. Poles right of zero are unstable.",
        height=3.3,
        draw=draw,
        numbers=lambda: _numbers(modes),
    )


def _draw_plane(chart: Axes, found: Sequence[ModeUncertainty], palette: Palette) -> None:
    poles = np.array([one.mode.pole for one in found])
    left = 1.25 * min(float(poles.real.min()), -0.5)
    right = max(1.25 * float(poles.real.max()), -0.12 * left)
    top = 1.35 * max(float(poles.imag.max()), -0.4 * left)
    chart.axvline(0.0, color=palette.ink, linewidth=0.8 * palette.line_scale)
    for damping in _DAMPING:
        slope = math.sqrt(1.0 - damping**2) / damping
        reach = min(-left, top / slope)
        chart.plot(
            [0.0, -reach], [0.0, slope * reach], color=palette.previous,
            linewidth=0.6 * palette.line_scale, linestyle=":",
        )  # fmt: skip
        chart.text(
            -0.93 * reach, 0.93 * slope * reach, f"{damping:g}", fontsize=6.0, ha="center",
            va="center", color=palette.secondary_ink, bbox={"facecolor": palette.background,
            "pad": 1.0,
                                                    "linewidth": 0.0},
        )  # fmt: skip
    for index, one in enumerate(found):
        pole = one.mode.pole
        chart.errorbar(
            [pole.real], [pole.imag], xerr=_bar(one.real_std),
            yerr=_bar(one.imaginary_std) if pole.imag else None, marker=flight_marker(index),
            markersize=6.0, color=palette.flight(index), linestyle="none",
            elinewidth=1.0 * palette.line_scale,
        )  # fmt: skip
        inward = pole.real > 0.5 * left
        chart.annotate(
            one.mode.name, (pole.real, pole.imag), xytext=(-7 if inward else 7, 5),
            textcoords="offset points", ha="right" if inward else "left", color=palette.ink,
            fontsize=7.5,
            bbox={"facecolor": palette.background, "pad": 0.8, "linewidth": 0.0, "alpha": 0.8},
        )  # fmt: skip
    format_axes(chart, palette)
    chart.set_xlim(left, right)
    chart.set_ylim(-0.05 * top, top)


def _bar(std: float) -> float | None:
    return REPORT.error_bar_sigmas * std if math.isfinite(std) else None


def modes_table(modes: Mapping[str, Sequence[ModeUncertainty]], units: str) -> DocumentTable:
    """Return frequency, damping and time constant of all modes, with their bounds, to be read."""
    spec = channel("V")
    unit = spec.display_unit(units)
    return DocumentTable(
        caption="Modes of the linear models from the means, with bounds",
        columns=(
            "axis",
            f"V [{unit}]",
            *MODE_BOUND_COLUMNS,
        ),
        rows=tuple(
            (
                axis,
                f"{from_si(one.speed, unit, spec.quantity):.{spec.decimals(unit)}f}",
                *mode_cells(one),
            )
            for axis, found in modes.items()
            for one in found
        ),
        numeric=frozenset({1, 3, 4, 5}),
    )


def _numbers(modes: Mapping[str, Sequence[ModeUncertainty]]) -> DocumentTable:
    return DocumentTable(
        columns=("axis", "mode", "real [1/s]", "imaginary [rad/s]", "frequency [rad/s]",
                 "frequency bound", "damping", "damping bound", "time constant [s]",
                 "time constant bound"),
        rows=tuple(
            (
                axis,
                one.mode.name,
                *map(
                    exact_number_text,
                    (one.mode.pole.real, one.mode.pole.imag, one.mode.frequency, one.frequency_std,
                     one.mode.damping, one.damping_std, one.mode.time_constant,
                     one.time_constant_std),
                ),
            )
            for axis, found in modes.items()
            for one in found
        ),
    )  # fmt: skip
