"""Test cards: the maneuvers and test points that a flight is made for, as a file.

::

    name = "B777, longitudinal"

    [[cards]]
    id = "E1"
    speed = "100 ft/s"
    surfaces = ["de"]
    amplitude = "4 deg"
    width = "0.45 s"
    repeats = 3
    [cards.tolerance]
    speed = "5 ft/s"
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import Field, field_validator, model_validator

from gsapp.flight.atomic_files import write_flight_file
from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.foundation import StrictModel, read_toml
from gsapp.foundation.files import ShippedFiles
from gsapp.foundation.toml import toml_text
from gsapp.quantities import SURFACE_NAMES, from_si
from gsapp.quantities.constants import DEGREE, FOOT
from gsapp.quantities.fields import Angle, Length, Ratio, Speed, Time

SHIPPED_CARDS: Final = ShippedFiles(folder=Path(__file__).parent / "files", kind="test cards")

CardSurface = Literal["de", "da", "dr"]
CardInputKind = Literal["doublet", "3-2-1-1", "pulse", "multistep", "sweep"]

STEP_COUNTS: Final[Mapping[str, int]] = {"doublet": 2, "3-2-1-1": 7, "pulse": 1}
"""How many widths an input lasts; the others have no width of one step."""


_UNITS: Final[Mapping[str, str]] = {
    "speed": "m/s",
    "alpha": "rad",
    "height": "m",
    "flap": "rad",
    "amplitude": "rad",
    "width": "s",
}
_RATIOS = ("amplitude", "width")


class Tolerance(StrictModel):
    """How far a maneuver may be from its card and still count."""

    speed: Speed = 5.0 * FOOT
    """m/s to either side."""
    alpha: Angle = 1.5 * DEGREE
    """rad to either side."""
    amplitude: Ratio = 0.35
    width: Ratio = 0.35
    """Shares of what the card asks for."""

    @field_validator("speed", "alpha", "amplitude", "width")
    @classmethod
    def _must_leave_room(cls, value: float) -> float:
        if not value > 0.0:
            raise ValueError("must be greater than zero")
        return value


class TestCard(StrictModel):
    """One planned maneuver, to be flown `repeats` times."""

    __test__ = False  # the name is the field's; it is no test of ours

    id: str
    """Short, said over the radio: ``E1``."""
    title: str = ""
    """In words; `display_title` makes one where it is left out."""
    speed: Speed
    """Airspeed at the start, m/s."""
    alpha: Angle | None = None
    """Angle of attack at the start, rad; at 1 g the speed fixes it, so most cards leave it out."""
    height: Length | None = None
    """Above the field, m."""
    flap: Angle = 0.0
    """rad."""
    throttle_step: Ratio = 0.0
    """By how much the throttle is moved as the input ends, and held: -0.4 is 40 % less."""
    surfaces: tuple[CardSurface, ...]
    """``de``, ``da``, ``dr``: those moved, in the order in which they are moved."""
    kind: CardInputKind = "doublet"
    """Shape of each input."""
    amplitude: Angle | Mapping[CardSurface, Angle]
    """Half the peak-to-peak deflection, rad; one for all surfaces, or by surface."""
    width: Time
    """Of one step, s: a doublet lasts two, a 3-2-1-1 seven. Of a sweep, all of it."""
    repeats: int = 1
    """How many good ones are wanted."""
    tolerance: Tolerance = Tolerance()
    remarks: str = ""
    """For the pilot: ``half stick, high rate``."""

    @field_validator("id")
    @classmethod
    def _must_be_said(cls, value: str) -> str:
        if not value.strip():
            raise ValueError("is empty; give a short one such as E1")
        return value

    @field_validator("speed")
    @classmethod
    def _must_fly(cls, value: float) -> float:
        if not 0.0 < value < 200.0:
            raise ValueError("is not a plausible speed; write the airspeed at the start")
        return value

    @field_validator("surfaces")
    @classmethod
    def _must_move(cls, value: tuple[CardSurface, ...]) -> tuple[CardSurface, ...]:
        if not value or len(set(value)) != len(value):
            raise ValueError('names none, or one twice; write those moved, such as ["da", "dr"]')
        return value

    @field_validator("amplitude")
    @classmethod
    def _must_be_an_angle(cls, value: float | Mapping[CardSurface, float]) -> Any:
        sizes = value.values() if isinstance(value, Mapping) else (value,)
        if any(not 0.0 < size < FLIGHT_DATA.max_amplitude for size in sizes):
            raise ValueError("must lie between 0 and 45 deg; it is half of peak to peak")
        return value

    @field_validator("throttle_step")
    @classmethod
    def _must_be_a_share(cls, value: float) -> float:
        if not -1.0 <= value <= 1.0:
            raise ValueError("must lie from -1 to 1; 0.4 is 40 % more throttle")
        return value

    @field_validator("width")
    @classmethod
    def _must_be_a_time(cls, value: float) -> float:
        low, high = FLIGHT_DATA.step_range
        if not low <= value <= high:
            raise ValueError(f"must lie from {low:g} to {high:g} s; check its unit")
        return value

    @field_validator("repeats")
    @classmethod
    def _must_be_flown(cls, value: int) -> int:
        if not 1 <= value <= FLIGHT_DATA.max_repeats:
            raise ValueError(
                f"must lie from 1 to {FLIGHT_DATA.max_repeats}; write the number of good repeats"
            )
        return value

    @model_validator(mode="after")
    def _must_fit_the_surfaces(self) -> TestCard:
        sizes = self.amplitude
        if isinstance(sizes, Mapping) and set(sizes) != set(self.surfaces):
            raise ValueError(
                f"amplitude is given for {', '.join(sizes)}, but {', '.join(self.surfaces)} move; "
                "give one for each of them"
            )
        return self

    @property
    def amplitudes(self) -> Mapping[str, float]:
        """Return the amplitude of each surface, rad."""
        given = self.amplitude
        if isinstance(given, Mapping):
            return {name: given[name] for name in self.surfaces}
        return dict.fromkeys(self.surfaces, given)

    @property
    def duration(self) -> float:
        """Return how long the input of one surface lasts, s."""
        return self.width * STEP_COUNTS.get(self.kind, 1)

    @property
    def display_title(self) -> str:
        """Return the title, or one made of surfaces and shape."""
        surfaces = " and ".join(SURFACE_NAMES[name] for name in self.surfaces)
        return self.title or f"{surfaces} {self.kind}".capitalize()


class CardSet(StrictModel):
    """A file of test cards."""

    name: str = ""
    """What the set is called."""
    aircraft: str = ""
    """Name of the aircraft it is made for; empty for any."""
    remarks: str = ""
    cards: tuple[TestCard, ...] = Field(min_length=1)
    """In the order in which they are to be flown."""

    def card(self, card_id: str) -> TestCard | None:
        """Return the card of that id, or None."""
        return next((card for card in self.cards if card.id == card_id), None)

    def content(self) -> dict[str, Any]:
        """Return what a TOML file holds: values with units as text, defaults left out."""
        kept = self.model_dump(exclude_defaults=True)
        return {**kept, "cards": [_format_values(card) for card in kept["cards"]]}


def _format_values(values: Mapping[str, Any], unit: str | None = None) -> dict[str, Any]:
    content: dict[str, Any] = {}
    for key, value in values.items():
        own = unit or _UNITS.get(key)
        if isinstance(value, Mapping):
            # A tolerance is a share where the card's own value has a unit.
            plain = {name: value[name] for name in _RATIOS if key == "tolerance" and name in value}
            rest = {name: one for name, one in value.items() if name not in plain}
            content[key] = {**_format_values(rest, unit=own), **plain}
        elif isinstance(value, float) and own is not None:
            content[key] = f"{value!r} {own}"
        else:
            content[key] = list(value) if isinstance(value, tuple) else value
    return content


def shipped_cards() -> tuple[str, ...]:
    """Return the names of the sets that come with the program."""
    return SHIPPED_CARDS.names()


def load_cards(name_or_path: str | Path) -> CardSet:
    """Read a set of test cards: a path, or the name of a shipped set such as ``b777``."""
    return read_toml(SHIPPED_CARDS.find(name_or_path), CardSet, distinct="cards")


def save_cards(path: Path | str, cards: CardSet) -> Path:
    """Write a set of test cards, whole or not at all; values are written in SI."""
    return write_flight_file(path, toml_text(cards.content()))


CardState = Literal["open", "begun", "done"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt:
    """A maneuver flown for a card."""

    maneuver: DetectedManeuver
    deviations: Mapping[str, float]
    """By how many tolerances ``speed``, ``alpha``, ``amplitude`` and ``width`` missed the card,
    signed (positive: too fast, too large, too long); what was not measured is left out."""
    reasons: tuple[str, ...] = ()
    """Why it does not count, in words; empty if it does."""

    @property
    def is_counted(self) -> bool:
        return not self.reasons


@dataclass(frozen=True, slots=True, kw_only=True)
class CardProgress:
    """A card and what was flown for it."""

    card: TestCard
    attempts: tuple[Attempt, ...] = ()
    """In order of time, good and bad."""

    @property
    def good_count(self) -> int:
        return sum(attempt.is_counted for attempt in self.attempts)

    @property
    def remaining_count(self) -> int:
        return max(self.card.repeats - self.good_count, 0)

    @property
    def state(self) -> CardState:
        """Return ``done``, ``begun`` (some good ones) or ``open``."""
        if not self.remaining_count:
            return "done"
        return "begun" if self.good_count else "open"


@dataclass(frozen=True, slots=True, kw_only=True)
class CardSetProgress:
    """A whole set of cards and a flight's maneuvers."""

    cards: tuple[CardProgress, ...]
    """In the order of the set."""
    unplanned: tuple[DetectedManeuver, ...] = ()
    """Those that no card asks for."""

    @property
    def next_card(self) -> TestCard | None:
        """Return the first card with repeats missing; None once all are done."""
        return next((one.card for one in self.cards if one.remaining_count), None)

    @property
    def is_complete(self) -> bool:
        return self.next_card is None


