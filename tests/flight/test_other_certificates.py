"""An old flight read with other certificates, and channels that have none: said everywhere."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from calibration import certificate_paths, load_certificates, write_certificate
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.cli._usage_errors import CommandUsageError
from gsapp.cli.compatibility import compatibility
from gsapp.cli.discrepancy import discrepancy
from gsapp.cli.estimate import estimate
from gsapp.cli.flight_files import export
from gsapp.cli.linear_models import linear_models
from gsapp.cli.maneuvers import maneuvers
from gsapp.cli.replay import replay as replay_command
from gsapp.cli.table_commands import cut
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.flight import load_flight
from gsapp.flight.certificates import calibrated_ranges
from gsapp.flight.folder import FlightFolder
from gsapp.flight.maneuvers import uncalibrated_text
from gsapp.flight.summary import summarize_flight
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError
from gsapp.session import Session
from gsapp.session.replay_runner import run_replay
from tests.flight.box_kit import box_tlog


@pytest.fixture
def flight(tmp_path: Path) -> FlightFolder:
    folder = FlightFolder.create(tmp_path / "flight")
    folder.tlog_file.write_bytes(box_tlog())
    folder.store_channel_map(MAPS.find("b777"))
    folder.store_aircraft(SHIPPED_AIRCRAFT.find("b777"))
    folder.store_certificates(certificate_paths("b777"))
    return folder


@pytest.fixture
def other(tmp_path: Path) -> Path:
    folder = tmp_path / "spring"
    folder.mkdir()
    for path in certificate_paths("b777"):
        if path.stem != "flap":
            shutil.copy(path, folder)
    alpha = load_certificates("b777")["alpha"]
    first, *rest = alpha.coefficients
    write_certificate(replace(alpha, coefficients=(first + 1.0, *rest)), folder / "alpha.toml")
    return folder


def test_other_certificates_change_the_numbers_and_are_said(
    flight: FlightFolder, other: Path
) -> None:
    own, read = load_flight(flight.path), load_flight(flight.path, certificates=other)
    np.testing.assert_allclose(read.block["alpha"] - own.block["alpha"], np.deg2rad(1.0))
    assert np.array_equal(read.block["q"], own.block["q"], equal_nan=True)
    assert "flap" in own.block.channels
    assert "flap" not in read.block.channels
    assert not [text for text in own.remarks if "certificate" in text]
    assert f"'{other}'" in read.remarks[0]
    assert read.remarks[1].endswith("volts only: flap")
    said = summarize_flight(read)["calibration"]
    assert (said["given"], said["instead_of_own"]) == (str(other), ["alpha", "flap"])
    assert said["uncalibrated"] == ["flap"]
    assert said["certificates"]["alpha"]["who"] == "shipped example"
    assert summarize_flight(own)["calibration"]["given"] is None


def test_what_lies_beyond_the_calibrated_range_is_said(flight: FlightFolder, other: Path) -> None:
    """A vane calibrated from -1 to 1 deg, and one that covered all that it showed."""
    own = load_flight(flight.path)
    assert not [text for text in own.remarks if "outside the calibrated range" in text]
    alpha = load_certificates("b777")["alpha"]
    ends = alpha.volts(np.deg2rad([-1.0, 1.0]))
    narrow = replace(alpha, range=(float(ends.min()), float(ends.max())), points=())
    write_certificate(narrow, other / "alpha.toml")
    read = load_flight(flight.path, certificates=other)
    (said,) = [text for text in read.remarks if "outside the calibrated range" in text]
    shown = own.block["alpha"][np.isfinite(own.block["alpha"])]
    share = float(np.mean(np.abs(np.rad2deg(shown)) > 1.0))
    assert share > 0.0
    assert said.endswith(f": alpha {100.0 * share:.1f} %")
    assert said in read.calibration_remarks
    assert summarize_flight(own)["calibration"]["beyond"] == {}
    count = int(np.sum(np.abs(np.rad2deg(shown)) > 1.0))
    assert summarize_flight(read)["calibration"]["beyond"] == {"alpha": count}


def test_what_is_derived_from_values_beyond_the_range_is_counted_too(
    flight: FlightFolder, other: Path
) -> None:
    shipped = load_certificates("b777")
    left = shipped["elevator_left"]
    read = load_flight(flight.path)
    shown = np.rad2deg(read.block["elevator_left"])
    ends = left.volts(np.deg2rad([np.nanmax(shown) + 0.5, np.nanmax(shown) + 1.0]))
    narrow = replace(left, range=(float(ends.min()), float(ends.max())), points=())
    write_certificate(narrow, other / "elevator_left.toml")
    again = load_flight(flight.path, certificates=other)
    beyond = again.calibration_json()["beyond"]
    assert beyond["elevator_left"] == np.count_nonzero(np.isfinite(shown))
    assert beyond["de"] == np.count_nonzero(np.isfinite(again.block["de"]))
    assert set(beyond) == {"elevator_left", "de"}
    assert "de " in again.calibration_remarks[-1]
    covered = calibrated_ranges(again.certificates, again.sources)
    assert set(covered["V"]) == {"dynamic_pressure", "static_pressure", "temperature"}
    assert set(covered["elevator_right"]) == {"elevator_right"}


def test_the_cache_of_a_flight_is_that_of_its_own_certificates(
    flight: FlightFolder, other: Path
) -> None:
    own = load_flight(flight.path)
    cached = next(flight.cache_folder.glob("*.npz"))
    before = cached.read_bytes()
    read = load_flight(flight.path, certificates=other)
    assert not np.array_equal(read.block["alpha"], own.block["alpha"], equal_nan=True)
    assert cached.read_bytes() == before
    again = load_flight(flight.path)
    assert np.array_equal(again.block["alpha"], own.block["alpha"], equal_nan=True)
    assert again.remarks == own.remarks


def test_a_replay_on_the_road_of_a_live_flight_says_and_does_the_same(
    flight: FlightFolder, other: Path
) -> None:
    session = Session.replay(flight.path, certificates=other, speed=np.inf)
    run_replay(session)
    streamed, read = session.flight(), load_flight(flight.path, certificates=other)
    assert streamed.calibration_json() == read.calibration_json()
    assert streamed.calibration_remarks == read.calibration_remarks
    assert np.array_equal(streamed.block["alpha"], read.block["alpha"], equal_nan=True)
    assert session.snapshot().uncalibrated == ("flap",)
    session.close()


def test_the_rudder_alone_is_calibrated(flight: FlightFolder, tmp_path: Path) -> None:
    certificates = tmp_path / "rudder"
    certificates.mkdir()
    shutil.copy(
        next(path for path in certificate_paths("b777") if path.stem == "rudder"), certificates
    )
    session = Session.replay(flight.path, certificates=certificates, speed=np.inf)
    run_replay(session)
    streamed, read = session.flight(), load_flight(flight.path, certificates=certificates)
    session.close()
    for name in ("dr", "rudder"):
        assert np.array_equal(streamed.block[name], read.block[name], equal_nan=True)
        assert np.isfinite(read.block[name]).all()
    assert "q" not in read.block.channels
    assert "q_volts" in read.block.channels


@pytest.mark.parametrize(
    ("kept", "bare"), [("rudder", "elevator_left"), ("q", "rudder"), ("alpha", "aileron_right")]
)
def test_inputs_that_are_volts_only_are_named_as_the_cause(
    flight: FlightFolder, tmp_path: Path, kept: str, bare: str
) -> None:
    certificates = tmp_path / "one"
    certificates.mkdir()
    (own,) = (path for path in certificate_paths("b777") if path.stem == kept)
    shutil.copy(own, certificates)
    read = load_flight(flight.path, certificates=certificates)
    (text,) = uncalibrated_text(read)
    inputs, _, answers = text.partition("; answers ")
    assert bare in inputs
    assert kept not in re.findall(r"\w+", text)
    assert ("alpha" in answers) == (kept != "alpha")
    given = {"flights": [flight.path], "calibration": str(certificates)}
    for run in (
        lambda: estimate(**given),
        lambda: discrepancy(**given, out=tmp_path / "out"),
    ):
        with pytest.raises(FlightError, match=f"uncalibrated.*{bare}"):
            run()
    assert uncalibrated_text(load_flight(flight.path)) == ()


def test_columns_that_were_calibrated_before_take_no_other_certificates(
    flight: FlightFolder, other: Path, tmp_path: Path
) -> None:
    export(flight=flight.path, to="csv", out=tmp_path / "flight.csv")
    with pytest.raises(FlightError, match="were calibrated"):
        load_flight(tmp_path / "flight.csv", certificates=other)


def test_a_map_without_volts_takes_no_certificates(tmp_path: Path, other: Path) -> None:
    folder = FlightFolder.create(tmp_path / "autopilot")
    folder.tlog_file.write_bytes(box_tlog())
    folder.store_channel_map(MAPS.find("px4"))
    with pytest.raises(FlightError, match="calibrates no channel"):
        load_flight(folder.path, certificates=other)


def test_uncalibrated_is_told_by_replay_export_and_cut_and_survives_a_table(
    flight: FlightFolder,
    other: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In the text, in the JSON, beside the channel; a table of volts is known for what it is."""
    monkeypatch.setenv("COLUMNS", "79")  # of which rich thinks where Windows writes to a pipe
    summary, table = tmp_path / "summary.json", tmp_path / "out.csv"
    replay_command(headless=True, flight=flight.path, json=summary, calibration=str(other))
    screen = capsys.readouterr().out
    assert "volts only: flap" in screen
    assert any("flap_volts" in line and "uncal" in line for line in screen.splitlines())
    told = json.loads(summary.read_text())
    assert told["calibration"]["uncalibrated"] == ["flap"]
    beside = {name: each["calibrated"] for name, each in told["channels"].items()}
    assert (beside["flap_volts"], beside["alpha"], beside["alpha_volts"]) == (False, True, None)

    export(flight=flight.path, to="csv", out=table, calibration=str(other), json=summary)
    assert "volts only: flap" in capsys.readouterr().out
    assert json.loads(summary.read_text())["calibration"]["uncalibrated"] == ["flap"]
    assert load_flight(table).uncalibrated_channels == ("flap",)

    cut(flight=flight.path, window=["10:11"], out=table, calibration=str(other), json=summary)
    assert "volts only: flap" in capsys.readouterr().err
    (cut_from,) = json.loads(summary.read_text())["calibration"]
    assert cut_from["given"] == str(other)


