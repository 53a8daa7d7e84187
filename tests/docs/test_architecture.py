"""The pages on the program's structure agree with the code."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.docs.reference import is_defined

ROOT = Path(__file__).parents[2]
GIT = shutil.which("git")
ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8")
PATHS = ("Live tick", "Estimate", "Discrepancy search", "Calibration")
QUESTIONS = re.findall(r"^\| [^|]+\? \| `git grep ([^`]+)` \| `([^`]+)` \|$", CONTRIBUTING, re.M)


def test_the_architecture_lists_every_package() -> None:
    packages = {
        path.parent.relative_to(ROOT).as_posix().replace("/", ".")
        for root in ("gsapp", "ui", "calibration")
        for path in (ROOT / root).rglob("__init__.py")
    }
    listed = set(re.findall(r"^\| `([\w.]+)` \|", ARCHITECTURE, re.M))

    assert listed == packages - {"gsapp"}


@pytest.mark.parametrize("title", PATHS)
def test_a_main_path_names_what_exists_in_ten_lines(title: str) -> None:
    section = ARCHITECTURE.split(f"## {title}\n")[1].split("\n## ")[0]
    drawn = re.findall(r"^    ( *)((?:gsapp|ui|calibration)\.[\w.]+)", section, re.M)

    assert 5 <= len(drawn) <= 10
    assert [name for _indent, name in drawn if not is_defined(name)] == []


def test_each_dotted_name_in_the_architecture_exists() -> None:
    named = set(re.findall(r"`((?:gsapp|ui|calibration)(?:\.\w+)+)`", ARCHITECTURE))

    assert [name for name in sorted(named) if not is_defined(name)] == []


@pytest.mark.skipif(GIT is None or not (ROOT / ".git").exists(), reason="needs a clone and git")
@pytest.mark.parametrize(("search", "answer"), QUESTIONS)
def test_a_term_of_the_field_leads_to_the_code(search: str, answer: str) -> None:
    """The page itself holds the answer, so it does not count."""
    option, pattern = re.fullmatch(r'(-i) "(.+)"', search).groups()  # type: ignore[union-attr]
    outside = ":!docs/contributing.md"
    found = subprocess.run(
        [str(GIT), "grep", option, pattern, "--", ".", outside], cwd=ROOT, capture_output=True,
        text=True, check=True,
    ).stdout  # fmt: skip

    assert answer in found
    assert len(found.splitlines()) < 30


def test_ten_questions_are_asked() -> None:
    assert len(QUESTIONS) == 10
