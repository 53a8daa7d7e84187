"""Before a calibration: what is in force and who calibrates. After it: what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QLabel,
    QLineEdit,
    QSizePolicy,
    QTableView,
    QWidget,
)

from gsapp.foundation import UnitError
from gsapp.quantities import channel, from_si, to_si
from ui.commands import shortcut_text
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.number_format import number_text, parse_number, unit_text
from ui.translation import tr
from ui.widgets.flow_layout import clear_layout
from ui.widgets.labels import CenteredPage, create_label
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import FittedTableView

if TYPE_CHECKING:
    from gsapp.session import Session


_TEMPERATURE = channel("temperature")


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentStatus:
    """How one instrument stands."""

    channel: str
    title: str
    """Its id and its name."""
    text: str
    """Since when it is calibrated, or that it is not."""
    is_calibrated: bool
    """Whether its certificate counts for a flight now."""


class InstrumentList(FittedTableView):
    """The instruments with their standing; one that is activated is calibrated again."""

    calibration_requested = Signal(str)  # channel

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style, tr("Instruments"), ("", ""), stretch=1, least=99, most=99)
        self.setFrameShape(QFrame.Shape.NoFrame)
        # The page scrolls; the list is as high as its rows.
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.menu.add_command(tr("Calibrate again"), self._calibrate)
        self.opened.connect(self._calibrate)

    def _fit_columns(self) -> None:
        # A wrapped cell tells Qt its height only.
        titles = [self._pixels(row.cells[0]) for row in self.row_model.rows]
        self.setColumnWidth(0, max(titles, default=0))

    def _calibrate(self) -> None:
        if self.selected_channel:
            self.calibration_requested.emit(self.selected_channel)

    @property
    def selected_channel(self) -> str:
        """Return the channel of the selected row; empty for none."""
        rows = self.selectionModel().selectedRows()
        return str(self.row_model.rows[rows[0].row()].key) if rows else ""

    def focusInEvent(self, event: QFocusEvent) -> None:
        # Nothing is selected by the keyboard's coming: Space is for all instruments then.
        QTableView.focusInEvent(self, event)

    def show_statuses(self, standings: Sequence[InstrumentStatus]) -> None:
        """Show the rows; the selection stays with its instrument."""
        self.show_rows(
            [
                TableRow(
                    key=one.channel,
                    cells=(f"{'✓' if one.is_calibrated else '▲'}  {one.title}", one.text),
                    state="good" if one.is_calibrated else "caution",
                    colored=frozenset({0, 1}),
                )
                for one in standings
            ]
        )
        self._fit_columns()

    def move_selection(self, rows: int) -> None:
        """Select the row so many below the selected one, and take the keyboard."""
        self.setFocus(Qt.FocusReason.OtherFocusReason)
        count = len(self.row_model.rows)
        if count:
            here = self.currentIndex().row() if self.selected_channel else -1
            at = here + rows if self.selected_channel or rows > 0 else count - 1
            self.selectRow(min(max(at, 0), count - 1))
            self.scroll_here()

    def scroll_here(self) -> None:
        """Bring the selected row into sight on the page that scrolls."""
        page = self.parentWidget()
        while page is not None and not isinstance(page, CenteredPage):
            page = page.parentWidget()
        if page is not None and (content := page.widget()) is not None:
            there = self.mapTo(content, self.visualRect(self.currentIndex()).center())
            page.ensureVisible(there.x(), there.y(), 0, self._style.px(40))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        key = Qt.Key(event.key())
        if key in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self.move_selection(-1 if key == Qt.Key.Key_Up else 1)
        elif key in (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter) and (
            self.selected_channel
        ):
            self._calibrate()
        else:
            event.ignore()


class WizardStartPanel(CenteredPage):
    """Says what is there and asks who calibrates; what can be done is in the actions below."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style, 860)
        self.setAccessibleName(tr("Calibration"))
        self.column.addWidget(create_label(tr("Calibration"), "title"))
        self.message = FieldMessage()
        self.message.setProperty("role", "")
        self.column.addWidget(self.message)
        self.resume = FieldMessage()
        self.resume.setProperty("role", "strong")
        self.column.addWidget(self.resume)
        self.column.addWidget(self._fields(style))
        self._card = QFrame()
        self._card.setObjectName("card")
        self._grid = QGridLayout(self._card)
        self.instruments = InstrumentList(style)
        self._grid.addWidget(self.instruments)
        self.column.addWidget(self._card)
        self.standings: tuple[InstrumentStatus, ...] | None = None
        style.changed.connect(self._restyle)
        self._restyle()

    def _fields(self, style: DisplayStyle) -> QWidget:
        holder = QWidget()
        grid = QGridLayout(holder)
        grid.setContentsMargins(0, style.px(4), 0, style.px(4))
        self.operator = QLineEdit()
        self.temperature = QLineEdit()
        for column, (name, field) in enumerate(
            ((tr("Calibrated by"), self.operator), (tr("Ground temperature"), self.temperature))
        ):
            title = create_label(name, "label")
            grid.addWidget(title, 0, column)
            field.setAccessibleName(name)
            grid.addWidget(field, 1, column)
            grid.setColumnStretch(column, 2 - column)
            high = QSizePolicy.Policy.Expanding
            field.setSizePolicy(high, high)
        # The last of the two.
        self._temperature_title = title
        self._unit = ""
        self._field_grid = grid
        return holder

    def _restyle(self) -> None:
        if not hasattr(self, "_card"):
            return
        px = self._style.px
        self._grid.setContentsMargins(px(16), px(10), px(16), px(10))
        self._field_grid.setHorizontalSpacing(px(16))
        # As high as its row: the style sheet knows a least height of its own.
        self._field_grid.setRowMinimumHeight(1, self._style.sizes.control)
        self._show_unit()

    def _show_unit(self) -> None:
        """Ask for the temperature in the units of the screen; what was typed is converted."""
        unit = _TEMPERATURE.display_unit(self._style.units)
        if unit == self._unit:
            return
        typed = parse_number(self.temperature.text().strip())
        if self._unit and typed is not None:
            kelvin = to_si(typed, self._unit, _TEMPERATURE.quantity)
            self.temperature.setText(number_text(from_si(kelvin, unit, _TEMPERATURE.quantity), 1))
        self._unit = unit
        name = tr("Ground temperature [{unit}]").format(unit=unit_text(unit))
        self._temperature_title.setText(name)
        self.temperature.setAccessibleName(name)

    @property
    def temperature_kelvin(self) -> float | None:
        """Return the temperature entered, K; None where there is none."""
        text = self.temperature.text().strip()
        if not text:
            return None
        value = parse_number(text)
        if value is None:
            degrees = (
                tr("degrees Celsius, such as 21.5")
                if self._unit == "degC"
                else (tr("degrees Fahrenheit, such as 70.5"))
            )
            raise UnitError(
                tr(
                    "the ground temperature '{text}' is not a number; write {degrees}, or nothing"
                ).format(text=text, degrees=degrees)
            )
        return float(to_si(value, self._unit, _TEMPERATURE.quantity))

    def suggest_operator(self, who: str) -> None:
        """Put the one who calibrated last into the field, if nobody is there yet."""
        if not self.operator.text():
            self.operator.setText(who)

    def show_statuses(self, standings: Sequence[InstrumentStatus]) -> None:
        """Show how every instrument stands."""
        if tuple(standings) == self.standings:
            return
        self.standings = tuple(standings)
        self._card.setVisible(bool(standings))
        self.instruments.show_statuses(standings)

    def show_connection(self, session: Session | None) -> None:
        """Say what to do, or what is missing for it."""
        connects = tr("{keys} connects one.").format(keys=shortcut_text("Ctrl+L"))
        if session is None:
            self.message.set_message(
                tr("No aircraft is connected: {connects}").format(connects=connects), "caution"
            )
        elif session.replay_feed is not None:
            text = tr("This is a replay: no aircraft to calibrate. {connects}").format(
                connects=connects
            )
            self.message.set_message(text, "caution")
        else:
            self.message.set_message(
                tr(
                    "Put the protractor on the surface shown, move it to each angle and hold it: "
                    "points are recorded automatically."
                )
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentOutcome:
    """What one instrument came to."""

    title: str
    text: str
    """Its name, and its curve and bounds, or that it is uncalibrated."""
    is_calibrated: bool
    """Whether it is calibrated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CombinedDeflection:
    """Surfaces that make one deflection, as they stand now."""

    title: str
    """Such as ``Elevator``."""
    parts: str
    """Left and right."""
    combined: str
    """The deflection that the equations of motion use, with its symbol."""
    rule: str
    """How it follows, with the number of the equation."""


class WizardSummaryPanel(CenteredPage):
    """Two tables: outcomes, and deflections as they are now."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style, 860)
        self.title = create_label("", "title")
        self.column.addWidget(self.title)
        self.message = create_label("", wrap=True)
        self.column.addWidget(self.message)
        self.outcomes: tuple[InstrumentOutcome, ...] = ()
        self._outcomes = _TableFrame(style)
        self.column.addWidget(self._outcomes)
        self._live_title = create_label(tr("Move the stick: left and right together"), "heading")
        self._live_title.hide()
        self.column.addWidget(self._live_title)
        self._together = _TableFrame(style)
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

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.setObjectName("card")
        self._grid = QGridLayout(self)
        self._cells: list[list[QLabel]] = []
        self._shape: tuple[object, ...] = ()
        style.changed.connect(self._restyle)
        self._restyle()
        self.hide()

    def _restyle(self) -> None:
        px = self._style.px
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
