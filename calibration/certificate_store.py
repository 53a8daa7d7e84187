"""The certificates of one aircraft: which are in force, which were, what is uncalibrated.

::

    <folder>/<aircraft>/
        history/elevator_left/0001-2026-05-12T083100.toml             a certificate
        history/elevator_left/0002-skipped.toml                       "uncalibrated" from here on
        history/elevator_left/0003-2026-05-13T090210.toml.withdrawn   taken back
        in_force/elevator_left.toml                                   what flights are made with
        checks/elevator_left/2026-05-12T113000.toml                   three-point checks

The history is the truth: each change adds or renames one file of it, so that a change is made
whole or not at all, whenever the power fails. The newest entry that was not withdrawn is in
force. `in_force` follows from the history, and is put right whenever a store is opened.
"""

from __future__ import annotations

import contextlib
import logging
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from urllib.parse import quote, unquote

from pydantic import ConfigDict, Field

from calibration.certificate import Certificate
from calibration.certificate_toml import (
    certificate_content,
    certificate_paths,
    load_certificate,
    load_certificates,
    write_certificate,
)
from calibration.curve_selection import fit_calibration
from calibration.drift import CheckResult, Drift, compute_drift
from calibration.points import CalibrationError
from calibration.quality import CalibrationQuality
from gsapp.foundation import (
    FileProblemsError,
    StrictModel,
    read_toml,
    toml_text,
    write_atomically,
    write_toml,
)
from gsapp.foundation.file_lock import FileLock
from gsapp.foundation.files import list_files
from gsapp.quantities import channel


class CheckRecord(StrictModel):
    """A three-point check of one instrument, as its file holds it."""

    model_config = ConfigDict(populate_by_name=True)

    channel: str
    who: str
    stamp: datetime
    certificate: datetime
    """Stamp of the certificate that was checked."""
    unit: str
    result: CheckResult = Field(alias="check")


log = logging.getLogger(__name__)

_ENTRY = re.compile(r"(?P<number>\d{4,})-(?P<rest>.+)\.toml")
_SKIPPED = "skipped"
_WITHDRAWN = ".withdrawn"
_STAMP = "%Y-%m-%dT%H%M%S"


class SkippedChannel(StrictModel):
    """Why a channel is uncalibrated."""

    channel: str
    reason: str
    who: str
    stamp: datetime
    """When, to the second."""


