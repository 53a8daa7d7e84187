"""What of a run is written where: the report, everything in a folder, or one file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, QUrl, Signal
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QFileDialog, QWidget

from ui.background_job import BackgroundJob, JobCanceledError, JobProgress
from ui.dialogs.file_dialogs import ask_save_file
from ui.number_format import sanitize_file_name
from ui.review.review_jobs import JobSubmitter, RunReportJob
from ui.settings import SettingsStore, initial_dialog_folder
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary.campaign_linear_models import LinearModelValidation

_REPORT_FILTER: Final = QT_TR_NOOP("HTML (*.html);;PDF (*.pdf)")


class SummaryExporter(QObject):
    """Asks for a place and writes: reports in the process of the review, files in a thread."""

    status_reported = Signal(str)

    def __init__(self, store: SettingsStore, begin_job: JobSubmitter, parent: QWidget) -> None:
        super().__init__(parent)
        self._store = store
        self._begin_job = begin_job
        self._window = parent
        self._job: BackgroundJob | None = None
        self.written: Path | None = None

    def export_report(
        self,
        outcome: RunOutcome,
        units: str,
        linear: LinearModelValidation | None,
        *,
        everything: bool = False,
    ) -> None:
        """Ask for a file and write the report there; or for a folder, and write all files, too."""
        if everything:
            title = tr("Write report and files into this folder")
            chosen = QFileDialog.getExistingDirectory(self._window, title, str(self._folder()))
            path = Path(chosen) if chosen else None
        else:
            start = self._folder() / f"{_export_title(outcome)} report.html"
            path = ask_save_file(self._window, tr("Write the report"), start, tr(_REPORT_FILTER))
        if path is not None:
            self._remember(path if path.is_dir() else path.parent)
            job = RunReportJob(outcome=outcome, path=path, units=units, linear=linear)
            self._begin_job(job, self._done, failed=lambda error: self._failed(path, error))

    def export_file(
        self, outcome: RunOutcome, name: str, linear: LinearModelValidation | None
    ) -> None:
        """Ask for a place and write one of the files of a campaign there."""
        ending = Path(name).suffix
        start = self._folder() / f"{_export_title(outcome)} {name}"
        kind = f"{ending[1:].upper()} (*{ending})"
        path = ask_save_file(self._window, tr("Write the file"), start, kind)
        if path is None:
            return
        self._remember(path.parent)

        def run(_progress: JobProgress) -> Path:
            from gsapp.foundation import write_atomically
            from gsapp.report.estimate_export import file_content

            return write_atomically(path, file_content(name, outcome, linear))

        work = BackgroundJob(tr("Writing {name}").format(name=path.name), run, self)
        work.done.connect(self._done)
        work.failed.connect(lambda error: self._failed(path, error))
        self._job = work
        work.start()

    def open_written(self) -> None:
        if self.written is not None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.written)))

    def _done(self, path: object) -> None:
        self.written = Path(str(path))
        self.status_reported.emit(tr("Written: {written}").format(written=self.written))

    def _failed(self, path: Path, error: BaseException) -> None:
        why = tr("stopped; nothing was written") if isinstance(error, JobCanceledError) else error
        self.status_reported.emit(
            tr("{name} was not written: {why}").format(name=path.name, why=why)
        )

    def _folder(self) -> Path:
        return initial_dialog_folder(self._store.current, self._store.current.review_folder)

    def _remember(self, folder: Path) -> None:
        self._store.change(review_folder=str(folder))


def _export_title(outcome: RunOutcome) -> str:
    flights = [path.stem for path in outcome.request.flights]
    names = (
        flights[0]
        if len(flights) == 1
        else tr("{flight} and {count} more").format(flight=flights[0], count=len(flights) - 1)
    )
    label = outcome.request.label.strip()
    return sanitize_file_name(label) or names
