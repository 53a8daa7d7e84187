"""The page of one instrument: what to do large on the left, points and curve beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QFrame, QScrollArea, QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.preflight.calibration_charts import CalibrationCharts
from ui.preflight.calibration_point_list import CalibrationPointList
from ui.preflight.surface_motion_view import SurfaceMotionView
from ui.preflight.wizard_figure import select_figure
from ui.preflight.wizard_prompt_view import WizardPromptView
from ui.preflight.wizard_rows import (
    WizardRemark,
    build_point_rows,
    build_quality_rows,
    list_remarks,
)
from ui.preflight.wizard_text import build_prompt
from ui.widgets.flow_layout import clear_layout
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import NameValueTable

if TYPE_CHECKING:
    from calibration.wizard import WizardView

_SIGNS = {"warning": "■", "caution": "▲", "plain": "·"}
_ROLES = {"warning": "strong", "caution": "strong", "plain": "muted"}
_MIN_HEIGHT = 216
"""Points of height from which the cue stays in sight while what is below it is scrolled."""
_SIDE_BY_SIDE_WIDTH = 860
"""Points of width from which the curve stands beside the cue."""


class RemarkList(QWidget):
    """Sentences that the crew should not pass over, each with its sign."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.shown: tuple[WizardRemark, ...] = ()
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self.hide()

    def show_remarks(self, remarks: tuple[WizardRemark, ...]) -> None:
        """Show other sentences."""
        if remarks == self.shown:
            return
        self.shown = remarks
        self._column.setSpacing(self._look.px(4))
        clear_layout(self._column)
        for state, sentence in remarks:
            line = create_label(f"{_SIGNS[state]} {sentence}", _ROLES[state], wrap=True)
            line.setProperty("state", state)
            self._column.addWidget(line)
        self.setVisible(bool(remarks))


class WizardCalibrationPanel(QWidget):
    """Shows a view of the wizard.

    Parameters
    ----------
    look : DisplayStyle
        Colors and sizes.

    Attributes
    ----------
    point_chosen : Signal(int)
        The mouse chose a point.
    """

    point_chosen = Signal(int)

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.prompt_view = WizardPromptView(look)
        self.motion_view = SurfaceMotionView(look)
        self.remarks = RemarkList(look)
        self.points = CalibrationPointList(look)
        self.points.point_selected.connect(self.point_chosen)
        self.quality = NameValueTable(look)
        self.charts = CalibrationCharts(look)
        self._box = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._left = QVBoxLayout()
        self._left.addWidget(self.prompt_view)
        self._below, self._below_column = _create_scroll_area()
        self._left.addWidget(self._below, 1)
        self._box.addLayout(self._left, 1)
        self._scroll, self._column = _create_scroll_area()
        self._column.addWidget(self.points)
        self._column.addWidget(self.charts, 1)
        # Takes the room only where the charts are not there.
        self._column.addStretch(0)
        self._box.addWidget(self._scroll, 1)
        self._wide = self._low = False
        self._arranged: tuple[bool, bool] | None = None
        self._beside = True
        look.changed.connect(self._fit)
        self._fit()

    def show_view(self, view: WizardView, choice: int | None, *, catching_up: bool) -> None:
        """Show a view, one of its points being chosen, perhaps while the flight is being read."""
        self.prompt_view.show_prompt(build_prompt(view, catching_up=catching_up))
        figure = select_figure(view)
        self.motion_view.show_figure(figure)
        self.remarks.show_remarks(list_remarks(view, self._look.units))
        rows = build_point_rows(view)
        self.points.show_rows(rows, choice)
        self.points.setVisible(bool(rows))
        self.quality.show_rows(build_quality_rows(view))
        by_hand = view.instrument is not None and view.instrument.is_angle_sensor
        drawn = by_hand and bool(view.points)
        self.charts.setVisible(drawn)
        if drawn:
            self.charts.show_view(view)
        self._beside = by_hand or bool(rows)
        self._scroll.setVisible(self._beside or not self._wide)

    def minimumSizeHint(self) -> QSize:
        return QSize(self._look.px(240), self._look.px(120))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        px = self._look.px
        margin = px(16)
        self._box.setContentsMargins(margin, px(8), margin, 0)
        self._box.setSpacing(px(24 if self.width() >= px(_SIDE_BY_SIDE_WIDTH) else 8))
        self._scroll.setMinimumHeight(px(40))
        self._left.setSpacing(px(8))
        self._below_column.setSpacing(px(8))
        self._column.setSpacing(px(12))
        self._column.setContentsMargins(0, 0, px(8), px(8))
        self._wide = self.width() >= px(_SIDE_BY_SIDE_WIDTH)
        self._low = not self._wide and self.height() < px(_MIN_HEIGHT)
        if (self._wide, self._low) != self._arranged:
            self._arranged = (self._wide, self._low)
            self._arrange()

    def _arrange(self) -> None:
        """Put everything where there is room for it; where there is least, in one column."""
        wide, low = self._wide, self._low
        side = QBoxLayout.Direction.LeftToRight
        self._box.setDirection(side if wide else QBoxLayout.Direction.TopToBottom)
        self._box.setStretch(0, 1 if wide else 0)
        self._below.setVisible(wide)
        self._scroll.setVisible(self._beside or not wide)
        self.prompt_view.set_compact(low=low)
        if low:
            self._column.insertWidget(0, self.prompt_view)
        else:
            self._left.insertWidget(0, self.prompt_view)
        for place, widget in enumerate((self.remarks, self.quality, self.motion_view)):
            if wide:
                self._below_column.addWidget(widget, 1 if widget is self.motion_view else 0)
            else:
                self._column.insertWidget(place + low, widget)

    def scroll_pages(self, pages: float) -> None:
        """Move what is below by parts of its height."""
        for area in (self._below, self._scroll):
            bar = area.verticalScrollBar()
            bar.setValue(bar.value() + round(pages * area.viewport().height()))


def _create_scroll_area() -> tuple[QScrollArea, QVBoxLayout]:
    """Return an area that scrolls down, and the column in it."""
    area = QScrollArea()
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setWidgetResizable(True)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    page = QWidget()
    page.setObjectName("page")
    area.setWidget(page)
    column = QVBoxLayout(page)
    column.setContentsMargins(0, 0, 0, 0)
    return area, column
