"""Parts stand in the import contract, the core has no graphics; names and TOML are read."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from gsapp.foundation import FileProblemsError, StrictModel, read_toml, write_toml
from gsapp.foundation.name_suggestions import did_you_mean, format_names

PROJECT = Path(__file__).parents[2]


def contract() -> dict[str, object]:
    return tomllib.loads((PROJECT / "pyproject.toml").read_text())["tool"]["importlinter"]


def test_every_part_of_gsapp_stands_in_the_contract() -> None:
    layers, _, forbidden = contract()["contracts"]
    parts = {f"gsapp.{path.parent.name}" for path in (PROJECT / "gsapp").glob("*/__init__.py")}
    assert parts <= set(layers["layers"])
    with_graphics = {"gsapp.api", "gsapp.cli", "gsapp.report"}
    assert parts - with_graphics <= set(forbidden["source_modules"])
    # A module beside the parts would stand outside every layer.
    outside = {path.name for path in (PROJECT / "gsapp").glob("*.py")}
    assert outside == {"__init__.py", "__main__.py"}


@pytest.mark.long
def test_every_core_module_imports_with_graphics_blocked() -> None:
    program = """
import importlib, pkgutil, sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"PySide6", "shiboken6", "pyqtgraph", "matplotlib"}:
            raise ImportError(f"{name} is graphics")
sys.meta_path.insert(0, Block())
import gsapp, calibration
count = 0
for package in (gsapp, calibration):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        above = ("gsapp.api", "gsapp.cli", "gsapp.report")
        if module.name.startswith(above) or "__main__" in module.name:
            continue
        importlib.import_module(module.name)
        count += 1
print(count)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 30


@pytest.mark.parametrize(
    ("names", "text"),
    [((), ""), (("p",), "p"), (("p", "q"), "p, q"), (("p", "q", "r", "V"), "p, q and 2 more")],
)
def test_of_many_names_only_the_first_are_named(names: tuple[str, ...], text: str) -> None:
    assert format_names(names, 2) == text


def test_a_slip_is_answered_by_what_is_near() -> None:
    known = ("alpha", "beta", "theta")
    assert did_you_mean("thetta", known) == "did you mean 'theta' or 'beta'?"
    assert did_you_mean("thetta", known, most=1) == "did you mean 'theta'?"
    assert did_you_mean("rpm", known, "known are three") == "known are three"


class Inner(StrictModel):
    size: float
    items: tuple[int, ...] = ()


class Outer(StrictModel):
    name: str
    inner: Inner
    parts: tuple[Inner, ...] = ()


def problems(tmp_path: Path, text: str | bytes) -> list[str]:
    path = tmp_path / "file.toml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(FileProblemsError) as caught:
        read_toml(path, Outer)
    assert str(path) in str(caught.value)
    return [str(problem) for problem in caught.value.problems]


def test_every_mistake_is_reported_at_once_with_its_key_path(tmp_path: Path) -> None:
    found = problems(tmp_path, "nam = 'x'\n[inner]\nsise = 1\n[[parts]]\nsize = 'big'\n")
    assert [problem.split(":")[0] for problem in found] == [
        "name",
        "line 2, inner.size",
        "line 3, inner.sise",
        "line 5, parts[0].size",
        "line 1, nam",
    ]
    assert "'size'" in found[2]
    assert "'name'" in found[4]


def test_a_syntax_error_names_line_and_column(tmp_path: Path) -> None:
    (only,) = problems(tmp_path, "name = 'x'\nsize = 3 ft\n")
    assert only.startswith("line 2, column")


def test_bytes_that_are_not_text_are_named(tmp_path: Path) -> None:
    (only,) = problems(tmp_path, b"\nname = '\xff\xfe'")
    assert only.startswith("line 2: byte 9 ")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileProblemsError, match="cannot be read"):
        read_toml(tmp_path / "absent.toml", Outer)


def test_what_is_written_reads_back_without_none(tmp_path: Path) -> None:
    path = write_toml(tmp_path / "f.toml", {"name": "x", "inner": {"size": 1.5, "items": [1, 2]}})
    assert read_toml(path, Outer) == Outer(name="x", inner=Inner(size=1.5, items=(1, 2)))
    assert "gone" not in write_toml(path, {"gone": None}).read_text()
