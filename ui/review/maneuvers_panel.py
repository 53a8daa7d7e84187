"""How the page of maneuvers is laid out: time line and flights side by side, the table below."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.review.channel_toggles import ChannelToggles
from ui.review.flights_panel import FlightsPanel
from ui.review.maneuver_details import ManeuverDetails
from ui.review.maneuver_toolbar import ManeuverToolbar
from ui.review.maneuvers_table import ManeuversTable
from ui.review.timeline import Timeline
from ui.widgets.layout_widgets import StackingColumns

_MENU_COMMANDS = (
    "review_zoom", "review_in_use", "review_grade", "review_rename", "review_note", "review_merge",
    "review_remove_maneuver",
)  # fmt: skip
"""Commands in the menu of a maneuver."""


class ManeuversPanel(QScrollArea):
    """All parts of the page; it scrolls where the window is small for its scale."""

    def __init__(self, actions: Mapping[str, QAction], look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.details = ManeuverDetails(look)
        self.timeline = Timeline(look)
        self.bar = ManeuverToolbar(actions, look)
        self.panel = FlightsPanel(actions, look)
        self.channels = ChannelToggles(look)
        self.table = ManeuversTable(look, [actions[name] for name in _MENU_COMMANDS])
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        body = QWidget()
        body.setObjectName("page")
        self.setWidget(body)
        self._column = QVBoxLayout(body)
        # What one works on stands first, also where the window is narrow.
        pair = StackingColumns(look, (7, 2))
        pair.left.addWidget(self.details)
        pair.left.addWidget(self.timeline, 1)
        pair.left.addWidget(self.bar)
        pair.right.addWidget(self.panel)
        pair.right.addWidget(self.channels)
        pair.right.addStretch(1)
        self._column.addWidget(pair, 3)
        self._column.addWidget(self.table, 1)
        self._rest = QWidget()
        pair.left.addWidget(self._rest, 1)
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._look.px
        self._column.setContentsMargins(px(16), px(10), px(16), px(10))
        self._column.setSpacing(px(8))

    def set_flight_known(self, *, known: bool) -> None:
        """Show the parts that work on a flight, where one is known: empty ones say nothing."""
        for part in (self.timeline, self.bar, self.channels, self.table):
            part.setVisible(known)
        self._rest.setVisible(not known)

    def show_table(self) -> None:
        bar = self.verticalScrollBar()
        bar.setValue(bar.maximum())
