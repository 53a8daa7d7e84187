"""Before a calibration: what is in force, who calibrates, and what can be begun."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtGui import QBrush, QKeyEvent
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QLineEdit,
    QMenu,
    QSizePolicy,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from gsapp.foundation import UnitError
from gsapp.quantities import channel, from_si, to_si
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.number_format import number_text, parse_number, unit_text
from ui.widgets.labels import CenteredPage, create_label

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


class InstrumentList(QTreeWidget):
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
        super().__init__()
        self._look = look
        self.setAccessibleName("Instruments")
        self.setColumnCount(2)
        self.setHeaderHidden(True)
        self.setRootIsDecorated(False)
        self.setIndentation(0)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWordWrap(True)
        # The page scrolls; the list is as high as its rows.
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.customContextMenuRequested.connect(self._show_menu)
        self.itemDoubleClicked.connect(
            lambda item, _column: self.calibration_requested.emit(_item_channel(item))
        )

    @property
    def selected_channel(self) -> str:
        """Return the channel of the selected row; empty for none."""
        return "".join(_item_channel(item) for item in self.selectedItems())

    def show_statuses(self, standings: Sequence[InstrumentStatus]) -> None:
        """Show the rows; the selection stays with its instrument."""
        chosen = self.selected_channel
        self.clear()
        for standing in standings:
            sign = "✓" if standing.is_calibrated else "▲"
            item = QTreeWidgetItem([f"{sign}  {standing.title}", standing.text])
            item.setData(0, Qt.ItemDataRole.UserRole, standing.channel)
            item.setToolTip(1, standing.text)
            color = self._look.state_color("good" if standing.is_calibrated else "caution")
            item.setForeground(0, QBrush(color))
            item.setForeground(1, QBrush(color))
            self.addTopLevelItem(item)
            if standing.channel == chosen:
                self.setCurrentItem(item)
        self.fit()

    def fit(self) -> None:
        """Take the height of all rows."""
        self.resizeColumnToContents(0)
        row = self.sizeHintForRow(0) if self.topLevelItemCount() else 0
        self.setFixedHeight(row * self.topLevelItemCount() + self._look.px(4))

    def move_selection(self, rows: int) -> None:
        """Select the row so many below the selected one, and take the keyboard."""
        self.setFocus(Qt.FocusReason.OtherFocusReason)
        count = self.topLevelItemCount()
        if count:
            here = self.indexOfTopLevelItem(self.currentItem()) if self.selected_channel else -1
            at = here + rows if self.selected_channel or rows > 0 else count - 1
            self.setCurrentItem(self.topLevelItem(min(max(at, 0), count - 1)))
            self.scroll_here()

    def scroll_here(self) -> None:
        """Bring the selected row into sight on the page that scrolls."""
        page = self.parentWidget()
        while page is not None and not isinstance(page, CenteredPage):
            page = page.parentWidget()
        if page is not None:
            spot = self.visualItemRect(self.currentItem()).center()
            there = self.mapTo(page.widget(), spot)
            page.ensureVisible(there.x(), there.y(), 0, self._look.px(40))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Act on the row; letters are keys of the page, no search."""
        key = Qt.Key(event.key())
        if key in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self.move_selection(-1 if key == Qt.Key.Key_Up else 1)
        elif (
            key in (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.selected_channel
        ):
            self.calibration_requested.emit(self.selected_channel)
        else:
            event.ignore()

    def _show_menu(self, spot: QPoint) -> None:
        item = self.itemAt(spot)
        if item is not None:
            self.setCurrentItem(item)
            menu = QMenu(self)
            menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
            menu.addAction(
                "Calibrate again", lambda: self.calibration_requested.emit(self.selected_channel)
            )
            menu.popup(self.viewport().mapToGlobal(spot))


def _item_channel(item: QTreeWidgetItem) -> str:
    return str(item.data(0, Qt.ItemDataRole.UserRole))


class WizardStartPanel(CenteredPage):
    """Says what is there and asks who calibrates; what can be done is in the actions below.

    Parameters
    ----------
    look : DisplayStyle
        Sizes and units.
    """

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look, 860)
        self.setAccessibleName("Calibration")
        self.column.addWidget(create_label("Calibration", "title"))
        self.sentence = FieldMessage()
        self.sentence.setProperty("role", "")
        self.column.addWidget(self.sentence)
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
        self.who = QLineEdit()
        self.temperature = QLineEdit()
        for column, (name, field) in enumerate(
            (("Who calibrates", self.who), ("Ground temperature", self.temperature))
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
        if self.standings:
            self.instruments.show_statuses(self.standings)

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
        name = f"Ground temperature [{unit_text(unit)}]"
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
                "degrees Celsius, such as 21.5"
                if self._unit == "degC"
                else ("degrees Fahrenheit, such as 70.5")
            )
            raise UnitError(
                f"the ground temperature '{text}' is not a number; write {degrees}, or nothing"
            )
        return float(to_si(value, self._unit, _TEMPERATURE.quantity))

    def suggest_operator(self, who: str) -> None:
        """Put the one who calibrated last into the field, if nobody is there yet."""
        if not self.who.text():
            self.who.setText(who)

    def show_statuses(self, standings: Sequence[InstrumentStatus]) -> None:
        """Show how every instrument stands."""
        if tuple(standings) == self.standings:
            return
        self.standings = tuple(standings)
        self._card.setVisible(bool(standings))
        self.instruments.show_statuses(standings)
