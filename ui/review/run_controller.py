"""Runs on their way: begun, done, repeated, stopped, and what is said of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from ui.background_job import JobCanceledError
from ui.commands import shortcut_text
from ui.number_format import join_sentences
from ui.review.review_jobs import NOT_STORED_TEXT, EstimateJob, JobSubmitter, RepeatJob
from ui.review.run_rows import count_derivatives
from ui.review.run_store import RunStore
from ui.translation import tr

if TYPE_CHECKING:
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.run_comparison import RepeatedRun
    from gsapp.identification.runs.run_execution import RunOutcome


class RunController(QObject):
    """Has runs done, one at a time.

    Parameters
    ----------
    begin_job : JobSubmitter
        Has a job done.
    run_store : RunStore
        Knows the kept runs.

    Attributes
    ----------
    changed : Signal
        A run began or ended.
    estimated : Signal(object)
        An `RunOutcome` is there.
    running : bool
    status_text : str
        How the last run ended; empty where there is nothing to say any more.
    """

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
        """Run what is asked for, and keep it."""
        self._begin()
        job = EstimateJob(request=request, catalog=self._run_store.catalog)
        self._begin_job(job, self._done, failed=self._failed)

    def repeat(self, number: int) -> None:
        """Do a kept run again, exactly."""
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

    def _end(self, words: str, outcome: RunOutcome) -> None:
        self.running = False
        self.status_text = words
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


def _describe_run_end(outcome: RunOutcome) -> str:
    """Return how a run ended, in words."""
    from gsapp.identification.runs.run_execution import SAME_SAMPLES_TEXT

    results = outcome.result.results
    failed = [one.maneuver.id for one in results if one.estimate is None]
    name = (
        tr("Run {number}").format(number=outcome.number)
        if outcome.number is not None
        else tr("The run")
    )
    said = [
        tr("{name}: {count} derivatives.").format(
            name=name, count=count_derivatives(outcome.summary.derivatives)
        )
    ]
    grave = (NOT_STORED_TEXT, SAME_SAMPLES_TEXT)
    said += [join_sentences((one,)) for one in outcome.remarks if one.startswith(grave)]
    if failed:
        said.append(tr("Not fitted: {failed}.").format(failed=", ".join(failed)))
    if outcome.summary.outlying_maneuvers:
        said.append(
            tr("Wild: {maneuvers}.").format(
                maneuvers=", ".join(one.maneuver for one in outcome.summary.outlying_maneuvers)
            )
        )
    gusty = [one.maneuver.id for one in results if one.equation_error_estimate is not None]
    if gusty:
        said.append(
            tr("In gusts, compare with equation error: {gusty}.").format(gusty=", ".join(gusty))
        )
    said.append(
        tr("See Figures ({figures}), Summary ({summary}).").format(
            figures=shortcut_text("Alt+3"), summary=shortcut_text("Alt+4")
        )
    )
    return " ".join(said)
