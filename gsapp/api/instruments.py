"""Instruments: compatibility with one another, calibration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from calibration import Certificate, load_certificate
from calibration.certificate_json import certificate_json
from calibration.certificate_store import evaluate_certificate
from calibration.certificate_toml import save_certificate
from calibration.points_calibration import PointsCalibration, calibrate_points
from gsapp.api.result import FlightSource, Result, request_values, table_of, unit_system
from gsapp.flight.flight import calibration_json, calibration_sentences
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.foundation.data_table import DataTable
from gsapp.identification.compatibility import CompatibilityResult
from gsapp.identification.compatibility.flight_check import (
    check_flights,
    compatibility_json,
    settings_with_errors,
)
from gsapp.quantities import channel, convert_text_units, convert_value_and_std
from gsapp.report.certificate_report import certificate_document


def compatibility(
    flights: FlightSource | Sequence[FlightSource],
    *,
    error: Sequence[str] = (),
    units: str = "us",
    **settings: Any,
) -> Result[CompatibilityResult]:
    """Check the instruments of flights against one another, as ``gsapp compatibility``.

    Parameters
    ----------
    flights : Flight, str, Path, or sequence of them
        Open flights, or the paths of flights.
    error : sequence of str, optional
        Errors to estimate beside the usual ones, as ``q.scale`` or ``V.delay``.
    units : {"us", "si"}, optional
        Of the tables.
    **settings
        aircraft, maneuver_windows, channel_map, calibration, as_found; see the table.

    Returns
    -------
    Result
        Tables ``errors`` (bias, scale, delay of each instrument) and ``verdicts``.
    """
    system = unit_system(units)
    paths, values = request_values(flights, settings)
    flown, found = check_flights(paths, ManeuverSettings(**values), settings_with_errors(error))
    opened = [one.flight for one in flown]
    return Result(
        summary=convert_text_units(found.summary, system),
        outcome=found,
        content={**compatibility_json(found), "calibration": calibration_json(opened)},
        tables={
            "errors": table_of("error value std unit status why", _error_rows(found, system)),
            "verdicts": table_of(
                "kind channels text",
                (
                    (one.kind, ", ".join(one.channels), convert_text_units(one.sentence, system))
                    for one in found.verdicts
                ),
            ),
        },
        remarks=tuple(
            convert_text_units(one, system)
            for one in (*calibration_sentences(opened), *found.warnings)
        ),
    )


def _error_rows(found: CompatibilityResult, system: str) -> Iterator[tuple[Any, ...]]:
    for name, one in found.parameters.items():
        instrument, _, kind = name.rpartition(".")
        unit = {"scale": "", "delay": "s", "position": "m"}.get(kind)
        unit = channel(instrument).unit if unit is None else unit
        if one.value is None or one.std is None:
            yield name, None, None, unit, one.status, one.why
            continue
        value, std, shown = convert_value_and_std(one.value, one.std, unit, system)
        yield name, value, std, shown, one.status, one.why


def calibrate(
    points: str | Path,
    channel: str,
    out: str | Path,
    *,
    degree: int | None = None,
    excitation: float | None = None,
    travel: tuple[float, float] | None = None,
    who: str = "",
    temperature: float | None = None,
    former: Sequence[str | Path] = (),
) -> Result[Certificate]:
    """Turn calibration points into a certificate, as ``gsapp calibrate``.

    Parameters
    ----------
    points : str or Path
        CSV with columns ``angle [deg]``, ``volts [V]``, ``direction``.
    channel : str
        Id of the channel, as ``elevator_left``.
    out : str or Path
        Certificate to write.
    degree : int, optional
        Order of the fit, 1 to 3; by default the best-fitting one.
    excitation : float, optional
        Supply voltage of a ratiometric instrument, V.
    travel : tuple of float, optional
        Lowest and highest position of the surface, in the unit of the points.
    who : str, optional
        Name of the person who took the readings.
    temperature : float, optional
        Of the surroundings, degC.
    former : sequence of str or Path, optional
        Certificates to compare with.

    Returns
    -------
    Result
        Tables ``points`` (with residuals) and ``quality``, in the unit of the points; a figure.
    """
    place, earlier = Path(out), [Path(one) for one in former]
    made = calibrate_points(
        Path(points), channel, degree=degree, excitation=excitation, travel=travel, who=who,
        temperature=temperature, former=earlier,
    )  # fmt: skip
    save_certificate(made.certificate, place)
    certificates = [load_certificate(one) for one in earlier]
    newest = max(certificates, key=lambda one: one.stamp.astimezone(), default=None)
    figures = certificate_document(evaluate_certificate(made.certificate, place, newest)).figures
    unit, order = made.points_file.unit, made.calibration.degree
    return Result(
        summary=f"{channel}: {len(made.points_file.points)} points, order {order}.",
        outcome=made.certificate,
        content=certificate_json(made, place),
        tables={
            "points": table_of(
                "line value signal direction residual", _point_rows(made), value=unit,
                signal=made.points_file.signal.unit, residual=unit,
            ),
            "quality": _quality_table(made),
        },
        figures={one.name: one for one in figures},
        remarks=made.remarks,
    )  # fmt: skip


def _point_rows(made: PointsCalibration) -> Iterator[tuple[Any, ...]]:
    taken = made.points_file
    for line, point, residual in zip(
        taken.lines, taken.points, made.calibration.fit.residuals, strict=True
    ):
        yield line, point.value, point.volts, point.direction, float(residual)


_QUALITY = (
    "uncertainty", "hysteresis", "return_to_zero", "linearity", "scatter", "resolution", "rms",
    "max_residual",
)  # fmt: skip
"""Of `calibration.quality.CalibrationQuality`, in the unit of the points."""


def _quality_table(made: PointsCalibration) -> DataTable:
    quality, unit = made.calibration.quality, made.points_file.unit
    rows = ((name, getattr(quality, name)) for name in _QUALITY)
    return table_of("figure value", rows, value=unit)
