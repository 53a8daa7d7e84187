"""The workflows run pinned actions, and commands that the scripts of packaging have."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
TEXT = "\n".join(path.read_text(encoding="utf-8") for path in WORKFLOWS)


def test_every_action_is_pinned_by_commit_and_names_its_version() -> None:
    actions = re.findall(r"uses: (.+)", TEXT)
    assert len(actions) >= 5
    for action in actions:
        assert re.fullmatch(r"actions/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", action)


def test_an_action_has_one_version_in_all_workflows() -> None:
    pins = set(re.findall(r"uses: ([\w/-]+)@(\w+)", TEXT))
    assert len({name for name, _ in pins}) == len(pins)


@pytest.mark.parametrize("script", ["bootstrap.py", "build.py"])
def test_the_scripts_have_the_commands_that_the_workflows_run(script: str) -> None:
    named = set(re.findall(rf"packaging/{re.escape(script)} ([a-z]+)", TEXT))
    if script == "build.py":
        named |= set(re.findall(r"build: (\w+)", TEXT))
    # Tests of commands set this; the scripts import one another from their folder.
    kept = {name: text for name, text in os.environ.items() if name != "PYTHONSAFEPATH"}
    done = subprocess.run(
        [sys.executable, ROOT / "packaging" / script], capture_output=True, text=True, env=kept
    )
    assert named
    assert named <= set(re.findall(rf"packaging/{re.escape(script)} ([a-z]+)", done.stdout))
