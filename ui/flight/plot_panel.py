"""One plot beside the strip charts: spectrum, one channel over another, or the ground track."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from PySide6.QtWidgets import QVBoxLayout, QWidget

from gsapp.quantities import channel
from ui.display_style import DisplayStyle
from ui.strips.chart_annotations import ChartSpan
from ui.strips.pixel_columns import SampleSource
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import LabeledComboBox

if TYPE_CHECKING:
    from ui.flight.plot_contents import PlotContent
    from ui.widgets.analysis_plot import AnalysisPlot

_INTERVAL = 1.0  # s between two drawings while samples arrive
_ALL_ROOM = 1000  # Share of the panel's height that the plot takes from the room below.
_USUAL_CHANNEL, _USUAL_OVER = "q", "alpha"
_KINDS: Final = (
    ("spectrum", QT_TR_NOOP("Spectrum")),
    ("channels", QT_TR_NOOP("Channel over channel")),
    ("track", QT_TR_NOOP("Ground track")),
)


class PlotPanel(QWidget):
    """Draws the stretch of the flight that the strip charts show, once a second."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._drawn: tuple[object, ...] = ()
        self._next = 0.0
        self._column = column = arrange(QVBoxLayout(self), 4, 12, 8, 12, 8)
        self.kind = LabeledComboBox(style, tr("Plot"))
        self.kind.set_choices([(key, tr(text)) for key, text in _KINDS], "spectrum")
        self.channel = LabeledComboBox(style, tr("Channel"))
        self.over = LabeledComboBox(style, tr("Over"))
        for choice in (self.kind, self.channel, self.over):
            column.addWidget(choice)
            choice.box.currentIndexChanged.connect(self._choose)
        self.note = create_label(tr("No samples yet."), "muted", wrap=True)
        column.addWidget(self.note)
        column.addStretch(1)
        self.plot: AnalysisPlot | None = None
        self.setFocusProxy(self.kind)
        self._choose()

    def _choose(self) -> None:
        kind = self.kind.current_key
        self.channel.setVisible(kind != "track")
        self.over.setVisible(kind == "channels")
        self._drawn, self._next = (), 0.0

    def show_flight(
        self, history: SampleSource | None, start: float, stop: float, spans: Sequence[ChartSpan]
    ) -> None:
        """Draw the samples between two flight times, s, if they may differ from those drawn.

        `spans`: maneuvers among them are drawn on the ground track.
        """
        now = time.monotonic()
        if history is None or not history.channels or not self.isVisible() or now < self._next:
            return
        self._next = now + _INTERVAL
        self._offer(history.channels)
        choice = (self.kind.current_key, self.channel.current_key, self.over.current_key)
        state = (start, stop, history.end, history.revision, self._style.units, *spans)
        if (*choice, *state) == self._drawn:
            return
        is_again = self._drawn[: len(choice)] == choice
        self._drawn = (*choice, *state)
        from ui.flight import plot_contents  # the window starts without it

        samples = plot_contents.PlottedSamples(
            history=history, start=start, stop=stop, units=self._style.units
        )
        kind, name, over = choice
        if kind == "track":
            content = plot_contents.track_content(samples, spans)
        elif kind == "channels":
            content = plot_contents.channels_content(samples, name, over)
        else:
            content = plot_contents.spectrum_content(samples, name)
        self._draw(content, is_track=kind == "track", keep_zoom=is_again)

    def _offer(self, channels: Sequence[str]) -> None:
        """Offer the channels that hold samples; those chosen stay."""
        choices = [(name, channel(name).title) for name in channels]
        for box, usual in ((self.channel, _USUAL_CHANNEL), (self.over, _USUAL_OVER)):
            box.set_choices(choices, box.current_key or usual)

    def _draw(self, content: PlotContent, *, is_track: bool, keep_zoom: bool) -> None:
        if self.plot is None:
            from ui.widgets.analysis_plot import AnalysisPlot  # as above

            self.plot = AnalysisPlot(self._style, tr("Plot"))
            self._column.insertWidget(self._column.count() - 1, self.plot, _ALL_ROOM)
        self.plot.lock_aspect(is_track)
        self.plot.draw(
            content.curves, title=content.title, bottom=content.bottom, left=content.left,
            keep_zoom=keep_zoom,
        )  # fmt: skip
        self.plot.setVisible(bool(content.curves))
        self.note.setText(content.note)
        self.note.setVisible(bool(content.note))
