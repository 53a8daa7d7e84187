"""Banners: sentences across the top of the window that stay until they are closed or done."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from PySide6.QtCore import QEvent, QObject, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gsapp.quantities import in_units
from ui.glyphs import State, paint_state
from ui.look import Look
from ui.pages import label

Level = Literal["note", "caution", "warning", "work"]
_STATES: dict[Level, State] = {
    "note": "plain",
    "caution": "caution",
    "warning": "warning",
    "work": "plain",
}
_MOST = 3  # at a time; older ones stand in the log
_WIDTH, _SIDE, _ABOVE = 720, 16, 72
"""Points: of a banner at most, free beside it, and free below it for the buttons of the page."""
_WORDS: dict[Level, str] = {"note": "Note", "caution": "Caution", "warning": "Failed", "work": ""}


class _Sign(QWidget):
    def __init__(self, level: Level, look: Look) -> None:
        super().__init__()
        self._level = level
        self._look = look
        self.setFixedSize(look.px(16), look.px(16))

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        color = self._look.state_color(_STATES[self._level])
        paint_state(
            painter, _STATES[self._level], QRectF(self.rect()).adjusted(2, 2, -2, -2), color
        )
        painter.end()


class Banner(QFrame):
    """One sentence with up to a few buttons.

    Parameters
    ----------
    level : {"note", "caution", "warning", "work"}
        What it is about.
    text : str
        The sentence.
    look : Look
        Colors and sizes.
    choices : sequence of (str, callable)
        Buttons; each closes the banner after its work, unless it is of level ``work``.

    Attributes
    ----------
    closed : Signal
        The banner was closed.
    """

    closed = Signal()

    def __init__(
        self,
        level: Level,
        text: str,
        look: Look,
        choices: tuple[tuple[str, Callable[[], object]], ...] = (),
    ) -> None:
        super().__init__()
        self.level = level
        self.setObjectName("banner")
        self.setProperty("level", level)
        row = QHBoxLayout(self)
        row.setContentsMargins(look.px(16), look.px(4), look.px(8), look.px(4))
        row.setSpacing(look.px(8))
        if _STATES[level] != "plain":
            row.addWidget(_Sign(level, look))
        if _WORDS[level]:
            word = QLabel(_WORDS[level])
            word.setProperty("role", "strong")
            row.addWidget(word)
        self.label = label(text, wrap=True, remarks_in=look)
        look.changed.connect(self._name)
        self._name()
        self.label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        row.addWidget(self.label, 1)
        self.meter: QProgressBar | None = None
        if level == "work":
            self.meter = QProgressBar()
            self.meter.setRange(0, 0)
            self.meter.setTextVisible(False)
            self.meter.setFixedSize(QSize(look.px(160), look.px(8)))
            self.meter.setAccessibleName("Progress")
            row.addWidget(self.meter)
        self.buttons: list[QPushButton] = []
        for words, act in choices:
            button = QPushButton(words)
            button.setAccessibleName(words)
            button.clicked.connect(lambda _checked=False, run=act: self._choose(run))
            row.addWidget(button)
            self.buttons.append(button)
        if level != "work":
            close = QPushButton("Close")
            close.setProperty("role", "quiet")
            close.setAccessibleName("Close this banner")
            close.clicked.connect(self.close_banner)
            row.addWidget(close)

    def _choose(self, act: Callable[[], object]) -> None:
        if self.level != "work":
            self.close_banner()
        act()

    def _name(self) -> None:
        """Let the sentence be heard as it is read."""
        text, word = self.label.text(), _WORDS[self.level]
        self.setAccessibleName(f"{word}: {text}" if word else text)

    def say(self, text: str) -> None:
        """Change the sentence."""
        self.label.setText(text)
        self._name()

    def show_share(self, share: float | None) -> None:
        """Show how much of a work is done; None = unknown."""
        if self.meter is None:
            return
        if share is None:
            self.meter.setRange(0, 0)
        else:
            self.meter.setRange(0, 1000)
            self.meter.setValue(round(1000 * share))

    def close_banner(self) -> None:
        """Remove the banner."""
        self.closed.emit()


class BannerStack(QWidget):
    """The banners on screen, newest on top; equal sentences are shown once.

    They float over the lower left of the page, so that nothing moves under the pointer, and clear
    of the buttons along its lower edge.

    Parameters
    ----------
    look : Look
        Colors and sizes.

    Attributes
    ----------
    passing_ms : int
        Milliseconds after which a note that offers nothing goes by itself.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self.passing_ms = 20_000
        self.banners: list[Banner] = []
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(1)
        self._page: QWidget | None = None
        self.hide()

    def float_over(self, page: QWidget) -> None:
        """Stand over a page from now on, wherever it moves."""
        self._page = page
        self.setParent(page.parentWidget())
        page.installEventFilter(self)
        self._look.changed.connect(self._place)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the page."""
        if watched is self._page and event.type() in (QEvent.Type.Resize, QEvent.Type.Move):
            self._place()
        return False

    def event(self, event: QEvent) -> bool:
        """Take the height that the words need."""
        if event.type() == QEvent.Type.LayoutRequest:
            self._place()
        return bool(super().event(event))

    def _place(self) -> None:
        page, look = self._page, self._look
        if page is None or not self.banners:
            return
        width = min(page.width() - 2 * look.px(_SIDE), look.px(_WIDTH))
        height = max(self._column.totalHeightForWidth(width), self._column.minimumSize().height())
        bottom = page.y() + page.height() - look.px(_ABOVE)
        top = max(bottom - height, page.y())
        self.setGeometry(page.x() + look.px(_SIDE), top, width, height)
        self.raise_()

    def show_banner(
        self,
        level: Level,
        text: str,
        *choices: tuple[str, Callable[[], object]],
    ) -> Banner:
        """Show a sentence and return its banner."""
        for banner in list(self.banners):
            shown = in_units(text, self._look.units)
            if banner.label.text() == shown and banner.level == level:
                self.remove(banner)
        banner = Banner(level, text, self._look, choices)
        banner.closed.connect(lambda: self.remove(banner))
        if level == "note" and not choices:
            # Nothing hangs on it, and the charts want their room back.
            QTimer.singleShot(self.passing_ms, banner, lambda: self.remove(banner))
        self.banners.insert(0, banner)
        self._column.insertWidget(0, banner)
        passing = [known for known in self.banners if known.level != "work"]
        for old in passing[_MOST:]:
            self.remove(old)
        self._place()
        self.show()
        return banner

    def remove(self, banner: Banner) -> None:
        """Take a banner away; one already gone is let be."""
        if banner in self.banners:
            self.banners.remove(banner)
            self._column.removeWidget(banner)
            banner.hide()
            banner.deleteLater()
        if not self.banners:
            self.hide()

    def dismiss(self) -> None:
        """Close the newest banner that is not a running work."""
        for banner in self.banners:
            if banner.level != "work":
                self.remove(banner)
                return

    def texts(self) -> tuple[str, ...]:
        """Return the sentences on screen, newest first."""
        return tuple(banner.label.text() for banner in self.banners)
