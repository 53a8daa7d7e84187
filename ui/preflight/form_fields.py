"""Fields of the forms before a flight: high enough for gloves, with a sentence below."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QLineEdit,
    QPlainTextEdit,
    QSizePolicy,
    QWidget,
)

from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.labels import create_label

_NAME, _UNIT = 128, 40
"""Points for the name left of a field and for the unit right of it."""


def set_touch_height(widget: QWidget) -> None:
    """Let a control be as high as gloves need; the style sheet knows how high that is."""
    widget.setProperty("tall", True)


def _is_undo(event: QEvent) -> bool:
    """Return whether a key means undo or redo, which belong to the whole page."""
    return (
        event.type() == QEvent.Type.ShortcutOverride
        and isinstance(event, QKeyEvent)
        and any(
            event.matches(key)
            for key in (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
        )
    )


class FormLineEdit(QLineEdit):
    """One line of text.

    Attributes
    ----------
    editing_finished : Signal
        The keyboard went elsewhere.
    """

    editing_finished = Signal()

    def event(self, event: QEvent) -> bool:
        if _is_undo(event):
            event.ignore()
            return False
        return super().event(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.editing_finished.emit()


class FormTextEdit(QPlainTextEdit):
    """Some lines of text; Tab goes on to the next field.

    Attributes
    ----------
    editing_finished : Signal
        The keyboard went elsewhere.
    """

    editing_finished = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setTabChangesFocus(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)

    def event(self, event: QEvent) -> bool:
        if _is_undo(event):
            event.ignore()
            return False
        return super().event(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.editing_finished.emit()


class _WidePopupComboBox(QComboBox):
    """A box in a narrow column, whose list is as wide as its longest line."""

    def showPopup(self) -> None:
        view = self.view()
        view.setMinimumWidth(view.sizeHintForColumn(0) + 2 * view.frameWidth())
        super().showPopup()


class FormField(QWidget):
    """A named field with a unit right of it and a sentence below it.

    Parameters
    ----------
    look : DisplayStyle
        Sizes.
    name : str
        Left of a line, above several lines.
    rows : int
        Lines of text in sight; 1 for a single one.
    choices : sequence of (str, str)
        Keys and words to choose from, in place of text.

    Attributes
    ----------
    text_edited : Signal(str)
        The user typed or chose something else.
    editing_finished : Signal
        The keyboard went elsewhere.
    """

    text_edited = Signal(str)
    editing_finished = Signal()

    def __init__(
        self,
        look: DisplayStyle,
        name: str,
        *,
        rows: int = 1,
        choices: Sequence[tuple[str, str]] = (),
    ) -> None:
        super().__init__()
        self._look = look
        self._rows = rows
        self.name = create_label(tr(name), wrap=True)
        self.unit = create_label("", "muted")
        self.message = FieldMessage()
        self.message.hide()
        self.edit = self._create_edit(rows, choices)
        self.edit.setAccessibleName(tr(name))
        set_touch_height(self.edit)
        self.setFocusProxy(self.edit)
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setColumnStretch(1, 1)
        if rows == 1:
            self._grid.addWidget(self.name, 0, 0)
            self._grid.addWidget(self.edit, 0, 1)
            self._grid.addWidget(self.unit, 0, 2)
        else:
            self._grid.addWidget(self.name, 0, 0, 1, 3)
            self._grid.addWidget(self.edit, 1, 0, 1, 3)
        self._grid.addWidget(self.message, 2, 0 if rows > 1 else 1, 1, -1)
        look.changed.connect(self._fit)
        self._fit()

    def _create_edit(
        self, rows: int, choices: Sequence[tuple[str, str]]
    ) -> QComboBox | FormTextEdit | FormLineEdit:
        if choices:
            box = _WidePopupComboBox()
            box.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
            for key, words in choices:
                box.addItem(tr(words), key)
            box.activated.connect(lambda _index: self.text_edited.emit(self.text))
            return box
        if rows > 1:
            lines = FormTextEdit()
            lines.textChanged.connect(lambda: self.text_edited.emit(self.text))
            lines.editing_finished.connect(self.editing_finished)
            return lines
        line = FormLineEdit()
        line.textEdited.connect(self.text_edited)
        line.editing_finished.connect(self.editing_finished)
        return line

    @property
    def text(self) -> str:
        """Return what stands there; of choices the key."""
        edit = self.edit
        if isinstance(edit, QComboBox):
            return str(edit.currentData() or "")
        return edit.toPlainText() if isinstance(edit, QPlainTextEdit) else edit.text()

    def set_text(self, text: str) -> None:
        """Show another text, or choice; emits nothing, and leaves the cursor where it was."""
        edit = self.edit
        if text == self.text:
            return
        edit.blockSignals(True)
        if isinstance(edit, QComboBox):
            edit.setCurrentIndex(max(edit.findData(text), 0))
        elif isinstance(edit, QPlainTextEdit):
            edit.setPlainText(text)
        else:
            edit.setText(text)
        edit.blockSignals(False)

    def set_choices(self, choices: Sequence[tuple[str, str]], chosen: str) -> None:
        """Show other choices with one of them chosen; emits nothing."""
        box = self.edit
        if isinstance(box, QComboBox):
            if [box.itemData(place) for place in range(box.count())] != [key for key, _ in choices]:
                box.clear()
                for key, words in choices:
                    box.addItem(tr(words), key)
            self.set_text(chosen)

    def select_all(self) -> None:
        """Let what is typed next replace what stands there."""
        if isinstance(self.edit, QLineEdit):
            self.edit.selectAll()

    def show_unit(self, unit: str) -> None:
        """Show another unit."""
        self.unit.setText(unit)
        self._fit()

    def show_hint(self, hint: str) -> None:
        """Show, where nothing was typed, what would stand there."""
        if isinstance(self.edit, (QLineEdit, QPlainTextEdit)):
            self.edit.setPlaceholderText(hint)

    def show_message(self, words: str, state: str = "") -> None:
        """Say something below the field, or nothing."""
        self.message.set_message(words, state)
        self.message.setVisible(bool(words))
        self.edit.setAccessibleDescription(words)

    def _fit(self) -> None:
        px = self._look.px
        self._grid.setHorizontalSpacing(px(8))
        self._grid.setVerticalSpacing(px(2))
        if self._rows > 1:
            self.edit.setFixedHeight(px(20 * self._rows + 16))
        else:
            self.name.setFixedWidth(px(_NAME))
            self.unit.setFixedWidth(px(_UNIT))
            self.unit.setVisible(bool(self.unit.text()))
