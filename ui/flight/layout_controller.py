"""Which layout of charts a flight is shown with: shipped, saved, or the user's own choice."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from ui.flight.channel_panel import ChannelPanel
from ui.flight.chart_selection import (
    OVERVIEW_LAYOUT,
    SHIPPED_LAYOUT_NAMES,
    create_shipped_layout,
    rename_layout,
)
from ui.flight.flight_view_state import FlightViewState, origin_note
from ui.flight.layout_store import LayoutStore
from ui.settings import SettingsStore
from ui.strips.strip_chart import StripChart
from ui.strips.strip_layout import StripLayout
from ui.translation import QT_TR_NOOP, tr

_OWN_CHOICE = QT_TR_NOOP("Custom")


class LayoutController(QObject):
    """Keeps charts, channel panel and saved layouts in step."""

    layout_shown = Signal()  # The charts show other channels.

    def __init__(
        self,
        charts: StripChart,
        panel: ChannelPanel,
        store: SettingsStore,
        layouts: LayoutStore,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._charts = charts
        self._panel = panel
        self._store = store
        self._layouts = layouts
        self._name = store.current.layout or OVERVIEW_LAYOUT
        self._state = FlightViewState()
        self._is_new_flight = True
        charts.layout_changed.connect(self._follow_charts)
        panel.charts_changed.connect(self._choose_charts)
        panel.layout_chosen.connect(self.show_layout)
        panel.layout_saved.connect(self._save)
        panel.layout_deleted.connect(self._delete)

    def begin_flight(self) -> None:
        """Choose the charts again once the channels of another flight are known."""
        self._state = FlightViewState()
        self._is_new_flight = True

    def show_state(self, state: FlightViewState) -> None:
        """Follow the channels that a flight has."""
        former, self._state = self._state, state
        if self._is_new_flight and state.available:
            self._is_new_flight = False
            self.show_layout(self._name or OVERVIEW_LAYOUT)
        elif (state.available, state.present, state.sources, state.channels_known) != (
            former.available,
            former.present,
            former.sources,
            former.channels_known,
        ):
            if self._name in SHIPPED_LAYOUT_NAMES:
                self.show_layout(self._name)
            else:
                self._show_channels()

    def show_layout(self, name: str) -> None:
        available = self._state.available
        if self._state.channels_known:
            existing = self._state.present | self._state.uncalibrated
            available = tuple(known for known in available if known in existing)
        if name in SHIPPED_LAYOUT_NAMES:
            layout = create_shipped_layout(name, available)
        elif name in self._layouts.names:
            layout = self._layouts.load(name)
        else:
            name, layout = OVERVIEW_LAYOUT, create_shipped_layout(OVERVIEW_LAYOUT, available)
        self._store.change(layout=name)
        self._set_charts(layout, name)

    def _set_charts(self, layout: StripLayout, name: str) -> None:
        self._name = name
        name = name or tr(_OWN_CHOICE)
        self._charts.set_layout(rename_layout(layout, name, self._charts.view.window))
        self._charts.advance()
        self._show_channels()
        self.layout_shown.emit()

    def _choose_charts(self, layout: StripLayout) -> None:
        self._set_charts(layout, "")

    def _follow_charts(self, layout: StripLayout) -> None:
        """Follow a change made on the charts themselves."""
        if layout.name in SHIPPED_LAYOUT_NAMES:
            self._set_charts(layout, "")
            return
        self._show_channels()
        self.layout_shown.emit()

    def _save(self, name: str) -> None:
        layout = rename_layout(self._charts.strip_layout, name, self._charts.view.window)
        self._layouts.save(layout, name)
        self._store.change(layout=name)
        self._set_charts(layout, name)

    def _delete(self, name: str) -> None:
        if name in self._layouts.names:
            self._layouts.delete(name)
            self.show_layout(OVERVIEW_LAYOUT)

    def _show_channels(self) -> None:
        state = self._state
        notes = {}
        for name in state.available:
            source = state.sources.get(name)
            note = origin_note(source) if source is not None else ""
            if state.channels_known and name not in state.present | state.uncalibrated:
                note = tr("{note}, no samples").format(note=note) if note else tr("no samples")
            if note:
                notes[name] = note
        self._panel.show_channels(state.available, self._charts.strip_layout, notes)
        self._panel.show_layouts(self._layouts.names, self._name)
