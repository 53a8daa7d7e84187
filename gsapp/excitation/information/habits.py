"""How this pilot flies cards: learned from the flight, from what is usual to begin with."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gsapp.dynamics.pilot.plan import SHAPES
from gsapp.excitation.doublets.verdict import Verdict
from gsapp.excitation.information.planned import Execution
from gsapp.flight.cards import TestCard
from gsapp.quantities.constants import FOOT

USUAL: Final = 4.0
"""What is usual counts as much as so many maneuvers seen."""
UNHEARD: Final = 1.0, 0.9
"""Mean and spread of the logarithm of what air nobody has heard does to bounds.

In calm air they are what the instruments allow; in gusts of 0.8 m/s ten times that.
"""
FIT: Final = frozenset({"good", "too-small", "too-fast", "too-slow", "not-trimmed"})
"""Verdicts on maneuvers that say something of the derivatives all the same."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Habit:
    """One number that maneuvers miss: mean and standard deviation, with what is usual in it.

    Attributes
    ----------
    mean, spread : float
    seen : int
    """

    mean: float
    spread: float
    seen: int = 0

    def after(self, values: Sequence[float]) -> Habit:
        """Return the habit once another maneuver was seen, with all that it showed of it."""
        weight = USUAL + self.seen
        value = float(np.mean(values))
        miss = value - self.mean
        mean = self.mean + miss / (weight + 1.0)
        seen = miss * (value - mean) + float(np.var(values))
        variance = (weight * self.spread**2 + seen) / (weight + 1.0)
        return Habit(mean=mean, spread=math.sqrt(variance), seen=self.seen + 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Habits:
    """All habits that matter for what a card brings.

    Attributes
    ----------
    size, width : Habit
        Logarithms of amplitude and of width over those asked for.
    speed : Habit
        Off the test point, m/s.
    surprise : Habit
        Logarithm of the bound under the noise that there was over the one expected for the same
        input as it was flown: noise and gusts are never twice the same.
    hands_off : Habit
        Seconds after the input that belong to the maneuver.
    tried, fit : int
        Maneuvers flown, and those that said something.
    """

    size: Habit = Habit(mean=0.0, spread=0.12)
    width: Habit = Habit(mean=0.0, spread=0.12)
    speed: Habit = Habit(mean=0.0, spread=3.0 * FOOT)
    surprise: Habit = Habit(mean=0.0, spread=0.5)
    hands_off: Habit = Habit(mean=4.0, spread=0.8)
    tried: int = 0
    fit: int = 0

    @property
    def fit_share(self) -> float:
        """Return the share of maneuvers that will be fit; four of five to begin with."""
        return (0.8 * USUAL + self.fit) / (USUAL + self.tried)

    def after(self, verdict: Verdict, card: TestCard | None) -> Habits:
        """Return the habits once another maneuver was judged.

        Parameters
        ----------
        verdict : Verdict
        card : TestCard or None
            That it was flown for.
        """
        fit = verdict.result in FIT
        found = replace(self, tried=self.tried + 1, fit=self.fit + fit)
        if not fit:
            return found
        found = replace(
            found, hands_off=self.hands_off.after([verdict.t_end - verdict.t_input_end])
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
            if width > 0.0 and len(verdict.halves[name]) == len(SHAPES.get(card.kind, ()))
        ]
        if sizes:
            found = replace(found, size=self.size.after([float(np.mean(sizes))]))
        if widths and card.kind == "doublet":
            found = replace(found, width=self.width.after([float(np.mean(widths))]))
        if verdict.V is not None:
            found = replace(found, speed=self.speed.after([verdict.V - card.speed]))
        return found

    def surprised(self, ratios: Sequence[float]) -> Habits:
        """Return the habits once bounds were so many times as large as expected."""
        return replace(self, surprise=self.surprise.after([math.log(one) for one in ratios]))


def executions(card: TestCard, habits: Habits, count: int) -> tuple[Execution, ...]:
    """Return how a card may turn out: `count` draws, the same ones every time.

    Sizes and widths miss together over a maneuver, and by half as much again from step to step
    and from surface to surface. Draws come in pairs that miss to opposite sides.
    """
    random = np.random.default_rng(len(card.surfaces))
    steps = len(SHAPES.get(card.kind, SHAPES["doublet"]))
    width = 4 + 2 * len(card.surfaces) * steps
    half = random.standard_normal(((count + 1) // 2, width))
    draws = np.concatenate((half, -half))[:count]
    return tuple(_execution(card, habits, draw.tolist(), steps) for draw in draws)


def _execution(card: TestCard, habits: Habits, draw: list[float], steps: int) -> Execution:
    size, width, speed, hands_off, *rest = draw
    single = iter(rest)

    def factors(habit: Habit, common: float) -> Mapping[str, tuple[float, ...]]:
        return {
            name: tuple(
                math.exp(habit.mean + habit.spread * (common + 0.5 * next(single)))
                for _ in range(steps)
            )
            for name in card.surfaces
        }

    sizes, widths = factors(habits.size, size), factors(habits.width, width)
    return Execution(
        sizes=sizes,
        widths=widths,
        stagger=math.exp(habits.width.mean + habits.width.spread * width),
        speed_off=habits.speed.mean + habits.speed.spread * speed,
        hands_off=max(1.0, habits.hands_off.mean + habits.hands_off.spread * hands_off),
    )
