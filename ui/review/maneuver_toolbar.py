"""What can be done with the maneuver that is looked at, as a row of buttons."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QCheckBox, QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.review.flights_panel import create_command_button
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.layout_widgets import create_button_row

_BUTTONS = (
    ("review_zoom", QT_TR_NOOP("Zoom")),
    ("review_add_maneuver", QT_TR_NOOP("Add")),
    ("review_remove_maneuver", QT_TR_NOOP("Remove")),
    ("review_merge", QT_TR_NOOP("Merge")),
    ("review_rename", QT_TR_NOOP("Rename")),
    ("review_note", QT_TR_NOOP("Note")),
    ("review_grade", QT_TR_NOOP("Grade…")),
)


class ManeuverToolbar(QWidget):
    """Buttons of the commands, and whether the maneuver takes part in estimates."""

    def __init__(self, actions: Mapping[str, QAction], look: DisplayStyle) -> None:
        super().__init__()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        self.use = QCheckBox(tr("Use in the estimate"))
        self._in_use = actions["review_in_use"]
        self.use.clicked.connect(actions["review_in_use"].trigger)
        self.buttons = {}
        for name, words in _BUTTONS:
            button = create_command_button(actions[name], quiet=True)
            button.setText(tr(words))
            self.buttons[name] = button
        self._look = look
        column.addWidget(create_button_row(look, *self.buttons.values(), self.use))

        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        # As high as the buttons beside it.
        self.use.setMinimumHeight(self._look.px(30))

    def set_in_use(self, used: bool | None) -> None:
        self.use.setEnabled(used is not None)
        known = used is not None
        self.use.setToolTip(self._in_use.text() if known else tr("Choose a maneuver first"))
        self.use.setChecked(bool(used))
