"""What the crew is told before an input: what counts as trimmed, what is off and by how much."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from gsapp.excitation.settings import TRIM
from gsapp.excitation.test_points.point import TestPoint
from gsapp.foundation.name_suggestions import join_names
from gsapp.quantities import channel, from_si
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


TrimState = Literal["blind", "ground", "fly", "hold", "go", "gusty", "turn"]
"""What to do now.

``blind``: too little is measured to judge; ``ground``: the aircraft is not airborne;
``fly``: fly to the test point, what is off is listed;
``hold``: everything is where it should be, keep it there a moment longer; ``go``: make the input;
``gusty``: it would be trimmed in calmer air, wait; ``turn``: in a turn, or the straight leg is
too short for another input.
"""


_WORDS: Final[Mapping[str, tuple[str, str]]] = {
    "bank": ("right wing low", "left wing low"),
    "roll rate": ("rolling right", "rolling left"),
    "pitch rate": ("nose rising", "nose dropping"),
    "yaw rate": ("nose swinging right", "nose swinging left"),
    "turn": ("turning right", "turning left"),
    "speed": ("fast", "slow"),
    "alpha": ("alpha high", "alpha low"),
    "climb": ("climbing", "sinking"),
    "acceleration": ("speeding up", "slowing down"),
    "height": ("high", "low"),
    "unrest": ("rough air", "rough air"),
}
"""What a spotter says of too much and of too little of each quantity."""

_NUMBERED: Final[Mapping[str, tuple[str, ...]]] = {
    "bank": ("phi",),
    "speed": ("V", "Vc"),
    "alpha": ("alpha",),
    "climb": ("climb_rate",),
    "height": ("height",),
}
"""Quantities told with a number, and the channels that earn it: a bank concluded from the turn
rate is not told in degrees, and nobody flies a rate to a number."""

_NUMBER_FIRST: Final = ("speed", "height")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimDeviation:
    """One thing that is not where it should be."""

    quantity: str
    """``bank``, ``roll rate``, ``pitch rate``, ``yaw rate``, ``speed``, ``alpha``, ``climb``,
    ``acceleration`` (the speed changes), ``turn``, ``height``, ``unrest`` (of the air)."""
    amount: float
    """By how much and which way, SI: value minus what is wanted."""
    tolerance_ratio: float
    """``abs(amount)`` over its tolerance; more than 1 is off."""
    channel: str
    """Of the vocabulary, for units and digits."""

    def format_text(self, system: str = "US") -> str:
        """Return what a spotter says: "3 ft/s slow", "left wing low 6 deg", "nose dropping"."""
        text = _WORDS[self.quantity][0 if self.amount > 0.0 else 1]
        if self.channel not in _NUMBERED.get(self.quantity, ()):
            return text
        spec = channel(self.channel)
        unit = spec.display_unit(system)
        size = abs(from_si(self.amount, unit, spec.quantity))
        # Nobody flies to a tenth: one is told only where a whole unit is much.
        digits = 0 if size >= 2.0 else min(spec.decimals(unit), 1)
        number = f"{size:.{digits}f} {unit}"
        return f"{number} {text}" if self.quantity in _NUMBER_FIRST else f"{text} {number}"


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimCue:
    """The cue at one moment."""

    time: float
    """Flight time, s."""
    state: TrimState
    """See `TrimState`."""
    since: float
    """Flight time since which this state stands, s."""
    deviations: tuple[TrimDeviation, ...] = ()
    """The worst first; those beyond their tolerance come before the others. Empty while blind."""
    judged_by: tuple[str, ...] = ()
    """By what each thing is judged, in words: "wings: rates and lateral acceleration, for want of
    attitude"."""
    limitations: tuple[str, ...] = ()
    """What cannot be judged, in words."""
    gust_strength: float | None = None
    """Strength of the gusts, m/s; None where it cannot be told."""
    leg_time_left: float | None = None
    """Seconds of the straight leg that are left; None where unknown."""
    progress: float = 0.0
    """0 to 1: how much of the steady time that GO takes has passed."""

    @property
    def worst(self) -> TrimDeviation | None:
        """Return what is off most; None if nothing is beyond its tolerance."""
        return (
            self.deviations[0]
            if self.deviations and self.deviations[0].tolerance_ratio > 1.0
            else None
        )


ATTITUDE_SOURCE: Final = ("attitude",)
"""What tells the bank where it is measured."""


