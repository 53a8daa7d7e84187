"""From command to surface: travel, delay, lag, rate limit of the servo; slop of the linkage.

Effects of the model that act on a control path go where they belong: delay, lag and rate limit
before the servo's output is taken, play, stops and gearing after it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gsapp.aircraft import Aircraft, Control
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.settings import SIMULATION
from gsapp.dynamics.signal_terms import (
    SURFACE_CHANNELS,
    Backlash,
    Delay,
    Lag,
    PathResponse,
    PathTerms,
    RateLimit,
    Saturation,
    ScaleFactor,
    SignalPath,
    SignalTerm,
    invert_path,
    path_response,
)
from gsapp.dynamics.terms import Term, create_term
from gsapp.quantities import FloatArray

_NO_LIMIT = 1e6


class ControlPosition(NamedTuple):
    """Where one control is."""

    command: float
    servo: float
    surface: float
    """As asked by the receiver, before the linkage, and on the surface, rad."""


def control_paths(
    aircraft: Aircraft, channel: str, effects: Sequence[tuple[Term, tuple[float, ...]]] = ()
) -> tuple[PathTerms, PathTerms]:
    """Return the path from command to servo and from servo to surface of a control.

    The effects of the model on this control have their parameters with them.
    """
    control: Control = getattr(aircraft.controls, channel)
    name = next(word for word, known in SURFACE_CHANNELS.items() if known == channel)
    servo: list[tuple[SignalTerm, tuple[float, ...]]] = []
    linkage: list[tuple[SignalTerm, tuple[float, ...]]] = []

    def own(kind: str, value: float) -> tuple[SignalTerm, tuple[float, ...]]:
        term = create_term(f"control.{name}.{kind}", aircraft)
        assert isinstance(term, SignalTerm)  # noqa: S101  every control effect is one
        return term, (value,)

    if control.delay > 0.0:
        servo.append(own("delay", control.delay))
    if control.lag > 0.0:
        servo.append(own("lag", control.lag))
    if control.rate_limit < _NO_LIMIT:
        servo.append(own("rate", control.rate_limit))
    if control.slop > 0.0:
        linkage.append(own("backlash", control.slop))
    for term, values in effects:
        if isinstance(term, (Delay, Lag, RateLimit)):
            servo.append((term, values))
        elif isinstance(term, (Backlash, Saturation, ScaleFactor)):
            linkage.append((term, values))
    return tuple(servo), tuple(linkage)


class Actuator:
    """One control, ``de``, ``da``, ``dr`` or ``flap``, stepped every `dt` s, with its effects."""

    def __init__(
        self,
        aircraft: Aircraft,
        channel: str,
        dt: float,
        effects: Sequence[tuple[Term, tuple[float, ...]]] = (),
    ) -> None:
        control: Control = getattr(aircraft.controls, channel)
        self._low, self._high = control.travel
        servo, linkage = control_paths(aircraft, channel, effects)
        self._servo = SignalPath(servo, dt)
        self._linkage = SignalPath(linkage, dt)

    def step(self, command: float) -> ControlPosition:
        """Take the command of one sample (rad); the first is taken as constant before."""
        reachable = min(max(command, self._low), self._high)
        servo = self._servo.step(reachable)
        return ControlPosition(command, servo, self._linkage.step(servo))


def create_actuators(model: FlightModel, dt: float) -> dict[str, Actuator]:
    """Return the actuators of de, da, dr and flap with the model's control effects."""
    return {
        channel: Actuator(model.aircraft, channel, dt, model.control_terms.get(name, ()))
        for name, channel in SURFACE_CHANNELS.items()
    }


@dataclass(frozen=True, slots=True)
class _SmoothedBacklash:
    """Play that a noisy record does not turn over.

    Noise of the record works a play that the surface never felt: within its width it would be
    turned over by the converter alone. So play follows the record smoothed, and what it takes is
    taken from the record as it is.
    """

    play: Backlash

    def respond(self, signal: FloatArray, dt: float, parameters: tuple[float, ...]) -> PathResponse:
        smooth = _smooth(signal, dt)
        # A surface that is not moved stays where it began: one noisy sample must not say where.
        smooth[0] = float(np.mean(signal[: max(1, round(SIMULATION.play_start / dt))]))
        found = self.play.respond(smooth, dt, parameters)

        def tangent(change: FloatArray) -> FloatArray:
            even = _smooth(change, dt)
            return change + found.tangent(even) - even

        return PathResponse(
            values=signal + found.values - smooth, parameters=found.parameters, tangent=tangent
        )


def _smooth(history: FloatArray, dt: float) -> FloatArray:
    half = round(0.5 * SIMULATION.control_smoothing / dt)
    from scipy.ndimage import uniform_filter1d  # a tenth of a second

    return np.asarray(uniform_filter1d(history, 2 * half + 1, axis=0, mode="nearest"))


def simulate_control_path(moved: PathTerms, recorded: FloatArray, dt: float) -> PathResponse:
    """Return how a control acted, from a record, shape (n,), that its sensor left as it was.

    `moved` are effects on the control path (``FlightModel.control_terms``); the columns of
    `parameters` are theirs.
    """
    terms = [
        (_SmoothedBacklash(term) if isinstance(term, Backlash) else term, values)
        for term, values in moved
    ]
    return path_response(terms, recorded, dt)


def reconstruct_deflection(
    shown: PathTerms, moved: PathTerms, recorded: FloatArray, dt: float
) -> PathResponse:
    """Return how a control acted, from its record, shape (n,): sensor undone, then control path.

    `shown` are effects on the sensor (``FlightModel.sensor_terms``), `moved` those on the control
    path; the columns of `parameters` are those of `shown`, then those of `moved`.
    """
    true = invert_path(shown, recorded, dt)
    found = simulate_control_path(moved, true.values, dt)
    return PathResponse(
        values=found.values,
        parameters=np.hstack((found.tangent(true.parameters), found.parameters)),
        tangent=lambda change: found.tangent(true.tangent(change)),
    )
