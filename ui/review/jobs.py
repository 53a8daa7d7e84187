"""What the review has done for it in a process of its own. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    # The window starts without the numerics behind an estimation.
    from gsapp.identification.runs.outcome import Outcome
    from gsapp.identification.runs.request import RunRequest
    from gsapp.report.hearing import Heard
    from gsapp.report.linear_report import LinearComparison


NOT_KEPT = "the run is not kept"
"""Begins the remark of an outcome that the catalog did not take."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimateJob:
    """Estimate, and keep the run in a catalog; the result is an `Outcome`.

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
        return f"Estimating {self.request.label}" if self.request.label else "Estimating"


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatJob:
    """Do a kept run again from what it was asked for; the result is a `Repeated`."""

    catalog: Path
    number: int

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return f"Repeating run {self.number}"


@dataclass(frozen=True, slots=True, kw_only=True)
class HearJob:
    """Let FTR listen to the flights of a request; the result is a tuple of `Heard`."""

    request: RunRequest

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return "Listening to whole flights"


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearJob:
    """Hold linear models against flight; the result is a `LinearComparison`.

    Attributes
    ----------
    outcome : Outcome
    validate : tuple of Path
        Flights kept out of the fits; empty lets the comparison choose.
    """

    outcome: Outcome
    validate: tuple[Path, ...] = ()

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return "Comparing linear models with flight"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportJob:
    """Write the report of an outcome; the result is the path written.

    Attributes
    ----------
    outcome : Outcome
    path : Path
        HTML, PDF or a folder.
    units : str
        ``US`` or ``SI``.
    heard, linear : optional
        What came of a `HearJob` and a `LinearJob` of the same outcome; done for the report where
        not given.
    """

    outcome: Outcome
    path: Path
    units: str = "US"
    heard: tuple[Heard, ...] | None = None
    linear: LinearComparison | None = None

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return f"Writing {self.path.name}"


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialJob:
    """Let the virtual aircraft fly a flight to try the review on; the result is its folder."""

    folder: Path

    @property
    def title(self) -> str:
        """Return what is being done, in words."""
        return "Flying the virtual aircraft"


Job = EstimateJob | RepeatJob | HearJob | LinearJob | ReportJob | TrialJob


class BeginJob(Protocol):
    """How a page has something done: jobs are done one after the other, in the order asked."""

    def __call__(
        self,
        job: Job,
        done: Callable[[object], None],
        *,
        failed: Callable[[BaseException], None] | None = None,
    ) -> None:
        """Begin a job, or let it wait for those before it.

        Parameters
        ----------
        job : Job
            One that waits already, or runs, is not done twice; all who asked get its result.
        done : callable
            Receives the result, in the thread of the window.
        failed : callable, optional
            Receives why there is none, `ui.work.CancelledError` where the user stopped it. The
            window tells of errors in any case.
        """