class MeanMotion(NamedTuple):
    """Means over a window, SI; NaN where missing. `bank_std` is how well the bank is known."""

    roll_rate: float
    pitch_rate: float
    yaw_rate: float
    speed: float
    acceleration: float
    alpha: float
    bank: float
    climb: float
    height: float
    bank_std: float


def average_motion(motions: Iterable[MeanMotion]) -> MeanMotion:
    """Return the mean of some motions; what is missing in one is missing."""
    columns = list(zip(*motions, strict=True))
    return MeanMotion(*(sum(column) / len(column) for column in columns))


def evaluate_trim(
    motion: MeanMotion, tolerances: TrimTolerances, point: TestPoint | None, *, attitude: bool
) -> tuple[TrimDeviation, ...]:
    """Return how far each thing that is measured is from where it should be, the worst first.

    Without a point speed, angle of attack and height are left out. If the attitude is not measured
    the tolerance of the bank shrinks by how badly it is known.
    """
    found: list[TrimDeviation] = []

    def add(quantity: str, amount: float, tolerance: float, channel: str) -> None:
        if math.isfinite(amount):
            found.append(
                TrimDeviation(
                    quantity=quantity,
                    amount=amount,
                    tolerance_ratio=abs(amount) / tolerance,
                    channel=channel,
                )
            )

    unseen = tolerances.bank_unmeasured
    doubt = 2.0 * max(motion.bank_std - TRIM.well_known_bank, 0.0)
    bank_tolerance = (
        tolerances.bank if attitude else max(unseen - doubt, TRIM.min_bank_share * unseen)
    )
    add("bank", motion.bank, bank_tolerance, "phi" if attitude else "r")
    add("roll rate", motion.roll_rate, tolerances.roll_rate, "p")
    add("pitch rate", motion.pitch_rate, tolerances.pitch_rate, "q")
    add("yaw rate", motion.yaw_rate, tolerances.yaw_rate, "r")
    add("acceleration", motion.acceleration, tolerances.acceleration, "ax")
    add("climb", motion.climb, tolerances.climb, "climb_rate")
    if point is not None:
        if point.speed is not None:
            add("speed", motion.speed - point.speed, point.speed_tolerance, "V")
        if point.alpha is not None:
            add("alpha", motion.alpha - point.alpha, point.alpha_tolerance, "alpha")
        if point.height is not None:
            add("height", motion.height - point.height, tolerances.height, "height")
    return tuple(sorted(found, key=lambda off: -off.tolerance_ratio))


def list_sources(
    motion: MeanMotion, point: TestPoint | None, *, wings: Sequence[str], leg: str
) -> tuple[str, ...]:
    """Return by what each thing is judged, in words; `leg` is the source of `LegMonitor`."""
    found = []
    if wings == ATTITUDE_SOURCE:
        found.append("wings: attitude")
    elif wings and math.isfinite(motion.bank):
        found.append(f"wings: {join_names(wings)} (no attitude)")
    if math.isfinite(motion.climb):
        found.append("climb: height and accelerations")
    if math.isfinite(motion.speed):
        found.append("speed: airspeed")
    if math.isfinite(motion.alpha):
        found.append("alpha: its vane, put back to the CG for upwash and pitch rate")
    if point is None:
        found.append("no test point: steadiness alone, at any speed")
    if leg:
        found.append(f"straight leg: {'position' if leg == 'position' else 'earlier laps'}")
    return tuple(found)


def list_unmeasured(
    motion: MeanMotion, point: TestPoint | None, *, calm: bool, leg: str, stuck: Iterable[str]
) -> tuple[str, ...]:
    """Return what cannot be judged, in words."""
    found = []
    for name, value in (
        ("bank: neither attitude nor yaw rate", motion.bank),
        ("roll rate: not measured", motion.roll_rate),
        ("pitch rate: not measured", motion.pitch_rate),
        ("yaw rate: not measured", motion.yaw_rate),
        ("speed: no airspeed", motion.speed),
        ("climb: no height", motion.climb),
    ):
        if not math.isfinite(value):
            found.append(name)
    if point is not None and point.alpha is not None and not math.isfinite(motion.alpha):
        stands_in = math.isfinite(motion.speed)
        found.append(f"alpha: {'at 1 g, from the speed' if stands_in else 'not measured'}")
    if not calm:
        found.append("how calm the air is")
    if not leg:
        found.append("straight leg: no earlier lap")
    found += [f"{name} is constant: ignored" for name in stuck]
    return tuple(found)
