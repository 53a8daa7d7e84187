"""Which channels the time line shows: a toggle for each, in the color of its line."""

from __future__ import annotations

from collections.abc import Collection

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QVBoxLayout, QWidget

from gsapp.quantities import channel, trace_color
from ui.display_style import DisplayStyle
from ui.number_format import symbol_text
from ui.review.timeline_charts import TIMELINE_CHANNELS
from ui.translation import tr
from ui.widgets.flow_layout import FlowLayout
from ui.widgets.labels import create_label


class ChannelToggles(QWidget):
    """Toggles that break into rows where the window is narrow."""

    selection_changed = Signal(object)
    """The channels to be shown, whether measured in this flight or not."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(look.px(6))
        column.addWidget(create_label(tr("Channels"), "heading"))
        holder = QWidget()
        flow = FlowLayout(holder, spacing=look.px(10))
        self.boxes: dict[str, QCheckBox] = {}
        for name in TIMELINE_CHANNELS:
            spec = channel(name)
            box = QCheckBox(symbol_text(spec.symbol))
            box.setAccessibleName(tr("Show {title}").format(title=spec.title.lower()))
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

    def set_selected_channels(self, channels: Collection[str]) -> None:
        """Show which channels are wanted; says nothing."""
        for name, box in self.boxes.items():
            box.blockSignals(True)
            box.setChecked(name in channels)
            box.blockSignals(False)

    def set_available_channels(self, channels: Collection[str]) -> None:
        for name, box in self.boxes.items():
            box.setVisible(name in channels)

    def _toggled(self) -> None:
        self.selection_changed.emit(
            tuple(name for name, box in self.boxes.items() if box.isChecked())
        )
