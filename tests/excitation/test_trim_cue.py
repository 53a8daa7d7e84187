"""The trim cue: right by the simulator's own states, steady, honest about what it lacks."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from gsapp.excitation.flight_rows import FlightRows, rows_from_block
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.excitation.trim.trim_monitor import TrimMonitor
from gsapp.quantities.constants import DEGREE, FOOT
from tests.excitation.trim_kit import RATE, SPEED, aircraft, at, changed, cues, drawn, ramped
from tests.virtual.approaches import fly_approach
from tests.virtual.inputs import FlownInput
from tests.virtual.trim_truth import INSTRUMENTS, Score, score

LEVEL = np.zeros(1000)
AIR = {1: 0.3, 2: 0.6}


@pytest.fixture(scope="module")
def flights() -> list[FlownInput]:
    return [fly_approach(seed, turbulence=air) for seed, air in AIR.items()]


@pytest.fixture(scope="module")
def rows(flights: list[FlownInput]) -> FlightRows:
    return rows_from_block(flights[-1].measured, RATE)


# Against the truth ---------------------------------------------------------------------


@pytest.mark.long
def test_go_comes_only_in_trim_and_then_soon(flights: list[FlownInput]) -> None:
    """By the simulator's states over the last second no GO is wrong, and few come late.

    Two flights of the benchmark ``trim_cue``, in light gusts and in stronger ones, each with every
    set of instruments.
    """
    together = Score()
    for flown in flights:
        for instruments in INSTRUMENTS:
            together.add(score(flown, instruments))
    assert together.wrong == 0
    assert together.right >= 4
    assert together.trimmed >= 4
    assert together.in_time >= together.trimmed - 1
    assert together.hasty == 0


def test_rough_air_is_told_from_bad_flying() -> None:
    random = np.random.default_rng(5)
    block = drawn(LEVEL)
    wild = np.convolve(random.standard_normal(block.times.size), np.ones(20) / 20, "same")
    gusty = changed(
        block,
        alpha=block["alpha"] + 5.0 * DEGREE * wild,
        an=block["an"] + 12.0 * wild,
        p=block["p"] + 0.6 * (wild - wild.mean()),
    )
    found = cues(gusty)
    assert {cue.state for cue in found if cue.time > 6.5} == {"gusty"}
    strength = at(found, 9.0).gust_strength
    assert strength > 0.5
    leaning = drawn(np.full(1000, 12.0 * DEGREE))
    assert at(cues(leaning), 9.0).state in ("fly", "turn")


# Steady --------------------------------------------------------------------------------


@settings(max_examples=8, deadline=None)
@given(cuts=st.lists(st.integers(1, 400), max_size=8))
def test_cutting_the_stream_changes_nothing(rows: FlightRows, cuts: list[int]) -> None:
    part = rows.slice_rows(500, 2000)
    whole = cues(part, point=None)
    assert len({cue.since for cue in whole}) > 3
    pieces = TrimMonitor(aircraft(), RATE)
    edges = sorted({0, *(5 * min(cut, 300) for cut in cuts), 1500})
    for start, stop in pairwise(edges):
        pieces.process_rows(part.slice_rows(start, stop))
        assert pieces.cue == whole[stop // 5 - 1]


def test_no_state_is_left_at_once(rows: FlightRows) -> None:
    changes = [cue for cue in cues(rows, point=None) if cue.since == cue.time]
    assert len(changes) > 3
    for before, after in pairwise(changes):
        assert before.state == "go" or after.since - before.since > 0.59


def test_go_ends_at_once_when_trim_is_lost() -> None:
    found = cues(drawn(ramped((8.0, 0.0), (1.0, 40.0))))
    assert at(found, 8.0).state == "go"
    first = next(cue for cue in found if cue.time > 8.0 and cue.state != "go")
    assert first.time < 8.35


def test_no_go_while_held_off() -> None:
    watch = TrimMonitor(aircraft(), RATE)
    watch.inhibit_go(6.0)
    found = cues(drawn(LEVEL), watch)
    assert {cue.state for cue in found if cue.time < 6.0} <= {"fly", "hold"}
    assert at(found, 6.3).state == "go"
    # What an input shakes is not taken for gusts, soon after it either.
    assert at(found, 9.0).gust_strength is None


# What is off ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bank", "speed", "words"),
    [
        (-6.5, SPEED, "left wing low 6 deg"),
        (0.0, SPEED - 9.0 * FOOT, "9 ft/s slow"),
        (0.0, SPEED + 7.0 * FOOT, "7 ft/s fast"),
    ],
)
def test_the_spotter_hears_what_is_off_and_which_way(bank: float, speed: float, words: str) -> None:
    cue = at(cues(drawn(np.full(900, bank * DEGREE), speed=speed)), 8.5)
    assert cue.state == "fly"
    assert cue.worst.format_text() == words


def test_without_attitude_the_wing_is_named_without_degrees() -> None:
    cue = at(cues(drawn(np.full(900, 9.0 * DEGREE), attitude=False)), 8.5)
    assert cue.worst.format_text() == "right wing low"
    text = "turn rate, rate of roll, lateral acceleration and beta (no attitude)"
    assert f"wings: {text}" in cue.judged_by


def test_without_a_point_any_steady_speed_will_do() -> None:
    found = cues(drawn(LEVEL, speed=24.0), point=None)
    assert at(found, 9.0).state == "go"
    assert any("no test point" in text for text in at(found, 9.0).judged_by)
    assert at(cues(drawn(LEVEL, speed=24.0)), 9.0).state == "fly"


def test_climbing_is_off() -> None:
    block = drawn(LEVEL)
    rising = changed(block, altitude=block["altitude"] + 8.0 * FOOT * block.times)
    worst = at(cues(rising), 9.0).worst
    assert worst.quantity == "climb"
    assert abs(worst.amount - 8.0 * FOOT) < 1.0 * FOOT


# With what is there --------------------------------------------------------------------


def _missing(cue: TrimCue) -> str:
    return "; ".join(cue.limitations)


def test_on_the_ground_it_says_nothing_of_flying() -> None:
    level = drawn(LEVEL, attitude=False)
    flying = changed(level, q=level["q"] + 4.0 * DEGREE)
    still = changed(flying, V=0.5)
    watch = TrimMonitor(aircraft(), RATE)
    assert {cue.state for cue in cues(still, watch) if cue.time > 2.5} == {"ground"}
    assert at(cues(flying, watch), 9.0).state == "go"
    assert at(cues(flying), 9.0).state == "fly"


def test_blind_without_rates() -> None:
    found = cues(changed(drawn(LEVEL), p=None, q=None, r=None))
    assert {cue.state for cue in found} == {"blind"}
    assert found[-1].deviations == ()
    assert "pitch rate" in _missing(found[-1])


@pytest.mark.parametrize(
    ("gone", "named"),
    [
        (("alpha", "beta"), "from the speed"),
        (("altitude",), "no height"),
        (("phi", "theta", "psi", "r"), "neither attitude nor yaw rate"),
        (("ax", "ay"), ""),
    ],
)
def test_what_is_not_measured_is_not_judged_and_said(gone: tuple[str, ...], named: str) -> None:
    cue = at(cues(changed(drawn(LEVEL), **dict.fromkeys(gone))), 9.0)
    assert cue.state == "go"
    assert named in _missing(cue)


def test_without_airspeed_all_counts_as_flown() -> None:
    cue = at(cues(changed(drawn(LEVEL), V=None), TrimMonitor(None, RATE)), 9.0)
    assert cue.state == "go"
    assert "no airspeed" in _missing(cue)


def test_a_stuck_channel_is_not_believed() -> None:
    found = cues(changed(drawn(LEVEL), alpha=20.0 * DEGREE))
    assert at(found, 1.5).state != "go"
    assert at(found, 9.0).state == "go"
    assert "alpha is constant" in _missing(at(found, 9.0))


def test_a_distrusted_channel_is_as_good_as_missing() -> None:
    block = drawn(LEVEL)
    lying = changed(block, q=block["q"] + 0.3, **{"q.2": block["q"]})
    watch = TrimMonitor(aircraft(), RATE)
    watch.set_invalid_channels(("q",))
    assert at(cues(lying, watch), 9.0).state == "go"
    assert "pitch rate" not in _missing(at(cues(lying, watch), 9.0))
    assert at(cues(lying), 9.0).state == "fly"


def test_without_an_aircraft_it_still_judges() -> None:
    assert at(cues(drawn(LEVEL), TrimMonitor(None, RATE)), 9.0).state == "go"
    slow = cues(drawn(LEVEL, speed=8.0), TrimMonitor(None, RATE), point=None)
    assert {cue.state for cue in slow if cue.time > 2.5} == {"ground"}


def test_gaps_do_no_harm() -> None:
    block = drawn(LEVEL)
    holes = np.where((np.arange(1000) % 50 < 10) | (np.arange(1000) > 800), np.nan, 1.0)
    found = cues(changed(block, **{name: block[name] * holes for name in block.channels}))
    assert at(found, 7.5).state == "go"
    assert found[-1].state == "blind"


@settings(max_examples=12, deadline=None)
@example(name="altitude", value=1e4, start=0, length=6)
@example(name="altitude", value=0.0, start=100, length=80)
@given(
    name=st.sampled_from(["p", "r", "an", "alpha", "beta", "V", "phi", "theta", "altitude"]),
    value=st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e300, 0.0, 1e4]),
    start=st.integers(0, 200),
    length=st.integers(1, 80),
)
def test_garbage_does_no_harm(name: str, value: float, start: int, length: int) -> None:
    block = drawn(np.zeros(800), position=True)
    bad = block[name].copy()
    bad[start : start + length] = value
    assert cues(changed(block, **{name: bad}), since=7.9)[-1].state == "go"
