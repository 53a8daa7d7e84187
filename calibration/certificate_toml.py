"""Certificates as TOML files: every mistake named with its key path, values with their units."""

from __future__ import annotations

import re
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from calibration.certificate import Certificate
from calibration.points import CalibrationPoint
from calibration.polynomial_fit import PolynomialFit, turning_points
from calibration.quality import CalibrationQuality
from calibration.settings import CALIBRATION
from calibration.signals import find_signal
from gsapp.foundation import (
    FileProblem,
    GroundStationError,
    StrictModel,
    UnitError,
    UnknownNameError,
    read_toml,
    toml_problems_error,
    write_toml,
)
from gsapp.foundation.errors import format_os_error
from gsapp.foundation.files import list_files, path_lexists
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import channel, from_si, normalize_unit, to_si
from gsapp.quantities.fields import Temperature, Voltage

_NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def _report(problems: list[FileProblem], where: str, what: str, remedy: str) -> None:
    problems.append(FileProblem(where=where, what=what, remedy=remedy))


def unit_per_signal(unit: str, signal: str, power: int) -> str:
    """Return the unit of the coefficient of a power of the signal, which is in V, us or count."""
    base = difference_unit(unit) if power else unit
    if power == 0:
        return base
    per = signal if power == 1 else f"{signal}^{power}"
    return f"{base or '1'}/{per}"


def difference_unit(unit: str) -> str:
    """Return the unit of a difference: a step of one degree Celsius is one kelvin."""
    return {"degC": "K", "degF": "delta_degF"}.get(unit, unit)


def parse_quantity(text: str, unit: str, where: str, problems: list[FileProblem]) -> float:
    """Read a number that must carry exactly this unit."""
    match = _NUMBER_AND_UNIT.fullmatch(text)
    if match is None or match.group(2).replace(" ", "") != unit:
        _report(
            problems,
            where,
            f"'{text}' is not a number in {unit or 'no unit'}",
            f'write for example "1.0 {unit}"'.replace(' "', '"'),
        )
        return float("nan")
    return float(match.group(1))


def parse_quantity_in_unit(
    text: str, unit: str, key: str, where: str, problems: list[FileProblem]
) -> float:
    """Read a number in any unit of the quantity, and return it in `unit`."""
    match = _NUMBER_AND_UNIT.fullmatch(text)
    if match is None:
        _report(
            problems,
            where,
            f"'{text}' does not begin with a number",
            f'write for example "1.0 {unit}"',
        )
        return float("nan")
    number = float(match.group(1))
    try:
        written = normalize_unit(match.group(2), key)
        return number if written == unit else from_si(to_si(number, written, key), unit, key)
    except UnitError as error:
        problems.append(FileProblem.from_error(where, error))
        return float("nan")


def _parse_signal(text: object) -> tuple[float, str]:
    """Return a signal as number and unit of its kind; raise ValueError for what is none."""
    match = _NUMBER_AND_UNIT.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        raise ValueError(f"'{text}' is no number with a unit; write for example \"1.49 V\"")
    try:
        signal = find_signal(match.group(2))
    except UnitError as error:
        raise ValueError(str(error)) from error
    return float(match.group(1)) * signal.factors[match.group(2).strip()], signal.unit


_SignalText = Annotated[tuple[float, str], BeforeValidator(_parse_signal)]


class _UncertaintySection(StrictModel):
    volts: tuple[Voltage, ...] = ()
    signal: tuple[_SignalText, ...] = ()
    half_width: tuple[str, ...] = Field(min_length=2)


class QualitySection(StrictModel):
    """As written in the file; see `calibration.quality.CalibrationQuality`."""

    linearity: str
    resolution: str
    covered: tuple[str, str]
    travel: tuple[str, str] | None = None
    scatter: str | None = None
    hysteresis_uncertainty: str | None = None
    return_to_zero: str | None = None
    outliers: tuple[int, ...] = ()
    uncertainty: _UncertaintySection | None = None


