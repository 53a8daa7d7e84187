"""From a file of points to a certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from calibration.certificate import Certificate
from calibration.certificate_toml import load_certificate
from calibration.curve_selection import create_certificate, fit_calibration
from calibration.drift import Drift, compute_drift
from calibration.points_file import PointsFile, load_points
from calibration.quality import Calibration, collect_remarks
from gsapp.foundation import GroundStationError
from gsapp.quantities import to_si


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PointsCalibration:
    """What a file of points gave."""

    certificate: Certificate
    calibration: Calibration
    points_file: PointsFile
    drifts: tuple[tuple[Path, Drift], ...]  # Against former certificates.
    remarks: tuple[str, ...]


def check_supply(volts: float | None) -> None:
    """Raise `GroundStationError` where no instrument has such a supply."""
    if volts is not None and not 0.5 <= volts <= 30.0:
        raise GroundStationError(f"a supply of {volts:g} V is not possible; give it in volts")


def calibrate_points(
    path: Path,
    channel_id: str,
    *,
    degree: int | None = None,
    excitation: float | None = None,
    travel: tuple[float, float] | None = None,
    who: str = "",
    temperature: float | None = None,
    former: Sequence[Path] = (),
) -> PointsCalibration:
    """Fit a curve to the points of a file and describe it in a certificate.

    Parameters
    ----------
    degree : int, optional
        Order of the fit, 1 to 3; by default the best-fitting one.
    excitation : float, optional
        Supply voltage of a ratiometric instrument, V; a column of the file has priority.
    travel : tuple of float, optional
        Of the surface, in the unit of the points.
    temperature : float, optional
        Of the surroundings, degC.
    former : sequence of Path
        Certificates to compare with.

    Raises
    ------
    GroundStationError
        If the file holds mistakes, or a value is not possible.
    """
    taken = load_points(path, channel_id)
    supply = taken.excitation or excitation
    check_supply(supply)
    made = fit_calibration(
        taken.points, degree=degree, travel=travel, resolution=taken.signal.resolution
    )
    certificate = create_certificate(
        made,
        taken.points,
        channel_id=channel_id,
        unit=taken.unit,
        who=who,
        stamp=datetime.now(),  # noqa: DTZ005  certificates carry the field's local time
        excitation_voltage=supply,
        ratiometric=supply is not None,
        temperature=None if temperature is None else to_si(temperature, "degC", "temperature"),
        signal_unit=taken.signal.unit,
    )
    remarks = collect_remarks(made, taken.points, taken.unit)
    if not who:
        remarks = (*remarks, "the person who took the readings is missing; add --who")
    return PointsCalibration(
        certificate=certificate,
        calibration=made,
        points_file=taken,
        drifts=tuple((one, compute_drift(certificate, load_certificate(one))) for one in former),
        remarks=remarks,
    )
