"""Where the calibrations of an aircraft are kept, and how a new one comes in force."""

from __future__ import annotations

import contextlib
import logging
import tempfile
from datetime import datetime
from pathlib import Path

from calibration import Certificate, load_certificates, write_certificate
from calibration.certificate_store import CertificateStore
from calibration.check_record import CheckRecord
from calibration.plan import CalibrationPlan, load_calibration_plan
from gsapp.aircraft import load_aircraft
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import GroundStationError, UnknownNameError, write_atomically
from gsapp.foundation.files import list_files
from gsapp.session import Session
from ui.disk_checks import may_block
from ui.settings import Settings

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
    """The calibrations of one aircraft: plan, certificates, journal.

    Parameters
    ----------
    folder : Path
        Of all aircraft.
    aircraft : str
        Its name.
    usual : str
        Set of certificates that counts for what was never calibrated here; empty for none.

    Attributes
    ----------
    folder, aircraft : Path, str
        As given.
    store : CertificateStore
        The certificates.
    journal : Path
        Where each step of a calibration is kept as it is taken.
    """

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
        """Return what is calibrated: the aircraft's own plan, a shipped one, or the usual one.

        Raises
        ------
        GroundStationError
            If the plan holds mistakes.
        """
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
        """Write the certificates in force into a folder that flights can be made with; return it.

        Raises
        ------
        OSError
            If the disk refuses.
        """
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
        held = sorted(self.store.in_force().values(), key=lambda one: one.stamp)
        return held[-1].who if held else ""

    def copy_to_flight(self, flight: Path) -> bool:
        """Copy what was calibrated here into a flight folder; return whether that changed anything.

        Raises
        ------
        FlightError
            If the disk refuses.
        """
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
