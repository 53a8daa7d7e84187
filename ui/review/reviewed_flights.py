"""Which flights are under review, opened and kept in threads, and which of them is on screen."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from gsapp.foundation import FlightError, GroundStationError
from gsapp.session.review import (
    Review,
    ReviewedFlight,
    open_reviewed_flight,
    save_maneuvers_to_catalog,
)
from ui.background_job import BackgroundJob, JobProgress
from ui.dialogs.file_dialogs import ask_flight_folder, ask_open_files
from ui.disk_checks import may_block, path_kind
from ui.review.review_steps import ReviewSelection
from ui.settings import SettingsStore, catalog_path
from ui.translation import tr


class FlightLoader(QObject):
    """Opens flights one after the other."""

    opened = Signal(object)
    failed = Signal(object, object)
    changed = Signal()

    def __init__(self, catalog: Callable[[], Path], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._catalog = catalog
        self._waiting: list[Path] = []
        self._job: BackgroundJob | None = None
        self._words = ""

    @property
    def status_text(self) -> str:
        """Return what is being opened, in words; empty for nothing."""
        if self._job is None:
            return ""
        left = (
            tr(", {count} more to come").format(count=len(self._waiting)) if self._waiting else ""
        )
        return f"{self._words[:1].upper()}{self._words[1:]}{left} …"

    def open(self, paths: Iterable[Path]) -> None:
        self._waiting += [path for path in paths if path not in self._waiting]
        if self._job is None:
            self._next()

    def _next(self) -> None:
        if not self._waiting:
            self._job = None
            self.changed.emit()
            return
        path = self._waiting.pop(0)
        catalog = self._catalog()

        def run(progress: JobProgress) -> ReviewedFlight:
            if may_block(path):
                raise FlightError(tr("{path} does not respond").format(path=path))
            return open_reviewed_flight(
                path, catalog=catalog, doing=lambda text: progress(None, text)
            )

        self._words = tr("opening {name}").format(name=path.name)
        self._job = BackgroundJob(self._words, run, self)
        self._job.progressed.connect(self._show_progress)
        self._job.done.connect(self._done)
        self._job.failed.connect(lambda error: self._report_failure(path, error))
        self._job.start()
        self.changed.emit()

    def _show_progress(self, _share: object, text: str) -> None:
        self._words = text
        self.changed.emit()

    def _done(self, flight: ReviewedFlight) -> None:
        self.opened.emit(flight)
        self._next()

    def _report_failure(self, path: Path, error: BaseException) -> None:
        self.failed.emit(path, error)
        self._next()


class CatalogWriter(QObject):
    """Keeps the maneuvers of changed flights in the catalog, the latest state of each."""

    failed = Signal(object)

    def __init__(self, catalog: Callable[[], Path], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._catalog = catalog
        self._waiting: dict[Path, Callable[[], None]] = {}
        self._job: BackgroundJob | None = None

    @property
    def busy(self) -> bool:
        return self._job is not None

    def store(self, flight: ReviewedFlight) -> None:
        catalog, maneuvers = self._catalog(), flight.maneuvers
        self._waiting[flight.path] = lambda: save_maneuvers_to_catalog(
            catalog, flight.flight, maneuvers, flight.aircraft
        )
        if self._job is None:
            self._next()

    def _next(self) -> None:
        if not self._waiting:
            self._job = None
            return
        write = self._waiting.pop(next(iter(self._waiting)))
        self._job = BackgroundJob(tr("Saving the maneuvers"), lambda _progress: write(), self)
        self._job.done.connect(lambda _result: self._next())
        self._job.failed.connect(self._report_failure)
        self._job.start()

    def _report_failure(self, error: BaseException) -> None:
        self.failed.emit(error)
        self._next()


log = logging.getLogger(__name__)


class ReviewedFlights(QWidget):
    """Opens flights, remembers them, takes them out, and looks at one.

    It is never shown itself: the questions for folders and files stand above it.
    """

    current_flight_changed = Signal(object)
    changed = Signal()
    status_changed = Signal()
    failed = Signal(str)

    def __init__(
        self, review: Review, store: SettingsStore, selection: ReviewSelection, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.hide()
        self._review = review
        self._store = store
        self._selection = selection
        self._open: Path | None = None
        self.flight: ReviewedFlight | None = None
        self.opening = FlightLoader(lambda: catalog_path(store.current), self)
        self.opening.opened.connect(self._opened)
        self.opening.failed.connect(self._not_opened)
        self.opening.changed.connect(self.status_changed)
        selection.maneuver_changed.connect(self._show_flight_of)

    def reopen_last_flights(self) -> None:
        """Open the flights that were under review last; those that are gone are named."""
        known = [Path(path) for path in self._store.current.review_flights]
        gone = [path for path in known if path_kind(path) == "missing"]
        self.opening.open([path for path in known if path not in gone])
        if gone:
            names = ", ".join(map(str, gone))
            self.failed.emit(
                tr("{names}: not found; add it from its new location").format(names=names)
            )

    # The flight that is open in the window

    def set_open_flight(self, path: Path | None) -> None:
        """Say which flight is open in the window; the first one of all is taken by itself."""
        self._open = path
        nothing = not (self._review.flights or self.opening.status_text)
        if path is not None and nothing and not self._store.current.review_flights:
            self.opening.open([path])
        self.status_changed.emit()

    @property
    def can_add_open_flight(self) -> bool:
        known = [path.resolve() for path in self._review.paths]
        return self._open is not None and self._open.resolve() not in known

    def add_open_flight(self) -> None:
        if self._open is not None:
            self.opening.open([self._open])

    # Others

    def add_folder(self) -> None:
        if path := ask_flight_folder(self, tr("Add a flight folder"), self._store.current):
            self.opening.open([path])

    def add_files(self) -> None:
        self.opening.open(ask_open_files(self, self._store.current))

    def remove_flight(self) -> None:
        """Take the flight on screen out of the review; its files stay as they are."""
        flight = self.flight
        if flight is None:
            return
        index = self._review.flights.index(flight)
        self._review.remove(flight)
        left = self._review.flights
        self._remember()
        self.select_flight(left[min(index, len(left) - 1)] if left else None)
        self.changed.emit()

    def _opened(self, flight: ReviewedFlight) -> None:
        chosen = self._selection.maneuver
        place = None if not chosen else self._review.find_maneuver(chosen)
        self._review.add(flight)
        self._remember()
        if place is not None and place[0] in self._review.flights:
            # Ids of a campaign begin with the number of the flight.
            self._selection.select_maneuver(self._review.campaign_id(place[0], place[1].id))
        elif self.flight is None or self.flight not in self._review.flights:
            # The first one, or the one on screen opened anew.
            self.select_flight(flight)
        self.changed.emit()

    def _not_opened(self, path: Path, error: BaseException) -> None:
        if not isinstance(error, GroundStationError):
            log.error("%s is not opened", path, exc_info=error)
        self.failed.emit(tr("{name} is not opened: {error}").format(name=path.name, error=error))

    def _remember(self) -> None:
        paths = tuple(str(path.absolute()) for path in self._review.paths)
        self._store.change(review_flights=paths)

    # What is on screen

    def select_flight(self, flight: ReviewedFlight | None) -> None:
        """Put another flight on screen; its first maneuver is chosen where none of it is."""
        if flight is not self.flight:
            self.flight = flight
            self.current_flight_changed.emit(flight)
        place = self._review.find_maneuver(self._selection.maneuver)
        if flight is None:
            self._selection.select_maneuver("")
        elif place is None or place[0] is not flight:
            first = flight.maneuvers[0].id if flight.maneuvers else ""
            self._selection.select_maneuver(
                self._review.campaign_id(flight, first) if first else ""
            )

    def _show_flight_of(self, campaign_id: str) -> None:
        place = self._review.find_maneuver(campaign_id)
        if place is not None and place[0] is not self.flight:
            self.flight = place[0]
            self.current_flight_changed.emit(place[0])
