"""Files with mistakes, damaged flights, folders without rights: one sentence, nothing changed."""

import json
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from calibration.certificate_toml import SHIPPED_CERTIFICATES_FOLDER as CERTIFICATES
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT as AIRCRAFT
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as CHANNEL_MAPS
from gsapp.decoding.framing import Framer
from gsapp.flight.folder import FlightFolder
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.flight.raw_files import RawWriter
from tests.bad_input.bad_input_kit import GSAPP, Box, everything_in, refused, without_rights
from tests.cli.command_kit import gsapp

FRAMES = 300
Summary = dict[str, Any]
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="needs the capabilities of Linux")


@pytest.fixture
def flight(tmp_path: Path) -> Path:
    return made_flight(tmp_path / "flight")


def made_flight(path: Path) -> Path:
    folder = prepare_flight_folder(path, aircraft="b777", channel_map="b777").path
    box, writer, framer = Box(), RawWriter(folder), Framer()
    for k in range(FRAMES):
        stamp = 1_700_000_000_000_000 + 10_000 * k
        writer.append(stamp, framer.feed(box.array(1_000_000 + 10_000 * k)))
    writer.append(1_700_000_003_000_001, framer.flush())
    writer.close()
    return folder


def altered(source: Path, target: Path, *changes: tuple[str, str]) -> str:
    text = source.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    target.write_text(text)
    return target.name


# Tables


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (
            "time [s],alpha [furlong]\n0,1\n1,2\n",
            ("line 1, column 2", "'furlong' is not a unit of angle", "use one of: rad, deg"),
        ),
        (
            "alpha [deg],q [deg/s]\n1,2\n2,3\n",
            ("line 1", "there is no column of time", "add one headed 'time [s]'"),
        ),
    ],
    ids=["wrong unit", "no time"],
)
def test_a_csv_with_a_mistake(tmp_path: Path, table: str, words: tuple[str, ...]) -> None:
    (tmp_path / "flight.csv").write_text(table)
    refused(("replay", "flight.csv", "--headless"), "flight.csv: 1 problem", *words, cwd=tmp_path)


