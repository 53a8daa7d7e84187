"""Bounds reached, and bounds to come."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivativeBound:
    """One derivative.

    Attributes
    ----------
    name : str
        ``Cn_r``.
    value : float
        Best value known now: estimated in flight if earned, else of the model.
    std : float or None
        Bound reached by the maneuvers flown; None before anything was learned.
    target : float or None
        Bound asked for; None for none.
    """

    name: str
    value: float
    std: float | None = None
    target: float | None = None

    @property
    def percent(self) -> float | None:
        """Return the bound in percent of the value; None where there is none, or no value."""
        return None if self.std is None or self.value == 0.0 else 100.0 * self.std / abs(self.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundReduction:
    """What a card does for one derivative.

    Attributes
    ----------
    name : str
    bound_before : float or None
        Bound now; None where nothing is known.
    bound_after : float
        Expected bound.
    low, high : float
        80 % band of the bound after.
    """

    name: str
    bound_before: float | None
    bound_after: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CardForecast:
    """What flying a card some more times would bring.

    Attributes
    ----------
    card : str
        Its id.
    repeats : int
        How many times.
    reductions : tuple of BoundReduction
        The largest first.
    score : float
        How much all bounds would shrink together: decides which card comes next.
    seconds : float
        Flight time that it takes.
    text : str
        "two more rudder-aileron doublets at 105 ft/s: C_nr from 35 % to 15 %".
    """

    card: str
    repeats: int
    reductions: tuple[BoundReduction, ...]
    score: float
    seconds: float
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlook:
    """What was learned, what comes next, what time there is for.

    Attributes
    ----------
    time : float
        Flight time, s.
    bounds : tuple of DerivativeBound
    best_forecast : CardForecast or None
        The card that gains most; None if nothing is left worth flying, or no card can be judged.
    forecasts : tuple of CardForecast
        One for each card with repeats missing, the best first.
    time_left : float or None
        Of the flight, by clock and fuel, s.
    maneuvers_left : int or None
        That fit into it.
    remarks : tuple of str
        What stands in for what is not known, in words.
    """

    time: float
    bounds: tuple[DerivativeBound, ...] = ()
    best_forecast: CardForecast | None = None
    forecasts: tuple[CardForecast, ...] = ()
    time_left: float | None = None
    maneuvers_left: int | None = None
    remarks: tuple[str, ...] = ()
