"""A three-point check as it is kept: what it found, of which certificate, when and by whom."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path

from calibration.drift import CheckResult
from gsapp.foundation import StrictModel, read_toml, write_toml


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckRecord:
    """A check of one instrument."""

    channel: str
    who: str
    stamp: datetime
    certificate: datetime
    """Stamp of the certificate that was checked."""
    unit: str
    result: CheckResult


class _ResultTable(StrictModel):
    zero: float
    zero_uncertainty: float
    slope: float
    slope_uncertainty: float
    largest: float
    off: tuple[float, ...]
    passed: bool
    sentence: str


class _CheckFile(StrictModel):
    channel: str
    who: str
    stamp: datetime
    certificate: datetime
    unit: str
    check: _ResultTable


def write_check_record(checked: CheckRecord, path: Path) -> Path:
    """Write a check to a TOML file; return its path."""
    result = asdict(checked.result)
    content = {
        "channel": checked.channel,
        "who": checked.who,
        "stamp": checked.stamp,
        "certificate": checked.certificate,
        "unit": checked.unit,
        "check": {**result, "off": list(result["off"])},
    }
    return write_toml(path, content)


def read_check_record(path: Path) -> CheckRecord:
    """Read a check.

    Raises
    ------
    FileProblemsError
        If the file holds something else.
    """
    file = read_toml(path, _CheckFile)
    return CheckRecord(
        channel=file.channel,
        who=file.who,
        stamp=file.stamp,
        certificate=file.certificate,
        unit=file.unit,
        result=CheckResult(**file.check.model_dump()),
    )