def test_a_csv_of_another_program_asks_for_a_map(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("GPS time (ms),Alpha,gyro_y,comment\n0,1,2,a\n20,1,2,b\n")
    words = ("'table' with --map", "Columns: GPS time (ms), Alpha, gyro_y, comment")
    refused(("import", "log.csv", "--out", "new"), *words, cwd=tmp_path)


def test_a_csv_without_a_column_that_the_map_needs(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,aoa\n0,1\n0.1,2\n0.2,3\n")
    (tmp_path / "map.toml").write_text(
        'name = "mine"\nformat = "table"\ntime = "t"\ntime_unit = "s"\n'
        '[[channels]]\nid = "alpha"\nsource = "aoa"\nunit = "deg"\n'
        '[[channels]]\nid = "beta"\nsource = "ssa"\nunit = "deg"\n'
    )
    call = ("import", "log.csv", "--map", "map.toml", "--out", "new")
    refused(
        call, "log.csv: 1 problem", "ssa: is no column of this file; it has: t, aoa", cwd=tmp_path
    )


# Flight folders


def replayed(flight: Path) -> tuple[str, Summary]:
    made = flight.parent / "summary.json"
    done = gsapp("replay", flight, "--headless", "--json", made)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    return done.stdout, json.loads(made.read_text())


@pytest.fixture(scope="module")
def hurt(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Summary]:
    flight = made_flight(tmp_path_factory.mktemp("hurt") / "flight")
    FlightFolder.open(flight).store_onboard_log(flight / "raw.tlog", "onboard.tlog")
    record = flight / "raw.tlog"
    data = record.read_bytes()
    size = len(data) // FRAMES
    record.write_bytes(data[: 100 * size + 40] + data[120 * size + 30 :])
    (flight / "events.jsonl").write_text('{"kind": "mark"\n{"kind": "mark", "text": "whole"}\n')
    return replayed(flight)


def test_a_record_torn_in_the_middle_opens_as_far_as_it_is_good(hurt: tuple[str, Summary]) -> None:
    said, summary = hurt
    assert "raw.tlog:" in said
    assert "1 place" in said
    assert summary["frames"]["good"] == FRAMES - 21
    assert summary["frames"]["lost"] == 21
    assert summary["channels"]["alpha"]["gaps"] == 1
    assert summary["duration"] == pytest.approx((FRAMES - 1) / 100)


def test_damaged_marks_are_left_out_and_told(hurt: tuple[str, Summary]) -> None:
    said, summary = hurt
    assert "events.jsonl: 1 line" in said
    marks = [event["text"] for event in summary["events"] if event["kind"] == "mark"]
    assert marks == ["whole"]


def test_a_replay_says_that_it_shows_the_live_record(hurt: tuple[str, Summary]) -> None:
    """Beside an on-board log, `load_flight` joins the two; a replay is of what came live."""
    assert "onboard.tlog" in hurt[0]


def test_a_log_of_nothing_is_no_flight(tmp_path: Path) -> None:
    """Whatever opens it says that there is no message in it; not that a map would help."""
    garbage = tmp_path / "garbage.tlog"
    garbage.write_bytes(random.Random(3).randbytes(5000))
    for call in (
        ("replay", garbage, "--headless"),
        ("replay", garbage, "--headless", "--map", "b777"),
        ("import", garbage, "--out", tmp_path / "made"),
        ("export", garbage, "--to", "csv", "--out", tmp_path / "made.csv"),
        ("maneuvers", garbage),
    ):
        done = gsapp(*call)
        assert done.returncode == 1, call
        assert "garbage.tlog" in done.stderr
        assert "--map" not in done.stderr
    assert list(tmp_path.iterdir()) == [garbage]


def test_a_recording_in_which_nothing_arrived_opens(tmp_path: Path) -> None:
    done = gsapp("replay", prepare_flight_folder(tmp_path / "silent").path, "--headless")
    assert done.returncode == 0
    assert "contains no record" in done.stdout


def test_a_record_cut_at_its_end_opens(flight: Path) -> None:
    record = flight / "raw.tlog"
    record.write_bytes(record.read_bytes()[:-30])
    said, summary = replayed(flight)
    assert "raw.tlog" in said
    assert summary["frames"]["good"] == FRAMES - 1


def test_a_lost_onboard_log_does_not_close_the_flight(flight: Path) -> None:
    FlightFolder.open(flight).store_onboard_log(flight / "raw.tlog", "onboard.tlog")
    (flight / "onboard.tlog").unlink()
    out = flight.parent / "out.csv"
    done = gsapp("export", flight, "--to", "csv", "--out", out)
    assert done.returncode == 0, done.stderr
    assert "onboard.tlog" in done.stdout
    assert len(out.read_text().splitlines()) > FRAMES


def test_a_damaged_flight_toml(flight: Path) -> None:
    info = flight / "flight.toml"
    good = info.read_text()
    info.write_text(good + "[[[\n")
    call = ("replay", "flight", "--headless")
    line = len(good.splitlines()) + 1
    refused(call, f"flight.toml: 1 problem\n  line {line}, column 3", "TOML", cwd=flight.parent)
    info.write_text('takeoff_weigth = "3 lb"\nfuel = "2 ft"\n')
    refused(
        call, "flight.toml: 2 problems", "did you mean 'takeoff_weight'?", "fuel: 'ft' is not a",
        cwd=flight.parent,
    )  # fmt: skip


# Files that are given to commands


def test_a_channel_map_with_mistakes(tmp_path: Path) -> None:
    """All of them at once, even where certificates are named beside it; no folder is made."""
    name = altered(
        CHANNEL_MAPS.find("b777"), tmp_path / "mine.toml",
        ('unit = "V"', 'unit = "Volt"'), ('id = "alpha"', 'id = "alhpa"'),
        ("[daq].data[7]", "[daq].dota[7]"),
    )  # fmt: skip
    refused(
        ("record", "udpin:127.0.0.1:14599", "--map", name, "--calibration", "b777", "--out", "new"),
        "mine.toml: 3 problems",
        "channels[0].unit: 'Volt' is no unit of a signal; use V, mV",
        "channels[5].id: no channel is called 'alhpa'; did you mean 'alpha'",
        "channels[7].source: DEBUG_FLOAT_ARRAY has no field 'dota'; did you mean 'data'?",
        cwd=tmp_path,
    )  # fmt: skip


def test_a_certificate_with_a_mistake(tmp_path: Path) -> None:
    shutil.copytree(CERTIFICATES / "b777", tmp_path / "mine")
    alpha = tmp_path / "mine" / "alpha.toml"
    altered(alpha, alpha, ('unit = "deg"', 'unit = "dag"'))
    refused(
        ("record", "udpin:127.0.0.1:14599", "--calibration", "mine", "--out", "new"),
        "alpha.toml: 1 problem", "unit: 'dag' is not a unit of angle", "use one of",
        cwd=tmp_path,
    )  # fmt: skip


def test_an_aircraft_with_mistakes(tmp_path: Path) -> None:
    name = altered(
        AIRCRAFT.find("b777"), tmp_path / "mine.toml",
        ('"11.33 ft^2"', '"11.33 ft"'), ("span =", "spam ="),
    )  # fmt: skip
    refused(
        ("fly", "--out", "new", "--plan", "short", "--aircraft", name),
        "mine.toml: 3 problems",
        "geometry.wing_area: 'ft' is not a unit of area; did you mean 'ft^2'?",
        "geometry.span: is missing; add it",
        "geometry.spam: is not a known key; did you mean 'span'?",
        cwd=tmp_path,
    )


def test_a_plan_with_mistakes(tmp_path: Path) -> None:
    from gsapp.virtual.flight_plan import SHIPPED_PLANS as PLANS

    name = altered(
        PLANS.find("short"), tmp_path / "mine.toml",
        ("leg =", "legg ="), ('inputs = ["de"]', 'inputs = ["dx"]'), ('"0.45 s"', '"0.45 m"'),
    )  # fmt: skip
    words = (
        "mine.toml: 3 problems",
        "pattern.legg: is not a known key; did you mean 'leg'?",
        "maneuvers[0].inputs[0]: input should be 'de', 'da' or 'dr' (found 'dx')",
        "maneuvers[0].step: 'm' is not a unit of time",
    )
    refused_here(("fly", "--out", "new", "--plan", name), words, tmp_path)


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        ("aero.Cm.nonsense", ("no effect is called 'aero.Cm.nonsense'", "did you mean")),
        ("aero.Cm.alpha2:foo=1", ("has no parameter 'foo'; it has Cm_alpha2",)),
        ("aero.Cm.alpha2:Cm_alpha2=x", ("is not PARAM=VALUE; write for example",)),
    ],
)
def test_an_effect_that_is_none(tmp_path: Path, effect: str, words: tuple[str, ...]) -> None:
    refused_here(("fly", "--out", "new", "--hide", effect), words, tmp_path, 2)


