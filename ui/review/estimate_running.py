"""Runs on their way: begun, done, repeated, stopped, and what is said of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from ui.commands import key_text
from ui.review.jobs import NOT_KEPT, BeginJob, EstimateJob, RepeatJob
from ui.review.runs_book import RunsBook
from ui.review.runs_lines import derivative_count
from ui.words import sentences
from ui.work import CancelledError

if TYPE_CHECKING:
    from gsapp.identification.runs.outcome import Outcome
    from gsapp.identification.runs.repeating import Repeated
    from gsapp.identification.runs.request import RunRequest


class Runner(QObject):
    """Has runs done, one at a time.

    Parameters
    ----------
    begin_job : BeginJob
        Has a job done.
    book : RunsBook
        Knows the kept runs.

    Attributes
    ----------
    changed : Signal
        A run began or ended.
    estimated : Signal(object)
        An `Outcome` is there.
    running : bool
    told : str
        How the last run ended; empty where there is nothing to say any more.
    """

    changed = Signal()
    estimated = Signal(object)

    def __init__(self, begin_job: BeginJob, book: RunsBook, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._begin_job = begin_job
        self._book = book
        self._kept_before: set[int] | None = None
        self.running = False
        self.told = ""
        book.changed.connect(self._runs_read)

    def estimate(self, request: RunRequest) -> None:
        """Run what is asked for, and keep it."""
        self._begin()
        job = EstimateJob(request=request, catalog=self._book.catalog)
        self._begin_job(job, self._done, failed=self._failed)

    def repeat(self, number: int) -> None:
        """Do a kept run again, exactly."""
        if not self.running:
            self._begin()
            job = RepeatJob(catalog=self._book.catalog, number=number)
            self._begin_job(job, self._repeated, failed=self._failed)

    def _begin(self) -> None:
        self.running = True
        self.told = ""
        self.changed.emit()

    def _done(self, found: object) -> None:
        outcome: Outcome = found  # type: ignore[assignment]
        self._book.read()
        self._end(_ended(outcome), outcome)

    def _repeated(self, found: object) -> None:
        repeated: Repeated = found  # type: ignore[assignment]
        same = "The same to the last bit." if repeated.same else "It is not the same."
        self._end(" ".join((same, *(f"{one}." for one in repeated.differences))), repeated.outcome)

    def _end(self, words: str, outcome: Outcome) -> None:
        self.running = False
        self.told = words
        self.estimated.emit(outcome)
        self.changed.emit()

    def _failed(self, error: BaseException) -> None:
        self.running = False
        self.told = ""
        if isinstance(error, CancelledError):
            # Whether it was stopped before it was kept is known when the catalog is read.
            self._kept_before = {run.number for run in self._book.runs}
            self._book.read()
        self.changed.emit()

    def _runs_read(self) -> None:
        """Say of a run that was stopped whether it was kept all the same."""
        if self._kept_before is None:
            return
        late = [run.number for run in self._book.runs if run.number not in self._kept_before]
        self._kept_before = None
        self.told = (
            f"Stopped when run {late[0]} was kept already; Delete in the list forgets it."
            if late
            else "Stopped; nothing was kept."
        )
        self.changed.emit()


def _ended(outcome: Outcome) -> str:
    """Return how a run ended, in words."""
    from gsapp.identification.runs.outcome import SAME_SAMPLES

    results = outcome.result.results
    failed = [one.maneuver.id for one in results if one.estimate is None]
    name = f"Run {outcome.number}" if outcome.number is not None else "The run"
    said = [f"{name}: {derivative_count(outcome.summary.derivatives)} derivatives."]
    grave = (NOT_KEPT, SAME_SAMPLES)
    said += [sentences((one,)) for one in outcome.remarks if one.startswith(grave)]
    if failed:
        said.append(f"Not fitted: {', '.join(failed)}.")
    if outcome.summary.wild:
        said.append(f"Wild: {', '.join(one.maneuver for one in outcome.summary.wild)}.")
    gusty = [one.maneuver.id for one in results if one.beside is not None]
    if gusty:
        said.append(f"In gusts, equation error beside: {', '.join(gusty)}.")
    said.append(f"Look at Figures ({key_text('Alt+3')}), Summary ({key_text('Alt+4')}).")
    return " ".join(said)
