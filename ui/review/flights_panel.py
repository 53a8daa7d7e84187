"""The flights under review: chosen, added, taken out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QPushButton, QVBoxLayout, QWidget

from gsapp.session.review.review import Review
from gsapp.session.review.reviewed_flight import ReviewedFlight
from ui.commands import action_hint
from ui.display_style import DisplayStyle
from ui.number_format import count_text, join_sentences
from ui.review.maneuver_text import grade_counts_text
from ui.translation import tr
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import create_button_row
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import BoxedListView

_MAX_REMARKS = 3
"""Remarks on a flight in sight; the others are in the tool tip."""


class FlightsPanel(QWidget):
    """The flights with their maneuvers and grades, what is to be said of the one chosen."""

    flight_selected = Signal(int)

    def __init__(self, actions: Mapping[str, QAction], look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        self._column = column
        column.addWidget(create_label(tr("Flights"), "heading"))
        self.flights = BoxedListView(look, tr("Flights under review"))
        self.flights.row_changed.connect(self.flight_selected.emit)
        column.addWidget(self.flights)
        self.status = create_label("", "muted", wrap=True, remarks_in=look)
        column.addWidget(self.status)
        self.buttons: dict[str, QPushButton] = {}
        names = ("review_add_open", "review_add_folder", "review_add_files", "review_take_out",
                 "review_trial")  # fmt: skip
        for name in names:
            self.buttons[name] = create_command_button(actions[name])
        column.addWidget(create_button_row(look, *self.buttons.values()))
        column.addStretch(1)
        self.flights.deleted.connect(lambda _key: actions["review_take_out"].trigger())
        look.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        self._column.setSpacing(self._look.px(6))

    def show_flights(self, review: Review, place: int, doing: str) -> None:
        """Show the flights, one of them chosen, and what is being opened."""
        flights = review.flights
        rows = []
        for row, flight in enumerate(flights):
            count = count_text(len(flight.maneuvers), "maneuver")
            words = f"{row + 1}  {review.title(flight)}   {count}"
            detail = f"{flight.path}\n{count}: {grade_counts_text(flight.maneuvers)}"
            rows.append(TableRow(key=row, cells=(words,), detail=detail))
        self.flights.blockSignals(True)
        self.flights.show_rows(rows)
        if self.flights.current_key() != place:
            self.flights.select_row(place)
        self.flights.blockSignals(False)
        self.flights.setVisible(bool(flights))
        self.buttons["review_trial"].setVisible(not flights)
        if doing:
            self._set_status(doing)
        elif not flights:
            self._set_status(
                tr("No flight yet. Add one: a flight folder, or a file (tlog, bin, ulg, csv, mat).")
            )
        else:
            self._show_remarks(flights[place])

    def _show_remarks(self, flight: ReviewedFlight) -> None:
        """Tell grades and the latest remarks: what was changed by hand is said last."""
        grades = grade_counts_text(flight.maneuvers)
        said = flight.remarks[::-1]
        more = max(len(said) - _MAX_REMARKS, 0)
        lines = (
            tr("grades: {grades}").format(grades=grades) if grades else "",
            *said[:_MAX_REMARKS],
            tr("{remarks} more").format(remarks=count_text(more, "remark")) if more else "",
        )
        self._set_status(join_sentences(lines), flight.remarks)

    def _set_status(self, words: str, remarks: Sequence[str] = ()) -> None:
        self.status.setText(words)
        self.status.setToolTip("\n".join(remarks))
        self.status.setAccessibleDescription(join_sentences(remarks))

    def set_open_flight_available(self, offered: bool) -> None:
        self.buttons["review_add_open"].setVisible(offered)

    @property
    def has_keyboard(self) -> bool:
        return any(button.hasFocus() for button in self.buttons.values())


def create_command_button(action: QAction, *, quiet: bool = False) -> QPushButton:
    """Return a button that does what a command does, gray when the command is."""
    words = action.text()
    button = QPushButton(words)
    button.setAccessibleName(words.rstrip("…"))
    if quiet:
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    button.clicked.connect(action.trigger)

    def follow() -> None:
        button.setEnabled(action.isEnabled())
        button.setToolTip(action_hint(action))

    action.changed.connect(follow)
    follow()
    return button
