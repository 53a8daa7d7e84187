"""The certificates of a folder at a glance: how old, how good, moved how far since the ones before.

A folder is one with certificates in it, a shipped set, the folder of one aircraft in a store
(`calibration.store`), or a flight folder, whose copies are taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from urllib.parse import unquote

from calibration.certificate import Certificate
from calibration.choosing import calibrate
from calibration.comparing import Drift, compare
from calibration.points import CalibrationError
from calibration.quality import Quality
from calibration.reading import certificate_files, load_certificate, load_certificates
from calibration.store import CertificateStore, Skipped
from gsapp.foundation.files import files_of

_IN_FORCE = "in_force"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Standing:
    """A certificate in force.

    Attributes
    ----------
    certificate : Certificate
    file : Path
        Where it was read from.
    quality : Quality or None
        Its own, or told anew by its points; None where they do not suffice.
    former : Certificate or None
        The one before, where it is known.
    drift : Drift or None
        How far the instrument moved since; None where the two cannot be compared.
    """

    certificate: Certificate
    file: Path
    quality: Quality | None
    former: Certificate | None
    drift: Drift | None

    def age(self, now: datetime) -> timedelta:
        """Return how long ago it was made; `now` is the field's local time, as the stamp is."""
        stamp = self.certificate.stamp
        return (now if stamp.tzinfo is None else now.astimezone(stamp.tzinfo)) - stamp


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Overview:
    """What a folder holds.

    Attributes
    ----------
    standing : tuple of Standing
        Those in force, by file name.
    skipped : tuple of Skipped
        Channels that were left uncalibrated on purpose, by name.
    """

    standing: tuple[Standing, ...]
    skipped: tuple[Skipped, ...] = ()


def stand(certificate: Certificate, file: Path, former: Certificate | None = None) -> Standing:
    """Judge a certificate, and compare it with the one before.

    Parameters
    ----------
    certificate : Certificate
    file : Path
        Where it stands.
    former : Certificate, optional
        Of the same channel.
    """
    drift = None
    if former is not None:
        try:
            drift = compare(certificate, former)
        except CalibrationError:
            drift = None
    return Standing(
        certificate=certificate, file=file, quality=quality_of(certificate), former=former,
        drift=drift,
    )  # fmt: skip


def quality_of(certificate: Certificate) -> Quality | None:
    """Return the quality that a certificate states, else what its points tell."""
    if certificate.quality is not None:
        return certificate.quality
    try:
        return calibrate(certificate.points, degree=certificate.degree).quality
    except CalibrationError:
        return None


def overview(folder_or_name: str | Path, former: str | Path | None = None) -> Overview:
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
    store = _store(Path(folder_or_name))
    skipped = () if store is None else tuple(one for _, one in sorted(store.skipped().items()))
    before = None if former is None else load_certificates(former)
    folder = folder_or_name if store is None else store.in_force_folder
    if store is not None and not files_of(store.in_force_folder, "*.toml") and skipped:
        return Overview(standing=(), skipped=skipped)
    standing = []
    for file in certificate_files(folder):
        certificate = load_certificate(file)
        if before is not None:
            last = before.get(certificate.channel)
        else:
            last = None if store is None else _before(store, certificate.channel)
        standing.append(stand(certificate, file, last))
    return Overview(standing=tuple(standing), skipped=skipped)


def _store(folder: Path) -> CertificateStore | None:
    """Return the store that a folder belongs to, by its aircraft's folder or its `in_force`."""
    root = folder.resolve()
    root = root.parent if root.name == _IN_FORCE else root
    if not (root / _IN_FORCE).is_dir() or not (root / "history").is_dir():
        return None
    return CertificateStore(root.parent, unquote(root.name))


def _before(store: CertificateStore, channel_id: str) -> Certificate | None:
    history = store.history(channel_id)
    return history[-2] if len(history) > 1 else None
