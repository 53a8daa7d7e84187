"""The Flight place: the three choices of an empty window, or the flight that is open."""

from __future__ import annotations

from PySide6.QtWidgets import QStackedWidget

from ui.flight.flight_view import FlightView
from ui.start_page import StartPage


class FlightPage(QStackedWidget):
    """Shows the start page until a flight is open."""

    def __init__(self, start: StartPage, view: FlightView) -> None:
        super().__init__()
        self.start = start
        self.view = view
        self.addWidget(start)
        self.addWidget(view)

    def show_flight(self, shown: bool) -> None:
        self.setCurrentWidget(self.view if shown else self.start)

    def begin(self) -> None:
        """Put the keyboard into the charts, or the start page."""
        (self.view.charts if self.currentWidget() is self.view else self.start).setFocus()
