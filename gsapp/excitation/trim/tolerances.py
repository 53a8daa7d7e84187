"""What counts as trimmed: the one place where it is stated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE, FOOT, GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimTolerances:
    """How far from steady level flight an input may begin.

    Everything is a mean over `averaging_time` seconds but the unrest: that is the standard
    deviation about the straight line through `averaging_time` seconds, as root mean square over
    `turbulence_time` seconds. How far speed and angle of attack may be from a test point is the
    point's own affair, see `gsapp.excitation.test_points.point.TestPoint`.

    The figures are a flight tester's. Five degrees of bank turn the path by 1.6 deg/s at
    100 ft/s, less than 8 deg in an input with its answer. Rates of 3 deg/s are a tenth of what
    an input brings. The air is too rough where it moves alpha half as much as a good elevator
    doublet does.
    """

    averaging_time: float = 1.0
    """s."""
    bank: float = 5.0 * DEGREE
    """rad to either side."""
    bank_unmeasured: float = 8.0 * DEGREE
    """The same where no attitude is measured, and bank follows from turn rate, rate of roll and
    lateral acceleration, rad."""
    roll_rate: float = 4.0 * DEGREE
    pitch_rate: float = 3.0 * DEGREE
    yaw_rate: float = 3.0 * DEGREE
    """About the body axes, rad/s."""
    acceleration: float = 2.0 * FOOT
    """Change of the airspeed, m/s^2."""
    climb: float = 5.0 * FOOT
    """m/s."""
    height: float = 50.0 * FOOT
    """From that of a test point that asks for one, m."""
    turbulence_time: float = 3.0
    """s."""
    alpha_rms: float = 0.7 * DEGREE
    beta_rms: float = 0.9 * DEGREE
    """rad."""
    roll_rate_rms: float = 5.0 * DEGREE
    pitch_rate_rms: float = 2.5 * DEGREE
    yaw_rate_rms: float = 3.0 * DEGREE
    """rad/s."""
    an_rms: float = 0.15 * GRAVITY
    """Normal acceleration, m/s^2."""


DEFAULT_TOLERANCES: Final = TrimTolerances()
"""Those that the cue goes by unless told otherwise."""
