"""Linear models about a steady condition: A, B, C, D from exact Jacobians, and their modes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.sensors import OutputModel
from gsapp.dynamics.trim import Trim
from gsapp.quantities import FloatArray

LONGITUDINAL_STATES = ("alpha", "V", "q", "theta")
LATERAL_STATES = ("beta", "p", "r", "phi")
LONGITUDINAL_INPUTS = ("de", "throttle")
LATERAL_INPUTS = ("da", "dr")
LONGITUDINAL_OUTPUTS = ("alpha", "V", "q", "theta", "an", "ax")
LATERAL_OUTPUTS = ("beta", "p", "r", "phi", "ay")


@dataclass(frozen=True, slots=True, kw_only=True)
class OperatingPoint:
    """The steady flight that a linear model is about."""

    speed: float  # True airspeed, m/s.
    density: float | None = None  # kg/m^3.
    mass: float | None = None  # kg.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearModel:
    """x' = A x + B u, y = C x + D u, for small changes from a steady condition."""

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    """SI and radians."""
    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    operating_point: OperatingPoint | None = None
    """None where nobody said."""

    def modes(self) -> tuple[Mode, ...]:
        return compute_modes(self.A, self.states)


@dataclass(frozen=True, slots=True, kw_only=True)
class Mode:
    """One natural motion: a real pole, or a pair."""

    name: str
    """``short period``, ``phugoid``, ``roll``, ``dutch roll``, ``spiral``; of a short period
    without oscillation ``short period, fast`` and ``..., slow``; else ``real`` or ``pair``."""
    pole: complex  # 1/s; that of a pair with the positive imaginary part.

    @property
    def frequency(self) -> float:
        """Return the undamped natural frequency, rad/s."""
        return abs(self.pole)

    @property
    def damping(self) -> float:
        return -self.pole.real / abs(self.pole) if self.pole != 0.0 else math.nan

    @property
    def time_constant(self) -> float:
        """Return -1/real part, s; negative when it grows."""
        return -1.0 / self.pole.real if self.pole.real != 0.0 else math.inf

    @property
    def period(self) -> float:
        """Return the period, s; infinite without oscillation."""
        return 2.0 * math.pi / self.pole.imag if self.pole.imag else math.inf


def linearize(
    model: FlightModel,
    trim: Trim,
    *,
    states: Sequence[str] | None = None,
    inputs: Sequence[str] = MODEL_INPUTS,
    outputs: Sequence[str] = (),
) -> LinearModel:
    """Return the linear model about a trim.

    Of the states, from ``model.state_names`` (all by default), what is left out is held. Inputs are
    from `gsapp.dynamics.flight_model.MODEL_INPUTS`, outputs from `gsapp.dynamics.sensors.OUTPUTS`,
    at the instruments' places.
    """
    chosen = model.state_names if states is None else tuple(states)
    output_model = OutputModel(model, outputs or ("V",))
    _, slopes, differential = output_model.jacobian(trim.state, trim.inputs)
    rows = [model.state_names.index(name) for name in chosen]
    columns = [len(model.state_names) + MODEL_INPUTS.index(name) for name in inputs]
    rates, slopes = differential.rates[0], slopes[0][: len(outputs)]
    return LinearModel(
        states=chosen,
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        A=rates[np.ix_(rows, rows)],
        B=rates[np.ix_(rows, columns)],
        C=slopes[:, rows],
        D=slopes[:, columns],
    )


def linearize_longitudinal(model: FlightModel, trim: Trim) -> LinearModel:
    """Return the model in alpha, V, q, theta, and the states of effects."""
    return linearize(
        model,
        trim,
        states=(*LONGITUDINAL_STATES, *model.state_names[9:]),
        inputs=LONGITUDINAL_INPUTS,
        outputs=LONGITUDINAL_OUTPUTS,
    )


def linearize_lateral(model: FlightModel, trim: Trim) -> LinearModel:
    """Return the model in beta, p, r, phi."""
    return linearize(
        model, trim, states=LATERAL_STATES, inputs=LATERAL_INPUTS, outputs=LATERAL_OUTPUTS
    )


def compute_modes(A: FloatArray, states: Sequence[str]) -> tuple[Mode, ...]:
    """Return the modes of a system matrix, fastest first.

    Names are given to the classic sets of states: (alpha, q) with or without V and theta, and
    (beta, p, r) with or without phi, in any order; each other pole is ``real`` or ``pair``.
    """
    values = np.linalg.eigvals(A)
    poles = sorted((complex(value) for value in values if value.imag >= 0.0), key=abs, reverse=True)
    names: list[str]
    if set(states) in ({"alpha", "q"}, {"alpha", "V", "q", "theta"}):
        names = _longitudinal_names(poles)
    elif set(states) in ({"beta", "p", "r"}, {"beta", "p", "r", "phi"}):
        names = _lateral_names(poles)
    else:
        names = ["pair" if pole.imag else "real" for pole in poles]
    return tuple(Mode(name=name, pole=pole) for name, pole in zip(names, poles, strict=True))


def _longitudinal_names(poles: Sequence[complex]) -> list[str]:
    names = ["short period" if poles[0].imag else "short period, fast"]
    rest = list(poles[1:])
    if not poles[0].imag and rest and not rest[0].imag:
        names.append("short period, slow")
        rest = rest[1:]
    return names + ["phugoid" if pole.imag else "real" for pole in rest]


def _lateral_names(poles: Sequence[complex]) -> list[str]:
    real = [index for index, pole in enumerate(poles) if not pole.imag]
    pairs = len(poles) - len(real)
    if pairs != 1:
        # Two pairs: roll and spiral have joined.
        return [
            "dutch roll" if k == 0 and pairs else "lateral phugoid" if pole.imag else "real"
            for k, pole in enumerate(poles)
        ]
    names = ["dutch roll"] * len(poles)
    for place, index in enumerate(real):
        names[index] = ("roll", "spiral")[min(place, 1)]
    return names
