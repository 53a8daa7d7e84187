"""From the cues of a session to what stands on the page. No Qt."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from gsapp.excitation.alerts.alert import Alert, AlertLevel
from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.doublets.verdict import InputInProgress, InputVerdict
from gsapp.excitation.test_points.point import TargetInput
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.flight.cards import TestCard
from gsapp.quantities import SURFACE_NAMES, convert_text_units
from ui.display_limits import DISPLAY
from ui.number_format import (
    DASH,
    clock_text,
    count_text,
    duration_text,
    floor_percent,
    plain_shortcut_text,
)
from ui.pilot.cue_display import (
    STATEMENT_SEPARATOR,
    CardDisplay,
    CueDisplay,
    DisplayTone,
    Gauge,
    Hint,
    SignName,
)
from ui.pilot.gauges import build_input_gauges, build_test_point_gauges
from ui.pilot.pilot_text import (
    RESULT_SIGNS,
    TRIM_STATE_SIGNS,
    advice_text,
    find_sign,
    surfaces_text,
)
from ui.translation import tr

_MAX_HINTS: Final = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class CueDisplayInput:
    """What the page is made of, beside the cues.

    Attributes
    ----------
    cues : CueSnapshot or None
        None where no flight is open, or it gives no cues.
    units : str
        ``US`` or ``SI``.
    is_flight_open : bool
        Whether a flight is open.
    seconds_without_data : float or None
        Seconds without a new sample, once they are too many to believe what was said; else None.
    monitored_fraction : float
        How much of the flight so far the cues have seen, 0 to 1.
    dismissed_verdict_id : str
        Id of the maneuver whose verdict was waved away.
    browsed_card : TestCard or None
        Card that the crew is looking at without having chosen it.
    target_input : TargetInput or None
        What was wanted of the input that the latest verdict is on.
    """

    cues: CueSnapshot | None = None
    units: str = "US"
    is_flight_open: bool = False
    seconds_without_data: float | None = None
    monitored_fraction: float = 1.0
    dismissed_verdict_id: str = ""
    browsed_card: TestCard | None = None
    target_input: TargetInput | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _StatusDisplay:
    """The upper half of the page."""

    word: str
    sign: SignName
    tone: DisplayTone
    ring: float | None = None
    count: str = ""
    hints: tuple[Hint, ...] = ()
    gauges: tuple[Gauge, ...] | None = None


def build_cue_display(reading: CueDisplayInput) -> CueDisplay:
    """Return what stands on the page."""
    cues = reading.cues
    if not reading.is_flight_open:
        connect, train = plain_shortcut_text("Ctrl+L"), plain_shortcut_text("Ctrl+Shift+T")
        hints = (
            Hint(
                text=tr("connect with {connect}, or train with {train}").format(
                    connect=connect, train=train
                )
            ),
        )
        return CueDisplay(status_text=tr("NO FLIGHT"), sign="unknown", tone="unknown", hints=hints)
    if cues is None:
        hints = (Hint(text=tr("this flight was opened without cues")),)
        return CueDisplay(status_text=tr("NO CUE"), sign="unknown", tone="unknown", hints=hints)
    head = _build_status(reading, cues)
    gauges = (
        head.gauges if head.gauges is not None else build_test_point_gauges(cues, reading.units)
    )
    told = reading.seconds_without_data is None and reading.monitored_fraction >= 1.0
    leg = cues.trim.leg_time_left if cues.trim is not None and told else None
    card = _build_card(cues if told else replace(cues, outlook=None), reading.browsed_card)
    return CueDisplay(
        status_text=head.word,
        sign=head.sign,
        tone=head.tone,
        ring=head.ring,
        count=head.count,
        hints=tuple(
            replace(hint, text=convert_text_units(hint.text, reading.units))
            for hint in head.hints[:_MAX_HINTS]
        ),
        gauges=gauges,
        leg_time_text=DASH if leg is None else f"{max(math.floor(leg), 0)}",
        leg_short=leg is not None and leg < DISPLAY.short_leg_time,
        card=replace(
            card,
            text=convert_text_units(card.text, reading.units),
            benefit_text=convert_text_units(card.benefit_text, reading.units),
        ),
        footer=_footer_text(cues),
    )


def _build_status(reading: CueDisplayInput, cues: CueSnapshot) -> _StatusDisplay:
    """Return the state: silence first, then danger, the input, its verdict, and the trim."""
    if reading.seconds_without_data is not None:
        words = tr("no samples for {time}: fly by eye").format(
            time=duration_text(reading.seconds_without_data)
        )
        return _StatusDisplay(
            word=tr("NO DATA"),
            sign="unknown",
            tone="unknown",
            hints=(Hint(text=words),),
            gauges=(Gauge(title=tr("SPEED"), number=DASH),),
        )
    if reading.monitored_fraction < 1.0:
        words = tr("catching up: {percent} %").format(
            percent=floor_percent(reading.monitored_fraction)
        )
        return _StatusDisplay(
            word=tr("NO CUE"),
            sign="unknown",
            tone="unknown",
            hints=(Hint(text=words),),
            gauges=(Gauge(title=tr("SPEED"), number=DASH),),
        )
    worst = cues.alerts[0] if cues.alerts else None
    if worst is not None and worst.level is AlertLevel.WARNING:
        return _build_danger(worst)
    if cues.input_in_progress is not None and _is_deliberate_input(cues.input_in_progress, cues):
        return _build_input(cues.input_in_progress, cues, reading.units)
    verdict = cues.fresh_verdict
    if verdict is not None and verdict.id != reading.dismissed_verdict_id:
        return _build_verdict(verdict, cues, reading)
    cautions = tuple(
        Hint(text=one.spoken_text or one.text, sign="danger", tone="caution") for one in cues.alerts
    )
    head = _build_trim(cues.trim, cues, reading.units)
    if not cautions:
        return head
    return _StatusDisplay(
        word=head.word,
        sign=head.sign,
        tone=head.tone,
        ring=head.ring,
        hints=(*head.hints[:1], *cautions),
    )


def _build_danger(danger: Alert) -> _StatusDisplay:
    """Return a danger in place of all: what to do, large; what it is, below."""
    spoken = danger.spoken_text or danger.text
    what, _, remedy = spoken.rpartition(": ")
    word = (remedy if what else spoken).upper()
    return _StatusDisplay(
        word=word,
        sign="land" if "LAND" in word else "danger",
        tone="warning",
        hints=(Hint(text=what or danger.text, sign="danger", tone="warning"),),
    )


def _is_deliberate_input(under_way: InputInProgress, cues: CueSnapshot) -> bool:
    """Return whether a quick move is shown as an input: not while it may still be steering."""
    if under_way.phase == "hands-off":
        return True
    if cues.trim is not None and cues.trim.state == "turn":
        return False
    wanted = None if cues.card is None else cues.card.target_input
    bands = {} if wanted is None else wanted.amplitudes
    known = [name for name in under_way.surfaces if name in bands]
    return not known or any(
        under_way.amplitudes.get(name, 0.0) >= DISPLAY.deliberate_share * bands[name].low
        for name in known
    )


def _build_input(under_way: InputInProgress, cues: CueSnapshot, units: str) -> _StatusDisplay:
    wanted = None if cues.card is None else cues.card.target_input
    gauges = build_input_gauges(under_way, wanted, units)
    if under_way.phase == "moving":
        hints = (Hint(text=surfaces_text(under_way.surfaces)),)
        return _StatusDisplay(
            word=tr("INPUT"), sign="stick", tone="strong", hints=hints, gauges=gauges
        )
    left, total = under_way.hands_off_left, under_way.hands_off_total
    return _StatusDisplay(
        word=tr("HANDS OFF"),
        sign="hand",
        tone="strong",
        ring=min(max(left / total, 0.0), 1.0) if total > 0.0 else 0.0,
        count=f"{max(math.ceil(left), 0)}",
        hints=(Hint(text=tr("hands off, let it oscillate"), sign="hand"),),
        gauges=gauges,
    )


def _build_verdict(
    verdict: InputVerdict, cues: CueSnapshot, reading: CueDisplayInput
) -> _StatusDisplay:
    word, sign, tone = RESULT_SIGNS[verdict.result]
    advice = advice_text(verdict)
    counted = cues.card if cues.card is not None and cues.card.card.id == verdict.card else None
    if verdict.result == "good" and counted is not None:
        done = tr("{good} of {repeats}").format(
            good=counted.good_repeats, repeats=counted.card.repeats
        )
        advice = f"{advice}, {done}" if advice else f"{verdict.card}: {done}"
    advice = advice or f"{surfaces_text(verdict.surfaces)} {verdict.kind}"
    return _StatusDisplay(
        word=tr(word),
        sign=sign,
        tone=tone,
        hints=(Hint(text=advice),),
        gauges=build_input_gauges(verdict, reading.target_input, reading.units),
    )


def _build_trim(trim: TrimCue | None, cues: CueSnapshot, units: str) -> _StatusDisplay:
    hints: tuple[Hint, ...] = ()
    if trim is None:
        hints = (Hint(text=tr("waiting for the first samples")),)
        return _StatusDisplay(word=tr("NO CUE"), sign="unknown", tone="unknown", hints=hints)
    word, sign, tone = TRIM_STATE_SIGNS[trim.state]
    off = tuple(
        Hint(text=one.format_text(units), sign=find_sign(one))
        for one in trim.deviations
        if one.tolerance_ratio > 1.0
    )
    wanted = cues.card.text if cues.card is not None else ""
    ring = None
    if trim.state == "blind":
        hints = tuple(Hint(text=words) for words in trim.limitations)
    elif trim.state == "fly":
        hints = _guidance_hints(off, cues.guidance)
        sign = hints[0].sign or sign if hints else sign
    elif trim.state == "hold":
        ring = min(max(trim.progress, 0.0), 1.0)
        hints = (Hint(text=tr("hold it")),)
    elif trim.state == "go":
        hints = (Hint(text=wanted or tr("fly the input")),)
        unseen = [name for name in _next_surfaces(cues) if name in cues.unmeasured_surfaces]
        if unseen:
            words = tr("no verdict: {surfaces} not measured").format(surfaces=surfaces_text(unseen))
            hints += (Hint(text=words, sign="unknown", tone="caution"),)
        if cues.card is not None and cues.speed is None and cues.alpha is None:
            hints += (Hint(text=tr("speed not measured: judge by eye")),)
    elif trim.state == "gusty":
        hints = (Hint(text=tr("gusty: wait for calmer air")),)
    elif trim.state == "turn":
        turning = next((one for one in off if one.sign.startswith("turn")), None)
        sign = turning.sign if turning is not None else sign
        hints = (
            Hint(text=tr("then {wanted}").format(wanted=wanted) if wanted else tr("next leg")),
        )
    return _StatusDisplay(word=tr(word), sign=sign, tone=tone, ring=ring, hints=hints)


def _next_surfaces(cues: CueSnapshot) -> tuple[str, ...]:
    """Return the surfaces of the next input; all of them where no card says."""
    return tuple(SURFACE_NAMES) if cues.card is None else cues.card.card.surfaces


def _guidance_hints(off: tuple[Hint, ...], guidance: str) -> tuple[Hint, ...]:
    """Return what is off, with the way to the test point in place of the words it begins with."""
    if not guidance:
        return off or (Hint(text=tr("stabilize")),)
    start = guidance.partition(":")[0]
    told = tuple(
        Hint(text=guidance, sign=one.sign) if one.text == start else one for one in off[:_MAX_HINTS]
    )
    if told != off[:_MAX_HINTS] or len(told) == _MAX_HINTS:
        return told
    return (*told, Hint(text=guidance))


def _build_card(cues: CueSnapshot, browsed: TestCard | None) -> CardDisplay:
    outlook, next_card = cues.outlook, cues.card
    time = room = ""
    if outlook is not None and outlook.time_left is not None:
        time = tr("{clock} left").format(clock=clock_text(max(outlook.time_left, 0.0)))
    if outlook is not None and outlook.maneuvers_left is not None:
        room = count_text(outlook.maneuvers_left, "maneuver")
    prospects = {one.card: one.text for one in outlook.forecasts} if outlook is not None else {}
    if browsed is not None:
        return CardDisplay(
            heading=tr("SHOWING {id} · Enter flies it").format(id=browsed.id),
            text=browsed.display_title,
            benefit_text=prospects.get(browsed.id, browsed.remarks),
            time_left_text=time,
            maneuvers_left_text=room,
        )
    if next_card is None:
        done = cues.requested_repeats > 0
        return CardDisplay(
            heading=tr("CARDS"),
            text=tr("all cards flown: land") if done else tr("no test cards for this flight"),
            benefit_text=""
            if done
            else tr("choose them at Preflight: {page}, {cards}").format(
                page=plain_shortcut_text("F1"), cards=plain_shortcut_text("Alt+4")
            ),
            time_left_text=time,
            maneuvers_left_text=room,
        )
    card = next_card.card
    return CardDisplay(
        heading=tr("NEXT {id} · {good} of {repeats} good · {reason}").format(
            id=card.id, good=next_card.good_repeats, repeats=card.repeats, reason=next_card.reason
        ),
        text=next_card.text or card.display_title,
        benefit_text=next_card.problem or prospects.get(card.id, ""),
        problem=bool(next_card.problem),
        time_left_text=time,
        maneuvers_left_text=room,
    )


def _footer_text(cues: CueSnapshot) -> str:
    """Return what can and cannot be judged, the gaps first."""
    missing = cues.limitations or (cues.trim.limitations if cues.trim is not None else ())
    judged = cues.judged_by or (cues.trim.judged_by if cues.trim is not None else ())
    told = [tr("Not evaluated: {missing}").format(missing="; ".join(missing))] if missing else []
    if judged:
        told.append(tr("Judged: {judged}").format(judged="; ".join(judged)))
    return STATEMENT_SEPARATOR.join(told)
