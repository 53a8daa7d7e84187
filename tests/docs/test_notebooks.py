"""The notebooks run from the first cell to the last, and find what the virtual aircraft flew."""

import ast
import json
from pathlib import Path
from typing import Any

import pytest

from gsapp.dynamics.model import load_model

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"
PATHS = sorted(FOLDER.glob("*.ipynb"))


def cells(path: Path) -> list[dict[str, Any]]:
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content["nbformat"] == 4
    return list(content["cells"])


def source(cell: dict[str, Any]) -> str:
    return "".join(cell["source"])


def run(name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """Run the code cells as Jupyter does: in one namespace, the value of each last line shown."""
    pytest.importorskip("pandas")
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (path,) = FOLDER.glob(f"{name}*.ipynb")
    namespace: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(cells(path), start=1):
        if cell["cell_type"] != "code":
            continue
        tree = ast.parse(source(cell))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        place = f"{path.name}, cell {number}"
        exec(compile(tree, place, "exec"), namespace)  # noqa: S102 - our own
        if last is not None:
            shown = eval(compile(ast.Expression(last.value), place, "eval"), namespace)  # noqa: S307
            for show in ("_repr_html_", "_repr_png_"):
                if hasattr(shown, show):
                    assert getattr(shown, show)()
    return namespace


def test_the_notebooks_are_three_without_outputs() -> None:
    assert [path.name[0] for path in PATHS] == ["1", "2", "3"]
    for path in PATHS:
        code = [one for one in cells(path) if one["cell_type"] == "code"]
        assert [one for one in code if one["outputs"] or one["execution_count"]] == []
        assert len({one["id"] for one in cells(path)}) == len(cells(path))
        assert max(len(line) for one in code for line in source(one).splitlines()) <= 120


def test_from_a_log_to_derivatives(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found = run("1", monkeypatch, tmp_path)
    frame = found["derivatives"].set_index("derivative")
    truth = load_model("b777").derivatives
    for name in ("CN_alpha", "Cm_alpha", "Cm_de", "Cl_p", "Cn_beta"):
        row = frame.loc[name]
        assert abs(row["value"] - truth[name]) < 5.0 * row["std"]
    assert len(found["frame"]) == len(found["flight"].block)


@pytest.mark.long
def test_a_hidden_effect_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found = run("2", monkeypatch, tmp_path)
    (effect,) = found["found"].outcome.effects
    assert effect.effect == "aero.Cm.alpha2"
    value, std = effect.parameters["Cm_alpha2"]
    assert abs(value + 2.0) < 4.0 * std
    gap = found["gap"].loc["q"]
    assert gap["after"] < gap["before"]


@pytest.mark.long
def test_a_campaign_compared(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    value = run("3", monkeypatch, tmp_path)["value"]
    assert value.loc["Cm_alpha", "in_bounds"] > 3.0
    assert abs(value.loc["CN_de", "in_bounds"]) < 3.0
