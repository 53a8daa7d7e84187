"""After a calibration: what each instrument came to, and left against right, live."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtWidgets import QFrame, QGridLayout, QLabel

from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.flow_layout import clear_layout
from ui.widgets.labels import CenteredPage, create_label


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentOutcome:
    """What one instrument came to.

    Attributes
    ----------
    title, text : str
        Its name, and its curve and bounds, or that it is uncalibrated.
    is_calibrated : bool
        Whether it is calibrated.
    """

    title: str
    text: str
    is_calibrated: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class CombinedDeflection:
    """Surfaces that make one deflection, as they stand now.

    Attributes
    ----------
    title : str
        Such as ``Elevator``.
    parts : str
        Left and right.
    combined : str
        The deflection that the equations of motion use, with its symbol.
    rule : str
        How it follows, with the number of the equation.
    """

    title: str
    parts: str
    combined: str
    rule: str


class WizardSummaryPanel(CenteredPage):
    """Two tables: outcomes, and deflections as they are now.

    Parameters
    ----------
    look : DisplayStyle
        Sizes.

    Attributes
    ----------
    outcomes : tuple of InstrumentOutcome
        As shown.
    """

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look, 860)
        self.title = create_label("", "title")
        self.column.addWidget(self.title)
        self.message = create_label("", wrap=True)
        self.column.addWidget(self.message)
        self.outcomes: tuple[InstrumentOutcome, ...] = ()
        self._outcomes = _TableFrame(look)
        self.column.addWidget(self._outcomes)
        self._live_title = create_label(tr("Move the stick: left and right together"), "heading")
        self._live_title.hide()
        self.column.addWidget(self._live_title)
        self._together = _TableFrame(look)
        self.column.addWidget(self._together)

    def show_outcomes(
        self, title: str, sentence: str, outcomes: Sequence[InstrumentOutcome]
    ) -> None:
        """Show what came of the instruments."""
        self.outcomes = tuple(outcomes)
        self.setAccessibleName(title)
        self.title.setText(title)
        self.message.setText(sentence)
        self._outcomes.show_rows(
            [
                ((sign, one.title, one.text), state)
                for one in outcomes
                for sign, state in [("✓", "good") if one.is_calibrated else ("▲", "caution")]
            ]
        )

    def show_deflections(self, deflections: Sequence[CombinedDeflection]) -> None:
        """Show the deflections as they are now."""
        self._live_title.setVisible(bool(deflections))
        self._together.show_rows(
            [((one.title, one.parts, one.combined, one.rule), "") for one in deflections]
        )


class _TableFrame(QFrame):
    """A framed table whose cells keep their labels while only their words change."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.setObjectName("card")
        self._grid = QGridLayout(self)
        self._cells: list[list[QLabel]] = []
        self._shape: tuple[object, ...] = ()
        look.changed.connect(self._restyle)
        self._restyle()
        self.hide()

    def _restyle(self) -> None:
        px = self._look.px
        self._grid.setContentsMargins(px(16), px(10), px(16), px(10))
        self._grid.setHorizontalSpacing(px(24))
        self._grid.setVerticalSpacing(px(6))

    def show_rows(self, rows: Sequence[tuple[Sequence[str], str]]) -> None:
        """Show rows of cells, each with its state."""
        shape = tuple((len(cells), state) for cells, state in rows)
        if shape != self._shape:
            self._shape = shape
            self._build(rows)
        for row, (cells, _) in enumerate(rows):
            for column, text in enumerate(cells):
                cell = self._cells[row][column]
                if cell.text() != text:
                    cell.setText(text)
        self.setVisible(bool(rows))

    def _build(self, rows: Sequence[tuple[Sequence[str], str]]) -> None:
        clear_layout(self._grid)
        self._cells = []
        for row, (cells, state) in enumerate(rows):
            line = []
            for column, _ in enumerate(cells):
                last = column == len(cells) - 1
                cell = create_label("", "" if last else "strong", wrap=last)
                if state and column != 1:
                    cell.setProperty("state", state)
                self._grid.addWidget(cell, row, column)
                line.append(cell)
            self._grid.setColumnStretch(len(cells) - 1, 1)
            self._cells.append(line)
