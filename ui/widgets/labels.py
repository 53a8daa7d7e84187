"""Labels in the roles of the style sheet and in the units of the screen; centered columns."""

from __future__ import annotations

import html

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtGui import Qt as RichText
from PySide6.QtWidgets import QFrame, QGridLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from gsapp.quantities import convert_text_units
from ui.display_style import DisplayStyle


class UnitConvertingLabel(QLabel):
    """A label whose sentences have their values in the units of the screen, also after a change."""

    def __init__(self, style: DisplayStyle, text: str = "") -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self._style = style
        self._remark = text
        style.changed.connect(self._convert)
        self._convert()

    def setText(self, text: str) -> None:
        self._remark = text
        self._convert()

    def _convert(self) -> None:
        super().setText(convert_text_units(self._remark, self._style.units))


def create_label(
    text: str, role: str = "", *, wrap: bool = False, remarks_in: DisplayStyle | None = None
) -> QLabel:
    """Return a label in a role of the style sheet; for remarks, in the units of a look."""
    made = QLabel(text) if remarks_in is None else UnitConvertingLabel(remarks_in, text)
    if role:
        made.setProperty("role", role)
    # A text may come from a file of a stranger: markup in it is shown, not obeyed.
    made.setTextFormat(Qt.TextFormat.PlainText)
    made.setWordWrap(wrap)
    return made


def plain_tooltip(text: str) -> str:
    """Return a tooltip that shows a text as it is, markup included."""
    if not RichText.mightBeRichText(text):
        return text
    return f"<qt>{html.escape(text)}</qt>".replace("\n", "<br>")


class CenteredPage(QScrollArea):
    """A column of text of readable width, centered, that scrolls where the window is small."""

    def __init__(self, style: DisplayStyle, width: int = 720) -> None:
        super().__init__()
        self._style = style
        self._width = width
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._page = QWidget()
        self._page.setObjectName("page")
        self.setWidget(self._page)
        outer = QGridLayout(self._page)
        self.column = QVBoxLayout()
        self._body = QWidget()
        self._body.setLayout(self.column)
        self.column.setContentsMargins(0, 0, 0, 0)
        outer.setColumnStretch(0, 1)
        outer.setColumnStretch(2, 1)
        outer.setRowStretch(0, 2)
        outer.setRowStretch(2, 3)
        outer.addWidget(self._body, 1, 1)
        self._outer = outer
        style.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        margin = self._style.px(24)
        self._outer.setContentsMargins(margin, margin, margin, margin)
        self.column.setSpacing(self._style.px(8))
        room = max(self.viewport().width() - 2 * margin - 2, 1)
        self._body.setFixedWidth(min(self._style.px(self._width), room))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()
