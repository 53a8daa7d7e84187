"""The line of messages below the page: the newest is in sight, all of them are in a list."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Literal

from PySide6.QtCore import QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QBrush, QMouseEvent, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QStackedLayout,
    QWidget,
)

from gsapp.quantities import convert_text_units
from ui.display_style import DisplayStyle
from ui.icons import IndicatorState, paint_indicator
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import UnitConvertingLabel, create_label, plain_tooltip

MessageLevel = Literal["note", "caution", "warning", "work"]
BannerAction = tuple[str, Callable[[], object]]
_STATES: dict[MessageLevel, IndicatorState] = {
    "note": "plain",
    "caution": "caution",
    "warning": "warning",
    "work": "plain",
}
_MAX_OPEN = 3  # open at a time; older ones stand in the list
_HEIGHT, _FLAT_HEIGHT = 34, 26
"""Points of height, reserved whether there is a message or not: nothing moves or is covered."""
_LOW_WINDOW_HEIGHT = 440  # Points of height of a window below which the line is flat.
_MAX_MESSAGES = 200  # Messages in the list.
LEVEL_TITLES: dict[MessageLevel, str] = {
    "note": QT_TR_NOOP("Note"),
    "caution": QT_TR_NOOP("Caution"),
    "warning": QT_TR_NOOP("Failed"),
    "work": "",
}


@dataclass(slots=True, kw_only=True, eq=False)
class BannerMessage:
    """A message of this session, for the list."""

    time: datetime  # When it came, local time.
    level: MessageLevel  # As of its banner.
    text: str
    actions: tuple[BannerAction, ...]  # What it offers; empty once that is out of date.


class _LevelIcon(QWidget):
    def __init__(self, level: MessageLevel, style: DisplayStyle) -> None:
        super().__init__()
        self._level = level
        self._style = style
        self.setFixedSize(style.px(16), style.px(16))

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        color = self._style.state_color(_STATES[self._level])
        paint_indicator(
            painter, _STATES[self._level], QRectF(self.rect()).adjusted(2, 2, -2, -2), color
        )
        painter.end()


class _ElidedLabel(UnitConvertingLabel):
    """A sentence in one line, cut with an ellipsis; the tool tip has it whole."""

    pressed = Signal()

    def __init__(self, style: DisplayStyle, text: str) -> None:
        super().__init__(style, text)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    @property
    def is_cut(self) -> bool:
        return self.fontMetrics().horizontalAdvance(self._line) > self.width()

    @property
    def _line(self) -> str:
        return " ".join(self.text().split())

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.setToolTip(plain_tooltip(self.text() if self.is_cut else ""))

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        elide = Qt.TextElideMode.ElideRight
        text = self.fontMetrics().elidedText(self._line, elide, self.width())
        self.style().drawItemText(
            painter, self.rect(), Qt.AlignmentFlag.AlignVCenter, self.palette(), True, text,
            self.foregroundRole(),
        )  # fmt: skip
        painter.end()

    def mousePressEvent(self, _event: QMouseEvent) -> None:
        if self.is_cut:
            self.pressed.emit()


def _button(
    row: QHBoxLayout, text: str, act: Callable[[], object], *, quiet: bool = False
) -> QPushButton:
    button = QPushButton(text)
    button.setAccessibleName(text)
    if quiet:
        button.setProperty("role", "quiet")
    # As high as the line.
    button.setSizePolicy(QSizePolicy.Policy.Minimum, QSizePolicy.Policy.Expanding)
    button.clicked.connect(lambda _checked=False: act())
    row.addWidget(button)
    return button


class JobProgressBar(QProgressBar):
    """How much of a job is done, hatched while that is unknown; nothing in it moves."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.setRange(0, 0)
        self.setTextVisible(False)

    def set_share(self, share: float | None) -> None:
        self.setRange(0, 0 if share is None else 1000)
        self.setValue(round(1000 * (share or 0.0)))

    def paintEvent(self, event: QPaintEvent) -> None:
        if self.maximum() > self.minimum():
            super().paintEvent(event)
            return
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._style.color("chosen"))
        painter.fillRect(self.rect(), QBrush(self._style.color("text"), Qt.BrushStyle.BDiagPattern))
        painter.end()


class Banner(QFrame):
    """One sentence with up to a few buttons.

    `choices`: buttons; each closes the banner after its work, unless it is of level ``work``.
    """

    closed = Signal()  # The banner was closed.
    details_requested = Signal()  # A sentence too long for the line was pressed.

    def __init__(
        self,
        level: MessageLevel,
        text: str,
        style: DisplayStyle,
        choices: tuple[BannerAction, ...] = (),
    ) -> None:
        super().__init__()
        self.level = level
        self.setObjectName("banner")
        self.setProperty("level", level)
        row = arrange(QHBoxLayout(self), style.px(8), style.px(8), 0, 0, 0)
        if _STATES[level] != "plain":
            row.addWidget(_LevelIcon(level, style))
        if LEVEL_TITLES[level]:
            word = create_label(tr(LEVEL_TITLES[level]))
            word.setProperty("role", "strong")
            row.addWidget(word)
        self.label = _ElidedLabel(style, text)
        self.label.pressed.connect(self.details_requested)
        style.changed.connect(self._name)
        self._name()
        row.addWidget(self.label, 1)
        self.progress_bar: JobProgressBar | None = None
        if level == "work":
            self.progress_bar = JobProgressBar(style)
            self.progress_bar.setFixedSize(QSize(style.px(160), style.px(8)))
            self.progress_bar.setAccessibleName(tr("Progress"))
            row.addWidget(self.progress_bar)
        self.buttons: list[QPushButton] = []
        for words, act in choices:
            button = _button(row, words, partial(self._choose, act))
            self.buttons.append(button)
        if level != "work":
            close = _button(row, tr("Close"), self.close_banner, quiet=True)
            close.setAccessibleName(tr("Close this message"))

    def _choose(self, act: Callable[[], object]) -> None:
        if self.level != "work":
            self.close_banner()
        act()

    def _name(self) -> None:
        """Let the sentence be heard as it is read."""
        text, word = self.label.text(), tr(LEVEL_TITLES[self.level])
        self.setAccessibleName(f"{word}: {text}" if word else text)

    def set_text(self, text: str) -> None:
        self.label.setText(text)
        self._name()

    def set_progress(self, share: float | None) -> None:
        """Show how much of a work is done; None = unknown."""
        if self.progress_bar is not None:
            self.progress_bar.set_share(share)

    def close_banner(self) -> None:
        self.closed.emit()


