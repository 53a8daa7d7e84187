"""Bounds of the modes of linear models, from the covariance of their derivatives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.dynamics.linearization import Mode
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_SURFACES
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.linear_models.derivative_conversion import SteadyCondition
from gsapp.identification.linear_models.model_comparison import mean_condition
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.summary.campaign_linear_models import (
    known_derivatives,
    model_about_flown_cg,
)
from gsapp.identification.summary.campaign_summary import CampaignSummary
from gsapp.identification.summary.mean_covariance import mean_covariance
from gsapp.quantities import FloatArray


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

    Raises `FlightError` if no maneuver moved a surface of the axis, or a channel is missing.
    """
    flown = [
        one.maneuver
        for one in result.results
        if one.estimate is not None and not set(AXIS_SURFACES[axis]).isdisjoint(one.maneuver.inputs)
    ]
    if not flown:
        raise FlightError("no maneuver moved a surface of this axis")
    means = {name: one.value for name, one in summary.derivatives.items()}
    return propagate_mode_covariance(
        flown[0],
        mean_condition(flown),
        axis,
        known_derivatives(result.settings, {name: one.mean for name, one in means.items()}),
        tuple(means),
        mean_covariance(result, means, tuple(means)),
    )


def propagate_mode_covariance(
    maneuver: Maneuver,
    condition: SteadyCondition,
    axis: LinearAxis,
    values: Mapping[str, float],
    names: Sequence[str],
    covariance: FloatArray,
) -> tuple[ModeUncertainty, ...]:
    """Return the modes of a linear model, with what the covariance of its derivatives leaves open.

    Each derivative is moved by one bound up and down for the slopes of a mode.

    Parameters
    ----------
    maneuver : Maneuver
        Gives the aircraft and its CG.
    values : mapping of str to float
        All derivatives that are known.
    names : sequence of str
        Those that the covariance is of.
    covariance : ndarray, shape (n_names, n_names)

    Raises
    ------
    FlightError
        If the model cannot be made.
    """

    def modes(changed: dict[str, float]) -> tuple[Mode, ...]:
        return model_about_flown_cg(maneuver, condition, axis, {**values, **changed}).modes()

    middle = modes({})
    stds = np.sqrt(np.maximum(covariance.diagonal(), 0.0))
    sides = [
        (modes({name: values[name] + std}), modes({name: values[name] - std}))
        for name, std in zip(names, stds.tolist(), strict=True)
    ]
    scale = np.where(stds > 0.0, stds, 1.0)
    correlation = covariance / scale / scale[:, None]
    return tuple(
        _mode_uncertainty(one, condition.U1, index, sides, middle, correlation)
        for index, one in enumerate(middle)
    )


def _mode_uncertainty(
    mode: Mode,
    speed: float,
    place: int,
    sides: Sequence[tuple[tuple[Mode, ...], tuple[Mode, ...]]],
    middle: tuple[Mode, ...],
    correlation: FloatArray,
) -> ModeUncertainty:
    changes = np.full((len(sides), 5), math.nan)
    for row, (up, down) in zip(changes, sides, strict=True):
        if [one.name for one in up] != [one.name for one in middle] or len(down) != len(up):
            break
        one, other = up[place], down[place]
        row[:] = (
            one.pole.real - other.pole.real, one.pole.imag - other.pole.imag,
            one.frequency - other.frequency, one.damping - other.damping,
            one.time_constant - other.time_constant,
        )  # fmt: skip
    changes *= 0.5
    squares = np.einsum("ik,ij,jk->k", changes, correlation, changes)
    real, imaginary, frequency, damping, time_constant = np.sqrt(np.maximum(squares, 0.0)).tolist()
    return ModeUncertainty(
        mode=mode, speed=speed, real_std=real, imaginary_std=imaginary, frequency_std=frequency,
        damping_std=damping, time_constant_std=time_constant,
    )  # fmt: skip
