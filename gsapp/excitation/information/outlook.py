"""Bounds reached, and bounds to come."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivativeBound:
    """One derivative."""

    name: str
    """``Cn_r``."""
    value: float
    """Best value known now: estimated in flight if earned, else of the model."""
    std: float | None = None
    """Bound reached by the maneuvers flown; None before anything was learned."""
    target: float | None = None
    """Bound asked for; None for none."""

    @property
    def percent(self) -> float | None:
        """Return the bound in percent of the value; None where there is none, or no value."""
        return None if self.std is None or self.value == 0.0 else 100.0 * self.std / abs(self.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundReduction:
    """What a card does for one derivative."""

    name: str
    bound_before: float | None
    """Bound now; None where nothing is known."""
    bound_after: float
    """Expected bound."""
    low: float
    high: float
    """80 % band of the bound after."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CardForecast:
    """What flying a card some more times would bring."""

    card: str
    repeats: int
    """How many times."""
    reductions: tuple[BoundReduction, ...]
    score: float
    """How much all bounds would shrink together: decides which card comes next."""
    seconds: float
    """Flight time that it takes."""
    text: str
    """"two more rudder-aileron doublets at 105 ft/s: Cn_r from 35 % to 15 %"."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlook:
    """What was learned, what comes next, what time there is for."""

    time: float
    """Flight time, s."""
    bounds: tuple[DerivativeBound, ...] = ()
    best_forecast: CardForecast | None = None
    """The card that gains most; None if nothing is left worth flying, or no card can be judged."""
    forecasts: tuple[CardForecast, ...] = ()
    """One for each card with repeats missing, the best first."""
    time_left: float | None = None
    """Of the flight, by clock and fuel, s."""
    maneuvers_left: int | None = None
    """That fit into it."""
    remarks: tuple[str, ...] = ()
    """What stands in for what is not known, in words."""
