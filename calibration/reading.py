"""Certificates as TOML files: every mistake named with its key path, values with their units."""

from __future__ import annotations

import re
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from calibration.certificate import Certificate
from calibration.fit import MAX_DEGREE, turning_points
from calibration.points import CalibrationPoint
from gsapp.foundation import (
    FileProblem,
    FileProblemsError,
    StrictModel,
    UnitError,
    UnknownNameError,
    read_toml,
    write_toml,
)
from gsapp.quantities import channel, from_si, normalize_unit, to_si
from gsapp.quantities.fields import Temperature, Voltage

FOLDER = Path(__file__).parent / "files"
"""One folder for each shipped set, such as ``b777``."""


class _Point(StrictModel):
    volts: Voltage
    value: str
    direction: Literal["up", "down", "single"] = "single"


class _FitSection(StrictModel):
    coefficients: tuple[str, ...] = Field(min_length=2, max_length=MAX_DEGREE + 1)
    range: tuple[Voltage, Voltage]
    rms_residual: str | None = None
    max_residual: str | None = None
    hysteresis: str | None = None


class _CertificateFile(StrictModel):
    channel: str
    unit: str
    instrument: str = ""
    notes: str = ""
    who: str
    stamp: datetime
    temperature: Temperature | None = None
    excitation_voltage: Voltage | None = None
    ratiometric: bool = False
    fit: _FitSection
    points: tuple[_Point, ...] = ()


_NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def load_certificate(path: str | Path) -> Certificate:
    """Read one certificate.

    Raises
    ------
    FileProblemsError
        If the file holds mistakes; each is named with key path and remedy.
    """
    file = read_toml(path, _CertificateFile)
    problems: list[FileProblem] = []
    key, unit = _channel_and_unit(file, problems)
    if problems:
        raise FileProblemsError(path, problems)
    coefficients = tuple(
        _quantity(text, _per_volt(unit, power), f"fit.coefficients[{power}]", problems)
        for power, text in enumerate(file.fit.coefficients)
    )
    points = tuple(
        CalibrationPoint(
            volts=point.volts,
            value=_in_unit(point.value, unit, key, f"points[{index}].value", problems),
            direction=point.direction,
        )
        for index, point in enumerate(file.points)
    )
    rms, largest, hysteresis = (
        0.0 if text is None else _quantity(text, _difference(unit), f"fit.{name}", problems)
        for name, text in (
            ("rms_residual", file.fit.rms_residual),
            ("max_residual", file.fit.max_residual),
            ("hysteresis", file.fit.hysteresis),
        )
    )
    _check_curve(file, coefficients, problems)
    if problems:
        raise FileProblemsError(path, problems)
    return Certificate(
        channel=file.channel,
        unit=unit,
        coefficients=coefficients,
        range=file.fit.range,
        who=file.who,
        stamp=file.stamp,
        points=points,
        hysteresis=hysteresis,
        rms_residual=rms,
        max_residual=largest,
        excitation_voltage=file.excitation_voltage,
        ratiometric=file.ratiometric,
        temperature=file.temperature,
        instrument=file.instrument,
        notes=file.notes,
    )


def load_certificates(folder_or_name: str | Path) -> dict[str, Certificate]:
    """Read all certificates of a folder, or of a shipped set such as ``b777``.

    Returns
    -------
    dict
        Channel id -> certificate, sorted by file name.

    Raises
    ------
    FileProblemsError
        If a file holds mistakes, or two files are for the same channel.
    UnknownNameError
        If there is neither such a folder nor such a shipped set, or it holds no certificate.
    """
    found: dict[str, Certificate] = {}
    files: dict[str, Path] = {}
    for path in certificate_files(folder_or_name):
        certificate = load_certificate(path)
        former = files.setdefault(certificate.channel, path)
        if former != path:
            problem = FileProblem(
                where="channel",
                what=f"'{certificate.channel}' has another certificate in {former.name}",
                remedy="keep in this folder the one that is in force",
            )
            raise FileProblemsError(path, [problem])
        found[certificate.channel] = certificate
    return found


def certificate_files(folder_or_name: str | Path) -> tuple[Path, ...]:
    """Return the certificates of a folder, or of a shipped set such as ``b777``, sorted, unread.

    Raises
    ------
    UnknownNameError
        If there is neither such a folder nor such a shipped set, or it holds no certificate.
    """
    folder = Path(folder_or_name)
    if not folder.is_dir():
        folder = FOLDER / str(folder_or_name)
        if folder.parent != FOLDER or not folder.is_dir():
            raise UnknownNameError(
                f"there is no folder '{folder_or_name}' with calibration certificates, and none "
                f"of that name comes with the program; shipped are: {', '.join(shipped_sets())}"
            )
    files = tuple(sorted(folder.glob("*.toml")))
    if not files:
        raise UnknownNameError(f"the folder {folder} holds no calibration certificate (*.toml)")
    return files


def shipped_sets() -> tuple[str, ...]:
    """Return the names of the sets of certificates that come with the program."""
    return tuple(sorted(path.name for path in FOLDER.iterdir() if path.is_dir()))


