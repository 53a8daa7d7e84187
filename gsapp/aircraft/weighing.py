r"""Weight and center of gravity from scales under the wheels.

With the aircraft standing on scales the moments of the loads about the CG balance, so the CG lies
over their center. Horizontal coordinates at pitch :math:`\theta` and bank :math:`\phi` are
:math:`X = x \cos\theta + z \sin\theta` and :math:`Y = y \cos\phi - z \sin\phi`, hence

.. math::
    x_{cg} = \sum F_i x_i / \sum F_i + (\sum F_i z_i / \sum F_i - z_{cg}) \tan\theta, \quad
    y_{cg} = \sum F_i y_i / \sum F_i - (\sum F_i z_i / \sum F_i - z_{cg}) \tan\phi

with the axles' centers as points: a wheel that rolls freely carries no moment. An aircraft that
stands level tells nothing of :math:`z_{cg}`; what is not level enters with the CG's usual height.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from pydantic import Field, field_validator, model_validator

from gsapp.aircraft.config import Axles
from gsapp.aircraft.ground_tests import GROUND_TESTS, MeasuredAngle, MeasuredValue, MeasuredWeight
from gsapp.foundation import FlightError, StrictModel
from gsapp.quantities.constants import DEGREE, GRAVITY
from gsapp.quantities.fields import Length, Mass, Position, Weight

LEVEL: Final = MeasuredValue(0.0, GROUND_TESTS.level_std)
"""The attitude of an aircraft set level by eye, rad."""
DEFAULT_CG_HEIGHT: Final = MeasuredValue(0.0)
"""z of the CG where a level weighing does not tell it: that of the aircraft file, m."""

_MAIN = "main"
_PAIR = ("left", "right")


class WeighingRecord(StrictModel):
    """What was read off the scales, as the flight card holds it."""

    loads: Mapping[str, MeasuredWeight]
    """Reading under each axle, N; two axles give the CG along x, three wheels along y as well.
    ``main`` is both main wheels on one scale, or added up."""
    axles: Mapping[str, Position] = Field(default_factory=dict)
    """Places of axles' centers in place of those of the aircraft file, in its frame, m."""
    pitch: MeasuredAngle = LEVEL
    bank: MeasuredAngle = LEVEL
    """Attitude on the scales, nose up and right wing down, rad."""
    fuel: Mass | None = None  # On board when weighed, kg; None for as much as at take-off.
    scale_error: Weight = GROUND_TESTS.scale_std
    """Standard deviation of each reading that states none, N."""
    axle_error: Length = GROUND_TESTS.axle_std
    """Standard deviation of each coordinate of an axle, m."""

    @field_validator("loads")
    @classmethod
    def _must_carry(cls, value: Mapping[str, MeasuredValue]) -> Mapping[str, MeasuredValue]:
        if len(value) not in (2, 3):
            raise ValueError(
                f"holds {len(value)} readings; write those of two axles (nose, main) or of three "
                "wheels (nose, left, right)"
            )
        for name, load in value.items():
            if not load.value > 0.0:
                raise ValueError(
                    f"{name} shows no load; every scale of an aircraft on its wheels is loaded: "
                    "read it again"
                )
        return value

    @field_validator("pitch", "bank")
    @classmethod
    def _must_be_nearly_level(cls, value: MeasuredValue) -> MeasuredValue:
        if abs(value.value) > 20.0 * DEGREE:
            raise ValueError("is more than 20 deg; weigh with the wings and the nose nearly level")
        return value if value.std > 0.0 else MeasuredValue(value.value, GROUND_TESTS.level_std)

    @model_validator(mode="after")
    def _must_not_be_negative(self) -> WeighingRecord:
        for name in ("fuel", "scale_error", "axle_error"):
            if (getattr(self, name) or 0.0) < 0.0:
                raise ValueError(f"{name} is negative; write what was measured, or leave it out")
        return self


@dataclass(frozen=True, slots=True, kw_only=True)
class Support:
    """One axle or wheel on a scale."""

    name: str  # For messages: ``nose``, ``left`` ...
    position: Position  # Center of the axle in the frame of the aircraft file, m.
    load: MeasuredValue  # Reading of the scale, N.
    position_std: float = GROUND_TESTS.axle_std  # Of each coordinate, m.


@dataclass(frozen=True, slots=True, kw_only=True)
class Weighing:
    """What a weighing says."""

    mass: MeasuredValue  # As it stood on the scales, kg.
    cg: Position
    """In the frame of the aircraft file: from the CG that its positions count from, body axes, m.
    Zero along an axis that was not measured."""
    cg_std: Position  # Standard deviations, m; NaN along an axis that was not measured.
    shares: Mapping[str, float]  # Part of the weight on each support, 0 to 1.

    @property
    def measured(self) -> tuple[bool, bool, bool]:
        """Return along which of x, y, z the CG was measured."""
        x, y, z = (math.isfinite(std) for std in self.cg_std)
        return x, y, z


