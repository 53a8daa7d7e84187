"""The registry of estimation methods, and the worked example of its how-to page."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from pkgutil import resolve_name

import pytest

from gsapp.dynamics.model import load_model
from gsapp.flight.writers import write_block
from gsapp.foundation import UnknownNameError
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.identification.methods import estimation_method, estimation_methods, short_method_title
from gsapp.virtual.virtual_flight import VirtualFlight

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-a-method.md"
_BLOCK = re.compile(r"^```\w+ (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def test_every_record_names_what_exists() -> None:
    for method in estimation_methods().values():
        assert callable(resolve_name(method.function))
        assert method.settings <= set(EstimateSettings.model_fields)


def test_a_method_that_is_not_installed_is_named_by_its_id() -> None:
    assert short_method_title("wls") == "wls"
    with pytest.raises(UnknownNameError, match="'ml'"):
        estimation_method("mll")


@pytest.mark.long
def test_the_example_of_the_how_to_page_runs_as_a_package(
    tmp_path: Path, flown_short: Callable[[int], VirtualFlight]
) -> None:
    """Written as the page says, found by its entry point, run by the command of the page."""
    package = tmp_path / "site"
    for name, text in _BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text, encoding="utf-8")
    _install(package)
    flight = tmp_path / "flight.csv"
    write_block(flight, flown_short(5).measured, "csv")
    out = tmp_path / "wls.json"
    done = subprocess.run(
        [sys.executable, "-m", "gsapp", "estimate", str(flight), "--aircraft", "b777",
         "--method", "wls", "--json", str(out)],
        capture_output=True, encoding="utf-8", check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join((str(package), *sys.path))},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(out.read_text(encoding="utf-8"))
    assert found["method"] == "wls"
    truth = load_model("b777")
    for name in ("CN_alpha", "Cm_alpha", "Cm_de"):
        assert found["campaign"][name]["mean"] == pytest.approx(truth.derivative(name), rel=0.25)


def _install(folder: Path) -> None:
    """Write what an installer writes: the names and entry points of the package."""
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    metadata = folder / f"gsapp_wls-{project['version']}.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    points = "".join(
        f"[{group}]\n" + "".join(f"{name} = {value}\n" for name, value in found.items())
        for group, found in project["entry-points"].items()
    )
    (metadata / "entry_points.txt").write_text(points)
