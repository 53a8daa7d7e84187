"""Runs searches behind the window and keeps their answers; decisions can be undone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from ui.background_job import BackgroundJob, JobProgress
from ui.gap.search_jobs import GapJob, GapReportJob, GapRequest, SearchResult, serve_gap_jobs
from ui.job_process.job_runner import JobRunner, ProcessJobRunner
from ui.translation import tr
from ui.undo import UndoCommand, UndoStack

_RESULT_CACHE_SIZE = 8
"""Answers kept for going back."""


def create_search_job_runner() -> ProcessJobRunner:
    """Return the process that searches; it begins with its first job."""
    return ProcessJobRunner(serve_gap_jobs, name=tr("search"), remedy=tr("use fewer flights"))


class GapSearch(QObject):
    """The search of the window: at most one runs; the result stays until another one comes."""

    began = Signal(object)
    """A `BackgroundJob` begins: a search, or a report being written."""
    progressed = Signal(object, str)
    """Share done or None, and what is being done with the time left."""
    ended = Signal(str)
    """The work ended: ``found``, ``written``, ``cancelled`` or ``failed``."""
    changed = Signal()
    written = Signal(object)

    def __init__(
        self,
        job_runner: JobRunner,
        report_error: Callable[[BaseException], None],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._job_runner = job_runner
        self._report_error = report_error
        self._job: BackgroundJob | None = None
        self.result: SearchResult | None = None
        self._decision = ""
        self.undo_stack = UndoStack(self)
        self.undo_stack.setUndoLimit(_RESULT_CACHE_SIZE)

    @property
    def running(self) -> bool:
        return self._job is not None and self._job.is_running

    @property
    def title(self) -> str:
        return self._job.title if self._job is not None else ""

    def search(self, request: GapRequest) -> None:
        self._start_search(request, tr("Searching for missing effects"), tr("search"))

    def refuse(self, effect: str, title: str) -> None:
        """Search again without an effect."""
        if self.result is not None:
            self._start_search(
                self.result.request.refuse(effect),
                tr("Searching without “{title}”").format(title=title),
                tr("refuse {title}").format(title=title),
            )

    def force(self, effect: str, title: str) -> None:
        """Search again with an effect in the model, whatever its evidence."""
        if self.result is not None:
            self._start_search(
                self.result.request.force(effect),
                tr("Searching with “{title}”").format(title=title),
                tr("force {title}").format(title=title),
            )

    def _show_answer(self, result: SearchResult) -> None:
        self.result = result
        self.changed.emit()

    def write_report(self, path: Path, units: str) -> None:
        result = self.result
        if result is None or self.running:
            return
        job = GapReportJob(result=result, path=path, units=units)
        self._start(tr("Writing {name}").format(name=path.name), job, self._report_done)

    def cancel(self) -> None:
        """Stop what runs; what was known before stays."""
        if self._job is not None:
            self._job.cancel()

    def close(self) -> None:
        self.cancel()
        self._job_runner.close()

    def _start_search(self, request: GapRequest, title: str, decision: str) -> None:
        if self.running:
            return
        self._decision = decision
        self._start(title, request, self._found)

    def _start(self, title: str, job: GapJob, done: Callable[[object], None]) -> None:
        def run(progress: JobProgress) -> object:
            return self._job_runner.do(job, progress)

        work = BackgroundJob(title, run, self)
        self._job = work
        work.progressed.connect(self.progressed)
        work.done.connect(done)
        work.canceled.connect(lambda: self.ended.emit("cancelled"))
        work.failed.connect(self._failed)
        work.start()
        self.began.emit(work)

    def _found(self, result: object) -> None:
        if not isinstance(result, SearchResult):
            return
        former = self.result
        if former is not None and result.continues(former):
            command = UndoCommand(
                self._decision,
                lambda: self._show_answer(former),
                lambda: self._show_answer(result),
            )
            self.undo_stack.push(command)
        else:
            self.undo_stack.clear()
        self.ended.emit("found")
        self._show_answer(result)

    def _report_done(self, path: object) -> None:
        self.ended.emit("written")
        self.written.emit(path)

    def _failed(self, error: BaseException) -> None:
        self.ended.emit("failed")
        self._report_error(error)
