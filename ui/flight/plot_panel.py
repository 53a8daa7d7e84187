"""One plot beside the strip charts: spectrum, one channel over another, or the ground track."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFileDialog, QPushButton, QVBoxLayout, QWidget

from gsapp.quantities import channel, to_si
from ui.disk_checks import nearest_folder
from ui.display_style import DisplayStyle
from ui.strips.chart_annotations import ChartSpan
from ui.strips.pixel_columns import SampleSource
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import FlowLayout, arrange
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import LabeledComboBox

if TYPE_CHECKING:
    from ui.flight.map_background import MapBackground
    from ui.flight.plot_contents import PlotContent
    from ui.widgets.analysis_plot import AnalysisPlot

_CHOICES = 3  # Kind and two channels, of what was drawn.
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

    map_chosen = Signal(str)  # Path of the map below the ground track; empty for none.

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
        self._map_row = _MapRow(style)
        self._map_row.chosen.connect(self._change_map)
        column.addWidget(self._map_row)
        self._map_path = ""
        self._map: MapBackground | None = None
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
        self._map_row.setVisible(kind == "track")
        self._redraw()

    def _redraw(self) -> None:
        """Draw again as soon as samples are shown."""
        self._drawn, self._next = self._drawn[:_CHOICES], 0.0

    def set_map(self, path: str) -> None:
        """Show another map below the ground track, or none; it is opened when one is drawn."""
        if self._map is not None:
            self._map.deleteLater()
            self._map = None
        self._map_path = path
        self._map_row.show_path(path)
        self._redraw()

    def _change_map(self, path: str) -> None:
        self.set_map(path)
        self.map_chosen.emit(path)

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
        if choice[0] == "track" and self._map_path and self.plot is not None:
            state = (*state, *self.plot.edges)
        if (*choice, *state) == self._drawn:
            return
        is_again = self._drawn[:_CHOICES] == choice  # what the user has zoomed to stays
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
        self._draw_map(content)

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

    def _draw_map(self, content: PlotContent) -> None:
        """Draw the map below a ground track, and ask for the tiles that it requires."""
        plot, origin = self.plot, content.origin
        if plot is None:
            return
        if not self._map_path or origin is None:
            plot.show_pictures(())
            if self._map_path and self.kind.current_key == "track" and content.curves:
                self._add_note(tr("No map: the position on the ground is not known."))
            return
        if self._map is None:
            from ui.flight.map_background import MapBackground  # as above

            self._map = MapBackground(Path(self._map_path), self)
            self._map.loaded.connect(self._redraw)
        unit = float(to_si(1.0, channel("north").display_unit(self._style.units), "length"))
        west, south, east, north = (unit * edge for edge in plot.edges)
        pixel = (east - west) / max(plot.plot.width(), 1)
        self._map.request(origin, (west, south, east, north), pixel)
        plot.show_pictures(self._map.pictures(origin, unit))
        self._add_note(self._map.note)

    def _add_note(self, text: str) -> None:
        self.note.setText(" ".join(filter(None, (self.note.text(), text))))


class _MapRow(QWidget):
    """The file of the map, with buttons to choose another one and to remove it."""

    chosen = Signal(str)

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._path = ""
        row = FlowLayout(self, spacing=style.px(8))
        row.addWidget(create_label(tr("Map"), "label"))
        self._name = create_label("", "label")
        row.addWidget(self._name)
        self.choose = QPushButton(tr("Choose…"))
        self.choose.setAccessibleName(tr("Choose a map below the ground track"))
        self.choose.clicked.connect(self._choose)
        row.addWidget(self.choose)
        self.remove = QPushButton(tr("Remove"))
        self.remove.setAccessibleName(tr("Remove the map below the ground track"))
        self.remove.clicked.connect(lambda: self.chosen.emit(""))
        row.addWidget(self.remove)

    def show_path(self, path: str) -> None:
        self._path = path
        self._name.setText(Path(path).name if path else tr("none"))
        self.remove.setVisible(bool(path))

    def _choose(self) -> None:
        path, _kind = QFileDialog.getOpenFileName(
            self,
            tr("Map below the ground track"),
            str(nearest_folder(Path(self._path or "~").expanduser())),
            tr("Map tiles (*.mbtiles)"),
        )
        if path:
            self.chosen.emit(path)