def refused_here(call: tuple[str, ...], words: tuple[str, ...], cwd: Path, code: int = 1) -> None:
    there = everything_in(cwd)
    done = gsapp(*call, folder=cwd)
    assert done.returncode == code
    *_, sentence = done.stderr.split("gsapp: ")
    for word in words:
        assert word in sentence
    assert everything_in(cwd) == there


# Rights


@pytest.fixture
def guarded(flight: Path) -> Iterator[Path]:
    place = flight.parent
    (place / "small.csv").write_text("time [s],alpha [deg]\n0,1\n0.1,2\n0.2,3\n")
    (place / "media").mkdir(mode=0o555)
    flight.chmod(0o000)
    yield place
    flight.chmod(0o755)


@LINUX
def test_a_folder_that_may_not_be_read(guarded: Path) -> None:
    (guarded / "flight").chmod(0o000)
    refused_blind(
        ("replay", "flight", "--headless"),
        "the folder flight cannot be read (Permission denied); check its permissions",
        cwd=guarded,
    )


def refused_blind(call: tuple[str, ...], *words: str, cwd: Path) -> None:
    done = subprocess.run(
        [*GSAPP, *call], capture_output=True, encoding="utf-8", timeout=240, cwd=cwd,
        preexec_fn=without_rights,
    )  # fmt: skip
    if done.returncode == 99:
        pytest.skip("root may not give up its rights here")
    assert done.returncode == 1, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    for word in words:
        assert word in done.stderr


@LINUX
@pytest.mark.parametrize(
    ("call", "words"),
    [
        (("export", "small.csv", "--to", "csv", "--out", "media/x.csv"), "media/x.csv cannot be"),
        (("import", "small.csv", "--out", "media/x"), "media/x cannot be made"),
        (("record", "udpin:127.0.0.1:14598", "--out", "media/x"), "media/x cannot be made"),
        (("replay", "small.csv", "--json", "media/x.json"), "media/x.json cannot be written"),
    ],
    ids=["export", "import", "record", "json"],
)
def test_a_medium_without_rights(guarded: Path, call: tuple[str, ...], words: str) -> None:
    refused_blind(call, words, "Permission denied", "with write permission" if call[0] != "export"
                  else "check the path, the permissions", cwd=guarded)  # fmt: skip
    assert everything_in(guarded / "media") == {}


# The display


@LINUX
@pytest.mark.parametrize(
    ("display", "words"),
    [(None, "No display"), (":9123", "The X display ':9123' does not answer")],
)
def test_no_display(tmp_path: Path, display: str | None, words: str) -> None:
    """Qt would abort the process; the command ends with a sentence and code 1 instead."""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    if display:
        environment["DISPLAY"] = display
    refused((), words, "use --headless", cwd=tmp_path, environment=environment)
