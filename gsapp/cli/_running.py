"""A run with a bar that shows how far it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.identification.campaign import CampaignResult, Step
    from gsapp.identification.runs.choosing import Doing

Result = TypeVar("Result")


def with_bar(console: Console, work: Callable[[Doing, Step], Result]) -> Result:
    """Return what a piece of work gives, showing on a console how far it is.

    Parameters
    ----------
    console : Console
    work : callable
        Takes what it tells before the fits begin, and what it tells of them.
    """
    from rich.progress import BarColumn, Progress, TimeRemainingColumn

    from gsapp.cli._screen import describing

    columns = (describing(), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def doing(words: str) -> None:
            bar.update(task, total=None, description=words)

        def step(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=what or "done")

        return work(doing, step)


def check_fitted(result: CampaignResult) -> None:
    """Raise `FlightError` where no maneuver gave anything."""
    from gsapp.foundation import FlightError

    failures = [one.failure for one in result.results if one.estimate is None]
    if len(failures) == len(result.results):
        raise FlightError(f"no maneuver could be fitted: {failures[0]}")
