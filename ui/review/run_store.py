"""The kept runs of the catalog, and runs on their way; read and changed in a thread."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from ui.background_job import BackgroundJob, JobCanceledError, JobProgress
from ui.commands import shortcut_text
from ui.number_format import join_sentences
from ui.review.review_jobs import NOT_STORED_TEXT, EstimateJob, JobSubmitter, RepeatJob
from ui.translation import tr
from ui.undo import UndoCommand, UndoStack

if TYPE_CHECKING:
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.run_comparison import RepeatedRun
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.runs.run_store import StoredRun

CatalogAction = Callable[[ModuleType, "Catalog"], object]
"""Does something to a catalog, with the module of kept runs, which is loaded in the thread."""


class RunStore(QObject):
    """Lists, renames and forgets kept runs."""

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
        """Why they could not be read; empty where they were."""

    @property
    def catalog(self) -> Path:
        return self._catalog()

    def find_run(self, number: int | None) -> StoredRun | None:
        return next((one for one in self.runs if one.number == number), None)

    def reload(self) -> None:
        self._do(None)

    def rename(self, number: int, label: str) -> None:
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
        if outcome.number is None:
            return
        self._do(lambda runs, catalog: runs.update_run_means(catalog, outcome))

    def _rename(self, number: int, label: str) -> None:
        self._do(lambda runs, catalog: runs.rename_run(catalog, number, label))

    def _forget(self, number: int) -> None:
        self._do(lambda runs, catalog: runs.forget_run(catalog, number))

    def _recall(self, number: int) -> None:
        self._do(lambda runs, catalog: runs.recall_run(catalog, number))

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
            from gsapp.identification.runs import run_store

            with Catalog(path) as catalog:
                if act is not None:
                    act(run_store, catalog)
                return run_store.stored_runs(catalog)[::-1]

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


class RunController(QObject):
    """Has runs done, one at a time."""

    changed = Signal()
    estimated = Signal(object)

    def __init__(
        self, begin_job: JobSubmitter, run_store: RunStore, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._begin_job = begin_job
        self._run_store = run_store
        self._kept_before: set[int] | None = None
        self.running = False
        self.status_text = ""
        run_store.changed.connect(self._runs_read)

    def estimate(self, request: RunRequest) -> None:
        self._begin()
        job = EstimateJob(request=request, catalog=self._run_store.catalog)
        self._begin_job(job, self._done, failed=self._failed)

    def repeat(self, number: int) -> None:
        if not self.running:
            self._begin()
            job = RepeatJob(catalog=self._run_store.catalog, number=number)
            self._begin_job(job, self._repeated, failed=self._failed)

    def _begin(self) -> None:
        self.running = True
        self.status_text = ""
        self.changed.emit()

    def _done(self, found: object) -> None:
        outcome: RunOutcome = found  # type: ignore[assignment]
        self._run_store.reload()
        self._end(_describe_run_end(outcome), outcome)

    def _repeated(self, found: object) -> None:
        repeated: RepeatedRun = found  # type: ignore[assignment]
        same = (
            tr("Identical to the last bit.") if repeated.is_identical else tr("The results differ.")
        )
        self._end(" ".join((same, *(f"{one}." for one in repeated.differences))), repeated.outcome)

    def _end(self, text: str, outcome: RunOutcome) -> None:
        self.running = False
        self.status_text = text
        self.estimated.emit(outcome)
        self.changed.emit()

    def _failed(self, error: BaseException) -> None:
        self.running = False
        self.status_text = ""
        if isinstance(error, JobCanceledError):
            # Whether it was stopped before it was kept is known when the catalog is read.
            self._kept_before = {run.number for run in self._run_store.runs}
            self._run_store.reload()
        self.changed.emit()

    def _runs_read(self) -> None:
        """Say of a run that was stopped whether it was kept all the same."""
        if self._kept_before is None:
            return
        late = [run.number for run in self._run_store.runs if run.number not in self._kept_before]
        self._kept_before = None
        self.status_text = (
            tr("Stopped when run {late} was already saved; delete it in the list.").format(
                late=late[0]
            )
            if late
            else tr("Stopped; nothing was saved.")
        )
        self.changed.emit()


def count_derivatives(names: Iterable[str]) -> int:
    """Return how many names are derivatives: the constant terms are none."""
    return sum(not name.endswith("_0") for name in names)


def _describe_run_end(outcome: RunOutcome) -> str:
    from gsapp.identification.runs.run_execution import SAME_SAMPLES_TEXT

    results = outcome.result.results
    failed = [one.maneuver.id for one in results if one.estimate is None]
    name = (
        tr("Run {number}").format(number=outcome.number)
        if outcome.number is not None
        else tr("The run")
    )
    parts = [
        tr("{name}: {count} derivatives.").format(
            name=name, count=count_derivatives(outcome.summary.derivatives)
        )
    ]
    grave = (NOT_STORED_TEXT, SAME_SAMPLES_TEXT)
    parts += [join_sentences((one,)) for one in outcome.remarks if one.startswith(grave)]
    if failed:
        parts.append(tr("Not fitted: {failed}.").format(failed=", ".join(failed)))
    if outcome.summary.outlying_maneuvers:
        parts.append(
            tr("Wild: {maneuvers}.").format(
                maneuvers=", ".join(one.maneuver for one in outcome.summary.outlying_maneuvers)
            )
        )
    gusty = [
        one.maneuver.id
        for one in results
        if one.estimate is not None and one.estimate.gusty_maneuvers
    ]
    if gusty:
        parts.append(tr("In gusts, by filter error: {gusty}.").format(gusty=", ".join(gusty)))
    parts.append(
        tr("See Figures ({figures}), Summary ({summary}).").format(
            figures=shortcut_text("Alt+3"), summary=shortcut_text("Alt+4")
        )
    )
    return " ".join(parts)
