"""Inputs are recognized while they happen, and the verdict on each agrees with the truth."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import Model, load_model
from gsapp.excitation.doublets.doublet_monitor import DoubletMonitor
from gsapp.excitation.doublets.gust_analysis import GustAnalyzer
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FlightRowStream
from gsapp.excitation.test_points.point import TargetInput, ToleranceBand
from gsapp.excitation.trim.trim_cue import DEFAULT_TOLERANCES
from gsapp.flight.cards import TestCard
from gsapp.flight.maneuvers import DetectedManeuver, NoiseFloor, detect_maneuvers
from gsapp.flight.maneuvers.detection import build_maneuver
from gsapp.flight.maneuvers.input_measures import INPUT_CRITERIA, Criterion
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE
from tests.excitation.verdict_kit import (
    RATE,
    FlownInput,
    first_move,
    gust_share,
    label,
    listen,
    own,
    point_of,
    rows_in_ticks,
    wanted_of,
    watched,
)
from tests.flight.maneuver_kit import EVERYTHING, make_flight
from tests.virtual.input_plan import Meddling
from tests.virtual.inputs import fly_input

SEEN = 4.0
"""Seconds of an answer whose gusts are looked for."""
CLEAN = {
    "kind": "doublet",
    "amplitudes": {"de": 4.0 * DEGREE},
    "surfaces": ("de",),
    "width": 0.58,
    "balance": 1.0,
    "bank": 0.0,
    "speed_off": 0.0,
    "roll_rate": 0.0,
    "pitch_rate": 0.0,
    "meddling": (),
    "hands_off": 5.5,
    "left_over": 0.0,
    "turbulence": 0.0,
    "noise": 1.0,
    "speed": 30.48,
    "start": (0.1, 0.0, 0.0, 0.0, 0.0, 0.0),
    "approach": 5.0,
    "still": 1.2,
}


@lru_cache(maxsize=2)
def _clean(hands_off: float = 5.5) -> FlownInput:
    return fly_input(5000, **{**CLEAN, "hands_off": hands_off})


@pytest.mark.long
def test_verdicts_agree_with_the_truth_of_the_simulator() -> None:
    wrong, clear = [], 0  # the benchmark `verdicts` judges 300 inputs
    for seed in range(12_000, 12_010):
        flown = fly_input(seed, ground=4.0, approach=4.0)
        truth = label(flown, wanted_of(flown))
        said = [one.result for one in own(flown, listen(flown, expected=seed % 10 < 7).verdicts)]
        clear += not truth.near
        if not truth.near and said[:1] != [truth.result]:
            wrong.append((seed, truth.result, said))
    assert clear >= 5
    assert len(wrong) <= 1, wrong


def test_recognized_at_once_and_judged_as_soon_as_the_hands_may_come_back() -> None:
    """An input is under way 0.2 s after the surface moved; the verdict waits for no more."""
    flown = _clean()
    heard = listen(flown)
    assert heard.recognized - first_move(flown) < 0.2
    (verdict,) = heard.verdicts
    wanted = wanted_of(flown)
    assert verdict.result == "good"
    assert verdict.advice == "good"
    assert verdict.id == "M1"
    assert verdict.surfaces == ("de",)
    assert 0.0 <= verdict.given_at - verdict.t_input_end - wanted.hands_off < 0.1
    assert heard.countdown - verdict.t_input_end < 1.0
    assert verdict.amplitudes["de"] == pytest.approx(4.0 * DEGREE, rel=0.15)
    assert sum(verdict.halves["de"]) == pytest.approx(2.0 * 0.58, rel=0.05)
    assert verdict.halves["de"] == pytest.approx((0.58, 0.58), rel=0.1)
    assert verdict.symmetry["de"] > 0.8
    assert verdict.left_over["de"] < 0.1


def test_a_hand_put_on_again_ends_the_interval_at_once() -> None:
    """Hands back after a second: invalid, said at once, with how long they were off."""
    flown = _clean(hands_off=1.0)
    verdict = listen(flown).verdicts[0]
    assert verdict.result == "invalid"
    assert "hands off for" in verdict.advice
    assert verdict.given_at < flown.t_hand + 0.5
    assert verdict.t_end == pytest.approx(flown.t_hand + 0.15, abs=0.2)


def test_a_second_stick_that_is_let_go_late_is_no_hand_put_on() -> None:
    late = Meddling(surface="de", size=1.2 * DEGREE, at=0.5, length=1.2)
    rudder = {"amplitudes": {"dr": 9.0 * DEGREE}, "surfaces": ("dr",), "width": 0.5}
    flown = fly_input(5000, **{**CLEAN, **rudder, "meddling": (late,)})
    verdict = watched(flown)[0]
    assert verdict.result == "good"
    assert verdict.cross["de"] > 0.8 * DEGREE
    assert verdict.t_end - verdict.t_input_end > 1.0


def _said(
    parts: Sequence[Block], flown: FlownInput
) -> tuple[tuple[InputVerdict, ...], list[float]]:
    watch = DoubletMonitor(load_aircraft("b777"), RATE)
    watch.expect(wanted_of(flown), point_of(flown), None)
    stream = FlightRowStream(RATE)
    left = []
    for part in parts:
        rows = [*stream.feed(part), *stream.take_complete_rows()]
        for one in rows:
            for low in range(0, len(one), stream.tick):
                watch.process_rows(one.slice_rows(low, low + stream.tick))
                now = watch.input_in_progress
                if now is not None and now.phase == "hands-off":
                    left.append(now.hands_off_left)
    return watch.verdicts, left


@settings(max_examples=3, deadline=None)
@given(cuts=st.lists(st.integers(1, 1400), max_size=8))
def test_cutting_the_stream_changes_nothing(cuts: list[int]) -> None:
    flown = _clean()
    block = flown.measured
    edges = sorted({0, *(cut for cut in cuts if cut < len(block)), len(block)})
    parts = [
        replace(block, times=block.times[low:high], values=block.values[low:high])
        for low, high in itertools.pairwise(edges)
    ]
    verdicts, left = _said(parts, flown)
    assert verdicts == watched(flown)
    assert left == sorted(left, reverse=True)
    assert left[-1] < 0.06


@pytest.mark.parametrize(
    ("missing", "result", "says"),
    [
        (("alpha", "beta"), "good", "angle of attack is not measured"),
        (("q", "an", "alpha"), "unclear", ""),
        (("phi", "theta", "psi"), "good", "no attitude"),
        (("elevator_left", "elevator_right", "de"), None, ""),
    ],
)
def test_what_is_not_measured_is_said_and_not_guessed(
    missing: tuple[str, ...], result: str | None, says: str
) -> None:
    flown = _clean()
    kept = [name for name in flown.measured.channels if name not in missing]
    heard = listen(replace(flown, measured=flown.measured.select(kept)))
    own = [one for one in heard.verdicts if abs(one.t_input - flown.t_input) < 0.8]
    assert [one.result for one in own] == ([] if result is None else [result])
    if says:
        assert any(says in text for text in own[0].judged_by)


def test_a_gap_makes_it_unclear_and_no_aircraft_leaves_the_shape() -> None:
    flown = _clean()
    block = flown.measured
    values = np.array(block.values)
    gone = (block.times > flown.t_input + 1.6) & (block.times < flown.t_input + 4.0)
    values[gone] = np.nan
    holed = replace(flown, measured=replace(block, values=values))
    assert listen(holed).verdicts[0].result == "unclear"
    watch = DoubletMonitor(None, RATE)
    for rows in rows_in_ticks(block):
        watch.process_rows(rows)
    (verdict,) = [one for one in watch.verdicts if abs(one.t_input - flown.t_input) < 0.8]
    assert verdict.kind == "doublet"
    assert any("amplitude and width" in text for text in verdict.judged_by)


def test_what_the_watch_says_live_is_what_the_detection_finds_afterwards() -> None:
    flight = make_flight(EVERYTHING, steering=1.5)
    aircraft = load_aircraft("b777")
    watch = DoubletMonitor(aircraft, RATE)
    for rows in rows_in_ticks(flight.block):
        watch.process_rows(rows)
    found = detect_maneuvers(flight, aircraft)
    assert len(found) == len(watch.verdicts)
    for one, verdict in zip(found, watch.verdicts, strict=True):
        assert verdict.t_input == pytest.approx(one.t_input, abs=0.05)
        assert set(verdict.surfaces) == set(one.inputs)
        assert verdict.kind == one.kind
        assert not (one.grade == "D" and verdict.result == "good")


def test_too_large_is_told_by_what_went_too_far() -> None:
    flown = fly_input(5000, **{**CLEAN, "amplitudes": {"de": 10.0 * DEGREE}})
    seen = watched(flown)[0]
    assert seen.result == "too-large"
    assert seen.findings[0].channel == "alpha"
    assert "linear range" in seen.advice
    blind = watched(flown, invalid=("alpha", "beta"))[0]
    assert blind.result == "too-large"
    assert blind.findings[0].channel == ""
    assert blind.findings[0].factor == pytest.approx(
        wanted_of(flown).amplitudes["de"].best / blind.amplitudes["de"]
    )


def test_a_sensor_at_its_end_is_named_and_one_that_always_stands_there_is_not() -> None:
    flown = _clean()
    block = flown.measured
    index = block.channels.index("q")
    high = load_aircraft("b777").sensors.gyro.range[1]
    values = np.array(block.values)
    values[:, index] = np.clip(5.0 * values[:, index], -high, high)
    clipped = watched(flown, replace(block, values=values))[0]
    assert clipped.result == "too-large"
    assert clipped.findings[0].channel == "q"
    assert "pitch rate clipped" in clipped.advice
    values[:, index] = high
    stuck = watched(flown, replace(block, values=values))[0]
    assert all(one.channel != "q" for one in stuck.findings if one.result == "too-large")
    assert any("saturated" in text for text in stuck.judged_by)


def _gusts(
    flown: FlownInput, surface: str, model: Model | None = None, **added: np.ndarray
) -> float:
    """Return the share of the true answer that a model takes for gusts'."""
    truth = flown.truth
    low = int(np.searchsorted(truth.times, flown.t_input))
    part = slice(low, low + round(SEEN * RATE))
    names = ("alpha", "q", "an") if surface == "de" else ("beta", "p", "r", "ay")
    answers = {name: truth[name][part] + added.get(name, 0.0) for name in names}
    share = GustAnalyzer(load_aircraft("b777"), model or load_model("b777"), RATE).gust_fraction(
        {surface: truth[surface][part]},
        answers,
        [surface],
        speed=float(truth["V"][low]),
        density=float(truth["density"][0]),
        noise=NoiseFloor(),
        trim={
            name: (float(truth[name][low - 100 : low].mean()), float(answers[name][0]))
            for name in names
        },
    )
    assert share is not None
    return share


