"""A card in the few words that a pilot is told, and the time that it takes."""

from __future__ import annotations

from collections.abc import Mapping

from gsapp.excitation.settings import CUES
from gsapp.excitation.test_points.target_input import TargetInput
from gsapp.flight.cards import TestCard
from gsapp.flight.cards.card import STEP_COUNTS
from gsapp.quantities import SURFACE_NAMES, channel, from_si


def format_card(card: TestCard, system: str) -> str:
    """Return what is flown and where: "aileron and rudder doublet at 100 ft/s"."""
    spec = channel("V")
    unit = spec.display_unit(system)
    surfaces = " and ".join(SURFACE_NAMES[name] for name in card.surfaces)
    speed = from_si(card.speed, unit, spec.quantity)
    return f"{surfaces} {card.kind} at {speed:.0f} {unit}"


def format_stick_input(stick: Mapping[str, str]) -> str:
    """Return how the sticks move: "half stick, then two thirds rudder, low rate"."""
    told = list(stick.values())
    tails = {words.partition(", ")[2] for words in told}
    if len(told) > 1 and len(tails) == 1 and (tail := tails.pop()):
        told = [words.partition(", ")[0] for words in told]
        return f"{', then '.join(told)}, {tail}"
    return ", then ".join(told)


def input_duration(wanted: TargetInput | None) -> float:
    """Return how long an input takes from GO to the end of its hands-off interval, s."""
    if wanted is None:
        return 0.0
    moving = STEP_COUNTS.get(wanted.kind, 1) * wanted.width.best * len(wanted.surfaces)
    return CUES.reaction_time + moving + wanted.hands_off
