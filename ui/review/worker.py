"""The process of the review: it keeps the opened flights for the runs that follow. No Qt."""

from __future__ import annotations

from multiprocessing.connection import Connection

from ui.process.engine import ProcessEngine
from ui.process.serving import Stop, Tell, serve_jobs
from ui.review.jobs import Job


def review_engine() -> ProcessEngine:
    """Return the process of the review; it begins with its first job."""
    return ProcessEngine(serve, name="work", remedy="try fewer flights at once")


def serve(connection: Connection, stop: Stop) -> None:
    """Do jobs until the window hangs up; see `ui.process.serving.serve_jobs`."""
    serve_jobs(connection, stop, ReviewBench)


class ReviewBench:
    """Does jobs one after the other and keeps the flights for the next.

    Parameters
    ----------
    tell : callable
        Says how far the job is; raises where the window does not want it any more.
    """

    def __init__(self, tell: Tell) -> None:
        self._tell = tell

    def do(self, job: Job) -> object:
        """Do one job and return its result."""
        self._tell(None, "starting")
        raise LookupError(job.title)