@pytest.mark.parametrize(
    ("surface", "size", "width"), [("de", 4.0, 0.58), ("da", 4.0, 0.36), ("dr", 8.0, 0.56)]
)
def test_the_share_of_the_gusts_is_what_they_truly_did(
    surface: str, size: float, width: float
) -> None:
    asked = {"amplitudes": {surface: size * DEGREE}, "surfaces": (surface,), "width": width}
    flown = fly_input(5000, **{**CLEAN, **asked, "turbulence": 0.9})
    assert _gusts(flown, surface) == pytest.approx(
        gust_share(flown, flown.t_input + SEEN), rel=0.25
    )


def test_what_one_instrument_alone_shows_is_no_gust() -> None:
    flown = _clean()
    wave = 1.5 * DEGREE * np.sin(2.0 * np.pi * 1.3 * np.arange(round(SEEN * RATE)) / RATE)
    assert _gusts(flown, "de") < 0.2  # the truth is at the CG, the model looks from the instruments
    assert _gusts(flown, "de", q=wave) < 0.2


def test_a_model_with_states_of_its_own_explains_as_well() -> None:
    flown = _clean()
    model = load_model("b777").with_effect("aero.CN.memory")
    assert _gusts(flown, "de", model) < 0.25


def test_a_steady_roll_is_no_gust() -> None:
    aileron = {"amplitudes": {"da": 3.0 * DEGREE}, "surfaces": ("da",), "width": 0.36}
    flown = fly_input(5000, **{**CLEAN, **aileron, "roll_rate": 6.0 * DEGREE})
    assert _gusts(flown, "da") < 0.15


