"""The debrief: every maneuver with verdict, reason and charts; score by card; trends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QScrollArea, QVBoxLayout, QWidget

from gsapp.excitation.debrief import Debrief, EvaluatedManeuver, FlightTrend
from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.pilot.debrief_charts import ManeuverCharts
from ui.pilot.debrief_text import (
    CARD_COLUMN_TITLES,
    TREND_COLUMN_TITLES,
    build_card_rows,
    build_maneuver_item,
    build_trend_rows,
    debrief_headline,
    list_verdict_reasons,
)
from ui.pilot.text_table import TextTable
from ui.translation import tr
from ui.widgets.labels import create_label
from ui.widgets.status_list import StatusListView

_SIDE_BY_SIDE_WIDTH: Final = 760
"""Points of width from which list and maneuver stand side by side."""
_SCROLL_STEP: Final = 60


class DebriefPage(QWidget):
    """Goes through the maneuvers of the open flight by keys.

    Parameters
    ----------
    look : DisplayStyle
        Colors, sizes, units.
    commands : sequence of QAction
        What the menu of the list offers for a maneuver.

    Attributes
    ----------
    changed : Signal
        Another maneuver is looked at, or there are others.
    """

    changed = Signal()

    def __init__(self, look: DisplayStyle, commands: Sequence[QAction] = ()) -> None:
        super().__init__()
        self.setObjectName("page")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName(tr("Debrief"))
        self._look = look
        self.debrief: Debrief | None = None
        self._shown: tuple[object, ...] = ()
        self._reading = False
        outer = QVBoxLayout(self)
        self.headline = create_label("", "heading", wrap=True)
        outer.addWidget(self.headline)
        self._row = QHBoxLayout()
        outer.addLayout(self._row, 1)
        self._outer = outer
        self.list = StatusListView(look, tr("Maneuvers"), commands)
        self.list.current_item_changed.connect(lambda _key: self._show_maneuver())
        self.list.item_activated.connect(lambda _key: self.focus_maneuver())
        self._row.addWidget(self.list, 2)
        self.scroll_area = QScrollArea()
        self.scroll_area.setProperty("role", "read")
        self.scroll_area.setWidgetResizable(True)
        self.scroll_area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.scroll_area.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.scroll_area.setAccessibleName(tr("The maneuver, the cards, the flights"))
        self._row.addWidget(self.scroll_area, 3)
        body = QWidget()
        body.setObjectName("page")
        self._column = QVBoxLayout(body)
        self.title = create_label("", "title", wrap=True)
        self.reasons = create_label("", wrap=True, remarks_in=look)
        self.charts = ManeuverCharts(look)
        self.cards = TextTable(look, tr("Score by card"), CARD_COLUMN_TITLES, 1)
        self.trends = TextTable(look, tr("From flight to flight"), TREND_COLUMN_TITLES, 3)
        for part in (self.title, self.reasons, self.charts, self.cards, self.trends):
            self._column.addWidget(part)
        self._column.addStretch(1)
        self.scroll_area.setWidget(body)
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._look.px
        self._outer.setContentsMargins(px(16), px(12), px(8), px(4))
        self._outer.setSpacing(px(8))
        self._row.setSpacing(px(12))
        self._column.setContentsMargins(0, 0, px(8), px(8))
        self._column.setSpacing(px(12))
        self._fit()
        self._shown = ()
        self.show_debrief(self.debrief)

    # What it shows

    def show_debrief(self, debrief: Debrief | None) -> None:
        """Show the debrief of a flight as far as it went."""
        self.debrief = debrief
        maneuvers = () if debrief is None else debrief.maneuvers
        state = (
            debrief is None, tuple(id(one) for one in maneuvers),
            () if debrief is None else debrief.cards, self._look.units,
        )  # fmt: skip
        if state == self._shown:
            return
        self._shown = state
        self.headline.setText(debrief_headline(debrief))
        self.list.set_items([build_maneuver_item(one, self._look.units) for one in maneuvers])
        self.cards.show_rows(build_card_rows(debrief), tr("This flight has no test cards."))
        self._show_maneuver()
        self.changed.emit()

    def show_trends(self, trends: Sequence[FlightTrend]) -> None:
        """Show flights in a row."""
        self.trends.show_rows(
            build_trend_rows(trends),
            tr("No flight in the catalog. {keys} saves this one.").format(
                keys=shortcut_text("Ctrl+S")
            ),
        )

    @property
    def current_maneuver(self) -> EvaluatedManeuver | None:
        """Return the maneuver that is looked at."""
        maneuvers = () if self.debrief is None else self.debrief.maneuvers
        key = self.list.current_key
        return next((one for one in maneuvers if one.verdict.id == key), None)

    def _show_maneuver(self) -> None:
        judged = self.current_maneuver
        self.charts.setVisible(judged is not None)
        self.reasons.setVisible(judged is not None)
        if judged is None:
            self.title.setText(tr("Inputs are listed here as they are flown"))
            return
        line = build_maneuver_item(judged, self._look.units)
        self.title.setText(f"{line.text}: {line.state_text}")
        self.reasons.setText(
            "\n".join(f"· {words}" for words in list_verdict_reasons(judged, self._look.units))
        )
        self.charts.show_maneuver(judged)
        self.changed.emit()

    # Keys

    def begin(self) -> None:
        """Put the keyboard into the list."""
        self._reading = False
        self._fit()
        self.list.setFocus()

    def focus_maneuver(self) -> None:
        """Go from the list to the maneuver; Esc comes back."""
        self._reading = True
        self._fit()
        self.scroll_area.setFocus()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        wide = self.width() >= self._look.px(_SIDE_BY_SIDE_WIDTH)
        self.list.setVisible(wide or not self._reading)
        self.scroll_area.setVisible(wide or self._reading)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        bar = self.scroll_area.verticalScrollBar()
        steps: dict[Qt.Key, Callable[[], int]] = {
            Qt.Key.Key_Down: lambda: self._look.px(_SCROLL_STEP),
            Qt.Key.Key_Up: lambda: -self._look.px(_SCROLL_STEP),
            Qt.Key.Key_PageDown: bar.pageStep,
            Qt.Key.Key_PageUp: lambda: -bar.pageStep(),
        }
        key = Qt.Key(event.key())
        if key == Qt.Key.Key_Escape:
            self.begin()
        elif key in steps:
            bar.setValue(bar.value() + steps[key]())
        else:
            super().keyPressEvent(event)
