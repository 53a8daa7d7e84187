"""When frames begin: with the samples, not sooner than the last one allows."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ui.session_poller
from tests.ui.window_kit import open_window, write_flight
from ui.session_poller import MIN_LIVE_FRAME_SECONDS, MIN_REPLAY_FRAME_SECONDS, FrameRateLimiter


def frames(pace, looks, cost):
    begun = []
    busy = 0.0
    for now in looks:
        if now >= busy and pace.may_begin_frame(now):
            begun.append(now)
            busy = now + cost
            pace.record_frame(now, busy)
    return begun


def test_every_sample_of_a_hundred_hertz_has_its_frame_and_no_more():
    """Proves that the grid's rate passes, wherever looks and samples lie, and faster ones do not.

    A sample waits for the next look; the frame it gets is never put off to the next sample.
    """
    for shift in (0.0, 0.0004, 0.0011, 0.0027):
        pace = FrameRateLimiter(MIN_LIVE_FRAME_SECONDS)
        looks = [0.003 * k for k in range(4000)]
        seen, begun = -1, []
        for now in looks:
            newest = int((now - shift) / 0.01 + 1e-9)
            if newest > seen and pace.may_begin_frame(now):
                assert newest == seen + 1 or seen < 0
                seen = newest
                begun.append(now)
                pace.record_frame(now, now + 0.002)
        assert len(begun) == pytest.approx(1200, abs=2)
    always = frames(FrameRateLimiter(MIN_LIVE_FRAME_SECONDS), looks, 0.001)
    assert len(always) / 12.0 < 1.01 / MIN_LIVE_FRAME_SECONDS


def test_a_late_frame_does_not_put_off_the_next_one():
    pace = FrameRateLimiter(MIN_LIVE_FRAME_SECONDS)
    for k in range(5):
        pace.record_frame(0.01 * k, 0.01 * k + 0.002)
    # This one began late and was held up, too.
    pace.record_frame(0.055, 0.0575)
    assert pace.may_begin_frame(0.0605)
    pace.record_frame(0.0605, 0.0625)
    assert not pace.may_begin_frame(0.064)
    assert pace.may_begin_frame(0.0705)


@given(cost=st.floats(0.004, 0.2))
@settings(max_examples=30, deadline=None)
def test_dear_frames_leave_most_of_the_time_to_everything_else(cost):
    begun = frames(
        FrameRateLimiter(MIN_LIVE_FRAME_SECONDS), [0.001 * k for k in range(20_000)], cost
    )
    assert len(begun) * cost / 20.0 < 0.4 + cost / 20.0


def test_a_replay_is_painted_with_the_screen_and_a_paused_one_not_at_all(
    qtbot, tmp_path, monkeypatch
):
    clock = [100.0]
    monkeypatch.setattr(ui.session_poller.time, "monotonic", lambda: clock[0])
    window = open_window(tmp_path)
    qtbot.addWidget(window)
    controller = window.flight_controller
    controller.flight_opener.open_flight(write_flight(tmp_path))
    qtbot.waitUntil(lambda: controller.is_loaded, timeout=10_000)
    controller.poller._timer.stop()
    painted = []
    controller.frame_requested.connect(painted.append)

    def count_frames(seconds):
        painted.clear()
        for _ in range(round(seconds / 0.003)):
            clock[0] += 0.003
            controller.poller.tick()
        return len(painted) / seconds

    assert count_frames(3.0) == pytest.approx(1.0 / MIN_REPLAY_FRAME_SECONDS, abs=2)
    assert painted == sorted(painted)
    controller.toggle_play()
    count_frames(0.1)
    assert count_frames(3.0) <= 5
    controller.seek(7.0)
    count_frames(0.02)
    assert 7.0 in painted
    controller.close()
