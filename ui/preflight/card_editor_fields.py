"""What stands on a test card, and how the cards stand, in words. No Qt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, get_args

from gsapp.flight.cards import CardProgress, CardSet, CardSetProgress, TestCard
from gsapp.flight.cards.card import CardInputKind
from gsapp.quantities import SURFACE_NAMES, from_si
from ui.icons import IndicatorState
from ui.number_format import count_text, number_text, unit_text
from ui.preflight.flight_card_fields import CardField
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.status_list import StatusListItem
from ui.window_frame.page_steps import StepStatus

_KIND_TITLES = {
    "doublet": QT_TR_NOOP("Doublet"), "3-2-1-1": "3-2-1-1", "pulse": QT_TR_NOOP("Pulse"),
    "multistep": QT_TR_NOOP("Multistep"), "sweep": QT_TR_NOOP("Sweep"),
}  # fmt: skip
_SURFACE_ORDERS = ("de", "da", "dr", "da,dr", "dr,da")
_SPEED_UNITS = {"US": "ft/s", "SI": "m/s"}


def _key(row: int, name: str) -> tuple[str, ...]:
    return ("cards", str(row), *name.split("."))


def _number(
    row: int, key: str, name: str, quantity: str, us: str, si: str, digits: int
) -> CardField:
    return CardField(
        key=_key(row, key), name=name, kind="number", quantity=quantity, us=us, si=si,
        digits=digits,
    )  # fmt: skip


def create_card_fields(row: int) -> tuple[CardField, ...]:
    """Return the values of a card, but for its surfaces and their amplitudes."""
    kinds = tuple((name, _KIND_TITLES[name]) for name in get_args(CardInputKind))
    return (
        CardField(key=_key(row, "id"), name=tr("Radio call")),
        CardField(key=_key(row, "title"), name=tr("Title")),
        _number(row, "speed", tr("Speed"), "speed", "ft/s", "m/s", 1),
        _number(row, "alpha", tr("Angle of attack"), "angle", "deg", "deg", 1),
        _number(row, "height", tr("Height"), "length", "ft", "m", 0),
        _number(row, "flap", tr("Flap"), "angle", "deg", "deg", 1),
        CardField(key=_key(row, "kind"), name=tr("Input"), kind="choice", choices=kinds),
        _number(row, "width", tr("Width of a step"), "time", "s", "s", 2),
        CardField(key=_key(row, "repeats"), name=tr("Good repeats required"), kind="whole"),
        CardField(key=_key(row, "remarks"), name=tr("For the pilot"), kind="lines"),
    )


def create_tolerance_fields(row: int) -> tuple[CardField, ...]:
    """Return how far off still counts."""
    return (
        _number(row, "tolerance.speed", tr("Speed ±"), "speed", "ft/s", "m/s", 1),
        _number(row, "tolerance.alpha", tr("Angle of attack ±"), "angle", "deg", "deg", 1),
        _number(row, "tolerance.amplitude", tr("Amplitude ±"), "ratio", "%", "%", 0),
        _number(row, "tolerance.width", tr("Width ±"), "ratio", "%", "%", 0),
    )


def create_surfaces_field(row: int, present: Sequence[str] = ()) -> CardField:
    """Return which surfaces are moved, in their order."""
    orders = list(_SURFACE_ORDERS)
    if present and ",".join(present) not in orders:
        orders.append(",".join(present))
    return CardField(
        key=_key(row, "surfaces"), name=tr("Surfaces"), kind="choice",
        choices=tuple((order, _order_text(order)) for order in orders),
    )  # fmt: skip


def _order_text(order: str) -> str:
    return tr(", then ").join(SURFACE_NAMES[name] for name in order.split(",")).capitalize()


def create_amplitude_field(row: int, surface: str, *, alone: bool) -> CardField:
    """Return how far a surface is moved: half of peak to peak."""
    key = "amplitude" if alone else f"amplitude.{surface}"
    name = tr("Amplitude ±") if alone else f"{SURFACE_NAMES[surface].capitalize()} ±"
    return _number(row, key, name, "angle", "deg", "deg", 1)


def replace_surfaces(card: Mapping[str, Any], surfaces: Sequence[str]) -> dict[str, Any]:
    """Return a card, as its file holds it, that moves other surfaces as far as the ones before."""
    former = card["amplitude"]
    sizes = former if isinstance(former, Mapping) else dict.fromkeys(card["surfaces"], former)
    usual = next(iter(sizes.values()))
    amplitude: Any = {name: sizes.get(name, usual) for name in surfaces}
    if len(surfaces) == 1:
        amplitude = amplitude[surfaces[0]]
    return {**card, "surfaces": list(surfaces), "amplitude": amplitude}


def build_card_item(card: TestCard, progress: CardProgress | None, system: str) -> StatusListItem:
    """Return a card as a line of the list."""
    unit = _SPEED_UNITS[system]
    speed = number_text(from_si(card.speed, unit, "speed"), 0 if system == "US" else 1)
    sizes = ", ".join(
        f"{SURFACE_NAMES[name]} ±{number_text(from_si(size, 'deg', 'angle'), 1)}°"
        for name, size in card.amplitudes.items()
    )
    parts = [f"{speed} {unit_text(unit)}", f"{card.kind}", sizes, f"{card.width:g} s"]
    state: IndicatorState = "plain"
    words, note = count_text(card.repeats, "time"), ""
    if progress is not None:
        words = tr("{good_count} of {repeats}").format(
            good_count=progress.good_count, repeats=card.repeats
        )
        state = "good" if progress.state == "done" else "unknown"
        note = {"done": tr("done"), "begun": tr("begun"), "open": tr("not yet")}[progress.state]
        misses = [attempt for attempt in progress.attempts if attempt.reasons]
        if misses and progress.state != "done":
            parts.append(tr("last miss: {reason}").format(reason=misses[-1].reasons[0]))
    return StatusListItem(
        key=card.id, text=f"{card.id}  {card.display_title}", detail=" · ".join(parts), state=state,
        state_text=words, note=note,
    )  # fmt: skip


def find_cards_state(
    cards: CardSet,
    flown: CardSetProgress | None,
    problems: Sequence[str],
    *,
    own: bool,
    flies: bool,
) -> StepStatus:
    """Return how the step stands.

    Parameters
    ----------
    cards : CardSet
    flown : CardSetProgress or None
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
        words = tr("{values} wrong").format(values=count_text(len(problems), "value"))
        return StepStatus(state="warning", text=words, detail=". ".join(problems))
    if flies and not own:
        return StepStatus(
            text=tr("none in this flight"),
            detail=tr("{count} shipped sets to choose from").format(count=count),
        )
    if flown is None:
        repeats = sum(card.repeats for card in cards.cards)
        return StepStatus(
            state="good" if own else "plain",
            text=tr("{count} planned").format(count=count)
            if own
            else tr("{count} as shipped").format(count=count),
            detail=f"{cards.name}: {count_text(repeats, 'maneuver')}",
        )
    done = sum(one.state == "done" for one in flown.cards)
    return StepStatus(
        state="good" if flown.is_complete else "plain",
        text=tr("{done} of {count} done").format(done=done, count=count),
        detail=tr("{maneuvers} not on a card").format(
            maneuvers=count_text(len(flown.unplanned), "maneuver")
        ),
    )
