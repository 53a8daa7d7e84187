"""The test cards of a flight: planned, changed, and compared with what was flown. No Qt."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from gsapp.aircraft import Aircraft
from gsapp.flight.cards import (
    CardProgress,
    CardSet,
    CardSetProgress,
    TestCard,
    match_cards,
    shipped_cards,
)
from gsapp.flight.cards.card import CardInputKind
from gsapp.flight.file_names import CARDS_FILE
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers import DetectedManeuver, collect_maneuvers
from gsapp.flight.toml_document import CardSetFile
from gsapp.foundation import FlightError, GroundStationError
from gsapp.quantities import SURFACE_NAMES, from_si
from gsapp.session import Session
from ui.icons import IndicatorState
from ui.number_format import count_text, number_text, unit_text
from ui.preflight.flight_card_fields import CardField
from ui.preflight.form_editor import FormEditor
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
        _number(row, "throttle_step", tr("Throttle step"), "ratio", "%", "%", 0),
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
    if card.flap:
        flap = number_text(from_si(card.flap, "deg", "angle"), 0)
        parts.append(tr("flap {angle}°").format(angle=flap))
    if card.throttle_step:
        parts.append(tr("then throttle {step} %").format(step=f"{100.0 * card.throttle_step:+.0f}"))
    state: IndicatorState = "plain"
    text, note = count_text(card.repeats, "time"), ""
    if progress is not None:
        text = tr("{good_count} of {repeats}").format(
            good_count=progress.good_count, repeats=card.repeats
        )
        state = "good" if progress.state == "done" else "unknown"
        note = {"done": tr("done"), "begun": tr("begun"), "open": tr("not yet")}[progress.state]
        misses = [attempt for attempt in progress.attempts if attempt.reasons]
        if misses and progress.state != "done":
            parts.append(tr("last miss: {reason}").format(reason=misses[-1].reasons[0]))
    return StatusListItem(
        key=card.id, text=f"{card.id}  {card.display_title}", detail=" · ".join(parts), state=state,
        state_text=text, note=note,
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
    flown : CardSetProgress or None
        What was flown for them; None before anybody looked.
    own : bool
        Whether a crew planned them; else they are those that come with the program.
    flies : bool
        Whether a flight is open: without cards of its own it has none, as the pilot's page says.
    """
    count = count_text(len(cards.cards), "card")
    if problems:
        text = tr("{values} wrong").format(values=count_text(len(problems), "value"))
        return StepStatus(state="warning", text=text, detail=". ".join(problems))
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


_CARDS = ("cards",)


def _is_same_but_id(one: TestCard, other: TestCard) -> bool:
    return one.model_copy(update={"id": other.id}) == other


class CardSetModel:
    """One set of cards."""

    def __init__(self) -> None:
        self.editor: FormEditor[CardSet] | None = None
        self.session: Session | None = None
        self.flown: CardSetProgress | None = None
        self.read_error = ""
        self._aircraft: Aircraft | None = None
        self._maneuvers: tuple[DetectedManeuver, ...] | None = None

    def set_flight(self, session: Session | None, folder: Path, aircraft: Aircraft | None) -> None:
        """Take the cards of another flight, or of the next one."""
        self.session, self._aircraft = session, aircraft
        self.flown = self._maneuvers = None
        self.read_error = ""
        names = shipped_cards()
        name = "" if aircraft is None else aircraft.name.casefold()
        try:
            file = CardSetFile(folder / CARDS_FILE, name if name in names else names[0])
        except GroundStationError as error:
            self.editor = None
            self.read_error = str(error)
        else:
            self.editor = FormEditor(file)

    @property
    def file(self) -> CardSetFile | None:
        file = None if self.editor is None else self.editor.file
        return file if isinstance(file, CardSetFile) else None

    @property
    def cards(self) -> CardSet | None:
        return None if self.editor is None else self.editor.file.model

    @property
    def state(self) -> StepStatus:
        if self.editor is None:
            return StepStatus(state="warning", text=tr("cannot be read"), detail=self.read_error)
        file = self.editor.file
        problems = tuple(self.editor.problems.values())
        flies = self.session is not None
        return find_cards_state(
            file.model, self.flown, problems, own=file.path.exists(), flies=flies
        )

    def progress(self, card_id: str) -> CardProgress | None:
        """Return what was flown for a card; None before anybody looked."""
        found = () if self.flown is None else self.flown.cards
        return next((one for one in found if one.card.id == card_id), None)

    # Changes

    def add(self, row: int) -> int:
        """Put a copy of a card below it; return where it stands."""
        file, editor = self.file, self.editor
        if file is not None and editor is not None:
            editor.set_values({_CARDS: file.with_duplicated_row(row)})
        return row + 1

    def insert_first(self, cards: Sequence[TestCard]) -> tuple[str, ...]:
        """Put cards before all others, where they are not there yet; return their ids.

        Raise FlightError if they cannot be written.
        """
        file, editor = self.file, self.editor
        if file is None or editor is None:
            return ()
        held = {card.id: card for card in file.model.cards}
        ids, new = [], []
        for card in cards:
            name = next((name for name, one in held.items() if _is_same_but_id(one, card)), None)
            if name is None:
                numbers = (f"X{number}" for number in itertools.count(1))
                name = next(one for one in numbers if one not in held)
                held[name] = card.model_copy(update={"id": name})
                new.append(held[name])
            ids.append(name)
        if new:
            editor.set_values({_CARDS: [*CardSet(cards=tuple(new)).content()["cards"], *file.rows]})
            editor.save()
        return tuple(ids)

    def remove(self, row: int) -> bool:
        """Take a card out; return whether it could go: the last one stays."""
        file, editor = self.file, self.editor
        if file is None or editor is None or len(file.rows) < 2:
            return False
        rows = file.rows
        del rows[row]
        return editor.set_values({_CARDS: rows})

    def move(self, row: int, steps: int) -> int:
        """Move a card up or down; return where it stands now."""
        file, editor = self.file, self.editor
        if file is None or editor is None:
            return row
        rows = file.rows
        target = min(max(row + steps, 0), len(rows) - 1)
        if target != row:
            rows.insert(target, rows.pop(row))
            editor.set_values({_CARDS: rows})
        return target

    def import_cards(self, path: Path) -> None:
        """Take the set of another file in place of this one; it can be taken back."""
        if self.editor is not None:
            content = CardSetFile(path, "").content
            keys = dict.fromkeys((*self.editor.file.content, *content))
            self.editor.set_values({(key,): content.get(key) for key in keys})

    # What was flown

    def loadable_flight(self) -> Flight | None:
        """Return the open flight up to now, to be searched; None where there is nothing."""
        session = self.session
        if session is None or self._aircraft is None or session.now is None:
            return None
        flight = session.flight()
        return flight if len(flight.block) else None

    def find_maneuvers(self, flight: Flight) -> tuple[DetectedManeuver, ...]:
        """Return the maneuvers of a flight; for the thread of a work."""
        if self._aircraft is None:
            return ()
        try:
            return collect_maneuvers(flight, self._aircraft).maneuvers
        except FlightError:
            # Nothing that moves was measured yet.
            return ()

    def set_maneuvers(self, maneuvers: tuple[DetectedManeuver, ...]) -> None:
        """Compare the cards with what was flown."""
        self._maneuvers = maneuvers
        self.compare_with_flight()

    def compare_with_flight(self) -> None:
        """Compare again, after the cards were changed."""
        cards = self.cards
        if self._maneuvers is not None and cards is not None:
            self.flown = match_cards(cards, self._maneuvers)
