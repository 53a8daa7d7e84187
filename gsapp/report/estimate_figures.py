"""Pictures of a campaign: values against conditions, measured against computed, FTR against ML.

Each function returns a `Picture`, drawn when the report is written. Measured is solid, computed is
dashed, what was known before is gray; flights differ by color and marker.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase
from matplotlib.ticker import MaxNLocator

from gsapp.identification.campaign import ManeuverResult
from gsapp.identification.ftr import EstimateHistory
from gsapp.identification.results import ResponseHistory
from gsapp.identification.summary import CampaignSummary, DerivativeSummary, Point
from gsapp.quantities import FloatArray, channel, from_si
from gsapp.report.document import TALLEST, Picture, margins
from gsapp.report.strip_figure import FAINT, INK, TRACE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COMPUTED, _BEFORE, _BAND, _OUT = "#d55e00", "#7d8590", "#dfe9f2", "#b9bfc7"
_COLORS: Final = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#20262e",
)  # fmt: skip
_MARKERS: Final = "os^Dv<>pXh"
_ACROSS: Final = 3
"""Charts of derivatives beside each other."""
_DOWN: Final = 4
"""Rows of them on a page."""
_POINTS: Final = 1500
"""Of a trace on paper: more cannot be told apart."""
_SIGMAS: Final = 2.0
"""Half the length of a bar, in bounds: 95 %."""


def values_pictures(
    summary: CampaignSummary,
    over: str,
    *,
    units: str = "US",
    known: Mapping[str, float] | None = None,
) -> tuple[Picture, ...]:
    """Return each derivative against a condition or the number of the maneuver.

    Parameters
    ----------
    summary : CampaignSummary
    over : str
        ``V``, ``alpha``, ``beta`` or ``number``.
    units : {"US", "SI"}
    known : mapping of str to float, optional
        Values known before, drawn as a gray line.

    Returns
    -------
    tuple of Picture
        As many pages as it takes; derivatives of bias (``_0``) are left to the table.
    """
    names = [name for name in summary.derivatives if not name.endswith("_0")]
    page = _ACROSS * _DOWN
    flights = _flights(summary)
    return tuple(
        _values_picture(
            [summary.derivatives[name] for name in names[first : first + page]],
            over,
            units,
            known or {},
            flights,
            number=first // page + 1,
        )
        for first in range(0, len(names), page)
    )


def _values_picture(
    chosen: Sequence[DerivativeSummary],
    over: str,
    units: str,
    known: Mapping[str, float],
    flights: Mapping[str, int],
    *,
    number: int,
) -> Picture:
    rows = -(-len(chosen) // _ACROSS)
    label, convert = _axis_of(over, units)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(rows, _ACROSS, squeeze=False)
        margins(container, left=0.55, top=0.42, bottom=0.45, hspace=0.42, wspace=0.3)
        for chart in charts.flat[len(chosen) :]:
            chart.set_visible(False)
        for chart, one in zip(charts.flat, chosen, strict=False):
            _draw_values(chart, one, over, convert, flights)
            if one.name in known:
                chart.axhline(known[one.name], color=_BEFORE, linewidth=0.9, linestyle=":")
            chart.set_title(one.name, loc="left", color=INK)
            chart.margins(x=0.08)
        for column in range(_ACROSS):
            shown = list(range(column, len(chosen), _ACROSS))
            if shown:
                charts.flat[shown[-1]].set_xlabel(label, color=INK)
        _legend(container, flights, known=bool(known))

    told = "over the number of the maneuver" if over == "number" else f"over {label}"
    return Picture(
        name=f"values-{over}-{number}",
        caption=f"Each derivative, per radian, {told}: bars are 95 % of its own bound, the band is "
        "the mean over all with 95 % of its error, the dotted line what was known before. Gray "
        "crosses were left out of the mean.",
        height=min(TALLEST, 0.9 + 1.65 * rows),
        draw=draw,
    )


def _flights(summary: CampaignSummary) -> dict[str, int]:
    """Return the flights in order of appearance, each with its number."""
    names = dict.fromkeys(
        point.flight for one in summary.derivatives.values() for point in one.points
    )
    return {name: place for place, name in enumerate(names)}


def _axis_of(over: str, units: str) -> tuple[str, tuple[str, str] | None]:
    """Return the label of an axis and the unit and quantity that its values are shown in."""
    if over == "number":
        return "maneuver", None
    spec = channel(over)
    unit = spec.display_unit(units)
    return f"{spec.symbol} [{unit}]", (unit, spec.quantity)


def _place(point: Point, over: str, convert: tuple[str, str] | None) -> float:
    if convert is None:
        return float(point.number)
    return float(from_si(point.conditions.get(over, np.nan), *convert))


def _draw_values(
    chart: Axes,
    one: DerivativeSummary,
    over: str,
    convert: tuple[str, str] | None,
    flights: Mapping[str, int],
) -> None:
    half = _SIGMAS * one.value.std
    chart.axhspan(one.value.mean - half, one.value.mean + half, color=_BAND, linewidth=0)
    chart.axhline(one.value.mean, color=INK, linewidth=0.8)
    for flight, place in flights.items():
        points = [point for point in one.kept if point.flight == flight]
        if points:
            chart.errorbar(
                [_place(point, over, convert) for point in points],
                [point.value for point in points],
                yerr=[_SIGMAS * point.std for point in points],
                linestyle="none", marker=_MARKERS[place % len(_MARKERS)], markersize=3.2,
                color=_COLORS[place % len(_COLORS)], elinewidth=0.7,
            )  # fmt: skip
    _plain(chart)
    low, high = chart.get_ylim()
    out = [outlier.point for outlier in one.outliers]
    if out:
        chart.plot(
            [_place(point, over, convert) for point in out],
            # A wild value stays in sight at the edge and does not flatten the others.
            [min(max(point.value, low), high) for point in out],
            linestyle="none", marker="x", color=_OUT, markersize=5.0, markeredgewidth=1.2,
            clip_on=False,
        )  # fmt: skip
        chart.set_ylim(low, high)


def _legend(container: FigureBase, flights: Mapping[str, int], *, known: bool) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [], [], linestyle="none", marker=_MARKERS[place % len(_MARKERS)], markersize=4.0,
            color=_COLORS[place % len(_COLORS)], label=name,
        )
        for name, place in flights.items()
    ]  # fmt: skip
    if known:
        handles.append(Line2D([], [], color=_BEFORE, linestyle=":", label="known before"))
    container.legend(
        handles=handles, loc="upper left", ncols=min(len(handles), 6), borderaxespad=0.1
    )


def fit_picture(result: ManeuverResult, *, units: str = "US") -> Picture | None:
    """Return inputs, and measured against computed responses, of one maneuver.

    None where the method computes no responses, or the fit failed.
    """
    estimate, maneuver = result.estimate, result.maneuver
    if estimate is None or not estimate.histories:
        return None
    history = estimate.histories[0]
    inputs = [name for name in ("de", "da", "dr") if name in maneuver.inputs]
    rows = len(inputs) + len(history.channels)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
        margins(container, left=0.95, top=0.32, bottom=0.42, hspace=0.16)
        for chart, name in zip(charts, inputs, strict=False):
            _trace(chart, name, maneuver.block.times, maneuver.samples(name), units, INK)
        for chart, column in zip(charts[len(inputs) :], range(len(history.channels)), strict=True):
            _draw_response(chart, history, column, units)
        charts[-1].set_xlabel("flight time [s]", color=INK)
        charts[-1].set_xlim(float(history.times[0]), float(history.times[-1]))
        charts[len(inputs)].legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0 + 1.16 * len(inputs)), ncols=2,
            borderaxespad=0.1,
        )  # fmt: skip

    return Picture(
        name=f"fit-{maneuver.flight}-{maneuver.id}".replace(":", "-").replace("/", "-"),
        caption=f"Maneuver {maneuver.id} of {maneuver.flight}: what was moved, and measured "
        "(solid) against computed (dashed) responses.",
        height=min(TALLEST, 0.8 + 0.82 * rows),
        draw=draw,
    )


def _draw_response(chart: Axes, history: ResponseHistory, column: int, units: str) -> None:
    name = history.channels[column]
    _trace(chart, name, history.times, history.measured[:, column], units, TRACE, label="measured")
    _trace(
        chart, name, history.times, history.computed[:, column], units, _COMPUTED,
        label="computed", linestyle="--",
    )  # fmt: skip


def _trace(
    chart: Axes,
    name: str,
    times: FloatArray,
    values: FloatArray,
    units: str,
    color: str,
    *,
    label: str = "",
    linestyle: str = "-",
) -> None:
    spec = channel(name)
    unit = spec.display_unit(units)
    step = max(1, -(-times.size // _POINTS))
    shown = from_si(np.asarray(values[::step]), unit, spec.quantity)
    chart.plot(times[::step], shown, color=color, linestyle=linestyle, label=label or None)
    chart.set_ylabel(
        f"{spec.symbol}\n[{unit}]" if unit else spec.symbol,
        rotation=0, ha="right", va="center", color=INK, labelpad=6,
    )  # fmt: skip
    _plain(chart)


def residual_picture(result: ManeuverResult, *, units: str = "US") -> Picture | None:
    """Return the residuals of one maneuver and how they repeat themselves; None without any.

    Right of each residual stands its autocorrelation over a second, with the band that white noise
    would keep within in 95 %.
    """
    estimate, maneuver = result.estimate, result.maneuver
    if estimate is None or not estimate.histories:
        return None
    history = estimate.histories[0]
    rows = len(history.channels)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(rows, 2, squeeze=False, width_ratios=(2.2, 1.0))
        margins(container, left=0.95, top=0.25, bottom=0.42, hspace=0.25, wspace=0.18)
        residuals = history.measured - history.computed
        dt = float(np.median(np.diff(history.times)))
        for row, name in enumerate(history.channels):
            left, right = charts[row]
            _trace(left, name, history.times, residuals[:, row], units, TRACE)
            lags, values, band = _autocorrelation(residuals[:, row], dt)
            right.axhspan(-band, band, color=_BAND, linewidth=0)
            right.plot(lags, values, color=TRACE)
            right.set_ylim(-1.05, 1.05)
            _plain(right)
            if row < rows - 1:
                left.tick_params(labelbottom=False)
                right.tick_params(labelbottom=False)
        charts[-1, 0].set_xlabel("flight time [s]", color=INK)
        charts[-1, 1].set_xlabel("lag [s]", color=INK)

    return Picture(
        name=f"residuals-{maneuver.flight}-{maneuver.id}".replace(":", "-").replace("/", "-"),
        caption=f"Maneuver {maneuver.id} of {maneuver.flight}: measured less computed, and the "
        "autocorrelation; white noise stays within the band.",
        height=min(TALLEST, 0.8 + 0.82 * rows),
        draw=draw,
    )


def _autocorrelation(values: FloatArray, dt: float) -> tuple[FloatArray, FloatArray, float]:
    """Return lags (s), autocorrelation, and the half width of the 95 % band of white noise."""
    good = np.isfinite(values)
    centered = np.where(good, values - (values[good].mean() if good.any() else 0.0), 0.0)
    most = min(max(2, round(1.0 / dt)), values.size - 1)
    size = 2 ** int(np.ceil(np.log2(2 * values.size)))
    power = np.abs(np.fft.rfft(centered, size)) ** 2
    sums = np.fft.irfft(power, size)[: most + 1]
    scale = sums[0] if sums[0] > 0.0 else 1.0
    band = 1.96 / math.sqrt(max(int(good.sum()), 1))
    lags = np.arange(most + 1, dtype=np.float64) * dt
    return lags, np.asarray(sums / scale, dtype=np.float64), band


def online_picture(
    histories: Sequence[EstimateHistory], summary: CampaignSummary, flight: str, number: int
) -> Picture:
    """Return how FTR's values formed over a flight, with the points and means of the campaign.

    Parameters
    ----------
    histories : sequence of EstimateHistory
        Of the derivatives to be drawn.
    summary : CampaignSummary
        Whose means are the lines to be reached.
    flight : str
    number : int
        Of the flight, for the name of the picture.
    """
    rows = -(-len(histories) // 2)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(rows, 2, sharex=True, squeeze=False)
        margins(container, left=0.6, top=0.3, bottom=0.42, hspace=0.3, wspace=0.22)
        for chart in charts.flat[len(histories) :]:
            chart.set_visible(False)
        for chart, one in zip(charts.flat, histories, strict=False):
            _draw_history(chart, one, summary.derivatives.get(one.name))
        for chart in charts[-1]:
            chart.set_xlabel("flight time [s]", color=INK)

    return Picture(
        name=f"online-{number}",
        caption=f"Flight {flight}: derivatives as FTR formed them in the air (line, with 95 % of "
        "its bound) and the mean of the campaign (dashed, with its band). Nothing is drawn where "
        "too little was excited.",
        height=min(TALLEST, 0.8 + 1.45 * rows),
        draw=draw,
    )


def _draw_history(chart: Axes, one: EstimateHistory, known: DerivativeSummary | None) -> None:
    if known is not None:
        half = _SIGMAS * known.value.std
        chart.axhspan(known.value.mean - half, known.value.mean + half, color=_BAND, linewidth=0)
        chart.axhline(known.value.mean, color=INK, linewidth=0.8, linestyle="--")
    low, high = one.values - _SIGMAS * one.stds, one.values + _SIGMAS * one.stds
    chart.fill_between(one.times, low, high, color=TRACE, alpha=0.18, linewidth=0)
    chart.plot(one.times, one.values, color=TRACE)
    _plain(chart)
    chart.set_title(one.name, loc="left", color=INK)
    earned = np.isfinite(one.values)
    if not earned.any():
        chart.text(
            0.5, 0.5, "unknown: too little excited", transform=chart.transAxes, ha="center",
            va="center", color=_BEFORE,
        )  # fmt: skip
        return
    # The first moments, with a bound many times the last one, must not flatten the rest.
    last = float(one.values[earned][-1])
    room = 6.0 * max(float(one.stds[earned][-1]), known.value.std if known else 0.0)
    reach = max(room, 1.3 * abs(last - known.value.mean) if known else 0.0)
    chart.set_ylim(last - reach, last + reach)


def _plain(chart: Axes) -> None:
    chart.grid(True, color=FAINT, linewidth=0.4)
    chart.yaxis.set_major_locator(MaxNLocator(nbins=4, min_n_ticks=2))
    chart.xaxis.set_major_locator(MaxNLocator(nbins=5))
    chart.tick_params(colors=INK, length=2)
    for side in ("top", "right"):
        chart.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        chart.spines[side].set_color(FAINT)
