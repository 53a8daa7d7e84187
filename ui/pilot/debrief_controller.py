"""The debrief within the place: made when it is first seen, kept in the catalog of the campaign."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from gsapp.foundation import GroundStationError
from ui.background_job import BackgroundJob
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.flight_controller import FlightController
from ui.pilot.page_state import FlightCues
from ui.settings import SettingsStore, catalog_path
from ui.translation import tr

if TYPE_CHECKING:
    from gsapp.excitation.debrief import Debrief, FlightTrend
    from ui.pilot.debrief_page import DebriefPage


class DebriefController(QObject):
    """Makes the page of the debrief and does what its commands say."""

    time_requested = Signal(float)
    """A flight time (s) should be on screen, in the charts."""

    def __init__(
        self,
        place: QWidget,
        style: DisplayStyle,
        store: SettingsStore,
        error_reporter: ErrorReporter,
        controller: FlightController,
        cues: FlightCues,
        commands: Sequence[QAction],
    ) -> None:
        super().__init__(place)
        self._style = style
        self._store = store
        self._error_reporter = error_reporter
        self._controller = controller
        self._cues = cues
        self._commands = tuple(commands)
        self.page: DebriefPage | None = None
        self._events: int | None = None

    def get_page(self) -> DebriefPage:
        if self.page is None:
            from ui.pilot.debrief_page import DebriefPage

            self.page = DebriefPage(self._style, self._commands)
        return self.page

    def refresh(self, events: int | None = None) -> None:
        """Show what was judged since; nothing was while there are no more events than before."""
        if self.page is not None and (events is None or events != self._events):
            self._events = events
            self.page.show_debrief(self._cues.debrief())

    def read_trends(self) -> None:
        if self.page is None:
            return
        try:
            self.page.show_trends(load_trends(catalog_path(self._store.current)))
        except GroundStationError as error:
            self._error_reporter.report(error)

    def store(self) -> None:
        session, debrief = self._controller.session, self._cues.debrief()
        if session is None or debrief is None:
            return
        catalog, path = catalog_path(self._store.current), session.path
        aircraft = "" if session.aircraft is None else session.aircraft.name
        work = BackgroundJob(
            tr("Saving the debrief"),
            lambda _tell: save_debrief(path, debrief, catalog, aircraft),
            self,
        )
        work.done.connect(lambda _catalog: self.read_trends())
        work.failed.connect(self._error_reporter.report)
        self._controller.job_started.emit(
            work,
            tr("Debrief of {name} is in {catalog}.").format(name=session.name, catalog=catalog),
        )
        work.start()

    def show_in_charts(self) -> None:
        judged = None if self.page is None else self.page.current_maneuver
        if judged is not None:
            self.time_requested.emit(judged.verdict.t_input)


def save_debrief(path: Path, debrief: Debrief, catalog: Path, aircraft: str = "") -> Path:
    """Write a debrief into a catalog, in place of that of the same flight; return the catalog.

    Raises
    ------
    FlightError
        If the flight cannot be read, or the catalog cannot be written.
    """
    from gsapp.flight.catalog import Catalog, store_debrief
    from gsapp.flight.flight_loader import load_flight

    flight, verdicts = load_flight(path), debrief.to_stored_verdicts()
    catalog.parent.mkdir(parents=True, exist_ok=True)
    with Catalog(catalog) as opened:
        store_debrief(opened, flight, verdicts, debrief.cards, aircraft=aircraft)
    return catalog


def load_trends(catalog: Path) -> tuple[FlightTrend, ...]:
    """Return what the flights of a catalog show, in order; none where there is no catalog.

    Raises
    ------
    FlightError
        If it cannot be read.
    """
    from gsapp.excitation.debrief import compute_trends
    from gsapp.flight.catalog import Catalog, list_card_scores, search_verdicts

    if not catalog.is_file():
        return ()
    with Catalog(catalog) as opened:
        verdicts = search_verdicts(opened)
        names = [name for name, _ in groupby(verdicts, key=lambda one: one.flight)]
        return compute_trends(verdicts, {name: list_card_scores(opened, name) for name in names})
