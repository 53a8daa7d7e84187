"""Gives a page its frames, at its own rate, while browsers show it."""

from __future__ import annotations

import math
import time

from ui.web_page.page_frame import PageFrameBuilder
from ui.web_page.page_server import PageServer
from ui.web_page.settings import WEB_PAGE


class PagePublisher:
    """Publishes what a builder makes; called in the thread of the session."""

    def __init__(self, server: PageServer, builder: PageFrameBuilder) -> None:
        self.server = server
        self._builder = builder
        self._next = -math.inf

    def publish_due(self) -> None:
        """Publish a frame where one is due and somebody looks; else it costs nothing."""
        now = time.monotonic()
        if now >= self._next and self.server.client_count:
            self._next = now + WEB_PAGE.interval
            self.server.publish(self._builder.build())
