"""Calibration points as a CSV file: ``angle [deg],volts [V],direction``, one line for each point.

The first column may be called ``value`` or by the channel, too; the second ``pulse [us]`` or
``counts [count]``. A column ``excitation [V]`` gives
the supply at each point; the volts are then referred to its mean.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from calibration.points import DIRECTION_TEXT, CalibrationPoint, Direction
from calibration.settings import CALIBRATION
from calibration.signals import SIGNALS, Signal, find_signal
from gsapp.foundation import FileProblem, FileProblemsError, UnitError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import ChannelSpec, channel, from_si, normalize_unit, to_si

MAX_PROBLEMS = 20
_SUPPLY = CALIBRATION.supply_range
_USUAL_SIGNALS = {"pulse": "us", "counts": "count"}


_HEADING = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")
_DIRECTIONS: dict[str, Direction] = {
    "up": "up", "down": "down", "single": "single", "": "single",
    **{words: key for key, words in DIRECTION_TEXT.items() if words},
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class PointsFile:
    """What a file of points holds."""

    unit: str
    points: tuple[CalibrationPoint, ...]
    """In the order of the file, volts referred to `excitation` where it was measured."""
    lines: tuple[int, ...]
    """Where each point stands."""
    excitation: float | None = None
    """Mean supply, V."""
    signal: Signal = SIGNALS[0]
    """What was read at each point, where it is not volts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Column:
    """Where a quantity stands in each line, and how it becomes a number."""

    place: int
    heading: str
    unit: str
    limits: tuple[float, float]
    convert: Callable[[float], float]


def load_points(path: str | Path, channel_id: str) -> PointsFile:
    """Read the calibration points of a channel.

    Parameters
    ----------
    channel_id : str
        Whose points they are; its quantity decides which units the values may have.

    Raises
    ------
    FileProblemsError
        If the file holds mistakes; the first twenty are named with line and remedy.
    UnknownNameError
        If there is no such channel.
    """
    rows = _rows(path)
    problems: list[FileProblem] = []
    if not rows:
        raise FileProblemsError(path, [_problem(1, "is empty", "begin with the line "
                                                "'angle [deg],volts [V],direction'")])  # fmt: skip
    columns, direction_at = _columns(rows[0], channel_id, problems)
    if problems:
        raise FileProblemsError(path, problems)
    found: list[tuple[int, dict[str, float], Direction]] = []
    for line, cells in rows[1:]:
        if len(cells) != len(rows[0][1]):
            problems.append(
                _problem(
                    line,
                    f"has {len(cells)} cells where the heading has {len(rows[0][1])}",
                    "write one cell for each column, numbers with a decimal point",
                )
            )
            continue
        numbers = {
            key: _number(line, column, cells[column.place], problems)
            for key, column in columns.items()
        }
        text = "" if direction_at is None else cells[direction_at].strip().lower()
        if text not in _DIRECTIONS:
            problems.append(
                _problem(
                    line, f"direction '{cells[direction_at or 0].strip()}' is not known",
                    "write increasing, decreasing, or leave it empty",
                )
            )  # fmt: skip
        found.append((line, numbers, _DIRECTIONS.get(text, "single")))
    if not problems and len(found) < 2:
        problems.append(
            _problem(
                rows[-1][0],
                f"the file ends with {len(found)} points",
                "a curve needs at least two; ten also give the hysteresis",
            )
        )
    if problems:
        raise FileProblemsError(path, problems[:MAX_PROBLEMS])
    made = _points_file(columns["value"].unit, found)
    return replace(made, signal=find_signal(columns["volts"].unit))


def _points_file(unit: str, found: list[tuple[int, dict[str, float], Direction]]) -> PointsFile:
    supplies = [numbers["excitation"] for _, numbers, _ in found if "excitation" in numbers]
    supply = sum(supplies) / len(supplies) if supplies else None
    return PointsFile(
        unit=unit,
        points=tuple(
            CalibrationPoint(
                volts=numbers["volts"] * (supply / numbers["excitation"] if supply else 1.0),
                value=numbers["value"],
                direction=direction,
            )
            for _, numbers, direction in found
        ),
        lines=tuple(line for line, _, _ in found),
        excitation=supply,
    )


