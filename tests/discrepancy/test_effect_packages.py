"""Effects of other packages: the worked example of the documentation, installed and used."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-an-effect.md"
EFFECT = "aero.Cl.da_abs_beta"
SEARCH = """
import json
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.settings import DiscrepancySettings
from tests.discrepancy.blind.cases import Case
from tests.discrepancy.blind.flying import fly_case
from tests.discrepancy.blind.plan import PLAN
from tests.discrepancy.test_hidden_effects import MANEUVERS, SEED

case = Case(id="own", group="outside", kind="outside.Cl.da_abs_beta", plan=SEED, seed=SEED,
            effects={"outside.Cl.da_abs_beta": 2.0}, rate=50, verdicts=())
flown = fly_case(case, [one for one in PLAN if one.id in MANEUVERS])
search = Investigation(flown.maneuvers, flown.aircraft, flown.model)
found = search.run(DiscrepancySettings())
print(json.dumps([found.verdict, [[one.effect, one.parameters] for one in found.effects]]))
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder in which the example is installed as a distribution."""
    folder = tmp_path_factory.mktemp("site")
    page = PAGE.read_text("utf-8")
    (source,) = re.findall(r"```python\n(.*?)```", page, flags=re.S)
    (project,) = re.findall(r"```toml\n(.*?)```", page, flags=re.S)
    (folder / "sideslip_effects.py").write_text(source, "utf-8")
    (points,) = re.findall(r'entry-points\."(gsapp\.effects)"\]\n(.*?)\n\n', project, flags=re.S)
    info = folder / "sideslip_effects-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: sideslip-effects\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{points[0]}]\n{points[1].replace(chr(34), '')}\n")
    return folder


def run(site: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python with the package of the example on its path."""
    path = os.pathsep.join((str(site), str(PAGE.parents[2])))
    return subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=True,
        timeout=600,
    )


def test_the_catalog_lists_the_example(site: Path, tmp_path: Path) -> None:
    listed = tmp_path / "catalog.json"
    run(site, "-m", "gsapp", "discrepancy", "--catalog", "--json", str(listed))
    effects = {one["effect"]: one for one in json.loads(listed.read_text("utf-8"))["effects"]}
    assert effects[EFFECT]["class"] == "A"
    assert effects[EFFECT]["parameters"]["Cl_da_abs_beta"]["plausible"] == -0.8


@pytest.mark.long
def test_a_search_finds_the_example(site: Path) -> None:
    """What has no name without the package (`test_hidden_effects`) has one with it."""
    pytest.importorskip("jsbsim", reason="truth is flown by JSBSim, which is not installed")
    verdict, effects = json.loads(run(site, "-c", SEARCH).stdout.splitlines()[-1])
    assert verdict == "effects-found"
    ((name, parameters),) = effects
    assert name == EFFECT
    assert parameters["Cl_da_abs_beta"][0] == pytest.approx(2.0, rel=0.15)


def test_a_package_that_fails_is_left_out(tmp_path: Path) -> None:
    info = tmp_path / "broken-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[gsapp.effects]\nbroken = no_such_module:EFFECT\n")
    code = "from gsapp.dynamics.terms import effect_ids; print(len(effect_ids()))"
    done = run(tmp_path, "-c", code)
    assert int(done.stdout) > 200
    assert "no_such_module" in done.stderr
