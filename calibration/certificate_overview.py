"""The certificates of a folder at a glance: how old, how good, moved how far since the ones before.

A folder is one with certificates in it, a shipped set, the folder of one aircraft in a store
(`calibration.certificate_store`), or a flight folder, whose copies are taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from urllib.parse import unquote

from calibration.certificate import Certificate
from calibration.certificate_store import CertificateStore, SkippedChannel
from calibration.certificate_toml import certificate_paths, load_certificate, load_certificates
from calibration.curve_selection import fit_calibration
from calibration.drift import Drift, compute_drift
from calibration.points import CalibrationError
from calibration.quality import CalibrationQuality
from gsapp.foundation.files import list_files

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
    """Judge a certificate, and compare it with the one before.

    Parameters
    ----------
    file : Path
        Where it stands.
    """
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
