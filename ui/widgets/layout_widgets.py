"""What pages are laid out with: columns, form sections, headings, names with values."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QComboBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from ui.display_style import DisplayStyle
from ui.widgets.flow_layout import FlowLayout, arrange, clear_layout
from ui.widgets.labels import create_label

_MIN_COLUMN_WIDTH = 360  # Points a column needs.


class FormSection(QFrame):
    """A framed part of a form: heading, then rows of fields."""

    def __init__(self, style: DisplayStyle, title: str) -> None:
        super().__init__()
        self._style = style
        self.setObjectName("card")
        self.column = QVBoxLayout(self)
        self.column.addWidget(create_label(title, "heading"))
        style.changed.connect(self._fit)
        self._fit()

    def add(self, *widgets: QWidget) -> None:
        for widget in widgets:
            self.column.addWidget(widget)

    def _fit(self) -> None:
        px = self._style.px
        self.column.setContentsMargins(px(16), px(12), px(16), px(12))
        self.column.setSpacing(px(8))


class FormColumns(QScrollArea):
    """Sections that stand in columns and scroll down."""

    def __init__(self, style: DisplayStyle, most: int = 3) -> None:
        super().__init__()
        self._style = style
        self._most = most
        self._sections: tuple[tuple[QWidget, int], ...] = ()
        self._shown = 0
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        page = QWidget()
        page.setObjectName("page")
        self._outer = QVBoxLayout(page)
        self.head = QVBoxLayout()
        self._outer.addLayout(self.head)
        self._row = QHBoxLayout()
        self._outer.addLayout(self._row)
        self._outer.addStretch(1)
        self._columns = [QVBoxLayout() for _ in range(most)]
        for column in self._columns:
            column.addStretch(1)
            self._row.addLayout(column, 1)
        self.setWidget(page)
        style.changed.connect(self._fit)

    def show_sections(self, sections: Sequence[tuple[QWidget, int]]) -> None:
        """Show the sections, each with its column where there is room for all columns."""
        self._sections = tuple(sections)
        self._shown = 0
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        px = self._style.px
        margin = px(16)
        self._outer.setContentsMargins(margin, margin, margin, margin)
        self._outer.setSpacing(margin)
        self._row.setSpacing(margin)
        for column in self._columns:
            column.setSpacing(margin)
        room = self.viewport().width() - 2 * margin
        count = min(max((room + margin) // (px(_MIN_COLUMN_WIDTH) + margin), 1), self._most)
        if count == self._shown or not self._sections:
            return
        self._shown = count
        for index, column in enumerate(self._columns):
            self._row.setStretch(index, 1 if index < count else 0)
            for section, _wish in self._sections:
                # An item that is taken out instead goes on measuring the widget in its stead.
                column.removeWidget(section)
        for section, wish in self._sections:
            column = self._columns[min(wish, count - 1)]
            column.insertWidget(column.count() - 1, section)


class PageStack(QStackedWidget):
    """Pages of which one is on screen; only that one decides how much room they need."""

    def __init__(self) -> None:
        super().__init__()
        self.currentChanged.connect(self.updateGeometry)

    def minimumSizeHint(self) -> QSize:
        page = self.currentWidget()
        if page is None:
            return super().minimumSizeHint()
        size, layout = page.minimumSizeHint(), page.layout()
        if isinstance(layout, QBoxLayout) and layout.hasHeightForWidth():
            size.setHeight(max(size.height(), layout.minimumHeightForWidth(self.width())))
        return size

    def hasHeightForWidth(self) -> bool:
        # With it a layout around the stack would give it the height that its pages prefer.
        return False

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if event.size().width() != event.oldSize().width():
            self.updateGeometry()


class PageScrollArea(QScrollArea):
    """Scrolls pages where the window is smaller than what they need at this scale."""

    def __init__(self, pages: PageStack) -> None:
        super().__init__()
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        # Left to itself a scroll area gives the stack the height that its pages prefer.
        holder = QWidget()
        arrange(QVBoxLayout(holder), 0).addWidget(pages)
        self.setWidget(holder)
        holder.setAutoFillBackground(False)
        self.viewport().setAutoFillBackground(False)


_SIDE_BY_SIDE_WIDTH = 860


class StackingColumns(QWidget):
    """Two columns side by side, or one above the other where the window is narrow."""

    def __init__(self, style: DisplayStyle, shares: tuple[int, int] = (1, 1)) -> None:
        super().__init__()
        self._style = style
        self._box = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._box.setContentsMargins(0, 0, 0, 0)
        self.left, self.right = QVBoxLayout(), QVBoxLayout()
        self._shares = shares
        for column, share in zip((self.left, self.right), shares, strict=True):
            holder = QWidget()
            # The share decides, not what happens to stand in the column.
            holder.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
            holder.setLayout(column)
            column.setContentsMargins(0, 0, 0, 0)
            self._box.addWidget(holder, share)
        style.changed.connect(self._fit)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        style = self._style
        wide = self.width() >= style.px(_SIDE_BY_SIDE_WIDTH)
        side = QBoxLayout.Direction.LeftToRight
        wanted = side if wide else QBoxLayout.Direction.TopToBottom
        if self._box.direction() != wanted:
            self._box.setDirection(wanted)
        for index, share in enumerate(self._shares):
            self._box.setStretch(index, share if wide else 0)
        self._box.setSpacing(style.px(24))
        for column in (self.left, self.right):
            column.setSpacing(style.px(8))


class LabeledComboBox(QWidget):
    """A labeled list to choose one from."""

    def __init__(self, style: DisplayStyle, name: str, *, letters: int = 12) -> None:
        super().__init__()
        row = arrange(QHBoxLayout(self), style.px(8))
        self.title = create_label(name, "label")
        row.addWidget(self.title)
        self.box = QComboBox()
        self.box.setAccessibleName(name)
        self.box.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.box.setMinimumContentsLength(letters)
        row.addWidget(self.box, 1)
        self.setFocusProxy(self.box)
        self._shown: tuple[tuple[str, str], ...] = ()

    def set_choices(self, choices: Sequence[tuple[str, str]], current: str) -> None:
        """Show the choices (key, words) with one chosen; emits nothing."""
        self.box.blockSignals(True)
        if tuple(choices) != self._shown:
            self._shown = tuple(choices)
            self.box.clear()
            for key, text in choices:
                self.box.addItem(text, key)
        place = self.box.findData(current)
        if place >= 0:
            self.box.setCurrentIndex(place)
        self.box.blockSignals(False)

    @property
    def current_key(self) -> str:
        return str(self.box.currentData() or "")


class HeadedParagraphs(QWidget):
    """Headings with a paragraph each."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._shown: tuple[tuple[str, str], ...] | None = None

    def show_paragraphs(self, paragraphs: Sequence[tuple[str, str]]) -> None:
        if tuple(paragraphs) == self._shown:
            return
        self._shown = tuple(paragraphs)
        clear_layout(self._column)
        self._column.setSpacing(self._style.px(2))
        for heading, text in paragraphs:
            if heading:
                self._column.addWidget(create_label(heading, "label"))
            body = create_label(text, wrap=True)
            body.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            body.setContentsMargins(0, 0, 0, self._style.px(6))
            self._column.addWidget(body)
        self.setVisible(bool(paragraphs))


