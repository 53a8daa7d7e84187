"""Numbers with units in certificate files: written, and read with every mistake named."""

from __future__ import annotations

import re

from gsapp.foundation import FileProblem, UnitError
from gsapp.quantities import from_si, normalize_unit, to_si

_NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def unit_per_volt(unit: str, power: int) -> str:
    """Return the unit of the coefficient of a power of volts."""
    base = difference_unit(unit) if power else unit
    if power == 0:
        return base
    per = "V" if power == 1 else f"V^{power}"
    return f"{base or '1'}/{per}"


def difference_unit(unit: str) -> str:
    """Return the unit of a difference: a step of one degree Celsius is one kelvin."""
    return {"degC": "K", "degF": "delta_degF"}.get(unit, unit)


def parse_quantity(text: str, unit: str, where: str, problems: list[FileProblem]) -> float:
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


def parse_quantity_in_unit(
    text: str, unit: str, key: str, where: str, problems: list[FileProblem]
) -> float:
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
        problems.append(FileProblem.from_error(where, error))
        return float("nan")
