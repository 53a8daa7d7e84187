"""Where things lie in a drawn figure: charts with their limits, points with their maneuvers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter

import numpy as np

from gsapp.quantities import FloatArray, clock_text

Limits = tuple[float, float]
"""Of an axis, from left to right or from bottom to top; decimal logarithms on a log axis."""


_ROUNDING = 1e-6
"""Of a range, that its limits may differ by."""
_MIN_ZOOM_FRACTION, _MAX_ZOOM_FRACTION = 1e-3, 4.0
"""Ranges of a chart that can be looked at, in times of the whole."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewRange:
    """What part of its data a chart shows."""

    x: Limits
    y: Limits


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FigureCurve:
    """One line over an x axis that rises."""

    label: str
    x: FloatArray
    y: FloatArray

    def value(self, x: float) -> float:
        """Return the sample nearest to a place on the x axis; NaN outside."""
        if not self.x.size or not self.x[0] <= x <= self.x[-1]:
            return float("nan")
        index = int(np.searchsorted(self.x, x))
        if index > 0 and x - self.x[index - 1] < self.x[min(index, self.x.size - 1)] - x:
            index -= 1
        return float(self.y[index])


@dataclass(frozen=True, slots=True, kw_only=True)
class Subplot:
    """One chart of a figure."""

    index: int
    name: str
    """What it is about, ``derivative:Cm_alpha``; may be empty."""
    left: float
    top: float
    right: float
    bottom: float
    """Logical pixels."""
    view: ViewRange
    group: int
    """Charts of one group have the x axis in common."""
    shares_x_axis: bool
    """Whether it shares its x axis with others: then only that is moved and zoomed."""
    x_title: str = ""
    y_title: str = ""
    x_log: bool = False
    y_log: bool = False
    x_is_time: bool = False
    curves: tuple[FigureCurve, ...] = field(default=(), compare=False)
    """Lines whose values the cursor reads."""

    def contains(self, x: float, y: float) -> bool:
        return self.left <= x <= self.right and self.top <= y <= self.bottom

    def to_fractions(self, x: float, y: float) -> tuple[float, float]:
        """Return where a pixel lies: shares of width from the left and height from the bottom."""
        wide, high = max(self.right - self.left, 1.0), max(self.bottom - self.top, 1.0)
        return (x - self.left) / wide, (self.bottom - y) / high

    def value_text(self, view: ViewRange, x: float, y: float) -> str:
        across, up = self.to_fractions(x, y)
        at_x, at_y = (
            10.0**value if log else value
            for value, log in (
                (view.x[0] + across * (view.x[1] - view.x[0]), self.x_log),
                (view.y[0] + up * (view.y[1] - view.y[0]), self.y_log),
            )
        )
        said = [f"{self.x_title} {at_x:.5g}"] if self.x_title else []
        if self.x_is_time:
            said = [clock_text(at_x, decimals=2)]
        values = [(one.label, one.value(at_x)) for one in self.curves]
        values = [(label, value) for label, value in values if np.isfinite(value)]
        if not values and self.y_title:
            values = [("", at_y)]
        # The unit follows the value: "q [deg/s]" becomes "q 3.2 deg/s".
        symbol, _, unit = self.y_title.partition("[")
        said += [
            " ".join(filter(None, (symbol.strip(), label, f"{value:.4g}", unit.rstrip("]"))))
            for label, value in values
        ]
        return "\n".join(said)

    def view_in_rectangle(
        self, view: ViewRange, corner: tuple[float, float], other: tuple[float, float]
    ) -> ViewRange:
        """Return the part of a view within a rectangle, given by two pixels."""
        (left, low), (right, high) = self.to_fractions(*corner), self.to_fractions(*other)
        x, y = ((min(a, b), max(a, b)) for a, b in ((left, right), (low, high)))
        return ViewRange(x=_limits_part(view.x, x), y=_limits_part(view.y, y))

    def map_to_view(self, view: ViewRange, x: float, y: float) -> tuple[float, float]:
        """Return where what was drawn at a pixel lies when the chart shows another view."""
        across, up = self.to_fractions(x, y)
        across = _rescale_fraction(across, self.view.x, view.x)
        up = _rescale_fraction(up, self.view.y, view.y)
        return (
            self.left + across * (self.right - self.left),
            self.bottom - up * (self.bottom - self.top),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverPoint:
    """One point that stands for a maneuver."""

    subplot_index: int
    maneuver: str
    x: float
    y: float


def _limits_part(limits: Limits, shares: Limits) -> Limits:
    low, high = limits
    return low + shares[0] * (high - low), low + shares[1] * (high - low)


def _rescale_fraction(share: float, drawn: Limits, wanted: Limits) -> float:
    value = drawn[0] + share * (drawn[1] - drawn[0])
    return (value - wanted[0]) / (wanted[1] - wanted[0])


def views_match(one: ViewRange, other: ViewRange) -> bool:
    """Return whether two views show the same, but for rounding."""
    return all(
        abs(a - b) <= _ROUNDING * abs(to[1] - to[0])
        for of, to in ((one.x, other.x), (one.y, other.y))
        for a, b in zip(of, to, strict=True)
    )


def is_usable_view(view: ViewRange, whole: ViewRange) -> bool:
    """Return whether a view shows any of what the whole chart shows, large enough to be seen."""
    return all(
        _MIN_ZOOM_FRACTION <= abs((part[1] - part[0]) / (every[1] - every[0])) <= _MAX_ZOOM_FRACTION
        and min(max(part), max(every)) > max(min(part), min(every))
        for part, every in ((view.x, whole.x), (view.y, whole.y))
    )


def zoom_view(
    view: ViewRange, across: float, up: float, factor: float, *, only_x: bool
) -> ViewRange:
    """Return a view with ranges times a factor about a point, given as shares of the chart."""
    x = _zoom_limits(view.x, across, factor)
    return replace(view, x=x) if only_x else ViewRange(x=x, y=_zoom_limits(view.y, up, factor))


def _zoom_limits(limits: Limits, share: float, factor: float) -> Limits:
    low, high = limits
    still = low + share * (high - low)
    return still + factor * (low - still), still + factor * (high - still)


def pan_view(view: ViewRange, across: float, up: float, *, only_x: bool) -> ViewRange:
    """Return a view moved by shares of its own ranges."""
    x = _pan_limits(view.x, across)
    return replace(view, x=x) if only_x else ViewRange(x=x, y=_pan_limits(view.y, up))


def _pan_limits(limits: Limits, share: float) -> Limits:
    step = share * (limits[1] - limits[0])
    return limits[0] + step, limits[1] + step


def find_nearest_point(
    spots: Iterable[ManeuverPoint], x: float, y: float, reach: float
) -> ManeuverPoint | None:
    """Return the point nearest to a pixel, within reach; None for none."""
    near = [(abs(one.x - x) ** 2 + abs(one.y - y) ** 2, one) for one in spots]
    near = [pair for pair in near if pair[0] <= reach**2]
    return min(near, key=lambda pair: pair[0])[1] if near else None


def next_point(
    spots: Sequence[ManeuverPoint], current: ManeuverPoint | None, key: str
) -> ManeuverPoint | None:
    """Return the point to the left or right in its chart, or up or down in another one."""
    if not spots:
        return None
    if current is None:
        first = min(one.subplot_index for one in spots)
        return min(
            (one for one in spots if one.subplot_index == first), key=lambda one: (one.x, one.y)
        )
    if key in ("left", "right"):
        row = sorted(
            (one for one in spots if one.subplot_index == current.subplot_index),
            key=attrgetter("x", "y", "maneuver"),
        )
        place = row.index(current) + (1 if key == "right" else -1)
        return row[min(max(place, 0), len(row) - 1)]
    same = [one for one in spots if one.maneuver == current.maneuver]
    here, index = current.subplot_index, attrgetter("subplot_index")
    if key == "down":
        return min((one for one in same if index(one) > here), key=index, default=current)
    return max((one for one in same if index(one) < here), key=index, default=current)
