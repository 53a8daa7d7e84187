"""The top of the page Estimate: the button, what a run would take, what the field at hand does."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFrame, QHBoxLayout, QSizePolicy, QVBoxLayout

from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.review.estimate_text import FIELD_HELP
from ui.translation import tr
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label


class EstimateHeader(QFrame):
    """Stays in sight while the settings below it scroll."""

    def __init__(self, run: QAction, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.setObjectName("banner")
        self._column = QVBoxLayout(self)
        self._row = QHBoxLayout()
        self.button = ActionButton(run, tr("Estimate"), look)
        self.button.setProperty("role", "primary")
        self.button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._row.addWidget(self.button, 0, Qt.AlignmentFlag.AlignTop)
        words = QVBoxLayout()
        words.setSpacing(2)
        self.message = FieldMessage()
        self.message.setProperty("role", "")
        words.addWidget(self.message)
        self.explained = create_label("", "muted", wrap=True, remarks_in=look)
        self.explained.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        self.explained.setAlignment(Qt.AlignmentFlag.AlignTop)
        words.addWidget(self.explained)
        self._row.addLayout(words, 1)
        self._column.addLayout(self._row)
        look.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        px = self._look.px
        self._row.setSpacing(px(16))
        self._column.setContentsMargins(px(16), px(8), px(16), px(8))
        self.button.setMinimumHeight(px(44))
        self.button.setMinimumWidth(px(120))
        # Two lines, so that nothing jumps as the keyboard goes from field to field.
        self.explained.setMinimumHeight(2 * self.explained.fontMetrics().height() + px(2))

    def show_field_help(self, field: str) -> None:
        words = FIELD_HELP[field]
        self.explained.setText(f"{tr(words.title)}: {tr(words.help_text)}")
