"""Commands are quick to ask, exit with the right code, and say one sentence when they fail."""

import errno
import itertools
import os
import re
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import get_type_hints

import pytest
from typer.models import OptionInfo

from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.cli import _usage_errors
from gsapp.cli._console import write_json
from gsapp.cli._usage_errors import check_output_paths
from gsapp.cli.main import app
from gsapp.decoding.dialect import dialect
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.flight.writers import write_block
from gsapp.foundation import GroundStationError, files
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.cli.command_kit import Done
from tests.cli.command_kit import gsapp as here

HEAVY = ("numpy", "pydantic", "pint", "PySide6", "matplotlib", "scipy", "pymavlink", "rich")


def gsapp(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "gsapp.cli", *arguments],
        capture_output=True,
        encoding="utf-8",
        timeout=240,
    )


def test_help_imports_nothing_heavy() -> None:
    program = (
        "import sys; sys.argv = ['gsapp', '--help']\n"
        "from gsapp.cli.main import app\n"
        "try: app()\n"
        "except SystemExit: pass\n"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, encoding="utf-8")
    assert done.stdout.splitlines()[-1] == "[]"


def test_the_list_of_commands_fits_a_terminal() -> None:
    listed = here("--help").stdout.partition("Commands:")[2].strip().splitlines()
    assert len(listed) == len(app.registered_commands)
    assert all(line.endswith(".") and not line.endswith("...") for line in listed)
    assert max(map(len, listed)) <= 80


@pytest.mark.parametrize("command", [one.name or one.callback.__name__ for one in
                                     app.registered_commands])  # fmt: skip
def test_help_shows_no_types_of_the_library(command: str) -> None:
    name = command.rstrip("_").replace("_", "-")
    said = here(name, "--help").stdout
    assert f"Example: gsapp {name}" in said
    for internal in ("Examples", "list[", "{", "<path>", "<str>", "<int", "<float"):
        assert internal not in said


@pytest.mark.parametrize(
    ("call", "complaint"),
    [
        (("export", "f", "--to", "xls", "--out", "x"), "'xls' is not one of 'csv', 'mat'"),
        (("fly", "--out", "x", "--seed", "-1"), "-1 is too small; use 0 or more"),
        (("fly", "--out", "x", "--seed", "1.5"), "'1.5' is not a whole number"),
        (("fly", "--out", "x", "--speed", "fast"), "'fast' is not a number"),
        (("calibrate", "p", "--channel", "q", "--out", "x", "--degree", "7"), "use 3 or less"),
    ],
)
def test_complaints_are_in_plain_words(call: tuple[str, ...], complaint: str) -> None:
    done = here(*call)
    assert done.returncode == 2
    assert complaint in done.stderr
    assert "Value error" not in done.stderr
    assert "Input should" not in done.stderr


