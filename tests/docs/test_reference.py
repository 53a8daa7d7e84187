"""The reference pages say what the code says."""

from __future__ import annotations

import importlib
import importlib.util
import re
from pathlib import Path

import pytest

_SPEC = importlib.util.spec_from_file_location(
    "reference", Path(__file__).with_name("reference.py")
)
assert _SPEC is not None
assert _SPEC.loader is not None
GLOSSARY = Path(__file__).parents[2] / "docs" / "reference" / "glossary.md"
reference = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(reference)


@pytest.mark.parametrize("page", reference.PAGES)
def test_the_page_is_what_the_code_says(page: str) -> None:
    written = (reference.FOLDER / page).read_text(encoding="utf-8")

    assert written == reference.PAGES[page](), "write it anew: python -m tests.docs.reference"


def test_all_that_the_glossary_names_is_defined_there() -> None:
    named = re.findall(r"\| `([\w.]+)` \|$", GLOSSARY.read_text(encoding="utf-8"), re.MULTILINE)

    missing = [name for name in named if not _is_defined(name)]

    assert len(named) > 60
    assert missing == []


def _is_defined(name: str) -> bool:
    if importlib.util.find_spec(name.split(".")[0]) is None:
        return False
    try:
        importlib.import_module(name)
    except ModuleNotFoundError:
        module, _, attribute = name.rpartition(".")
        try:
            return hasattr(importlib.import_module(module), attribute)
        except ModuleNotFoundError:
            return False
    return True
