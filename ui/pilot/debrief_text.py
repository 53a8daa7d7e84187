"""What the debrief says of each maneuver, of the cards, and of flights in a row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from gsapp.excitation.debrief import Debrief, EvaluatedManeuver, FlightTrend
from gsapp.quantities import SURFACE_NAMES, channel
from ui.icons import IndicatorState
from ui.number_format import (
    DASH,
    channel_value_text,
    clock_text,
    count_text,
    duration_text,
    number_text,
    percent_text,
)
from ui.pilot.pilot_text import RESULT_SIGNS, surfaces_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.status_list import StatusListItem

_RESULT_STATES: Final[Mapping[str, IndicatorState]] = {"good": "good", "unclear": "unknown"}
"""Signs of verdicts; all others are a caution."""


def debrief_headline(debrief: Debrief | None) -> str:
    """Return how the flight went, in one line."""
    if debrief is None:
        return tr("No flight with cues is open")
    flown = len(debrief.maneuvers)
    good = (
        tr("{good} of {inputs} good").format(good=debrief.good, inputs=count_text(flown, "input"))
        if flown
        else tr("no inputs yet")
    )
    words = f"{debrief.flight}: {good}"
    if debrief.score is not None:
        words += tr(" · {score} of the card set").format(score=percent_text(debrief.score))
    return words


def build_maneuver_item(judged: EvaluatedManeuver, units: str) -> StatusListItem:
    """Return one maneuver as a line of the list."""
    verdict = judged.verdict
    speed = "" if verdict.V is None else f", {channel_value_text(channel('V'), verdict.V, units)}"
    counts = tr("counts") if verdict.counts else ""
    return StatusListItem(
        key=verdict.id,
        text=f"{verdict.id}  {surfaces_text(verdict.surfaces)} {verdict.kind}",
        detail=f"{clock_text(verdict.t_input, decimals=1)}{speed}: {verdict.advice}",
        state=_RESULT_STATES.get(verdict.result, "caution"),
        state_text=tr(RESULT_SIGNS[verdict.result][0]).lower(),
        note=" ".join(filter(None, (verdict.card, counts))),
    )


def list_verdict_reasons(judged: EvaluatedManeuver, units: str) -> tuple[str, ...]:
    """Return why a maneuver got its verdict, and what was measured of it, as sentences."""
    verdict = judged.verdict
    said = [finding.words for finding in verdict.findings] or [tr("no objection")]
    said += [_input_shape_text(judged, name, units) for name in verdict.surfaces]
    moved = [f"{SURFACE_NAMES.get(name, name)} {_angle_text(name, size, units)}"
             for name, size in verdict.cross.items()]  # fmt: skip
    if moved:
        said.append(tr("also moved: {moved}").format(moved=", ".join(moved)))
    said.append(_input_start_text(judged))
    said += verdict.judged_by
    return tuple(said)


def _input_shape_text(judged: EvaluatedManeuver, name: str, units: str) -> str:
    """Return size, times and symmetry of what a surface did."""
    verdict, wanted = judged.verdict, judged.target_input
    words = SURFACE_NAMES.get(name, name)
    if name in verdict.amplitudes:
        words += f" {_angle_text(name, verdict.amplitudes[name], units)}"
    if wanted is not None and name in wanted.amplitudes:
        band = wanted.amplitudes[name]
        low, high = (_angle_text(name, limit, units) for limit in (band.low, band.high))
        words += tr(" (wanted {low} to {high})").format(low=low, high=high)
    halves = verdict.halves.get(name, ())
    if halves:
        words += tr(", steps of {steps} s").format(
            steps=", ".join(number_text(step, 2) for step in halves)
        )
    if name in verdict.symmetry:
        words += tr(", halves symmetric to {percent}").format(
            percent=percent_text(verdict.symmetry[name])
        )
    if name in verdict.left_over:
        words += tr(", {percent} residual").format(percent=percent_text(verdict.left_over[name]))
    return words


def _angle_text(name: str, value: float, units: str) -> str:
    return channel_value_text(channel(name), value, units)


def _input_start_text(judged: EvaluatedManeuver) -> str:
    """Return how it began: with GO or without, and what was off."""
    go = judged.go_at
    begun = judged.verdict.t_input
    words = (
        tr("started without GO")
        if go is None
        else tr("begun {duration} after GO").format(duration=duration_text(begun - go))
    )
    off = [f"{name} {number_text(share, 1)}" for name, share in judged.trim_deviations.items()]
    return (
        tr("{words}; deviations in tolerances: {off}").format(words=words, off=", ".join(off))
        if off
        else words
    )


CARD_COLUMN_TITLES: Final = (
    QT_TR_NOOP("Card"), "", QT_TR_NOOP("Good"), QT_TR_NOOP("Flown"), QT_TR_NOOP("Wanted"),
)  # fmt: skip


def build_card_rows(debrief: Debrief | None) -> tuple[tuple[str, ...], ...]:
    """Return the score by card as rows of a table."""
    cards = () if debrief is None else debrief.cards
    return tuple(
        (one.card, one.title, str(one.good), str(one.flown), str(one.requested)) for one in cards
    )


TREND_COLUMN_TITLES: Final = (
    QT_TR_NOOP("Flight"), QT_TR_NOOP("Good"), QT_TR_NOOP("Cards"),
    QT_TR_NOOP("Size flown / target"), QT_TR_NOOP("Trim deviation at start"), QT_TR_NOOP("Apart"),
)  # fmt: skip


def build_trend_rows(trends: Sequence[FlightTrend]) -> tuple[tuple[str, ...], ...]:
    """Return flights in a row as rows of a table, the newest first."""
    return tuple(
        (
            one.flight,
            tr("{good} of {inputs}").format(good=one.good, inputs=one.inputs),
            percent_text(one.score),
            _share_texts(
                {SURFACE_NAMES.get(name, name): value for name, value in one.amplitudes.items()}
            ),
            _share_texts(one.trim_errors),
            duration_text(one.seconds_each),
        )
        for one in reversed(trends)
    )


def _share_texts(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {number_text(value, 1)}" for name, value in values.items()) or DASH
