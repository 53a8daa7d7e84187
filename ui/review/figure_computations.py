"""What some figures need to be worked out first, in the process of the review."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from ui.background_job import JobCanceledError
from ui.review.review_jobs import FtrHistoryJob, JobSubmitter, LinearModelsJob, ReviewJob
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary.campaign_linear_models import LinearModelValidation
    from gsapp.report.ftr_histories import FlightEstimateHistory

_PROGRESS_TEXTS = {
    "ftr_histories": QT_TR_NOOP("Computing FTR over the flights, from take-off…"),
    "comparison": QT_TR_NOOP("Fitting linear models and validating them on held-out maneuvers…"),
}


def _input_key(outcome: RunOutcome) -> tuple[object, ...]:
    """Return what FTR listens to: which flights, read how, and the sums of their files."""
    asked = outcome.request
    return asked.flights, asked.aircraft, asked.calibration, asked.channel_map, outcome.inputs


class FigureComputations(QObject):
    """Has things worked out when a figure first asks for them, once for each run.

    Parameters
    ----------
    begin_job : JobSubmitter
    parent : QObject, optional

    Attributes
    ----------
    changed : Signal
        Something is worked out now, or will not be.
    ftr_histories : tuple of FlightEstimateHistory or None
    comparison : LinearModelValidation or None
    """

    changed = Signal()

    def __init__(self, begin_job: JobSubmitter, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._begin_job = begin_job
        self._outcome: RunOutcome | None = None
        self._asked: set[str] = set()
        self._refused: dict[str, str] = {}
        self.ftr_histories: tuple[FlightEstimateHistory, ...] | None = None
        self.comparison: LinearModelValidation | None = None

    def reset(self, outcome: RunOutcome) -> None:
        """Look at another run; what was heard over the same flights is kept."""
        if self._outcome is None or _input_key(self._outcome) != _input_key(outcome):
            self.ftr_histories = None
        self.comparison = None
        self._outcome = outcome
        self._asked.clear()
        self._refused.clear()

    def allow_retry(self) -> None:
        """Let what was stopped or failed be asked for once more."""
        self._asked -= self._refused.keys()
        self._refused.clear()

    def request(self, what: str, outcome: RunOutcome) -> str:
        """Have something worked out; return what is being done, or why it was not, in words."""
        if what in self._refused:
            return self._refused[what]
        if what not in self._asked:
            self._asked.add(what)
            job: ReviewJob = (
                FtrHistoryJob(request=outcome.request)
                if what == "ftr_histories"
                else LinearModelsJob(outcome=outcome)
            )
            run = self._outcome
            self._begin_job(
                job,
                lambda result: self._done(what, run, result),
                failed=lambda error: self._failed(what, run, error),
            )
        return self._refused.get(what) or tr(_PROGRESS_TEXTS[what])

    def _done(self, what: str, run: RunOutcome | None, result: object) -> None:
        # Another run is looked at meanwhile: this one came too late.
        if run is self._outcome:
            setattr(self, what, result)
            self._asked.discard(what)
            self.changed.emit()

    def _failed(self, what: str, run: RunOutcome | None, error: BaseException) -> None:
        if run is self._outcome:
            why = tr("stopped") if isinstance(error, JobCanceledError) else str(error)
            self._refused[what] = tr(
                "Not computed: {why}. Choose this figure again to retry."
            ).format(why=why)
            self.changed.emit()
