"""How far jobs are: in a panel on their page, in banners elsewhere."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFrame, QHBoxLayout, QSizePolicy

from ui.background_job import BackgroundJob
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.action_button import ActionButton
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import create_label
from ui.window_frame.banners import Banner, BannerStack, JobProgressBar


class JobProgressPanel(QFrame):
    """Across the top of a place while something runs there."""

    def __init__(self, style: DisplayStyle, cancel: QAction, name: str) -> None:
        super().__init__()
        self._style = style
        self.setObjectName("banner")
        self.setAccessibleName(tr("{name} that runs").format(name=name.capitalize()))
        row = arrange(
            QHBoxLayout(self), style.px(12), style.px(16), style.px(6), style.px(8), style.px(6)
        )
        self.title = ""
        self.text_label = create_label("", wrap=True)
        self.text_label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        row.addWidget(self.text_label, 1)
        self.progress_bar = JobProgressBar(style)
        self.progress_bar.setAccessibleName(tr("Progress of the {name}").format(name=name))
        row.addWidget(self.progress_bar)
        self.stop_button = ActionButton(cancel, tr("Stop"), style)
        row.addWidget(self.stop_button)
        style.changed.connect(self._rescale)
        self._rescale()
        self.hide()

    def _rescale(self) -> None:
        self.progress_bar.setFixedSize(self._style.px(160), self._style.px(8))

    def start(self, title: str) -> None:
        self.title = title
        self.text_label.setText(tr("{title}: starting").format(title=title))
        self.progress_bar.set_share(None)
        self.show()

    def set_progress(self, share: float | None, text: str) -> None:
        self.progress_bar.set_share(share)
        self.text_label.setText(f"{self.title}: {text}")


class JobBanner:
    """One banner, there or not."""

    def __init__(self, banners: BannerStack, stop: Callable[[], object]) -> None:
        self._banners = banners
        self._stop = stop
        self._banner: Banner | None = None
        self._end: Banner | None = None
        self._title = ""

    def show(self, title: str) -> None:
        """Tell of a work from now on."""
        self.remove()
        self._title = title
        self._banner = self._banners.show_banner("work", title, (tr("Stop"), self._stop))

    def set_progress(self, share: float | None, text: str) -> None:
        """Say how far it is, where the banner is there."""
        if self._banner is not None:
            self._banner.set_progress(share)
            self._banner.set_text(f"{self._title}: {text}")

    def remove(self) -> None:
        if self._banner is not None:
            self._banners.remove(self._banner)
            self._banner = None

    def show_result(self, text: str, offer: str, style: Callable[[], object]) -> None:
        """Tell what came of a work, and offer to look at it."""
        self.clear()
        self._end = self._banners.show_banner("note", text, (offer, style))

    def clear(self) -> None:
        """Tell nothing here of what the place itself shows now."""
        self.remove()
        if self._end is not None:
            self._banners.remove(self._end)
            self._end = None


_SHORT_JOB_MS = 300  # A job that ends sooner gets no banner.
_STOP_SECONDS = 2.0  # For a job to stop as the window closes.


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

        def show_progress(share: float | None, text: str) -> None:
            for banner in shown:
                banner.set_progress(share)
                banner.set_text(f"{title} {text}")

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
