"""Names of modules and classes: words that nobody would search for are not used."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

NOT_USED = frozenset(
    """
    account affair believed belonging beside book board chapter chord chords competitor
    conversation danger dangers deed deeds desk doubt drawer eyes face former furniture guise
    habit halves hand hands harm head heads hear heard hearing honesty judge judged judgment
    keeper keepers kept lateness lean leaning ledger lesson lessons lore look looked looking
    maker making meaning naming nose nuisances offer pale pane parting passage passing patience
    pen photographer piece place placed placing prospect prospects quick quiet reach room rooms
    said seen sentence sentences shaken sheet shelf shelves showing shown sight sigmas slopes
    soonest spot speaking spoken stand standing stands starter stillness story stretch stretches
    sure surroundings taken taking telling told treatment trust unrest untick waiting wanted
    watch way ways wild wish wishes word words worth wrong
    """.split()  # noqa: SIM905
)
"""Metaphors and everyday words in a private sense, from names that the program had."""

FIELD_WORDS = {"StyleSheetIcons", "style_sheet", "style_sheet_icons", "WordWrapDelegate"}
"""Terms of Qt."""


def _words(name: str) -> set[str]:
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)
    return {part.lower() for part in parts}


def _names() -> Iterator[tuple[str, str]]:
    for package in ("gsapp", "ui", "calibration"):
        for path in sorted((ROOT / package).rglob("*.py")):
            where = path.relative_to(ROOT).as_posix()
            yield where, path.stem
            if path.name == "__init__.py":
                yield where, path.parent.name
            for name in re.findall(r"(?m)^ *class (\w+)", path.read_text(encoding="utf-8")):
                yield where, name


def test_names_are_words_of_the_field() -> None:
    wrong = [
        f"{where}: {name}"
        for where, name in _names()
        if name not in FIELD_WORDS and _words(name) & NOT_USED
    ]
    assert not wrong


@pytest.mark.parametrize("name", ["FlightDesk", "DeedList", "chords", "GyroRoom", "_LoreText"])
def test_a_name_that_nobody_searches_for_is_found(name: str) -> None:
    """The search sees words within names; a list that nothing matches would prove nothing."""
    assert _words(name) & NOT_USED