def certificate_content(certificate: Certificate) -> dict[str, Any]:
    """Return what the file of a certificate holds; `load_certificate` reads it back exactly."""
    unit = certificate.unit
    difference = _difference(unit)
    content: dict[str, Any] = {
        "channel": certificate.channel,
        "unit": unit,
        "instrument": certificate.instrument,
        "notes": certificate.notes,
        "who": certificate.who,
        "stamp": certificate.stamp.replace(microsecond=0),
    }
    if certificate.temperature is not None:
        celsius = from_si(certificate.temperature, "degC", "temperature")
        content["temperature"] = f"{round(celsius, 9)!r} degC"
    if certificate.excitation_voltage is not None:
        content["excitation_voltage"] = f"{certificate.excitation_voltage!r} V"
    content["ratiometric"] = certificate.ratiometric
    content["fit"] = {
        "coefficients": [
            f"{coefficient!r} {_per_volt(unit, power)}".rstrip()
            for power, coefficient in enumerate(certificate.coefficients)
        ],
        "range": [f"{volts!r} V" for volts in certificate.range],
        "rms_residual": f"{certificate.rms_residual:.6g} {difference}".rstrip(),
        "max_residual": f"{certificate.max_residual:.6g} {difference}".rstrip(),
        "hysteresis": f"{certificate.hysteresis:.6g} {difference}".rstrip(),
    }
    content["points"] = [
        {
            "volts": f"{point.volts!r} V",
            "value": f"{point.value!r} {unit}".rstrip(),
            "direction": point.direction,
        }
        for point in certificate.points
    ]
    return content


def write_certificate(certificate: Certificate, path: str | Path) -> Path:
    """Write a certificate as TOML, atomically."""
    return write_toml(path, certificate_content(certificate))


def _channel_and_unit(file: _CertificateFile, problems: list[FileProblem]) -> tuple[str, str]:
    key, unit = "", file.unit
    try:
        key = channel(file.channel).quantity
        unit = normalize_unit(file.unit, key)
    except UnknownNameError as error:
        problems.append(FileProblem.of("channel", error))
    except UnitError as error:
        problems.append(FileProblem.of("unit", error))
    if file.stamp.microsecond:
        problems.append(
            FileProblem(
                where="stamp",
                what="has fractions of a second",
                remedy="write it to the second, as 2003-05-14T08:30:00",
            )
        )
    if file.ratiometric and file.excitation_voltage is None:
        problems.append(
            FileProblem(
                where="excitation_voltage",
                what="is missing, and a ratiometric instrument cannot do without",
                remedy='add the supply during calibration, as excitation_voltage = "5.0 V"',
            )
        )
    low, high = file.fit.range
    if not low < high:
        problems.append(
            FileProblem(where="fit.range", what="ends before it begins", remedy="swap the two")
        )
    return key, unit


def _check_curve(
    file: _CertificateFile, coefficients: tuple[float, ...], problems: list[FileProblem]
) -> None:
    turning = turning_points(coefficients, *file.fit.range)
    if turning or not any(coefficients[1:]):
        what = f"turns back at {turning[0]:.3f} V" if turning else "is flat"
        problems.append(
            FileProblem(
                where="fit.coefficients",
                what=f"the curve {what}, so that a voltage would not tell one value",
                remedy="fit again with a lower degree, or narrow fit.range",
            )
        )
    low, high = file.fit.range
    for index, point in enumerate(file.points):
        if not low - 1e-9 <= point.volts <= high + 1e-9:
            problems.append(
                FileProblem(
                    where=f"points[{index}].volts",
                    what=f"{point.volts:g} V lies outside fit.range",
                    remedy="widen fit.range to cover all points",
                )
            )


def _per_volt(unit: str, power: int) -> str:
    base = _difference(unit) if power else unit
    if power == 0:
        return base
    per = "V" if power == 1 else f"V^{power}"
    return f"{base or '1'}/{per}"


def _difference(unit: str) -> str:
    """Return the unit of a difference: a step of one degree Celsius is one kelvin."""
    return {"degC": "K", "degF": "delta_degF"}.get(unit, unit)


def _quantity(text: str, unit: str, where: str, problems: list[FileProblem]) -> float:
    """Read a number that must carry exactly this unit."""
    match = _NUMBER_AND_UNIT.fullmatch(text)
    if match is None or match.group(2).replace(" ", "") != unit:
        problems.append(
            FileProblem(
                where=where,
                what=f"'{text}' is not a number in {unit or 'no unit'}",
                remedy=f'write for example "1.0 {unit}"'.replace(' "', '"'),
            )
        )
        return float("nan")
    return float(match.group(1))


def _in_unit(text: str, unit: str, key: str, where: str, problems: list[FileProblem]) -> float:
    """Read a number in any unit of the quantity, and return it in `unit`."""
    match = _NUMBER_AND_UNIT.fullmatch(text)
    if match is None:
        problems.append(
            FileProblem(
                where=where,
                what=f"'{text}' does not begin with a number",
                remedy=f'write for example "1.0 {unit}"',
            )
        )
        return float("nan")
    number = float(match.group(1))
    try:
        written = normalize_unit(match.group(2), key)
        return number if written == unit else from_si(to_si(number, written, key), unit, key)
    except UnitError as error:
        problems.append(FileProblem.of(where, error))
        return float("nan")