def test_a_doublet_flown_while_its_stick_still_steers_began_out_of_trim() -> None:
    flown = fly_input(16_053)
    assert abs(flown.plan.pitch_rate) > 10.0 * DEGREE
    verdict = watched(flown)[0]
    assert verdict.kind == "doublet"
    assert verdict.result == "not-trimmed"
    assert verdict.t_input == pytest.approx(first_move(flown), abs=0.15)


def test_a_stick_that_comes_all_the_way_back_late_is_in_a_hand() -> None:
    flown = fly_input(5000, **{**CLEAN, "left_over": 0.11})
    block = flown.measured
    values = np.array(block.values)
    hand = flown.t_let_go + 1.5
    elevator = block.channels.index("de")
    aside = (block.times > hand - 0.5) & (block.times < hand)
    before = (block.times > flown.t_input - 0.5) & (block.times < flown.t_input)
    away = np.median(values[aside, elevator]) - np.median(values[before, elevator])
    assert abs(away) > 0.35 * DEGREE
    values[:, elevator] -= away * np.clip((block.times - hand) / 0.3, 0.0, 1.0)
    verdict = watched(flown, replace(block, values=values))[0]
    assert verdict.result == "invalid"
    assert verdict.t_end == pytest.approx(hand, abs=0.4)


