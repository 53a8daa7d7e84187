"""Background jobs shown in banners, and stopped as the window closes."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer

from ui.background_job import BackgroundJob
from ui.translation import tr
from ui.window_frame.banners import Banner, BannerStack

_SHORT_JOB_MS = 300
"""A job that ends sooner gets no banner."""
_STOP_SECONDS = 2.0
"""For a job to stop as the window closes."""


class JobBannerController(QObject):
    """Shows each job in a banner until it ends."""

    def __init__(self, banners: BannerStack, parent: QObject) -> None:
        super().__init__(parent)
        self._banners = banners
        self._unfinished: list[BackgroundJob] = []

    @property
    def unfinished_jobs(self) -> tuple[str, ...]:
        """Return the titles of the jobs that make something and are not done."""
        return tuple(job.title for job in self._unfinished)

    def stop_jobs(self) -> None:
        """Stop the jobs that make something, as the window closes, and let them clean up."""
        for job in self._unfinished:
            job.cancel()
        for job in self._unfinished:
            job.wait(_STOP_SECONDS)

    def show_job(self, job: BackgroundJob, done: str) -> None:
        """Show a job until it ends, whatever page is on screen.

        A job that makes something has a sentence for its end, shown also where the job was done
        before it could be canceled. Nothing is shown of a job that another replaced.
        """
        title = f"{job.title}…"
        shown: list[Banner] = []
        asked: list[bool] = []
        made: list[bool] = []
        if done:
            self._unfinished.append(job)

        def cancel() -> None:
            asked.append(True)
            job.cancel()

        def begin() -> None:
            if job.is_running:
                shown.append(self._banners.show_banner("work", title, (tr("Cancel"), cancel)))

        def show_progress(share: float | None, words: str) -> None:
            for banner in shown:
                banner.set_progress(share)
                banner.set_text(f"{title} {words}")

        def end(sentence: str) -> None:
            if job in self._unfinished:
                self._unfinished.remove(job)
            for banner in shown:
                self._banners.remove(banner)
            if sentence:
                self._banners.show_banner("note", sentence)

        job.progressed.connect(show_progress)
        job.done.connect(lambda _result: end(done))
        job.discarded.connect(lambda _result: made.append(True))
        job.canceled.connect(
            lambda: end(
                done
                if made and done
                else tr("{title}: cancelled.").format(title=job.title)
                if asked
                else ""
            )
        )
        job.failed.connect(lambda _error: end(""))
        QTimer.singleShot(_SHORT_JOB_MS, begin)
