"""How long a step should last, and how long the hands stay off: from the aircraft's own motions.

A doublet puts most of itself where half of the mode's natural period is one of its steps; a short
one ends before the mode has answered, a long one lets the answer die while the stick is held. The
measure is the spectrum of the input at the mode's natural frequency, per amplitude.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.dynamics.linearization import LinearModel
from gsapp.excitation.settings import INPUTS
from gsapp.excitation.test_points.point import ToleranceBand
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.quantities import FloatArray
from gsapp.virtual.flight_plan import INPUT_SHAPES

_GRID = np.linspace(0.02, 1.5, 297) * math.pi
"""Widths of a step, as the phase, rad, that the mode goes through meanwhile."""
_MIDDLE_STEP = {"3-2-1-1": 2}
"""Units of the step that is to last half a period, in shapes that spread about the mode."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeTiming:
    """One mode that an input excites."""

    name: str
    """``short period``, ``dutch roll``, ``roll``."""
    natural_frequency: float
    """Natural frequency, rad/s."""
    damping_ratio: float
    """Ratio; 1 for real poles."""
    slowest_time_constant: float
    """Time constant of its slower part, s."""

    @property
    def hands_off_time(self) -> float:
        """Return how long its free motion is worth having, s: two periods, if it has any."""
        if self.damping_ratio < INPUTS.max_damping_ratio:
            period = (
                2.0 * math.pi / (self.natural_frequency * math.sqrt(1.0 - self.damping_ratio**2))
            )
            wanted = INPUTS.hands_off_periods * period
        else:
            wanted = INPUTS.aperiodic_time_constants * self.slowest_time_constant
        return min(max(wanted, DETECTION.min_free_response_time), INPUTS.max_hands_off_time)


def short_period(longitudinal: LinearModel) -> ModeTiming:
    """Return the short period: alpha and q with the speed held."""
    return _timing("short period", _poles(longitudinal, ("alpha", "q")))


def dutch_roll(lateral: LinearModel) -> ModeTiming:
    """Return the dutch roll; that of beta and r alone where no pair of poles is left."""
    poles = _poles(lateral, ("beta", "p", "r", "phi"))
    pairs = [pole for pole in poles if pole.imag > 0.0]
    if pairs:
        chosen = max(pairs, key=lambda pole: pole.imag)
        return _timing("dutch roll", [chosen, chosen.conjugate()])
    return _timing("dutch roll", _poles(lateral, ("beta", "r")))


def roll_subsidence(lateral: LinearModel) -> ModeTiming:
    """Return the roll mode: the fastest real pole, or p alone where there is none."""
    poles = _poles(lateral, ("beta", "p", "r", "phi"))
    real = [pole for pole in poles if not pole.imag]
    fastest = max(real, key=abs) if real else _poles(lateral, ("p",))[0]
    return _timing("roll", [fastest])


def oscillation_step_width(mode: ModeTiming, kind: str) -> ToleranceBand:
    """Return the width of one step that excites an oscillation best.

    Of a 3-2-1-1 the step of two is as long as one of a doublet; other shapes are taken as doublets.
    """
    units = _MIDDLE_STEP.get(kind, 1)
    response = _spectrum(INPUT_SHAPES["pulse" if kind == "pulse" else "doublet"])
    best = int(np.argmax(response))
    poor = response < INPUTS.min_response_share * response[best]
    low = int(np.flatnonzero(poor[:best])[-1]) + 1 if poor[:best].any() else 0
    after = np.flatnonzero(poor[best:])
    high = best + int(after[0]) - 1 if after.size else response.size - 1
    widths = np.clip(
        _GRID[[low, best, high]] / (units * mode.natural_frequency),
        INPUTS.min_step,
        INPUTS.max_step,
    )
    return ToleranceBand(
        low=float(widths[0]),
        best=float(widths[1]),
        high=float(widths[2]),
        why_low=f"quicker, the {mode.name} has no time to respond",
        why_high=f"slower, the {mode.name} is followed and no longer excited",
    )


def roll_step_width(roll_mode: ModeTiming, wobble: ModeTiming) -> ToleranceBand:
    """Return the width of an aileron input: the roll builds up, the dutch roll stays small."""
    half_period = math.pi / wobble.natural_frequency
    low = min(INPUTS.roll_time_constants * roll_mode.slowest_time_constant, half_period / 1.5)
    low, high = (min(max(width, INPUTS.min_step), INPUTS.max_step) for width in (low, half_period))
    return ToleranceBand(
        low=low,
        best=math.sqrt(low * high),
        high=high,
        why_low="faster, the roll rate has no time to build up",
        why_high="slower, the bank grows and the dutch roll responds instead",
    )


def _timing(name: str, poles: Sequence[complex]) -> ModeTiming:
    """Return frequency and damping of one pole or two."""
    sizes = [max(abs(pole), 1e-3) for pole in poles]
    natural = math.sqrt(sizes[0] * sizes[-1])
    decay = -sum(pole.real for pole in poles) / len(poles)
    damping = decay / natural if poles[0].imag else 1.0
    slow = min(max(-pole.real, 1e-3) for pole in poles)
    return ModeTiming(
        name=name,
        natural_frequency=natural,
        damping_ratio=damping,
        slowest_time_constant=1.0 / slow,
    )


def _poles(linear: LinearModel, states: Sequence[str]) -> list[complex]:
    rows = [linear.states.index(name) for name in states]
    return [complex(pole) for pole in np.linalg.eigvals(linear.A[np.ix_(rows, rows)])]


def _spectrum(steps: Sequence[float]) -> FloatArray:
    """Return the size of an input's spectrum over frequency times width, per amplitude."""
    edges = np.diff([0.0, *steps, 0.0])
    phases = np.exp(-1j * np.outer(_GRID, np.arange(edges.size)))
    # At one frequency, per width: the integral of the steps is their edges over j omega.
    return np.asarray(np.abs(phases @ edges), dtype=np.float64)