def read_quality(
    section: QualitySection,
    *,
    fit: PolynomialFit,
    two_sided: bool,
    unit: str,
    key: str,
    problems: list[FileProblem],
) -> CalibrationQuality:
    """Return the quality that a file tells of; mistakes are added to `problems`.

    Parameters
    ----------
    fit : PolynomialFit
        Of the same file: what it says is not said twice.
    two_sided : bool
        Whether the points were taken upward and downward.
    unit, key : str
        Of the certificate, and the quantity of its channel.
    """
    step = difference_unit(unit)

    def optional(name: str) -> float | None:
        text = getattr(section, name)
        return None if text is None else parse_quantity(text, step, f"quality.{name}", problems)

    def pair(texts: tuple[str, str], name: str) -> tuple[float, float]:
        low, high = (
            parse_quantity_in_unit(text, unit, key, f"quality.{name}[{index}]", problems)
            for index, text in enumerate(texts)
        )
        # A single reading covers a single value; a travel without length is none.
        if low > high or (low == high and name == "travel"):
            _report(problems, f"quality.{name}", "ends before it begins", "swap the two")
        return low, high

    places: tuple[float, ...] = ()
    half_widths: tuple[float, ...] = ()
    if section.uncertainty is not None:
        given = section.uncertainty
        places = given.volts or tuple(number for number, _ in given.signal)
        half_widths = tuple(
            parse_quantity(text, step, f"quality.uncertainty.half_width[{index}]", problems)
            for index, text in enumerate(section.uncertainty.half_width)
        )
        if len(places) != len(half_widths) or sorted(set(places)) != list(places):
            _report(
                problems,
                "quality.uncertainty",
                "volts (or signal) are not increasing, or the number of half widths differs",
                "write one half width for each, in increasing order",
            )
    return CalibrationQuality(
        degree=len(fit.coefficients) - 1,
        rms=fit.rms,
        max_residual=fit.max_residual,
        linearity=parse_quantity(section.linearity, step, "quality.linearity", problems),
        scatter=optional("scatter"),
        hysteresis=fit.hysteresis if two_sided else None,
        hysteresis_uncertainty=optional("hysteresis_uncertainty"),
        return_to_zero=optional("return_to_zero"),
        resolution=parse_quantity(section.resolution, step, "quality.resolution", problems),
        covered=pair(section.covered, "covered"),
        travel=None if section.travel is None else pair(section.travel, "travel"),
        uncertainty_volts=places,
        half_widths=half_widths,
        outliers=section.outliers,
    )


def quality_content(quality: CalibrationQuality, unit: str, signal: str = "V") -> dict[str, Any]:
    """Return what the section holds; `read_quality` reads it back to six digits."""
    step = difference_unit(unit)

    def written(value: float | None) -> str | None:
        return None if value is None else f"{value:.6g} {step}".rstrip()

    def pair(values: tuple[float, float] | None) -> list[str] | None:
        return None if values is None else [f"{float(value)!r} {unit}".rstrip() for value in values]

    content = {
        "linearity": written(quality.linearity),
        "scatter": written(quality.scatter),
        "hysteresis_uncertainty": written(quality.hysteresis_uncertainty),
        "return_to_zero": written(quality.return_to_zero),
        "resolution": written(quality.resolution),
        "covered": pair(quality.covered),
        "travel": pair(quality.travel),
        "outliers": list(quality.outliers) or None,
        "uncertainty": {
            _signal_key(signal): [f"{float(v)!r} {signal}" for v in quality.uncertainty_volts],
            "half_width": [written(half_width) for half_width in quality.half_widths],
        }
        if quality.uncertainty_volts
        else None,
    }
    return {key: value for key, value in content.items() if value is not None}


def _signal_key(signal: str) -> str:
    return "volts" if signal == "V" else "signal"


SHIPPED_CERTIFICATES_FOLDER = Path(__file__).parent / "files"
"""One folder for each shipped set, such as ``b777``."""


