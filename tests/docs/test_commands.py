"""The commands of the pages run, in the order shown, in one folder that starts as a clone does.

Info strings of ``sh`` blocks: none, run here; ``background``, run until the block after it ends;
``field``, needs an aircraft or a card; ``window``, opens the window; ``setup``, done by packaging.
"""

from __future__ import annotations

import json
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gsapp.cli.main import app
from gsapp.dynamics.model import load_model

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GUIDES = (
    "field-day", "calibrate-and-check", "estimate-derivatives", "find-a-missing-effect",
    "fly-the-virtual-aircraft",
)  # fmt: skip
"""Pages of how-to that run, after the tutorial, whose flight they use."""
_BLOCK = re.compile(r"^ *```sh ?(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)


def _blocks(page: Path) -> list[tuple[str, list[str]]]:
    """Return kind and lines of the blocks to run, with a port that no other test uses."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = str(probe.getsockname()[1])
    return [
        (kind, [line.strip().replace("14550", port) for line in text.splitlines()])
        for kind, text in _BLOCK.findall(page.read_text(encoding="utf-8"))
        if kind in ("", "background")
    ]


def _run(line: str) -> None:
    words = shlex.split(line)
    if words[0] == "cp":
        shutil.copytree(words[2], words[3])
        return
    assert words[0] == "gsapp", line
    result = CliRunner().invoke(app, words[1:])
    assert result.exit_code == 0, f"{line}\n{result.output}\n{result.exception!r}"


def _start(line: str) -> subprocess.Popen[bytes]:
    words = shlex.split(line)
    process = subprocess.Popen([sys.executable, "-m", "gsapp", *words[1:]])
    state = Path(words[words.index("--out") + 1]) / "recorder.json"
    while not state.exists():
        assert process.poll() is None, line
        time.sleep(0.1)
    return process


def _run_page(page: Path) -> None:
    background = None
    for kind, lines in _blocks(page):
        if kind == "background":
            (line,) = lines
            background = _start(line)
            continue
        for line in lines:
            _run(line)
        if background is not None:
            time.sleep(1.0)
            background.send_signal(signal.SIGINT)
            assert background.wait(timeout=60.0) == 0
            background = None


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return a folder with what the pages use of a clone, after the tutorial."""
    if sys.platform == "win32":
        pytest.skip("a console program there is not interrupted alone")
    folder = tmp_path_factory.mktemp("clone")
    shutil.copytree(DOCS / "tutorial", folder / "docs" / "tutorial")
    shutil.copytree(ROOT / "calibration" / "files", folder / "calibration" / "files")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("PYTHONPATH", str(ROOT))
        _run_page(DOCS / "tutorial.md")
        yield folder


def test_the_tutorial_gives_the_derivatives_that_it_shows(clone: Path) -> None:
    estimates = json.loads((clone / "derivatives.json").read_text())["campaign"]
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| `(\w+)` \| (\S+) \| (\S+) \| (\S+) \| (\S+) \|", text, re.MULTILINE)
    truth = load_model("b777").derivatives
    assert len(shown) == 3
    for name, mean, std, _scatter, flown in shown:
        assert estimates[name]["mean"] == pytest.approx(float(mean), rel=5e-3)
        assert estimates[name]["std"] == pytest.approx(float(std), rel=0.1)
        assert truth[name] == pytest.approx(float(flown), rel=5e-3)
    assert (clone / "results" / "report.html").is_file()


@pytest.mark.parametrize("name", GUIDES)
def test_the_commands_of_the_guide_run(clone: Path, name: str) -> None:
    page = DOCS / "how-to" / f"{name}.md"
    assert _blocks(page)
    _run_page(page)


def test_the_guide_finds_the_effect_that_it_hid(clone: Path) -> None:
    found = json.loads((clone / "missing" / "discrepancy.json").read_text())
    (effect,) = found["effects"]
    assert found["verdict"] == "effects-found"
    assert effect["effect"] == "propulsion.Cm.throttle"
    assert effect["parameters"]["arm"]["value"] == pytest.approx(0.05, abs=1e-3)
