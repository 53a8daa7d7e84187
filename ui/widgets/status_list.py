"""A list of large lines: sign, words, what there is to say of them, and how they stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QAction, QFont, QFontMetrics, QKeyEvent, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QListView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
)

from gsapp.quantities import convert_text_units
from ui.display_style import DisplayStyle
from ui.icons import IndicatorState, paint_indicator
from ui.translation import tr
from ui.widgets.row_model import VALUE_ROLE, ModelIndex, TableRow, TableRowModel
from ui.widgets.table_menu import TableMenu

_WRAP = Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft
_LEFT, _RIGHT = 44, 108  # Points for the sign on the left and for the state on the right.


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusListItem:
    """One line."""

    key: str  # What it stands for.
    text: str  # Strong, on top.
    detail: str = ""  # Below.
    state: IndicatorState = "plain"  # Sign and colors.
    state_text: str = ""  # On the right, in the color of the state.
    note: str = ""  # Below these.
    # Whether an empty box stands in place of the sign: something that a hand ticks.
    is_checkable: bool = False
    is_done: bool = False  # Whether there is nothing left to do about it.


class _StatusListDelegate(QStyledItemDelegate):
    """Draws one line as high as its words need."""

    def __init__(self, style: DisplayStyle, view: StatusListView) -> None:
        super().__init__(view)
        self._style = style
        self._view = view

    def _fonts(self) -> tuple[QFont, QFont]:
        strong = self._style.font("body", strong=True)
        strong.setPixelSize(self._style.px(15))
        return strong, self._style.font("body")

    def _parts(self, line: StatusListItem, width: int) -> tuple[QRect, QRect]:
        px = self._style.px
        strong, plain = self._fonts()
        room = max(width - px(_LEFT) - px(_RIGHT) - px(14), px(80))
        text = QFontMetrics(strong).boundingRect(0, 0, room, 10_000, _WRAP, line.text)
        text.moveTo(px(_LEFT), px(6))
        more = QFontMetrics(plain).boundingRect(0, 0, room, 10_000, _WRAP, line.detail)
        more.moveTo(px(_LEFT), text.bottom() + px(2))
        return text, more

    def sizeHint(self, _option: QStyleOptionViewItem, index: ModelIndex) -> QSize:
        width = self._view.viewport().width()
        line = index.data(VALUE_ROLE)
        high = self._parts(line, width)[1].bottom() + self._style.px(8)
        return QSize(width, max(high, self._style.px(48)))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        style, px = self._style, self._style.px
        line = index.data(VALUE_ROLE)
        box = option.rect
        painter.save()
        if line.state in ("warning", "caution"):
            painter.fillRect(box, style.color(f"{line.state}_band"))
        painter.setPen(style.color("line"))
        painter.drawLine(box.bottomLeft(), box.bottomRight())
        if option.state & QStyle.StateFlag.State_Selected:
            pen = QPen(style.color("text" if self._view.hasFocus() else "axis"))
            pen.setWidth(px(2))
            painter.setPen(pen)
            painter.drawRect(box.adjusted(px(1), px(1), -px(1) - 1, -px(1) - 1))
        side = px(16)
        sign = QRectF(box.left() + px(14), box.top() + px(8), side, side)
        color = style.state_color(line.state)
        if line.is_checkable:
            painter.setPen(style.color("text"))
            painter.drawRect(sign)
        else:
            paint_indicator(painter, line.state, sign, color)
        text, more = self._parts(line, box.width())
        strong, plain = self._fonts()
        painter.setFont(strong)
        painter.setPen(style.color("text"))
        painter.drawText(text.translated(box.topLeft()), _WRAP, line.text)
        painter.setFont(plain)
        painter.setPen(style.color("text" if line.state in ("warning", "caution") else "muted"))
        painter.drawText(more.translated(box.topLeft()), _WRAP, line.detail)
        painter.setFont(strong)
        painter.setPen(color)
        right = QRect(box.right() - px(_RIGHT) - px(10), box.top() + px(6), px(_RIGHT), px(20))
        painter.drawText(right, Qt.AlignmentFlag.AlignRight, line.state_text)
        painter.setFont(style.font("label"))
        painter.setPen(style.color("muted"))
        below = right.translated(0, px(20))
        painter.drawText(below, Qt.AlignmentFlag.AlignRight, line.note)
        painter.restore()


_MIN_HEIGHT = 96
"""Points: one line with its details, and a part of the next."""


class StatusListView(QListView):
    """The list; keys act on the line that the keyboard is on."""

    # Key of the line on which Space or Enter was pressed, or the mouse.
    item_activated = Signal(str)
    current_item_changed = Signal(str)  # Key of the line that the keyboard is on now.
    move_requested = Signal(int)  # Alt with Up or Down: the line shall go there.
    delete_requested = Signal()  # Delete.

    def __init__(self, style: DisplayStyle, name: str, commands: Sequence[QAction] = ()) -> None:
        super().__init__()
        self._style = style
        self.row_model = TableRowModel(style, (tr("Line"),))
        self.setModel(self.row_model)
        self.menu = TableMenu(self, commands, self._table)
        self.setItemDelegate(_StatusListDelegate(style, self))
        self.setAccessibleName(name)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setResizeMode(QListView.ResizeMode.Adjust)
        self.clicked.connect(
            lambda index: self.item_activated.emit(self.row_model.rows[index.row()].key)
        )
        self._given: tuple[StatusListItem, ...] = ()
        style.changed.connect(self._restyle)
        self.setMinimumHeight(style.px(_MIN_HEIGHT))

    def _restyle(self) -> None:
        self.setMinimumHeight(self._style.px(_MIN_HEIGHT))
        self.set_items(self._given)
        self.scheduleDelayedItemsLayout()

    def _table(self) -> list[tuple[str, ...]]:
        items = [row.value for row in self.row_model.rows]
        rows = [(one.text, one.detail, one.state_text, one.note) for one in items]
        return [(tr("Line"), tr("Details"), tr("State"), tr("Note")), *rows]

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.scheduleDelayedItemsLayout()

    def currentChanged(
        self,
        current: QModelIndex | QPersistentModelIndex,
        previous: QModelIndex | QPersistentModelIndex,
    ) -> None:
        super().currentChanged(current, previous)
        if current.isValid():
            self.current_item_changed.emit(self.current_key)

    def set_items(self, lines: Sequence[StatusListItem]) -> None:
        """Show the lines, with values in the units of the screen.

        The keyboard stays on the same one, but does not follow it to the end.
        """
        self._given = tuple(lines)
        units = self._style.units
        rows = []
        for line in lines:
            text, detail = (convert_text_units(one, units) for one in (line.text, line.detail))
            spoken = ", ".join(filter(None, (text, line.state_text, detail)))
            value = replace(line, text=text, detail=detail)
            rows.append(TableRow(key=line.key, cells=(spoken,), value=value))
        former, row = self.current_key, self.currentIndex().row()
        before = [one.key for one in self.row_model.rows]
        scrolled = self.verticalScrollBar().value()
        self.row_model.set_rows(rows)
        keys = [line.key for line in lines]
        if keys == before or not keys:
            return
        left = {line.key for line in lines if not line.is_done}
        stays = former in keys and (former in left or not left)
        self.select_row(keys.index(former) if stays else row)
        self.verticalScrollBar().setValue(scrolled)

    @property
    def current_key(self) -> str:
        """Return the key of the line that the keyboard is on; empty for none."""
        row = self.currentIndex().row()
        return str(self.row_model.rows[row].key) if 0 <= row < len(self.row_model.rows) else ""

    def select_item(self, key: str) -> None:
        """Put the keyboard on a line, if it is there."""
        row = self.row_model.find_row(key)
        if row >= 0:
            self.select_row(row)

    def select_row(self, row: int) -> None:
        """Put the keyboard on the line that stands there, or nearest to there."""
        last = len(self.row_model.rows) - 1
        self.setCurrentIndex(self.row_model.index(min(max(row, 0), last), 0))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        key = Qt.Key(event.key())
        moves = {Qt.Key.Key_Up: -1, Qt.Key.Key_Down: 1}
        if key in (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter):
            if not event.isAutoRepeat():
                self.item_activated.emit(self.current_key)
        elif key in moves and event.modifiers() & Qt.KeyboardModifier.AltModifier:
            self.move_requested.emit(moves[key])
        elif key == Qt.Key.Key_Delete:
            self.delete_requested.emit()
        else:
            super().keyPressEvent(event)
