"""The calibrations of an aircraft: where they are kept, how new ones come in force, on paper."""

from __future__ import annotations

import contextlib
import logging
import tempfile
from datetime import datetime
from pathlib import Path

from calibration import Certificate, load_certificates, write_certificate
from calibration.certificate_store import CertificateStore, CheckRecord, load_certificate_overview
from calibration.plan import CalibrationPlan, load_calibration_plan
from gsapp.aircraft import load_aircraft
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import FlightError, GroundStationError, UnknownNameError, write_atomically
from gsapp.foundation.files import list_files
from gsapp.session import Session
from ui.background_job import BackgroundJob, JobProgress
from ui.disk_checks import may_block, path_kind
from ui.flight_controller import FlightController
from ui.preflight.practice_bench import PracticeBench
from ui.settings import Settings, SettingsStore, calibrations_path
from ui.translation import tr

log = logging.getLogger(__name__)

_JOURNAL = "calibration.jsonl"
_PLANS_FOLDER = "plans"
_DEFAULT_PLAN = "b777"


def practice_folder(settings: Path) -> Path:
    """Return the folder of what was calibrated for practice only."""
    return settings.parent / "practice"


def find_current_aircraft(session: Session | None, settings: Settings) -> str:
    """Return the name of the aircraft whose calibrations are meant.

    That of the open flight, or of the file with which an aircraft was connected last.
    """
    if session is not None and session.aircraft is not None:
        return session.aircraft.name
    if not may_block(settings.aircraft):
        # What is wrong with it is said where an aircraft is connected with it.
        with contextlib.suppress(GroundStationError):
            return load_aircraft(settings.aircraft).name
    return Path(settings.aircraft).stem.upper()


class CalibrationFolder:
    """The calibrations of one aircraft: plan, certificates, journal."""

    def __init__(self, folder: Path, aircraft: str, usual: str = "") -> None:
        self.aircraft = aircraft
        self.folder = folder
        self._usual = usual
        self.store = CertificateStore(folder, aircraft)
        self._root = self.store.in_force_folder.parent
        self._kept = self._root / "before"
        self._began: dict[Path, dict[str, bytes]] = {}
        self.journal = self._root / _JOURNAL

    def load_plan_in_use(self) -> CalibrationPlan:
        """Return what is calibrated: the aircraft's own plan, a shipped one, or the usual one."""
        own = self.folder / _PLANS_FOLDER / f"{self.aircraft}.toml"
        if own.is_file():
            return load_calibration_plan(own)
        try:
            return load_calibration_plan(self.aircraft)
        except UnknownNameError:
            return load_calibration_plan(_DEFAULT_PLAN)

    def certificates_in_force(self) -> dict[str, Certificate]:
        """Return the certificates in force by channel.

        Those of the usual set count for what was never calibrated here.
        """
        left = self.store.skipped_channels()
        known = {name: one for name, one in self._usual_ones().items() if name not in left}
        return {**known, **self.store.in_force()}

    def last_checks(self) -> dict[str, CheckRecord]:
        """Return the last check of each certificate in force that was checked, by channel."""
        found = {}
        for name in self.store.in_force():
            try:
                checked = self.store.last_check(name)
            except GroundStationError as error:
                log.warning("check not taken: %s", error)
                continue
            if checked is not None:
                found[name] = checked
        return found

    def _usual_ones(self) -> dict[str, Certificate]:
        source = self._kept if self._kept.is_dir() else self._usual
        if not source:
            return {}
        try:
            return load_certificates(source)
        except GroundStationError as error:
            log.warning("certificates not taken: %s", error)
            return {}

    def write_flight_certificates(self) -> Path:
        """Write the certificates in force into a folder to make flights with; return it."""
        if not self._kept.is_dir():
            # What counted before anything was calibrated here is kept, for what never is.
            for certificate in self._usual_ones().values():
                write_certificate(certificate, self._kept / f"{certificate.channel}.toml")
        folder = self._root / "flights"
        wanted = {path.name: path.read_bytes() for path in list_files(self._kept, "*.toml")}
        for name in self.store.skipped_channels():
            wanted.pop(f"{name}.toml", None)
        for path in list_files(self.store.in_force_folder, "*.toml"):
            wanted[path.name] = path.read_bytes()
        for name, content in wanted.items():
            target = folder / name
            if not target.is_file() or target.read_bytes() != content:
                write_atomically(target, content)
        for old in list_files(folder, "*.toml"):
            if old.name not in wanted:
                old.unlink()
        return folder

    def last_operator(self) -> str:
        """Return who calibrated last here."""
        # A stamp without a zone is the field's local time.
        held = sorted(self.store.in_force().values(), key=lambda one: one.stamp.astimezone())
        return held[-1].who if held else ""

    def copy_to_flight(self, flight: Path) -> bool:
        """Copy what was calibrated here into a flight folder; return whether it changed."""
        folder = FlightFolder.open(flight)
        before = {path.stem: path.read_bytes() for path in folder.certificate_files()}
        # As the flight began, where nothing made here counts any more.
        began = self._began.setdefault(flight, before)
        held = {path.stem: path for path in list_files(self.store.in_force_folder, "*.toml")}
        left = self.store.skipped_channels()
        after = {name: one for name, one in began.items() if name not in left}
        after |= {name: path.read_bytes() for name, path in held.items()}
        if after == before:
            return False
        with tempfile.TemporaryDirectory() as scratch:
            for name, content in after.items():
                Path(scratch, f"{name}.toml").write_bytes(content)
            folder.store_certificates(sorted(Path(scratch).iterdir()))
        return True


