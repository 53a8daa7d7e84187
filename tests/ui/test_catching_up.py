"""What stands in the window while alarms and cues are still those of an earlier time."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

from gsapp.excitation.announcer import Announcement
from gsapp.session import Alarm, Session, Severity
from gsapp.session.cue_monitor import CueMonitor
from tests.ui.window_kit import Loudspeaker, Mouth, open_window, until, write_flight


def test_what_was_true_a_while_ago_is_neither_shown_nor_said(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not "ALARMS none" in green, no cue, no voice; all of it when the flight is caught up with."""
    watched = 0.349
    monkeypatch.setattr(Session, "monitored_fraction", property(lambda _self: watched))
    window = open_window(tmp_path, flight_speech="always")
    qtbot.addWidget(window)
    loud, mouth = Loudspeaker(), Mouth()
    window.voice._player = loud
    window.voice._set_speaker(mouth)
    window.voice.set_muted(False)
    window.flight_controller.flight_opener.open_flight(
        write_flight(tmp_path / "flights"), playing=False
    )
    until(qtbot, lambda: window.flight_controller.is_loaded)
    session = window.flight_controller.session
    assert session is not None
    alarm = Alarm(
        key="limit:alpha", severity=Severity.WARNING, current=Severity.WARNING, time=3.0,
        message="alpha high",
    )  # fmt: skip
    monkeypatch.setattr(window.flight_controller, "unacknowledged_alarms", lambda: (alarm,))

    def tell() -> None:
        watch = session.cue_monitor
        assert isinstance(watch, CueMonitor)
        time = watch.cueing.snapshot().time
        assert time is not None
        watch.spoken.append(Announcement(time=time, text="hands off", priority="prompt", tone=""))
        window.flight_controller._refresh(session)
        # An aircraft that stands still gives alarms of its own.
        window.flight_controller._snapshot = replace(session.snapshot(), alarms=())
        window.pilot_page.refresh()
        window.pilot_page.state.update()

    window.flight_controller.seek(15.0)
    until(qtbot, lambda: session.feed.caught_up)
    tell()
    *_, alarms = window._status_items()
    assert (alarms.value, alarms.note, alarms.state) == ("catching up", "34 %", "unknown")
    assert "34 %" in window.view.alarms._empty.text()
    sheet = window.pilot_page.state.build_display("US")
    assert (sheet.status_text, sheet.leg_time_text, sheet.card.time_left_text) == (
        "NO CUE",
        "–",
        "",
    )
    assert any("34 %" in hint.text for hint in sheet.hints)
    assert (loud.tones, mouth.spoken) == ([], [])

    watched = 1.0
    monkeypatch.setattr(Session, "monitored_fraction", property(lambda _self: watched))
    tell()
    *_, alarms = window._status_items()
    assert alarms.value == "none"
    assert window.view.alarms._empty.text() == "No alarms."
    assert "catching up" not in str(window.pilot_page.state.build_display("US"))
    assert loud.tones == ["warning"]
    assert "alpha high" in mouth.spoken
    window.flight_controller.close_flight()


def test_a_held_replay_that_jumped_catches_up_without_a_rest(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = open_window(tmp_path)
    qtbot.addWidget(window)
    window.flight_controller.flight_opener.open_flight(
        write_flight(tmp_path / "flights"), playing=False
    )
    until(
        qtbot, lambda: window.flight_controller.is_loaded and window.flight_controller.is_up_to_date
    )
    session = window.flight_controller.session
    behind = True
    monkeypatch.setattr(type(session.feed), "caught_up", property(lambda _feed: not behind))
    monkeypatch.setattr(
        window.flight_controller.poller._pace, "may_begin_frame", lambda _now: False
    )
    taken_in: list[float] = []
    monkeypatch.setattr(session, "update", taken_in.append)
    window.flight_controller.poller._refreshed_at = math.inf
    window.flight_controller.poller.tick()
    assert len(taken_in) == 1
    behind = False
    window.flight_controller.poller.tick()
    assert len(taken_in) == 1
    window.flight_controller.close_flight()


def test_a_paused_display_says_that_recording_goes_on(qtbot: QtBot, tmp_path: Path) -> None:
    """And the newest time is that of now only once the record was read up to it."""
    window = open_window(tmp_path)
    qtbot.addWidget(window)
    picture = window.view._state
    window.view.show_state(replace(picture, recording=True, present_shown=False))
    assert (window.view.charts.model.recording, window.view.charts.model.newest_text) == (
        True,
        "read up to",
    )
    window.view.show_state(replace(picture, recording=False))
    assert (window.view.charts.model.recording, window.view.charts.model.newest_text) == (
        False,
        "now",
    )


def test_values_are_stale_when_the_flight_says_so(qtbot: QtBot, tmp_path: Path) -> None:
    window = open_window(tmp_path)
    qtbot.addWidget(window)
    window.flight_controller.flight_opener.open_flight(
        write_flight(tmp_path / "flights"), playing=False
    )
    until(qtbot, lambda: bool(window.view._state.available))
    session, picture = window.flight_controller.session, window.view._state
    assert picture.stale_ages == session.stale_timeouts(picture.available)
    window.view.show_state(replace(picture, stale_ages={"battery": 10.0}))
    assert window.view.charts.model.stale_ages == {"battery": 10.0}
    window.flight_controller.close_flight()
