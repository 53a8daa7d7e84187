"""The demo does the whole job: stream, record, watch, replay, sum up, draw, estimate, report."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from gsapp.flight.catalog import Catalog
from gsapp.identification.runs.run_store import stored_runs


@pytest.mark.long
def test_the_headless_demo_ends_with_a_summary_and_a_picture(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "gsapp.cli", "demo", "--headless", "--speed", "25", "--out", "demo",
         "--json", "result.json"],
        capture_output=True, encoding="utf-8", cwd=tmp_path, timeout=900,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "bit-identical" in done.stdout
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
    # The campaign: this flight's two maneuvers, and six of another flight.
    derivatives = json.loads((tmp_path / result["derivatives"]).read_text())
    assert len(summary["maneuvers"]) == 2
    assert [one["id"][0] for one in derivatives["maneuvers"]] == ["1"] * 6 + ["2"] * 2
    # What the aircraft flew with: its shipped model.
    assert abs(derivatives["campaign"]["Cm_de"]["mean"] + 1.104) < 0.03
    assert abs(derivatives["campaign"]["Cl_da"]["mean"] - 0.395) < 0.02
    report = tmp_path / result["report"]
    page = (report / "report.html").read_text()
    assert "1 maneuver" in page
    assert (report / "report.pdf").stat().st_size > 50_000
    assert {"derivatives.mat", "model.toml", "linear-lon.toml"} <= {
        path.name for path in report.iterdir()
    }
    with Catalog(tmp_path / result["catalog"]) as catalog:
        (kept,) = stored_runs(catalog)
    assert kept.maneuver_count == 8
