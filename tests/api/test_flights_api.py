"""Flights in a notebook: samples as arrays, data frames and data sets, in the units chosen."""

import importlib
import inspect
import re
import subprocess
import sys

import numpy as np
import pytest

import gsapp
from gsapp.flight.writers import write_flight_csv
from gsapp.foundation import UnknownNameError
from gsapp.foundation.data_table import MissingPackageError
from tests.docs.reference import FOLDER, public_functions

CSV = """time [s],alpha [deg],V [kt],an [ft/s^2],static_pressure [inHg],throttle [%]
0.00,2.0,50,32.174,29.0,40
0.02,2.5,51,,29.1,41
0.04,3.0,52,30.000,29.2,42
0.06,3.5,53,31.000,29.3,43
"""
"""As another program wrote it: knots, inches of mercury, a missing sample."""


@pytest.fixture
def flight(tmp_path):
    path = tmp_path / "tuesday.csv"
    path.write_text(CSV)
    return gsapp.open(path)


def test_units_of_another_program_become_those_asked_for(flight):
    us = flight.to_numpy(["alpha", "V", "an"], units="US")
    assert us.shape == (4, 3)
    np.testing.assert_allclose(us[:, 0], [2.0, 2.5, 3.0, 3.5])
    np.testing.assert_allclose(us[0, 1], 50 * 1852 / 3600 / 0.3048)
    np.testing.assert_allclose(us[0, 2], 32.174 * 0.3048 / 9.80665)
    assert np.isnan(us[1, 2])
    si = flight.to_numpy(["V", "static_pressure"], units="si")
    np.testing.assert_allclose(si[0], [50 * 1852 / 3600, 29.0 * 3.386388], rtol=1e-5)
    base = flight.to_numpy(["alpha", "an", "throttle"], units="base")
    np.testing.assert_array_equal(base, flight.block.select(["alpha", "an", "throttle"]).values)
    np.testing.assert_allclose(base[:, 2], [0.40, 0.41, 0.42, 0.43])
    assert flight.to_numpy([]).shape == (4, 0)


def test_all_channels_come_in_the_order_of_the_flight(flight):
    assert flight.to_numpy(units="base").tobytes() == flight.block.values.tobytes()


@pytest.mark.parametrize(("channels", "units"), [(["alfa"], "us"), (["alpha"], "metric")])
def test_a_name_that_does_not_exist_is_named(flight, channels, units):
    with pytest.raises(UnknownNameError, match=r"alpha|us, si, base"):
        flight.to_numpy(channels, units)


def test_a_data_frame_has_time_as_index_and_knows_its_units(flight):
    pytest.importorskip("pandas")
    frame = flight.to_dataframe(["alpha", "an"], units="US")
    assert (frame.index.name, list(frame.columns)) == ("time", ["alpha", "an"])
    np.testing.assert_array_equal(frame.index, flight.block.times)
    np.testing.assert_array_equal(frame, flight.to_numpy(["alpha", "an"], "us"))
    assert frame.attrs["units"] == {"time": "s", "alpha": "deg", "an": "g"}
    assert frame["an"].isna().sum() == 1


def test_a_data_set_has_units_and_titles(flight):
    pytest.importorskip("xarray")
    data = flight.to_xarray(["V"], units="si")
    assert data["V"].attrs == {"units": "m/s", "long_name": "True airspeed"}
    assert data["V"].dims == ("time",)
    assert data.attrs["flight"] == "tuesday"
    np.testing.assert_array_equal(data["time"], flight.block.times)


@pytest.mark.parametrize(
    ("package", "method"), [("pandas", "to_dataframe"), ("xarray", "to_xarray")]
)
def test_a_missing_package_is_named_with_its_extra(flight, monkeypatch, package, method):
    monkeypatch.setitem(sys.modules, package, None)  # as if it were not installed
    assert flight.to_numpy(["alpha"]).shape == (4, 1)
    with pytest.raises(MissingPackageError, match=rf"{package} .*\[notebook\]") as caught:
        getattr(flight, method)(["alpha"])
    assert isinstance(caught.value, ImportError)


def test_a_flight_shows_itself_in_one_line_and_as_a_table(flight, tmp_path):
    assert len(repr(flight)) < 80
    assert "tuesday" in repr(flight)
    html = flight._repr_html_()
    assert re.findall(r"<tr><td>(\w+)</td>", html) == list(flight.block.channels)
    assert "<td>ft/s</td><td>4</td><td>84.39</td>" in html
    write_flight_csv(tmp_path / "a<b>.csv", flight.block)
    assert "<b>" not in gsapp.open(tmp_path / "a<b>.csv")._repr_html_()


def test_each_sample_at_its_own_time(tmp_path):
    path = tmp_path / "sparse.csv"
    path.write_text("time [s],alpha [deg]\n0.0,1\n0.1,2\n0.25,3\n0.4,4\n")
    flight = gsapp.open(path, native=True)
    np.testing.assert_allclose(flight.to_numpy(["alpha"])[:, 0], [1, 2, 3, 4])
    assert repr(flight).startswith("<Flight sparse")


PARAMETERS = {
    "gsapp.calibrate": "points channel out degree excitation travel who temperature former",
    "gsapp.changes": "catalog names by against method units wanted",
    "gsapp.compatibility": "flights error units settings",
    "gsapp.discrepancy": "flights out units settings",
    "gsapp.estimate": "flights units settings",
    "gsapp.export": "flight out to units aircraft",
    "gsapp.fly": "out truth settings",
    "gsapp.maneuvers": "flight units settings",
    "gsapp.open": "path aircraft channel_map calibration native raw",
    "gsapp.report": "flights out validate units dated settings",
    "gsapp.trend": "catalog name against by method units wanted",
    "Flight.to_dataframe": "self channels units",
    "Flight.to_numpy": "self channels units",
    "Flight.to_xarray": "self channels units",
    "Result.to_dataframe": "self table",
    "Result.to_dict": "self",
}
"""Scripts of users call these: a name or parameter stays."""


def test_names_and_parameters_of_the_interface_stay():
    found = {
        name: " ".join(inspect.signature(function).parameters)
        for name, function in public_functions().items()
    }
    assert found == PARAMETERS
    assert {f"gsapp.{name}" for name in gsapp.__all__} - {"gsapp.__version__"} <= set(found)
    page = (FOLDER / "api.md").read_text(encoding="utf-8")
    assert [name for name in PARAMETERS if f"## {name}\n" not in page] == []


def test_each_name_is_the_function_of_its_module():
    for name in set(gsapp.__all__) - {"__version__"}:
        assert name in dir(gsapp)
        assert getattr(importlib.import_module(gsapp._MODULES[name]), name).__doc__
    with pytest.raises(AttributeError, match="opne"):
        _ = gsapp.opne


def test_the_package_imports_nothing_before_it_is_used():
    program = (
        "import sys; before = set(sys.modules); import gsapp; "
        "print(*{one.partition('.')[0] for one in set(sys.modules) - before}); "
        "import os; print(os.environ['OPENBLAS_NUM_THREADS'], gsapp.__version__)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    modules, threads = done.stdout.splitlines()
    assert set(modules.split()) - {"gsapp"} <= set(sys.stdlib_module_names)
    assert re.fullmatch(r"1 \d+\.\d+\.\d+", threads)
