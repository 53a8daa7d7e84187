"""What is off, which way and by how much, from means over the last second."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.trim.settings import TRIM
from gsapp.excitation.trim.tolerances import TrimTolerances
from gsapp.excitation.trim.trim_cue import TrimDeviation
from gsapp.identification.compatibility.results import join_names

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

    Parameters
    ----------
    point : TestPoint or None
        None leaves out speed, angle of attack and height.
    attitude : bool
        Whether the bank is measured. Else its tolerance shrinks by how badly it is known.
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
    room = tolerances.bank if attitude else max(unseen - doubt, TRIM.min_bank_share * unseen)
    add("bank", motion.bank, room, "phi" if attitude else "r")
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
    """Return by what each thing is judged, in words.

    Parameters
    ----------
    wings : sequence of str
        What tells the bank.
    leg : str
        What tells the end of the leg, as `gsapp.excitation.trim.leg_monitor.LegMonitor` has it.
    """
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
