"""The debrief within the place: made when it is first seen, kept in the catalog."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from gsapp.foundation import GroundStationError
from ui.background_job import BackgroundJob
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.flight_controller import FlightController
from ui.pilot.flight_cues import FlightCues
from ui.settings import SettingsStore, catalog_path
from ui.translation import tr

if TYPE_CHECKING:
    from ui.pilot.debrief_page import DebriefPage


class DebriefController(QObject):
    """Makes the page of the debrief and does what its commands say."""

    time_requested = Signal(float)
    """A flight time (s) should be on screen, in the charts."""

    def __init__(
        self,
        place: QWidget,
        look: DisplayStyle,
        store: SettingsStore,
        error_reporter: ErrorReporter,
        controller: FlightController,
        cues: FlightCues,
        commands: Sequence[QAction],
    ) -> None:
        super().__init__(place)
        self._look = look
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

            self.page = DebriefPage(self._look, self._commands)
        return self.page

    def refresh(self, events: int | None = None) -> None:
        """Show what was judged since.

        Parameters
        ----------
        events : int, optional
            How many there were so far: while there are no more, nothing was judged.
        """
        if self.page is not None and (events is None or events != self._events):
            self._events = events
            self.page.show_debrief(self._cues.debrief())

    def read_trends(self) -> None:
        from ui.pilot.debrief_storage import load_trends

        if self.page is None:
            return
        try:
            self.page.show_trends(load_trends(catalog_path(self._store.current)))
        except GroundStationError as error:
            self._error_reporter.report(error)

    def store(self) -> None:
        from ui.pilot.debrief_storage import save_debrief

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
