"""Forcing an effect: a list to search, the best candidates first."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLineEdit, QVBoxLayout, QWidget

from ui.dialogs.form_dialog import FieldMessage, FormDialog
from ui.display_style import DisplayStyle
from ui.gap.gap_view_models import ForceableEffect
from ui.translation import tr
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import BoxedListView


class _SearchEdit(QLineEdit):
    """Typed words narrow the list; Up and Down move in it meanwhile."""

    def __init__(self, listed: QWidget) -> None:
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
            tr("Force another effect"),
            tr(
                "Adds the effect regardless of its evidence and refits all values. Undo removes it."
            ),
            tr("Force"),
            look,
            parent,
        )
        self.listed = BoxedListView(look, tr("Effects"))
        self.search = _SearchEdit(self.listed)
        self.search.setPlaceholderText(tr("Search the effects"))
        self.search.setAccessibleName(tr("Search the effects"))
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._filter)
        self.note = FieldMessage()
        self._rows = [
            TableRow(
                key=one.effect,
                cells=(f"{one.title}   ({one.effect})",),
                detail=f"{one.title}   ({one.effect})\n{one.reason}".strip(),
                value=one,
            )
            for one in choices
        ]
        holder = QWidget()
        column = QVBoxLayout(holder)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(look.px(8))
        column.addWidget(self.search)
        column.addWidget(self.listed)
        holder.setFocusProxy(self.search)
        self.add_row(tr("Effect"), holder, self.note)
        self.listed.row_changed.connect(lambda _key: self._validate())
        self.listed.doubleClicked.connect(lambda _index: self.accept())
        self._filter("")
        # As high with few matches as with all.
        self.listed.setFixedHeight(look.px(224))
        self.fit_to_content()

    def _filter(self, words: str) -> None:
        wanted = words.lower().split()
        self.listed.show_rows(
            [row for row in self._rows if all(word in row.cells[0].lower() for word in wanted)]
        )
        if self.listed.row_model.rows and self.listed.current_key() is None:
            self.listed.selectRow(0)
        self._validate()

    def _validate(self) -> None:
        chosen = self.selected_effect
        self.button.setEnabled(chosen is not None)
        if chosen is None:
            self.note.set_message(tr("No such effect."), "warning")
        else:
            self.note.set_message(chosen.reason or tr("Not a candidate here."))

    @property
    def selected_effect(self) -> ForceableEffect | None:
        row = self.listed.currentIndex().row()
        return self.listed.row_model.rows[row].value if row >= 0 else None
