"""A kept run done again, and two beside each other: what differs is said, down to the last bit."""

import math
import shutil
from pathlib import Path

import pytest

from gsapp.dynamics.model import load_model, save_model
from gsapp.flight.catalog import Catalog
from gsapp.foundation import GroundStationError
from gsapp.identification.runs.request import RunRequest, describe_settings, setting_differences
from gsapp.identification.runs.run_comparison import SettingDifference, compare_runs, repeat_run
from gsapp.identification.runs.run_execution import RunOutcome, execute_run
from gsapp.identification.runs.run_store import load_run, save_run


@pytest.fixture
def campaign(tmp_path: Path, flight_files: tuple[Path, Path]) -> Path:
    folder = tmp_path / "campaign"
    folder.mkdir()
    path = Path(shutil.copy(flight_files[0], folder))
    with Catalog(folder / "c.sqlite") as catalog:
        request = RunRequest(flights=(path,), maneuver_windows=("0:6",), joint=True)
        save_run(catalog, execute_run(request))
    return folder


def test_a_repeat_is_the_same_to_the_last_bit_in_another_place_too(
    campaign: Path, tmp_path: Path
) -> None:
    with Catalog(campaign / "c.sqlite") as catalog:
        found = repeat_run(catalog, 1)
    assert (found.is_identical, found.differences) == (True, ())
    moved = campaign.rename(tmp_path / "elsewhere")
    with Catalog(moved / "c.sqlite") as catalog:
        found = repeat_run(catalog, 1)
    assert found.is_identical
    assert found.outcome.request.flights == (moved / "a.csv",)
    assert found.differences == ()


def test_one_bit_is_a_difference(campaign: Path) -> None:
    with Catalog(campaign / "c.sqlite") as catalog:
        (row,) = catalog.query("SELECT std FROM estimates WHERE run = 1 AND name = 'Cm_q'")
        with catalog.transaction() as connection:
            connection.execute(
                "UPDATE estimates SET std = ? WHERE run = 1 AND name = 'Cm_q'",
                (math.nextafter(row["std"], 1e9),),
            )
        found = repeat_run(catalog, 1)
    assert not found.is_identical
    assert len(found.differences) == 2
    assert "Cm_q" in found.differences[0]


def test_what_changed_since_is_named(campaign: Path) -> None:
    path = campaign / "a.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    column = lines[0].split(",").index("q [deg/s]")
    for place in range(100, 130):
        cells = lines[place].split(",")
        cells[column] = str(float(cells[column]) + 2.0)
        lines[place] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with Catalog(campaign / "c.sqlite") as catalog:
        with catalog.transaction() as connection:
            connection.execute(
                "UPDATE kept_runs SET versions = json_set(versions, '$.numpy', '1.0')"
            )
        found = repeat_run(catalog, 1)
    assert not found.is_identical
    assert found.differences[0] == f"{path} has changed"
    assert found.differences[1].startswith("numpy was 1.0")
    assert found.differences[2].startswith("maneuver 1: ")
    assert " more" in found.differences[2]
    path.unlink()
    gone = pytest.raises(GroundStationError, match=r"a\.csv")
    with Catalog(campaign / "c.sqlite") as catalog, gone:
        repeat_run(catalog, 1)


def test_marks_and_notes_change_no_run(campaign: Path) -> None:
    (campaign / "a.csv.events.jsonl").write_text('{"kind": "mark"}\n', encoding="utf-8")
    with Catalog(campaign / "c.sqlite") as catalog:
        assert repeat_run(catalog, 1).differences == ()


def test_a_model_that_is_gone_is_remembered(campaign: Path) -> None:
    file = save_model(load_model("b777").with_derivatives({"CN_q": 4.0}), campaign / "own.toml")
    asked = RunRequest(
        flights=(campaign / "a.csv",), maneuver_windows=("0:6",), model=str(file),
        free=("Cm_alpha", "Cm_q", "Cm_de", "Cm_0"),
    )  # fmt: skip
    with Catalog(campaign / "c.sqlite") as catalog:
        made = execute_run(asked)
        assert [one.role for one in made.inputs] == ["flight", "aircraft", "model"]
        number = save_run(catalog, made)
        file.unlink()
        found = repeat_run(catalog, number)
    assert (found.is_identical, found.differences) == (True, ())
    model = found.outcome.result.settings.known_model
    assert model is not None
    assert model.derivative("CN_q") == 4.0


def test_two_runs_beside_each_other(campaign: Path, outcome: RunOutcome) -> None:
    """Settings that differ in words, maneuvers of one only, values in joint bounds."""
    other = execute_run(outcome.request.with_changes(label="held", held={"CN_q": 5.0}))
    with Catalog(campaign / "c.sqlite") as catalog:
        one, two = (load_run(catalog, save_run(catalog, made)) for made in (outcome, other))
        found = compare_runs(one, two)
        assert (found.one, found.other) == ("both", "held")
        assert found.settings == (SettingDifference(name="held", one="none", other="CN_q 5"),)
        values = {row.name: row for row in found.values}
        assert values["CN_q"].other is None
        assert values["CN_q"].differs
        row = values["Cm_de"]
        assert row.difference == row.other.mean - row.one.mean
        joint = math.sqrt(row.one.std**2 + row.other.std**2)
        assert row.in_bounds == pytest.approx((row.other.mean - row.one.mean) / joint)
        assert compare_runs(one, one).settings == ()
        # Another part of the flight.
        settings = {row.name: row for row in compare_runs(load_run(catalog, 1), one).settings}
        assert settings["flights"].other == "a, b"
        assert settings["maneuver 1 of b.csv"].one == "not used"
        assert settings["all maneuvers jointly"].one == "yes"


def test_settings_that_look_alike_are_told_apart(outcome: RunOutcome) -> None:
    def asked(value: float) -> RunRequest:
        return outcome.request.with_changes(start={"Cm_q": value})

    one, other = asked(-20.0), asked(math.nextafter(-20.0, 0.0))
    assert describe_settings(one) == describe_settings(other)
    ((name, first, second),) = setting_differences(one, other)
    assert name == "start values"
    assert (first, second) == ("Cm_q -20", "Cm_q -19.999999999999996")
