"""The maneuver that is looked at, in words: what was flown, its grade and why, what was said."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QSizePolicy, QVBoxLayout, QWidget

from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.session.review.review import ManeuverRow
from ui.dialogs.form_dialog import FieldMessage, repolish
from ui.display_style import DisplayStyle
from ui.review.maneuver_text import (
    GRADE_STATES,
    condition_text,
    grade_text,
    reasons_text,
    remarks_text,
    times_text,
    title_text,
)
from ui.translation import tr
from ui.widgets.flow_layout import FlowLayout
from ui.widgets.labels import create_label


class ManeuverDetails(QWidget):
    """Title, grade with its reasons, remarks; while an edge is dragged what it would be."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self._row: ManeuverRow | None = None
        self._hint = ""
        self._nothing = tr("No maneuver is chosen")
        self.setAccessibleName(tr("Selected maneuver"))
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        self._column = column
        holder = QWidget()
        self._line = FlowLayout(holder, spacing=look.px(12))
        policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        policy.setHeightForWidth(True)
        holder.setSizePolicy(policy)
        self.title = create_label("", "heading")
        self.grade = create_label("", "heading")
        self.times = create_label("", "number")
        for one in (self.title, self.grade, self.times):
            self._line.addWidget(one)
        column.addWidget(holder)
        self.reasons = create_label("", wrap=True, remarks_in=look)
        self.reasons.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        column.addWidget(self.reasons)
        self.remarks = create_label("", "muted", wrap=True, remarks_in=look)
        column.addWidget(self.remarks)
        self.message = FieldMessage()
        column.addWidget(self.message)
        self.message.hide()
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        self._column.setSpacing(self._look.px(2))
        self._line.setSpacing(self._look.px(12))
        self.show_row(self._row, self._hint)

    def show_row(self, row: ManeuverRow | None, hint: str = "") -> None:
        """Show a maneuver as it stands; None where none is looked at, with what to do then."""
        self._row, self._hint = row, hint
        if row is None:
            self.title.setText(self._nothing)
            for empty in (self.grade, self.times, self.remarks):
                empty.setText("")
            self.reasons.setText(hint)
        else:
            self._show(row.id, row.maneuver)
            self.remarks.setText(remarks_text(row))
        self.remarks.setVisible(bool(self.remarks.text()))

    def set_empty_title(self, title: str) -> None:
        self._nothing = title

    def show_edge_preview(self, maneuver: DetectedManeuver) -> None:
        self._show(maneuver.id if self._row is None else self._row.id, maneuver)

    def _show(self, name: str, maneuver: DetectedManeuver) -> None:
        self.title.setText(title_text(name, maneuver))
        self.grade.setText(tr("Grade {grade}").format(grade=grade_text(maneuver)))
        state = GRADE_STATES[maneuver.grade]
        if self.grade.property("state") != state:
            self.grade.setProperty("state", state)
            repolish(self.grade)
        self.times.setText(times_text(maneuver))
        condition = condition_text(maneuver, self._look.units)
        self.reasons.setText(f"{reasons_text(maneuver)} {condition}".strip())
        words = f"{self.title.text()}, {self.grade.text()}, {self.times.text()}. "
        self.setAccessibleDescription(words + self.reasons.text())

    def show_message(self, words: str, state: str = "") -> None:
        self.message.set_message(words, state)
        self.message.setVisible(bool(words))
