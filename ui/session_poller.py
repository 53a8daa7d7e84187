"""Takes samples into the open session on a precise timer, and says when to paint.

From the arrival of a sample to its pixels there are 20 ms (95 of 100 samples). At 100 Hz they
go, in the order of the road:

    0 to 2 ms     the recorder frames, writes and hands to the operating system
    0 to 2 ms     until the next look at the sizes of the files: `POLL_INTERVAL_MS`
    2 to 3 ms     decoding, calibration, history, alarms, painting, flushing
    10 ms         only where a source stamps beside the grid of the charts: the next row of the
                  grid lies between two samples, and the later one is still to come

What is left, some 3 to 5 ms, is for a busy machine. It does not suffice for waiting for the next
sixtieth of a second, which takes up to 17 ms: so a frame begins with the samples.
`MIN_LIVE_FRAME_SECONDS` lets the 100 Hz of the charts' grid through and no more; faster streams
share frames. Screens that refresh 60 times a second take the newest frame each time. A machine on
which frames are dear gets fewer of them (`FrameRateLimiter`), so that keys and mouse always find
their turn.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from gsapp.session import UNLIMITED_SPEED, Session
from ui.display_limits import DISPLAY
from ui.error_reporter import ErrorReporter

POLL_INTERVAL_MS = 2
"""Between looks whether the record has grown: three sizes of files, nothing is read."""

MIN_LIVE_FRAME_SECONDS = 0.009
"""Seconds from frame to frame at least, while samples decide when they come."""

MIN_REPLAY_FRAME_SECONDS = 0.0165
"""Seconds from frame to frame at least, where only the screen decides."""

_REST_FACTOR = 1.5  # times the duration of a frame, left to everything else
_DURATION_WINDOW = 4


class FrameRateLimiter:
    """Lets a frame begin as soon as there is something to show, but not too many of them.

    `soonest`: seconds from frame to frame, at least, as a mean. A frame that was late does not put
    off the next one.
    """

    def __init__(self, soonest: float) -> None:
        self._earliest = soonest
        self._next = 0.0
        self._taken: deque[float] = deque(maxlen=_DURATION_WINDOW)

    def may_begin_frame(self, now: float) -> bool:
        """Return whether a frame may begin at a time (s) of a clock that never goes back."""
        return now >= self._next

    def seconds_to_next(self, now: float) -> float:
        return max(self._next - now, 0.0)

    def record_frame(self, begin: float, end: float) -> None:
        """Take note of a frame, from its beginning to its end, s."""
        # The least of a few: a frame that waited for the processor is not dear by itself.
        self._taken.append(end - begin)
        self._next = max(
            self._next + self._earliest,
            begin + 0.5 * self._earliest,
            end + _REST_FACTOR * min(self._taken),
        )


_UPDATE_SECONDS = 0.006
_BACKGROUND_UPDATE_SECONDS = 0.02
_CATCH_UP_UPDATE_SECONDS = 0.04
"""Seconds of a tick for new samples; more while alarms and cues are behind the charts, and most
while what was recorded before is read, or while nothing moves."""
_REFRESH_SECONDS = 0.1
_IDLE_PAINT_SECONDS = 0.25
_RETRY_MS = 1000  # After an error until the next try: two milliseconds later it would be the same.


class SessionPoller(QObject):
    """Updates one session, as fast as its samples and the screen allow.

    `refresh`: called with the session ten times a second.
    """

    # Samples came: paint a frame; carries the flight time to paint up to, s or None.
    frame_requested = Signal(object)

    def __init__(
        self, refresh: Callable[[Session], None], error_reporter: ErrorReporter, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._refresh = refresh
        self._error_reporter = error_reporter
        self._session: Session | None = None
        self._pace = FrameRateLimiter(MIN_LIVE_FRAME_SECONDS)
        self._refreshed_at = self._painted_at = self._moved_at = 0.0
        self._painted: tuple[float | None, int] | None = None
        self._fault = ""
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(POLL_INTERVAL_MS)
        self._timer.timeout.connect(self.tick)

    def set_session(self, session: Session | None) -> None:
        """Update a session once, or none any more; `start` goes on with it."""
        self._timer.stop()
        self._session = session
        if session is None:
            return
        live = session.replay_feed is None
        self._pace = FrameRateLimiter(MIN_LIVE_FRAME_SECONDS if live else MIN_REPLAY_FRAME_SECONDS)
        self._painted, self._fault = None, ""
        self._moved_at = time.monotonic()
        session.update(_UPDATE_SECONDS)

    def start(self) -> None:
        self._timer.start()

    def tick(self) -> None:
        """Take in new samples, paint if there are any, refresh ten times a second.

        An error is reported once, and the tick tried again after a while.
        """
        if self._session is None:
            return
        try:
            self._update(self._session)
        except Exception as error:
            self._timer.setInterval(_RETRY_MS)
            if repr(error) != self._fault:
                self._fault = repr(error)
                self._error_reporter.report(error)

    def _update(self, session: Session) -> None:
        now = time.monotonic()
        refreshes = now - self._refreshed_at >= _REFRESH_SECONDS
        if self._timer.interval() != POLL_INTERVAL_MS:
            self._timer.setInterval(POLL_INTERVAL_MS)
        paints = self._pace.may_begin_frame(now)
        hurries = _takes_all_at_once(session)
        if not (
            refreshes or hurries or (paints and (session.has_new_data or self._is_behind(session)))
        ):
            return
        session.update(_update_seconds(session))
        if paints and self._is_behind(session):
            self._painted = (session.now, session.history.revision)
            self._moved_at = self._painted_at = now
            self.frame_requested.emit(session.now)
        elif now - self._painted_at >= _IDLE_PAINT_SECONDS:
            self._painted_at = now
            self.frame_requested.emit(self._idle_time(session, now))
        if paints and (self._painted_at == now or session.replay_feed is not None):
            # A replay always has news; they come with the frames, not with the ticks.
            end = time.monotonic()
            self._pace.record_frame(now, end)
            if not hurries:
                # No tick before can lead to a frame.
                self._timer.setInterval(
                    max(int(1000 * self._pace.seconds_to_next(end)), POLL_INTERVAL_MS)
                )
        if refreshes:
            self._refreshed_at = now
            self._refresh(session)
        self._fault = ""

    def _is_behind(self, session: Session) -> bool:
        return (session.now, session.history.revision) != self._painted

    def _idle_time(self, session: Session, now: float) -> float | None:
        """Return the flight time to paint up to while no sample comes.

        It goes on, so that values grow stale and the gap is seen.
        """
        silent = now - self._moved_at
        # While what was recorded is still being read nothing is missing yet.
        live = (
            session.replay_feed is None
            and session.recorder is not None
            and session.feed.is_up_to_date
        )
        if session.now is None or not live or silent <= DISPLAY.data_timeout:
            return session.now
        return session.now + silent


def _takes_all_at_once(session: Session) -> bool:
    replay = session.replay_feed
    if replay is None:
        return not session.feed.caught_up
    if replay.playing:
        return not replay.complete or replay.speed == UNLIMITED_SPEED
    # Nothing moves: after a jump all monitors are waited for.
    return not (replay.complete and replay.caught_up)


def _update_seconds(session: Session) -> float:
    """Return the seconds of a tick for taking in new samples."""
    feed, replay = session.feed, session.replay_feed
    if feed.caught_up:
        return _UPDATE_SECONDS
    if replay is None:
        return _BACKGROUND_UPDATE_SECONDS if feed.is_up_to_date else _CATCH_UP_UPDATE_SECONDS
    # A replay that jumped reads all before the playhead again; one that plays goes on.
    return _BACKGROUND_UPDATE_SECONDS if replay.playing else _CATCH_UP_UPDATE_SECONDS
