"""The license is stated where tools look for it, and agrees with that of every dependency."""

import re
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "licenses.md").read_text(encoding="utf-8")
LISTED = dict(re.findall(r"^\| `([\w.-]+)` \| (.+?) \|$", PAGE, re.MULTILINE))
WEAK_COPYLEFT = {"pymavlink", "pyside6-essentials", "shiboken6"}


def locked(name: str) -> set[str]:
    text = (ROOT / "packaging" / name).read_text(encoding="utf-8")
    return set(re.findall(r"^([\w.-]+)==", text, re.MULTILINE))


RUN = set().union(*(locked(f"{name}.lock") for name in ("run", "parquet", "notebook", "dask")))


def declared(package: str) -> str:
    about = metadata(package)
    text = about.get("License-Expression") or about.get("License") or ""
    if 0 < len(text) < 60 and "\n" not in text and not text.startswith("Copyright"):
        return text
    kinds = [one for one in about.get_all("Classifier") or () if one.startswith("License ::")]
    return kinds[-1].rpartition(" :: ")[2] if kinds else text


def test_every_locked_package_is_listed_with_the_license_that_it_declares() -> None:
    assert set(LISTED) == RUN | locked("test.lock")
    for package, license_ in LISTED.items():
        try:
            found = declared(package)
        except PackageNotFoundError:  # of another system
            continue
        assert found == license_, package


@pytest.mark.parametrize("package", sorted(RUN))
def test_nothing_that_runs_asks_more_than_the_readme_says(package: str) -> None:
    copyleft = re.search("GPL|General Public|MPL|Mozilla|EUPL|CDDL|EPL", LISTED[package])
    assert (copyleft is not None) == (package in WEAK_COPYLEFT)


def test_the_metadata_names_license_authors_and_version() -> None:
    about = metadata("gsapp-ground-station")
    assert about["License-Expression"] == "BSD-3-Clause"
    assert about["Author"] == "The maintainers"
    assert (ROOT / "LICENSE").read_text(encoding="utf-8").startswith("BSD 3-Clause License")
    assert "license: BSD-3-Clause" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_the_version_stands_in_one_place() -> None:
    (version,) = re.findall(
        r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert metadata("gsapp-ground-station")["Version"] == version
    assert version in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert version not in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
