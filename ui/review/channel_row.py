"""Which channels the time line shows: a toggle for each, in the color of its line."""

from __future__ import annotations

from collections.abc import Collection

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QVBoxLayout, QWidget

from gsapp.quantities import channel, trace_color
from ui.layouts import FlowLayout
from ui.look import Look
from ui.pages import label
from ui.review.timeline_lines import CHANNELS
from ui.words import symbol_text


class ChannelRow(QWidget):
    """Toggles that break into rows where the window is narrow.

    Parameters
    ----------
    look : Look
        Colors and sizes.

    Attributes
    ----------
    chosen : Signal(object)
        The channels to be shown, whether measured in this flight or not.
    """

    chosen = Signal(object)

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(look.px(6))
        column.addWidget(label("Channels", "heading"))
        holder = QWidget()
        flow = FlowLayout(holder, spacing=look.px(10))
        self.boxes: dict[str, QCheckBox] = {}
        for name in CHANNELS:
            spec = channel(name)
            box = QCheckBox(symbol_text(spec.symbol))
            box.setAccessibleName(f"Show {spec.title.lower()}")
            box.setToolTip(spec.title)
            box.toggled.connect(self._toggled)
            flow.addWidget(box)
            self.boxes[name] = box
        column.addWidget(holder)
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        for name, box in self.boxes.items():
            color = self._look.theme.trace(trace_color(name))
            box.setStyleSheet(f"QCheckBox {{ color: {color}; font-weight: 600; }}")

    def show_wanted(self, channels: Collection[str]) -> None:
        """Show which channels are wanted; says nothing."""
        for name, box in self.boxes.items():
            box.blockSignals(True)
            box.setChecked(name in channels)
            box.blockSignals(False)

    def show_measured(self, channels: Collection[str]) -> None:
        """Offer the channels that the flight has."""
        for name, box in self.boxes.items():
            box.setVisible(name in channels)

    def _toggled(self) -> None:
        self.chosen.emit(tuple(name for name, box in self.boxes.items() if box.isChecked()))
