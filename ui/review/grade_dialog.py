"""Asks for a grade given by a person, and why."""

from __future__ import annotations

from PySide6.QtWidgets import QComboBox, QLineEdit, QWidget

from gsapp.flight.maneuvers.detected_maneuver import GRADED_BY_CREW, GRADES, DetectedManeuver, Grade
from ui.dialogs.form_dialog import FormDialog
from ui.display_style import DisplayStyle
from ui.translation import tr


class GradeDialog(FormDialog):
    """A grade from A to D, or the one that the samples give; and a reason."""

    def __init__(
        self,
        look: DisplayStyle,
        name: str,
        maneuver: DetectedManeuver,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            tr("Set the grade"),
            tr(
                "Maneuver {name} has grade {grade}. A manual grade stays when the edges "
                "move; unfit (D) excludes it from estimates."
            ).format(name=name, grade=maneuver.grade),
            tr("Grade"),
            look,
            parent,
        )
        self.choice = QComboBox()
        self.choice.setAccessibleName(tr("Grade"))
        for grade, words in GRADES.items():
            self.choice.addItem(f"{grade}  {words.partition(':')[0]}", grade)
        self.choice.addItem(tr("Automatic grade"), "")
        self.choice.setCurrentIndex(list(GRADES).index(maneuver.grade))
        self.reason = QLineEdit(
            "; ".join(maneuver.reasons) if maneuver.graded_by == GRADED_BY_CREW else ""
        )
        self.reason.setAccessibleName(tr("Reason"))
        self.reason.setPlaceholderText(tr("A gust, hands on the sticks …"))
        self.add_row(tr("Grade"), self.choice)
        self.add_row(tr("Reason"), self.reason)
        self.choice.setFocus()
        self.fit_to_content(480)

    @property
    def grade(self) -> Grade | None:
        return self.choice.currentData() or None
