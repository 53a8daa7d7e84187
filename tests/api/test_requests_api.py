"""Requests in a notebook give the numbers of the commands, to the last bit."""

import json
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

import gsapp
from gsapp.flight.writers import write_flight_csv
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.foundation.settings import SettingError
from tests.cli.command_kit import gsapp as command

WINDOWS = ("30:38", "40:45", "50:58", "63.5:68.5", "70:76")
"""Stretches of the flight, two of them doublets."""
POINTS = """angle [deg],volts [V],direction
-20,1.51,up
-10,2.02,up
0,2.49,up
10,3.01,up
20,3.52,up
10,2.99,down
0,2.51,down
-10,1.98,down
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory, flown_short):
    """Return a flight in the units of another program: inches of water, ft/s^2, rad/s."""
    block = flown_short(5).measured
    path = tmp_path_factory.mktemp("flights") / "day.csv"
    write_flight_csv(path, block, "us")
    head, *rows = path.read_text().splitlines()
    names = head.split(",")
    factors = {
        "dynamic_pressure [lbf/ft^2]": ("dynamic_pressure [inH2O]", 47.880258980 / 249.08891),
        "ay [g]": ("ay [ft/s^2]", 9.80665 / 0.3048),
        "q [deg/s]": ("q [rad/s]", np.pi / 180.0),
    }
    for old, (new, factor) in factors.items():
        place = names.index(old)
        names[place] = new
        for index, row in enumerate(rows):
            cells = row.split(",")
            cells[place] = cells[place] and repr(float(cells[place]) * factor)
            rows[index] = ",".join(cells)
    path.write_text("\n".join([",".join(names), *rows]) + "\n")
    return path


@pytest.fixture(scope="module")
def flight(path):
    return gsapp.open(path)


@pytest.fixture(scope="module")
def estimates(flight):
    return gsapp.estimate([flight], aircraft="b777", method="ee", joint=True)


def printed(tmp_path, *arguments):
    done = command(*arguments, "--json", tmp_path / "out.json")
    assert done.returncode == 0, done.stderr
    return json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))


def test_estimates_are_those_of_the_command(path, estimates, tmp_path):
    options = ("--aircraft", "b777", "--method", "ee", "--joint")
    content = printed(tmp_path, "estimate", path, *options)
    assert estimates.to_dict() == content
    assert len(content["maneuvers"]) == 2


def test_maneuvers_are_those_of_the_command(path, flight, tmp_path):
    found = gsapp.maneuvers(flight, aircraft="b777")
    assert found.to_dict() == printed(tmp_path, "maneuvers", path, "--aircraft", "b777")
    table = found.tables["maneuvers"]
    assert table.columns["id"] == [one.id for one in found.outcome.maneuvers]
    assert table.units["V"] == "ft/s"
    speeds = [one.V / 0.3048 for one in found.outcome.maneuvers]
    np.testing.assert_allclose(table.columns["V"], speeds)


def test_compatibility_is_that_of_the_command(path, flight, tmp_path):
    found = gsapp.compatibility(flight, error=["q.scale"], units="si", aircraft="b777")
    content = printed(tmp_path, "compatibility", path, "--error", "q.scale", "--aircraft", "b777")
    assert found.to_dict() == content
    rows = dict(
        zip(*(found.tables["errors"].columns[name] for name in ("error", "value")), strict=True)
    )
    assert rows["alpha.bias"] == pytest.approx(
        np.degrees(content["parameters"]["alpha.bias"]["value"])
    )
    assert rows["q.scale"] == content["parameters"]["q.scale"]["value"]


SEARCH = {"aircraft": "b777", "model": "b777", "maneuver_windows": WINDOWS}


def test_the_search_is_that_of_the_command(path, flight, tmp_path):
    found = gsapp.discrepancy([flight], **SEARCH)
    windows = [word for one in WINDOWS for word in ("--maneuver", one)]
    content = printed(
        tmp_path, "discrepancy", path, "--out", tmp_path / "command", "--aircraft", "b777",
        "--model", "b777", *windows,
    )  # fmt: skip
    assert found.to_dict() == {**content, "model": None}
    assert set(found.tables["gap"].columns["channel"]) == set(content["gap"]["channels"])
    assert len(found.figures) >= 3


@pytest.mark.long
def test_the_search_leaves_the_folder_of_the_command(flight, tmp_path):
    out = tmp_path / "missing"
    found = gsapp.discrepancy(flight, out, check_instruments=False, **SEARCH)
    assert {one.name for one in out.iterdir()} >= {"model.toml", "report.html", "discrepancy.json"}
    assert json.loads((out / "discrepancy.json").read_text()) == found.to_dict()


def test_a_certificate_is_that_of_the_command(tmp_path):
    points = tmp_path / "points.csv"
    points.write_text(POINTS)
    out = tmp_path / "rudder.toml"
    found = gsapp.calibrate(points, "rudder", out, excitation=5.0, travel=(-25.0, 25.0))
    content = printed(
        tmp_path, "calibrate", points, "--channel", "rudder", "--out", out, "--excitation", "5",
        "--travel=-25:25",
    )  # fmt: skip
    assert found.to_dict() == content
    assert found.tables["points"].columns["value"] == [-20, -10, 0, 10, 20, 10, 0, -10]
    assert found.figures["rudder"]._repr_png_()[:4] == b"\x89PNG"


@pytest.mark.long
def test_a_report_of_estimates_is_that_of_the_command(path, estimates, tmp_path):
    (made,) = gsapp.report(estimates, tmp_path / "made.html", dated=False)
    content = printed(
        tmp_path, "report", path, "--aircraft", "b777", "--method", "ee", "--joint", "--no-date",
        "--out", tmp_path / "printed.html",
    )  # fmt: skip
    assert made.read_bytes() == Path(content["written"][0]).read_bytes()
    with pytest.raises(TypeError, match="method"):
        gsapp.report(estimates, tmp_path / "other.html", method="ml")


def test_each_derivative_has_both_bounds_and_each_maneuver_a_figure(flight, tmp_path):
    found = gsapp.estimate(flight, aircraft="b777", single_method=True, axis="lon", units="si")
    table = found.tables["derivatives"]
    rows = dict(
        zip(table.columns["derivative"], zip(*table.columns.values(), strict=True), strict=True)
    )
    own = dict(zip(table.columns, rows["Cm_alpha"], strict=True))
    (one,) = found.to_dict()["maneuvers"]
    assert own["value"] == one["derivatives"]["Cm_alpha"]["value"]
    assert own["std"] == one["derivatives"]["Cm_alpha"]["std"]
    assert own["cramer_rao"] == one["cramer_rao"]["Cm_alpha"]
    assert own["std"] != own["cramer_rao"]
    assert (own["flight"], own["maneuver"], own["status"]) == ("day", one["id"], "estimated")
    figure = found.figures[one["id"]].to_figure()
    own_maneuver = found.outcome.result.results[0].maneuver
    assert len(figure.axes) == len(own_maneuver.inputs) + len(one["fit"])
    html = found._repr_html_()
    assert "<caption>means" in html
    assert all(f"<td>{name}</td>" in html for name in ("Cm_alpha", "CN_de"))
    assert "derivatives (" in repr(found)


def test_a_table_becomes_a_data_frame(estimates):
    pytest.importorskip("pandas")
    frame = estimates.to_dataframe()
    assert list(frame.columns) == list(estimates.tables["derivatives"].columns)
    assert "joint lon" in set(frame["maneuver"])
    means = estimates.to_dataframe("means").set_index("derivative")
    summary = estimates.outcome.summary.derivatives["Cm_alpha"].value
    assert means.loc["Cm_alpha", "mean"] == summary.mean
    with pytest.raises(UnknownNameError, match="derivatives"):
        estimates.to_dataframe("derivative")


def test_a_request_uses_what_the_flight_was_opened_with(path, tmp_path):
    head, rows = path.read_text().split("\n", 1)
    table = tmp_path / "log.csv"
    table.write_text(head.replace("q [rad/s]", "PitchRate") + "\n" + rows)
    entries = [("q", "PitchRate", "rad/s")]
    for title in head.split(",")[1:]:
        name, unit = title.rstrip("]").split(" [")
        if name != "q" and not name.endswith("_volts"):
            entries.append((name, title, unit))
    channel_map = tmp_path / "map.toml"
    channel_map.write_text(
        'name = "other"\nformat = "table"\n'
        + "".join(
            f'[[channels]]\nid = "{one}"\nsource = "{title}"\nunit = "{unit}"\n'
            for one, title, unit in entries
        )
    )
    opened = gsapp.open(table, channel_map=channel_map)
    np.testing.assert_allclose(opened.to_numpy(["q"])[:9], gsapp.open(path).to_numpy(["q"])[:9])
    found = gsapp.compatibility(opened, aircraft="b777", maneuver_windows=["30:45"])
    assert "q.bias" in found.tables["errors"].columns["error"]
    with pytest.raises(FlightError, match="channel_map"):
        gsapp.compatibility([opened, gsapp.open(path)], aircraft="b777")


@pytest.mark.parametrize(
    ("settings", "error"),
    [
        ({"methd": "ml"}, SettingError),
        ({"held": {"Cm_alfa": -0.3}}, UnknownNameError),
        ({"units": "metric"}, UnknownNameError),
    ],
)
def test_a_wrong_request_is_named_before_any_work(tmp_path, settings, error):
    with pytest.raises(error, match=r"methd|Cm_alpha|us, si"):
        gsapp.estimate(tmp_path / "absent", **settings)


@pytest.mark.long
def test_a_virtual_flight_opens_as_recorded(tmp_path):
    flight = gsapp.fly(tmp_path / "virtual", truth=tmp_path / "truth.csv", plan="short", seed=3)
    assert (flight.name, flight.info.source) == ("virtual", "virtual")
    truth = gsapp.open(tmp_path / "truth.csv")
    assert truth.duration == pytest.approx(flight.duration, abs=5.0)
    with pytest.raises(FlightError, match="exists"):
        gsapp.fly(tmp_path / "virtual", plan="short")


def test_packages_of_the_program_are_also_functions():
    program = (
        "import gsapp, gsapp.report.document, gsapp.discrepancy.results\n"
        "import gsapp.report.palette as palette\n"
        "assert gsapp.report.document.Document and palette.PRINT_PALETTE\n"
        "for call in (gsapp.report, gsapp.discrepancy):\n"
        "    try: call('/absent/flight.csv', '/tmp/out.html' if call is gsapp.report else '')\n"
        "    except gsapp.foundation.FlightError as error: print('no flight' in str(error))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.split() == ["True", "True"], done.stderr
    assert gsapp.__version__ == version("gsapp-ground-station")
