"""A word means the same in every command, and a wrong one is answered with the right one."""

import os
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest
import typer

from calibration.certificate_toml import SHIPPED_CERTIFICATES_FOLDER
from gsapp.cli.main import app
from gsapp.flight.writers import write_block
from tests.cli.command_kit import gsapp
from tests.flight.maneuver_kit import Input, make_flight
from tests.foreign_units import CUSTOMARY, METRIC

COMMANDS = typer.main.get_command(app).commands
FIXED = {"--to"}
"""Of `fly` a link, of `export` a format: both are promised to scripts."""


def choices(annotation: Any) -> frozenset[str]:
    if get_origin(annotation) is Literal:
        return frozenset(get_args(annotation))
    return frozenset().union(*map(choices, get_args(annotation)))


def test_an_option_means_the_same_in_every_command() -> None:
    found: dict[str, dict[str, tuple[bool, frozenset[str]]]] = defaultdict(dict)
    for name, command in COMMANDS.items():
        for option in command.params:
            if option.param_type_name == "option" and not option.hidden:
                kind = option.is_flag, choices(option.type_descriptor.annotation)
                found[option.opts[0]][name] = kind
    assert len(found) > 60
    for option, uses in found.items():
        if option not in FIXED:
            assert len({flag for flag, _ in uses.values()}) == 1, (option, uses)
            every = max((text for _, text in uses.values()), key=len)
            shared = {"us", "si"} if option == "--units" else every
            assert all(shared <= text <= every for _, text in uses.values()), (option, uses)


@pytest.mark.parametrize(
    ("command", "former"),
    [("discrepancy", "--catalog"), ("compatibility", "--free"), ("resample", "--kind")],
)
def test_former_words_are_still_understood(command: str, former: str) -> None:
    option = next(one for one in COMMANDS[command].params if former in one.opts)
    assert option.hidden
    assert former not in gsapp(command, "--help").stdout.split()


def test_units_are_understood_in_capitals(tmp_path: Path) -> None:
    (tmp_path / "fl.csv").write_text("time [s],V [m/s]\n0,30\n1,30\n")
    made = gsapp("export", "fl.csv", "--to", "csv", "--units", "SI", "--out", "x.csv",
                 folder=tmp_path)  # fmt: skip
    assert made.returncode == 0, made.stderr
    assert "V [m/s]" in (tmp_path / "x.csv").read_text()


def test_an_imported_flight_is_described_in_the_units_of_the_call(tmp_path: Path) -> None:
    (tmp_path / "fl.csv").write_text("time [s],V [m/s]\n0,30\n1,30\n")
    made = gsapp("import", "fl.csv", "--units", "si", "--out", "one", folder=tmp_path)
    assert made.returncode == 0, made.stderr
    assert "m/s" in made.stdout
    assert "ft/s" not in made.stdout
    assert "ft/s" in gsapp("import", "fl.csv", "--out", "two", folder=tmp_path).stdout


@pytest.mark.parametrize(
    ("call", "meant"),
    [
        (("estimat", "fl.csv"), "'estimate'"),
        (("replay", "fl.csv", "--headles"), "--headless"),
        (("export", "fl.csv", "--to", "cvs", "--out", "x.csv"), "'csv'"),
        (("estimate", "fl.csv", "--axis", "Lonn"), "'lon'"),
        (("runs", "c.sqlite", "shw"), "'show'"),
        (("replay", "fk.csv", "--headless"), "'fl.csv'"),
        (("replay", "fl.csv", "--headless", "--map", "b77"), "'b777'"),
        (("cut", "fl.csv", "--channels", "Alhpa", "--out", "x.csv"), "'alpha'"),
        (("estimate", "fl.csv", "--aircraft", "B77"), "'b777'"),
        (("estimate", "fl.csv", "--aircraft", "b777", "--hold", "CM_ALPH=1"), "'Cm_alpha'"),
        (("estimate", "fl.csv", "--aircraft", "b777", "--states", "alhpa"), "'alpha'"),
        (("estimate", "fl.csv", "--aircraft", "b777", "--form", "dimensionl"), "'dimensional'"),
        (("estimate", "fl.csv", "--aircraft", "b777", "--inputs", "dee"), "'de'"),
        (("terms", "fl.csv", "--coefficient", "Cmm"), "'Cm'"),
        (("compatibility", "fl.csv", "--error", "q.scal"), "'q.scale'"),
        (("fly", "--out", "x", "--plan", "shrt"), "'short'"),
        (("fly", "--out", "x", "--hide", "aero.Cm.alfa2"), "'aero.Cm.alpha2'"),
        (("fly", "--out", "x", "--fault", "alhpa:stuck"), "'alpha'"),
        (("fly", "--out", "x", "--fault", "alpha:stukc"), "'stuck'"),
        (("fly", "--bench", "--to", "virtual", "--fault", "ruder:dead"), "'rudder'"),
        (("certificates", "b77"), "'b777'"),
        (("discrepancy", "fl.csv", "--out", "d", "--force", "aero.Cm.alfa2"), "'aero.Cm.alpha2'"),
        (("record", "seriel:/dev/x:57600", "--out", "x"), "'serial:/dev/x:57600'"),
    ],
)  # fmt: skip
def test_a_wrong_name_is_answered_with_the_one_that_was_meant(
    tmp_path: Path, call: tuple[str, ...], meant: str
) -> None:
    rows = "".join(f"{k / 50},{k % 7},{k % 5}\n" for k in range(200))
    (tmp_path / "fl.csv").write_text(f"time [s],alpha [deg],q [deg/s]\n{rows}")
    done = gsapp(*call, folder=tmp_path)
    assert meant in re.split("[Dd]id you mean", done.stderr)[-1], done.stderr
    assert "ou mean" in done.stderr
    assert done.returncode in {1, 2}
    assert [path.name for path in tmp_path.iterdir()] == ["fl.csv"]


