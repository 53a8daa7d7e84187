"""Text files with numbers of thousands of digits, brackets without end, and what is no number."""

import json
import re
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import calibration
from calibration.certificate_toml import load_certificate
from calibration.plan import CALIBRATION_PLANS, load_calibration_plan
from calibration.wizard.journal import Journal
from gsapp.aircraft import load_aircraft
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.aircraft.swings import compute_inertia, load_swings
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS, load_channel_map
from gsapp.dynamics.model import SHIPPED_MODELS, load_model
from gsapp.excitation.alerts.geofence import load_geofence
from gsapp.flight.cards import load_cards
from gsapp.flight.cards.card import SHIPPED_CARDS
from gsapp.flight.catalog import Catalog, list_flights, search_maneuvers
from gsapp.flight.events import read_events
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import FileProblemsError, GroundStationError
from gsapp.identification.linear_models.linear_model_files import (
    SHIPPED_LINEAR_MODELS,
    load_linear_model,
)
from gsapp.identification.weights import SHIPPED_WEIGHTS, load_weights
from gsapp.session.checklist.items import load_checklist
from gsapp.session.limits import load_limits
from gsapp.virtual.flight_plan import SHIPPED_PLANS, load_flight_plan
from ui.settings import SettingsStore
from ui.strips.strip_layout import load_layout

CERTIFICATES = Path(calibration.__file__).parent / "files" / "b777"
GOOD_LINES = '# 1\nname = """a\n[b]"""\nitems = [\n  1, # ]\n]\n'
ODD_LINE = 7
ODD = {
    "digits": GOOD_LINES + "x = " + "9" * 5000,
    "hexadecimal digits": GOOD_LINES + "x = 0x" + "F" * 5000,
    "brackets": GOOD_LINES + "x = " + "[" * 5000,
    "tables": GOOD_LINES + "x = " + "{a=" * 5000,
    "no value": GOOD_LINES + "x = ",
    "open list": GOOD_LINES + "x = [1,\n\n",
    "open string": GOOD_LINES + "x = '''a\n\nb = 1\n",
    "bytes": GOOD_LINES + "x = '\ud800'",
}


def open_card(path: Path) -> object:
    path.rename(path.with_name("flight.toml"))
    return FlightFolder.open(path.parent).update_info(notes="windy")


LOADERS: dict[str, Callable[[Path], object]] = {
    "aircraft": load_aircraft,
    "calibration plan": load_calibration_plan,
    "cards": load_cards,
    "certificate": load_certificate,
    "channel map": load_channel_map,
    "checklist": load_checklist,
    "fence": load_geofence,
    "flight card": open_card,
    "layout": load_layout,
    "limits": load_limits,
    "linear model": load_linear_model,
    "model": load_model,
    "plan": load_flight_plan,
    "swings": load_swings,
    "weights": load_weights,
}


@pytest.mark.parametrize("text", ODD.values(), ids=ODD)
@pytest.mark.parametrize("load", LOADERS.values(), ids=LOADERS)
def test_a_file_that_no_parser_takes_is_refused(
    tmp_path: Path, load: Callable[[Path], object], text: str
) -> None:
    path = tmp_path / "odd.toml"
    path.write_text(text + "\n# end", encoding="utf-8", errors="surrogatepass")
    with pytest.raises(FileProblemsError) as caught:
        load(path)
    assert caught.value.path.name in ("odd.toml", "flight.toml")
    (problem,) = caught.value.problems
    assert problem.remedy
    assert re.match(rf"line {ODD_LINE}\b", str(problem))


@pytest.mark.parametrize(
    ("load", "shipped", "good", "bad"),
    [
        (load_aircraft, SHIPPED_AIRCRAFT.find("b777"), "wing_area = ", "wing_are = "),
        (load_cards, SHIPPED_CARDS.find("b777"), "amplitude = ", "amplitude = true # "),
        (load_weights, SHIPPED_WEIGHTS.find("table-6.2.7"), "q = ", "q = [] # "),
        (
            load_linear_model,
            SHIPPED_LINEAR_MODELS.find("seanor-ml-lateral"),
            "A = [",
            "A = [[[1]],",
        ),
        (load_channel_map, SHIPPED_CHANNEL_MAPS.find("b777"), "unit = ", "unit = 'furlong' # "),
        (load_calibration_plan, CALIBRATION_PLANS.find("b777"), "unit = ", "unit = 'furlong' # "),
        (
            load_certificate,
            CERTIFICATES / "alpha.toml",
            "coefficients = [",
            "coefficients = ['1 ft',",
        ),
        (load_model, SHIPPED_MODELS.find("b777"), "Cm_alpha = ", "Cm_alpha = [1] # "),
    ],
)
def test_a_wrong_value_is_named_with_its_line(
    tmp_path: Path, load: Callable[[Path], object], shipped: Path, good: str, bad: str
) -> None:
    before, found, after = shipped.read_text(encoding="utf-8").partition(good)
    assert found
    path = tmp_path / "odd.toml"
    path.write_text(before + bad + after, encoding="utf-8")
    with pytest.raises(FileProblemsError) as caught:
        load(path)
    line = before.count("\n") + 1
    assert any(one.line == line and one.remedy for one in caught.value.problems)


@pytest.mark.parametrize("text", ODD.values(), ids=ODD)
def test_settings_that_no_parser_takes_are_kept_beside(tmp_path: Path, text: str) -> None:
    path = tmp_path / "settings.toml"
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    store = SettingsStore(path)
    assert re.search(rf"\bline {ODD_LINE}\b", store.error_text)
    assert (tmp_path / "settings.damaged.toml").exists()
    assert store.change(scale=150).scale == 150


