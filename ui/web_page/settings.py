"""Settings of the page in a browser."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class WebPageSettings:
    """Engineering choices; times in s."""

    interval: float = 0.125  # Between two frames.
    check_interval: float = 0.03  # Between looks of the window whether one is due.
    window: float = 60.0  # In sight.
    column_time: float = 0.1  # Of one column of a strip.
    overlap: int = 20  # Columns sent again: channels arrive at different times.
    max_strips: int = 6
    max_ticks: int = 4
    # Pixels of a strip's height, free at either end, and between two labels.
    tick_geometry: tuple[float, float, float] = (96.0, 4.0, 20.0)
    max_connections: int = 32  # Of all browsers; each needs a few while the page loads.
    max_request_bytes: int = 8192
    send_timeout: float = 5.0  # In which a browser takes a frame.
    idle_timeout: float = 30.0  # Of a connection that asks for nothing.
    refusal_delay: float = 1.0  # Before a wrong key is answered: slows down a search for it.
    key_length: int = 10  # Letters of the key in the address: 50 bits.
    closing_time: float = 2.0  # To hang up at the end.


WEB_PAGE: Final = WebPageSettings()
