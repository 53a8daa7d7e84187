"""Cues made by hand, for the tests of the pilot's page: one for every state."""

from dataclasses import replace

import numpy as np

from gsapp.excitation.alerts.alert import Alert, AlertLevel
from gsapp.excitation.cues import CueSnapshot, NextCard
from gsapp.excitation.debrief import Debrief, EvaluatedManeuver, FlightTrend, ManeuverCurves
from gsapp.excitation.doublets.verdict import InputFinding, InputInProgress, InputVerdict
from gsapp.excitation.information.outlook import BoundReduction, CardForecast, Outlook
from gsapp.excitation.test_points.point import TargetInput, TestPoint, ToleranceBand
from gsapp.excitation.trim.trim_cue import TrimCue, TrimDeviation
from gsapp.flight.cards import load_cards
from gsapp.flight.catalog import CardScore
from gsapp.quantities.constants import DEGREE, FOOT
from ui.pilot.cue_display import CueDisplay
from ui.pilot.cue_display_builder import CueDisplayInput, build_cue_display

CARDS = load_cards("b777")
CARD = next(card for card in CARDS.cards if card.id == "C1")
POINT = TestPoint(
    card="C1", speed=100 * FOOT, speed_tolerance=5 * FOOT, alpha_tolerance=1.5 * DEGREE
)
WANTED = TargetInput(
    surfaces=("da", "dr"), kind="doublet",
    amplitudes={
        "da": ToleranceBand(low=4 * DEGREE, best=6 * DEGREE, high=9 * DEGREE),
        "dr": ToleranceBand(low=7 * DEGREE, best=10 * DEGREE, high=14 * DEGREE),
    },
    width=ToleranceBand(low=0.4, best=0.5, high=0.7), hands_off=2.4, mode="dutch roll",
    source="model",
)  # fmt: skip
NEXT = NextCard(
    card=CARD, good_repeats=2, point=POINT, target_input=WANTED,
    stick_text={"da": "third of stick, high rate", "dr": "half stick, high rate"},
    text="aileron and rudder doublet: third of stick, half rudder, high rate",
    reason="most to gain",
)  # fmt: skip
OUTLOOK = Outlook(
    time=180.0,
    forecasts=(
        CardForecast(
            card="C1", repeats=2,
            reductions=(BoundReduction(name="Cn_r", bound_before=0.12, bound_after=0.05, low=0.04,
            high=0.07),), score=0.4,
            seconds=60.0, text="two more rudder-aileron doublets at 100 ft/s: Cn_r from 35 % to "
            "15 %",
        ),
    ),
    time_left=250.0, maneuvers_left=6,
)  # fmt: skip
SLOW = TrimDeviation(quantity="speed", amount=-3 * FOOT, tolerance_ratio=1.8, channel="V")
LOW_WING = TrimDeviation(quantity="bank", amount=-6 * DEGREE, tolerance_ratio=1.2, channel="phi")
VERDICT = InputVerdict(
    id="M7", given_at=180.0, t_start=174.0, t_input=175.0, t_input_end=179.0, t_end=179.4,
    surfaces=("da", "dr"), kind="doublet", amplitudes={"da": 6.2 * DEGREE, "dr": 4.9 * DEGREE},
    halves={"da": (0.5, 0.5), "dr": (0.5, 0.5)}, symmetry={"da": 0.9, "dr": 0.9},
    left_over={}, cross={}, V=100 * FOOT, alpha=4 * DEGREE, result="too-small",
    findings=(InputFinding(result="too-small", words="rudder doublet too small: 50 % larger",
                      surface="dr", factor=1.5),),
    advice="rudder doublet too small: 50 % larger, two thirds stick", card="C1",
)  # fmt: skip
MISSING = ("bank angle is not measured: wings by rates and lateral acceleration",)


def cue(state: str, **more: object) -> TrimCue:
    return TrimCue(time=180.0, state=state, since=178.0, leg_time_left=7.4, **more)  # type: ignore[arg-type]


BASE = CueSnapshot(
    time=180.0, trim=cue("fly", deviations=(SLOW, LOW_WING)), card=NEXT, outlook=OUTLOOK,
    speed=97 * FOOT, alpha=4.2 * DEGREE, judged_by=("wings: rates and lateral acceleration",),
    limitations=MISSING, good_repeats=5, requested_repeats=12,
)  # fmt: skip


def moving(phase: str, left: float = 1.6) -> InputInProgress:
    return InputInProgress(
        time=180.0, phase=phase, surfaces=("da", "dr"), t_input=179.0,  # type: ignore[arg-type]
        amplitudes={"da": 6.2 * DEGREE, "dr": 4.9 * DEGREE},
        hands_off_left=left, hands_off_total=2.4,
    )  # fmt: skip


def verdict(result: str, advice: str) -> InputVerdict:
    return replace(VERDICT, result=result, advice=advice)  # type: ignore[type-var]


def danger(text: str, *, warning: bool = True) -> Alert:
    urgency = AlertLevel.WARNING if warning else AlertLevel.CAUTION
    return Alert(key="nose", level=urgency, since=178.0, text=text, spoken_text=text)