def cg_from_axles(
    front: Support,
    rear: Support,
    *,
    pitch: MeasuredValue = LEVEL,
    height: MeasuredValue = DEFAULT_CG_HEIGHT,
) -> Weighing:
    """Return mass and place along x from two axles.

    They are nose axle and main axle, or main axle and tail wheel; both main wheels on one scale, or
    their readings added up. `pitch` is nose up on the scales, rad; `height` z of the CG in the same
    frame as the axles, m. Raise FlightError if a load is not positive, or the axles stand at one
    place.
    """
    return _weigh((front, rear), pitch, LEVEL, height, axes=1)


def cg_from_three_points(
    one: Support,
    two: Support,
    three: Support,
    *,
    pitch: MeasuredValue = LEVEL,
    bank: MeasuredValue = LEVEL,
    height: MeasuredValue = DEFAULT_CG_HEIGHT,
) -> Weighing:
    """Return mass and place along x and y from three wheels; see `cg_from_axles`.

    Raise FlightError if a load is not positive, or the wheels stand in one line.
    """
    return _weigh((one, two, three), pitch, bank, height, axes=2)


def evaluate_weighing(record: WeighingRecord, axles: Axles | Mapping[str, Position]) -> Weighing:
    """Return mass and CG from what a flight card holds, with the axles of the aircraft file.

    Raise FlightError if the place of an axle is not known, or the readings do not make an aircraft.
    """
    places = {**axles, **record.axles}
    supports = tuple(
        Support(
            name=name,
            position=_axle_position(name, places),
            load=load if load.std > 0.0 else MeasuredValue(load.value, record.scale_error),
            position_std=record.axle_error,
        )
        for name, load in record.loads.items()
    )
    if len(supports) == 2:
        rear, front = sorted(supports, key=lambda one: one.position[0])
        return cg_from_axles(front, rear, pitch=record.pitch)
    one, two, three = supports
    return cg_from_three_points(one, two, three, pitch=record.pitch, bank=record.bank)


def _axle_position(name: str, places: Mapping[str, Position]) -> Position:
    if name in places:
        return places[name]
    if name == _MAIN and all(wheel in places for wheel in _PAIR):
        left, right = (places[wheel] for wheel in _PAIR)
        x, y, z = (0.5 * (a + b) for a, b in zip(left, right, strict=True))
        return x, y, z
    known = ", ".join(places) or "none"
    raise FlightError(
        f"weighing.loads.{name}: the position of this axle is missing (known: {known}); write "
        f"its place from the CG into [axles] of the aircraft file, {name} = "
        '["1.2 ft", "0 ft", "1.0 ft"]'
    )


def _weigh(
    supports: tuple[Support, ...],
    pitch: MeasuredValue,
    bank: MeasuredValue,
    height: MeasuredValue,
    *,
    axes: int,
) -> Weighing:
    _check_supports(supports, axes)
    loads = np.array([one.load.value for one in supports])
    places = np.array([one.position for one in supports])
    weight = float(loads.sum())
    center = loads @ places / weight
    below = float(center[2]) - height.value
    x = float(center[0]) + below * math.tan(pitch.value)
    y = float(center[1]) - below * math.tan(bank.value) if axes == 2 else 0.0
    # Each reading pulls the center towards its axle; each place counts with its share.
    shares = loads / weight
    stds = np.array([one.load.std for one in supports])
    variance = ((places[:, :2] - center[:2]) / weight * stds[:, None]) ** 2
    places_std = np.array([one.position_std for one in supports])
    own = variance.sum(axis=0) + ((shares * places_std) ** 2).sum()
    tilts = (pitch, bank)
    std = [
        math.sqrt(
            float(own[k])
            + (below * tilts[k].std / math.cos(tilts[k].value) ** 2) ** 2
            + (height.std * math.tan(tilts[k].value)) ** 2
        )
        for k in range(axes)
    ]
    return Weighing(
        mass=MeasuredValue(weight / GRAVITY, float(np.linalg.norm(stds)) / GRAVITY),
        cg=(x, y, 0.0),
        cg_std=(std[0], std[1] if axes == 2 else math.nan, math.nan),
        shares={one.name: float(share) for one, share in zip(supports, shares, strict=True)},
    )


def _check_supports(supports: tuple[Support, ...], axes: int) -> None:
    for one in supports:
        if not (math.isfinite(one.load.value) and one.load.value > 0.0):
            raise FlightError(
                f"the scale under the axle '{one.name}' shows {one.load.value:g} N; an aircraft on "
                "its wheels loads every scale: read it again"
            )
    if axes == 1:
        front, rear = supports
        if abs(front.position[0] - rear.position[0]) < GROUND_TESTS.min_axle_distance:
            raise FlightError(
                f"the axles '{front.name}' and '{rear.name}' have the same x position; the CG "
                "cannot be computed; measure their positions again"
            )
        return
    (x1, y1), (x2, y2), (x3, y3) = (one.position[:2] for one in supports)
    twice_area = abs((x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1))
    longest = max(
        math.dist(one.position[:2], two.position[:2])
        for one, two in itertools.combinations(supports, 2)
    )
    if twice_area < GROUND_TESTS.min_axle_distance * max(longest, GROUND_TESTS.min_axle_distance):
        names = ", ".join(one.name for one in supports)
        raise FlightError(
            f"the wheels {names} are in one line; the CG cannot be computed along both axes; "
            "measure their positions again, or weigh two axles"
        )
