"""Linear models with the means of a campaign, and how sure their modes are."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from gsapp.dynamics.linearization import LinearModel, Mode
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_SURFACES, AXIS_TITLES
from gsapp.identification.campaign import CampaignResult, CampaignSettings
from gsapp.identification.linear_models.model_comparison import (
    DRAG_DERIVATIVES,
    mean_condition,
    model_from_derivatives,
)
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.summary.campaign_summary import CampaignSummary

_REQUIRED_DERIVATIVES: Final[dict[LinearAxis, tuple[str, ...]]] = {
    "lon": ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"),
    "lat": ("CY_beta", "Cl_beta", "Cl_p", "Cl_da", "Cn_beta", "Cn_r"),
}
"""Without these there is no model: zero in their place would be another aircraft."""


NO_LINEAR_MODEL_PREFIX: Final = "no linear"
"""Begins each remark on a linear model that could not be made."""


def known_derivatives(settings: CampaignSettings, means: Mapping[str, float]) -> dict[str, float]:
    """Return what is known of the derivatives: means, then what was held, then a model's values."""
    model = settings.known_model
    return {**({} if model is None else model.derivatives), **settings.held, **means}


def check_required_derivatives(axis: LinearAxis, values: Mapping[str, float]) -> None:
    """See that the derivatives without which a linear model is none are known.

    Raises
    ------
    FlightError
        Names those that are not.
    """
    missing = [name for name in _REQUIRED_DERIVATIVES[axis] if name not in values]
    if missing:
        raise FlightError(f"{', '.join(missing)} not known")


def build_linear_models(
    result: CampaignResult, summary: CampaignSummary
) -> tuple[dict[LinearAxis, LinearModel], tuple[str, ...]]:
    """Return the linear models about the mean condition of the maneuvers of each axis.

    `summary`: whose means are taken; what is held or known from a model stands in for the others.

    Returns
    -------
    models : dict of str to LinearModel
        By axis, SI; those that cannot be made are left out.
    remarks : tuple of str
        Why not, in words.
    """
    means = {name: one.value.mean for name, one in summary.derivatives.items()}
    values = known_derivatives(result.settings, means)
    found: dict[LinearAxis, LinearModel] = {}
    remarks = []
    for axis in _REQUIRED_DERIVATIVES:
        flown = [
            one.maneuver
            for one in result.results
            if one.estimate is not None
            and not set(AXIS_SURFACES[axis]).isdisjoint(one.maneuver.inputs)
        ]
        if not flown:
            continue
        words = AXIS_TITLES[axis]
        try:
            check_required_derivatives(axis, values)
            found[axis] = model_from_derivatives(
                flown[0].aircraft, mean_condition(flown), axis, values
            )
        except FlightError as error:
            remarks.append(f"{NO_LINEAR_MODEL_PREFIX} {words} model: {error}")
            continue
        if axis == "lon" and "V" not in found[axis].states:
            missing = ", ".join(name for name in DRAG_DERIVATIVES if name not in values)
            remarks.append(
                f"{NO_LINEAR_MODEL_PREFIX} model of speed and pitch angle: {missing} not known"
            )
    return found, tuple(remarks)


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

    Raises `FlightError` if no maneuver moved a surface of the axis, or a channel is missing.
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
