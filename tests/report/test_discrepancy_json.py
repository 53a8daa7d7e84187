"""The JSON of ``gsapp discrepancy`` has the fixed keys (DESIGN section 5) and is strict."""

import json
from pathlib import Path
from typing import Any

import pytest

from gsapp.discrepancy.results import discrepancy_json
from tests.report.discrepancy_kit import adequate, answer

# The fixed shape, written down a second time by hand: a list stands for a list of such things.
TOP = {
    "verdict", "disagreements", "observability", "ranking", "effects", "values", "alternatives",
    "disturbance", "gap", "model", "why",
}  # fmt: skip
DISAGREEMENT = {
    "coefficient", "channel", "maneuver", "t_start", "t_end", "rms", "noise_floor", "p_value",
    "region",
}  # fmt: skip
OBSERVABILITY = {"effect", "class", "sigma", "aliases", "fly"}
RANKED = {"effect", "title", "score", "evidence"}
EFFECT = {"effect", "title", "equation", "parameters", "confidence"}


def read_back(found: Any, **options: Any) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    text = json.dumps(discrepancy_json(found, **options), allow_nan=False)
    return json.loads(text, parse_constant=refuse)


def test_every_fixed_key_is_there_with_its_meaning() -> None:
    content = read_back(answer(), model=Path("out/model.toml"))
    assert set(content) >= TOP
    assert content["verdict"] == "effects-found"
    assert content["model"] == str(Path("out/model.toml"))
    first = content["disagreements"][0]
    assert set(first) == DISAGREEMENT
    assert first["coefficient"] == "Cm"
    assert first["region"] == {
        "variable": "throttle", "low": 0.7, "high": 1.0, "words": "throttle above 70 %",
    }  # fmt: skip
    assert content["disagreements"][1]["region"] is None
    seen = content["observability"][0]
    assert set(seen) >= OBSERVABILITY
    assert seen["class"] == "A"
    assert seen["aliases"] == ["aero.Cm.speed"]
    assert [one["effect"] for one in content["ranking"]] == [
        "propulsion.Cm.throttle", "aero.Cm.speed", "unnamed.Cm.alpha_de2",
    ]  # fmt: skip
    assert all(set(one) >= RANKED for one in content["ranking"])
    named = content["effects"][0]
    assert set(named) >= EFFECT
    assert named["parameters"] == {"arm": {"value": 0.0493, "std": 0.0021}}
    assert content["effects"][1]["forced"] is True
    assert content["values"] == {"Cm_q": {"before": -23.0, "after": -19.4, "std": 0.6}}
    assert content["alternatives"][0]["effects"] == ["mass.cg.x", "aero.CN.alpha"]
    assert "two scales" in content["alternatives"][0]["fly"]
    assert content["disturbance"]["gust"] == pytest.approx(0.31)
    assert set(content["gap"]) >= {"channels", "closed", "on"}
    assert set(content["gap"]["channels"]["q"]) >= {"before", "after", "floor"}
    assert content["gap"]["on"] == ["3", "6"]


def test_ranking_is_the_one_that_the_baseline_faced() -> None:
    found = answer()
    assert read_back(found)["ranking"] == read_back(found)["steps"][0]["ranking"]
    assert [one["added"] for one in read_back(found)["steps"]] == [
        None, "propulsion.Cm.throttle", "aero.Cm.alpha2",
    ]  # fmt: skip


def test_what_is_absent_is_null_and_infinite_is_absent() -> None:
    content = read_back(adequate())
    assert set(content) >= TOP
    assert content["gap"]["closed"] is None
    assert content["disturbance"] == {"gust": None}
    assert content["model"] is None
    assert content["ranking"] == []
    # No size of flap would show without a flap moved.
    assert content["observability"][1]["sigma_size"] is None