class CertificateStore:
    """Certificates of an aircraft on disk."""

    def __init__(self, folder: Path, aircraft: str) -> None:
        if not aircraft.strip():
            raise CalibrationError("certificates are stored by aircraft; this aircraft has no name")
        self.aircraft = aircraft
        # Quoted, so that no name leaves the folder and no two names share one.
        self._root = Path(folder) / quote(aircraft, safe=" ").replace(".", "%2E")
        self._lock = FileLock(self._root / ".lock")
        self._loaded: dict[Path, Certificate] = {}
        if self._root.is_dir():
            with self._alone():
                for name in self._known():
                    self._put_right(name)

    @property
    def in_force_folder(self) -> Path:
        """Return the folder with one certificate for each calibrated channel, perhaps none."""
        return self._root / "in_force"

    def in_force(self) -> dict[str, Certificate]:
        """Return the certificates in force by channel."""
        entries = ((name, self._newest(name)) for name in self._known())
        return {
            name: self._load(entry)
            for name, entry in entries
            if entry is not None and not _is_skip(entry)
        }

    def history(self, channel_id: str) -> tuple[Certificate, ...]:
        """Return the certificates that a channel has and had, newest last, withdrawn ones not."""
        return tuple(
            self._load(entry) for entry in self._entries(channel_id) if not _is_skip(entry)
        )

    def find_by_stamp(self, channel_id: str, stamp: datetime) -> Certificate | None:
        """Return the certificate of a channel that carries a stamp, unless it was withdrawn."""
        wanted = stamp.strftime(_STAMP)
        for entry in reversed(self._entries(channel_id)):
            match = _ENTRY.fullmatch(entry.name)
            if match is not None and match["rest"] == wanted:
                return self._load(entry)
        return None

    def skipped_channels(self) -> dict[str, SkippedChannel]:
        """Return the channels that were left uncalibrated on purpose."""
        found: dict[str, SkippedChannel] = {}
        for name in self._known():
            entry = self._newest(name)
            if entry is not None and _is_skip(entry):
                found[name] = read_toml(entry, SkippedChannel)
        return found

    def put_in_force(self, certificate: Certificate) -> None:
        """Put a certificate in force. Doing so again changes nothing."""
        name = certificate.channel
        with self._alone():
            newest = self._newest(name)
            content = toml_text(certificate_content(certificate))
            if newest is None or newest.read_text(encoding="utf-8") != content:
                stamp = certificate.stamp.strftime(_STAMP)
                write_certificate(certificate, self._following(name, stamp))
            self._put_right(name)

    def mark_uncalibrated(self, channel_id: str, reason: str, who: str, stamp: datetime) -> None:
        """Take a channel out of force: it is uncalibrated. Doing so again changes nothing."""
        channel(channel_id)
        skipped = SkippedChannel(
            channel=channel_id, reason=reason, who=who, stamp=stamp.replace(microsecond=0)
        )
        with self._alone():
            newest = self._newest(channel_id)
            if (
                newest is None
                or not _is_skip(newest)
                or read_toml(newest, SkippedChannel) != skipped
            ):
                write_toml(self._following(channel_id, _SKIPPED), skipped.model_dump())
            self._put_right(channel_id)

    def withdraw(self, channel_id: str, stamp: datetime) -> None:
        """Withdraw what is in force if it carries this stamp; what was before is in force again.

        The withdrawn certificate is kept in the history under another name.
        """
        with self._alone():
            newest = self._newest(channel_id)
            if newest is None:
                return
            if _stamp_of(newest) == stamp.replace(microsecond=0):
                newest.rename(newest.with_name(f"{newest.name}{_WITHDRAWN}"))
            self._put_right(channel_id)

    def record_check(self, checked: CheckRecord) -> Path:
        """Keep what a three-point check found, as TOML; it changes nothing in force."""
        folder = self._root / "checks" / checked.channel
        path = folder / f"{checked.stamp.strftime(_STAMP)}.toml"
        return write_toml(path, checked.model_dump(by_alias=True))

    def withdraw_check(self, channel_id: str, stamp: datetime) -> None:
        """Let a check count no more; it is kept under another name. Doing so again does nothing."""
        path = self._root / "checks" / channel_id / f"{stamp.strftime(_STAMP)}.toml"
        if path.is_file():
            path.replace(path.with_name(f"{path.name}{_WITHDRAWN}"))

    def last_check(self, channel_id: str) -> CheckRecord | None:
        """Return the newest check of the certificate in force; None where it was not checked.

        Raises
        ------
        FileProblemsError
            If the file of that check was changed by hand and cannot be read.
        """
        newest, files = self._newest(channel_id), self.checks(channel_id)
        if newest is None or _is_skip(newest) or not files:
            return None
        checked = read_toml(files[-1], CheckRecord)
        return checked if checked.certificate == self._load(newest).stamp else None

    def failed_checks(self) -> dict[str, datetime]:
        """Return the channels whose last check failed, with the stamp of their certificate."""
        failed = {}
        for name in self.in_force():
            try:
                checked = self.last_check(name)
            except FileProblemsError as error:
                log.warning("check not taken: %s", error)
                continue
            if checked is not None and not checked.result.passed:
                failed[name] = checked.certificate
        return failed

    def checks(self, channel_id: str) -> tuple[Path, ...]:
        """Return the files of the checks of a channel, newest last."""
        return list_files(self._root / "checks" / channel_id, "*.toml")

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        """Hold the store alone among the windows that may be open."""
        self._root.mkdir(parents=True, exist_ok=True)
        if not self._lock.acquire(patience=5.0):
            raise CalibrationError(
                f"the certificates of {self.aircraft} are being changed by another window; "
                "close it and try again"
            )
        try:
            yield
        finally:
            self._lock.release()

    def _load(self, entry: Path) -> Certificate:
        if entry not in self._loaded:
            self._loaded[entry] = load_certificate(entry)
        return self._loaded[entry]

    def _known(self) -> tuple[str, ...]:
        return tuple(path.name for path in list_files(self._root / "history"))

    def _entries(self, channel_id: str) -> tuple[Path, ...]:
        folder = self._root / "history" / channel_id
        return tuple(path for path in _numbered(folder) if _ENTRY.fullmatch(path.name))

    def _newest(self, channel_id: str) -> Path | None:
        entries = self._entries(channel_id)
        return entries[-1] if entries else None

    def _following(self, channel_id: str, rest: str) -> Path:
        """Return the path of the next entry; numbers of withdrawn ones are not used again."""
        folder = self._root / "history" / channel_id
        taken = _numbered(folder)
        number = _number(taken[-1]) + 1 if taken else 1
        return folder / f"{number:04d}-{rest}.toml"

    def _put_right(self, channel_id: str) -> None:
        """Make the file in force what the history says."""
        target = self.in_force_folder / f"{channel_id}.toml"
        newest = self._newest(channel_id)
        if newest is None or _is_skip(newest):
            target.unlink(missing_ok=True)
            return
        content = newest.read_bytes()
        if not target.is_file() or target.read_bytes() != content:
            write_atomically(target, content)


