"""The type check of the test command holds on the systems that this one is not."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("gsapp", "calibration")


@pytest.mark.long
@pytest.mark.parametrize("platform", sorted({"linux", "darwin", "win32"} - {sys.platform}))
def test_what_asks_for_the_system_has_its_types_right_on_all(tmp_path: Path, platform: str) -> None:
    asking = [
        str(path)
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
        if "sys.platform" in path.read_text(encoding="utf-8")
    ]
    assert asking
    command = [sys.executable, "-m", "mypy", "--platform", platform, "--follow-imports=silent"]
    done = subprocess.run(
        [*command, f"--cache-dir={tmp_path}", *asking],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
