"""The demo does the whole job: stream, record, watch, replay, sum up, draw."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path


def test_the_headless_demo_ends_with_a_summary_and_a_picture(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "gsapp.cli", "demo", "--headless", "--speed", "25", "--out", "demo",
         "--json", "result.json"],
        capture_output=True, text=True, cwd=tmp_path, timeout=240,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "the same, to the last bit, as seen live" in done.stdout
    summary = json.loads((tmp_path / "demo" / "flight.json").read_text())
    result = json.loads((tmp_path / "result.json").read_text())
    assert {name: result[name] for name in summary} == summary
    assert Path(result["picture"]).name == "flight.png"
    assert result["channels_as_live"] == len(summary["channels"])
    assert summary["frames"]["good"] > 20_000
    assert summary["frames"]["damaged"] == 0
    # What the virtual aircraft really does: take-off near 73 ft/s, level near 100 ft/s.
    assert 27.0 < summary["channels"]["V"]["max"] < 43.0
    assert summary["channels"]["an"]["rate"] == 100.0
    assert {"Airborne", "Landed"} <= {event["text"] for event in summary["events"]}
    assert (tmp_path / "demo" / "flight.png").stat().st_size > 20_000
    assert (tmp_path / "demo" / "flight" / "raw.tlog").stat().st_size > 1_000_000
    derivatives = json.loads((tmp_path / "demo" / "flight-derivatives.json").read_text())
    assert len(derivatives["maneuvers"]) == len(summary["maneuvers"]) == 2
    # What the aircraft flew with: its shipped model.
    assert abs(derivatives["campaign"]["Cm_de"]["mean"] + 1.104) < 0.05
    assert abs(derivatives["campaign"]["Cl_da"]["mean"] - 0.395) < 0.03
