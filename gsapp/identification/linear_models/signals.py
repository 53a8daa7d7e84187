"""States, inputs and outputs of maneuvers as linear models need them, in stretches without gaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.linear_models.settings import LINEAR_MODELS
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.identification.smoothing import contiguous_slices
from gsapp.quantities import BoolArray, FloatArray

LinearAxis = Literal["lon", "lat"]

LINEAR_STATES: Mapping[LinearAxis, tuple[str, ...]] = {
    "lon": ("alpha", "q"),
    "lat": ("beta", "p", "r"),
}
LINEAR_INPUTS: Mapping[LinearAxis, tuple[str, ...]] = {"lon": ("de",), "lat": ("da", "dr")}
LINEAR_OUTPUTS: Mapping[LinearAxis, tuple[str, ...]] = {
    "lon": ("an", "alpha", "q"),
    "lat": ("ay", "beta", "p", "r"),
}
"""As in (7.2.12)-(7.2.15)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearModelSignals:
    """One stretch without a missing sample."""

    maneuver: str
    times: FloatArray  # Shape (n,).
    states: FloatArray
    inputs: FloatArray
    outputs: FloatArray
    """Shape (n, ...). As measured, SI; flow angles at the center of gravity, accelerations where
    the instrument sits."""
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]

    def __len__(self) -> int:
        return int(self.times.size)

    @property
    def dt(self) -> float:
        return float(self.times[1] - self.times[0])


def linear_model_signals(maneuver: Maneuver, axis: LinearAxis) -> tuple[LinearModelSignals, ...]:
    """Return the stretches of a maneuver in which everything was measured.

    Raises
    ------
    FlightError
        If a state, input or output of the axis was not measured at all, or stood still.
    """
    known = measured_motion(maneuver)
    absent = [
        name for name in (*LINEAR_STATES[axis], *LINEAR_INPUTS[axis]) if name not in known.measured
    ]
    absent += [
        name
        for name in LINEAR_OUTPUTS[axis]
        if name not in absent and (not maneuver.has(name) or _is_constant(maneuver.samples(name)))
    ]
    if absent:
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}' has no {', '.join(absent)}, which a "
            f"{AXIS_TITLES[axis]} linear model needs"
        )
    states = np.column_stack([known.state(name) for name in LINEAR_STATES[axis]])
    inputs = np.column_stack([known.input(name) for name in LINEAR_INPUTS[axis]])
    outputs = np.column_stack(
        [
            known.state(name) if name in LINEAR_STATES[axis] else maneuver.samples(name)
            for name in LINEAR_OUTPUTS[axis]
        ]
    )
    good: BoolArray = np.asarray(np.isfinite(outputs).all(axis=1), dtype=np.bool_)
    for name in (*LINEAR_STATES[axis], *LINEAR_INPUTS[axis]):
        if name in known.interpolated:
            good &= np.logical_not(known.interpolated[name])
    least = LINEAR_MODELS.min_duration / maneuver.dt
    return tuple(
        LinearModelSignals(
            maneuver=maneuver.id,
            times=known.times[rows],
            states=states[rows],
            inputs=inputs[rows],
            outputs=outputs[rows],
            state_names=LINEAR_STATES[axis],
            input_names=LINEAR_INPUTS[axis],
            output_names=LINEAR_OUTPUTS[axis],
        )
        for rows in contiguous_slices(good)
        if rows.stop - rows.start >= least
    )


def _is_constant(samples: FloatArray) -> bool:
    known = samples[np.isfinite(samples)]
    return bool(known.size) and float(np.ptp(known)) == 0.0


def all_linear_model_signals(
    maneuvers: Sequence[Maneuver], axis: LinearAxis
) -> tuple[LinearModelSignals, ...]:
    """Return the stretches of several maneuvers.

    Raises
    ------
    FlightError
        If there is none.
    """
    found = tuple(one for maneuver in maneuvers for one in linear_model_signals(maneuver, axis))
    if not found:
        raise FlightError(
            f"no maneuver holds {LINEAR_MODELS.min_duration:g} s without a missing sample; "
            "nothing to fit"
        )
    return found
