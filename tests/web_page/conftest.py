"""Pages with frames made by hand, and what the tests ask of them."""

import http.client
import json
import socket
import threading
import time
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from tests.telemetry.conftest import free_port
from tests.ui import pilot_kit
from ui.pilot.cue_display import CueDisplay
from ui.web_page.page_frame import PageFrame
from ui.web_page.page_server import PageServer


def make_frame(end: int = 100, *, text: str = "", **content: Any) -> PageFrame:
    """Return a frame with one strip that shows 100 columns up to an index."""
    low = np.arange(end - 100, end, dtype=float)
    line = {"title": text or "q Pitch rate", "color": "#0147c5", "dark": "#74b6ff",
            "dashed": False, "value": text or str(end), "stale": False, "state": "",
            "note": text}  # fmt: skip
    strip = {"unit": text or "°/s", "low": -1.0, "high": end + 1.0,
             "ticks": [[0.0, text or "0"], [end, "1"]], "lines": [line]}  # fmt: skip
    display = CueDisplay(status_text=text) if text else pilot_kit.display(pilot_kit.STATES["go"])
    return PageFrame(
        content={
            "cue": asdict(display), "last": None, "flight": text or "first", "time": "01:00.0",
            "mode": "LIVE", "strips": [strip], "column": 0.1, "window": 10.0, **content,
        },
        record=1, first_column=end - 100, lines=((low, low + 1.0, 1),),
    )  # fmt: skip


class Page:
    """A page that is served, and a thread that gives it frames as a flight does."""

    def __init__(self, host: str = "127.0.0.1", *, is_open: bool = False) -> None:
        self.port = free_port(socket.SOCK_STREAM)
        self.server = PageServer(f"http:{host}:{self.port}", is_open=is_open)
        self.make = make_frame
        self.published = 0
        self.slowest = 0.0  # s that `publish` took
        self._over = threading.Event()
        self.resume()

    def resume(self) -> None:
        self._over.clear()
        self._thread = threading.Thread(target=self._fly)
        self._thread.start()

    def _fly(self) -> None:
        while not self._over.wait(0.02):
            frame = self.make(100 + self.published)
            begin = time.perf_counter()
            self.server.publish(frame)
            self.slowest = max(self.slowest, time.perf_counter() - begin)
            self.published += 1

    def pause(self) -> None:
        self._over.set()
        self._thread.join()

    def close(self) -> None:
        self.pause()
        self.server.close()

    @property
    def key(self) -> str:
        return self.server.url.partition("#")[2]

    def ask(
        self, path: str = "/", method: str = "GET", body: str | None = None, **headers: str
    ) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20.0)
        connection.request(method, path, body, headers)
        return connection.getresponse()

    def frames(self, count: int, **headers: str) -> list[dict[str, Any]]:
        with self.ask("/frames", **headers) as answer:
            assert answer.status == 200
            return [json.loads(answer.readline()) for _ in range(count)]


@pytest.fixture
def page() -> Iterator[Page]:
    made = Page()
    yield made
    made.close()
