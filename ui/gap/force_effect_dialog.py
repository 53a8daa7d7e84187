"""Forcing an effect: a list to search, the best candidates first."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLineEdit, QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from ui.dialogs.form_dialog import FieldMessage, FormDialog
from ui.display_style import DisplayStyle
from ui.gap.gap_view_models import ForceableEffect


class _SearchEdit(QLineEdit):
    """Typed words narrow the list; Up and Down move in it meanwhile."""

    def __init__(self, listed: QListWidget) -> None:
        super().__init__()
        self._listed = listed

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self._listed.keyPressEvent(event)
        else:
            super().keyPressEvent(event)


class ForceEffectDialog(FormDialog):
    """Asks which effect shall be put into the model."""

    def __init__(
        self, look: DisplayStyle, choices: Sequence[ForceableEffect], parent: QWidget | None = None
    ) -> None:
        super().__init__(
            "Force another effect",
            "It is put into the model whatever its evidence, and everything is fitted anew. Undo "
            "takes it back.",
            "Force",
            look,
            parent,
        )
        self.listed = QListWidget()
        self.listed.setAccessibleName("Effects")
        self.listed.setProperty("role", "boxed")
        self.listed.setFixedHeight(look.px(224))
        self.listed.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.search = _SearchEdit(self.listed)
        self.search.setPlaceholderText("Search the effects")
        self.search.setAccessibleName("Search the effects")
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._narrow)
        self.note = FieldMessage()
        for one in choices:
            item = QListWidgetItem(f"{one.title}   ({one.effect})")
            item.setToolTip(f"{item.text()}\n{one.reason}".strip())
            item.setData(Qt.ItemDataRole.UserRole, one)
            self.listed.addItem(item)
        holder = QWidget()
        column = QVBoxLayout(holder)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(look.px(8))
        column.addWidget(self.search)
        column.addWidget(self.listed)
        holder.setFocusProxy(self.search)
        self.add_row("Effect", holder, self.note)
        self.listed.currentItemChanged.connect(lambda *_: self._judge())
        self.listed.itemDoubleClicked.connect(lambda _item: self.accept())
        self.listed.setCurrentRow(0)
        self._judge()
        self.fit_to_content()

    def _narrow(self, words: str) -> None:
        wanted = words.lower().split()
        first = None
        for row in range(self.listed.count()):
            item = self.listed.item(row)
            fits = all(word in item.text().lower() for word in wanted)
            item.setHidden(not fits)
            if fits and first is None:
                first = item
        current = self.listed.currentItem()
        if current is None or current.isHidden():
            self.listed.setCurrentItem(first)
        self._judge()

    def _judge(self) -> None:
        chosen = self.selected_effect
        self.button.setEnabled(chosen is not None)
        if chosen is None:
            self.note.set_message("No effect is called that.", "warning")
        else:
            self.note.set_message(chosen.reason or "It did not compete here.")

    @property
    def selected_effect(self) -> ForceableEffect | None:
        """Return the effect chosen; None while nothing fits the words."""
        item = self.listed.currentItem()
        if item is None or item.isHidden():
            return None
        found = item.data(Qt.ItemDataRole.UserRole)
        return found if isinstance(found, ForceableEffect) else None
