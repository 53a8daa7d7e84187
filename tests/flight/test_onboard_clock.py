"""The clock of an on-board log against that of the live record: offset, drift, or a refusal."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.flight.onboard_log import LogClock, OnboardLogState
from gsapp.flight.onboard_log.clock_alignment import ClockAlignmentError, align_clocks
from gsapp.flight.onboard_log.log_merge import resample_to_flight_time
from gsapp.quantities import Block

RATE = 100.0
CHANNELS = ("q", "p", "de")
PHASES = np.random.default_rng(4).uniform(0.0, 7.0, (3, 12))
SPEEDS = 2.0 * np.pi * np.random.default_rng(5).uniform(0.1, 2.0, (3, 12))


def motion(times):
    return np.stack(
        [
            np.sin(np.outer(times, speed) + phase).mean(axis=1)
            for speed, phase in zip(SPEEDS, PHASES, strict=True)
        ],
        axis=1,
    )


def thin_record(seconds, seed=0, noise=0.003, step=0.05):
    random = np.random.default_rng(seed)
    sampled = np.arange(0.0, seconds, step)
    values = motion(sampled) + noise * random.normal(size=(sampled.size, 3))
    times = np.arange(round(seconds * RATE)) / RATE
    columns = [np.interp(times, sampled, column) for column in values.T]
    return Block(channels=CHANNELS, times=times, values=np.stack(columns, axis=1))


def own_log(seconds, offset, drift, seed=1, noise=0.003, late=0.0):
    random = np.random.default_rng(seed)
    middle = 0.5 * seconds
    rows = np.arange(round((late - offset) * RATE), round((seconds - offset) * RATE))
    own = rows / RATE
    at = middle - offset
    flight_time = own + offset - drift * (own - at)
    values = motion(flight_time) + noise * random.normal(size=(rows.size, 3))
    return Block(channels=CHANNELS, times=own, values=values), at


@settings(max_examples=8, deadline=None)
@given(
    offset=st.floats(-50.0, 50.0),
    ppm=st.floats(-300.0, 300.0),
    seed=st.integers(0, 1000),
    step=st.sampled_from([0.05, 0.1, 0.2]),
)
def test_offset_and_drift_are_found_within_their_uncertainties(offset, ppm, seed, step):
    log, at = own_log(300.0, offset, ppm * 1e-6, seed + 1)
    clock = align_clocks(thin_record(300.0, seed, step=step), log, RATE)
    assert clock.drift_std < 3e-6 * (step / 0.05) ** 2
    assert clock.offset_std < 1e-3
    assert abs(clock.drift - ppm * 1e-6) < 4.0 * clock.drift_std
    there = clock.offset - clock.drift * (at - clock.at)
    assert abs(there - offset) < 4.0 * clock.offset_std
    assert clock.agreeing >= 0.8 * clock.windows


def test_a_log_that_drifts_is_laid_on_the_motion_within_a_sample():
    """3.7 s off and 40 ppm fast over ten minutes, which are 24 ms: corrected to a few ms."""
    live = thin_record(600.0)
    log, _ = own_log(600.0, 3.7, 40e-6)
    clock = align_clocks(live, log, RATE)
    assert clock.drifts
    assert clock.drift == pytest.approx(40e-6, abs=3e-6)
    assert "gains 40." in clock.describe() or "gains 39." in clock.describe()
    moved = resample_to_flight_time(log, clock, RATE)
    rows = moved.times * RATE
    np.testing.assert_allclose(rows, np.rint(rows), atol=1e-6)
    for start in (5.0, 300.0, 590.0):
        part = moved.between(start, start + 5.0)
        # The same motion a sample early or late fits worse than as it lies.
        apart = [
            np.square(part.values - motion(part.times + late)).sum() for late in (-0.01, 0.0, 0.01)
        ]
        assert apart[1] == min(apart)
        assert np.sqrt(apart[1] / part.values.size) < 0.004


def test_of_a_long_flight_the_stretches_that_move_count():
    def still_after(block, end, seed):
        noise = 0.003 * np.random.default_rng(seed).normal(size=block.values.shape)
        flown = block.times[:, np.newaxis] < end
        values = np.where(flown, block.values, noise)
        return Block(channels=block.channels, times=block.times, values=values)

    log, at = own_log(900.0, 3.7, 40e-6)
    live = still_after(thin_record(900.0), 70.0, 8)
    clock = align_clocks(live, still_after(log, 70.0 - 3.7, 9), RATE)
    assert clock.agreeing >= 5
    there = clock.offset - clock.drift * (at - clock.at)
    sure = clock.offset_std + clock.drift_std * abs(at - clock.at)
    assert abs(there - 3.7) < 4.0 * sure


def test_without_a_drift_samples_stay_as_they_were_measured():
    live = thin_record(120.0)
    log, _ = own_log(120.0, -12.34, 0.0)
    clock = align_clocks(live, log, RATE)
    assert not clock.drifts
    moved = resample_to_flight_time(log, clock, RATE)
    assert np.array_equal(moved.values, log.values)
    np.testing.assert_allclose(moved.times - log.times, -12.34, atol=1e-6)
    same, _ = own_log(120.0, 0.0, 0.0)
    clock = align_clocks(live, same, RATE)
    assert resample_to_flight_time(same, clock, RATE) is same
    assert "live record's" in clock.describe()


def test_interpolation_keeps_steps_gaps_and_turns():
    times = np.arange(2000) / RATE
    heading = np.remainder(times * 2.0 + np.pi, 2.0 * np.pi) - np.pi
    switch = (times > 10.0).astype(float)
    hole = np.where((times > 5.0) & (times < 5.5), np.nan, np.sin(times))
    log = Block(
        channels=("psi", "rate_switch", "q"),
        times=times,
        values=np.stack([heading, switch, hole], axis=1),
    )
    clock = LogClock(
        offset=0.5, offset_std=1e-4, drift=1e-3, drift_std=1e-6, drifts=True, at=10.0,
        correlation=1.0, windows=5, agreeing=5,
    )  # fmt: skip
    moved = resample_to_flight_time(log, clock, RATE)
    own = 10.0 + (moved.times - 10.0 - 0.5) / (1.0 - 1e-3)
    turn = np.remainder(moved["psi"] - own * 2.0 + np.pi, 2.0 * np.pi) - np.pi
    assert np.nanmax(np.abs(turn)) < 1e-9
    assert set(np.unique(moved["rate_switch"])) == {0.0, 1.0}
    there = ~np.isnan(moved["q"])
    assert np.abs(moved["q"] - np.sin(own))[there].max() < 2e-5
    assert np.count_nonzero(~there) == pytest.approx(50, abs=3)


def test_another_flight_is_refused_and_why():
    live = thin_record(120.0)
    random = np.random.default_rng(8)
    times = np.arange(12000) / RATE
    walk = np.cumsum(random.normal(size=(times.size, 3)), axis=0)
    other = Block(channels=CHANNELS, times=times, values=walk)
    with pytest.raises(ClockAlignmentError, match="correlates"):
        align_clocks(live, other, RATE)
    silent = Block(channels=("alpha",), times=times, values=walk[:, :1])
    with pytest.raises(ClockAlignmentError, match="no moving channel"):
        align_clocks(live, silent, RATE)
    # The same flight, cut into pieces that were put together with pauses left out.
    whole, _ = own_log(120.0, 0.0, 0.0)
    rows = np.concatenate([np.arange(k * 2000, k * 2000 + 1200) for k in range(6)])
    pieced = Block(channels=CHANNELS, times=np.arange(rows.size) / RATE, values=whole.values[rows])
    with pytest.raises(ClockAlignmentError):
        align_clocks(live, pieced, RATE)


def test_the_state_goes_through_the_cache_unchanged():
    clock = LogClock(
        offset=3.7, offset_std=1e-4, drift=4e-5, drift_std=None, drifts=False, at=10.0,
        correlation=0.99, windows=5, agreeing=5,
    )  # fmt: skip
    for state in (
        OnboardLogState(file="a.bin", in_place=True, channels=3, clock=clock),
        OnboardLogState(file="a.bin", in_place=False, why="torn"),
    ):
        assert OnboardLogState.from_json(state.to_json()) == state
