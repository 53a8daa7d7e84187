"""Certificates on paper: one page for each that is in force, written in the background."""

from __future__ import annotations

from pathlib import Path

from calibration.certificate_overview import load_certificate_overview
from gsapp.foundation import FlightError
from ui.background_job import BackgroundJob, JobProgress
from ui.flight_controller import FlightController
from ui.preflight.calibration_folder import CalibrationFolder, current_local_time
from ui.translation import tr


class CertificatePrinter:
    """Writes the pages of what was calibrated.

    Parameters
    ----------
    controller : FlightController
        Shows the progress, and says where the pages are.

    Attributes
    ----------
    work : BackgroundJob or None
        Under way.
    """

    def __init__(self, controller: FlightController) -> None:
        self._controller = controller
        self.work: BackgroundJob | None = None

    def write(self, calibrations: CalibrationFolder, units: str) -> None:
        """Write a PDF for every certificate in force that was made here; once at a time.

        Raises
        ------
        FlightError
            If there is none yet.
        """
        if self.work is not None and self.work.is_running:
            return
        folder = calibrations.store.in_force_folder.parent
        if not calibrations.store.in_force():
            raise FlightError(
                tr(
                    "no instrument was calibrated on the {aircraft}; no certificate to print"
                ).format(aircraft=calibrations.aircraft)
            )
        work = BackgroundJob(
            tr("Writing the certificates"),
            lambda told: _write_pages(folder, units, told),
            parent=self._controller,
        )
        work.done.connect(self._written)
        work.failed.connect(self._controller.error_reporter.report)
        self.work = work
        self._controller.job_started.emit(work, "")
        work.start()

    def _written(self, pages: tuple[Path, ...]) -> None:
        count = (
            tr("1 page is") if len(pages) == 1 else tr("{count} pages are").format(count=len(pages))
        )
        self._controller.message_posted.emit(
            "note",
            tr("{count} written, one per certificate: {parent}.").format(
                count=count, parent=pages[0].parent
            ),
        )


def _write_pages(folder: Path, units: str, told: JobProgress) -> tuple[Path, ...]:
    from gsapp.report.certificate_report import write_certificate_report

    standing = load_certificate_overview(folder).in_force
    pages = []
    for number, one in enumerate(standing):
        told(
            number / len(standing), tr("Drawing {channel}").format(channel=one.certificate.channel)
        )
        page = folder / "pages" / f"{one.certificate.channel}.pdf"
        pages.append(
            write_certificate_report(
                one,
                page,
                written=f"{current_local_time():%Y-%m-%d %H:%M}",
                units="SI" if units == "SI" else "US",
            )
        )
    return tuple(pages)