def _number(path: Path) -> int:
    return int(path.name.partition("-")[0])


def _numbered(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    found = [
        path for path in folder.iterdir() if _ENTRY.fullmatch(path.name.removesuffix(_WITHDRAWN))
    ]
    return sorted(found, key=_number)


def _is_skip(path: Path) -> bool:
    match = _ENTRY.fullmatch(path.name)
    return match is not None and match["rest"] == _SKIPPED


def _stamp_of(path: Path) -> datetime:
    return read_toml(path, SkippedChannel).stamp if _is_skip(path) else load_certificate(path).stamp


_IN_FORCE = "in_force"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CertificateStatus:
    """A certificate in force."""

    certificate: Certificate
    file: Path
    """Where it was read from."""
    quality: CalibrationQuality | None
    """Its own, or told anew by its points; None where they do not suffice."""
    former: Certificate | None
    """The one before, where it is known."""
    drift: Drift | None
    """How far the instrument moved since; None where the two cannot be compared."""

    def age(self, now: datetime) -> timedelta:
        """Return how long ago it was made; `now` is the field's local time, as the stamp is."""
        stamp = self.certificate.stamp
        return (now if stamp.tzinfo is None else now.astimezone(stamp.tzinfo)) - stamp


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CertificateOverview:
    """What a folder holds."""

    in_force: tuple[CertificateStatus, ...]
    """Those in force, by file name."""
    skipped: tuple[SkippedChannel, ...] = ()
    """Channels that were left uncalibrated on purpose, by name."""


def evaluate_certificate(
    certificate: Certificate, file: Path, former: Certificate | None = None
) -> CertificateStatus:
    """Judge a certificate, and compare it with the one before."""
    drift = None
    if former is not None:
        try:
            drift = compute_drift(certificate, former)
        except CalibrationError:
            drift = None
    return CertificateStatus(
        certificate=certificate, file=file, quality=certificate_quality(certificate), former=former,
        drift=drift,
    )  # fmt: skip


def certificate_quality(certificate: Certificate) -> CalibrationQuality | None:
    """Return the quality that a certificate states, else what its points tell."""
    if certificate.quality is not None:
        return certificate.quality
    try:
        return fit_calibration(certificate.points, degree=certificate.degree).quality
    except CalibrationError:
        return None


def load_certificate_overview(
    folder_or_name: str | Path, former: str | Path | None = None
) -> CertificateOverview:
    """Look through the certificates of a folder.

    Parameters
    ----------
    folder_or_name : str or Path
        See the top of this module.
    former : str or Path, optional
        Certificates to compare with; by default those before in a store's history.

    Raises
    ------
    FileProblemsError
        If a file holds mistakes.
    UnknownNameError
        If there is no such folder or set, or it holds no certificate.
    """
    store = _find_store(Path(folder_or_name))
    skipped = (
        () if store is None else tuple(one for _, one in sorted(store.skipped_channels().items()))
    )
    before = None if former is None else load_certificates(former)
    folder = folder_or_name if store is None else store.in_force_folder
    if store is not None and not list_files(store.in_force_folder, "*.toml") and skipped:
        return CertificateOverview(in_force=(), skipped=skipped)
    standing = []
    for file in certificate_paths(folder):
        certificate = load_certificate(file)
        if before is not None:
            last = before.get(certificate.channel)
        else:
            last = None if store is None else _previous_certificate(store, certificate.channel)
        standing.append(evaluate_certificate(certificate, file, last))
    return CertificateOverview(in_force=tuple(standing), skipped=skipped)


def _find_store(folder: Path) -> CertificateStore | None:
    """Return the store that a folder belongs to, by its aircraft's folder or its `in_force`."""
    root = folder.resolve()
    root = root.parent if root.name == _IN_FORCE else root
    if not (root / _IN_FORCE).is_dir() or not (root / "history").is_dir():
        return None
    return CertificateStore(root.parent, unquote(root.name))


def _previous_certificate(store: CertificateStore, channel_id: str) -> Certificate | None:
    history = store.history(channel_id)
    return history[-2] if len(history) > 1 else None
