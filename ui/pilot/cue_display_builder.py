"""From the cues of a session to what stands on the page. No Qt."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from gsapp.excitation.alerts.alert import Alert, AlertLevel
from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.doublets.verdict import InputInProgress, InputVerdict
from gsapp.excitation.test_points.point import TargetInput, ToleranceBand
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.flight.cards import TestCard
from gsapp.quantities import SURFACE_NAMES, ChannelSpec, channel, convert_text_units, typeset
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
    RESULT_SIGNS,
    STATEMENT_SEPARATOR,
    TRIM_STATE_SIGNS,
    CardDisplay,
    CueDisplay,
    Gauge,
    Hint,
    advice_text,
    coarse_number_text,
    display_unit_text,
    find_sign,
    surfaces_text,
)
from ui.translation import tr

_MAX_GAUGES: Final = 2
_TOLERANCE_SHARE: Final = 0.2
"""Share of the bar from what is wanted to each end of the tolerance."""
_DECIMALS: Final = {"V": 0, "alpha": 1}
_INPUT_SPAN_FACTOR: Final = 1.5
"""The bar of an input ends at so many times the largest that is wanted."""


def build_test_point_gauges(snapshot: CueSnapshot, units: str) -> tuple[Gauge, ...]:
    """Return where the aircraft is and where it should be: by speed, else by angle of attack."""
    point = snapshot.card.point if snapshot.card is not None else None
    speed, alpha = channel("V"), channel("alpha")
    if point is not None and point.speed is not None and snapshot.speed is not None:
        return (_target_gauge(speed, snapshot.speed, point.speed, point.speed_tolerance, units),)
    if point is not None and point.alpha is not None and snapshot.alpha is not None:
        return (_target_gauge(alpha, snapshot.alpha, point.alpha, point.alpha_tolerance, units),)
    if point is not None and point.speed is not None:
        return (_target_gauge(speed, None, point.speed, point.speed_tolerance, units),)
    number = coarse_number_text(speed, snapshot.speed, units, _DECIMALS["V"])
    return (Gauge(title=tr("SPEED"), number=number, unit=display_unit_text(speed, units)),)


def _target_gauge(
    spec: ChannelSpec, value: float | None, wanted: float, tolerance: float, units: str
) -> Gauge:
    decimals = _DECIMALS[spec.id]
    share = None if value is None else 0.5 + _TOLERANCE_SHARE * (value - wanted) / tolerance
    return Gauge(
        title=tr("SPEED") if spec.id == "V" else tr("ALPHA"),
        number=coarse_number_text(spec, value, units, decimals),
        unit=display_unit_text(spec, units),
        target_text=tr("target {wanted} ± {tolerance}").format(
            wanted=coarse_number_text(spec, wanted, units, decimals),
            tolerance=coarse_number_text(spec, tolerance, units, decimals),
        ),
        marker=share,
        low=0.5 - _TOLERANCE_SHARE,
        high=0.5 + _TOLERANCE_SHARE,
    )


def build_input_gauges(
    under_way: InputInProgress | InputVerdict, wanted: TargetInput | None, units: str
) -> tuple[Gauge, ...]:
    """Return how large an input is, or was, on each of its surfaces."""
    bands = {} if wanted is None else wanted.amplitudes
    return tuple(
        _amplitude_gauge(name, under_way.amplitudes.get(name), bands.get(name), units)
        for name in under_way.surfaces[:_MAX_GAUGES]
    )


def _amplitude_gauge(
    name: str, value: float | None, band: ToleranceBand | None, units: str
) -> Gauge:
    spec = channel(name)
    title = SURFACE_NAMES.get(name, name).upper()
    number = coarse_number_text(spec, value, units, 1)
    if band is None:
        return Gauge(title=title, number=number, unit=display_unit_text(spec, units))
    full = _INPUT_SPAN_FACTOR * band.high
    return Gauge(
        title=title,
        number=number,
        unit=display_unit_text(spec, units),
        target_text=tr("target {low}–{high}").format(
            low=coarse_number_text(spec, band.low, units, 0),
            high=coarse_number_text(spec, band.high, units, 0),
        ),
        marker=None if value is None else value / full,
        low=band.low / full,
        high=band.high / full,
    )


_MAX_HINTS: Final = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class CueDisplayInput:
    """What the page is made of, beside the cues."""

    cues: CueSnapshot | None = None
    """None where no flight is open, or it gives no cues."""
    units: str = "US"
    is_flight_open: bool = False
    seconds_without_data: float | None = None
    """Seconds without a new sample, once they are too many to believe what was said; else None."""
    monitored_fraction: float = 1.0
    """How much of the flight so far the cues have seen, 0 to 1."""
    dismissed_verdict_id: str = ""
    browsed_card: TestCard | None = None
    target_input: TargetInput | None = None


def build_cue_display(reading: CueDisplayInput) -> CueDisplay:
    """Return what stands on the page."""
    cues = reading.cues
    if not reading.is_flight_open:
        connect, train = plain_shortcut_text("Ctrl+L"), plain_shortcut_text("Ctrl+Shift+T")
        text = tr("connect with {connect}, or train with {train}")
        return _unknown_display(tr("NO FLIGHT"), text.format(connect=connect, train=train))
    if cues is None:
        return _unknown_display(tr("NO CUE"), tr("this flight was opened without cues"))
    head = _build_status(reading, cues)
    told = reading.seconds_without_data is None and reading.monitored_fraction >= 1.0
    leg = cues.trim.leg_time_left if cues.trim is not None and told else None
    card = _build_card(cues if told else replace(cues, outlook=None), reading.browsed_card)
    return replace(
        head,
        hints=tuple(
            replace(hint, text=convert_text_units(hint.text, reading.units))
            for hint in head.hints[:_MAX_HINTS]
        ),
        leg_time_text=DASH if leg is None else f"{max(math.floor(leg), 0)}",
        leg_short=leg is not None and leg < DISPLAY.short_leg_time,
        card=replace(
            card,
            text=convert_text_units(card.text, reading.units),
            benefit_text=convert_text_units(card.benefit_text, reading.units),
        ),
        footer=_footer_text(cues),
    )


def _unknown_display(word: str, text: str, gauges: tuple[Gauge, ...] = ()) -> CueDisplay:
    """Return a state in which nothing is known of the aircraft."""
    return CueDisplay(
        status_text=word, sign="unknown", tone="unknown", hints=(Hint(text=text),), gauges=gauges
    )


def _build_status(reading: CueDisplayInput, cues: CueSnapshot) -> CueDisplay:
    """Return the state: silence first, then danger, the input, its verdict, and the trim."""
    no_speed = (Gauge(title=tr("SPEED"), number=DASH),)
    if reading.seconds_without_data is not None:
        text = tr("no samples for {time}: fly by eye").format(
            time=duration_text(reading.seconds_without_data)
        )
        return _unknown_display(tr("NO DATA"), text, no_speed)
    if reading.monitored_fraction < 1.0:
        text = tr("catching up: {percent} %").format(
            percent=floor_percent(reading.monitored_fraction)
        )
        return _unknown_display(tr("NO CUE"), text, no_speed)
    test_point = build_test_point_gauges(cues, reading.units)
    worst = cues.alerts[0] if cues.alerts else None
    if worst is not None and worst.level is AlertLevel.WARNING:
        return _build_danger(worst, test_point)
    if cues.input_in_progress is not None and _is_deliberate_input(cues.input_in_progress, cues):
        return _build_input(cues.input_in_progress, cues, reading.units)
    verdict = cues.fresh_verdict
    if verdict is not None and verdict.id != reading.dismissed_verdict_id:
        return _build_verdict(verdict, cues, reading)
    cautions = tuple(
        Hint(text=one.spoken_text or one.text, sign="danger", tone="caution") for one in cues.alerts
    )
    head = replace(_build_trim(cues.trim, cues, reading.units), gauges=test_point)
    return replace(head, hints=(*head.hints[:1], *cautions)) if cautions else head


def _build_danger(danger: Alert, gauges: tuple[Gauge, ...]) -> CueDisplay:
    """Return a danger in place of all: what to do, large; what it is, below."""
    spoken = danger.spoken_text or danger.text
    what, _, remedy = spoken.rpartition(": ")
    word = (remedy if what else spoken).upper()
    return CueDisplay(
        status_text=word,
        sign="land" if "LAND" in word else "danger",
        tone="warning",
        hints=(Hint(text=what or danger.text, sign="danger", tone="warning"),),
        gauges=gauges,
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


def _build_input(under_way: InputInProgress, cues: CueSnapshot, units: str) -> CueDisplay:
    wanted = None if cues.card is None else cues.card.target_input
    gauges = build_input_gauges(under_way, wanted, units)
    if under_way.phase == "moving":
        hints = (Hint(text=surfaces_text(under_way.surfaces)),)
        return CueDisplay(
            status_text=tr("INPUT"), sign="stick", tone="strong", hints=hints, gauges=gauges
        )
    left, total = under_way.hands_off_left, under_way.hands_off_total
    return CueDisplay(
        status_text=tr("HANDS OFF"),
        sign="hand",
        tone="strong",
        ring=min(max(left / total, 0.0), 1.0) if total > 0.0 else 0.0,
        count=f"{max(math.ceil(left), 0)}",
        hints=(Hint(text=tr("hands off, let it oscillate"), sign="hand"),),
        gauges=gauges,
    )


def _build_verdict(
    verdict: InputVerdict, cues: CueSnapshot, reading: CueDisplayInput
) -> CueDisplay:
    word, sign, tone = RESULT_SIGNS[verdict.result]
    advice = advice_text(verdict)
    counted = cues.card if cues.card is not None and cues.card.card.id == verdict.card else None
    if verdict.result == "good" and counted is not None:
        done = tr("{good} of {repeats}").format(
            good=counted.good_repeats, repeats=counted.card.repeats
        )
        advice = f"{advice}, {done}" if advice else f"{verdict.card}: {done}"
    advice = advice or f"{surfaces_text(verdict.surfaces)} {verdict.kind}"
    return CueDisplay(
        status_text=tr(word),
        sign=sign,
        tone=tone,
        hints=(Hint(text=advice),),
        gauges=build_input_gauges(verdict, reading.target_input, reading.units),
    )


def _build_trim(trim: TrimCue | None, cues: CueSnapshot, units: str) -> CueDisplay:
    hints: tuple[Hint, ...] = ()
    if trim is None:
        return _unknown_display(tr("NO CUE"), tr("waiting for the first samples"))
    word, sign, tone = TRIM_STATE_SIGNS[trim.state]
    off = tuple(
        Hint(text=one.format_text(units), sign=find_sign(one))
        for one in trim.deviations
        if one.tolerance_ratio > 1.0
    )
    wanted = cues.card.text if cues.card is not None else ""
    ring = None
    if trim.state == "blind":
        hints = tuple(Hint(text=text) for text in trim.limitations)
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
            text = tr("no verdict: {surfaces} not measured").format(surfaces=surfaces_text(unseen))
            hints += (Hint(text=text, sign="unknown", tone="caution"),)
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
    return CueDisplay(status_text=tr(word), sign=sign, tone=tone, ring=ring, hints=hints)


def _next_surfaces(cues: CueSnapshot) -> tuple[str, ...]:
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
    prospects = (
        {one.card: typeset(one.text) for one in outlook.forecasts} if outlook is not None else {}
    )
    times = CardDisplay(time_left_text=time, maneuvers_left_text=room)
    if browsed is not None:
        return replace(
            times,
            heading=tr("SHOWING {id} · Enter flies it").format(id=browsed.id),
            text=browsed.display_title,
            benefit_text=prospects.get(browsed.id, browsed.remarks),
        )
    if next_card is None:
        done = cues.requested_repeats > 0
        return replace(
            times,
            heading=tr("CARDS"),
            text=tr("all cards flown: land") if done else tr("no test cards for this flight"),
            benefit_text=""
            if done
            else tr("choose them at Preflight: {page}, {cards}").format(
                page=plain_shortcut_text("F1"), cards=plain_shortcut_text("Alt+4")
            ),
        )
    card = next_card.card
    return replace(
        times,
        heading=tr("NEXT {id} · {good} of {repeats} good · {reason}").format(
            id=card.id, good=next_card.good_repeats, repeats=card.repeats, reason=next_card.reason
        ),
        text=next_card.text or card.display_title,
        benefit_text=next_card.problem or prospects.get(card.id, ""),
        problem=bool(next_card.problem),
    )


def _footer_text(cues: CueSnapshot) -> str:
    missing = cues.limitations or (cues.trim.limitations if cues.trim is not None else ())
    judged = cues.judged_by or (cues.trim.judged_by if cues.trim is not None else ())
    told = [tr("Not evaluated: {missing}").format(missing="; ".join(missing))] if missing else []
    if judged:
        told.append(tr("Judged: {judged}").format(judged="; ".join(judged)))
    return STATEMENT_SEPARATOR.join(told)
