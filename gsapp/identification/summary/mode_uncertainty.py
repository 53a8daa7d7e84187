"""How far the bounds of the derivatives let frequency and damping of the modes stray."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gsapp.dynamics.linearization import Mode
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_SURFACES
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.linear_models.model_comparison import (
    mean_condition,
    model_from_derivatives,
)
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.summary.campaign_linear_models import known_derivatives
from gsapp.identification.summary.campaign_summary import CampaignSummary


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeUncertainty:
    """A mode with what the bounds of the means leave open."""

    mode: Mode
    speed: float  # True airspeed of the steady flight, m/s.
    real_std: float
    imaginary_std: float
    """Standard deviations of the pole's parts, 1/s."""
    frequency_std: float
    damping_std: float
    time_constant_std: float
    """Standard deviations, rad/s, none, s; NaN where a change of one bound turns a pair into two
    real poles, or the other way round."""


def propagate_mode_uncertainty(
    result: CampaignResult, summary: CampaignSummary, axis: LinearAxis
) -> tuple[ModeUncertainty, ...]:
    """Return the modes of the linear model with the means, and how far the bounds let them stray.

    Each derivative is moved by one bound up and down, the others held; what that does to a mode
    adds up in squares. Bounds of means are taken as independent.

    Raises
    ------
    FlightError
        If no maneuver moved a surface of the axis, or a channel is missing.
    """
    flown = [
        one.maneuver
        for one in result.results
        if one.estimate is not None and not set(AXIS_SURFACES[axis]).isdisjoint(one.maneuver.inputs)
    ]
    if not flown:
        raise FlightError("no maneuver moved a surface of this axis")
    means = {name: one.value.mean for name, one in summary.derivatives.items()}
    values = known_derivatives(result.settings, means)
    aircraft, condition = flown[0].aircraft, mean_condition(flown)

    def modes(changed: dict[str, float]) -> tuple[Mode, ...]:
        return model_from_derivatives(aircraft, condition, axis, {**values, **changed}).modes()

    middle = modes({})
    sides = [
        (modes({name: mean + std}), modes({name: mean - std}))
        for name, mean, std in (
            (name, one.value.mean, one.value.std) for name, one in summary.derivatives.items()
        )
    ]
    return tuple(
        _mode_uncertainty(one, condition.U1, place, sides, middle)
        for place, one in enumerate(middle)
    )


def _mode_uncertainty(
    mode: Mode,
    speed: float,
    place: int,
    sides: Sequence[tuple[tuple[Mode, ...], tuple[Mode, ...]]],
    middle: tuple[Mode, ...],
) -> ModeUncertainty:
    squares = [0.0] * 5
    for up, down in sides:
        if [one.name for one in up] != [one.name for one in middle] or len(down) != len(up):
            squares = [math.nan] * 5
            break
        one, other = up[place], down[place]
        steps = (
            one.pole.real - other.pole.real, one.pole.imag - other.pole.imag,
            one.frequency - other.frequency, one.damping - other.damping,
            one.time_constant - other.time_constant,
        )  # fmt: skip
        squares = [sum_ + (0.5 * step) ** 2 for sum_, step in zip(squares, steps, strict=True)]
    real, imaginary, frequency, damping, time_constant = map(math.sqrt, squares)
    return ModeUncertainty(
        mode=mode, speed=speed, real_std=real, imaginary_std=imaginary, frequency_std=frequency,
        damping_std=damping, time_constant_std=time_constant,
    )  # fmt: skip
