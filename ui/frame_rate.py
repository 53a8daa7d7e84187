"""When to look for samples, and when to paint them. No Qt.

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

from collections import deque

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

    Parameters
    ----------
    soonest : float
        Seconds from frame to frame, at least, as a mean. A frame that was late does not put off
        the next one.
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
