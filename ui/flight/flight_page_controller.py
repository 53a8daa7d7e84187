"""The Flight page, and what the crew does there: marks, alarms, sound, running a replay."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QStackedWidget, QWidget

from gsapp.quantities import channel
from gsapp.session import Alarm, Severity
from gsapp.session.limits import LimitBands
from gsapp.session.user_limit_store import UserLimitStore
from ui.dialogs.flight_dialogs import GoToDialog, RangeDialog
from ui.dialogs.limits import LimitsDialog
from ui.display_limits import DISPLAY
from ui.display_style import DisplayStyle
from ui.flight.controls import next_speed
from ui.flight.flight_view import FlightView
from ui.flight.flight_view_state import FlightViewState, FlightViewStateBuilder
from ui.flight_controller import FlightController
from ui.settings import SettingsStore
from ui.start_page import StartPage
from ui.voice.speech_queue import UtterancePriority
from ui.voice.voice import Voice


class FlightPage(QStackedWidget):
    """Shows the start page until a flight is open."""

    def __init__(self, start: StartPage, view: FlightView) -> None:
        super().__init__()
        self.start = start
        self.view = view
        self.addWidget(start)
        self.addWidget(view)

    def show_flight(self, shown: bool) -> None:
        self.setCurrentWidget(self.view if shown else self.start)

    def set_initial_focus(self) -> None:
        """Put the keyboard into the charts, or the start page."""
        (self.view.charts if self.currentWidget() is self.view else self.start).setFocus()


class FlightPageController(QObject):
    """Binds the view of a flight to the flight controller."""

    def __init__(
        self,
        window: QWidget,
        controller: FlightController,
        view: FlightView,
        style: DisplayStyle,
        store: SettingsStore,
        limits: UserLimitStore,
        voice: Voice,
    ) -> None:
        super().__init__(window)
        self._window = window
        self._controller = controller
        self._view = view
        self._style = style
        self._store = store
        self._limits = limits
        self._voice = voice
        self._given: Mapping[str, LimitBands] = {}
        self._announced_alarms: frozenset[str] = frozenset()
        self._sounded = 0.0
        self._before_note: tuple[bool, int] | None = None
        self._builder: FlightViewStateBuilder | None = None
        controller.changed.connect(self._give_all_limits)
        controller.refreshed.connect(self._follow_limits)
        view.mark_requested.connect(controller.mark)
        view.marks.jump_requested.connect(self._go_to_mark)
        view.marks.edited.connect(lambda key, text: controller.edit_mark(str(key), text))
        view.marks.deleted.connect(lambda key: controller.delete_mark(str(key)))
        view.marks.edit_ended.connect(self._note_written)
        view.alarms.acknowledged.connect(lambda: controller.acknowledge("crew, Alarms tab"))
        view.alarms.jump_requested.connect(self._go_to_key)
        view.messages.jump_requested.connect(self._go_to_key)
        view.estimates.opened.connect(self._go_to_maneuver_of)
        view.estimates.search.switched.connect(self._remember_search)
        view.plot.set_map(store.current.map_tiles)
        view.plot.map_chosen.connect(lambda path: store.change(map_tiles=path))
        view.replay.moved.connect(self._seek)
        view.replay.speed_chosen.connect(controller.set_speed)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "chart_pause": self.toggle_pause,
            "mark": self._view.charts.navigator.request_mark,
            "note": self.add_note,
            "previous_mark": lambda: self.step_mark(-1),
            "next_mark": lambda: self.step_mark(1),
            "acknowledge": self.acknowledge,
            "mute": self.toggle_mute,
            "slower": lambda: self._controller.set_speed(next_speed(self._controller.speed, -1)),
            "faster": lambda: self._controller.set_speed(next_speed(self._controller.speed, 1)),
            "step_back": lambda: self._controller.step(-1),
            "step": lambda: self._controller.step(1),
            "go_to": self.ask_time,
            "type_range": self.ask_y_range,
            "type_limits": self.ask_limits,
        }

    def view_state(self) -> FlightViewState:
        """Return what the page shows beside the samples."""
        session, snapshot = self._controller.session, self._controller.snapshot
        if session is None or snapshot is None:
            self._builder = None
            return FlightViewState()
        if self._builder is None or self._builder.session is not session:
            self._builder = FlightViewStateBuilder(session)
            self._switch_search(self._store.current.live_search)
        return self._builder.build(snapshot, self._style.units)

    def acknowledge(self) -> None:
        """Acknowledge the alarms, by the key or from the menu."""
        by_key = self._view.is_by_key("acknowledge")
        self._controller.acknowledge("crew, key K" if by_key else "crew, menu")

    def toggle_pause(self) -> None:
        """Hold the display while live; in a replay hold the replay itself."""
        if self._controller.is_replay:
            self._view.charts.navigator.go_live()
            self._controller.toggle_play()
        else:
            self._view.charts.navigator.toggle_pause()

    # Marks

    def add_note(self) -> None:
        """Mark this moment and let the user write a few words; Enter comes back to the charts."""
        before = self._view.panel_shown
        view = self._view.charts.view
        at = view.cursors.get("cursor") if view.paused else None
        key = self._controller.mark(at if at is not None else self._controller.time, kind="note")
        self._view.show_state(self.view_state())
        self._view.show_panel(2)
        self._view.marks.begin_edit(key)
        self._before_note = before

    def _note_written(self) -> None:
        before, self._before_note = self._before_note, None
        if before is not None:
            # After the table has taken the text and the focus.
            QTimer.singleShot(0, self, lambda: self._view.restore_charts(before))

    def step_mark(self, steps: int) -> None:
        """Go to the mark before or after what is in sight."""
        view = self._view.charts.view
        if view.now is None:
            return
        here = self._controller.time if self._controller.is_replay else None
        if here is None:
            here = view.time(view.width / 2) if view.paused else view.now
        times = sorted(self._controller.mark_times())
        past = [at for at in times if at < here - 0.05]
        coming = [at for at in times if at > here + 0.05]
        if steps < 0 and past:
            self.go_to_time(past[-1])
        elif steps > 0 and coming:
            self.go_to_time(coming[0])

    def _go_to_mark(self, key: object) -> None:
        at = self._controller.mark_time(str(key))
        if at is not None:
            self.go_to_time(at)

    def _go_to_key(self, key: object) -> None:
        """Alarms and messages carry their time as the last part of their key."""
        at = key[-1] if isinstance(key, tuple) else None
        if isinstance(at, float):
            self.go_to_time(at)

    def _go_to_maneuver_of(self, derivative: str) -> None:
        rows = {row.key: row.value for row in self._view.estimates.list.row_model.rows}
        if derivative in rows and rows[derivative].points:
            self.go_to_time(rows[derivative].points[-1].time)

    def _remember_search(self, enabled: bool) -> None:
        self._store.change(live_search=enabled)
        self._switch_search(enabled)

    def _switch_search(self, enabled: bool) -> None:
        session = self._controller.session
        if session is not None and session.estimates is not None:
            session.estimates.switch_search(enabled)

    def go_to_time(self, at: float) -> None:
        if self._controller.is_replay:
            self._seek(at)
        else:
            self._view.charts.navigator.go_to(at)

    # Replay

    def _seek(self, at: float) -> None:
        self._view.charts.navigator.go_live()
        self._controller.seek(at)

    def ask_time(self) -> None:
        span = self._controller.replay_span
        if span is None:
            return
        dialog = GoToDialog(self._style, *span, self._controller.time or span[0], self._window)
        if dialog.exec():
            self._seek(dialog.clamped_time)

    # Charts

    def ask_y_range(self) -> None:
        chart = self._view.charts.model.selected_chart
        if chart is None:
            return
        dialog = RangeDialog(
            self._style, chart.specs[0].title, chart.displays[0].unit, chart.low, chart.high,
            self._window,
        )  # fmt: skip
        if dialog.exec():
            self._view.charts.editor.set_range(dialog.range)

    def ask_limits(self) -> None:
        chart, session = self._view.charts.model.selected_chart, self._controller.session
        if chart is None or session is None:
            return
        spec = chart.specs[0]
        dialog = LimitsDialog(
            self._style, spec, session.limits.bands(spec.id),
            typed=session.limits.has_user_limits(spec.id),
            parent=self._window,
        )  # fmt: skip
        if dialog.exec():
            self._limits.write(spec.id, dialog.limits, self._style.units)
            self._give_limits()
            self._controller.refreshed.emit()

    def _give_all_limits(self) -> None:
        """Let what was typed before count in the flight that was opened."""
        self._limits.refresh()
        self._given = {}
        self._give_limits()

    def _follow_limits(self) -> None:
        """Let count what was typed in another window."""
        if self._limits.refresh():
            self._give_limits()

    def _give_limits(self) -> None:
        """Let the flight know what was typed or forgotten since it was told last."""
        session = self._controller.session
        if session is None:
            return
        former, self._given = self._given, self._limits.limits
        for channel_id in {**former, **self._given}:
            bands = self._given.get(channel_id)
            if bands != former.get(channel_id):
                session.set_user_limits(channel_id, bands)

    # Sound

    def toggle_mute(self) -> None:
        """Turn the sound off or on, words and tones alike."""
        muted = not self._store.current.muted
        self._store.change(muted=muted)
        self._voice.set_muted(muted)
        self._controller.refreshed.emit()

    def sound_alarms(self) -> None:
        """Let every new alarm be heard, warnings in words; one that nobody has seen goes on."""
        if self._voice.muted:
            # What still waits when the sound comes back is news then.
            self._announced_alarms = frozenset()
            return
        if self._controller.is_catching_up:
            # They are of an earlier time. Those that still stand are news when it has caught up.
            return
        waiting = self._controller.unacknowledged_alarms()
        keys = {f"{alarm.key}@{alarm.time}": alarm for alarm in waiting}
        new = [alarm for key, alarm in keys.items() if key not in self._announced_alarms]
        self._announced_alarms = frozenset(keys)
        severe = any(alarm.active and alarm.severity is Severity.WARNING for alarm in waiting)
        now = time.monotonic()
        if not new and not (severe and now - self._sounded >= DISPLAY.warning_interval):
            return
        self._sounded = now
        warnings = [alarm for alarm in new if alarm.severity is Severity.WARNING]
        self._voice.play_tone("warning" if severe or warnings else "caution")
        if warnings:
            self._voice.say(spoken_alarm_text(warnings[0]), UtterancePriority.WARNING)


def spoken_alarm_text(alarm: Alarm) -> str:
    """Return an alarm in a few words for the ear: what, which side, what it means; no numbers."""
    if alarm.rule is None:
        return alarm.message
    meaning = alarm.rule.describe(alarm.severity)
    head = f"{channel(alarm.rule.channel).title} {alarm.rule.side}"
    return f"{head}, {meaning}" if meaning else head