def test_no_character_ends_a_command_whose_words_go_to_a_pipe(tmp_path: Path) -> None:
    flight, cut = tmp_path / "flight.csv", tmp_path / "cut-λ.csv"
    flight.write_text("time [s],alpha [deg]\n0,1\n0.01,2\n0.02,3\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "gsapp.cli", "cut", flight, "--window", "0:1", "--out", cut],
        capture_output=True, timeout=240, env={**os.environ, "PYTHONIOENCODING": "cp1252"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "cut-λ.csv" in done.stdout.decode("utf-8")


@pytest.mark.parametrize("columns", ["40", "80", "120"])
def test_a_channel_stays_in_one_piece_however_wide_its_numbers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, columns: str
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    flight = tmp_path / "flight.csv"
    rows = [f"{k / 50:.2f},{k * 1e4},{-k * 1e9},{k * 1e7}" for k in range(100)]
    flight.write_text(
        "time [s],elevator_right_volts [V],elevator_right [deg],static_pressure_volts [V]\n"
        + "\n".join(rows)
    )
    lines = here("replay", flight, "--headless").stdout.splitlines()
    for name in ("elevator_right_volts", "elevator_right", "static_pressure_volts"):
        (line,) = [one.split() for one in lines if name in one.split()[:1]]
        assert line[2:4] == ["100", "50"]
        assert "…" not in "".join(line[:6])


def test_headings_of_tables_say_their_units(tmp_path: Path) -> None:
    flight = tmp_path / "flight.csv"
    flight.write_text("time [s],alpha [deg],de [deg]\n0,1,0\n0.01,2,0\n0.02,3,0\n")
    catalog = tmp_path / "campaign.sqlite"
    found = here("maneuvers", flight, "--catalog", catalog).stdout
    assert "start [s]" in found
    assert "V [ft/s]" in found
    assert "alpha [deg]" in here("catalog", catalog).stdout


@pytest.mark.parametrize("call", [("dance",), ("record",), ("fly",), ("replay",)])
def test_a_wrong_call_exits_with_2(call: tuple[str, ...]) -> None:
    done = here(*call)
    assert done.returncode == 2
    assert "Usage:" in done.stderr


def test_the_process_ends_with_the_code_of_its_command() -> None:
    ended = [gsapp(*call) for call in (("--version",), ("export", "absent.csv", "--to", "mat",
             "--out", "x.mat"), ("dance",))]  # fmt: skip
    assert [one.returncode for one in ended] == [0, 1, 2]


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (("replay", "flight.csv", "--headless", "--speed", "0"), "give 0.1 to 50 times real time"),
        (("replay", "flight.csv", "--speed", "fast"), "invalid replay speed 'fast'"),
        (("record", "foo:bar", "--out", "x"), "'foo:bar' is neither a link nor a flight"),
        (("record", "udpin:nowhere", "--out", "x"), "the port is missing"),
        (("record", "udpin:127.0.0.1:99999", "--out", "x"), "port 99999"),
        (("record", "udpin:127.0.0.1:14599", "--out", "x", "--speed", "2"), "leave out --speed"),
        (("record", "flight.csv", "--out", "x", "--speed", "0"), "is not possible"),
        (("fly", "--to", "udpout:127.0.0.1:0"), "port 0"),
        (("fly", "--out", "x", "--speed", "nan"), "is not possible"),
        (("fly", "--out", "x", "--hide", "aero.Cm.none"), "no effect is called"),
        (("fly", "--out", "x", "--fault", "alpha:spam"), "is not a fault"),
        (("onboard", "flight", "--link", "udpin"), "the port is missing"),
        (("onboard", "flight", "--link", "text:COM5:9600"), "no log can be requested"),
        (("debrief",), "nothing to debrief"),
        (("export", "f.csv", "--to", "csv", "--out", "x.mat"), "of another format than --to csv"),
        (("estimate", "flight.csv", "--stand-in", "speed=30"), "no channel is called 'speed'"),
        (("estimate", "flight.csv", "--bound-factor", "-1"), "greater than 0"),
        (("compatibility", "flight.csv", "--maneuver", "5"), "the maneuver '5' cannot be read"),
        (("discrepancy", "flight.csv", "--out", "x", "--refuse", "none"), "no effect 'none'"),
        (("cut", "flight.csv", "--out", "x.csv", "--window", "5:2"), "is not a window of time"),
        (("cut", "flight.csv", "--out", "x.csv", "--rename", "q=none"), "no channel is called"),
        (("calibrate", "p.csv", "--channel", "none", "--out", "x"), "no channel is called"),
        (("inertia", "swings.toml", "--unit", "ft/s"), "not a unit of inertia"),
    ],
)
def test_words_that_no_file_could_fit_exit_with_2(
    tmp_path: Path, call: tuple[str, ...], sentence: str
) -> None:
    done = here(*call, folder=tmp_path)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("gsapp: ")
    assert sentence in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_flight_in_the_place_of_a_command_is_told_how_it_opens(tmp_path: Path) -> None:
    told = here(tmp_path)
    assert told.returncode == 2
    assert "gsapp replay FLIGHT" in told.stderr
    assert "No such command" in here(tmp_path / "nothing").stderr


@pytest.mark.parametrize("more", [("--out", "fl", "--thin"), ("--to", "udpout:127.0.0.1:9")])
def test_an_on_board_log_that_nobody_would_write_is_a_wrong_call(
    tmp_path: Path, more: tuple[str, ...]
) -> None:
    done = here("fly", "--onboard", "box.tlog", *more, folder=tmp_path)
    assert (done.returncode, list(tmp_path.iterdir())) == (2, [])
    assert "--onboard" in done.stderr


def test_certificates_from_the_future_are_told_by_the_clock_that_is_wrong(tmp_path: Path) -> None:
    """A laptop without a battery wakes in 1970: an age of minus 2295873 minutes helps nobody."""
    (tmp_path / "points.csv").write_text(_POINTS)
    made = here("calibrate", "points.csv", "--channel", "rudder", "--out", "c/rudder.toml",
                folder=tmp_path)  # fmt: skip
    assert made.returncode == 0, made.stderr
    certificate = tmp_path / "c" / "rudder.toml"
    text = certificate.read_text(encoding="utf-8")
    certificate.write_text(re.sub(r"stamp = \d{4}", "stamp = 2126", text), encoding="utf-8")
    listed = here("certificates", "c", folder=tmp_path).stdout
    assert "clock?" in listed
    today = datetime.now()  # noqa: DTZ005
    assert f"{today.day} {today:%b %Y}" in " ".join(listed.split())


