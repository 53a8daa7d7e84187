"""Values with their wanted bands: the test point, and the input while it is made. No Qt."""

from __future__ import annotations

from typing import Final

from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.doublets.verdict import InputInProgress, InputVerdict
from gsapp.excitation.test_points.point import TargetInput, ToleranceBand
from gsapp.quantities import SURFACE_NAMES, ChannelSpec, channel
from ui.pilot.cue_display import Gauge
from ui.pilot.pilot_text import coarse_number_text, display_unit_text
from ui.translation import tr

_MAX_GAUGES: Final = 2
_TOLERANCE_SHARE: Final = 0.2
"""Share of the bar from what is wanted to each end of the tolerance."""
_DECIMALS: Final = {"V": 0, "alpha": 1}
_INPUT_SPAN_FACTOR: Final = 1.5
"""The bar of an input ends at so many times the largest that is wanted."""


def build_test_point_gauges(snapshot: CueSnapshot, units: str) -> tuple[Gauge, ...]:
    """Return where the aircraft is and where it should be: by speed, else by angle of attack."""
    point = snapshot.card.point if snapshot.card is not None else None
    speed, alpha = channel("V"), channel("alpha")
    if point is not None and point.speed is not None and snapshot.speed is not None:
        return (_target_gauge(speed, snapshot.speed, point.speed, point.speed_tolerance, units),)
    if point is not None and point.alpha is not None and snapshot.alpha is not None:
        return (_target_gauge(alpha, snapshot.alpha, point.alpha, point.alpha_tolerance, units),)
    if point is not None and point.speed is not None:
        return (_target_gauge(speed, None, point.speed, point.speed_tolerance, units),)
    number = coarse_number_text(speed, snapshot.speed, units, _DECIMALS["V"])
    return (Gauge(title=tr("SPEED"), number=number, unit=display_unit_text(speed, units)),)


def _target_gauge(
    spec: ChannelSpec, value: float | None, wanted: float, tolerance: float, units: str
) -> Gauge:
    """Return a gauge with what is wanted in its middle."""
    decimals = _DECIMALS[spec.id]
    share = None if value is None else 0.5 + _TOLERANCE_SHARE * (value - wanted) / tolerance
    return Gauge(
        title=tr("SPEED") if spec.id == "V" else tr("ALPHA"),
        number=coarse_number_text(spec, value, units, decimals),
        unit=display_unit_text(spec, units),
        target_text=tr("want {wanted} ± {tolerance}").format(
            wanted=coarse_number_text(spec, wanted, units, decimals),
            tolerance=coarse_number_text(spec, tolerance, units, decimals),
        ),
        marker=share,
        low=0.5 - _TOLERANCE_SHARE,
        high=0.5 + _TOLERANCE_SHARE,
    )


def build_input_gauges(
    under_way: InputInProgress | InputVerdict, wanted: TargetInput | None, units: str
) -> tuple[Gauge, ...]:
    """Return how large an input is, or was, on each of its surfaces."""
    bands = {} if wanted is None else wanted.amplitudes
    return tuple(
        _amplitude_gauge(name, under_way.amplitudes.get(name), bands.get(name), units)
        for name in under_way.surfaces[:_MAX_GAUGES]
    )


def _amplitude_gauge(
    name: str, value: float | None, band: ToleranceBand | None, units: str
) -> Gauge:
    spec = channel(name)
    title = SURFACE_NAMES.get(name, name).upper()
    number = coarse_number_text(spec, value, units, 1)
    if band is None:
        return Gauge(title=title, number=number, unit=display_unit_text(spec, units))
    full = _INPUT_SPAN_FACTOR * band.high
    return Gauge(
        title=title,
        number=number,
        unit=display_unit_text(spec, units),
        target_text=tr("want {low}–{high}").format(
            low=coarse_number_text(spec, band.low, units, 0),
            high=coarse_number_text(spec, band.high, units, 0),
        ),
        marker=None if value is None else value / full,
        low=band.low / full,
        high=band.high / full,
    )
