"""The documentation tells the truth: examples load, commands parse, keys, effects and links exist.

Examples are fenced blocks whose info string names what they are: ``toml aircraft``.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import typer

from calibration import load_certificate, load_certificates
from gsapp.aircraft import Control, Limits, load_aircraft
from gsapp.aircraft.swings import compute_inertia, load_swings
from gsapp.cli.calibration_commands import calibrate
from gsapp.cli.main import app
from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.dynamics.model import load_model
from gsapp.excitation.alerts.geofence import load_geofence
from gsapp.flight.cards import load_cards
from gsapp.flight.events import EventLog, read_events
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.flown_aircraft import apply_flight_info
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info_checks import check_flight_info
from gsapp.flight.maneuvers import DetectedManeuver, ManeuverEditLog
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.identification.linear_models.linear_model_files import load_linear_model
from gsapp.identification.weights import load_weights
from gsapp.quantities.constants import GRAVITY
from gsapp.session.checklist import load_checklist
from gsapp.session.checklist.items import CHECKLIST_RULES
from gsapp.session.limits import load_limits
from gsapp.session.session_flight import find_session_setting
from gsapp.virtual.flight_plan import load_flight_plan

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
FILES = DOCS / "reference" / "files.md"
PAGES = sorted([ROOT / "README.md", *DOCS.rglob("*.md")])
_BLOCK = re.compile(r"^ *```(\w+)[ ]?([\w-]*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
_CHECKED = {
    "flight", "events", "flight-csv", "aircraft", "channel-map", "mixed-map", "servo-map",
    "text-map", "lines", "table-map", "table", "numbers-map", "raw-map", "certificate", "limits",
    "plan", "model", "layout", "weights", "swings", "linear-model", "cards", "checklist", "points",
    "fence", "calibration-plan",
}  # fmt: skip


def _blocks() -> dict[tuple[str, str], str]:
    found: dict[tuple[str, str], str] = {}
    for language, kind, text in _BLOCK.findall(FILES.read_text(encoding="utf-8")):
        if language == "sh":
            continue
        assert (language, kind) not in found, f"two examples of {language} {kind}"
        found[language, kind] = text
    return found


BLOCKS = _blocks()
Example = Callable[..., Path]
"""Writes an example to a file: language, kind, and the name if it matters."""


@pytest.fixture
def example(tmp_path: Path) -> Example:
    """Return a function that writes an example to a file."""

    def write(language: str, kind: str, name: str = "") -> Path:
        path = tmp_path / (name or f"{kind}.{language}")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(BLOCKS[language, kind], encoding="utf-8")
        return path

    return write


def test_every_example_is_of_a_kind_that_is_checked_here() -> None:
    assert {kind for _language, kind in BLOCKS} == _CHECKED


def test_the_aircraft_is_read_and_its_units_converted(example: Example) -> None:
    aircraft = load_aircraft(example("toml", "aircraft"))
    assert aircraft.geometry.wing_area == pytest.approx(11.33 * 0.3048**2)
    assert aircraft.controls.de.full_stick_high < 0.0
    assert aircraft.warnings() == ()


def test_the_channel_map_is_read(example: Example) -> None:
    found = load_channel_map(example("toml", "channel-map"))
    assert [entry.kind for entry in found.by_channel["q"]] == ["measured", "estimated"]
    assert found.by_channel["elevator_left"][0].volts_channel == "elevator_left_volts"


def test_the_map_of_a_v_tail_centers_its_servos(example: Example) -> None:
    """1500 us on both servos is no elevator and no rudder; full pulse on both is all elevator."""
    found = load_channel_map(example("toml", "mixed-map"))
    elevator, rudder = found.entries
    assert elevator.scale * 1500.0 + elevator.offset == pytest.approx(0.0)
    assert elevator.scale * 2000.0 + elevator.offset == pytest.approx(12.0)
    assert (elevator.scale, rudder.offset) == (rudder.scale, 0.0)


def test_pulses_of_servos_become_degrees(example: Example) -> None:
    elevator, aileron, rudder = load_channel_map(example("toml", "servo-map")).entries
    assert elevator.curve is not None
    assert elevator.curve.evaluate(np.array([1500.0]))[0] == pytest.approx(0.5)
    assert aileron.curve is not None
    assert aileron.curve.evaluate(np.array([1500.0]))[0] == pytest.approx(1.45)
    assert (rudder.unit, rudder.calibration) == ("us", "dr_command")


def test_lines_of_text_become_samples(example: Example) -> None:
    found = load_channel_map(example("toml", "text-map"))
    decoder = Decoder(found, rate=50.0)
    records = [
        RawRecord(1_000_000 + 20_000 * index, "line", line.encode())
        for index, line in enumerate(BLOCKS["text", "lines"].splitlines())
    ]
    blocks = [*decoder.feed(records), *decoder.finish()]
    alpha = np.concatenate([block["alpha"] for block in blocks if "alpha" in block.channels])
    assert np.degrees(alpha) == pytest.approx([2.5, 2.6, 2.4])
    assert blocks[0].times[0] == pytest.approx(1.0)


def test_a_table_of_another_program_is_read_with_its_map(example: Example) -> None:
    flight = load_flight(
        example("csv", "table"), channel_map=example("toml", "table-map"), rate=50.0
    )
    assert np.degrees(flight.block["alpha"]) == pytest.approx([2.0, 2.1, 2.2])
    assert flight.block["q"] == pytest.approx([0.01, 0.02, 0.03])


def test_a_file_of_numbers_is_read_by_the_places_of_its_columns(example: Example) -> None:
    path = example("toml", "numbers-map").with_name("flight.asc")
    path.write_text("0.0 0.1 1 1 1 1 1 0.7\n0.1 0.2 1 1 1 1 1 0.8\n", encoding="utf-8")
    flight = load_flight(path, channel_map=example("toml", "numbers-map"), rate=10.0)
    assert flight.block["de"] == pytest.approx([0.1, 0.2])
    assert flight.block["q"] == pytest.approx([0.7, 0.8])


def test_a_map_names_raw_fields(example: Example) -> None:
    decoder = Decoder(load_channel_map(example("toml", "raw-map")))
    assert {"q", "VIBRATION.clipping_2", "NAV_CONTROLLER_OUTPUT.nav_roll"} <= set(decoder.channels)


def test_the_flight_csv_is_read(example: Example) -> None:
    flight = load_flight(example("csv", "flight-csv"))
    assert flight.rate == pytest.approx(100.0)
    assert np.isnan(flight.block["an"][2])
    assert flight.block["V"][0] == pytest.approx(100.2 * 0.3048)


def test_the_certificate_is_read_and_agrees_with_its_points(example: Example) -> None:
    certificate = load_certificate(example("toml", "certificate"))
    volts = [point.volts for point in certificate.points]
    values = np.radians([point.value for point in certificate.points])
    worst = np.radians(certificate.max_residual) + 1e-9
    assert np.abs(certificate.evaluate(volts) - values).max() <= worst


def test_points_become_a_certificate(example: Example, tmp_path: Path) -> None:
    calibrate(
        points=example("csv", "points"), channel="rudder", out=tmp_path / "rudder.toml",
        travel="-30:30",
    )  # fmt: skip
    made = load_certificate(tmp_path / "rudder.toml")
    assert np.degrees(made.evaluate([2.5])) == pytest.approx([0.0], abs=0.05)
    assert made.hysteresis == pytest.approx(0.4, abs=0.05)


def test_limits_are_read(example: Example) -> None:
    rules = {rule.key: rule for rule in load_limits(example("toml", "limits")).rules()}
    assert set(rules) == {"battery:low", "alpha:high"}
    assert rules["battery:low"].warning == pytest.approx(10.5)


def test_weights_are_read_by_flight(example: Example) -> None:
    weights = load_weights(example("toml", "weights"))
    assert weights.for_flight("A")["an"] == pytest.approx(35 / 9.80665**2)
    assert weights.for_flight("Flight B")["alpha"] == 0.0


def test_swings_are_read_and_mean_something(example: Example) -> None:
    found = compute_inertia(load_swings(example("toml", "swings")))
    assert {"ixx", "izz"} == set(found.values)
    assert all(0.0 < one.std < 0.3 * one.value for one in found.values.values())


def test_the_linear_model_is_read(example: Example) -> None:
    model = load_linear_model(example("toml", "linear-model")).model()
    assert model.C[1, 1] == pytest.approx(57.3 * np.pi / 180.0)


def test_the_plan_is_read(example: Example) -> None:
    plan = load_flight_plan(example("toml", "plan"))
    assert [maneuver.inputs for maneuver in plan.maneuvers] == [("de",), ("da", "dr")]


def test_the_fence_is_read(example: Example) -> None:
    fence = load_geofence(example("toml", "fence"))
    assert fence.radius == pytest.approx(600.0)
    assert fence.latitude is not None
    assert fence.floor is not None


def test_the_test_cards_are_read(example: Example) -> None:
    cards = load_cards(example("toml", "cards"))
    assert [card.display_title for card in cards.cards] == [
        "Elevator doublet",
        "Aileron and rudder doublet",
    ]


def test_the_checklist_is_read_and_its_rules_are_all_told(example: Example) -> None:
    found = load_checklist(example("toml", "checklist"))
    assert [item.checked_by for item in found.items].count("hand") == 1
    table = FILES.read_text(encoding="utf-8").partition("| rule |")[2]
    told = re.findall(r"^\| `(\w+)` \|", table.partition("\n\n")[0], re.MULTILINE)
    kinds = {model.model_fields["kind"].annotation.__args__[0] for model in CHECKLIST_RULES}
    assert set(told) == kinds


def test_the_model_is_read(example: Example) -> None:
    model = load_model(example("toml", "model"))
    assert model.effects[0].parameters == {"Cm_alpha2": -2.0}


def test_the_layout_is_read(example: Example) -> None:
    layout_reader = pytest.importorskip("ui.strips.strip_layout")
    layout = layout_reader.load_layout(example("toml", "layout"))
    assert layout.channels == ("q", "alpha", "elevator_left", "elevator_right")


def test_the_examples_together_are_a_flight_folder(example: Example, tmp_path: Path) -> None:
    example("toml", "flight", "day/flight.toml")
    example("toml", "aircraft", "day/aircraft.toml")
    example("toml", "channel-map", "day/channel_map.toml")
    example("toml", "certificate", "day/calibration/rudder.toml")
    example("toml", "limits", "day/limits.toml")
    example("json", "events", "day/events.jsonl")
    folder = FlightFolder.open(tmp_path / "day")
    info = folder.info()
    assert info is not None
    assert info.takeoff_weight == pytest.approx(46.6 * 4.4482216, rel=1e-6)
    own = folder.aircraft()
    assert own is not None
    assert apply_flight_info(own, info).cg_shift[0] < 0.0
    assert check_flight_info(info, own) == ()
    setting = find_session_setting(folder.path)
    assert setting.channel_map is not None
    assert setting.channel_map.name == "my box"
    assert set(load_certificates(folder.calibration_folder)) == {"rudder"}
    assert {rule.key for rule in setting.limits} == {"battery:low", "alpha:high"}
    record = read_events(folder.path / "events.jsonl")
    assert record.damaged == 0
    assert [event.kind for event in record.events] == [
        "mark", "note", "card-choice", "vehicle", "verdict", "maneuver-edit", "maneuver-undo",
    ]  # fmt: skip
    changes = ManeuverEditLog(EventLog(folder.path / "events.jsonl"), [_found("3", 119.0, 124.16)])
    assert (
        changes.skipped_count,
        len(changes.maneuver_list.edits),
        len(changes.maneuver_list.undone),
    ) == (0, 0, 1)


def _found(name: str, start: float, stop: float) -> DetectedManeuver:
    return DetectedManeuver(
        id=name, t_start=start, t_end=stop, inputs=("de",), kind="doublet", amplitude=0.1, grade="A"
    )


def _commands() -> list[str]:
    found = {
        line: None
        for page in PAGES
        for language, _kind, text in _BLOCK.findall(page.read_text(encoding="utf-8"))
        for line in map(str.strip, text.splitlines())
        if language == "sh" and line.startswith("gsapp ")
    }
    return list(found)


@pytest.mark.parametrize("line", _commands())
def test_every_command_is_understood(line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    words = shlex.split(line, posix=os.name != "nt")
    group = typer.main.get_command(app)
    command = group.commands[words[1]]  # type: ignore[attr-defined]
    command.make_context(words[1], words[2:]).close()


def _wizard_keys() -> set[str]:
    """Return the keys that the page of the calibration takes for itself."""
    from PySide6.QtGui import QKeySequence

    from ui.preflight import wizard_page, wizard_text

    typed = {
        QKeySequence(key).toString()
        for key in (*wizard_page._FIT_ORDER_KEYS, *wizard_page._ARROW_STEPS)
    }
    start = wizard_text.build_start_actions(None, "", left=True, made=True)
    helper = {"H"}
    return (
        typed
        | helper
        | {offer.key for offer in start}
        | {o[2] for o in wizard_text._WIZARD_ACTIONS}
    )


_PAGES_WITH_COMMON_KEYS = (
    "keys.md", "keyboard-and-access.md", "fly-with-cues.md", "review-a-flight.md",
)  # fmt: skip
"""Pages that also name keys of every desktop program, of tables and of charts."""


def test_every_key_is_one_of_the_window() -> None:
    commands = pytest.importorskip("ui.commands")
    known = {key for command in commands.COMMANDS for key in command.shortcuts} | _wizard_keys()
    named = {
        key
        for page in PAGES
        if page.name not in _PAGES_WITH_COMMON_KEYS
        for key in re.findall(r"<kbd>(.+?)</kbd>", page.read_text(encoding="utf-8"))
    }
    assert named
    assert named <= known


def test_the_default_limits_are_those_of_the_code() -> None:
    """They raise alarms and grade maneuvers, though nobody wrote them."""
    text = " ".join(FILES.read_text(encoding="utf-8").split())
    usual, control = Limits(), Control()
    low, high = np.degrees(usual.alpha_linear)
    least, most = np.array(usual.load_factor) / GRAVITY
    for told in (
        f"`alpha_linear` {low:.0f} to {high:.0f} deg",
        f"`alpha_stall` {np.degrees(usual.alpha_stall):.0f} deg",
        f"`beta_linear` {np.degrees(usual.beta_linear):.0f} deg",
        f"`load_factor` {least:.0f} to {most:.0f} g",
        f"`bank` {np.degrees(usual.bank):.0f} deg",
        "travel {:.0f} to {:.0f} deg".format(*np.degrees(control.travel)),
        f"full stick {np.degrees(control.full_stick_high):.0f} deg "
        f"(low rate {np.degrees(control.full_stick_low):.0f} deg)",
    ):
        assert told in text, told
    assert usual.stall_speed == 0.0


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    text = _BLOCK.sub("", page.read_text(encoding="utf-8"))
    for target, fragment in re.findall(r"\]\(([^)#]*)(?:#([^)]*))?\)", text):
        if "://" in target:
            continue
        found = page.parent / target if target else page
        assert found.exists(), target
        assert not fragment or fragment in _anchors(found), f"{target}#{fragment}"


def _anchors(page: Path) -> set[str]:
    """Return the anchors that a web page makes of the headings."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings}


def test_every_decision_is_in_the_index() -> None:
    index = (DOCS / "decisions" / "README.md").read_text(encoding="utf-8")
    for page in DOCS.glob("decisions/0*.md"):
        title = page.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
        assert f"[{title}]({page.name})" in index
