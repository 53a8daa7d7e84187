"""Every part stands in the import contract, and the core runs without any graphics."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]


def contract() -> dict[str, object]:
    return tomllib.loads((PROJECT / "pyproject.toml").read_text())["tool"]["importlinter"]


def test_every_part_of_gsapp_stands_in_the_contract() -> None:
    layers, _, forbidden = contract()["contracts"]
    parts = {f"gsapp.{path.parent.name}" for path in (PROJECT / "gsapp").glob("*/__init__.py")}
    assert parts <= set(layers["layers"])
    with_graphics = {"gsapp.cli", "gsapp.report"}
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
        if module.name.startswith(("gsapp.cli", "gsapp.report")) or "__main__" in module.name:
            continue
        importlib.import_module(module.name)
        count += 1
print(count)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 30
