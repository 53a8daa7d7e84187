"""The kept runs of the catalog as the window knows them; read and changed in a thread."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from ui.background_job import BackgroundJob, JobProgress
from ui.translation import tr
from ui.undo import UndoCommand, UndoStack

if TYPE_CHECKING:
    # The window starts without the numerics behind a run.
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.runs.run_store import StoredRun

CatalogAction = Callable[["Catalog"], object]


class RunStore(QObject):
    """Lists, renames and forgets kept runs.

    Parameters
    ----------
    catalog : callable
        Returns where the catalog is.
    report_error : callable
        Where errors go.
    undo_stack : UndoStack
        Takes the changes.

    Attributes
    ----------
    changed : Signal
        Other runs are known now.
    runs : tuple of StoredRun
        The newest first.
    read_error : str
        Why they could not be read; empty where they were.
    """

    changed = Signal()

    def __init__(
        self,
        catalog: Callable[[], Path],
        report_error: Callable[[BaseException], None],
        undo_stack: UndoStack,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._catalog = catalog
        self._report_error = report_error
        self._undo_stack = undo_stack
        self._job: BackgroundJob | None = None
        self._waiting: list[CatalogAction | None] = []
        self._only_reads = True
        self.runs: tuple[StoredRun, ...] = ()
        self.read_error = ""

    @property
    def catalog(self) -> Path:
        """Return where the catalog is."""
        return self._catalog()

    def find_run(self, number: int | None) -> StoredRun | None:
        """Return a run by its number; None if it is not known."""
        return next((one for one in self.runs if one.number == number), None)

    def reload(self) -> None:
        """Read the runs anew."""
        self._do(None)

    def rename(self, number: int, label: str) -> None:
        """Call a run something else."""
        before = self.find_run(number)
        if before is None or before.label == label.strip():
            return
        former = before.label
        self._rename(number, label)
        self._undo_stack.push(
            UndoCommand(
                tr("rename run {number}").format(number=number),
                lambda: self._rename(number, former),
                lambda: self._rename(number, label),
            )
        )

    def remove(self, number: int) -> None:
        """Leave a run out; it can be brought back."""
        if self.find_run(number) is None:
            return
        self._forget(number)
        self._undo_stack.push(
            UndoCommand(
                tr("remove run {number}").format(number=number),
                lambda: self._recall(number),
                lambda: self._forget(number),
            )
        )

    def update_means(self, outcome: RunOutcome) -> None:
        """Keep the means of a kept run as they are now."""
        if outcome.number is None:
            return

        def act(catalog: Catalog) -> None:
            from gsapp.identification.runs.run_store import update_run_means

            update_run_means(catalog, outcome)

        self._do(act)

    def _rename(self, number: int, label: str) -> None:
        def act(catalog: Catalog) -> None:
            from gsapp.identification.runs.run_store import rename_run

            rename_run(catalog, number, label)

        self._do(act)

    def _forget(self, number: int) -> None:
        def act(catalog: Catalog) -> None:
            from gsapp.identification.runs.run_store import forget_run

            forget_run(catalog, number)

        self._do(act)

    def _recall(self, number: int) -> None:
        def act(catalog: Catalog) -> None:
            from gsapp.identification.runs.run_store import recall_run

            recall_run(catalog, number)

        self._do(act)

    def _do(self, act: CatalogAction | None) -> None:
        """Change something, if asked, and read anew; one after the other."""
        self._waiting.append(act)
        self._next()

    def _next(self) -> None:
        if self._job is not None or not self._waiting:
            return
        act, path = self._waiting.pop(0), self.catalog
        self._only_reads = act is None

        def run(_progress: JobProgress) -> tuple[StoredRun, ...]:
            if not path.is_file():
                return ()
            from gsapp.flight.catalog import Catalog
            from gsapp.identification.runs.run_store import stored_runs

            with Catalog(path) as catalog:
                if act is not None:
                    act(catalog)
                return stored_runs(catalog)[::-1]

        work = BackgroundJob(tr("Reading the kept runs"), run, self)
        self._job = work
        work.done.connect(self._read)
        work.failed.connect(self._failed)
        work.start()

    def _read(self, runs: tuple[StoredRun, ...]) -> None:
        self._job = None
        self.runs, self.read_error = runs, ""
        self.changed.emit()
        self._next()

    def _failed(self, error: BaseException) -> None:
        self._job = None
        if self._only_reads:
            self.read_error = str(error)
            self.changed.emit()
        self._report_error(error)
        self._next()
