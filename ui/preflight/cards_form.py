"""What stands on a test card, and how the cards stand, in words. No Qt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, get_args

from gsapp.flight.cards import CardProgress, CardSet, CardsFlown, TestCard
from gsapp.flight.cards.card import SURFACES, Kind
from gsapp.quantities import from_si
from ui.frame.steps import StepState
from ui.preflight.big_list import BigLine
from ui.preflight.card_form import CardValue
from ui.words import count_text, number_text, unit_text

_KINDS = {"doublet": "Doublet", "3-2-1-1": "3-2-1-1", "pulse": "Pulse", "multistep": "Multistep",
          "sweep": "Sweep"}  # fmt: skip
_ORDERS = ("de", "da", "dr", "da,dr", "dr,da")
_SPEED = {"US": "ft/s", "SI": "m/s"}


def _key(row: int, name: str) -> tuple[str, ...]:
    return ("cards", str(row), *name.split("."))


def _number(
    row: int, key: str, name: str, quantity: str, us: str, si: str, digits: int
) -> CardValue:
    return CardValue(
        key=_key(row, key), name=name, kind="number", quantity=quantity, us=us, si=si,
        digits=digits,
    )  # fmt: skip


def card_values(row: int) -> tuple[CardValue, ...]:
    """Return the values of a card, but for its surfaces and their amplitudes."""
    kinds = tuple((name, _KINDS[name]) for name in get_args(Kind))
    return (
        CardValue(key=_key(row, "id"), name="Said over the radio"),
        CardValue(key=_key(row, "title"), name="Title"),
        _number(row, "speed", "Speed", "speed", "ft/s", "m/s", 1),
        _number(row, "alpha", "Angle of attack", "angle", "deg", "deg", 1),
        _number(row, "height", "Height", "length", "ft", "m", 0),
        _number(row, "flap", "Flap", "angle", "deg", "deg", 1),
        CardValue(key=_key(row, "kind"), name="Input", kind="choice", choices=kinds),
        _number(row, "width", "Width of a step", "time", "s", "s", 2),
        CardValue(key=_key(row, "repeats"), name="Good ones wanted", kind="whole"),
        CardValue(key=_key(row, "remarks"), name="For the pilot", kind="lines"),
    )


def tolerance_values(row: int) -> tuple[CardValue, ...]:
    """Return how far off still counts."""
    return (
        _number(row, "tolerance.speed", "Speed ±", "speed", "ft/s", "m/s", 1),
        _number(row, "tolerance.alpha", "Angle of attack ±", "angle", "deg", "deg", 1),
        _number(row, "tolerance.amplitude", "Amplitude ±", "ratio", "%", "%", 0),
        _number(row, "tolerance.width", "Width ±", "ratio", "%", "%", 0),
    )


def surfaces_value(row: int, present: Sequence[str] = ()) -> CardValue:
    """Return which surfaces are moved, in their order."""
    orders = list(_ORDERS)
    if present and ",".join(present) not in orders:
        orders.append(",".join(present))
    return CardValue(
        key=_key(row, "surfaces"), name="Surfaces", kind="choice",
        choices=tuple((order, _order_words(order)) for order in orders),
    )  # fmt: skip


def _order_words(order: str) -> str:
    return ", then ".join(SURFACES[name] for name in order.split(",")).capitalize()


def amplitude_value(row: int, surface: str, *, alone: bool) -> CardValue:
    """Return how far a surface is moved: half of peak to peak."""
    key = "amplitude" if alone else f"amplitude.{surface}"
    name = "Amplitude ±" if alone else f"{SURFACES[surface].capitalize()} ±"
    return _number(row, key, name, "angle", "deg", "deg", 1)


def with_surfaces(card: Mapping[str, Any], surfaces: Sequence[str]) -> dict[str, Any]:
    """Return a card, as its file holds it, that moves other surfaces as far as the ones before."""
    former = card["amplitude"]
    sizes = former if isinstance(former, Mapping) else dict.fromkeys(card["surfaces"], former)
    usual = next(iter(sizes.values()))
    amplitude: Any = {name: sizes.get(name, usual) for name in surfaces}
    if len(surfaces) == 1:
        amplitude = amplitude[surfaces[0]]
    return {**card, "surfaces": list(surfaces), "amplitude": amplitude}


def card_line(card: TestCard, progress: CardProgress | None, system: str) -> BigLine:
    """Return a card as a line of the list."""
    unit = _SPEED[system]
    speed = number_text(from_si(card.speed, unit, "speed"), 0 if system == "US" else 1)
    sizes = ", ".join(
        f"{SURFACES[name]} ±{number_text(from_si(size, 'deg', 'angle'), 1)}°"
        for name, size in card.amplitudes.items()
    )
    parts = [f"{speed} {unit_text(unit)}", f"{card.kind}", sizes, f"{card.width:g} s"]
    state, words, note = "plain", count_text(card.repeats, "time"), ""
    if progress is not None:
        words = f"{progress.good} of {card.repeats}"
        state = "good" if progress.state == "done" else "unknown"
        note = {"done": "done", "begun": "begun", "open": "not yet"}[progress.state]
        misses = [attempt for attempt in progress.attempts if attempt.reasons]
        if misses and progress.state != "done":
            parts.append(f"last miss: {misses[-1].reasons[0]}")
    return BigLine(
        key=card.id, words=f"{card.id}  {card.heading}", more=" · ".join(parts), state=state,
        state_words=words, note=note,
    )  # fmt: skip


def cards_state(
    cards: CardSet,
    flown: CardsFlown | None,
    problems: Sequence[str],
    *,
    own: bool,
    flies: bool,
) -> StepState:
    """Return how the step stands.

    Parameters
    ----------
    cards : CardSet
    flown : CardsFlown or None
        What was flown for them; None before anybody looked.
    problems : sequence of str
        What is wrong with values.
    own : bool
        Whether a crew planned them; else they are those that come with the program.
    flies : bool
        Whether a flight is open: without cards of its own it has none, as the pilot's page says.
    """
    count = count_text(len(cards.cards), "card")
    if problems:
        words = f"{count_text(len(problems), 'value')} wrong"
        return StepState(state="warning", words=words, detail=". ".join(problems))
    if flies and not own:
        return StepState(words="none in this flight", detail=f"{count} as shipped to choose from")
    if flown is None:
        repeats = sum(card.repeats for card in cards.cards)
        return StepState(
            state="good" if own else "plain",
            words=f"{count} planned" if own else f"{count} as shipped",
            detail=f"{cards.name}: {count_text(repeats, 'maneuver')}",
        )
    done = sum(one.state == "done" for one in flown.cards)
    return StepState(
        state="good" if flown.done else "plain",
        words=f"{done} of {count} done",
        detail=f"{count_text(len(flown.unplanned), 'maneuver')} beside the cards",
    )