def match_cards(cards: CardSet, maneuvers: Sequence[DetectedManeuver]) -> CardSetProgress:
    """Give each maneuver to the card that it comes nearest to.

    A maneuver belongs to a card of the same surfaces and the same shape. Among several it goes to
    one that it satisfies and that still misses repeats, else to the nearest. It counts if it lies
    within the card's tolerances and was not graded unfit (D).
    """
    attempts: dict[str, list[Attempt]] = {card.id: [] for card in cards.cards}
    good = dict.fromkeys(attempts, 0)
    unplanned: list[DetectedManeuver] = []
    for maneuver in maneuvers:
        fits = [
            (card, compare_with_card(card, maneuver))
            for card in cards.cards
            if _requests_maneuver(card, maneuver)
        ]
        if not fits:
            unplanned.append(maneuver)
            continue
        card, attempt = min(
            fits,
            key=lambda fit: (
                bool(fit[1].reasons),
                good[fit[0].id] >= fit[0].repeats,
                _distance(fit[1]),
            ),
        )
        attempts[card.id].append(attempt)
        good[card.id] += attempt.is_counted
    return CardSetProgress(
        cards=tuple(
            CardProgress(card=card, attempts=tuple(attempts[card.id])) for card in cards.cards
        ),
        unplanned=tuple(unplanned),
    )