class NameValueTable(QWidget):
    """Names and values in two columns, values aligned."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setColumnStretch(1, 1)
        self.rows: tuple[tuple[str, str], ...] = ()

    def show_rows(self, rows: Sequence[tuple[str, str]]) -> None:
        if tuple(rows) == self.rows:
            return
        self.rows = tuple(rows)
        clear_layout(self._grid)
        self._grid.setHorizontalSpacing(self._style.px(16))
        self._grid.setVerticalSpacing(self._style.px(4))
        for row, (name, value) in enumerate(rows):
            self._grid.addWidget(create_label(name, "muted"), row, 0)
            self._grid.addWidget(create_label(value, "number", wrap=True), row, 1)
        self.setVisible(bool(rows))


def create_button_row(style: DisplayStyle, *buttons: QWidget) -> QWidget:
    """Return buttons side by side that break into rows where the window is narrow."""
    holder = QWidget()
    flow = FlowLayout(holder, spacing=style.px(8))
    for one in buttons:
        flow.addWidget(one)
    policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
    policy.setHeightForWidth(True)
    holder.setSizePolicy(policy)
    return holder


def add_widgets(layout: QBoxLayout, *widgets: QWidget | tuple[QWidget, int]) -> None:
    """Add widgets one after the other, some with the share of the room that they take."""
    for one in widgets:
        widget, share = one if isinstance(one, tuple) else (one, 0)
        layout.addWidget(widget, share)


class ScrollingPage(QScrollArea):
    """A page that scrolls up and down, without a frame; what it holds is in its `column`."""

    def __init__(self, page: QWidget | None = None) -> None:
        super().__init__()
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        body = page or QWidget()
        body.setObjectName("page")
        body.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.column = QVBoxLayout(body)
        self.setWidget(body)
