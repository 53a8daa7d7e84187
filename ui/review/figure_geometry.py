"""Where things lie in a drawn figure: charts with their limits, points with their maneuvers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

Limits = tuple[float, float]
"""Of an axis, from left to right or from bottom to top; decimal logarithms on a log axis."""


_ROUNDING = 1e-6
"""Of a range, that its limits may differ by."""
_DEEPEST, _FARTHEST = 1e-3, 4.0
"""Ranges of a chart that can be looked at, in times of the whole."""


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """What part of its data a chart shows."""

    x: Limits
    y: Limits


@dataclass(frozen=True, slots=True, kw_only=True)
class Pane:
    """One chart of a figure.

    Attributes
    ----------
    place : int
        Among all axes of the figure.
    name : str
        What it is about, ``derivative:Cm_alpha``; may be empty.
    left, top, right, bottom : float
        Logical pixels.
    view : View
    group : int
        Charts of one group have the x axis in common.
    over_time : bool
        Whether it shares its x axis with others: then only that is moved and zoomed.
    x_title, y_title : str
        Along its axes.
    x_log, y_log : bool
        Whether an axis is logarithmic.
    """

    place: int
    name: str
    left: float
    top: float
    right: float
    bottom: float
    view: View
    group: int
    over_time: bool
    x_title: str = ""
    y_title: str = ""
    x_log: bool = False
    y_log: bool = False

    def holds(self, x: float, y: float) -> bool:
        """Return whether a pixel lies within."""
        return self.left <= x <= self.right and self.top <= y <= self.bottom

    def shares(self, x: float, y: float) -> tuple[float, float]:
        """Return where a pixel lies: shares of width from the left and height from the bottom."""
        wide, high = max(self.right - self.left, 1.0), max(self.bottom - self.top, 1.0)
        return (x - self.left) / wide, (self.bottom - y) / high

    def reading(self, view: View, x: float, y: float) -> str:
        """Return the values at a pixel, each beside its axis' title; a title less is left out."""
        said = []
        for title, limits, share, log in zip(
            (self.x_title, self.y_title), (view.x, view.y), self.shares(x, y),
            (self.x_log, self.y_log), strict=True,
        ):  # fmt: skip
            value = limits[0] + share * (limits[1] - limits[0])
            if title:
                said.append(f"{title} {10.0**value if log else value:.5g}")
        return "\n".join(said)

    def seen_as(self, view: View, x: float, y: float) -> tuple[float, float]:
        """Return where what was drawn at a pixel lies when the chart shows another view."""
        across, up = self.shares(x, y)
        across = _rescaled(across, self.view.x, view.x)
        up = _rescaled(up, self.view.y, view.y)
        return (
            self.left + across * (self.right - self.left),
            self.bottom - up * (self.bottom - self.top),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Spot:
    """One point that stands for a maneuver."""

    pane: int
    maneuver: str
    x: float
    y: float


def _rescaled(share: float, drawn: Limits, wanted: Limits) -> float:
    value = drawn[0] + share * (drawn[1] - drawn[0])
    return (value - wanted[0]) / (wanted[1] - wanted[0])


def alike(one: View, other: View) -> bool:
    """Return whether two views show the same, but for rounding."""
    return all(
        abs(a - b) <= _ROUNDING * abs(to[1] - to[0])
        for of, to in ((one.x, other.x), (one.y, other.y))
        for a, b in zip(of, to, strict=True)
    )


def sensible(view: View, whole: View) -> bool:
    """Return whether a view shows any of what the whole chart shows, large enough to be seen."""
    return all(
        _DEEPEST <= abs((part[1] - part[0]) / (every[1] - every[0])) <= _FARTHEST
        and min(max(part), max(every)) > max(min(part), min(every))
        for part, every in ((view.x, whole.x), (view.y, whole.y))
    )


def zoomed(view: View, across: float, up: float, factor: float, *, only_x: bool) -> View:
    """Return a view with ranges times a factor about a point, given as shares of the chart."""
    x = _zoomed(view.x, across, factor)
    return replace(view, x=x) if only_x else View(x=x, y=_zoomed(view.y, up, factor))


def _zoomed(limits: Limits, share: float, factor: float) -> Limits:
    low, high = limits
    still = low + share * (high - low)
    return still + factor * (low - still), still + factor * (high - still)


def moved(view: View, across: float, up: float, *, only_x: bool) -> View:
    """Return a view moved by shares of its own ranges."""
    x = _moved(view.x, across)
    return replace(view, x=x) if only_x else View(x=x, y=_moved(view.y, up))


def _moved(limits: Limits, share: float) -> Limits:
    step = share * (limits[1] - limits[0])
    return limits[0] + step, limits[1] + step


def nearest(spots: Iterable[Spot], x: float, y: float, reach: float) -> Spot | None:
    """Return the point nearest to a pixel, within reach; None for none."""
    near = [(abs(one.x - x) ** 2 + abs(one.y - y) ** 2, one) for one in spots]
    near = [pair for pair in near if pair[0] <= reach**2]
    return min(near, key=lambda pair: pair[0])[1] if near else None


def stepped(spots: Sequence[Spot], current: Spot | None, key: str) -> Spot | None:
    """Return the point that a walk comes to next.

    Parameters
    ----------
    spots : sequence of Spot
    current : Spot or None
        Where it stands; None begins at the first point of the first chart.
    key : {"left", "right", "up", "down"}
        Left and right go on within the chart, up and down to the same maneuver in another chart.
    """
    if not spots:
        return None
    if current is None:
        first = min(one.pane for one in spots)
        return min((one for one in spots if one.pane == first), key=lambda one: (one.x, one.y))
    if key in ("left", "right"):
        row = sorted((one for one in spots if one.pane == current.pane), key=_order)
        place = row.index(current) + (1 if key == "right" else -1)
        return row[min(max(place, 0), len(row) - 1)]
    same = [one for one in spots if one.maneuver == current.maneuver]
    if key == "down":
        return min((one for one in same if one.pane > current.pane), key=_pane, default=current)
    return max((one for one in same if one.pane < current.pane), key=_pane, default=current)


def _order(spot: Spot) -> tuple[float, float, str]:
    return (spot.x, spot.y, spot.maneuver)


def _pane(spot: Spot) -> int:
    return spot.pane
