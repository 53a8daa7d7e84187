"""States, inputs and outputs of maneuvers as linear models need them, in stretches without gaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gsapp.foundation import FlightError
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.identification.smoothing import runs
from gsapp.quantities import BoolArray, FloatArray

LinearAxis = Literal["lon", "lat"]

STATES: Mapping[LinearAxis, tuple[str, ...]] = {"lon": ("alpha", "q"), "lat": ("beta", "p", "r")}
INPUTS: Mapping[LinearAxis, tuple[str, ...]] = {"lon": ("de",), "lat": ("da", "dr")}
OUTPUTS: Mapping[LinearAxis, tuple[str, ...]] = {
    "lon": ("an", "alpha", "q"),
    "lat": ("ay", "beta", "p", "r"),
}
"""As in (7.2.12)-(7.2.15)."""

SHORTEST = 1.0
"""Stretches shorter than this (s) are left out."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signals:
    """One stretch without a missing sample.

    Attributes
    ----------
    maneuver : str
    times : ndarray, shape (n,)
    states, inputs, outputs : ndarray, shape (n, ...)
        As measured, SI; flow angles at the center of gravity, accelerations where the instrument
        sits.
    state_names, input_names, output_names : tuple of str
    """

    maneuver: str
    times: FloatArray
    states: FloatArray
    inputs: FloatArray
    outputs: FloatArray
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]

    def __len__(self) -> int:
        """Return the number of samples."""
        return int(self.times.size)

    @property
    def dt(self) -> float:
        """Return the sample time, s."""
        return float(self.times[1] - self.times[0])


def signals_of(maneuver: Maneuver, axis: LinearAxis) -> tuple[Signals, ...]:
    """Return the stretches of a maneuver in which everything was measured.

    Raises
    ------
    FlightError
        If a state, input or output of the axis was not measured at all, or stood still.
    """
    known = measured_motion(maneuver)
    absent = [name for name in (*STATES[axis], *INPUTS[axis]) if name not in known.measured]
    absent += [
        name
        for name in OUTPUTS[axis]
        if name not in absent and (not maneuver.has(name) or _stands_still(maneuver.samples(name)))
    ]
    if absent:
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}' has no {', '.join(absent)}, which a "
            f"{'longitudinal' if axis == 'lon' else 'lateral-directional'} linear model needs"
        )
    states = np.column_stack([known.state(name) for name in STATES[axis]])
    inputs = np.column_stack([known.input(name) for name in INPUTS[axis]])
    outputs = np.column_stack(
        [
            known.state(name) if name in STATES[axis] else maneuver.samples(name)
            for name in OUTPUTS[axis]
        ]
    )
    good: BoolArray = np.asarray(np.isfinite(outputs).all(axis=1), dtype=np.bool_)
    for name in (*STATES[axis], *INPUTS[axis]):
        if name in known.filled:
            good &= np.logical_not(known.filled[name])
    least = SHORTEST / maneuver.dt
    return tuple(
        Signals(
            maneuver=maneuver.id,
            times=known.times[rows],
            states=states[rows],
            inputs=inputs[rows],
            outputs=outputs[rows],
            state_names=STATES[axis],
            input_names=INPUTS[axis],
            output_names=OUTPUTS[axis],
        )
        for rows in runs(good)
        if rows.stop - rows.start >= least
    )


def _stands_still(samples: FloatArray) -> bool:
    """Return whether a channel shows the same all the time: its instrument is dead."""
    known = samples[np.isfinite(samples)]
    return bool(known.size) and float(np.ptp(known)) == 0.0


def all_signals(maneuvers: Sequence[Maneuver], axis: LinearAxis) -> tuple[Signals, ...]:
    """Return the stretches of several maneuvers.

    Raises
    ------
    FlightError
        If there is none.
    """
    found = tuple(one for maneuver in maneuvers for one in signals_of(maneuver, axis))
    if not found:
        raise FlightError(
            f"no maneuver holds {SHORTEST:g} s without a missing sample; there is nothing to fit"
        )
    return found
