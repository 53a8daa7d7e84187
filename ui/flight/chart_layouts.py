"""Layouts of charts: shipped, saved in a folder of the user's, or chosen by hand."""

from __future__ import annotations

import logging
import re
from itertools import count
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog

from gsapp.foundation import FileProblemsError, FlightError, GroundStationError, UnknownNameError
from gsapp.foundation.files import list_files
from ui.dialogs.file_dialogs import ask_save_file
from ui.flight.channel_panel import ChannelPanel
from ui.flight.chart_selection import (
    OVERVIEW_LAYOUT,
    SHIPPED_LAYOUT_NAMES,
    create_shipped_layout,
    rename_layout,
)
from ui.flight.flight_view_state import FlightViewState, origin_note
from ui.number_format import sanitize_file_name
from ui.settings import SettingsStore
from ui.strips.strip_chart import StripChart
from ui.strips.strip_layout import StripLayout, load_layout, save_layout
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.message_boxes import show_warning

log = logging.getLogger(__name__)

_UNSAFE_CHARACTERS = re.compile(r"[^\w\-]+")


class LayoutStore:
    """Layouts by name, on disk.

    `folder`: where they are kept; made when the first is saved.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._layouts: dict[str, tuple[Path, StripLayout]] = {}
        complaints: list[str] = []
        try:
            files = list_files(folder, "*.toml")
        except GroundStationError as error:
            log.warning("layouts not used: %s", error)
            complaints.append(tr("The layouts could not be read: {error}.").format(error=error))
            files = ()
        for path in files:
            try:
                layout = load_layout(path)
            except FileProblemsError as error:
                log.warning("layout not used: %s", error)
                complaints.append(
                    tr("The layout {name} could not be read: {problem}.").format(
                        name=path.name, problem=error.problems[0]
                    )
                )
            else:
                self._layouts[layout.name] = (path, layout)
        # What is wrong with files that could not be read; these are left alone.
        self.read_errors = tuple(complaints)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(sorted(self._layouts))

    def load(self, name: str) -> StripLayout:
        try:
            return self._layouts[name][1]
        except KeyError:
            raise UnknownNameError(
                tr("no layout named '{name}' was saved").format(name=name)
            ) from None

    def save(self, layout: StripLayout, name: str) -> None:
        """Keep a layout under a name.

        Raises `FlightError` if the name belongs to a layout that comes with the program, or the
        disk refuses.
        """
        if name in SHIPPED_LAYOUT_NAMES or not name.strip():
            raise FlightError(
                tr("'{name}' comes with the program; choose another name").format(name=name)
            )
        path = self._layouts[name][0] if name in self._layouts else self._free_path(name)
        try:
            save_layout(path, rename_layout(layout, name))
        except OSError as error:
            raise FlightError(
                tr("the layout '{name}' cannot be written to {path} ({strerror})").format(
                    name=name, path=path, strerror=error.strerror
                )
            ) from error
        self._layouts[name] = (path, rename_layout(layout, name))

    def _free_path(self, name: str) -> Path:
        stem = sanitize_file_name(_UNSAFE_CHARACTERS.sub("-", name).strip("-").lower()) or "layout"
        taken = {path for path, _layout in self._layouts.values()}
        number = 1
        while True:
            path = self._folder / (f"{stem}.toml" if number == 1 else f"{stem}-{number}.toml")
            if path not in taken and not path.exists():
                return path
            number += 1

    def delete(self, name: str) -> None:
        path, _layout = self._layouts.pop(name)
        path.unlink(missing_ok=True)


_OWN_CHOICE = QT_TR_NOOP("Custom")
_FILES = QT_TR_NOOP("Layout (*.toml)")


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
        panel.import_requested.connect(self._ask_import)
        panel.export_requested.connect(self._ask_export)

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

    def _ask_import(self) -> None:
        path, _kind = QFileDialog.getOpenFileName(
            self._panel, tr("Import a layout"), str(Path.home()), tr(_FILES)
        )
        if path:
            self.import_layout(Path(path))

    def import_layout(self, path: Path) -> None:
        """Save the layout of a file under its name, or one like it, and show it."""
        try:
            layout = load_layout(path)
            taken = {*SHIPPED_LAYOUT_NAMES, *self._layouts.names}
            names = (f"{layout.name} {number}" for number in count(2))
            name = (
                layout.name
                if layout.name not in taken
                else next(n for n in names if n not in taken)
            )
            self._layouts.save(layout, name)
        except (GroundStationError, OSError) as error:
            show_warning(self._panel, tr("Import a layout"), str(error))
            return
        self.show_layout(name)

    def _ask_export(self) -> None:
        shown = self._charts.strip_layout
        name = sanitize_file_name(shown.name) or "layout"
        path = ask_save_file(
            self._panel, tr("Export the layout"), Path.home() / f"{name}.toml", tr(_FILES)
        )
        if path is None:
            return
        try:
            save_layout(path, rename_layout(shown, shown.name, self._charts.view.window))
        except OSError as error:
            show_warning(self._panel, tr("Export the layout"), str(error))

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
