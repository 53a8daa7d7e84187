"""Straight legs of the pattern: learned from earlier laps, by position or by turns alone."""

import numpy as np
import pytest

from gsapp.excitation.trim.settings import TRIM
from gsapp.excitation.trim.trim_monitor import TrimMonitor
from tests.excitation.trim_kit import RATE, aircraft, at, changed, cues, drawn, ramped

# 45 deg of bank at 30 m/s turn by 180 deg in so many seconds, rolling in included.
TURN, LEG = 9.73, 12.0
LAPS = ramped((6.0, 0.0), *(((TURN, -45.0), (LEG, 0.0)) * 3), (5.0, -45.0))
ONSET = 6.0 + 3 * (TURN + LEG)
"""When the fourth turn begins, s."""


@pytest.mark.parametrize("position", [True, False])
def test_seconds_left_of_a_leg_are_learned(position: bool) -> None:
    found = cues(drawn(LAPS, position=position, attitude=False), point=None, since=ONSET - 9.0)
    for before in (8.0, 5.0, 2.0):
        left = at(found, ONSET - before).leg_time_left
        assert abs(left - before) < 0.5
    assert any("position" in words for words in at(found, ONSET - 5.0).judged_by) == position


def test_no_go_before_a_turn_nor_in_it() -> None:
    block = drawn(LAPS, position=True)
    watch = TrimMonitor(aircraft(), RATE)
    found = cues(block, watch, point=None, since=ONSET - 9.0)
    last = max(cue.time for cue in found if cue.state == "go" and cue.time < ONSET)
    assert TRIM.min_leg_time_left < ONSET - last < TRIM.min_leg_time_left + 1.5
    assert at(found, ONSET + 4.0).state == "turn"
    watch = TrimMonitor(aircraft(), RATE)
    watch.require_leg_time(5.5)
    found = cues(block, watch, point=None, since=ONSET - 9.0)
    last = max(cue.time for cue in found if cue.state == "go" and cue.time < ONSET)
    assert 5.5 < ONSET - last < 5.5 + 1.5


def test_a_leg_is_not_too_short_for_an_input_under_way() -> None:
    watch = TrimMonitor(aircraft(), RATE)
    watch.inhibit_go(ONSET + 1.0)
    found = cues(drawn(LAPS, position=True), watch, point=None, since=ONSET - 4.0)
    assert {cue.state for cue in found if ONSET - 3.0 < cue.time < ONSET} <= {"hold", "fly"}
    assert at(found, ONSET + 2.0).state == "turn"


def test_without_an_earlier_lap_nothing_is_claimed() -> None:
    cue = at(cues(drawn(np.zeros(1000), position=True)), 9.0)
    assert cue.state == "go"
    assert cue.leg_time_left is None
    assert any("no earlier lap" in words for words in cue.limitations)


def test_wind_does_not_matter_to_legs_of_one_direction() -> None:
    up, down = 15.0, 9.0
    bank = ramped(
        (6.0, 0.0),
        *(((TURN, -45.0), (up, 0.0), (TURN, -45.0), (down, 0.0)) * 2),
        (TURN, -45.0),
        (up, 0.0),
    )
    found = cues(drawn(bank, attitude=False), point=None, since=100.0)
    # The third leg upwind begins after five turns.
    onset = 6.0 + 5 * TURN + 2 * (up + down) + up
    left = at(found, onset - 6.0).leg_time_left
    assert abs(left - 6.0) < 0.5


def test_latitude_and_longitude_serve_as_well() -> None:
    block = drawn(LAPS, position=True, attitude=False)
    radius, latitude = 6_371_000.0, 0.69
    turned = changed(
        block,
        north=None,
        east=None,
        latitude=latitude + block["north"] / radius,
        longitude=-1.4 + block["east"] / (radius * np.cos(latitude)),
    )
    left = at(cues(turned, point=None, since=ONSET - 6.0), ONSET - 5.0).leg_time_left
    assert abs(left - 5.0) < 0.5


def test_yawing_level_is_no_turn() -> None:
    block = drawn(np.zeros(1000))
    swung = changed(block, r=block["r"] + 0.25 * np.sin(3.0 * block.times))
    assert "turn" not in {cue.state for cue in cues(swung, point=None)}
    assert at(cues(drawn(ramped((5.0, 0.0), (5.0, 40.0)))), 8.0).state == "turn"


def test_a_swerve_is_no_turn_of_the_pattern() -> None:
    swerve = ((3.0, 0.0), (1.3, 30.0), (1.3, -30.0), (LEG - 5.6, 0.0))
    bank = ramped((6.0, 0.0), *(((TURN, -45.0), (LEG, 0.0)) * 2), (TURN, -45.0), *swerve)
    found = cues(drawn(bank, attitude=False), point=None, since=ONSET - 5.0)
    left = at(found, ONSET - 4.0).leg_time_left
    assert abs(left - 4.0) < 0.6