def test_a_small_doublet_that_was_expected_is_judged_though_a_hand_follows_at_once() -> None:
    flown = fly_input(16_215, ground=8.0)
    assert max(map(abs, flown.plan.amplitudes.values())) < 1.0 * DEGREE
    (verdict,) = own(flown, listen(flown).verdicts)
    assert verdict.surfaces == flown.plan.surfaces
    assert verdict.result == "invalid"


def test_another_shape_than_the_one_expected_is_told() -> None:
    pulse = fly_input(5000, **{**CLEAN, "kind": "pulse"})
    verdict = watched(pulse, wanted=wanted_of(pulse, kind="doublet"))[0]
    assert (verdict.kind, verdict.result) == ("pulse", "unclear")
    assert "a pulse" in verdict.advice
    uneven = fly_input(5000, **{**CLEAN, "balance": 2.2})
    verdict = watched(uneven)[0]
    assert verdict.result == "good"
    assert "uneven" in verdict.advice
    assert verdict.symmetry["de"] < 0.6


def test_a_card_counts_what_is_good_and_within_its_tolerances() -> None:
    flown = _clean()
    card = TestCard(id="E1", speed="100 ft/s", surfaces=("de",), amplitude="4 deg", width="0.58 s")
    counted = []
    for speed in (30.48, 28.0):
        verdict = watched(flown, card=card.model_copy(update={"speed": speed}))[0]
        counted.append((verdict.card, verdict.counts))
        advice = verdict.advice
    assert counted == [("E1", True), ("E1", False)]
    assert advice.startswith("good, but")
    assert "speed" in advice


OUTSIDE = {"too-small", "too-large", "too-fast", "too-slow"}


@lru_cache
def graded_inputs() -> tuple[FlownInput, ...]:
    return (
        fly_input(5100, **CLEAN),
        fly_input(5101, **{**CLEAN, "surfaces": ("dr",), "amplitudes": {"dr": 11.7 * DEGREE}}),
        fly_input(5102, **{**CLEAN, "turbulence": 0.6}),
    )


def judged_against(
    flown: FlownInput, size: float, width: float
) -> tuple[InputVerdict, TargetInput]:
    """Return the verdict on an input where so many times the usual size and width were asked."""
    usual = wanted_of(flown)
    asked = replace(
        usual,
        amplitudes={name: scaled(band, size) for name, band in usual.amplitudes.items()},
        width=scaled(usual.width, width),
    )
    watch = DoubletMonitor(
        load_aircraft("b777"), RATE, model=load_model("b777"), wanted_for=lambda *_: asked
    )
    watch.expect(asked, point_of(flown), None)
    for rows in rows_in_ticks(flown.measured):
        watch.process_rows(rows)
    watch.finish()
    (verdict,) = watch.verdicts[:1]
    return verdict, asked


