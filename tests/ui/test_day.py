"""A short day by mouse and keys in a real X server; the whole day is a benchmark."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from gsapp.flight.raw_files import RawTail
from tests.ui.x_driver import left_running, missing_programs, x_server

WALK = Path(__file__).with_name("day_walk.py")


def walk(name: str, folder: Path, where: dict[str, str]) -> dict[str, object]:
    command = [sys.executable, "-P", str(WALK), name, str(folder)]
    done = subprocess.run(
        command, env=where, capture_output=True, text=True, timeout=300.0, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads((folder / f"{name}.json").read_text())


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="X servers are for Linux")
def test_a_day_by_mouse_and_keys(tmp_path: Path) -> None:
    if missing := missing_programs():
        pytest.skip(f"not installed: {', '.join(missing)}")
    with x_server(tmp_path) as where:
        seen = walk("quick", tmp_path, where)
        assert left_running(tmp_path) == []
        assert seen["port"] in seen["wrong_port"]
        assert any("silent" in text for text in seen["alarms"])
        assert not seen["recording"]
        assert seen["waiting"] == seen["recorders"] == []
        (flight,) = (tmp_path / "flights").iterdir()
        assert len(RawTail(flight).poll()) == seen["sent"]
        assert flight.name in walk("again", tmp_path, where)["listed"]