STATES: dict[str, CueSnapshot] = {
    "fly": BASE,
    "hold": replace(BASE, trim=cue("hold", progress=0.6), speed=99 * FOOT),
    "go": replace(BASE, trim=cue("go"), speed=100.4 * FOOT),
    "gusty": replace(BASE, trim=cue("gusty", gust_strength=0.9)),
    "turn": replace(
        BASE,
        trim=cue(
            "turn",
            deviations=(
                TrimDeviation(quantity="turn", amount=0.3, tolerance_ratio=3.0, channel="r"),
            ),
        ),
    ),
    "blind": replace(BASE, trim=cue("blind", limitations=("no rates come in",)), speed=None),
    "input": replace(BASE, input_in_progress=moving("moving")),
    "hands-off": replace(BASE, input_in_progress=moving("hands-off")),
    "too-small": replace(BASE, verdict=VERDICT),
    "too-large": replace(
        BASE, verdict=verdict("too-large", "rudder too large, yaw rate clipped: 35 % smaller")
    ),
    "too-fast": replace(BASE, verdict=verdict("too-fast", "rudder too fast: 0.5 s each way")),
    "too-slow": replace(BASE, verdict=verdict("too-slow", "rudder too slow: 0.4 s each way")),
    "not-trimmed": replace(
        BASE, verdict=verdict("not-trimmed", "not trimmed: 8 ft/s slow at the start")
    ),
    "invalid": replace(BASE, verdict=verdict("invalid", "invalid: elevator moved with it")),
    "unclear": replace(BASE, verdict=verdict("unclear", "unclear: yaw rate is missing")),
    "good": replace(BASE, verdict=verdict("good", "good")),
    "danger": replace(BASE, alerts=(danger("nose sensors lost: land"),)),
    "caution": replace(BASE, alerts=(danger("yaw gyro clips", warning=False),)),
}
"""Cues by what the page shows of them."""


def display(cues: CueSnapshot, **more: object) -> CueDisplay:
    """Return what stands on the page for cues of an open flight."""
    return build_cue_display(CueDisplayInput(cues=cues, is_flight_open=True, **more))  # type: ignore[arg-type]


def judged(name: str = "M7", made: InputVerdict = VERDICT, *, go: bool = True) -> EvaluatedManeuver:
    times = np.arange(round(25 * (made.t_end - made.t_start))) / 25.0 + made.t_start
    since = times - made.t_input
    step = np.where((since > 0) & (since < 0.5), 1.0, np.where((since > 0.5) & (since < 1), -1, 0))
    swing = np.where(since > 0, np.exp(-0.5 * since) * np.sin(5.4 * since), 0.0)
    series = {
        "da": 0.01 + made.amplitudes.get("da", 0.0) * step,
        "dr": 0.02 + made.amplitudes.get("dr", 0.0) * np.roll(step, 12),
        "p": 0.5 * swing, "r": 0.2 * np.roll(swing, 6),
    }  # fmt: skip
    return EvaluatedManeuver(
        verdict=replace(made, id=name), target_input=WANTED, point=POINT,
        go_at=made.t_input - 1.2 if go else None, trim_deviations={"speed": -0.4, "bank": 0.3},
        curves=ManeuverCurves(times=times, series=series),
    )  # fmt: skip


def debrief() -> Debrief:
    """Return a debrief of eight maneuvers."""
    results = ("good", "too-small", "good", "invalid", "too-large", "good", "not-trimmed", "good")
    made = tuple(
        judged(
            f"M{index + 1}",
            replace(
                VERDICT if result == "too-small" else verdict(result, RESULT_ADVICE[result]),
                counts=result == "good", t_start=60.0 * index + 20, t_input=60.0 * index + 21,
                t_input_end=60.0 * index + 22.2, t_end=60.0 * index + 25,
                findings=VERDICT.findings if result == "too-small" else (),
            ),
            go=index != 6,
        )
        for index, result in enumerate(results)
    )  # fmt: skip
    cards = tuple(
        CardScore(
            card=card.id, title=card.display_title, good=min(index + 1, card.repeats),
            flown=index + 2,
            requested=card.repeats,
        )
        for index, card in enumerate(CARDS.cards)
    )  # fmt: skip
    return Debrief(flight="2026-05-12 flight 2", maneuvers=made, cards=cards)


RESULT_ADVICE = {
    "good": "good", "invalid": "invalid: elevator moved with it",
    "too-large": "rudder too large, yaw rate clipped: 35 % smaller",
    "not-trimmed": "not trimmed: 8 ft/s slow at the start",
}  # fmt: skip


def flights() -> tuple[FlightTrend, ...]:
    return tuple(
        FlightTrend(
            flight=f"2026-05-12 flight {number}", inputs=12, good=3 + 2 * number,
            results={"good": 3 + 2 * number}, amplitudes={"da": 0.9, "dr": 0.5 + 0.1 * number},
            widths=1.1, trim_errors={"speed": 0.6, "bank": 0.4}, without_go=1,
            seconds_each=31.0, score=0.2 * number,
        )
        for number in (1, 2, 3)
    )  # fmt: skip