class BannerStack(QWidget):
    """The messages that are open, the newest in sight; equal sentences are shown once.

    They have a line of their own below the page, so that nothing moves under the pointer and
    nothing is covered. What was closed stays in the list.
    """

    changed = Signal()  # A message came, or was closed.
    list_requested = Signal()  # The list is wanted.

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.note_timeout_ms = 10_000  # Milliseconds after which a note that offers nothing closes.
        self.banners: list[Banner] = []
        self.messages: list[BannerMessage] = []  # All of this session, newest first.
        self._shown: dict[Banner, BannerMessage] = {}
        self._front: Banner | None = None
        self._is_flat = False
        self.setObjectName("messages")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName(tr("Messages"))
        self._row = QHBoxLayout(self)
        self._pile = QStackedLayout()
        self._pile.addWidget(QWidget())
        self._row.addLayout(self._pile, 1)
        self.next_button = _button(self._row, "", self._show_next, quiet=True)
        self.list_button = _button(self._row, tr("Messages"), self.list_requested.emit, quiet=True)
        style.changed.connect(self._restyle)
        self._restyle()
        self._refresh()

    def _restyle(self) -> None:
        px = self._style.px
        self._row.setContentsMargins(px(8), px(1), px(4), px(1))
        self._row.setSpacing(px(4))
        self.setFixedHeight(px(_FLAT_HEIGHT if self._is_flat else _HEIGHT))

    def fit(self, window_height: int) -> None:
        """Take less height where the window is low for its scale."""
        is_flat = window_height < self._style.px(_LOW_WINDOW_HEIGHT)
        if is_flat != self._is_flat:
            self._is_flat = is_flat
            self._restyle()

    def _refresh(self) -> None:
        """Put the message in front on screen, and say how many wait behind it."""
        if self._front not in self.banners:
            self._front = self.banners[0] if self.banners else None
        count = len(self.banners)
        if self._front is None:
            self._pile.setCurrentIndex(0)
        else:
            self._pile.setCurrentWidget(self._front)
            self.next_button.setText(
                tr("{index} of {count}").format(
                    index=self.banners.index(self._front) + 1, count=count
                )
            )
        self.next_button.setVisible(count > 1)
        self.next_button.setAccessibleName(tr("Next of {count} messages").format(count=count))
        self.next_button.setToolTip(tr("Next message"))
        self.list_button.setEnabled(bool(self.messages))
        self.list_button.setToolTip(
            tr("All messages since the start") if self.messages else tr("No message yet")
        )
        self.changed.emit()

    def _show_next(self) -> None:
        if self._front is not None:
            index = self.banners.index(self._front) + 1
            self._front = self.banners[index % len(self.banners)]
            self._refresh()

    def show_banner(self, level: MessageLevel, text: str, *choices: BannerAction) -> Banner:
        """Show a sentence and return its banner."""
        for banner in list(self.banners):
            shown = convert_text_units(text, self._style.units)
            if banner.label.text() == shown and banner.level == level:
                self.remove(banner)
        banner = Banner(level, text, self._style, choices)
        banner.closed.connect(lambda: self._close(banner))
        banner.details_requested.connect(self.list_requested)
        if level == "note" and not choices:
            # Nothing hangs on it.
            QTimer.singleShot(self.note_timeout_ms, banner, banner.close_banner)
        if level != "work":
            message = BannerMessage(
                time=datetime.now().astimezone(), level=level, text=text, actions=choices
            )
            self._shown[banner] = message
            self.messages[:] = [message, *self.messages][:_MAX_MESSAGES]
        self.banners.insert(0, banner)
        self._pile.addWidget(banner)
        self._front = banner
        for old in [known for known in self.banners if known.level != "work"][_MAX_OPEN:]:
            self._close(old)
        self._refresh()
        return banner

    def show_again(self, message: BannerMessage) -> None:
        """Show a message of the list again, with what it offers."""
        self.messages.remove(message)
        self.show_banner(message.level, message.text, *message.actions)

    def remove(self, banner: Banner) -> None:
        """Withdraw a banner whose matter has ended, with what it offers."""
        if banner in self._shown:
            self._shown[banner].actions = ()
        self._close(banner)

    def _close(self, banner: Banner) -> None:
        """Close a banner; one already gone is let be."""
        if banner in self.banners:
            self.banners.remove(banner)
            self._shown.pop(banner, None)
            self._pile.removeWidget(banner)
            banner.hide()
            banner.deleteLater()
            self._refresh()

    def dismiss(self) -> None:
        """Close the message in sight, or else the newest that is not a running work."""
        ended = [banner for banner in self.banners if banner.level != "work"]
        if ended:
            self._close(self._front if self._front in ended else ended[0])

    def texts(self) -> tuple[str, ...]:
        """Return the sentences of the open messages, newest first."""
        return tuple(banner.label.text() for banner in self.banners)
