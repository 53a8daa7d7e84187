"""A run with a bar that shows how far it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.identification.campaign import CampaignProgressCallback
    from gsapp.identification.runs.inputs import StatusCallback
    from gsapp.identification.runs.run_execution import RunOutcome

WorkResult = TypeVar("WorkResult")


def run_with_progress_bar(
    console: Console, work: Callable[[StatusCallback, CampaignProgressCallback], WorkResult]
) -> WorkResult:
    """Return what a piece of work gives, showing on a console how far it is.

    Parameters
    ----------
    console : Console
    work : callable
        Takes what it tells before the fits begin, and what it tells of them.
    """
    from rich.progress import BarColumn, Progress, TimeRemainingColumn

    from gsapp.cli._console import description_column

    columns = (description_column(), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def doing(words: str) -> None:
            bar.update(task, total=None, description=words)

        def step(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=what or "done")

        return work(doing, step)


def check_fitted(outcome: RunOutcome) -> None:
    """Raise `FlightError` where no maneuver gave anything; what is uncalibrated comes first."""
    from gsapp.foundation import FlightError

    results = outcome.result.results
    failures = [one.failure for one in results if one.estimate is None]
    if len(failures) == len(results):
        causes = (*outcome.uncalibrated, failures[0])
        raise FlightError(f"no maneuver could be fitted: {'; '.join(causes)}")
