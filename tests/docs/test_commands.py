"""The commands of the pages run, in the order shown, in one folder that starts as a clone does.

Info strings of ``sh`` blocks: none, run here; ``parquet``, run where pyarrow is installed;
``background``, run until the block after it ends;
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
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from gsapp.cli.main import app
from gsapp.dynamics.model import load_model

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = (
    "tutorial", "how-to/field-day", "how-to/calibrate-and-check", "how-to/estimate-derivatives",
    "how-to/find-a-missing-effect", "how-to/fly-the-virtual-aircraft",
)  # fmt: skip
"""In the order in which they use each other's flights."""
_BLOCK = re.compile(r"^ *```sh ?(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="a console program there is not interrupted alone"
)


class Step(NamedTuple):
    """One block of a page, with the command that runs beside it if there is one."""

    page: str
    lines: tuple[str, ...]
    background: str = ""


def _steps() -> Iterator[Step]:
    for page in PAGES:
        background = ""
        for kind, text in _BLOCK.findall((DOCS / f"{page}.md").read_text(encoding="utf-8")):
            lines = tuple(line.strip() for line in text.splitlines())
            if kind == "background":
                (background,) = lines
            elif not kind or (kind == "parquet" and find_spec("pyarrow")):
                yield Step(page, lines, background)
                background = ""


STEPS = tuple(_steps())


class PageRunner:
    """Runs steps in their order, each once."""

    def __init__(self) -> None:
        self._done = 0
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self._port = str(probe.getsockname()[1])

    def run_through(self, index: int) -> None:
        """Run all steps up to one that did not run yet."""
        while self._done <= index:
            number = self._done
            self._done = len(STEPS) + 1  # after a failure nothing runs
            self._run(STEPS[number])
            self._done = number + 1
        assert self._done <= len(STEPS), "an earlier command failed"

    def _run(self, step: Step) -> None:
        recorder = self._start(step.background) if step.background else None
        try:
            for line in step.lines:
                self._run_line(line)
        finally:
            if recorder is not None:
                time.sleep(1.0)
                recorder.send_signal(signal.SIGINT)
                assert recorder.wait(timeout=120.0) == 0

    def _words(self, line: str) -> list[str]:
        """Return a command's words, with a port that no other test uses."""
        return shlex.split(line.replace("14550", self._port))

    def _run_line(self, line: str) -> None:
        words = self._words(line)
        if words[0] == "cp":
            shutil.copytree(words[2], words[3])
            return
        result = CliRunner().invoke(app, words[1:])
        assert result.exit_code == 0, f"{line}\n{result.output}\n{result.exception!r}"

    def _start(self, line: str) -> subprocess.Popen[bytes]:
        words = self._words(line)
        process = subprocess.Popen([sys.executable, "-m", "gsapp", *words[1:]])
        state = Path(words[words.index("--out") + 1]) / "recorder.json"
        while not state.exists():
            assert process.poll() is None, line
            time.sleep(0.1)
        return process


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageRunner]:
    """Return a runner in a folder with what the pages use of a clone."""
    folder = tmp_path_factory.mktemp("clone")
    shutil.copytree(DOCS / "tutorial", folder / "docs" / "tutorial")
    shutil.copytree(ROOT / "calibration" / "files", folder / "calibration" / "files")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("PYTHONPATH", str(ROOT))
        yield PageRunner()


@pytest.mark.parametrize(
    "index",
    [
        pytest.param(n, id=step.page, marks=[pytest.mark.long] * (step.page != "tutorial"))
        for n, step in enumerate(STEPS)
    ],
)
def test_the_commands_run_in_the_order_shown(pages: PageRunner, index: int) -> None:
    pages.run_through(index)


def test_the_tutorial_gives_the_derivatives_that_it_shows(pages: PageRunner) -> None:
    pages.run_through(max(n for n, step in enumerate(STEPS) if step.page == "tutorial"))
    estimates = json.loads(Path("derivatives.json").read_text(encoding="utf-8"))["campaign"]
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| `(\w+)` \| (\S+) \| (\S+) \| (\S+) \| (\S+) \|", text, re.MULTILINE)
    truth = load_model("b777").derivatives
    assert len(shown) == 3
    for name, mean, std, _scatter, flown in shown:
        assert estimates[name]["mean"] == pytest.approx(float(mean), rel=5e-3)
        assert estimates[name]["std"] == pytest.approx(float(std), rel=0.1)
        assert truth[name] == pytest.approx(float(flown), rel=5e-3)
    assert Path("results", "report.html").is_file()


@pytest.mark.parametrize("line", sorted({line for step in STEPS for line in step.lines}))
def test_each_command_and_option_shown_exists(line: str) -> None:
    words = shlex.split(line)
    if words[0] == "gsapp":
        with pytest.raises(SystemExit, match="0"):
            get_command(app)([words[1], *words[2:], "--help"], standalone_mode=True)


@pytest.mark.long
def test_the_guide_finds_the_effect_that_it_hid(pages: PageRunner) -> None:
    pages.run_through(max(n for n, step in enumerate(STEPS) if step.page.endswith("effect")))
    found = json.loads(Path("missing", "discrepancy.json").read_text(encoding="utf-8"))
    (effect,) = found["effects"]
    assert found["verdict"] == "effects-found"
    assert effect["effect"] == "propulsion.Cm.throttle"
    assert effect["parameters"]["arm"]["value"] == pytest.approx(0.05, abs=1e-3)