def test_tables_for_other_programs_name_what_is_uncalibrated(
    flight: FlightFolder, other: Path, tmp_path: Path
) -> None:
    pyarrow = pytest.importorskip("pyarrow.parquet")
    read = load_flight(flight.path, certificates=other)
    mat, parquet = tmp_path / "out.mat", tmp_path / "out.parquet"
    write_block(mat, read.block, "mat")
    write_block(parquet, read.block, "parquet")
    assert loadmat(mat)["uncalibrated"][0] == "flap"
    columns = pyarrow.read_schema(parquet)
    assert columns.field("flap_volts").metadata[b"uncalibrated"] == b"flap"
    assert b"uncalibrated" not in columns.field("alpha_volts").metadata
    for path in (mat, parquet):
        assert load_flight(path).uncalibrated_channels == ("flap",)


def test_results_with_other_certificates_stay_out_of_the_catalog(
    flight: FlightFolder, other: Path, tmp_path: Path
) -> None:
    for call in (
        lambda: maneuvers(
            flights=[flight.path], calibration=str(other), catalog=tmp_path / "c.sqlite"
        ),
        lambda: estimate(
            flights=[flight.path], calibration=str(other), catalog=tmp_path / "c.sqlite"
        ),
    ):
        with pytest.raises(CommandUsageError, match="--catalog"):
            call()
    assert not (tmp_path / "c.sqlite").exists()


@pytest.mark.parametrize(
    "command", ["estimate", "compatibility", "discrepancy", "linear_models", "maneuvers"]
)
def test_every_analysis_reads_with_the_certificates_given(
    command: str, flight: FlightFolder, tmp_path: Path
) -> None:
    calls = {
        "estimate": lambda: estimate(flights=[flight.path], calibration="absent"),
        "compatibility": lambda: compatibility(flights=[flight.path], calibration="absent"),
        "discrepancy": lambda: discrepancy(
            flights=[flight.path], out=tmp_path / "d", calibration="absent"
        ),
        "linear_models": lambda: linear_models(
            flights=[flight.path],
            validate=shutil.copytree(flight.path, tmp_path / "another"),
            calibration="absent",
        ),
        "maneuvers": lambda: maneuvers(flights=[flight.path], calibration="absent"),
    }
    with pytest.raises(Exception, match="no folder 'absent'"):
        calls[command]()
