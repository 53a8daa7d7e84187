"""The reference pages agree with the code."""

from __future__ import annotations

import re

import pytest

from tests.docs import reference


@pytest.mark.parametrize("page", reference.PAGES)
def test_the_page_is_what_the_code_says(page: str) -> None:
    written = (reference.FOLDER / page).read_text(encoding="utf-8")

    assert written == reference.PAGES[page](), "run: python -m tests.docs.reference"


def test_each_name_in_the_glossary_exists() -> None:
    glossary = (reference.FOLDER / "glossary.md").read_text(encoding="utf-8")
    named = re.findall(r"\| `([\w.]+)` \|$", glossary, re.MULTILINE)

    assert len(named) > 60
    assert [name for name in named if not reference.is_defined(name)] == []


def test_a_name_that_does_not_exist_is_found() -> None:
    assert not reference.is_defined("gsapp.quantities.absent")
    assert not reference.is_defined("gsapp.quantities.channels.ABSENT")
    assert not reference.is_defined("absent.module")
