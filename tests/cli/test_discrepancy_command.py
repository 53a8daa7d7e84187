"""``gsapp discrepancy``: what it prints and writes, and that nothing is left half written.

The search is replaced by a ready answer, but where it says so; tests/discrepancy holds the search.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gsapp.aircraft import load_aircraft
from gsapp.cli.main import app
from gsapp.discrepancy import flight_search
from gsapp.discrepancy.results import DiscrepancyResult
from gsapp.discrepancy.settings import DiscrepancySettings, SearchProgress
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import load_model
from gsapp.flight.writers import write_block
from gsapp.foundation import GroundStationError
from gsapp.identification.maneuver import Maneuver
from gsapp.session.review import open_reviewed_flight
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.report.discrepancy_kit import adequate, answer

WINDOWS = ("30:38", "40:45", "50:58", "63.5:68.5", "70:76")
"""Stretches of the flight, two of them doublets."""
Install = Callable[..., list["Asked"]]


class Asked:
    def __init__(self, maneuvers: Sequence[Maneuver], settings: DiscrepancySettings) -> None:
        self.maneuvers = maneuvers
        self.settings = settings


@pytest.fixture(scope="module")
def flight(
    tmp_path_factory: pytest.TempPathFactory, flown_short: Callable[[int], VirtualFlight]
) -> Path:
    path = tmp_path_factory.mktemp("flight") / "day.csv"
    write_block(path, flown_short(5).measured, "csv")
    return path


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch) -> Install:
    """Return a function that puts a ready answer, or an error, in place of the search."""

    def install(found: DiscrepancyResult | BaseException) -> list[Asked]:
        asked: list[Asked] = []

        class Ready:
            def __init__(self, maneuvers: Sequence[Maneuver], *_: object) -> None:
                self._maneuvers = maneuvers

            def run(
                self, settings: DiscrepancySettings, *, progress: Callable[[SearchProgress], object]
            ) -> DiscrepancyResult:
                progress(SearchProgress(share=0.5, activity="naming"))
                asked.append(Asked(self._maneuvers, settings))
                if isinstance(found, BaseException):
                    raise found
                return found

        monkeypatch.setattr(flight_search, "Investigation", Ready)
        return asked

    return install


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gsapp.report.document_writer.render_png", lambda _: b"\x89PNG")
    monkeypatch.setattr("gsapp.report.document_writer.render_pdf", lambda _, **__: b"%PDF")


def call(*arguments: object) -> tuple[int, str, BaseException | None]:
    done = CliRunner().invoke(app, ["discrepancy", *map(str, arguments)], env={"COLUMNS": "160"})
    return done.exit_code, " ".join(done.output.split()), done.exception


SMALL = answer(maneuvers=3, samples=40)


@pytest.mark.usefixtures("undrawn")
def test_the_story_is_told_and_everything_written(
    flight: Path, search: Install, tmp_path: Path
) -> None:
    """Four steps in order on the screen; model, report, figures and JSON in the folder."""
    asked = search(SMALL)
    out = tmp_path / "deep" / "answer"
    code, said, _ = call(flight, "--aircraft", "b777", "--model", "b777", "--out", out)
    assert code == 0, said
    places = [said.index(step) for step in ("1. Find", "2. Name", "3. Add", "4. Show")]
    assert places == sorted(places)
    for text in (
        "throttle above 70 %: the pitching moment (Cm) is off by 8.0 times the noise",
        "arm = 0.1617 ± 0.0069 ft; confidence 97 %",
        "weigh the aircraft on two scales",
        "Cm_q -23 -19.40 ± 0.60",
        "gusts of 1.0 ± 0.13 ft/s",
        "94 ± 3 % of the gap",
        "The model lacks a named effect.",
        "q was clipped",
    ):
        assert text in said, text
    asked_for = DiscrepancySettings(aircraft="b777", model="b777", check_instruments=True)
    assert asked[0].settings == asked_for
    assert [one.id for one in asked[0].maneuvers] == ["1", "2"]
    names = {path.name for path in out.iterdir()}
    assert names == {"model.toml", "report.html", "report.pdf", "figures", "discrepancy.json"}
    assert load_model(out / "model.toml") == SMALL.model
    content = json.loads((out / "discrepancy.json").read_text(encoding="utf-8"))
    assert content["model"] == str(out / "model.toml")
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "SHA-256" in report
    assert str(flight) in report
    assert [path for path in out.parent.iterdir() if path != out] == []


@pytest.mark.usefixtures("undrawn")
def test_options_reach_the_search(flight: Path, search: Install, tmp_path: Path) -> None:
    asked = search(adequate(maneuvers=3, samples=40))
    code, said, _ = call(
        flight, "--out", tmp_path / "a", "--refuse", "aero.Cm.speed", "--refuse",
        "unnamed.Cm.alpha_de2", "--force", "propulsion.Cm.throttle", "--held-out", "2",
        "--most-effects", "1", "--draw", "1", "--units", "si", "--maneuver", "40:45",
        "--maneuver", "63.5:68.5",
    )  # fmt: skip
    assert code == 0, said
    settings = asked[0].settings
    assert not settings.model
    assert settings.refused == ("aero.Cm.speed", "unnamed.Cm.alpha_de2")
    assert settings.forced == ("propulsion.Cm.throttle",)
    assert settings.held_out == ("2",)
    assert settings.most_effects == 1
    assert asked[0].maneuvers[0].t_start == pytest.approx(40.0)
    figures = [path.name for path in (tmp_path / "a" / "figures").iterdir()]
    assert any("overlay-1" in name for name in figures)
    assert not any("overlay-2" in name for name in figures)
    assert "[m/s]" in said


@pytest.mark.usefixtures("undrawn")
def test_maneuvers_corrected_by_hand_are_searched(
    flight: Path, search: Install, tmp_path: Path
) -> None:
    asked = search(SMALL)
    own = Path(shutil.copy(flight, tmp_path / "day.csv"))
    reviewed = open_reviewed_flight(own)
    first, second = reviewed.maneuvers
    reviewed.move(first.id, first.t_start + 0.5, first.t_end)
    reviewed.remove(second.id)
    out = tmp_path / "answer"
    assert call(own, "--out", out)[0] == 0
    (searched,) = asked[0].maneuvers
    assert searched.t_start == pytest.approx(first.t_start + 0.5)
    report = (out / "report.html").read_text(encoding="utf-8")
    assert f"{own}.events.jsonl" in report
    assert call(own, "--out", out, "--as-found")[0] == 0
    assert [one.id for one in asked[1].maneuvers] == [first.id, second.id]


@pytest.mark.usefixtures("undrawn")
def test_json_on_the_screen_stands_alone(flight: Path, search: Install, tmp_path: Path) -> None:
    search(SMALL)
    done = CliRunner().invoke(
        app, ["discrepancy", str(flight), "--out", str(tmp_path / "a"), "--json", "-"]
    )
    assert done.exit_code == 0
    content = json.loads(done.stdout)
    assert content == json.loads((tmp_path / "a" / "discrepancy.json").read_text(encoding="utf-8"))
    assert "4. Show" in done.stderr


@pytest.mark.usefixtures("undrawn")
def test_a_second_run_replaces_its_own_files_only(
    flight: Path, search: Install, tmp_path: Path
) -> None:
    out = tmp_path / "answer"
    search(SMALL)
    assert call(flight, "--out", out)[0] == 0
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    search(adequate(maneuvers=3, samples=40))
    assert call(flight, "--out", out)[0] == 0
    assert (out / "notes.txt").read_text(encoding="utf-8") == "mine"
    assert not list((out / "figures").glob("*ranking*"))
    assert json.loads((out / "discrepancy.json").read_text())["verdict"] == "model-adequate"
    assert [path.name for path in tmp_path.iterdir()] == ["answer"]


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), GroundStationError("too few maneuvers")])
def test_what_stops_the_search_leaves_nothing(
    flight: Path, search: Install, tmp_path: Path, stop: BaseException
) -> None:
    search(stop)
    code, _, _ = call(flight, "--out", tmp_path / "answer", "--json", tmp_path / "a.json")
    assert code != 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_the_real_search_from_flight_to_model(flight: Path, tmp_path: Path) -> None:
    """Nothing replaced: fixed keys, numbers that are finite or null, a model that flies at once."""
    named = [word for window in WINDOWS for word in ("--maneuver", window)]
    out = tmp_path / "answer"
    code, said, _ = call(
        flight, "--aircraft", "b777", "--model", "b777", "--out", out, *named,
        "--force", "propulsion.Cm.throttle", "--held-out", "2", "--most-effects", "0",
    )  # fmt: skip
    assert code == 0, said
    content = json.loads((out / "discrepancy.json").read_text(encoding="utf-8"))
    (effect,) = content["effects"]
    assert effect["effect"] == "propulsion.Cm.throttle"
    assert effect["forced"] is True
    # The flight has no such effect: what was forced in comes out as nothing, within its bounds.
    arm = effect["parameters"]["arm"]
    assert abs(arm["value"]) < 5.0 * arm["std"] + 0.005
    assert content["gap"]["on"] == ["2"]
    assert content["warnings"]
    model = load_model(out / "model.toml")
    assert [one.id for one in model.effects] == ["propulsion.Cm.throttle"]
    assert model.parent
    assert "propulsion.Cm.throttle" in model.evidence
    FlightModel(load_aircraft("b777"), model)


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals there")
def test_ctrl_c_in_the_midst_of_a_search(flight: Path, tmp_path: Path) -> None:
    """The real search in a terminal: share, time left and what it does are shown, then it stops."""
    import pty

    named = [word for window in WINDOWS for word in ("--maneuver", window)]
    # Effects to try make the search last, on the quickest machine, until it is stopped.
    forced = ("aero.Cm.alpha2", "aero.CN.alpha2", "aero.CA.alpha2", "aero.Cm.alphadot")
    named += [word for effect in forced for word in ("--force", effect)]
    terminal, end = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "gsapp.cli", "discrepancy", str(flight), "--out", "answer", *named],
        cwd=tmp_path, stdin=end, stdout=end, stderr=end, start_new_session=True,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "120"},
        # The tests themselves may run where Ctrl-C is ignored: in the background of a script.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509 - no locks
    )  # fmt: skip
    os.close(end)
    shown = ""
    try:
        while not re.search(r"fitting the current model.* [1-9]\d?%.*\d:\d\d", shown):
            shown += os.read(terminal, 4096).decode(errors="replace")
        process.send_signal(signal.SIGINT)
        while True:
            shown += os.read(terminal, 4096).decode(errors="replace")
    except OSError:  # the other end was closed: it ended
        pass
    finally:
        os.close(terminal)
    assert process.wait(timeout=120) == 130, shown
    assert "Traceback" not in shown
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("undrawn")
def test_what_stops_the_writing_leaves_the_former_answer(
    flight: Path, search: Install, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "answer"
    search(SMALL)
    assert call(flight, "--out", out)[0] == 0
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("gsapp.report.discrepancy_folder.write_discrepancy_report", full)
    search(adequate(maneuvers=3, samples=40))
    code, _, error = call(flight, "--out", out)
    assert code == 1
    assert isinstance(error, OSError)
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["answer"]


def test_the_wrong_call_is_told_from_the_failed_one(tmp_path: Path) -> None:
    code, said, _ = call("--out", tmp_path / "a")
    assert code == 2
    assert "--list" in said


def test_the_catalog_is_listed(tmp_path: Path) -> None:
    code, said, _ = call("--catalog")
    assert code == 0
    assert "propulsion.Cm.throttle" in said
    assert call("--catalog", "--json", tmp_path / "effects.json")[0] == 0
    assert json.loads((tmp_path / "effects.json").read_text(encoding="utf-8"))
