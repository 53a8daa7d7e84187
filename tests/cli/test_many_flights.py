"""Commands over several flights on several processes: the same JSON, whatever happens to them."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gsapp.flight.catalog import Catalog, ManeuverFilter
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.writers import write_block
from gsapp.identification.fleet.fleet_values import select_fleet_values
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.cli.command_kit import busy_worker, gsapp


@pytest.fixture(scope="module")
def flights(
    tmp_path_factory: pytest.TempPathFactory, flown_short: Callable[[int], VirtualFlight]
) -> list[Path]:
    folder = tmp_path_factory.mktemp("flights")
    paths = [folder / f"flight{seed}.csv" for seed in (5, 6)]
    for seed, path in zip((5, 6), paths, strict=True):
        write_block(path, flown_short(seed).measured, "csv")
    return paths


def result_of(command: str, flights: list[Path], out: Path, *options: str) -> bytes:
    done = gsapp(command, *flights, "--json", out, *options)
    assert done.returncode == 0, done.stderr
    return out.read_bytes()


@pytest.mark.parametrize("address", ["local:2", "dask://local:2"])
@pytest.mark.parametrize("command", ["estimate", "maneuvers", "compatibility"])
def test_the_json_is_the_same_to_the_last_bit(
    command: str, address: str, flights: list[Path], tmp_path: Path
) -> None:
    if address.startswith("dask"):
        pytest.importorskip("distributed", reason="Dask is not installed (extra dask)")
    here = result_of(command, flights, tmp_path / "here.json")
    assert result_of(command, flights, tmp_path / "there.json", "--on", address) == here


def test_several_logs_become_flight_folders(flights: list[Path], tmp_path: Path) -> None:
    """Each under its name, or named as failed; the same on workers as here."""
    broken = tmp_path / "broken.csv"
    broken.write_text("nothing\n")
    found = {}
    for name, options in (("here", ()), ("there", ("--on", "local:2"))):
        out = tmp_path / name
        result = tmp_path / f"{name}.json"
        done = gsapp("import", *flights, broken, "--out", out, "--json", result, *options)
        assert done.returncode == 1
        assert sorted(one.name for one in out.iterdir()) == ["flight5", "flight6"]
        assert load_flight(out / "flight6").duration == load_flight(flights[1]).duration
        found[name] = json.loads(result.read_text())["flights"]
        assert [one.pop("flight", None) for one in found[name]] == [
            str(out / "flight5"), str(out / "flight6"), None,
        ]  # fmt: skip
    assert found["here"] == found["there"]
    assert "failure" in found["here"][2]
    again = gsapp("import", *flights, "--out", tmp_path / "here")
    assert again.returncode == 1  # they are taken
    alike = tmp_path / "other" / flights[0].name
    alike.parent.mkdir()
    alike.write_bytes(flights[0].read_bytes())
    assert gsapp("import", flights[0], alike, "--out", tmp_path / "x").returncode == 2
    assert not (tmp_path / "x").exists()


def test_a_report_is_the_same_to_the_last_byte(flights: list[Path], tmp_path: Path) -> None:
    written = []
    for name, options in (("here", ()), ("there", ("--on", "local:2"))):
        out = tmp_path / f"{name}.html"
        words = (*flights, "--axis", "lon", "--no-date", "--out", out)
        assert gsapp("report", *words, *options).returncode == 0
        written.append(out.read_bytes())
    assert written[0] == written[1]


def test_the_instruments_of_each_flight_are_stored(flights: list[Path], tmp_path: Path) -> None:
    """Alone, each has the errors of a check of that flight; a flight that fails is named."""
    broken = tmp_path / "broken.csv"
    broken.write_text("nothing\n")
    catalog, out = tmp_path / "c.sqlite", tmp_path / "each.json"
    words = (flights[0], broken, flights[1], "--catalog", catalog, "--json", out)
    done = gsapp("compatibility", *words, "--on", "local:2")
    assert done.returncode == 1
    first, failed, second = json.loads(out.read_text())
    assert (first["flight"], second["flight"]) == ("flight5", "flight6")
    assert "failure" in failed
    alone = json.loads(result_of("compatibility", flights[:1], tmp_path / "alone.json"))
    assert first["parameters"] == alone["parameters"]
    with Catalog(catalog) as store:
        found = select_fleet_values(store, "alpha.bias", ManeuverFilter())
        assert [one.flight for one in found.values] == ["flight5", "flight6"]
        bias = second["parameters"]["alpha.bias"]
        assert (found.values[1].value, found.values[1].std) == (bias["value"], bias["std"])
        # The flights have their maneuvers, so that conditions select them.
        fast = ManeuverFilter(conditions={"V": (500.0, None)})
        assert select_fleet_values(store, "alpha.bias", fast).values == ()
    assert gsapp("compatibility", *words).returncode == 1
    assert json.loads(out.read_text())[0] == first


def test_maneuvers_of_several_flights_name_each_and_the_one_that_fails(
    flights: list[Path], tmp_path: Path
) -> None:
    broken = tmp_path / "broken.csv"
    broken.write_text("nothing\n")
    out = tmp_path / "m.json"
    done = gsapp("maneuvers", flights[0], broken, flights[1], "--json", out)
    assert done.returncode == 1
    first, second, third = json.loads(out.read_text())
    assert [first["flight"], second["flight"], third["flight"]] == [
        "flight5",
        "broken.csv",
        "flight6",
    ]
    assert second["failure"]
    assert second["maneuvers"] == []
    for path, one in ((flights[0], first), (flights[1], third)):
        assert gsapp("maneuvers", path, "--json", out).returncode == 0
        assert json.loads(out.read_text()) == one["maneuvers"] != []


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="child processes are found in /proc")
def test_a_worker_killed_in_the_middle_costs_no_number(flights: list[Path], tmp_path: Path) -> None:
    here = result_of("estimate", flights, tmp_path / "here.json")
    out = tmp_path / "there.json"
    command = [sys.executable, "-m", "gsapp.cli", "estimate", *map(str, flights)]
    child = subprocess.Popen(
        [*command, "--json", str(out), "--on", "local:2"],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip
    killed = None
    while child.poll() is None:
        if killed is None and (killed := busy_worker(child.pid)) is not None:
            os.kill(killed, signal.SIGKILL)
        time.sleep(0.01)
    assert child.returncode == 0, child.stderr.read()
    assert killed is not None
    assert out.read_bytes() == here


@pytest.fixture
def scheduler() -> Iterator[str]:
    """Return the address of a scheduler with two workers, each a process as on a cluster."""
    pytest.importorskip("distributed", reason="Dask is not installed (extra dask)")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    dask = [sys.executable, "-m", "dask"]
    place = f"127.0.0.1:{port}"
    calls = [
        [*dask, "scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"],
        *[[*dask, "worker", f"tcp://{place}", "--nthreads", "1", "--no-dashboard"]] * 2,
    ]
    running = [subprocess.Popen(call, stderr=subprocess.DEVNULL) for call in calls]
    try:
        yield f"dask://{place}"
    finally:
        for one in reversed(running):
            one.terminate()
            one.wait(60.0)


def test_workers_of_a_cluster_give_the_same_json(
    scheduler: str, flights: list[Path], tmp_path: Path
) -> None:
    here = result_of("estimate", flights, tmp_path / "here.json")
    assert result_of("estimate", flights, tmp_path / "there.json", "--on", scheduler) == here
