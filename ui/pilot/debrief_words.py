"""What the debrief says of each maneuver, of the cards, and of flights in a row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from gsapp.excitation.debrief import Debrief
from gsapp.excitation.debrief_maneuver import JudgedManeuver
from gsapp.excitation.debrief_trends import FlightTrend
from gsapp.flight.cards.card import SURFACES
from gsapp.quantities import channel
from ui.glyphs import State
from ui.pilot.wording import RESULTS, surfaces_text
from ui.preflight.big_list import BigLine
from ui.words import (
    DASH,
    clock_text,
    count_text,
    duration_text,
    number_text,
    percent_text,
    value_text,
)

_STATES: Final[Mapping[str, State]] = {"good": "good", "unclear": "unknown"}
"""Signs of verdicts; all others are a caution."""


def headline(debrief: Debrief | None) -> str:
    """Return how the flight went, in one line."""
    if debrief is None:
        return "No flight with cues is open"
    flown = len(debrief.maneuvers)
    good = f"{debrief.good} of {count_text(flown, 'input')} good" if flown else "no inputs yet"
    words = f"{debrief.flight}: {good}"
    if debrief.score is not None:
        words += f" · {percent_text(debrief.score)} of what the cards ask for"
    return words


def maneuver_line(judged: JudgedManeuver, units: str) -> BigLine:
    """Return one maneuver as a line of the list."""
    verdict = judged.verdict
    speed = "" if verdict.V is None else f", {value_text(channel('V'), verdict.V, units)}"
    counts = "counts" if verdict.counts else ""
    return BigLine(
        key=verdict.id,
        words=f"{verdict.id}  {surfaces_text(verdict.surfaces)} {verdict.kind}",
        more=f"{clock_text(verdict.t_input, decimals=1)}{speed}: {verdict.advice}",
        state=_STATES.get(verdict.result, "caution"),
        state_words=RESULTS[verdict.result][0].lower(),
        note=" ".join(filter(None, (verdict.card, counts))),
    )


def reasons(judged: JudgedManeuver, units: str) -> tuple[str, ...]:
    """Return why a maneuver got its verdict, and what was measured of it, as sentences."""
    verdict = judged.verdict
    said = [finding.words for finding in verdict.findings] or ["nothing speaks against it"]
    said += [_shape(judged, name, units) for name in verdict.surfaces]
    moved = [f"{SURFACES.get(name, name)} {_angle(name, size, units)}"
             for name, size in verdict.cross.items()]  # fmt: skip
    if moved:
        said.append(f"moved beside it: {', '.join(moved)}")
    said.append(_beginning(judged))
    said += verdict.judged_by
    return tuple(said)


def _shape(judged: JudgedManeuver, name: str, units: str) -> str:
    """Return size, times and symmetry of what a surface did."""
    verdict, wanted = judged.verdict, judged.wanted
    words = SURFACES.get(name, name)
    if name in verdict.amplitudes:
        words += f" {_angle(name, verdict.amplitudes[name], units)}"
    if wanted is not None and name in wanted.amplitudes:
        band = wanted.amplitudes[name]
        words += f" (wanted {_angle(name, band.low, units)} to {_angle(name, band.high, units)})"
    halves = verdict.halves.get(name, ())
    if halves:
        words += f", steps of {', '.join(number_text(step, 2) for step in halves)} s"
    if name in verdict.symmetry:
        words += f", halves alike to {percent_text(verdict.symmetry[name])}"
    if name in verdict.left_over:
        words += f", {percent_text(verdict.left_over[name])} left over"
    return words


def _angle(name: str, value: float, units: str) -> str:
    return value_text(channel(name), value, units)


def _beginning(judged: JudgedManeuver) -> str:
    """Return how it began: with GO or without, and what was off."""
    go = judged.go_at
    begun = judged.verdict.t_input
    words = "begun without GO" if go is None else f"begun {duration_text(begun - go)} after GO"
    off = [f"{name} {number_text(share, 1)}" for name, share in judged.off.items()]
    return f"{words}; off in tolerances: {', '.join(off)}" if off else words


CARD_HEADS: Final = ("Card", "", "Good", "Flown", "Wanted")


def card_rows(debrief: Debrief | None) -> tuple[tuple[str, ...], ...]:
    """Return the score by card as rows of a table."""
    cards = () if debrief is None else debrief.cards
    return tuple(
        (one.card, one.heading, str(one.good), str(one.flown), str(one.wanted)) for one in cards
    )


TREND_HEADS: Final = (
    "Flight", "Good", "Cards", "Size flown over wanted", "Off at the start", "Apart",
)  # fmt: skip


def trend_rows(trends: Sequence[FlightTrend]) -> tuple[tuple[str, ...], ...]:
    """Return flights in a row as rows of a table, the newest first."""
    return tuple(
        (
            one.flight,
            f"{one.good} of {one.inputs}",
            percent_text(one.score),
            _shares({SURFACES.get(name, name): value for name, value in one.amplitudes.items()}),
            _shares(one.trim_errors),
            duration_text(one.seconds_each),
        )
        for one in reversed(trends)
    )


def _shares(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {number_text(value, 1)}" for name, value in values.items()) or DASH
