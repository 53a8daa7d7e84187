"""The pages of the window, and the rail on the left that leads to them."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QAbstractButton, QButtonGroup, QSizePolicy, QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.icons import paint_icon
from ui.shortcut_filter import ArrowKeyNavigation
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import arrange
from ui.window_frame.attitude_indicator import AttitudeIndicator


@dataclass(frozen=True, slots=True, kw_only=True)
class PageInfo:
    """One place on the rail."""

    id: str  # Name in code; ``place_<id>`` is the command that goes there.
    title: str  # Word on the rail.
    shortcut: str  # Key that goes there.
    purpose: str  # What the place is for, one sentence.


PAGES = tuple(
    PageInfo(id=page_id, title=title, shortcut=f"F{number}", purpose=purpose)
    for number, (page_id, title, purpose) in enumerate((
        ("preflight", QT_TR_NOOP("Preflight"), QT_TR_NOOP(
            "Calibrate the surfaces and vanes, and check the aircraft before take-off."
        )),
        ("flight", QT_TR_NOOP("Flight"), QT_TR_NOOP("Watch the flight on strip charts.")),
        ("pilot", QT_TR_NOOP("Pilot"), QT_TR_NOOP(
            "Large cues for the pilot, readable from three meters: trim, speed, next maneuver."
        )),
        ("review", QT_TR_NOOP("Review"), QT_TR_NOOP(
            "Cut the maneuvers, estimate the derivatives, and compare the models."
        )),
        ("gap", QT_TR_NOOP("Model gap"), QT_TR_NOOP(
            "Find where simulation and measurement disagree, and which effect the model lacks."
        )),
    ), start=1)
)  # fmt: skip
"""From top to bottom."""


class ExclusiveButtonGroup(QButtonGroup):
    """Buttons of which Tab stops at the chosen one; arrows lead to the others.

    Left to itself Qt stops at the first, and from then on at the one that had the keyboard last:
    not at the place that is on screen.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.buttonToggled.connect(_set_tab_stop)

    def add_button(self, button: QAbstractButton) -> None:
        """Add a button that is not chosen yet."""
        self.addButton(button)
        _set_tab_stop(button, chosen=False)


def _set_tab_stop(button: QAbstractButton, chosen: bool) -> None:
    others = button.focusPolicy() & ~Qt.FocusPolicy.TabFocus
    button.setFocusPolicy(others | Qt.FocusPolicy.TabFocus if chosen else others)


_NARROW = 800


class NavigationButton(QAbstractButton, ArrowKeyNavigation):
    """One place on the rail."""

    def __init__(self, place: PageInfo, style: DisplayStyle) -> None:
        super().__init__()
        self.page = place
        self._style = style
        self.narrow = False
        self.setCheckable(True)
        self.setText(tr(place.title))
        self.setAccessibleName(f"{self.text()}, {place.shortcut}")
        self.setToolTip(f"{self.text()} ({place.shortcut}): {tr(place.purpose)}")
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        style = self._style
        return (
            QSize(style.px(48), style.px(48)) if self.narrow else QSize(style.px(80), style.px(64))
        )

    def paintEvent(self, _event: QPaintEvent) -> None:
        style, box = self._style, QRectF(self.rect())
        painter = QPainter(self)
        chosen = self.isChecked()
        if chosen or self.underMouse():
            painter.fillRect(box, style.color("chosen" if chosen else "hover"))
        if chosen:
            painter.fillRect(QRectF(0, 0, style.px(3), box.height()), style.color("accent"))
        ink: QColor = style.color("text" if chosen else "muted")
        side = style.px(24)
        top = (box.height() - side) / 2 if self.narrow else style.px(8)
        paint_icon(painter, self.page.id, QRectF((box.width() - side) / 2, top, side, side), ink)
        if not self.narrow:
            painter.setPen(ink)
            painter.setFont(style.font("label", strong=chosen))
            line = QRectF(0, style.px(34), box.width(), style.px(14))
            painter.drawText(line, Qt.AlignmentFlag.AlignCenter, self.text())
            painter.setPen(style.color("muted"))
            painter.setFont(style.font("small"))
            line = QRectF(0, style.px(47), box.width(), style.px(13))
            painter.drawText(line, Qt.AlignmentFlag.AlignCenter, self.page.shortcut)
        if self.hasFocus():
            painter.setPen(style.color("accent"))
            painter.drawRect(box.adjusted(1, 1, -2, -2))
        painter.end()


class NavigationRail(QWidget):
    """The five places, top to bottom."""

    page_selected = Signal(str)  # Id of the place the user pressed.

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.setObjectName("rail")
        self.setAccessibleName(tr("Places"))
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        column = arrange(QVBoxLayout(self), 0)
        self.buttons: dict[str, NavigationButton] = {}
        self._group = ExclusiveButtonGroup(self)
        for place in PAGES:
            button = NavigationButton(place, style)
            button.clicked.connect(
                lambda _checked=False, name=place.id: self.page_selected.emit(name)
            )
            self._group.add_button(button)
            column.addWidget(button)
            self.buttons[place.id] = button
        column.addStretch(1)
        self.attitude = AttitudeIndicator(style)
        column.addWidget(self.attitude)
        style.changed.connect(self._refresh)

    def show_page(self, place_id: str) -> None:
        self.buttons[place_id].setChecked(True)

    def fit(self, window_width: int) -> None:
        """Drop the words where the window is narrow for its scale."""
        narrow = window_width < self._style.px(_NARROW)
        if any(button.narrow != narrow for button in self.buttons.values()):
            for button in self.buttons.values():
                button.narrow = narrow
            self._refresh()

    def _refresh(self) -> None:
        for button in self.buttons.values():
            button.updateGeometry()
            button.update()
