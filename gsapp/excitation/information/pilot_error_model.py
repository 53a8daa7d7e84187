"""How this pilot flies cards: learned from the flight, from what is usual to begin with."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.information.planned_maneuver import CardExecution
from gsapp.excitation.information.settings import INFORMATION
from gsapp.flight.cards import TestCard
from gsapp.quantities.constants import FOOT
from gsapp.virtual.flight_plan import INPUT_SHAPES

USABLE_RESULTS: Final = frozenset({"good", "too-small", "too-fast", "too-slow", "not-trimmed"})
"""Verdicts on maneuvers that say something of the derivatives all the same."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorDistribution:
    """One number that maneuvers miss: mean and standard deviation, with what is usual in it."""

    mean: float
    std: float
    sample_count: int = 0

    def updated(self, values: Sequence[float]) -> ErrorDistribution:
        """Return the habit once another maneuver was seen, with all that it showed of it."""
        weight = INFORMATION.pilot_prior_weight + self.sample_count
        value = float(np.mean(values))
        miss = value - self.mean
        mean = self.mean + miss / (weight + 1.0)
        seen = miss * (value - mean) + float(np.var(values))
        variance = (weight * self.std**2 + seen) / (weight + 1.0)
        return ErrorDistribution(
            mean=mean, std=math.sqrt(variance), sample_count=self.sample_count + 1
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PilotErrorModel:
    """All habits that matter for what a card brings."""

    size: ErrorDistribution = ErrorDistribution(mean=0.0, std=0.12)
    width: ErrorDistribution = ErrorDistribution(mean=0.0, std=0.12)
    """Logarithms of amplitude and of width over those asked for."""
    speed_error: ErrorDistribution = ErrorDistribution(mean=0.0, std=3.0 * FOOT)
    """Off the test point, m/s."""
    bound_ratio: ErrorDistribution = ErrorDistribution(mean=0.0, std=0.5)
    """Logarithm of the bound under the noise that there was over the one expected for the same
    input as it was flown: noise and gusts are never twice the same."""
    hands_off: ErrorDistribution = ErrorDistribution(mean=4.0, std=0.8)
    """Seconds after the input that belong to the maneuver."""
    maneuver_count: int = 0
    usable_count: int = 0
    """Maneuvers flown, and those that said something."""

    @property
    def usable_share(self) -> float:
        """Return the share of maneuvers that will be fit; four of five to begin with."""
        return (0.8 * INFORMATION.pilot_prior_weight + self.usable_count) / (
            INFORMATION.pilot_prior_weight + self.maneuver_count
        )

    def updated_by_verdict(self, verdict: InputVerdict, card: TestCard | None) -> PilotErrorModel:
        """Return the habits once another maneuver was judged."""
        fit = verdict.result in USABLE_RESULTS
        found = replace(
            self, maneuver_count=self.maneuver_count + 1, usable_count=self.usable_count + fit
        )
        if not fit:
            return found
        found = replace(
            found, hands_off=self.hands_off.updated([verdict.t_end - verdict.t_input_end])
        )
        if card is None or card.kind != verdict.kind or set(card.surfaces) != set(verdict.surfaces):
            return found
        asked = card.amplitudes
        sizes = [
            math.log(size / asked[name])
            for name, size in verdict.amplitudes.items()
            if name in asked and size > 0.0
        ]
        widths = [
            math.log(width / card.width)
            for name in card.surfaces
            for width in verdict.halves.get(name, ())
            if width > 0.0 and len(verdict.halves[name]) == len(INPUT_SHAPES.get(card.kind, ()))
        ]
        if sizes:
            found = replace(found, size=self.size.updated([float(np.mean(sizes))]))
        if widths and card.kind == "doublet":
            found = replace(found, width=self.width.updated([float(np.mean(widths))]))
        if verdict.V is not None:
            found = replace(found, speed_error=self.speed_error.updated([verdict.V - card.speed]))
        return found

    def updated_by_bounds(self, ratios: Sequence[float]) -> PilotErrorModel:
        """Return the habits once bounds were so many times as large as expected."""
        return replace(
            self, bound_ratio=self.bound_ratio.updated([math.log(one) for one in ratios])
        )


def draw_executions(
    card: TestCard, habits: PilotErrorModel, count: int
) -> tuple[CardExecution, ...]:
    """Return how a card may turn out: `count` draws, the same ones every time.

    Sizes and widths miss together over a maneuver, and by half as much again from step to step
    and from surface to surface. Draws come in pairs that miss to opposite sides.
    """
    random = np.random.default_rng(len(card.surfaces))
    steps = len(INPUT_SHAPES.get(card.kind, INPUT_SHAPES["doublet"]))
    width = 4 + 2 * len(card.surfaces) * steps
    half = random.standard_normal(((count + 1) // 2, width))
    draws = np.concatenate((half, -half))[:count]
    return tuple(_create_execution(card, habits, draw.tolist(), steps) for draw in draws)


def _create_execution(
    card: TestCard, habits: PilotErrorModel, draw: list[float], steps: int
) -> CardExecution:
    size, width, speed, hands_off, *rest = draw
    single = iter(rest)

    def factors(habit: ErrorDistribution, common: float) -> Mapping[str, tuple[float, ...]]:
        return {
            name: tuple(
                math.exp(habit.mean + habit.std * (common + 0.5 * next(single)))
                for _ in range(steps)
            )
            for name in card.surfaces
        }

    sizes, widths = factors(habits.size, size), factors(habits.width, width)
    return CardExecution(
        sizes=sizes,
        widths=widths,
        stagger=math.exp(habits.width.mean + habits.width.std * width),
        speed_error=habits.speed_error.mean + habits.speed_error.std * speed,
        hands_off=max(1.0, habits.hands_off.mean + habits.hands_off.std * hands_off),
    )