def test_suspicious_numbers_of_ones_own_aircraft_are_told(tmp_path: Path) -> None:
    doubt = "ixx + iyy - izz says that the mass lies"
    mine = tmp_path / "mine.toml"
    shipped = (SHIPPED_AIRCRAFT.folder / "b777.toml").read_text(encoding="utf-8")
    mine.write_text(shipped.replace('name = "B777"', 'name = "Mine"'), encoding="utf-8")
    for aircraft, said in (("b777", 0), (mine, 1)):
        flight, again = tmp_path / f"flight-{said}", tmp_path / f"again-{said}"
        failed = here("fly", "--out", again, "--plan", "absent", "--aircraft", aircraft)
        assert failed.stderr.count(f"Mine: {doubt}") == said
        assert failed.stderr.count(doubt) == said
        folder = prepare_flight_folder(flight, aircraft=str(aircraft), channel_map="b777")
        frame = dialect().MAVLink(None, srcSystem=1).heartbeat_encode(1, 3, 0, 0, 4)
        packed = frame.pack(dialect().MAVLink(None, srcSystem=1))
        folder.tlog_file.write_bytes(struct.pack(">Q", 1_760_000_000_000_000) + packed)
        assert here("replay", flight, "--headless").stdout.count(doubt) == said
        recorded = here("record", flight, "--aircraft", aircraft, "--out", again)
        assert recorded.stdout.count(doubt) == said


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (("replay", "absent-flight", "--headless"), "absent-flight"),
        (("export", "absent.csv", "--to", "mat", "--out", "x.mat"), "absent.csv"),
        (("import", "absent.bin", "--map", "ardupilot-log", "--out", "x"), "absent.bin"),
        (("fly", "--out", "x", "--plan", "absent-plan"), "absent-plan"),
    ],
)
def test_a_failure_exits_with_1_and_says_why_without_a_stack_trace(
    tmp_path: Path, call: tuple[str, ...], sentence: str
) -> None:
    done = here(*call, folder=tmp_path)
    assert done.returncode == 1, done.stderr
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "call",
    [
        ("cut", "table.csv", "--window", "0:1", "--out", "table.csv"),
        ("cut", "table.csv", "--window", "0:1", "--out", "other/../table.csv"),
        ("merge", "more.csv", "table.csv", "--out", "table.csv"),
        ("export", "solo.tlog", "--map", "b777", "--to", "csv", "--out", "solo.tlog"),
        ("calibrate", "table.csv", "--channel", "alpha", "--out", "table.csv"),
        ("replay", "flight", "--headless", "--json", "flight/raw.tlog"),
        ("replay", "table.csv", "--headless", "--json", "flight/flight.toml"),
        ("cut", "table.csv", "--out", "new.csv", "--json", "new.csv"),
        ("inertia", "table.csv", "--json", "table.csv"),
        ("record", "flight", "--out", "flight"),
        ("record", "flight/raw.tlog", "--out", "flight"),
        ("discrepancy", "flight", "--model", "other/model.toml", "--out", "other"),
        ("report", "other", "--out", "other"),
        ("linear-models", "flight", "--validate", "other/more.csv", "--out", "other/../other"),
    ],
)
def test_no_command_overwrites_what_it_reads_nor_a_flight(
    tmp_path: Path, call: tuple[str, ...]
) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "flight").mkdir()
    names = (
        "table.csv", "more.csv", "solo.tlog", "flight/raw.tlog", "flight/flight.toml",
        "other/model.toml", "other/more.csv",
    )  # fmt: skip
    for name in names:
        (tmp_path / name).write_text(f"dear {name}")
    done = here(*call, folder=tmp_path)
    assert done.returncode == 1, done.stderr
    assert re.search(
        "input of the command; choose|made of; choose|choose two|another folder", done.stderr
    )
    for name in names:
        assert (tmp_path / name).read_text() == f"dear {name}"
    assert not (tmp_path / "new.csv").exists()


def test_a_recording_goes_on_with_the_copies_of_its_own_flight(tmp_path: Path) -> None:
    check_output_paths({"link": "virtual", "out": tmp_path, "channel_map": _laid(tmp_path)})
    with pytest.raises(GroundStationError, match=r"holds .*channel_map\.toml"):
        check_output_paths({"flights": ("fl",), "out": tmp_path, "channel_map": _laid(tmp_path)})


