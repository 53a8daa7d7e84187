"""How far one fit can be trusted: what it cannot tell apart, and what its bounds leave out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.figure import FigureBase
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from gsapp.foundation.name_suggestions import format_names
from gsapp.identification.results import Estimate
from gsapp.report.document import MAX_FIGURE_HEIGHT, DocumentFigure, DocumentTable, set_margins
from gsapp.report.palette import PRINT_PALETTE, Palette
from gsapp.report.plot_elements import exact_number_text, format_axes, symbol_mathtext
from gsapp.report.settings import REPORT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

_MAX_LARGE_CELLS: Final = 10
"""Names from which the numbers of a heat map stand closer."""
_LABEL_ANGLE: Final = 60.0
"""Of the names above a heat map, degrees: neighbors do not run into each other."""
_ROW: Final = 0.24
_NAMED: Final = 3


def correlated_pairs(estimate: Estimate) -> tuple[tuple[str, str, float], ...]:
    """Return pairs that one fit can hardly tell apart, the closest first, biases left out."""
    names, matrix = estimate.free, estimate.correlation
    found = [
        (names[column], names[row], float(matrix[row, column]))
        for row in range(len(names))
        for column in range(row)
        if abs(matrix[row, column]) > REPORT.high_correlation
        and "_0" not in names[row] + names[column]
    ]
    return tuple(sorted(found, key=lambda pair: -abs(pair[2])))


def correlation_figure(
    estimate: Estimate, subject: str, *, palette: Palette = PRINT_PALETTE
) -> DocumentFigure | None:
    """Return the correlations of one fit as a map with numbers; None where it freed nothing.

    Parameters
    ----------
    subject : str
        What was fitted, ``maneuver 2:M4 of Flight D``.
    """
    names = estimate.free
    if len(names) < 2:
        return None
    matrix = estimate.correlation
    pairs = correlated_pairs(estimate)
    crowded = len(names) > _MAX_LARGE_CELLS

    def draw(container: FigureBase) -> None:
        chart = container.subplots()
        set_margins(container, left=0.85, right=0.12, top=0.65, bottom=0.1)
        symbols = [symbol_mathtext(name) for name in names]
        chart.imshow(matrix, cmap=_map(palette), vmin=-1.0, vmax=1.0, aspect="auto")
        chart.set_xticks(
            range(len(names)), symbols, fontsize=6.0 if crowded else 7.5, rotation=_LABEL_ANGLE,
            parse_math=True,
        )  # fmt: skip
        for text in chart.get_xticklabels():
            text.set_horizontalalignment("left")
            text.set_rotation_mode("anchor")
        chart.xaxis.tick_top()
        chart.set_yticks(
            range(len(names)), symbols, fontsize=6.5 if crowded else 7.5, parse_math=True
        )
        chart.tick_params(length=0, colors=palette.ink)
        for side in chart.spines.values():
            side.set_visible(False)
        for row in range(len(names)):
            for column in range(len(names)):
                value = float(matrix[row, column])
                chart.text(
                    column, row, "1" if row == column else _short(value), ha="center",
                    va="center", fontsize=5.5 if crowded else 7.0,
                    color=_readable(_map(palette)(0.5 + 0.5 * value), palette),
                )  # fmt: skip
        for one, other, _ in pairs:
            _frame(chart, names.index(one), names.index(other), palette)

    told = format_names(
        [f"{one} and {other} ({value:+.2f})" for one, other, value in pairs], _NAMED
    )
    said = (
        f"Framed: highly correlated pairs: {told}."
        if pairs
        else f"No pair is closer than {REPORT.high_correlation:g}."
    )
    return DocumentFigure(
        name="correlations",
        caption=f"Correlations between the derivatives of the fit of {subject}. {said}",
        height=min(MAX_FIGURE_HEIGHT, 0.85 + 1.25 * _ROW * max(len(names), 5)),
        draw=draw,
        numbers=lambda: DocumentTable(
            columns=("", *names),
            rows=tuple(
                (name, *map(exact_number_text, line))
                for name, line in zip(names, matrix, strict=True)
            ),
        ),
    )


def _map(palette: Palette) -> LinearSegmentedColormap:
    """Return a map from rust (-1) over the background (0) to blue (1)."""
    return LinearSegmentedColormap.from_list(
        "correlations", (palette.traces["rust"], palette.background, palette.traces["blue"])
    )


def _short(value: float) -> str:
    """Return a correlation without the zero before its point: the cells are narrow."""
    text = f"{value:+.2f}"
    return "0" if text[1:] == "0.00" else text.replace("0.", ".")


def _readable(fill: Sequence[float], palette: Palette) -> str:
    """Return that of ink and background which stands out more against a fill."""

    def light(color: Sequence[float]) -> float:
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in color[:3]]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    def contrast(color: str) -> float:
        high, low = sorted((light(to_rgb(color)), light(fill)), reverse=True)
        return (high + 0.05) / (low + 0.05)

    return max((palette.ink, palette.background), key=contrast)


def _frame(chart: Axes, one: int, other: int, palette: Palette) -> None:
    for column, row in ((one, other), (other, one)):
        chart.add_patch(
            Rectangle(
                (column - 0.46, row - 0.46), 0.92, 0.92, fill=False, edgecolor=palette.ink,
                linewidth=1.4,
            )
        )  # fmt: skip


def bounds_figure(
    estimate: Estimate, subject: str, *, palette: Palette = PRINT_PALETTE
) -> DocumentFigure | None:
    """Return the bounds of one fit in percent: as white noise would have them, and as they are.

    None where no derivative was earned.
    """
    found = [
        (name, 100.0 * one.cramer_rao / abs(one.value), 100.0 * one.std / abs(one.value))
        for name, one in estimate.derivatives.items()
        if one.status == "estimated" and one.value and one.std and one.cramer_rao
        and not name.endswith("_0")
    ]  # fmt: skip
    if not found:
        return None

    def draw(container: FigureBase) -> None:
        chart = container.subplots()
        set_margins(container, left=0.85, right=0.75, top=0.3, bottom=0.45)
        rows = np.arange(len(found))
        raw, honest = np.array([[low, high] for _, low, high in found]).T
        chart.set_xscale("log")
        chart.hlines(rows, raw, honest, color=palette.previous, linewidth=2.0 * palette.line_scale)
        chart.plot(
            raw, rows, linestyle="none", marker="o", markerfacecolor=palette.background,
            markeredgecolor=palette.secondary_ink, markersize=5.5,
            label="Cramér-Rao (white noise)",
        )  # fmt: skip
        chart.plot(
            honest, rows, linestyle="none", marker="s", color=palette.ink,
            markersize=5.5,
            label="corrected for colored residuals",
        )  # fmt: skip
        format_axes(chart, palette)
        chart.set_yticks(rows, [symbol_mathtext(name) for name, _, _ in found], parse_math=True)
        chart.set_ylim(len(found) - 0.4, -0.6)
        low, high = float(min(raw.min(), honest.min())), float(max(raw.max(), honest.max()))
        chart.set_xlim(0.7 * low, 1.4 * high)
        chart.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        chart.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        chart.xaxis.set_minor_formatter(NullFormatter())
        for row, value in zip(rows, honest, strict=True):
            chart.annotate(
                f"{value:.2g} %" if value < 100.0 else f"{value:.0f} %", (1.0, row),
                xycoords=("axes fraction", "data"), xytext=(6, 0), textcoords="offset points",
                va="center", fontsize=7.0, color=palette.ink, annotation_clip=False,
            )  # fmt: skip
        chart.set_xlabel("bound, percent of the value", color=palette.ink)
        container.legend(loc="upper left", ncols=2, borderaxespad=0.1)

    return DocumentFigure(
        name="bounds",
        caption=f"Bounds of the fit of {subject}: circles Cramer-Rao, squares corrected for "
        "colored residuals.",
        height=min(MAX_FIGURE_HEIGHT, 0.9 + _ROW * max(len(found), 4)),
        draw=draw,
        numbers=lambda: DocumentTable(
            columns=("derivative", "Cramer-Rao [%]", "corrected [%]"),
            rows=tuple(
                (name, exact_number_text(low), exact_number_text(high)) for name, low, high in found
            ),
        ),
    )
