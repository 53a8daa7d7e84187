"""What a search begins with: flights, aircraft, current model; or what to do without a flight."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QPushButton,
    QWidget,
)

from gsapp.aircraft.aircraft_loader import shipped_aircraft
from ui.background_job import BackgroundJob, JobProgress
from ui.dialogs.file_dialogs import ask_flight_folder, ask_open_files
from ui.dialogs.file_fields import ShippedFileField
from ui.dialogs.form_dialog import FieldMessage
from ui.disk_checks import path_kind
from ui.display_style import DisplayStyle
from ui.gap.gap_stages import GAP_STAGES
from ui.gap.search_jobs import GapRequest
from ui.settings import SettingsStore
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.labels import CenteredPage, create_label
from ui.widgets.layout_widgets import create_button_row
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import BoxedListView

_STAGE_DESCRIPTIONS = {
    "find": QT_TR_NOOP("Where simulation and flight disagree: coefficient, maneuver, region."),
    "name": QT_TR_NOOP(
        "The missing effect, its confidence, and the maneuver that tells it from others."
    ),
    "add": QT_TR_NOOP("The effect in the model, all values refitted; reject it, or force another."),
    "show": QT_TR_NOOP("Before and after, on held-out maneuvers."),
}


class SearchSetupPage(CenteredPage):
    """Asks what to search."""

    search_requested = Signal(object)
    virtual_flight_requested = Signal()
    back_requested = Signal()
    command_requested = Signal(str)

    def __init__(self, style: DisplayStyle, store: SettingsStore) -> None:
        super().__init__(style, 720)
        self._store = store
        self._open: Path | None = None
        self._busy = False
        self.setAccessibleName(tr("Search for a missing effect"))
        settings = store.current
        self.column.addWidget(create_label(tr("Model gap"), "title"))
        self.column.addWidget(
            create_label(
                tr(
                    "Find where simulation and measurement disagree, and which effect the model "
                    "lacks."
                ),
                "muted",
                wrap=True,
            )
        )
        self.column.addWidget(self._create_stage_overview())
        self.column.addSpacing(style.px(8))
        self.column.addWidget(create_label(tr("Flights"), "heading"))
        self.paths: tuple[Path, ...] = ()
        self.flights = BoxedListView(
            style, tr("Flights to search"), elide=Qt.TextElideMode.ElideMiddle
        )
        self.column.addWidget(self.flights)
        self.message = FieldMessage()
        self.column.addWidget(self.message)
        self.add_open = self._button(tr("Add the open flight"), self._add_open)
        self.add_file = self._button(tr("Add a file…"), self._add_file)
        self.add_folder = self._button(tr("Add a folder…"), self._add_folder)
        self.remove = self._button(tr("Remove"), self._remove)
        self.column.addWidget(
            create_button_row(style, self.add_open, self.add_file, self.add_folder, self.remove)
        )
        self.column.addSpacing(style.px(8))
        form = QWidget()
        grid = QGridLayout(form)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(style.px(16))
        grid.setVerticalSpacing(style.px(8))
        grid.setColumnStretch(1, 1)
        self.aircraft = ShippedFileField(
            tr("Aircraft"), shipped_aircraft(), settings.gap_aircraft, none=tr("From each flight")
        )
        self.model = ShippedFileField(
            tr("Current model"), tuple(filter(None, (settings.gap_model,))), settings.gap_model,
            none=tr("None: fit the baseline from these flights"),
        )  # fmt: skip
        for row, (name, field) in enumerate((("aircraft", self.aircraft), ("model", self.model))):
            grid.addWidget(create_label(tr(GapRequest.title_of(name)), "strong"), row, 0)
            grid.addWidget(field, row, 1)
        self.column.addWidget(form)
        self.column.addSpacing(style.px(8))
        self.search = self._button(tr("Search"), self.request_search)
        self.search.setProperty("role", "primary")
        self.search.setMinimumHeight(style.px(44))
        self.back = self._button(tr("Back to the result"), self.back_requested.emit)
        self.back.setMinimumHeight(style.px(44))
        self.back.hide()
        self.column.addWidget(create_button_row(style, self.search, self.back))
        self.column.addSpacing(style.px(8))
        self.other = create_label(tr("No flight available?"), "heading")
        self.column.addWidget(self.other)
        self.open = self._button(
            tr("Open a flight…"), lambda: self.command_requested.emit("open_file")
        )
        self.virtual = self._button(
            tr("Fly the virtual aircraft…"), lambda: self.command_requested.emit("virtual")
        )
        self.trial = self._button(
            tr("Try a flight with a hidden effect"), self.virtual_flight_requested.emit
        )
        self.trial.setToolTip(
            tr(
                "Simulates a flight whose throttle pitches the nose (about half a minute), then "
                "searches it with a model without that effect"
            )
        )
        self.column.addWidget(create_button_row(style, self.open, self.virtual, self.trial))
        for path in settings.gap_flights:
            if path_kind(path) != "missing":
                self._append(Path(path))
        self._read_models()
        self.flights.row_changed.connect(self._update_state)
        self.flights.deleted.connect(self._remove)
        style.changed.connect(self._rescale)
        self._update_state()

    def _button(self, text: str, act: Callable[[], object]) -> QPushButton:
        button = QPushButton(text)
        button.setAccessibleName(text.rstrip("…"))
        button.clicked.connect(lambda _checked=False: act())
        return button

    def _create_stage_overview(self) -> QWidget:
        card = QFrame()
        card.setObjectName("card")
        grid = QGridLayout(card)
        grid.setContentsMargins(16, 12, 16, 12)
        grid.setHorizontalSpacing(16)
        grid.setColumnStretch(1, 1)
        for row, stage in enumerate(GAP_STAGES):
            grid.addWidget(
                create_label(f"{row + 1}  {tr(stage.title)}", "strong"),
                row,
                0,
                Qt.AlignmentFlag.AlignTop,
            )
            grid.addWidget(create_label(tr(_STAGE_DESCRIPTIONS[stage.id]), wrap=True), row, 1)
        return card

    def _read_models(self) -> None:
        """Find the shipped models in a thread: what reads models takes seconds to load."""

        def names(_progress: JobProgress) -> tuple[str, ...]:
            from gsapp.dynamics.model import shipped_models

            return shipped_models()

        work = BackgroundJob(tr("Reading the models"), names, self)
        work.done.connect(self._offer_models)
        work.failed.connect(
            lambda error: self.message.set_message(
                tr("The models cannot be read: {error}").format(error=error), "warning"
            )
        )
        work.start()

    def _offer_models(self, names: Sequence[str]) -> None:
        self.model.add_names(names)

    # Flights

    def add_flight(self, path: Path) -> None:
        """List a flight; one that is listed already is left where it is."""
        if path.absolute() not in [known.absolute() for known in self.paths]:
            self._append(path)
        self._update_state()

    def set_open_flight(self, path: Path | None) -> None:
        """Say which flight is open in the window; the first one of all is listed by itself."""
        if path == self._open:
            return
        self._open = path
        if path is not None and not self.paths:
            self._append(path)
        self._update_state()

    def show_state(self, *, busy: bool, answered: bool) -> None:
        """Say whether a search runs, and whether there is a result to go back to."""
        if busy and not self._busy and self.search.hasFocus():
            # Not to the next button, where a second Enter would do something else.
            self.flights.setFocus()
        self._busy = busy
        self.back.setVisible(answered)
        self._update_state()

    def _append(self, path: Path) -> None:
        self._show_paths((*self.paths, path))

    def _show_paths(self, paths: Sequence[Path]) -> None:
        self.paths = tuple(paths)
        self.flights.show_rows(
            [
                TableRow(key=path, cells=(f"{path.name}   {path.parent}",), detail=str(path))
                for path in paths
            ]
        )
        if paths and self.flights.current_key() is None:
            self.flights.select_row(paths[0])

    def _add_open(self) -> None:
        if self._open is not None:
            self.add_flight(self._open)

    def _add_file(self) -> None:
        for path in ask_open_files(self, self._store.current):
            self.add_flight(path)

    def _add_folder(self) -> None:
        if path := ask_flight_folder(self, tr("Add a flight folder"), self._store.current):
            self.add_flight(path)

    def _remove(self) -> None:
        chosen = self.flights.current_key()
        self._show_paths([path for path in self.paths if path != chosen])
        self._update_state()

    def _update_state(self) -> None:
        paths = self.paths
        self.flights.setVisible(bool(paths))
        listed = [path.absolute() for path in paths]
        offered = self._open is not None and self._open.absolute() not in listed
        self.add_open.setVisible(offered)
        self.remove.setEnabled(self.flights.current_key() is not None)
        self.search.setEnabled(bool(paths) and not self._busy)
        self.trial.setEnabled(not self._busy)
        busy = tr("A search is running") if self._busy else ""
        self.remove.setToolTip("" if self.remove.isEnabled() else tr("Choose a flight first"))
        self.search.setToolTip("" if self.search.isEnabled() else busy or tr("Add a flight first"))
        self.trial.setToolTip(busy)
        gone = [path.name for path in paths if path_kind(path) == "missing"]
        if gone:
            self.message.set_message(
                tr("{gone} no longer exists; remove it.").format(gone=gone[0]), "warning"
            )
        elif not paths:
            self.message.set_message(
                tr(
                    "No flight. Add one with doublets of every surface, or try a flight with a "
                    "hidden effect below."
                ),
                "caution",
            )
        elif self._busy:
            self.message.set_message(tr("Changes apply to the next search."))
        elif len(paths) == 1:
            self.message.set_message(
                tr("One flight. Several flights with the same maneuvers give more certain names.")
            )
        else:
            self.message.set_message(
                tr("{count} flights, searched together.").format(count=len(paths)), "good"
            )

    def _rescale(self) -> None:
        self.search.setMinimumHeight(self._style.px(44))
        self.back.setMinimumHeight(self._style.px(44))
        self._update_state()

    # The question

    @property
    def request(self) -> GapRequest:
        return GapRequest(flights=self.paths, aircraft=self.aircraft.value, model=self.model.value)

    def request_search(self) -> None:
        if self.search.isEnabled():
            self.save_settings(self.paths)
            self.search_requested.emit(self.request)

    def save_settings(self, flights: Sequence[Path]) -> None:
        self._store.change(
            gap_flights=tuple(str(path.absolute()) for path in flights),
            gap_aircraft=self.aircraft.value,
            gap_model=self.model.value,
        )

    def set_flight(self, flight: Path, aircraft: str, model: str) -> None:
        self._show_paths((flight,))
        self._offer_models((model,))
        for field, value in ((self.aircraft, aircraft), (self.model, model)):
            place = field.findData(value)
            if place >= 0:
                field.setCurrentIndex(place)
        self._update_state()
        self.request_search()

    def set_initial_focus(self) -> None:
        (self.search if self.search.isEnabled() else self.trial).setFocus()