def _laid(folder: Path) -> str:
    (folder / "channel_map.toml").write_text('name = "mine"')
    return str(folder / "channel_map.toml")


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights of their own")
def test_no_link_leads_a_result_into_a_flight(tmp_path: Path) -> None:
    prepare_flight_folder(tmp_path / "flight", aircraft="b777", channel_map="b777")
    (tmp_path / "x.json").symlink_to(tmp_path / "flight" / "flight.toml")
    with pytest.raises(GroundStationError, match="made of"):
        check_output_paths({"json": tmp_path / "x.json"})


def test_only_the_result_for_programs_goes_to_the_screen(tmp_path: Path) -> None:
    done = here("calibrate", "points.csv", "--channel", "alpha", "--out", "-", folder=tmp_path)
    assert (done.returncode, list(tmp_path.iterdir())) == (2, [])
    assert "--json" in done.stderr


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (
            OSError(errno.ENOSPC, "No space left on device", "a.html"),
            "a.html: No space.*; free disk space",
        ),
        (
            PermissionError(errno.EACCES, "Permission denied", "b"),
            "b: Permission denied; check the",
        ),
        (
            OSError(errno.ENAMETOOLONG, "File name too long", "c" * 999),
            r"c\.\.\.c.*; choose a short",
        ),
    ],
)
def test_what_a_system_refuses_is_told_with_a_remedy(
    monkeypatch: pytest.MonkeyPatch, error: OSError, sentence: str
) -> None:
    def fail(_: object) -> None:
        raise error

    monkeypatch.setattr("gsapp.aircraft.swings.load_swings", fail)
    done = here("inertia", "swings.toml")
    assert done.returncode == 1
    assert re.search(sentence, done.stderr)
    assert len(done.stderr) < 300


_POINTS = "angle [deg],volts [V],direction\n" + "".join(
    f"{angle},{2.5 + angle / 20},{way}\n" for way in ("up", "down") for angle in (-20, 0, 20)
)


@pytest.mark.parametrize(
    "call",
    [
        ("calibrate", "points.csv", "--channel", "rudder", "--out", "new.toml"),
        ("calibrate", "points.csv", "--channel", "rudder", "--out", "c.toml", "--report", "x.html"),
        ("replay", "fl.csv", "--headless", "--json", "x.json"),
        ("export", "fl.csv", "--to", "csv", "--out", "x.csv"),
        ("export", "fl.csv", "--to", "parquet", "--out", "x.parquet"),
        ("import", "fl.csv", "--out", "folder"),
    ],
)
def test_a_full_disk_is_told_with_its_remedy_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: tuple[str, ...]
) -> None:
    (tmp_path / "points.csv").write_text(_POINTS)
    (tmp_path / "fl.csv").write_text("time [s],alpha [deg]\n0,1\n1,1\n")
    there = sorted(tmp_path.iterdir())
    flush, calls = files.flush_to_disk, itertools.count()

    def fill(descriptor: int) -> None:
        if "c.toml" not in call or next(calls):
            raise OSError(errno.ENOSPC, "No space left on device")
        flush(descriptor)  # the certificate still fits, the page no more

    monkeypatch.setattr(files, "flush_to_disk", fill)
    done = here(*call, folder=tmp_path)
    assert done.returncode == 1
    assert "No space left" in done.stderr
    assert f"{call[-1]} cannot be " in done.stderr
    assert sorted(tmp_path.iterdir()) == sorted(
        [*there, *([tmp_path / "c.toml"] if "c.toml" in call else [])]
    )


@pytest.mark.skipif(sys.platform != "linux", reason="a device that is always full")
def test_what_is_printed_on_a_full_disk_is_told_with_its_remedy() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "gsapp.cli", "--version"],
            stdout=full, stderr=subprocess.PIPE, encoding="utf-8", timeout=240,
        )  # fmt: skip
    assert done.returncode == 1
    assert "No space left" in done.stderr


def test_what_cannot_be_read_is_told_by_the_command() -> None:
    for command in app.registered_commands:
        for name, hint in get_type_hints(command.callback, include_extras=True).items():
            about = next(iter(getattr(hint, "__metadata__", ())), None)
            if "Path" in str(hint) and about is not None:
                assert about.readable is False, (command.callback, name)