def test_a_setting_of_a_wrong_type_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "settings.toml"
    path.write_text("units = 'SI'\n\nscale = [\n'big']\n")
    store = SettingsStore(path)
    assert store.current.units == "SI"
    assert "scale (line 3)" in store.error_text


@pytest.mark.parametrize("line", ["[" * 100_000, "9" * 5000, '{"a":' * 5000])
def test_lines_that_no_parser_takes_are_damaged(tmp_path: Path, line: str) -> None:
    path = tmp_path / "x.jsonl"
    path.write_text(f"{line}\n")
    assert read_events(path).damaged == 1
    assert Journal(path).read() == ()


LINEAR: dict[str, Any] = {
    "name": "x", "states": ["alpha [rad]"], "inputs": ["de [rad]"], "outputs": ["alpha [rad]"],
    "A": [[-1.0]], "B": [[1.0]], "C": [[1.0]], "D": [[0.0]],
}  # fmt: skip


@pytest.mark.parametrize(
    "number", ["nan", "inf", "-inf", "1e999", "1e300", '"one"', "9" * 400, "[1.0]"]
)
def test_a_linear_model_holds_finite_numbers(tmp_path: Path, number: str) -> None:
    path = tmp_path / "model.toml"
    lines = [f"{key} = {json.dumps(value)}" for key, value in LINEAR.items()]
    path.write_text("\n".join(lines))
    assert load_linear_model(path).A == ((-1.0,),)
    path.write_text("\n".join(lines).replace("-1.0", number))
    with pytest.raises(GroundStationError, match=r"A\b"):
        load_linear_model(path)


CHANGES = {
    "amplitude of a card": (load_cards, SHIPPED_CARDS.find("b777"), 'amplitude = "4.5 deg"'),
    "throttle of a plan": (load_flight_plan, SHIPPED_PLANS.find("short"), "throttle = 1.0"),
    "leg of a plan": (load_flight_plan, SHIPPED_PLANS.find("short"), 'leg = "8 s"'),
    "a weight": (load_weights, SHIPPED_WEIGHTS.find("table-6.2.7"), "q = 8"),
}
WRONG = (
    "nan", "inf", "1e999", "1e300", '"nan deg"', '"1e999 s"', '"1e300 s"', "[[1]]", "{}", "true",
    "9" * 400, '"one"',
)  # fmt: skip


@pytest.mark.parametrize("number", WRONG)
@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_number_that_is_none_is_refused(
    tmp_path: Path, change: tuple[Callable[[Path], object], Path, str], number: str
) -> None:
    load, shipped, good = change
    text = shipped.read_text(encoding="utf-8")
    assert good in text
    path = tmp_path / "odd.toml"
    path.write_text(text, encoding="utf-8")
    load(path)
    path.write_text(text.replace(good, f"{good.partition(' =')[0]} = {number}", 1))
    with pytest.raises(GroundStationError, match=r"odd\.toml") as caught:
        load(path)
    assert len(str(caught.value)) < 1000


SWINGS = """
[aircraft]
weight = "46.7 lb"
depth = "1.6 ft"
[x]
times = ["{time}"]
cycles = {cycles}
pivot_to_cg = "{arm}"
"""


@pytest.mark.parametrize(
    ("time", "cycles", "arm"),
    [
        ("1e300 s", "10", "4.9 ft"),
        ("1e-320 s", "10", "4.9 ft"),
        ("25 s", "10", "1e300 ft"),
        ("25 s", "9" * 400, "4.9 ft"),
    ],
)
def test_swings_beyond_any_pendulum_are_refused(
    tmp_path: Path, time: str, cycles: str, arm: str
) -> None:
    path = tmp_path / "swings.toml"
    path.write_text(SWINGS.format(time=time, cycles=cycles, arm=arm))
    with pytest.raises(GroundStationError):
        compute_inertia(load_swings(path))


def test_a_catalog_whose_schema_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "campaign.sqlite"
    with Catalog(path) as opened:
        assert search_maneuvers(opened) == ()
    data = path.read_bytes()
    assert data.count(b"t_start")
    path.write_bytes(data.replace(b"t_start", b"t_\xff\xfe\xfft"))
    with pytest.raises(GroundStationError, match=re.escape(str(path))), Catalog(path) as opened:
        search_maneuvers(opened)


@pytest.mark.parametrize(
    "change",
    [
        "INSERT INTO flights (name) VALUES (cast(x'ff41fe' AS text))",
        "ALTER TABLE flights RENAME COLUMN date TO day",
        "ALTER TABLE flights RENAME TO old; CREATE VIEW flights AS WITH RECURSIVE n(x) AS "
        "(SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x AS name, x AS date FROM n",
        "CREATE TRIGGER t AFTER INSERT ON flights BEGIN SELECT 1; END",
    ],
)
def test_a_catalog_that_another_program_changed(tmp_path: Path, change: str) -> None:
    path = tmp_path / "campaign.sqlite"
    Catalog(path).close()
    connection = sqlite3.connect(path)
    connection.executescript(change)
    connection.close()
    with pytest.raises(GroundStationError, match="is damaged"), Catalog(path) as opened:
        list_flights(opened)


@pytest.mark.parametrize("number", ["9" * 400, "1e999", "-Infinity", "NaN", "1e300"])
@pytest.mark.parametrize("key", ["time", "host_time_us"])
def test_an_event_at_no_time_is_damaged(tmp_path: Path, key: str, number: str) -> None:
    path = tmp_path / "events.jsonl"
    path.write_text(f'{{"kind": "mark", "{key}": {number}}}\n{{"kind": "mark", "time": 1}}\n')
    read = read_events(path)
    assert (read.damaged, [event.time for event in read.events]) == (1, [1.0])