def scaled(band: ToleranceBand, factor: float) -> ToleranceBand:
    return replace(band, low=factor * band.low, best=factor * band.best, high=factor * band.high)


@settings(max_examples=8, deadline=None)
@given(number=st.integers(0, 2), size=st.floats(0.2, 8.0), width=st.floats(0.3, 3.0))
@example(number=1, size=0.55, width=1.0)
@example(number=0, size=1.0, width=2.0)
@example(number=0, size=1.0, width=1.0)
def test_grade_and_verdict_never_contradict_each_other(
    number: int, size: float, width: float
) -> None:
    verdict, asked = judged_against(graded_inputs()[number], size, width)
    inside = all(
        asked.amplitudes[name].low <= amplitude <= asked.amplitudes[name].high
        for name, amplitude in verdict.amplitudes.items()
        if name in asked.amplitudes
    )
    if not inside:
        assert verdict.result != "good"
    if OUTSIDE & {one.result for one in verdict.findings}:
        assert verdict.grade != "A"
    assert (verdict.result == "good") == (not verdict.findings)
    if verdict.result == "good":
        assert verdict.grade in ("A", "B")
    if verdict.grade == "A":
        assert verdict.result == "good"


@pytest.mark.parametrize(
    "flaw",
    [
        {"left_over": 0.8},
        {"meddling": (Meddling(surface="da", size=6.0 * DEGREE, at=0.6, length=0.8),)},
        {"amplitudes": {"de": 12.0 * DEGREE}},
    ],
    ids=["left over", "second stick", "out of the linear range"],
)
def test_what_samples_alone_make_invalid_is_no_a_without_a_verdict(
    flaw: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    grades: list[str] = []

    def build(*arguments: Any) -> DetectedManeuver:
        grades.append((found := build_maneuver(*arguments)).grade)
        return found

    monkeypatch.setattr("gsapp.excitation.doublets.verdict_criteria.build_maneuver", build)
    flown = fly_input(5103, **{**CLEAN, **flaw})
    watch = DoubletMonitor(load_aircraft("b777"), RATE)
    for rows in rows_in_ticks(flown.measured):
        watch.process_rows(rows)
    watch.finish()
    assert watch.verdicts[0].findings
    assert watch.verdicts[0].result != "unclear"
    assert grades[0] != "A"


def test_criteria_of_verdict_and_grade_are_in_order() -> None:
    with pytest.raises(ValueError, match="small <= invalid <= large"):
        Criterion(small=0.3, invalid=0.2)
    with pytest.raises(ValueError, match="small <= invalid <= large"):
        Criterion(small=0.1, invalid=0.5, large=0.4)
    found = Criterion(small=0.1, invalid=0.2, large=0.3)
    assert [found.severity(value) for value in (0.1, 0.15, 0.3, 0.4)] == [
        None, "small", "small", "large",
    ]  # fmt: skip
    assert [found.is_invalid(value) for value in (0.2, 0.25)] == [False, True]
    rates = (
        INPUT_CRITERIA.trim_tolerance_factor * rate
        for rate in (
            DEFAULT_TOLERANCES.roll_rate,
            DEFAULT_TOLERANCES.pitch_rate,
            DEFAULT_TOLERANCES.yaw_rate,
        )
    )
    trim = INPUT_CRITERIA.trim_rate
    assert all(trim.small <= rate * (1.0 + 1e-9) <= trim.large for rate in rates)


def test_twice_what_was_asked_is_too_large_though_nothing_left_its_linear_range() -> None:
    verdict, asked = judged_against(graded_inputs()[1], 0.55, 1.0)
    assert verdict.amplitudes["dr"] > asked.amplitudes["dr"].high
    assert verdict.result == "too-large"
    assert verdict.grade == "B"
    assert verdict.findings[0].surface == "dr"