def test_every_option_that_names_what_is_written_is_watched() -> None:
    read = {"channel_map", "calibration", "aircraft", "model", "weights", "validate", "former"}
    read |= {"plan", "cards", "log", "catalog"}  # a catalog is both, and nothing but a catalog
    watched = set(_usage_errors._WRITTEN)
    for command in app.registered_commands:
        hints = get_type_hints(command.callback, include_extras=True)
        for name, hint in hints.items():
            about = next(iter(getattr(hint, "__metadata__", ())), None)
            if isinstance(about, OptionInfo) and "Path" in str(hint):
                assert name in watched | read, (command.callback, name)


# Windows takes no colon in a name.
MARKED = "[x]fl" if sys.platform == "win32" else "[x]fl:smile:"


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Done]:
    """Return a short flight with a name that could be taken for marks of style, and what was said.

    It is only read.
    """
    folder = tmp_path_factory.mktemp("flown")
    (folder / "plan.toml").write_text(
        'name = "ground"\n[engines]\nstart = "0.5 s"\nrunning = "2 s"\n'
    )
    done = here("fly", "--out", MARKED, "--plan", "plan.toml", "--seed", 3, folder=folder)
    return folder / MARKED, done


def test_words_in_brackets_and_between_colons_are_printed_as_they_are(
    flown: tuple[Path, Done], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    assert flown[1].returncode == 0
    assert flown[1].stderr == f"Wrote the flight {MARKED}.\n"
    name = MARKED
    table = tmp_path / f"{name}.csv"
    table.write_text("time [s],alpha [deg]\n0,1\n0.01,-0.0001\n0.02,1\n")
    for call in (
        ("replay", table, "--headless", "--json", f"{name}.json"),
        ("import", table, "--out", f"in{name}"),
        ("cut", table, "--window", "0:1", "--out", f"cut{name}.csv"),
        ("export", table, "--to", "csv", "--out", f"out{name}.csv"),
    ):
        done = here(*call, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        assert name in done.stdout, call
    assert "-0" not in here("replay", table, "--headless", folder=tmp_path).stdout


def test_all_commands_print_on_the_same_kind_of_screen() -> None:
    for path in Path(_usage_errors.__file__).parent.glob("*.py"):
        text = path.read_text(encoding="utf-8")
        if path.name != "_console.py":
            assert not re.search(r"\bConsole\(|TextColumn\(\"{task.desc|rich\.markup", text), path
            assert not re.search(r"\[/\w*\]", text), path  # the end of a mark


def test_numbers_of_estimates_are_whole_however_narrow_the_screen(
    flown_short: Callable[[int], VirtualFlight], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = write_block(tmp_path / "flight.csv", flown_short(6).measured, "csv")
    call = ("estimate", flight, "--aircraft", "b777", "--method", "ee")
    wide = here(*call).stdout
    monkeypatch.setenv("COLUMNS", "40")
    narrow = here(*call).stdout
    assert "\u2026" not in narrow
    numbers = set(re.findall(r"-?\d+\.\d{4}", narrow))
    assert len(numbers) > 20
    assert numbers <= set(re.findall(r"-?\d+\.\d{4}", wide))


@pytest.mark.parametrize("command", ["estimate", "debrief", "compatibility", "report", "terms"])
def test_a_flight_given_twice_is_refused(tmp_path: Path, command: str) -> None:
    (tmp_path / "fl.csv").write_text("time [s],alpha [deg]\n0,1\n1,1\n")
    more = ("--out", "x.html") if command == "report" else ()
    done = here(command, "fl.csv", "./fl.csv", *more, folder=tmp_path)
    assert done.returncode == 2
    assert "fl.csv" in done.stderr


def test_a_flight_given_beside_the_folder_that_holds_it_is_refused(tmp_path: Path) -> None:
    prepare_flight_folder(tmp_path / "day" / "fl", aircraft="b777", channel_map="b777")
    done = here("report", "day", "day/fl", "--out", "x.html", folder=tmp_path)
    assert done.returncode == 2
    assert str(Path("day/fl")) in done.stderr


def test_a_result_for_a_closed_output_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    with pytest.raises(GroundStationError, match="standard output"):
        write_json(Path("-"), "{}")


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every name is Unicode")
def test_names_that_are_not_utf8_are_told_without_a_stack_trace(
    flown: tuple[Path, Done], tmp_path: Path
) -> None:
    name = os.fsdecode(b"bad\xe9")
    shutil.copytree(flown[0], tmp_path / name)
    for call in (
        ("fly", "--plan", "short", "--out", f"{name}.out"),
        ("maneuvers", name, "--catalog", "c.sqlite"),
    ):
        done = here(*call, folder=tmp_path)
        assert done.returncode == 1, call
        assert "not UTF-8" in done.stderr
