"""Before a calibration: what is in force, who calibrates, and what can be begun."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
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
from ui.widgets.labels import CenteredPage, create_label
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import FittedTableView

if TYPE_CHECKING:
    from gsapp.session import Session

_TEMPERATURE = channel("temperature")


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentStatus:
    """How one instrument stands.

    Attributes
    ----------
    channel, title : str
        Its id and its name.
    text : str
        Since when it is calibrated, or that it is not.
    is_calibrated : bool
        Whether its certificate counts for a flight now.
    """

    channel: str
    title: str
    text: str
    is_calibrated: bool


class InstrumentList(FittedTableView):
    """The instruments with their standing; one that is activated is calibrated again.

    Parameters
    ----------
    look : DisplayStyle
        Colors and sizes.

    Attributes
    ----------
    calibration_requested : Signal(str)
        Channel to calibrate: Space or Enter, a double click, or the context menu.
    """

    calibration_requested = Signal(str)

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look, tr("Instruments"), ("", ""), stretch=1, least=99, most=99)
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
            page.ensureVisible(there.x(), there.y(), 0, self._look.px(40))

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
    """Says what is there and asks who calibrates; what can be done is in the actions below.

    Parameters
    ----------
    look : DisplayStyle
        Sizes and units.
    """

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look, 860)
        self.setAccessibleName(tr("Calibration"))
        self.column.addWidget(create_label(tr("Calibration"), "title"))
        self.message = FieldMessage()
        self.message.setProperty("role", "")
        self.column.addWidget(self.message)
        self.resume = FieldMessage()
        self.resume.setProperty("role", "strong")
        self.column.addWidget(self.resume)
        self.column.addWidget(self._fields(look))
        self._card = QFrame()
        self._card.setObjectName("card")
        self._grid = QGridLayout(self._card)
        self.instruments = InstrumentList(look)
        self._grid.addWidget(self.instruments)
        self.column.addWidget(self._card)
        self.standings: tuple[InstrumentStatus, ...] | None = None
        look.changed.connect(self._restyle)
        self._restyle()

    def _fields(self, look: DisplayStyle) -> QWidget:
        holder = QWidget()
        grid = QGridLayout(holder)
        grid.setContentsMargins(0, look.px(4), 0, look.px(4))
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
        px = self._look.px
        self._grid.setContentsMargins(px(16), px(10), px(16), px(10))
        self._field_grid.setHorizontalSpacing(px(16))
        # As high as its row: the style sheet knows a least height of its own.
        self._field_grid.setRowMinimumHeight(1, self._look.sizes.control)
        self._show_unit()

    def _show_unit(self) -> None:
        """Ask for the temperature in the units of the screen; what was typed is converted."""
        unit = _TEMPERATURE.display_unit(self._look.units)
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
        """Return the temperature entered, K; None where there is none.

        Raises
        ------
        UnitError
            If what was entered is no number.
        """
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
            words = tr("This is a replay: no aircraft to calibrate. {connects}").format(
                connects=connects
            )
            self.message.set_message(words, "caution")
        else:
            self.message.set_message(
                tr(
                    "Put the protractor on the surface shown, move it to each angle and hold it: "
                    "points are recorded automatically."
                )
            )
