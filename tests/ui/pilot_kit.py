"""Cues made by hand, for the tests of the pilot's page: one for every state."""

from __future__ import annotations

from dataclasses import replace

from gsapp.excitation.cues import CueSnapshot, NextCard
from gsapp.excitation.dangers.danger import Danger, Urgency
from gsapp.excitation.doublets.verdict import Finding, InputUnderWay, Verdict
from gsapp.excitation.information.prospect import Gain, Outlook, Prospect
from gsapp.excitation.points.point import TestPoint
from gsapp.excitation.points.wanted import Band, WantedInput
from gsapp.excitation.trim.cue import Off, TrimCue
from gsapp.flight.cards import load_cards
from gsapp.quantities.constants import DEGREE, FOOT

CARDS = load_cards("b777")
CARD = next(card for card in CARDS.cards if card.id == "C1")
POINT = TestPoint(
    card="C1", speed=100 * FOOT, speed_tolerance=5 * FOOT, alpha_tolerance=1.5 * DEGREE
)
WANTED = WantedInput(
    surfaces=("da", "dr"), kind="doublet",
    amplitudes={
        "da": Band(low=4 * DEGREE, best=6 * DEGREE, high=9 * DEGREE),
        "dr": Band(low=7 * DEGREE, best=10 * DEGREE, high=14 * DEGREE),
    },
    width=Band(low=0.4, best=0.5, high=0.7), hands_off=2.4, mode="dutch roll", source="model",
)  # fmt: skip
NEXT = NextCard(
    card=CARD, good=2, point=POINT, wanted=WANTED,
    stick={"da": "third of stick, high rate", "dr": "half stick, high rate"},
    words="aileron and rudder doublet: third of stick, half rudder, high rate",
    why="most to gain",
)  # fmt: skip
OUTLOOK = Outlook(
    time=180.0,
    prospects=(
        Prospect(
            card="C1", repeats=2,
            gains=(Gain(name="Cn_r", before=0.12, after=0.05, low=0.04, high=0.07),), score=0.4,
            seconds=60.0, words="two more rudder-aileron doublets at 100 ft/s: Cn_r from 35 % to "
            "15 %",
        ),
    ),
    time_left=250.0, maneuvers_left=6,
)  # fmt: skip
SLOW = Off(quantity="speed", amount=-3 * FOOT, share=1.8, channel="V")
LOW_WING = Off(quantity="bank", amount=-6 * DEGREE, share=1.2, channel="phi")
VERDICT = Verdict(
    id="M7", given_at=180.0, t_start=174.0, t_input=175.0, t_input_end=179.0, t_end=179.4,
    surfaces=("da", "dr"), kind="doublet", amplitudes={"da": 6.2 * DEGREE, "dr": 4.9 * DEGREE},
    halves={"da": (0.5, 0.5), "dr": (0.5, 0.5)}, symmetry={"da": 0.9, "dr": 0.9},
    left_over={}, cross={}, V=100 * FOOT, alpha=4 * DEGREE, result="too-small",
    findings=(Finding(result="too-small", words="rudder doublet too small: half again",
                      surface="dr", factor=1.5),),
    advice="rudder doublet too small: half again, two thirds stick", card="C1",
)  # fmt: skip
MISSING = ("bank angle is not measured: wings by rates and lateral acceleration",)


def cue(state: str, **more: object) -> TrimCue:
    """Return a trim cue in a state."""
    return TrimCue(time=180.0, state=state, since=178.0, leg_left=7.4, **more)  # type: ignore[arg-type]


BASE = CueSnapshot(
    time=180.0, trim=cue("fly", off=(SLOW, LOW_WING)), card=NEXT, outlook=OUTLOOK,
    speed=97 * FOOT, alpha=4.2 * DEGREE, judged=("wings: rates and lateral acceleration",),
    missing=MISSING, good=5, wanted=12,
)  # fmt: skip


def moving(phase: str, left: float = 1.6) -> InputUnderWay:
    """Return an input under way."""
    return InputUnderWay(
        time=180.0, phase=phase, surfaces=("da", "dr"), t_input=179.0,  # type: ignore[arg-type]
        amplitudes={"da": 6.2 * DEGREE, "dr": 4.9 * DEGREE},
        hands_off_left=left, hands_off_total=2.4,
    )  # fmt: skip


def verdict(result: str, advice: str) -> Verdict:
    """Return a verdict."""
    return replace(VERDICT, result=result, advice=advice)  # type: ignore[type-var]


def danger(words: str, *, warning: bool = True) -> Danger:
    """Return a danger that stands."""
    urgency = Urgency.WARNING if warning else Urgency.CAUTION
    return Danger(key="nose", urgency=urgency, since=178.0, words=words, spoken=words)


STATES: dict[str, CueSnapshot] = {
    "fly": BASE,
    "hold": replace(BASE, trim=cue("hold", progress=0.6), speed=99 * FOOT),
    "go": replace(BASE, trim=cue("go"), speed=100.4 * FOOT),
    "gusty": replace(BASE, trim=cue("gusty", gusts=0.9)),
    "turn": replace(
        BASE,
        trim=cue("turn", off=(Off(quantity="turn", amount=0.3, share=3.0, channel="r"),)),
    ),
    "blind": replace(BASE, trim=cue("blind", missing=("no rates come in",)), speed=None),
    "input": replace(BASE, under_way=moving("moving")),
    "hands-off": replace(BASE, under_way=moving("hands-off")),
    "too-small": replace(BASE, verdict=VERDICT),
    "too-large": replace(
        BASE, verdict=verdict("too-large", "rudder too large, yaw rate clipped: a third less")
    ),
    "too-fast": replace(BASE, verdict=verdict("too-fast", "rudder too fast: 0.5 s each way")),
    "too-slow": replace(BASE, verdict=verdict("too-slow", "rudder too slow: 0.4 s each way")),
    "not-trimmed": replace(
        BASE, verdict=verdict("not-trimmed", "not trimmed: 8 ft/s slow at the start")
    ),
    "spoiled": replace(BASE, verdict=verdict("spoiled", "spoiled: elevator moved with it")),
    "unclear": replace(BASE, verdict=verdict("unclear", "unclear: yaw rate is missing")),
    "good": replace(BASE, verdict=verdict("good", "good")),
    "danger": replace(BASE, dangers=(danger("nose sensors lost: land"),)),
    "caution": replace(BASE, dangers=(danger("yaw gyro clips", warning=False),)),
}
"""Cues by what the page shows of them."""