class _Point(StrictModel):
    volts: Voltage | None = None
    signal: _SignalText | None = None
    value: str
    direction: Literal["up", "down", "single"] = "single"
    noise: _SignalText = (0.0, "V")

    @property
    def level(self) -> float:
        return self.signal[0] if self.signal is not None else self.volts or 0.0

    @model_validator(mode="after")
    def _must_have_one_signal(self) -> _Point:
        if (self.volts is None) == (self.signal is None):
            raise ValueError('needs one of volts = "1.49 V" and signal = "1500 us"')
        return self


class _FitSection(StrictModel):
    coefficients: tuple[str, ...] = Field(min_length=2, max_length=CALIBRATION.max_degree + 1)
    range: tuple[_SignalText, _SignalText]
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
    quality: QualitySection | None = None
    points: tuple[_Point, ...] = ()


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
    (low, signal), (high, other) = file.fit.range
    if other != signal:
        _report(problems, "fit.range", f"begins in {signal} and ends in {other}", "use one unit")
    if problems:
        raise toml_problems_error(path, problems)
    coefficients = tuple(
        parse_quantity(
            text, unit_per_signal(unit, signal, power), f"fit.coefficients[{power}]", problems
        )
        for power, text in enumerate(file.fit.coefficients)
    )
    points = tuple(
        CalibrationPoint(
            volts=point.level,
            value=parse_quantity_in_unit(
                point.value, unit, key, f"points[{index}].value", problems
            ),
            direction=point.direction,
            noise=point.noise[0],
        )
        for index, point in enumerate(file.points)
    )
    rms, largest, hysteresis = (
        0.0
        if text is None
        else parse_quantity(text, difference_unit(unit), f"fit.{name}", problems)
        for name, text in (
            ("rms_residual", file.fit.rms_residual),
            ("max_residual", file.fit.max_residual),
            ("hysteresis", file.fit.hysteresis),
        )
    )
    _check_curve(file, coefficients, problems)
    quality = None
    if file.quality is not None:
        met = {point.direction for point in points}
        quality = read_quality(
            file.quality,
            fit=PolynomialFit(
                coefficients=coefficients, residuals=(), rms=rms, max_residual=largest,
                hysteresis=hysteresis,
            ),
            two_sided={"up", "down"} <= met,
            unit=unit,
            key=key,
            problems=problems,
        )  # fmt: skip
    if problems:
        raise toml_problems_error(path, problems)
    return Certificate(
        channel=file.channel,
        unit=unit,
        coefficients=coefficients,
        range=(low, high),
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
        quality=quality,
        signal_unit=signal,
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
    for path in certificate_paths(folder_or_name):
        certificate = load_certificate(path)
        former = files.setdefault(certificate.channel, path)
        if former != path:
            problem = FileProblem(
                where="channel",
                what=f"'{certificate.channel}' has another certificate in {former.name}",
                remedy="keep only the one in force",
            )
            raise toml_problems_error(path, [problem])
        found[certificate.channel] = certificate
    return found


def certificate_paths(folder_or_name: str | Path) -> tuple[Path, ...]:
    """Return the certificates of a folder, or of a shipped set such as ``b777``, sorted, unread.

    Of a flight folder they are the copies kept with the flight, of an aircraft's folder in a store
    those in force.

    Raises
    ------
    UnknownNameError
        If there is neither such a folder nor such a shipped set, or it holds no certificate.
    """
    folder = Path(folder_or_name)
    if not folder.is_dir():
        folder = SHIPPED_CERTIFICATES_FOLDER / str(folder_or_name)
        if folder.parent != SHIPPED_CERTIFICATES_FOLDER or not folder.is_dir():
            hint = did_you_mean(str(folder_or_name), shipped_certificate_sets(), most=1)
            raise UnknownNameError(
                f"there is no folder '{folder_or_name}' with calibration certificates, and no "
                f"shipped set has that name; {hint}{' ' if hint else ''}shipped are: "
                f"{', '.join(shipped_certificate_sets())}"
            )
    inner = (folder / name for name in ("calibration", "in_force"))
    folder = next((place for place in inner if path_lexists(place)), folder)
    files = list_files(folder, "*.toml")
    if not files:
        raise UnknownNameError(f"the folder {folder} holds no calibration certificate (*.toml)")
    return files


def shipped_certificate_sets() -> tuple[str, ...]:
    """Return the names of the sets of certificates that come with the program."""
    return tuple(
        sorted(path.name for path in SHIPPED_CERTIFICATES_FOLDER.iterdir() if path.is_dir())
    )


def certificate_content(certificate: Certificate) -> dict[str, Any]:
    """Return what the file of a certificate holds; `load_certificate` reads it back exactly."""
    unit, signal = certificate.unit, certificate.signal_unit
    step = difference_unit(unit)
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
        content["excitation_voltage"] = f"{float(certificate.excitation_voltage)!r} V"
    content["ratiometric"] = certificate.ratiometric
    content["fit"] = {
        "coefficients": [
            f"{float(coefficient)!r} {unit_per_signal(unit, signal, power)}".rstrip()
            for power, coefficient in enumerate(certificate.coefficients)
        ],
        "range": [f"{float(end)!r} {signal}" for end in certificate.range],
        "rms_residual": f"{certificate.rms_residual:.6g} {step}".rstrip(),
        "max_residual": f"{certificate.max_residual:.6g} {step}".rstrip(),
        "hysteresis": f"{certificate.hysteresis:.6g} {step}".rstrip(),
    }
    if certificate.quality is not None:
        content["quality"] = quality_content(certificate.quality, unit, signal)
    content["points"] = [
        {
            _signal_key(signal): f"{float(point.volts)!r} {signal}",
            "value": f"{float(point.value)!r} {unit}".rstrip(),
            "direction": point.direction,
            **({"noise": f"{point.noise:.3g} {signal}"} if point.noise else {}),
        }
        for point in certificate.points
    ]
    return content


def write_certificate(certificate: Certificate, path: str | Path) -> Path:
    """Write a certificate as TOML, atomically."""
    return write_toml(path, certificate_content(certificate))


def save_certificate(certificate: Certificate, path: Path) -> None:
    """Write a certificate as TOML; raise `GroundStationError`, with words, where that fails."""
    try:
        write_certificate(certificate, path)
    except OSError as error:
        raise GroundStationError(
            format_os_error(path, error, "choose a folder with write permission")
        ) from error


def _channel_and_unit(file: _CertificateFile, problems: list[FileProblem]) -> tuple[str, str]:
    key, unit = "", file.unit
    try:
        key = channel(file.channel).quantity
        unit = normalize_unit(file.unit, key)
    except UnknownNameError as error:
        problems.append(FileProblem.from_error("channel", error))
    except UnitError as error:
        problems.append(FileProblem.from_error("unit", error))
    if file.stamp.microsecond:
        _report(
            problems,
            "stamp",
            "has fractions of a second",
            "write it to the second, as 2003-05-14T08:30:00",
        )
    if file.ratiometric and file.excitation_voltage is None:
        _report(
            problems,
            "excitation_voltage",
            "is missing; a ratiometric instrument requires it",
            'add the supply during calibration, as excitation_voltage = "5.0 V"',
        )
    (low, _), (high, _) = file.fit.range
    if not low < high:
        _report(problems, "fit.range", "ends before it begins", "swap the two")
    return key, unit


def _check_curve(
    file: _CertificateFile, coefficients: tuple[float, ...], problems: list[FileProblem]
) -> None:
    turning = turning_points(coefficients, file.fit.range[0][0], file.fit.range[1][0])
    if turning or not any(coefficients[1:]):
        what = f"turns back at {turning[0]:.3f} V" if turning else "is flat"
        _report(
            problems,
            "fit.coefficients",
            f"the curve {what}; a voltage has no unique value",
            "fit again with a lower degree, or narrow fit.range",
        )
    (low, signal), (high, _) = file.fit.range
    for index, point in enumerate(file.points):
        if not low - 1e-9 <= point.level <= high + 1e-9:
            _report(
                problems,
                f"points[{index}].volts",
                f"{point.level:g} {signal} lies outside fit.range",
                "widen fit.range to cover all points",
            )
