"""A flight on screen: the charts with their menu, the controls below, the panels beside."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from functools import partial
from pathlib import Path

from PySide6.QtCore import QPoint, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QFontMetricsF, QGuiApplication, QResizeEvent
from PySide6.QtWidgets import QMenu, QSplitter, QTabWidget, QVBoxLayout, QWidget

from gsapp.foundation import FlightError
from gsapp.quantities import ChannelSpec, channel
from ui.commands import CHART_PREFIX
from ui.dialogs.file_dialogs import ask_save_file
from ui.display_style import DisplayStyle
from ui.flight.channel_panel import ChannelPanel
from ui.flight.chart_layouts import LayoutController, LayoutStore
from ui.flight.controls import ControlRow, ReplayBar
from ui.flight.estimates_panel import EstimatesPanel
from ui.flight.flight_view_state import FlightViewState
from ui.flight.panel_rows import build_cursor_value_rows, cursor_times_text
from ui.flight.plot_panel import PlotPanel
from ui.flight.side_panels import AlarmsPanel, MarksPanel, MessagesPanel, ValuesPanel
from ui.number_format import channel_value_text, clock_text, floor_percent
from ui.settings import SettingsStore
from ui.strips.chart_keys import KEY_ACTIONS
from ui.strips.pixel_columns import SampleSource
from ui.strips.strip_chart import StripChart
from ui.strips.strip_layout import MAX_TRACES
from ui.style_sheet import TAB_MARGIN
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import arrange

_ZOOM_MARGIN = 1.2  # Time in sight beside a maneuver that is zoomed to, times its length.


def create_chart_menu(
    charts: StripChart,
    picture: FlightViewState,
    actions: Mapping[str, QAction],
    time: float | None,
    units: str,
    parent: QWidget,
) -> QMenu:
    """Return the menu of the selected chart.

    `time`: flight time under the pointer, s.
    """
    menu = QMenu(parent)
    chart = charts.model.selected_chart
    if chart is not None:
        if time is not None:
            for spec in chart.specs:
                text = channel_value_text(spec, charts.model.value_at(spec.id, time), units)
                menu.addAction(
                    tr("Copy {title} {text}").format(title=spec.title, text=text),
                    partial(_copy_text, text),
                )
        menu.addAction(tr("Hide {title}").format(title=chart.specs[0].title), charts.editor.hide)
        menu.addAction(actions["chart_enlarge"])
        _add_channel_actions(menu, charts, chart.specs, picture.present)
        menu.addSeparator()
        auto = menu.addAction(tr("Autoscale"), lambda: charts.editor.set_range(None))
        auto.setEnabled(chart.strip.range != "auto")
        menu.addAction(actions["type_range"])
        menu.addAction(actions["type_limits"])
        menu.addSeparator()
    if time is not None:
        at = clock_text(time, decimals=1)
        menu.addAction(tr("Mark {at}").format(at=at), lambda: charts.mark_requested.emit(time))
        menu.addAction(
            tr("Set A at {at}").format(at=at), lambda: charts.navigator.set_cursor("a", time)
        )
        menu.addAction(
            tr("Set B at {at}").format(at=at), lambda: charts.navigator.set_cursor("b", time)
        )
        for span in picture.spans:
            if span.stop is not None and span.start <= time <= span.stop:
                menu.addAction(
                    tr("Zoom to {label}").format(label=span.label),
                    partial(zoom_to, charts, span.start, span.stop),
                )
    a, b = charts.view.cursors.get("a"), charts.view.cursors.get("b")
    if a is not None and b is not None and a != b:
        menu.addAction(tr("Zoom to A and B"), lambda: zoom_to(charts, min(a, b), max(a, b)))
    menu.addAction(actions["chart_clear"])
    menu.addSeparator()
    menu.addAction(tr("Copy picture"), lambda: QGuiApplication.clipboard().setPixmap(charts.grab()))
    menu.addAction(tr("Save as…"), lambda: export_chart_image(charts))
    return menu


def _add_channel_actions(
    menu: QMenu, charts: StripChart, shown: Sequence[ChannelSpec], present: AbstractSet[str]
) -> None:
    """Offer further channels of the same quantity for a chart, and to take one out of several."""
    names = [spec.id for spec in shown]
    others = [
        spec
        for spec in map(channel, sorted(present - set(names)))
        if spec.quantity == shown[0].quantity
    ]
    if others and len(names) < MAX_TRACES:
        further = menu.addMenu(tr("Add channel"))
        for spec in others:
            further.addAction(spec.title, partial(charts.editor.set_channels, [*names, spec.id]))
    if len(names) > 1:
        for spec in shown:
            rest = [name for name in names if name != spec.id]
            menu.addAction(
                tr("Remove {title}").format(title=spec.title),
                partial(charts.editor.set_channels, rest),
            )


def _copy_text(text: str) -> None:
    QGuiApplication.clipboard().setText(text)


def zoom_to(charts: StripChart, start: float, stop: float) -> None:
    """Show a stretch of the flight (s) with some room on either side."""
    charts.navigator.set_window(_ZOOM_MARGIN * (stop - start))
    charts.navigator.go_to((start + stop) / 2.0)


def export_chart_image(charts: StripChart) -> None:
    """Write the charts as they are on screen into a file."""
    picture = charts.grab()  # before the dialog stands over it
    path = ask_save_file(
        charts, tr("Save the charts"), Path.home() / "charts.png", tr("Picture (*.png)")
    )
    if path is not None and not picture.save(str(path)):
        raise FlightError(tr("{path} cannot be written; choose another folder").format(path=path))


_PANEL_WIDTH = 344  # Points of the side panel, if the words of its tabs are not longer.
_ALARMS = QT_TR_NOOP("Alarms")
_TAB_NAMES = (
    QT_TR_NOOP("Channels"), QT_TR_NOOP("Values"), QT_TR_NOOP("Marks"), _ALARMS,
    QT_TR_NOOP("Messages"), QT_TR_NOOP("Derivatives"), QT_TR_NOOP("Plot"),
)  # fmt: skip
_PANEL_STEP = 32  # Points by which a key widens it.
_PANEL_MIN_WIDTH = 1000
_CHARTS_MIN_WIDTH = 420
_RESIZE_SAVE_MS = 300
"""From the last move of the edge of the side panel until its width is written down."""


class FlightView(QWidget):
    """Charts, controls and panels of the open flight."""

    mark_requested = Signal(float)  # Mark this flight time, s.
    show_requested = Signal()  # A panel is asked for while another place is on screen.

    def __init__(
        self,
        actions: Mapping[str, QAction],
        style: DisplayStyle,
        store: SettingsStore,
        layouts: LayoutStore,
    ) -> None:
        super().__init__()
        self._actions = actions
        self._style = style
        self._store = store
        self._history: SampleSource | None = None
        self._state = FlightViewState()
        self._requested_panel: bool | None = None
        column = arrange(QVBoxLayout(self), 0)
        self._split = QSplitter(Qt.Orientation.Horizontal)
        self._split.setChildrenCollapsible(False)
        self.charts = StripChart(timed=False)
        self.charts.navigator.set_window(store.current.span)
        self._split.addWidget(self.charts)
        self.tabs = self._make_panels()
        self.layouts = LayoutController(self.charts, self.channels, store, layouts, self)
        self._split.addWidget(self.tabs)
        self._split.setStretchFactor(0, 1)
        self._split.setStretchFactor(1, 0)
        column.addWidget(self._split, 1)
        self._panel_width = store.current.panel_width
        self._drawn = QTimer(self)
        self._drawn.setSingleShot(True)
        self._drawn.setInterval(_RESIZE_SAVE_MS)
        self._drawn.timeout.connect(lambda: store.change(panel_width=self._panel_width))
        self._split.splitterMoved.connect(lambda *_: self._panel_drawn())
        foot = QWidget()
        foot.setObjectName("controls")
        foot.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        below = arrange(QVBoxLayout(foot), 0)
        self.replay = ReplayBar(actions, style)
        below.addWidget(self.replay.slider)
        self.controls = ControlRow(actions, style, self.replay)
        below.addWidget(self.controls)
        column.addWidget(foot)
        self.replay.show_bar(False)
        self._connect()
        self._restyle()
        self._size_panel()

    def is_by_key(self, command: str) -> bool:
        """Return whether a key triggers a command at this moment."""
        return bool(getattr(self._actions[command], "by_key", False))

    def _make_panels(self) -> QTabWidget:
        tabs = QTabWidget()
        tabs.setDocumentMode(True)
        tabs.setAccessibleName(tr("Panels"))
        tabs.setUsesScrollButtons(True)
        tabs.tabBar().setExpanding(False)
        tabs.tabBar().setDrawBase(False)
        self.channels = ChannelPanel(self._style)
        self.values = ValuesPanel(self._style)
        self.marks = MarksPanel(self._style)
        self.alarms = AlarmsPanel(self._style)
        self.messages = MessagesPanel(self._style)
        self.estimates = EstimatesPanel(self._style)
        self.plot = PlotPanel(self._style)
        panels = (
            self.channels, self.values, self.marks, self.alarms, self.messages, self.estimates,
            self.plot,
        )  # fmt: skip
        for name, panel in zip(_TAB_NAMES, panels, strict=True):
            tabs.addTab(panel, tr(name))
        return tabs

    def _connect(self) -> None:
        charts, store = self.charts, self._store
        charts.mark_requested.connect(self.mark_requested)
        charts.menu_requested.connect(self._show_menu)
        charts.cursor_moved.connect(lambda *_: self._show_values())
        charts.view_changed.connect(self._view_changed)
        self.controls.span_chosen.connect(charts.navigator.set_window)
        self.layouts.layout_shown.connect(self._show_values)
        self.tabs.currentChanged.connect(lambda _index: self._show_values())
        self.tabs.currentChanged.connect(lambda _index: self._size_panel())
        self._style.changed.connect(self._restyle)
        self._actions["side_panel"].setChecked(store.current.side_panel)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        chart = {
            CHART_PREFIX + action.id: lambda name=action.id: self.charts.perform(name)
            for action in KEY_ACTIONS
            if action.id not in ("mark", "pause", "clear")
        }
        return {
            **chart,
            CHART_PREFIX + "clear": self.cancel,
            "panel_channels": lambda: self.show_panel(0),
            "panel_values": lambda: self.show_panel(1),
            "panel_marks": lambda: self.show_panel(2),
            "panel_alarms": lambda: self.show_panel(3),
            "panel_messages": lambda: self.show_panel(4),
            "panel_estimates": lambda: self.show_panel(5),
            "panel_plot": lambda: self.show_panel(6),
            "side_panel": self.toggle_panel,
            "panel_wider": lambda: self._widen_panel(_PANEL_STEP),
            "panel_narrower": lambda: self._widen_panel(-_PANEL_STEP),
        }

    def cancel(self) -> None:
        """Esc: back from a panel to the charts, or else take the cursors away."""
        if self.charts.isHidden():
            self._set_panel(False)
        elif self.charts.hasFocus() or not self.isAncestorOf(self.focusWidget() or self):
            self.charts.clear()
        self.charts.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def show_panel(self, index: int) -> None:
        """Open a panel and put the keyboard into it."""
        if not self.isVisible():
            # Else one would type into what nobody sees.
            self.show_requested.emit()
        self._set_panel(True)
        self.tabs.setCurrentIndex(index)
        panel = self.tabs.currentWidget()
        if panel is self.channels:
            self.channels.set_initial_focus()
        else:
            (panel.focusProxy() or panel).setFocus(Qt.FocusReason.ShortcutFocusReason)

    @property
    def panel_shown(self) -> tuple[bool, int]:
        """Return whether the side panel is open, and which of its panels."""
        return self.tabs.isVisibleTo(self), self.tabs.currentIndex()

    def restore_charts(self, shown: tuple[bool, int]) -> None:
        opened, index = shown
        self.tabs.setCurrentIndex(index)
        if not opened:
            self._set_panel(False)
        self.charts.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def toggle_panel(self) -> None:
        self._set_panel(not self.tabs.isVisibleTo(self))

    def _set_panel(self, shown: bool) -> None:
        self._requested_panel = shown
        self._store.change(side_panel=shown)
        self._size_panel()

    def _size_panel(self) -> None:
        roomy = self.width() >= self._style.px(_PANEL_MIN_WIDTH)
        shown = self._store.current.side_panel and roomy
        if self._requested_panel is not None:
            shown = self._requested_panel
        if shown != self.tabs.isVisibleTo(self):
            self.tabs.setVisible(shown)
            self._show_values()
        self._actions["side_panel"].setChecked(shown)
        # Where both do not fit side by side, the open panel takes the place of the charts.
        least = max(self._style.px(_PANEL_WIDTH), self._tabs_width())
        most = self.width() - self._style.px(_CHARTS_MIN_WIDTH)
        alone = shown and most < least
        self.charts.setVisible(not alone)
        if shown:
            if alone:
                least = most = max(self.width(), 1)
            self.tabs.setMinimumWidth(least)
            self.tabs.setMaximumWidth(most)
            wide = self.alarms.view.full_width if self.tabs.currentWidget() is self.alarms else 0
            side = min(max(self._style.px(self._panel_width), least, wide), most)
            # Else the splitter would keep the shares of a time when it was hidden, or room for
            # words that are wider than the panel.
            self._split.setSizes([self.width() - side, side])

    def apply_settings(self) -> None:
        self._requested_panel = None
        self._drawn.stop()
        self._panel_width = self._store.current.panel_width
        self.layouts.show_layout(self._store.current.layout)
        self._size_panel()

    def _widen_panel(self, points: int) -> None:
        if self.tabs.isVisible():
            self._panel_width = round(self.tabs.width() / self._style.sizes.scale) + points
            self._size_panel()
            self._panel_drawn()

    def _panel_drawn(self) -> None:
        self._panel_width = round(self.tabs.width() / self._style.sizes.scale)
        self._drawn.start()

    def _tabs_width(self) -> int:
        """Return the width at which all tabs are in sight, with up to 99 alarms waiting."""
        style = self._style
        plain = QFontMetricsF(style.font("label"))
        chosen = QFontMetricsF(style.font("label", strong=True))
        words = [_alarms_tab_text(99) if name == _ALARMS else tr(name) for name in _TAB_NAMES]
        bolder = max(
            chosen.horizontalAdvance(word) - plain.horizontalAdvance(word) for word in words
        )
        # Qt gives each tab whole pixels.
        each = [
            math.ceil(plain.horizontalAdvance(word)) + 2 * style.px(TAB_MARGIN) for word in words
        ]
        return sum(each) + math.ceil(bolder)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._size_panel()

    # What is shown

    def show_history(self, history: SampleSource | None) -> None:
        self._history = history
        self._state = FlightViewState()
        self.layouts.begin_flight()
        self.charts.clear()
        self.charts.set_history(history)
        if history is not None:
            self.charts.setFocus(Qt.FocusReason.OtherFocusReason)

    def show_state(self, picture: FlightViewState) -> None:
        """Show everything beside the samples; what did not change is left alone."""
        former, self._state = self._state, picture
        self.charts.set_limits(picture.limits)
        if picture.sources != former.sources:
            self.charts.set_sources(picture.sources)
        if picture.stale_ages != former.stale_ages:
            self.charts.set_stale_ages(picture.stale_ages)
        self.charts.set_empty_text(picture.empty_text)
        self.charts.set_recording(picture.recording)
        self.charts.set_newest_text(tr("now") if picture.present_shown else tr("read up to"))
        self.charts.set_marks(picture.marks)
        self.charts.set_spans(picture.spans)
        self.charts.set_alarms(picture.alarms)
        self.layouts.show_state(picture)
        self.marks.show_rows(picture.mark_rows)
        self.alarms.set_empty_text(_no_alarms_text(picture.monitored_fraction))
        self.alarms.show_rows(picture.alarm_rows)
        self.alarms.set_unacknowledged_count(picture.unacknowledged_count)
        replay = picture.replay
        played = replay is None or (replay.time == replay.end and picture.monitored_fraction == 1.0)
        self.alarms.cues_note.setHidden(played)
        self.messages.show_rows(picture.message_rows)
        if picture.estimates is not former.estimates:
            self.estimates.show_rows(picture.estimates, picture.estimates_state)
        search = self.estimates.search
        search.setVisible(picture.has_search)
        if picture.has_search:
            search.show_search(
                picture.search_steps, picture.search_state, enabled=picture.search_enabled
            )
        self.plot.show_flight(self._history, *self.charts.view.times, picture.spans)
        place, text = _TAB_NAMES.index(_ALARMS), _alarms_tab_text(picture.unacknowledged_count)
        if self.tabs.tabText(place) != text:
            self.tabs.setTabText(place, text)
        self._show_replay(picture)

    def _show_replay(self, picture: FlightViewState) -> None:
        replay = picture.replay
        self.replay.show_bar(replay is not None)
        self.controls.pause.setVisible(replay is None)
        if replay is not None:
            self.replay.show_replay(
                replay.time,
                replay.start,
                replay.end,
                playing=replay.playing,
                speed=replay.speed,
                marks=[mark.time for mark in picture.marks],
                alarms=picture.alarms,
            )

    def advance(self, now: float | None) -> None:
        """Paint what has arrived: one frame."""
        self.charts.set_now(now)
        self.charts.advance()

    def _show_menu(self, where: QPoint, time: float | None) -> None:
        units = self._style.units
        menu = create_chart_menu(self.charts, self._state, self._actions, time, units, self)
        menu.exec(where)
        menu.deleteLater()

    def _view_changed(self) -> None:
        view = self.charts.view
        self.controls.show_paused(view.paused)
        self.controls.show_span(view.window)
        if abs(view.window - self._store.current.span) > 1e-6:
            self._store.change(span=view.window)

    def _show_values(self) -> None:
        # Values at the cursors stand once: in the table, or else beside the charts.
        self.charts.set_cursor_values_shown(not self.values.isVisible())
        if self._history is None or not self.values.isVisible():
            return
        cursors = self.charts.view.cursors
        names = self.charts.strip_layout.channels if cursors else ()
        self.values.show_rows(
            build_cursor_value_rows(
                self._history, names, cursors, self._style.units, self._state.sources
            )
        )
        self.values.show_columns(cursors)
        self.values.show_times(cursor_times_text(cursors) if cursors else "")

    def _restyle(self) -> None:
        self.charts.set_theme(self._style.theme)
        self.charts.set_units(self._style.units)
        self.charts.set_scale(self._style.sizes.scale)
        self.charts.advance()
        self._show_values()
        self._view_changed()
        self._size_panel()


def _no_alarms_text(watched: float) -> str:
    if watched < 1.0:
        return tr("Catching up, {percent} %: reading the flight so far.").format(
            percent=floor_percent(watched)
        )
    return tr("No alarms.")


def _alarms_tab_text(waiting: int) -> str:
    """Return the words of the tab of the alarms: how many nobody has acknowledged."""
    return f"{tr(_ALARMS)} {waiting}" if waiting else tr(_ALARMS)
