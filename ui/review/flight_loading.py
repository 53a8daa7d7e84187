"""What the page of maneuvers has done in threads: flights opened, changes kept in the catalog."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from gsapp.foundation import FlightError
from gsapp.session.review import ReviewedFlight, open_reviewed_flight, save_maneuvers_to_catalog
from ui.background_job import BackgroundJob, JobProgress
from ui.disk_checks import may_block
from ui.translation import tr


class FlightLoader(QObject):
    """Opens flights one after the other."""

    opened = Signal(object)
    """A `ReviewedFlight`."""
    failed = Signal(object, object)
    """The path, and the exception."""
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
        """Open these flights after those that wait."""
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
                path, catalog=catalog, doing=lambda words: progress(None, words)
            )

        self._words = tr("opening {name}").format(name=path.name)
        self._job = BackgroundJob(self._words, run, self)
        self._job.progressed.connect(self._show_progress)
        self._job.done.connect(self._done)
        self._job.failed.connect(lambda error: self._report_failure(path, error))
        self._job.start()
        self.changed.emit()

    def _show_progress(self, _share: object, words: str) -> None:
        self._words = words
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
            catalog, flight.flight, maneuvers, flight.aircraft.name
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