def current_local_time() -> datetime:
    """Return the time of day with its zone."""
    return datetime.now().astimezone()


_DEFAULT_CERTIFICATES = "b777"


class CalibrationController:
    """The calibrations of the current aircraft, and their way into flights.

    Parameters
    ----------
    controller : FlightController
        The open flight.
    store : SettingsStore
        Remembers which certificates flights are made with.
    practice : PracticeBench
        What is calibrated while it runs never counts for an aircraft.
    """

    def __init__(
        self, controller: FlightController, store: SettingsStore, practice: PracticeBench
    ) -> None:
        self._controller = controller
        self._store = store
        self._practice = practice
        self._calibrations: CalibrationFolder | None = None
        self._changed_flight: Path | None = None

    @property
    def folder(self) -> CalibrationFolder:
        name = find_current_aircraft(self._controller.session, self._store.current)
        practices = self._practice.running
        settings = self._store.path
        folder = practice_folder(settings) if practices else calibrations_path(settings)
        calibrations = self._calibrations
        if calibrations is None or (calibrations.folder, calibrations.aircraft) != (folder, name):
            usual = _DEFAULT_CERTIFICATES if practices else self._store.current.calibration
            calibrations = self._calibrations = CalibrationFolder(folder, name, usual)
        return calibrations

    def apply(self, calibrations: CalibrationFolder) -> None:
        """Use these certificates for the open flight and those to come."""
        if calibrations.folder != practice_folder(self._store.path):
            self._store.change(calibration=str(calibrations.write_flight_certificates()))
        session = self._controller.session
        if (
            session is not None
            and session.replay_feed is None
            and path_kind(session.path) == "folder"
            and calibrations is self.folder
            and calibrations.copy_to_flight(session.path)
        ):
            self._changed_flight = session.path

    def reload_flight(self) -> None:
        """Read the open flight with the certificates put in force: as any replay will."""
        session, stale = self._controller.session, self._changed_flight
        self._changed_flight = None
        if session is not None and session.path == stale:
            self._controller.flight_opener.open_flight(stale)


class CertificatePrinter:
    """Writes the pages of what was calibrated."""

    def __init__(self, controller: FlightController) -> None:
        self._controller = controller
        self.work: BackgroundJob | None = None

    def write(self, calibrations: CalibrationFolder, units: str) -> None:
        """Write a PDF for every certificate in force that was made here; once at a time."""
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
    for index, one in enumerate(standing):
        told(index / len(standing), tr("Drawing {channel}").format(channel=one.certificate.channel))
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
