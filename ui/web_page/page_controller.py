"""Switches the page in the window on and off, and gives it its frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from gsapp.session import Session
from ui.error_reporter import ErrorReporter
from ui.strips.strip_layout import Strip
from ui.web_page.settings import WEB_PAGE

if TYPE_CHECKING:
    from ui.web_page.page_publisher import PagePublisher


class WebPageController(QObject):
    """At most one page, whatever flight is open.

    `session`, `strips`, `units`: as `PageFrameBuilder` takes them.
    """

    changed = Signal()  # The page was switched on or off.

    def __init__(
        self,
        session: Callable[[], Session | None],
        strips: Callable[[], Sequence[Strip]],
        units: Callable[[], str],
        error_reporter: ErrorReporter,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._sources = session, strips, units
        self._error_reporter = error_reporter
        self._publisher: PagePublisher | None = None
        self._timer = QTimer(self)
        self._timer.setInterval(round(1000 * WEB_PAGE.check_interval))
        self._timer.timeout.connect(self._publish)

    @property
    def link(self) -> str:
        """Return where the page is served, ``http:HOST:PORT``; empty while it is off."""
        return "" if self._publisher is None else self._publisher.server.link

    @property
    def url(self) -> str:
        """Return what to type into a browser, with the key; empty while it is off."""
        return "" if self._publisher is None else self._publisher.server.url

    @property
    def client_count(self) -> int:
        return 0 if self._publisher is None else self._publisher.server.client_count

    def start(self, link: str, *, is_open: bool) -> None:
        """Serve the page; raise LinkError where it cannot be served there."""
        from ui.web_page.page_frame import PageFrameBuilder
        from ui.web_page.page_publisher import PagePublisher
        from ui.web_page.page_server import PageServer

        self.stop()
        server = PageServer(link, is_open=is_open)
        self._publisher = PagePublisher(server, PageFrameBuilder(*self._sources))
        self._timer.start()
        self.changed.emit()

    def stop(self) -> None:
        publisher, self._publisher = self._publisher, None
        self._timer.stop()
        if publisher is not None:
            publisher.server.close()
            self.changed.emit()

    def _publish(self) -> None:
        try:
            if self._publisher is not None:
                self._publisher.publish_due()
        except Exception as error:  # once, and not at every frame
            self.stop()
            self._error_reporter.report(error)
