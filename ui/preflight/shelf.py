"""Where the calibrations of an aircraft are kept, and how a new one comes in force."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path

from calibration import Certificate, load_certificates
from calibration.plan import CalibrationPlan, load_plan
from calibration.store import CertificateStore
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import GroundStationError, UnknownNameError

log = logging.getLogger(__name__)

_JOURNAL = "calibration.jsonl"
_PLANS = "plans"
_USUAL_PLAN = "b777"


def calibrations_path(settings: Path) -> Path:
    """Return the folder of all aircraft's calibrations that belongs to a settings file."""
    return settings.parent / "calibrations"


class Shelf:
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
    store : CertificateStore
        The certificates.
    journal : Path
        Where each step of a calibration is kept as it is taken.
    """

    def __init__(self, folder: Path, aircraft: str, usual: str = "") -> None:
        self.aircraft = aircraft
        self._folder = folder
        self._usual = usual
        self.store = CertificateStore(folder, aircraft)
        self.journal = self.store.in_force_folder.parent / _JOURNAL

    def plan(self) -> CalibrationPlan:
        """Return what is calibrated: the aircraft's own plan, a shipped one, or the usual one.

        Raises
        ------
        GroundStationError
            If the plan holds mistakes.
        """
        own = self._folder / _PLANS / f"{self.aircraft}.toml"
        if own.is_file():
            return load_plan(own)
        try:
            return load_plan(self.aircraft)
        except UnknownNameError:
            return load_plan(_USUAL_PLAN)

    def fill(self) -> None:
        """Take in the certificates that counted so far, for channels never calibrated here.

        Without them a flight made with this shelf would have no throttle and no temperature, and
        the first calibration nothing to be compared with.
        """
        if not self._usual or Path(self._usual) == self.store.in_force_folder:
            return
        try:
            known = load_certificates(self._usual)
        except GroundStationError as error:
            log.warning("certificates not taken in: %s", error)
            return
        left = self.store.skipped()
        held = self.store.in_force()
        for name, certificate in known.items():
            if name not in held and name not in left and not self.store.history(name):
                self.store.put(certificate)

    def certificates(self) -> dict[str, Certificate]:
        """Return the certificates in force."""
        return self.store.in_force()

    def keep_with(self, flight: Path) -> tuple[str, ...]:
        """Copy the certificates in force into a flight folder; return the channels that changed.

        Raises
        ------
        FlightError
            If the disk refuses.
        """
        folder = FlightFolder.open(flight)
        files = _files(self.store.in_force_folder)
        before = {path.stem: path.read_bytes() for path in folder.certificate_files()}
        after = {path.stem: path.read_bytes() for path in files}
        changed = tuple(
            sorted(name for name in {*before, *after} if before.get(name) != after.get(name))
        )
        if changed:
            folder.keep_certificates(files)
        return changed


def _files(folder: Path) -> tuple[Path, ...]:
    return tuple(sorted(folder.glob("*.toml")))


def local_now() -> datetime:
    """Return the time of day with its zone."""
    return datetime.now().astimezone()


def standing_of(channels: Iterable[str], shelf: Shelf) -> tuple[tuple[str, str], ...]:
    """Return for each channel whether and since when it is calibrated, in words."""
    held, left = shelf.store.in_force(), shelf.store.skipped()
    found = []
    for name in channels:
        certificate = held.get(name)
        if certificate is not None:
            by = f" by {certificate.who}" if certificate.who else ""
            found.append((name, f"{certificate.stamp:%d %b %Y %H:%M}{by}"))
        elif name in left:
            found.append((name, f"uncalibrated: {left[name].reason}"))
        else:
            found.append((name, "uncalibrated"))
    return tuple(found)
