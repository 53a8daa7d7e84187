"""The bar on top, painted: each part is a word, a number, and the sign of its state."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QBrush,
    QFont,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
)
from PySide6.QtWidgets import QAbstractButton, QApplication, QSizePolicy, QToolTip, QWidget

from ui.display_style import DisplayStyle
from ui.icons import paint_indicator
from ui.shortcut_filter import ArrowKeyNavigation
from ui.translation import tr
from ui.widgets.flow_layout import FlowLayout
from ui.widgets.labels import plain_tooltip
from ui.widgets.paint_primitives import paint_focus_frame
from ui.window_frame.status_bar_model import StatusItem

_LOW_WINDOW_HEIGHT = 440  # Points of height below which the bar is flat.

_FLAT_STEP = 24
"""Points by which the width of a flat part grows, so that it does not follow every digit."""

_ARROW_STEPS = {
    Qt.Key.Key_Left: -1, Qt.Key.Key_Up: -1, Qt.Key.Key_Right: 1, Qt.Key.Key_Down: 1,
}  # fmt: skip
"""From part to part, by key."""


class StatusItemWidget(QAbstractButton, ArrowKeyNavigation):
    """One part, painted; a press, Space or Enter runs what belongs to it."""

    part_pressed = Signal(str)  # Id of the part.

    def __init__(self, part: StatusItem, style: DisplayStyle) -> None:
        super().__init__()
        self.item = part
        # Whether word and value share one line, for windows that are low for their scale.
        self.is_flat = False
        self._style = style
        wide = QSizePolicy.Policy.Expanding if part.stretches else QSizePolicy.Policy.Preferred
        self.setSizePolicy(wide, QSizePolicy.Policy.Fixed)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.clicked.connect(self._run)
        self._describe()

    def show_item(self, part: StatusItem) -> bool:
        """Show other words; return whether the width it asks for changed."""
        if part == self.item:
            return False
        former = self.sizeHint()
        self.item = part
        self._describe()
        self.update()
        return self.sizeHint() != former

    def _describe(self) -> None:
        part = self.item
        text = f"{part.title} {part.value} {part.note}".strip()
        self.setAccessibleName(
            text if part.state in ("plain", "good") else f"{text}, {tr(part.state)}"
        )
        self.setAccessibleDescription(part.detail)
        self.setToolTip(plain_tooltip(part.detail))

    def sizeHint(self) -> QSize:
        style = self._style
        if self.is_flat:
            step = style.px(_FLAT_STEP)
            needed = sum(self._flat_widths()) + style.px(24 if self.item.state == "plain" else 40)
            return QSize(math.ceil(needed / step) * step, style.px(28))
        return QSize(style.px(self.item.width + 16), style.px(48))

    def minimumSizeHint(self) -> QSize:
        size = self.sizeHint()
        if self.item.stretches:
            size.setWidth(min(size.width(), self._style.px(self.item.width)))
        return size

    def paintEvent(self, _event: QPaintEvent) -> None:
        style, part = self._style, self.item
        painter = QPainter(self)
        box = QRectF(self.rect())
        if part.state in ("caution", "warning"):
            painter.fillRect(box, style.color(f"{part.state}_band"))
        elif part.state == "unknown":
            brush = QBrush(style.color("line"), Qt.BrushStyle.BDiagPattern)
            painter.fillRect(box, brush)
        left = style.px(8)
        top = style.px(7 if self.is_flat else 6)
        line = QRectF(left, top, box.width() - 2 * left, style.px(14))
        if part.state != "plain":
            side = style.px(10)
            sign = QRectF(left, line.center().y() - side / 2, side, side)
            paint_indicator(painter, part.state, sign, style.state_color(part.state))
            line.setLeft(left + side + style.px(5))
        self._word(painter, line)
        below = QRectF(left, style.px(20), box.width() - 2 * left, style.px(24))
        if self.is_flat:
            word = self._flat_word(line.width()) + style.px(8)
            below = QRectF(line.left() + word, 0, line.width() - word, box.height())
        self._value(painter, below)
        painter.setPen(style.color("line"))
        edge = box.right() - 0.5
        painter.drawLine(QPointF(edge, 0), QPointF(edge, box.height()))
        if self.hasFocus():
            paint_focus_frame(painter, self.rect(), style)
        painter.end()

    def _value_font(self) -> QFont:
        if self.is_flat and self.item.stretches:
            return self._style.font("label", strong=True)
        font = self._style.font("body", strong=True)
        font.setPixelSize(self._style.px(15))
        return font

    def _flat_widths(self) -> tuple[float, float]:
        small = QFontMetricsF(self._style.font("label"))
        part, gap = self.item, self._style.px(8)
        value = QFontMetricsF(self._value_font()).horizontalAdvance(part.value)
        note = gap + small.horizontalAdvance(part.note) if part.note else 0.0
        return small.horizontalAdvance(part.title), value + note

    def _flat_word(self, width: float) -> float:
        """Return the room for the word on one line; the value goes first."""
        word, value = self._flat_widths()
        return min(word, max(0.3 * width, width - value - self._style.px(8)))

    def _word(self, painter: QPainter, line: QRectF) -> None:
        font = self._style.font("label")
        painter.setFont(font)
        painter.setPen(self._style.color("muted" if self.item.state != "warning" else "text"))
        # A pixel more, as the widths are rounded.
        room = self._flat_word(line.width()) + 1.0 if self.is_flat else line.width()
        text = self.item.title
        if self.item.hint and not self.is_flat:
            text = f"{text}   {self.item.hint}"
        word = QFontMetricsF(font).elidedText(text, Qt.TextElideMode.ElideRight, room)
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter, word)

    def _value(self, painter: QPainter, line: QRectF) -> None:
        style, part = self._style, self.item
        font = self._value_font()
        metrics = QFontMetricsF(font)
        if (
            part.stretches
            and not self.is_flat
            and metrics.horizontalAdvance(part.value) > line.width()
        ):
            self._sentence(painter, line)
            return
        role = part.state if part.state in ("caution", "warning") else "text"
        painter.setFont(font)
        painter.setPen(style.color("muted" if part.state == "unknown" else role))
        value = metrics.elidedText(part.value, Qt.TextElideMode.ElideRight, line.width())
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter, value)
        used = metrics.horizontalAdvance(value) + style.px(8)
        room = line.width() - used
        if part.note and room > style.px(16):
            small = style.font("label")
            painter.setFont(small)
            painter.setPen(style.color("muted" if role == "text" else "text"))
            note = QFontMetricsF(small).elidedText(part.note, Qt.TextElideMode.ElideRight, room)
            painter.drawText(line.adjusted(used, 1, 0, 1), Qt.AlignmentFlag.AlignVCenter, note)

    def _sentence(self, painter: QPainter, line: QRectF) -> None:
        """Draw a long value in two small lines; what still does not fit is in the tool tip."""
        style, part = self._style, self.item
        font = style.font("label", strong=True)
        painter.setFont(font)
        painter.setPen(style.color(part.state if part.state in ("caution", "warning") else "text"))
        metrics = QFontMetricsF(font)
        first, rest = _break_text(part.value, metrics, line.width())
        high = style.px(14)
        top = QRectF(line.left(), style.px(19), line.width(), high)
        painter.drawText(top, Qt.AlignmentFlag.AlignVCenter, first)
        rest = metrics.elidedText(rest, Qt.TextElideMode.ElideRight, line.width())
        painter.drawText(top.translated(0, high), Qt.AlignmentFlag.AlignVCenter, rest)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton:
            event.ignore()
            return
        self._run()

    def _run(self) -> None:
        self.part_pressed.emit(self.item.id)
        if QApplication.activePopupWidget() is None:
            # Whole, where the part has no room for it.
            text = plain_tooltip(self.item.detail or self.accessibleName())
            QToolTip.showText(self.mapToGlobal(self.rect().center()), text, self)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if Qt.Key(event.key()) in _ARROW_STEPS:
            event.ignore()  # Goes to the bar.
        else:
            super().keyPressEvent(event)


class StatusBar(QWidget):
    """All parts in a row, or in two where the window is narrow.

    Tab stops at the first; arrows lead to the others.

    `buttons`: what stands beside a part, by its id, while that has an action.
    """

    pressed = Signal(str)  # Id of the part the user pressed.

    def __init__(self, style: DisplayStyle, buttons: Mapping[str, QWidget] | None = None) -> None:
        super().__init__()
        self._style = style
        self._buttons = buttons or {}
        self.setObjectName("bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName(tr("Flight, link, recorder, alarms"))
        self._flow = FlowLayout(self, spacing=0, fill=True)
        self._flow.setContentsMargins(0, 0, 0, 1)
        policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        self.item_widgets: dict[str, StatusItemWidget] = {}
        self._flat = False
        style.changed.connect(self._resized)

    def show_items(self, parts: Iterable[StatusItem]) -> None:
        wider = False
        for part in parts:
            view = self.item_widgets.get(part.id)
            if view is None:
                view = StatusItemWidget(part, self._style)
                view.part_pressed.connect(self.pressed)
                if not self.item_widgets:
                    view.setFocusPolicy(Qt.FocusPolicy.TabFocus)
                self.item_widgets[part.id] = view
                self._flow.addWidget(view)
                if part.id in self._buttons:
                    self._flow.addWidget(self._buttons[part.id])
                wider = True
            else:
                wider = view.show_item(part) or wider
            button = self._buttons.get(part.id)
            if button is not None and button.isVisibleTo(self) != part.shows_button:
                button.setVisible(part.shows_button)
                wider = True
        if wider:
            self._resized()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        views: list[QWidget] = list(self.item_widgets.values())
        focus, step = self.focusWidget(), _ARROW_STEPS.get(Qt.Key(event.key()))
        if step is None or focus not in views:
            event.ignore()
            return
        index = min(max(views.index(focus) + step, 0), len(views) - 1)
        views[index].setFocus(Qt.FocusReason.TabFocusReason)

    def fit(self, window_height: int) -> None:
        flat = window_height < self._style.px(_LOW_WINDOW_HEIGHT)
        if flat != self._flat:
            self._flat = flat
            self._resized()

    def _resized(self) -> None:
        for view in self.item_widgets.values():
            view.is_flat = self._flat
        for view in self.item_widgets.values():
            view.updateGeometry()
            view.update()
        self._flow.invalidate()
        self.updateGeometry()


def _break_text(text: str, metrics: QFontMetricsF, width: float) -> tuple[str, str]:
    """Return as many words as fit into a width, and the rest."""
    words = text.split(" ")
    count = 1
    while count < len(words) and metrics.horizontalAdvance(" ".join(words[: count + 1])) <= width:
        count += 1
    return " ".join(words[:count]), " ".join(words[count:])