def _problem(line: int, what: str, remedy: str) -> FileProblem:
    return FileProblem(where=f"line {line}", what=what, remedy=remedy)


def _rows(path: str | Path) -> list[tuple[int, list[str]]]:
    """Return the lines that hold anything, with their numbers."""
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(stream, strict=True)
            return [
                (reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)
            ]
    except UnicodeDecodeError as error:
        problem = FileProblem(
            where=f"byte {error.start}", what="is not UTF-8 text", remedy="save the file as UTF-8"
        )
    except csv.Error as error:
        problem = _problem(
            reader.line_num, f"is not CSV ({error})", "write cells without quotation marks"
        )
    except OSError as error:
        problem = FileProblem(
            where="file",
            what=f"cannot be read ({error.strerror})",
            remedy="check the path and the permissions",
        )
    raise FileProblemsError(path, [problem])


def _columns(
    row: tuple[int, list[str]], channel_id: str, problems: list[FileProblem]
) -> tuple[dict[str, _Column], int | None]:
    """Return the columns of numbers, and where the direction stands."""
    line, headings = row
    spec = channel(channel_id)
    names = {
        "angle": "value", "value": "value", channel_id: "value", "volts": "volts",
        f"{channel_id}_volts": "volts", "pulse": "volts", "counts": "volts",
        "excitation": "excitation", "direction": "direction",
    }  # fmt: skip
    columns: dict[str, _Column] = {}
    direction_at: int | None = None
    seen: set[str] = set()
    for index, heading in enumerate(headings):
        match = _HEADING.fullmatch(heading)
        name = match["name"].lower() if match else heading
        key = names.get(name)
        if match is None or key is None:
            remedy = did_you_mean(name, names, f"known: {', '.join(names)}", most=1)
            problems.append(_problem(line, f"'{heading.strip()}' is not a known column", remedy))
            continue
        if key in seen:
            problems.append(_problem(line, f"there are two columns for {key}", "keep one"))
        seen.add(key)
        if key == "direction":
            direction_at = index
            continue
        if match["unit"] is None:
            usual = spec.si_display if key == "value" else _USUAL_SIGNALS.get(name, "V")
            problems.append(_problem(line, f"'{name}' has no unit", f"write '{name} [{usual}]'"))
            continue
        try:
            columns[key] = _column(index, name, key, match["unit"], spec)
        except UnitError as error:
            problems.append(FileProblem.from_error(f"line {line}", error))
    for key, example in (("value", "angle [deg]"), ("volts", "volts [V]")):
        if key not in seen:
            problems.append(
                _problem(line, f"there is no column '{example}'", "add it to the heading")
            )
    return columns, direction_at


def _column(place: int, name: str, key: str, unit: str, spec: ChannelSpec) -> _Column:
    """Return a column; values stay in their unit, a signal and the supply become V, us or count.

    Raise UnitError if it cannot have that unit.
    """
    if key == "volts":
        signal = find_signal(unit)
        factor = signal.factors[unit.strip()]
        low, high = (limit / factor for limit in signal.limits)
        return _Column(
            place=place, heading=name, unit=unit.strip(), limits=(low, high),
            convert=lambda number: number * factor,
        )  # fmt: skip
    value = key == "value"
    quantity, limits = (spec.quantity, spec.limits) if value else ("voltage", _SUPPLY)
    unit = normalize_unit(unit, quantity)
    low, high = (from_si(limit, unit, quantity) for limit in limits)
    return _Column(
        place=place,
        heading=name,
        unit=unit,
        limits=(low, high),
        convert=(lambda number: number)
        if value
        else (lambda number: to_si(number, unit, quantity)),
    )


def _number(line: int, column: _Column, text: str, problems: list[FileProblem]) -> float:
    """Return the number in a cell; NaN, and a problem, where there is none."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    low, high = column.limits
    if not math.isfinite(number):
        problems.append(
            _problem(
                line,
                f"{column.heading} '{text.strip()}' is not a number",
                "write it with a decimal point and without its unit, as 2.513",
            )
        )
    elif not low <= number <= high:
        problems.append(
            _problem(
                line,
                f"{column.heading} {number:g} {column.unit} is not possible "
                f"({low:g} to {high:g} {column.unit})",
                "check the number and the unit in the heading",
            )
        )
    return column.convert(number)
