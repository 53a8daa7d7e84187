"""A test point: where to be, trimmed, before an input."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class TestPoint:
    """Where the aircraft should be when the input begins."""

    __test__ = False  # the name is the field's; it is no test of ours

    card: str = ""
    """Id of the card that it belongs to; empty for none."""
    speed: float | None = None
    alpha: float | None = None
    """True airspeed, m/s, and angle of attack at the CG at 1 g, rad: a pair on the trim curve, or
    one of them where no model tells the other."""
    speed_tolerance: float
    alpha_tolerance: float
    """To either side, m/s and rad."""
    height: float | None = None
    """Above the field, m."""
    flap: float = 0.0
    """rad."""
    throttle: float | None = None
    elevator: float | None = None
    """That hold it in level flight, by the model; 0 to 1 and rad."""
    density: float | None = None
    mass: float | None = None
    """Of the air (kg/m^3) and of the aircraft (kg) that this holds for; None: sea level, and the
    aircraft file's."""
    remarks: tuple[str, ...] = ()
    """What cannot be told of it, in words."""
