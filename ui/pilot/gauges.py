"""Values with their wanted bands: the test point, and the input while it is made. No Qt."""

from __future__ import annotations

from typing import Final

from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.doublets.verdict import InputUnderWay, Verdict
from gsapp.excitation.points.wanted import Band, WantedInput
from gsapp.flight.cards.card import SURFACES
from gsapp.quantities import ChannelSpec, channel
from ui.pilot.sheet import Gauge
from ui.pilot.wording import coarse_text, unit_of

_MOST: Final = 2
_WIDTH: Final = 0.2
"""Share of the bar from what is wanted to each end of the tolerance."""
_DECIMALS: Final = {"V": 0, "alpha": 1}
_SURFACE_SPAN: Final = 1.5
"""The bar of an input ends at so many times the largest that is wanted."""


def point_gauges(snapshot: CueSnapshot, units: str) -> tuple[Gauge, ...]:
    """Return where the aircraft is and where it should be: by speed, else by angle of attack."""
    point = snapshot.card.point if snapshot.card is not None else None
    speed, alpha = channel("V"), channel("alpha")
    if point is not None and point.speed is not None and snapshot.speed is not None:
        return (_about(speed, snapshot.speed, point.speed, point.speed_tolerance, units),)
    if point is not None and point.alpha is not None and snapshot.alpha is not None:
        return (_about(alpha, snapshot.alpha, point.alpha, point.alpha_tolerance, units),)
    if point is not None and point.speed is not None:
        return (_about(speed, None, point.speed, point.speed_tolerance, units),)
    number = coarse_text(speed, snapshot.speed, units, _DECIMALS["V"])
    return (Gauge(title="SPEED", number=number, unit=unit_of(speed, units)),)


def _about(
    spec: ChannelSpec, value: float | None, wanted: float, tolerance: float, units: str
) -> Gauge:
    """Return a gauge with what is wanted in its middle."""
    decimals = _DECIMALS[spec.id]
    share = None if value is None else 0.5 + _WIDTH * (value - wanted) / tolerance
    return Gauge(
        title="SPEED" if spec.id == "V" else "ALPHA",
        number=coarse_text(spec, value, units, decimals),
        unit=unit_of(spec, units),
        wanted=f"want {coarse_text(spec, wanted, units, decimals)}"
        f" ± {coarse_text(spec, tolerance, units, decimals)}",
        at=share,
        low=0.5 - _WIDTH,
        high=0.5 + _WIDTH,
    )


def input_gauges(
    under_way: InputUnderWay | Verdict, wanted: WantedInput | None, units: str
) -> tuple[Gauge, ...]:
    """Return how large an input is, or was, on each of its surfaces."""
    bands = {} if wanted is None else wanted.amplitudes
    return tuple(
        _size(name, under_way.amplitudes.get(name), bands.get(name), units)
        for name in under_way.surfaces[:_MOST]
    )


def _size(name: str, value: float | None, band: Band | None, units: str) -> Gauge:
    spec = channel(name)
    title = SURFACES.get(name, name).upper()
    number = coarse_text(spec, value, units, 1)
    if band is None:
        return Gauge(title=title, number=number, unit=unit_of(spec, units))
    full = _SURFACE_SPAN * band.high
    return Gauge(
        title=title,
        number=number,
        unit=unit_of(spec, units),
        wanted=f"want {coarse_text(spec, band.low, units, 0)}"
        f"–{coarse_text(spec, band.high, units, 0)}",
        at=None if value is None else value / full,
        low=band.low / full,
        high=band.high / full,
    )
