"""A calibration that runs: volts of the open flight in, prompts and views out."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np
from PySide6.QtCore import QObject, Signal

from calibration.wizard import CalibrationWizard, WizardAction, WizardView
from gsapp.foundation import GroundStationError
from gsapp.quantities import INSTRUMENTS, Block
from ui.display_limits import DISPLAY
from ui.error_reporter import ErrorReporter
from ui.flight_controller import FlightController


class Prompter(Protocol):
    """Says short sentences and gives tones; mute is its own affair."""

    def say(self, text: str) -> None:
        """Say words; what waits to be said and is out of date by now is dropped."""

    def play_tone(self, name: str) -> None:
        """Give a tone: ``steady``, ``taken``, ``moved``, ``error``."""


class SilentPrompter:
    """Says nothing."""

    def say(self, text: str) -> None:
        """Say nothing."""

    def play_tone(self, name: str) -> None:
        """Give no tone."""


_VOLTAGE_CHANNELS = tuple(f"{name}_volts" for name in INSTRUMENTS)
_MAX_NAMED_CHANNELS = 15
"""Samples that stand for these seconds: one for each look at the volts."""


class WizardController(QObject):
    """Feeds a wizard from the open flight, ten times a second, while its page is on screen."""

    view_changed = Signal(object)  # WizardView
    certificates_changed = Signal()

    def __init__(
        self,
        wizard: CalibrationWizard,
        controller: FlightController,
        prompter: Prompter,
        error_reporter: ErrorReporter,
    ) -> None:
        super().__init__()
        self._wizard = wizard
        self._controller = controller
        self._prompter = prompter
        self._error_reporter = error_reporter
        self._next: int | None = None
        self._is_active = False
        self._reported_error = ""
        self._last_data_time = time.monotonic()
        self._fed_until: float | None = None  # flight time, s; None once told of silence
        self.view: WizardView = wizard.view
        controller.refreshed.connect(self._feed_if_active)
        controller.changed.connect(self._restart)

    def set_active(self, on: bool) -> None:
        """Look at the volts from now on, or no longer: sticks are moved for other reasons too."""
        if on != self._is_active:
            self._is_active = on
            self._restart()

    def close(self) -> None:
        """Look no longer; everything is in the journal."""
        self._controller.refreshed.disconnect(self._feed_if_active)
        self._controller.changed.disconnect(self._restart)

    def perform(self, action: WizardAction) -> None:
        """Do what the crew asks."""
        self._guarded(lambda: self._act(action))

    def _act(self, action: WizardAction) -> None:
        self._feed_missing_data()
        self._wizard.act(action)

    def _restart(self) -> None:
        self._next = None

    def _feed_if_active(self) -> None:
        if self._is_active:
            self._guarded(self._feed)

    def _feed_missing_data(self) -> None:
        """Let the wizard know that no volts come, lest it take those that came last."""
        if self._fed_until is None or not self.has_no_data:
            return
        times = (
            self._fed_until + np.linspace(0.0, DISPLAY.no_volts_time, _MAX_NAMED_CHANNELS + 1)[1:]
        )
        self._fed_until = None
        missing = np.full((_MAX_NAMED_CHANNELS, 1), np.nan)
        self._wizard.feed(Block(channels=_VOLTAGE_CHANNELS[:1], times=times, values=missing))

    def _guarded(self, work: Callable[[], object]) -> None:
        """Do something, show what came of it; a disk that refuses is said once, and not fatal."""
        try:
            work()
        except GroundStationError as error:
            if str(error) != self._reported_error:
                self._reported_error = str(error)
                self._error_reporter.report(error)
        else:
            self._reported_error = ""
        self._show(self._wizard.view)

    def _feed(self) -> None:
        session = self._controller.session
        if session is None or session.replay_feed is not None:
            # Volts of another day say nothing about the instruments as they are now.
            return
        if self._next is None and not session.feed.is_up_to_date:
            # What was recorded before is no movement of now.
            return
        history = session.history
        names = [name for name in (*_VOLTAGE_CHANNELS, "excitation") if history.has(name)]
        spans = [span for name in names if (span := history.span(name)) is not None]
        end = history.end
        if not spans or end is None:
            return
        last = min(max(stop for _, stop in spans), history.index(end) + 1)
        # Slow channels hold the others up for a while, silent ones do not.
        stop = min(
            min(stop, last)
            for _, stop in spans
            if stop > last - DISPLAY.max_channel_delay * history.rate
        )
        first = self._next
        if first is None or first > stop:
            self._next = stop
            self._last_data_time = time.monotonic()
            return
        if stop > first:
            self._next = stop
            self._last_data_time = time.monotonic()
            rows = history.rows(first, stop, names)
            self._fed_until = float(rows.times[-1])
            self._wizard.feed(rows)

    @property
    def has_no_data(self) -> bool:
        """Return whether no volts have come for a while: what they were is not what they are."""
        return time.monotonic() - self._last_data_time > DISPLAY.no_volts_time

    @property
    def catching_up(self) -> bool:
        """Return whether none come because the flight is still being read, as after a change."""
        session = self._controller.session
        return session is not None and not session.feed.is_up_to_date

    def _show(self, view: WizardView) -> None:
        if self.has_no_data:
            view = replace(view, reading=None, current_value=None, amount=None)
        before, self.view = self.view, view
        if view.event_count != before.event_count and view.tone:
            self._prompter.play_tone(view.tone)
        if view.spoken != before.spoken and view.spoken:
            self._prompter.say(view.spoken)
        self.view_changed.emit(view)
        if (view.accepted, dict(view.skipped)) != (before.accepted, dict(before.skipped)):
            self.certificates_changed.emit()
