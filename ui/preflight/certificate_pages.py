"""Certificates on paper: one page for each that is in force, written in the background."""

from __future__ import annotations

from pathlib import Path

from calibration.overview import overview
from gsapp.foundation import FlightError
from ui.desk import Desk
from ui.preflight.shelf import Shelf, local_now
from ui.work import Progress, Work


class CertificatePages:
    """Writes the pages of what was calibrated.

    Parameters
    ----------
    desk : Desk
        Shows the progress, and says where the pages are.

    Attributes
    ----------
    work : Work or None
        Under way.
    """

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self.work: Work | None = None

    def write(self, shelf: Shelf, units: str) -> None:
        """Write a PDF for every certificate in force that was made here; once at a time.

        Raises
        ------
        FlightError
            If there is none yet.
        """
        if self.work is not None and self.work.running:
            return
        folder = shelf.store.in_force_folder.parent
        if not shelf.store.in_force():
            raise FlightError(
                f"nothing was calibrated on the {shelf.aircraft} yet: there is no certificate to "
                "print"
            )
        work = Work(
            "Writing the certificates", lambda told: _write(folder, units, told), parent=self._desk
        )
        work.done.connect(self._written)
        work.failed.connect(self._desk.faults.report)
        self.work = work
        self._desk.working.emit(work, "")
        work.start()

    def _written(self, pages: tuple[Path, ...]) -> None:
        count = "1 page is" if len(pages) == 1 else f"{len(pages)} pages are"
        self._desk.said.emit(
            "note", f"{count} written, one for each certificate: {pages[0].parent}."
        )


def _write(folder: Path, units: str, told: Progress) -> tuple[Path, ...]:
    from gsapp.report.certificate_report import write_certificate_report

    standing = overview(folder).standing
    pages = []
    for number, one in enumerate(standing):
        told(number / len(standing), f"Drawing {one.certificate.channel}")
        page = folder / "pages" / f"{one.certificate.channel}.pdf"
        pages.append(
            write_certificate_report(
                one,
                page,
                written=f"{local_now():%Y-%m-%d %H:%M}",
                units="SI" if units == "SI" else "US",
            )
        )
    return tuple(pages)
