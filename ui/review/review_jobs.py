"""What the review has done for it in a process of its own. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from ui.translation import tr

if TYPE_CHECKING:
    # The window starts without the numerics behind an estimation.
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.report.ftr_histories import FlightEstimateHistory
    from gsapp.report.linear_report import LinearModelValidation


NOT_STORED_TEXT = "the run is not saved"
"""Begins the remark of an outcome that the catalog did not take."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimateJob:
    """Estimate, and keep the run in a catalog; the result is an `RunOutcome`.

    What cannot be kept is an outcome all the same: without a number, with a remark.

    Attributes
    ----------
    request : RunRequest
    catalog : Path or None
        None keeps nothing.
    """

    request: RunRequest
    catalog: Path | None = None

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return (
            tr("Estimating {label}").format(label=self.request.label)
            if self.request.label
            else tr("Estimating")
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatJob:
    """Do a kept run again from what it was asked for; the result is a `RepeatedRun`."""

    catalog: Path
    number: int

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return tr("Repeating run {number}").format(number=self.number)


@dataclass(frozen=True, slots=True, kw_only=True)
class FtrHistoryJob:
    """Compute FTR over the flights of a request: a tuple of `FlightEstimateHistory`."""

    request: RunRequest

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return tr("Computing FTR over the flights")


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearModelsJob:
    """Hold linear models against flight; the result is a `LinearModelValidation`.

    Attributes
    ----------
    outcome : RunOutcome
    validate : tuple of Path
        Flights kept out of the fits; empty lets the comparison choose.
    """

    outcome: RunOutcome
    validate: tuple[Path, ...] = ()

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return tr("Comparing linear models with flight")


@dataclass(frozen=True, slots=True, kw_only=True)
class RunReportJob:
    """Write the report of an outcome; the result is the path written.

    Attributes
    ----------
    outcome : RunOutcome
    path : Path
        HTML, PDF or a folder.
    units : str
        ``US`` or ``SI``.
    ftr_histories, linear : optional
        What came of a `FtrHistoryJob` and a `LinearModelsJob` of the same outcome; done for the
        report where not given.
    """

    outcome: RunOutcome
    path: Path
    units: str = "US"
    ftr_histories: tuple[FlightEstimateHistory, ...] | None = None
    linear: LinearModelValidation | None = None

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return tr("Writing {name}").format(name=self.path.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualFlightJob:
    """Let the virtual aircraft fly a flight to try the review on; the result is its folder."""

    folder: Path

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return tr("Flying the virtual aircraft")


ReviewJob = (
    EstimateJob | RepeatJob | FtrHistoryJob | LinearModelsJob | RunReportJob | VirtualFlightJob
)


class JobSubmitter(Protocol):
    """How a page has something done: jobs are done one after the other, in the order asked."""

    def __call__(
        self,
        job: ReviewJob,
        done: Callable[[object], None],
        *,
        failed: Callable[[BaseException], None] | None = None,
    ) -> None:
        """Begin a job, or let it wait for those before it.

        Parameters
        ----------
        job : ReviewJob
            One that waits already, or runs, is not done twice; all who asked get its result.
        done : callable
            Receives the result, in the thread of the window.
        failed : callable, optional
            Receives why there is none, `ui.background_job.JobCanceledError` where the user stopped
            it. The window tells of errors in any case.
        """
