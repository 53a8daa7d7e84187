"""``gsapp estimate --dataset``: a campaign that other programs read, partitioned by flight."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from gsapp.flight.flight_loader import load_flight
from gsapp.flight.writers import write_block
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.cli.command_kit import gsapp

pytest.importorskip("pyarrow", reason="pyarrow is not installed (extra parquet)")
pandas = pytest.importorskip("pandas", reason="pandas is not installed (extra notebook)")

NAMES = ("flight5", "day 2 ä=b")


@pytest.fixture(scope="module")
def flights(
    tmp_path_factory: pytest.TempPathFactory, flown_short: Callable[[int], VirtualFlight]
) -> list[Path]:
    folder = tmp_path_factory.mktemp("flights")
    paths = [folder / f"{name}.csv" for name in NAMES]
    for seed, path in zip((5, 6), paths, strict=True):
        write_block(path, flown_short(seed).measured, "csv", "base")
    return paths


@pytest.fixture(scope="module")
def dataset(flights: list[Path]) -> Path:
    folder = flights[0].parent / "campaign"
    done = gsapp(
        "estimate", *flights, "--aircraft", "b777", "--method", "ee",
        "--dataset", folder, "--json", folder.with_name("out.json"),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return folder


def test_pandas_reads_the_derivatives_of_the_json(dataset: Path) -> None:
    frame = pandas.read_parquet(dataset / "derivatives")
    assert set(frame["flight"].astype(str)) == set(NAMES)
    content = json.loads(dataset.with_name("out.json").read_text())
    own = frame[frame["method"] == "ee"].set_index(["maneuver", "derivative"])
    count = 0
    for maneuver in content["maneuvers"]:
        for name, one in maneuver["derivatives"].items():
            row = own.loc[maneuver["id"], name]
            assert str(row["flight"]) == maneuver["flight"]
            # What was not earned is missing here, too, and states why.
            assert (row["status"] == "estimated") == (one["value"] is not None)
            if one["value"] is not None:
                assert (row["value"], row["std"]) == (one["value"], one["std"])
            else:
                assert pandas.isna(row["value"])
            count += 1
    assert len(own) == count > 40
    assert set(frame["method"]) > {"ee"}
    assert own["mach"].between(0.05, 0.15).all()


def test_the_samples_are_those_of_the_flight(dataset: Path, flights: list[Path]) -> None:
    frame = pandas.read_parquet(
        dataset / "samples", filters=[("flight", "==", NAMES[1]), ("maneuver", "==", "2:1")]
    )
    content = json.loads(dataset.with_name("out.json").read_text())
    one = next(one for one in content["maneuvers"] if one["id"] == "2:1")
    block = load_flight(flights[1]).block.between(one["t_start"], one["t_end"] + 1e-6)
    assert frame["time"].tolist() == block.times.tolist()
    assert frame["p"].tolist() == pytest.approx(block["p"].tolist(), abs=1e-12)


def test_columns_state_their_units(dataset: Path) -> None:
    from pyarrow import parquet

    def units(name: str) -> dict[str, bytes]:
        (file, *_) = sorted((dataset / name).rglob("*.parquet"))
        schema = parquet.read_schema(file)
        return {
            one.name: one.metadata[b"unit"] for one in schema if b"unit" in (one.metadata or {})
        }

    assert units("samples")["alpha"] == b"rad"
    assert units("derivatives")["V"] == b"m/s"
    assert units("derivatives")["wing_loading"] == b"Pa"


def test_duckdb_selects_one_flight(dataset: Path) -> None:
    duckdb = pytest.importorskip("duckdb", reason="DuckDB is not installed")
    place = dataset / "derivatives" / "*" / "*.parquet"
    rows = duckdb.sql(
        f"""SELECT flight, derivative, avg(value), count(value) FROM
        read_parquet('{place}', hive_partitioning = true)
        WHERE method = 'ee' AND derivative = 'Cm_alpha' AND status = 'estimated'
        GROUP BY ALL ORDER BY flight"""  # noqa: S608 - a path of the test
    ).fetchall()
    assert [row[0] for row in rows] == sorted(NAMES)
    frame = pandas.read_parquet(dataset / "derivatives")
    chosen = frame[(frame["method"] == "ee") & (frame["derivative"] == "Cm_alpha")]
    means = chosen.groupby(chosen["flight"].astype(str))["value"].mean()
    assert {row[0]: row[2] for row in rows} == pytest.approx(means.to_dict())


def test_a_folder_with_content_is_left_alone(dataset: Path, flights: list[Path]) -> None:
    before = sorted(dataset.rglob("*"))
    done = gsapp("estimate", *flights, "--dataset", dataset)
    assert done.returncode == 1
    assert "not empty" in done.stderr
    assert sorted(dataset.rglob("*")) == before
