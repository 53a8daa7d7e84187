"""Texts in a CSV: none of them is a formula for a spreadsheet, and each number stays one."""

import csv
import io

import pytest

from gsapp.foundation.delimited_text import delimited_text

FORMULAS = (
    "=1+1", "+cmd|' /C calc'!A0", "-2+3+cmd|' /C calc'!A0", "@SUM(A1)", "\t=1", "\r=1", " =1",
    "=HYPERLINK(\"http://x\")", "-x", "+", "\uff1d1+1", "-1-1", "-1*2",
)  # fmt: skip
PLAIN = (
    "", "doublet", "-0.34", "+3", "-1e-05", "-0.34 ± 0.01", "-12.5 deg", "-1,200", "-", "--",
    "-inf", "a=1", "M-1", "-3 ft/s",
)  # fmt: skip


def read(text: str) -> list[str]:
    return next(csv.reader(io.StringIO(text, newline="")))


@pytest.mark.parametrize("separator", [",", "\t"])
@pytest.mark.parametrize("cell", FORMULAS)
def test_a_formula_becomes_text(cell: str, separator: str) -> None:
    text = delimited_text([[cell, "next"]], separator)
    rows = list(csv.reader(io.StringIO(text, newline=""), delimiter=separator))
    assert rows == [["'" + cell.replace("\r", "\n"), "next"]]


@pytest.mark.parametrize("cell", PLAIN)
def test_what_is_no_formula_stays(cell: str) -> None:
    assert read(delimited_text([[cell, "x"]])) == [cell, "x"]


def test_a_return_begins_no_line() -> None:
    assert read(delimited_text([["windy\r=1+1", "x"]])) == ["windy\n=1+1", "x"]


def test_numbers_stay_numbers() -> None:
    assert delimited_text([[-1.5, 2, None], ["a", "b,c", 'd"']]) == '-1.5,2,\na,"b,c","d"""\n'
