"""What is done about a flight's on-board log, and the process that does it. No Qt."""

from __future__ import annotations

from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from ui.job_process.job_runner import ProcessJobRunner
from ui.job_process.job_server import JobProgressCallback, StopEvent, serve_jobs
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.flight.onboard_log.log_storage import InstalledLog
    from gsapp.telemetry.log_download import DownloadState


@dataclass(frozen=True, slots=True, kw_only=True)
class OnboardLogJob:
    """Let a log take the place of the live record; the result is a `OnboardLogResult`."""

    flight: Path
    file: Path | None = None
    link: str | None = None
    """The log that is fetched over this LINK; empty for that of the recorder at work."""
    use: str | None = None
    """A log that lies in the folder; empty for the live record alone."""

    @property
    def title(self) -> str:
        what = tr("Fetching") if self.link is not None else tr("Aligning")
        return tr("{what} the on-board log of {name}").format(what=what, name=self.flight.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnboardLogResult:
    """How a flight stands now."""

    flight: Path
    text: str
    previous_log: str
    """What was in force before; empty for the live record alone."""


_FETCH_SHARE = 0.95
"""Share of the bar when the log has come; then it is aligned."""
_PHASES = {
    "listening": QT_TR_NOOP("listening to the autopilot"),
    "listing": QT_TR_NOOP("requesting the log list"),
    "listed": QT_TR_NOOP("choosing the log of this flight"),
    "done": QT_TR_NOOP("log received"),
}


def create_log_job_runner() -> ProcessJobRunner:
    """Return the process; it begins with its first job."""
    return ProcessJobRunner(
        serve_log_jobs,
        name=tr("work on the log"),
        remedy=tr("start again: the received part of the log is kept"),
    )


def serve_log_jobs(connection: Connection, stop: StopEvent) -> None:
    """Do jobs until the window hangs up; see `ui.job_process.job_server.serve_jobs`."""
    serve_jobs(connection, stop, OnboardLogJobHandler)


class OnboardLogJobHandler:
    """Does one job after the other."""

    def __init__(self, tell: JobProgressCallback) -> None:
        self._report_progress = tell

    def do(self, job: OnboardLogJob) -> OnboardLogResult:
        from gsapp.flight.folder import FlightFolder
        from gsapp.flight.onboard_log.log_storage import activate_log

        if job.use is not None:
            info = FlightFolder.open(job.flight).info()
            self._report_progress(None, QT_TR_NOOP("reading the flight"))
            flight = activate_log(job.flight, job.use)
            state = flight.onboard
            text = state.remark() if state is not None else QT_TR_NOOP("live record only")
            former = info.onboard_log if info is not None else ""
            return OnboardLogResult(
                flight=job.flight, text=f"{flight.name}: {text}.", previous_log=former
            )
        placed = self._fetched(job) if job.link is not None else self._install(job)
        state = placed.flight.onboard
        text = state.remark() if state is not None else ""
        beside = f" {placed.remark}." if placed.remark else ""
        return OnboardLogResult(
            flight=job.flight,
            text=f"{placed.flight.name}: {text}.{beside}",
            previous_log=placed.previous_name,
        )

    def _install(self, job: OnboardLogJob) -> InstalledLog:
        from gsapp.flight.onboard_log.log_storage import install_log
        from gsapp.foundation import FlightError

        if job.file is None:
            raise FlightError("no log was named; choose a file")
        self._report_progress(None, f"comparing {job.file.name} with the live record")
        return install_log(job.flight, job.file)

    def _fetched(self, job: OnboardLogJob) -> InstalledLog:
        from gsapp.flight.onboard_log.log_storage import install_log
        from gsapp.foundation import LinkError
        from gsapp.telemetry.log_download import LogFetcher

        with LogFetcher(job.flight, job.link or "", tell=self._report_download) as fetcher:
            entry = fetcher.select()
            fetched = fetcher.fetch(entry) if entry is not None else None
        if fetched is None:
            raise LinkError("the log was not downloaded; start again")
        self._report_progress(_FETCH_SHARE, QT_TR_NOOP("comparing it with the live record"))
        placed = install_log(job.flight, fetched.path, begun=fetched.start_time)
        fetched.path.unlink(missing_ok=True)
        return placed

    def _report_download(self, state: DownloadState) -> None:
        if state.phase != "fetching":
            self._report_progress(None, _PHASES.get(state.phase, state.phase))
            return
        share = state.received_bytes / state.size if state.size else 0.0
        text = f"{state.received_bytes / 1e6:.1f} of {state.size / 1e6:.1f} MB"
        if state.rate > 0.0:
            text += f", {state.rate / 1e3:.0f} kB/s"
        self._report_progress(_FETCH_SHARE * share, text)