def compare_with_card(card: TestCard, maneuver: DetectedManeuver) -> Attempt:
    """Return how well a maneuver meets a card, whatever its surfaces."""
    off = dict(_deviations(card, maneuver))
    reasons = [
        _deviation_text(name, share, card) for name, share in off.items() if abs(share) > 1.0
    ]
    if maneuver.grade == "D":
        reasons.append(f"graded unfit ({'; '.join(maneuver.reasons) or 'no reason given'})")
    return Attempt(maneuver=maneuver, deviations=off, reasons=tuple(reasons))


def _requests_maneuver(card: TestCard, maneuver: DetectedManeuver) -> bool:
    return set(card.surfaces) == set(maneuver.inputs) and card.kind == maneuver.kind


def _deviations(card: TestCard, maneuver: DetectedManeuver) -> Iterator[tuple[str, float]]:
    allowed = card.tolerance
    if maneuver.V is not None:
        yield "speed", (maneuver.V - card.speed) / allowed.speed
    if card.alpha is not None and maneuver.alpha is not None:
        yield "alpha", (maneuver.alpha - card.alpha) / allowed.alpha
    sizes = maneuver.amplitudes or _main_amplitude(card, maneuver)
    for name, wanted in card.amplitudes.items():
        if name in sizes:
            yield (
                f"amplitude of the {SURFACE_NAMES[name]}",
                (sizes[name] / wanted - 1.0) / (allowed.amplitude),
            )
    width = _width(card, maneuver)
    if width is not None:
        yield "width", (width / card.width - 1.0) / allowed.width


def _main_amplitude(card: TestCard, maneuver: DetectedManeuver) -> Mapping[str, float]:
    if maneuver.amplitude is None or len(card.surfaces) != 1:
        return {}
    return {card.surfaces[0]: maneuver.amplitude}


def _width(card: TestCard, maneuver: DetectedManeuver) -> float | None:
    """Return the length of one step, s; of staggered inputs it cannot be told from their span."""
    span = maneuver.t_input_end - maneuver.t_input
    if not math.isfinite(span) or card.kind not in STEP_COUNTS or len(card.surfaces) != 1:
        return None
    return span / STEP_COUNTS[card.kind]


def _distance(attempt: Attempt) -> float:
    return math.hypot(*attempt.deviations.values())


def _deviation_text(name: str, share: float, card: TestCard) -> str:
    """Return by how much a card was missed: ``7.0 ft/s too fast, 5.0 ft/s allowed``."""
    allowed = card.tolerance
    if name == "speed":
        limit, unit, sides = from_si(allowed.speed, "ft/s", "speed"), "ft/s", ("slow", "fast")
    elif name == "alpha":
        limit, unit, sides = from_si(allowed.alpha, "deg", "angle"), "deg", ("small", "large")
    elif name == "width":
        limit, unit, sides = 100.0 * allowed.width, "%", ("short", "long")
    else:
        limit, unit, sides = 100.0 * allowed.amplitude, "%", ("small", "large")
    digits = 0 if unit == "%" else 1
    missed = f"{abs(share) * limit:.{digits}f} {unit} too {sides[share > 0.0]}"
    return f"{name} {missed}, {limit:.{digits}f} {unit} allowed"