def test_a_missing_flight_is_named_without_a_display(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    done = gsapp("replay", "absent", folder=tmp_path)
    assert done.returncode == 1
    assert "absent" in done.stderr
    assert "display" not in done.stderr


def test_help_is_as_wide_as_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    def widest(columns: int) -> int:
        monkeypatch.setenv("COLUMNS", str(columns))
        return max(map(len, gsapp("estimate", "--help").stdout.splitlines()))

    assert 120 < widest(140) <= 140
    assert widest(80) <= 80


@pytest.mark.parametrize("option", ["-V", "--version"])
def test_the_version_is_that_of_the_package(option: str) -> None:
    from importlib.metadata import version

    assert gsapp(option).stdout.strip() == version("gsapp-ground-station")


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("gsapp est", ["estimate"]),
        ("gsapp export --to ", ["csv", "mat", "parquet", "sidpac"]),
        ("gsapp replay --head", ["--headless"]),
    ],
)
def test_a_shell_completes_what_is_typed(typed: str, completed: list[str]) -> None:
    asked = {
        "_GSAPP_COMPLETE": "complete_bash",
        "COMP_WORDS": typed,
        "COMP_CWORD": str(len(typed.split(" ")) - 1),
    }
    done = subprocess.run(
        [sys.executable, "-m", "gsapp"], env={**os.environ, **asked}, capture_output=True,
        encoding="utf-8", timeout=240,
    )  # fmt: skip
    assert done.stdout.split() == completed


def test_completion_is_installed_for_a_shell(tmp_path: Path) -> None:
    # In the tests no shell calls the program that it could find.
    named = {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1", "HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-m", "gsapp", "--install-completion", "bash"],
        env={**os.environ, **named}, capture_output=True, encoding="utf-8", timeout=240,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (script,) = tmp_path.rglob("gsapp.sh")
    assert "_GSAPP_COMPLETE" in script.read_text()
    assert str(script) in (tmp_path / ".bashrc").read_text()


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("units") / "whole.csv"
    made = make_flight([Input(at=3.0, surface="de")], ground=0.0, seconds=12.0, steering=0.0)
    write_block(path, made.block, "csv", "us")
    return path


@pytest.mark.parametrize("system", ["US", "SI"])
@pytest.mark.parametrize(
    ("command", "options", "has_values"),
    [
        ("maneuvers", (), False),
        ("debrief", ("--aircraft", "b777"), False),
        ("estimate", ("--aircraft", "b777", "--method", "ee"), True),
        ("compatibility", ("--aircraft", "b777"), False),
        ("replay", ("--headless",), False),
        ("certificates", (), True),
    ],
)
def test_a_command_prints_in_the_units_asked_for(
    flight: Path, command: str, options: tuple[str, ...], has_values: bool, system: str
) -> None:
    subject = "b777" if command == "certificates" else flight.name
    done = gsapp(command, subject, *options, "--units", system, folder=flight.parent)
    assert done.returncode == 0, done.stderr
    own, foreign = (METRIC, CUSTOMARY) if system == "SI" else (CUSTOMARY, METRIC)
    said = done.stdout + done.stderr
    assert not foreign.search(said), foreign.search(said)
    assert not has_values or own.search(said)
    assert f"V [{'ft/s' if system == 'SI' else 'm/s'}]" not in said


@pytest.mark.parametrize(("system", "sheet"), [("US", "612 792"), ("SI", "595")])
def test_certificates_are_printed_on_the_paper_of_the_system(
    tmp_path: Path, system: str, sheet: str
) -> None:
    (tmp_path / "set").mkdir()
    shutil.copy(SHIPPED_CERTIFICATES_FOLDER / "b777" / "rudder.toml", tmp_path / "set")
    done = gsapp("certificates", "set", "--report", "pages", "--units", system, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "pages" / "rudder.pdf").read_bytes()
    assert f"/MediaBox [ 0 0 {sheet}".encode() in page
