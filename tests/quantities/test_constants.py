"""The numbers that hold everywhere stand in one place, and agree with the table of units."""

import math
import re
from pathlib import Path

import pytest

import gsapp
from gsapp.quantities import constants, to_si

_REPEATED = re.compile(r"(?<![\d.\w])(9\.80665|0?\.3048|0\.0174532925\d*|pi / 180(\.0)?)(?![\d\w])")


def test_they_agree_with_the_units_in_files() -> None:
    assert to_si(1.0, "g", "acceleration") == constants.GRAVITY
    assert math.pi / 180.0 == constants.DEGREE
    assert to_si(1.0, "deg", "angle") == pytest.approx(constants.DEGREE, rel=1e-14)
    assert to_si(1.0, "ft", "length") == constants.FOOT


def test_no_other_module_writes_them_again() -> None:
    root = Path(gsapp.__file__).parents[1]
    found = []
    for package in ("gsapp", "calibration", "ui"):
        for file in sorted((root / package).rglob("*.py")):
            if file.name == "constants.py":
                continue
            code = re.sub(r'"""[\s\S]*?"""|#.*', "", file.read_text(encoding="utf-8"))
            if _REPEATED.search(code):
                found.append(str(file.relative_to(root)))
    assert not found
