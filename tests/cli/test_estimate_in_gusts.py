"""``gsapp estimate`` of a maneuver in gusts: equation error on the screen and in the JSON."""

import json
import math
from pathlib import Path

import pytest

from gsapp.cli.estimate import estimate
from gsapp.flight.writers import write_block
from tests.identification.virtual_maneuvers import fly


def test_equation_error_stands_beside_in_gusts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A column of its own with the value that the JSON holds, and where the two lie apart."""
    monkeypatch.setenv("COLUMNS", "200")
    rough = fly(70, "lon", gust=1.0, dt=0.02).maneuver
    flight = write_block(tmp_path / "gusty.csv", rough.block, "csv")
    out = tmp_path / "out.json"
    estimate(flights=[flight], aircraft="b777", maneuver_windows=["0:10"], json=out)
    shown = capsys.readouterr().out
    (maneuver,) = json.loads(out.read_text(encoding="utf-8"))["maneuvers"]
    beside = maneuver["equation_error"]["derivatives"]["Cm_q"]
    (row,) = [line for line in shown.splitlines() if line.strip().startswith("Cm_q")]
    assert f"{beside['value']:.3f} ±{beside['std']:.3f}" in row
    assert f"{maneuver['derivatives']['Cm_q']['value']:.3f} ±" in row
    said = " ".join(shown.split())
    assert "turbulence" in said
    both = (maneuver["derivatives"], maneuver["equation_error"]["derivatives"])
    apart = [
        name
        for name, one in both[0].items()
        if not name.endswith("_0")
        and one["value"] is not None
        and abs(one["value"] - both[1][name]["value"])
        > 2.0 * math.hypot(one["std"], both[1][name]["std"])
    ]
    if apart:
        assert f"2 joint bounds off in {', '.join(apart)}; use the smaller bound" in said
    else:
        assert "equation error agrees" in said
