"""Parts of the trim cue: straight legs of the pattern, windows, observers, states, ticks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.excitation.flight_rows import rows_from_block
from gsapp.excitation.settings import CUES, TRIM
from gsapp.excitation.trim.bank_observer import BankObserver
from gsapp.excitation.trim.motion_estimator import ClimbObserver, MovingWindow
from gsapp.excitation.trim.tick_means import TICK_INDEX, TickMeans
from gsapp.excitation.trim.trim_cue import TrimDeviation
from gsapp.excitation.trim.trim_monitor import StateHysteresis, TrimMonitor
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE, GRAVITY
from tests.excitation.trim_kit import RATE, SPEED, aircraft, at, changed, cues, drawn, ramped

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
    assert any("position" in text for text in at(found, ONSET - 5.0).judged_by) == position


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
    assert any("no earlier lap" in text for text in cue.limitations)


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


DT = 0.05


# Windows -------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000), cut=st.integers(0, 60), share=st.floats(0.0, 0.5))
def test_lines_are_those_of_least_squares(seed: int, cut: int, share: float) -> None:
    """Mean, slope and power of every window are those of `numpy.polyfit`; cuts change nothing."""
    random = np.random.default_rng(seed)
    values = random.standard_normal((60, 2))
    values[random.random(60) < share, 1] = np.nan
    whole, pieces = MovingWindow(20, 2), MovingWindow(20, 2)
    found = whole.fit_windows(values)
    parts = pieces.fit_windows(values[:cut]), pieces.fit_windows(values[cut:])
    for name in ("mean", "slope", "power"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(found, name))
    place = np.arange(20)
    for end in (19, 37, 59):
        window = values[end - 19 : end + 1, 0]
        slope, offset = np.polyfit(place, window, 1)
        rest = window - slope * place - offset
        assert found.mean[end, 0] == pytest.approx(window.mean())
        assert found.slope[end, 0] == pytest.approx(slope)
        assert found.power[end, 0] == pytest.approx((rest**2).mean())
        there = np.isfinite(values[end - 19 : end + 1, 1])
        if there.sum() >= 12:
            known = values[end - 19 : end + 1, 1][there]
            assert found.mean[end, 1] == pytest.approx(known.mean())
        else:
            assert np.isnan(found.mean[end, 1])


# Observers -----------------------------------------------------------------------------


def test_bank_is_known_without_attitude() -> None:
    bank = ramped((8.0, 12.0), (6.0, -4.0), (8.0, 45.0), (8.0, 0.0), (8.0, -45.0), (10.0, 3.0))
    block = drawn(bank, attitude=False)
    ticks, _ = TickMeans(5, DT).average_rows(rows_from_block(block, RATE))
    for vane in (True, False):
        watch = BankObserver(DT, SPEED)
        misses = []
        for index, values in enumerate(ticks):
            row = {name: float(values[column]) for name, column in TICK_INDEX.items()}
            beta = row["beta"] if vane else np.nan
            watch.step((row["p"], row["q"], row["r"]), row["ax"], row["ay"], row["V"], beta, 0.0)
            misses.append(watch.bank - bank[5 * index + 2])
        late = np.array(misses[120:])
        assert np.sqrt((late**2).mean()) < 1.3 * DEGREE
        assert np.abs(late).max() < 4.0 * DEGREE
        assert watch.bank_std < 3.0 * DEGREE


def test_climb_is_known_now_though_height_comes_late() -> None:
    random = np.random.default_rng(3)
    count = round(16.0 / DT)
    lift = np.zeros(count)
    lift[200:210] = -4.0
    climb = 1.0 + np.cumsum(lift) * DT
    height = 100.0 + np.cumsum(climb) * DT
    watch = ClimbObserver(DT)
    late = round(CUES.slow_channel_delay / DT)
    found = []
    for place in range(count):
        shown = height[place - late] + 0.5 * random.standard_normal() if place >= late else np.nan
        watch.step(shown, np.nan, lift[place] + 0.02 * GRAVITY * random.standard_normal())
        found.append(watch.climb)
    misses = np.abs(np.array(found) - climb)
    assert np.nanmax(misses[120:200]) < 0.5
    assert misses[211:].max() < 0.6


def test_climb_from_a_rate_alone_and_from_nothing() -> None:
    watch = ClimbObserver(DT)
    for _ in range(200):
        watch.step(np.nan, 1.5, 0.0)
    assert watch.climb == pytest.approx(1.5, abs=0.05)
    for _ in range(60):
        watch.step(np.nan, np.nan, 0.0)
    assert np.isnan(watch.climb)


# States --------------------------------------------------------------------------------

_WANTED = st.tuples(st.sampled_from(["fly", "hold", "go", "gusty", "turn", "blind"]), st.booleans())


@settings(max_examples=50, deadline=None)
@given(samples=st.lists(_WANTED, min_size=1, max_size=120))
def test_states_stand_for_a_while(samples: list[tuple[str, bool]]) -> None:
    keeper = StateHysteresis("fly", 0.0)
    for tick, (wanted, lost) in enumerate(samples, start=1):
        before, since = keeper.state, keeper.since
        keeper.step(tick * DT, wanted, lost=lost)  # type: ignore[arg-type]
        changed_now = keeper.since != since
        assert changed_now == (keeper.state != before)
        if changed_now:
            assert keeper.state == wanted
            assert (before == "go" and lost) or tick * DT - since >= TRIM.min_dwell_time - 1e-6
        if before == "go" and lost:
            assert keeper.state == wanted


# Ticks and words -----------------------------------------------------------------------


def test_ticks_leave_out_what_is_not_to_be_believed() -> None:
    block = drawn(np.zeros(400))
    block = changed(block, alpha=0.1, **{"r.3": block["r"] + 1.0})
    means = TickMeans(5, DT)
    means.invalid_channels = frozenset(("r", "beta"))
    ticks, stuck = means.average_rows(rows_from_block(block, RATE))
    assert ticks.shape == (80, len(TICK_INDEX))
    assert ticks[3, TICK_INDEX["p"]] == pytest.approx(block["p"][15:20].mean())
    assert np.isnan(ticks[:, TICK_INDEX["beta"]]).all()
    np.testing.assert_allclose(ticks[:, TICK_INDEX["r"]], 1.0, atol=0.05)
    assert np.isfinite(ticks[20, TICK_INDEX["alpha"]])
    assert np.isnan(ticks[60, TICK_INDEX["alpha"]])
    assert stuck[20] == ()
    assert stuck[60] == ("alpha",)


@pytest.mark.parametrize("rate", [20.0, 25.0, 50.0])
def test_slower_records_serve(rate: float) -> None:
    step = round(RATE / rate)
    full = drawn(np.zeros(1000))
    block = Block(
        channels=full.channels,
        times=np.arange(1000 // step) / rate,
        values=full.values[: 1000 // step * step : step],
    )
    watch = TrimMonitor(aircraft(), rate)
    watch.process_rows(rows_from_block(block, rate))
    assert watch.cue.state == "go"


@pytest.mark.parametrize(
    ("quantity", "amount", "channel", "us", "si"),
    [
        ("speed", -0.95, "V", "3 ft/s slow", "0.9 m/s slow"),
        ("bank", -6.2 * DEGREE, "phi", "left wing low 6 deg", "left wing low 6 deg"),
        ("bank", 6.2 * DEGREE, "r", "right wing low", "right wing low"),
        ("climb", 1.2, "climb_rate", "climbing 4 ft/s", "climbing 1.2 m/s"),
        ("alpha", -2.2 * DEGREE, "alpha", "alpha low 2 deg", "alpha low 2 deg"),
        ("pitch rate", -0.1, "q", "nose dropping", "nose dropping"),
        ("acceleration", 0.9, "ax", "speeding up", "speeding up"),
        ("height", 20.0, "height", "66 ft high", "20 m high"),
        ("unrest", 0.8, "alpha", "rough air", "rough air"),
    ],
)
def test_words_of_a_spotter(quantity: str, amount: float, channel: str, us: str, si: str) -> None:
    off = TrimDeviation(quantity=quantity, amount=amount, tolerance_ratio=1.5, channel=channel)
    assert off.format_text() == us
    assert off.format_text("SI") == si
