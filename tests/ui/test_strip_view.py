"""The window in time: live, paused, scrolled, zoomed; cursors."""

import pytest

from ui.strips.strip_view import WINDOWS, StripView


def live_view(now=500.0, width=1000, window=60.0):
    view = StripView(width=width, rate=100.0, window=window)
    view.start, view.now = 0.0, now
    return view


def test_live_the_newest_sample_is_in_the_last_column():
    view = live_view()
    for now in (500.0, 500.01, 500.5, 777.77):
        view.now = now
        assert view.x(now) == view.width - 1
        assert not view.paused
        assert view.seconds_behind == 0.0


def test_a_paused_view_stands_still_and_counts_the_seconds_behind():
    view = live_view()
    view.pause()
    before = view.columns
    view.now = 512.5
    assert view.columns == before
    assert view.paused
    assert view.seconds_behind == pytest.approx(12.5)
    view.toggle_pause()
    assert view.x(512.5) == view.width - 1


def test_scrolling_back_pauses_and_reaching_the_newest_sample_goes_on():
    view = live_view()
    view.scroll(-30.0)
    assert view.paused
    assert view.seconds_behind == pytest.approx(30.0)
    view.scroll(-10_000.0)
    assert 0 <= view.x(0.0) < view.width
    view.scroll(+10_000.0)
    assert not view.paused


def test_a_short_flight_does_not_scroll_out_of_sight():
    view = live_view(now=10.0)
    view.scroll(-100.0)
    assert 0 <= view.x(0.0) < view.width
    assert view.x(10.0) == view.width - 1


@pytest.mark.parametrize("steps", [1, -1, 3, -3])
def test_zoom_keeps_the_anchor_in_place_while_paused(steps):
    view = live_view(now=5000.0)
    view.scroll(-2000.0)
    anchor = view.time(300)
    view.zoom(steps, anchor)
    assert view.x(anchor) == pytest.approx(300, abs=2)


def test_zoom_goes_through_all_windows_and_stops_at_the_ends():
    view = live_view(now=9000.0)
    seen = [view.seconds]
    for _ in range(40):
        view.zoom(1)
        seen.append(view.seconds)
    assert view.window == WINDOWS[0]
    assert seen == sorted(seen, reverse=True)
    for _ in range(40):
        before = view.seconds
        view.zoom(-1)
        assert view.seconds > before or view.window == WINDOWS[-1]
    assert view.window == WINDOWS[-1]


def test_time_and_columns_agree():
    view = live_view()
    for window in WINDOWS:
        view.set_window(window)
        for x in (0, 1, 17, view.width - 1):
            assert view.x(view.time(x)) == x


def test_cursors_stand_on_samples():
    view = live_view()
    view.set_cursor("a", 12.3456)
    assert view.cursors["a"] == pytest.approx(12.35)
    view.set_cursor("a", None)
    assert "a" not in view.cursors
    with pytest.raises(ValueError, match="no cursor"):
        view.set_cursor("x", 1.0)


def test_go_to_brings_a_time_to_the_middle():
    view = live_view()
    view.go_to(200.0)
    assert view.x(200.0) == pytest.approx(view.width / 2, abs=1)
    view.go_to_start()
    assert view.x(0.0) == pytest.approx(0, abs=1)


def test_a_jump_back_of_a_replay_ends_a_pause_in_what_is_now_the_future():
    view = live_view()
    view.scroll(-20.0)
    view.set_now(490.0)
    assert view.paused
    view.set_now(100.0)
    assert not view.paused
    assert view.x(100.0) == view.width - 1
