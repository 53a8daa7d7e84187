"""From the cues of a session to what stands on the page. No Qt."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.dangers.danger import Danger, Urgency
from gsapp.excitation.doublets.verdict import InputUnderWay, Verdict
from gsapp.excitation.points.wanted import WantedInput
from gsapp.excitation.trim.cue import TrimCue
from gsapp.flight.cards import TestCard
from gsapp.flight.cards.card import SURFACES
from gsapp.quantities import in_units
from ui.pilot.gauges import input_gauges, point_gauges
from ui.pilot.sheet import STATEMENTS, CardLines, Gauge, Hint, Sheet, SignName, Tone
from ui.pilot.wording import RESULTS, STATES, advice_text, sign_of, surfaces_text
from ui.words import DASH, clock_text, count_text, duration_text, floor_percent, keys_text

_HINTS: Final = 2
_MEANT: Final = 0.5
"""Share of the least amplitude wanted, from which a move shows as an input while it is made."""
_SHORT_LEG: Final = 4.0
"""Seconds of leg below which its number is marked; what an input needs, the state knows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What the page is made of, beside the cues.

    Attributes
    ----------
    cues : CueSnapshot or None
        None where no flight is open, or it gives no cues.
    units : str
        ``US`` or ``SI``.
    open : bool
        Whether a flight is open.
    silent : float or None
        Seconds without a new sample, once they are too many to believe what was said; else None.
    watched : float
        How much of the flight so far the cues have seen, 0 to 1.
    dismissed : str
        Id of the maneuver whose verdict was waved away.
    browsed : TestCard or None
        Card that the crew is looking at without having chosen it.
    wanted : WantedInput or None
        What was wanted of the input that the latest verdict is on.
    """

    cues: CueSnapshot | None = None
    units: str = "US"
    open: bool = False
    silent: float | None = None
    watched: float = 1.0
    dismissed: str = ""
    browsed: TestCard | None = None
    wanted: WantedInput | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Head:
    """The upper half of the page."""

    word: str
    sign: SignName
    tone: Tone
    ring: float | None = None
    count: str = ""
    hints: tuple[Hint, ...] = ()
    gauges: tuple[Gauge, ...] | None = None


def sheet_of(reading: Reading) -> Sheet:
    """Return what stands on the page."""
    cues = reading.cues
    if not reading.open:
        connect, train = keys_text("Ctrl+L"), keys_text("Ctrl+Shift+T")
        hints = (Hint(words=f"connect with {connect}, or train with {train}"),)
        return Sheet(word="NO FLIGHT", sign="unknown", tone="unknown", hints=hints)
    if cues is None:
        hints = (Hint(words="this flight is opened without cues"),)
        return Sheet(word="NO CUE", sign="unknown", tone="unknown", hints=hints)
    head = _head(reading, cues)
    gauges = head.gauges if head.gauges is not None else point_gauges(cues, reading.units)
    told = reading.silent is None and reading.watched >= 1.0
    leg = cues.trim.leg_left if cues.trim is not None and told else None
    card = _card_lines(cues if told else replace(cues, outlook=None), reading.browsed)
    return Sheet(
        word=head.word,
        sign=head.sign,
        tone=head.tone,
        ring=head.ring,
        count=head.count,
        hints=tuple(
            replace(hint, words=in_units(hint.words, reading.units)) for hint in head.hints[:_HINTS]
        ),
        gauges=gauges,
        leg=DASH if leg is None else f"{max(math.floor(leg), 0)}",
        leg_short=leg is not None and leg < _SHORT_LEG,
        card=replace(
            card, words=in_units(card.words, reading.units), gain=in_units(card.gain, reading.units)
        ),
        foot=_foot(cues),
    )


def _head(reading: Reading, cues: CueSnapshot) -> _Head:
    """Return the state: silence first, then danger, the input, its verdict, and the trim."""
    if reading.silent is not None:
        words = f"no samples for {duration_text(reading.silent)}: fly by eye"
        return _Head(
            word="NO DATA",
            sign="unknown",
            tone="unknown",
            hints=(Hint(words=words),),
            gauges=(Gauge(title="SPEED", number=DASH),),
        )
    if reading.watched < 1.0:
        words = f"catching up with the flight: {floor_percent(reading.watched)} %"
        return _Head(
            word="NO CUE",
            sign="unknown",
            tone="unknown",
            hints=(Hint(words=words),),
            gauges=(Gauge(title="SPEED", number=DASH),),
        )
    worst = cues.dangers[0] if cues.dangers else None
    if worst is not None and worst.urgency is Urgency.WARNING:
        return _danger(worst)
    if cues.under_way is not None and _is_meant(cues.under_way, cues):
        return _input(cues.under_way, cues, reading.units)
    verdict = cues.fresh_verdict
    if verdict is not None and verdict.id != reading.dismissed:
        return _verdict(verdict, cues, reading)
    cautions = tuple(
        Hint(words=one.spoken or one.words, sign="danger", tone="caution") for one in cues.dangers
    )
    head = _trim(cues.trim, cues, reading.units)
    if not cautions:
        return head
    return _Head(
        word=head.word,
        sign=head.sign,
        tone=head.tone,
        ring=head.ring,
        hints=(*head.hints[:1], *cautions),
    )


def _danger(danger: Danger) -> _Head:
    """Return a danger in place of all: what to do, large; what it is, below."""
    spoken = danger.spoken or danger.words
    what, _, remedy = spoken.rpartition(": ")
    word = (remedy if what else spoken).upper()
    return _Head(
        word=word,
        sign="land" if "LAND" in word else "danger",
        tone="warning",
        hints=(Hint(words=what or danger.words, sign="danger", tone="warning"),),
    )


def _is_meant(under_way: InputUnderWay, cues: CueSnapshot) -> bool:
    """Return whether a quick move is shown as an input: not while it may still be steering."""
    if under_way.phase == "hands-off":
        return True
    if cues.trim is not None and cues.trim.state == "turn":
        return False
    wanted = None if cues.card is None else cues.card.wanted
    bands = {} if wanted is None else wanted.amplitudes
    known = [name for name in under_way.surfaces if name in bands]
    return not known or any(
        under_way.amplitudes.get(name, 0.0) >= _MEANT * bands[name].low for name in known
    )


def _input(under_way: InputUnderWay, cues: CueSnapshot, units: str) -> _Head:
    wanted = None if cues.card is None else cues.card.wanted
    gauges = input_gauges(under_way, wanted, units)
    if under_way.phase == "moving":
        hints = (Hint(words=surfaces_text(under_way.surfaces)),)
        return _Head(word="INPUT", sign="stick", tone="strong", hints=hints, gauges=gauges)
    left, total = under_way.hands_off_left, under_way.hands_off_total
    return _Head(
        word="HANDS OFF",
        sign="hand",
        tone="strong",
        ring=min(max(left / total, 0.0), 1.0) if total > 0.0 else 0.0,
        count=f"{max(math.ceil(left), 0)}",
        hints=(Hint(words="let it swing", sign="hand"),),
        gauges=gauges,
    )


def _verdict(verdict: Verdict, cues: CueSnapshot, reading: Reading) -> _Head:
    word, sign, tone = RESULTS[verdict.result]
    advice = advice_text(verdict)
    counted = cues.card if cues.card is not None and cues.card.card.id == verdict.card else None
    if verdict.result == "good" and counted is not None:
        done = f"{counted.good} of {counted.card.repeats}"
        advice = f"{advice}, {done}" if advice else f"{verdict.card}: {done}"
    advice = advice or f"{surfaces_text(verdict.surfaces)} {verdict.kind}"
    return _Head(
        word=word,
        sign=sign,
        tone=tone,
        hints=(Hint(words=advice),),
        gauges=input_gauges(verdict, reading.wanted, reading.units),
    )


def _trim(trim: TrimCue | None, cues: CueSnapshot, units: str) -> _Head:
    if trim is None:
        hints = (Hint(words="waiting for the first samples"),)
        return _Head(word="NO CUE", sign="unknown", tone="unknown", hints=hints)
    word, sign, tone = STATES[trim.state]
    off = tuple(
        Hint(words=one.words(units), sign=sign_of(one)) for one in trim.off if one.share > 1.0
    )
    wanted = cues.card.words if cues.card is not None else ""
    hints: tuple[Hint, ...] = ()
    ring = None
    if trim.state == "blind":
        hints = tuple(Hint(words=words) for words in trim.missing)
    elif trim.state == "fly":
        hints = _towards(off, cues.guidance)
        sign = hints[0].sign or sign if hints else sign
    elif trim.state == "hold":
        ring = min(max(trim.progress, 0.0), 1.0)
        hints = (Hint(words="keep it there"),)
    elif trim.state == "go":
        hints = (Hint(words=wanted or "make the input"),)
        unseen = [name for name in _asked_for(cues) if name in cues.unseen]
        if unseen:
            words = f"no verdict: {surfaces_text(unseen)} not measured"
            hints += (Hint(words=words, sign="unknown", tone="caution"),)
        if cues.card is not None and cues.speed is None and cues.alpha is None:
            hints += (Hint(words="speed by eye: nothing measures it"),)
    elif trim.state == "gusty":
        hints = (Hint(words="gusty: wait for calmer air"),)
    elif trim.state == "turn":
        turning = next((one for one in off if one.sign.startswith("turn")), None)
        sign = turning.sign if turning is not None else sign
        hints = (Hint(words=f"then {wanted}" if wanted else "next leg"),)
    return _Head(word=word, sign=sign, tone=tone, ring=ring, hints=hints)


def _asked_for(cues: CueSnapshot) -> tuple[str, ...]:
    """Return the surfaces of the next input; all of them where no card says."""
    return tuple(SURFACES) if cues.card is None else cues.card.card.surfaces


def _towards(off: tuple[Hint, ...], guidance: str) -> tuple[Hint, ...]:
    """Return what is off, with the way to the test point in place of the words it begins with."""
    if not guidance:
        return off or (Hint(words="stabilize"),)
    start = guidance.partition(":")[0]
    told = tuple(
        Hint(words=guidance, sign=one.sign) if one.words == start else one for one in off[:_HINTS]
    )
    if told != off[:_HINTS] or len(told) == _HINTS:
        return told
    return (*told, Hint(words=guidance))


def _card_lines(cues: CueSnapshot, browsed: TestCard | None) -> CardLines:
    outlook, next_card = cues.outlook, cues.card
    time = room = ""
    if outlook is not None and outlook.time_left is not None:
        time = f"{clock_text(max(outlook.time_left, 0.0))} left"
    if outlook is not None and outlook.maneuvers_left is not None:
        room = count_text(outlook.maneuvers_left, "maneuver")
    prospects = {one.card: one.words for one in outlook.prospects} if outlook is not None else {}
    if browsed is not None:
        return CardLines(
            lead=f"LOOKING AT {browsed.id} · Enter flies it",
            words=browsed.heading,
            gain=prospects.get(browsed.id, browsed.remarks),
            time=time,
            room=room,
        )
    if next_card is None:
        done = cues.wanted > 0
        return CardLines(
            lead="CARDS",
            words="all cards flown: land" if done else "no test cards for this flight",
            gain=""
            if done
            else f"choose them at Preflight: {keys_text('F1')}, {keys_text('Alt+4')}",
            time=time,
            room=room,
        )
    card = next_card.card
    return CardLines(
        lead=f"NEXT {card.id} · {next_card.good} of {card.repeats} good · {next_card.why}",
        words=next_card.words or card.heading,
        gain=next_card.problem or prospects.get(card.id, ""),
        problem=bool(next_card.problem),
        time=time,
        room=room,
    )


def _foot(cues: CueSnapshot) -> str:
    """Return what can and cannot be judged, the gaps first."""
    missing = cues.missing or (cues.trim.missing if cues.trim is not None else ())
    judged = cues.judged or (cues.trim.judged_by if cues.trim is not None else ())
    told = [f"Not judged: {'; '.join(missing)}"] if missing else []
    if judged:
        told.append(f"Judged: {'; '.join(judged)}")
    return STATEMENTS.join(told)
