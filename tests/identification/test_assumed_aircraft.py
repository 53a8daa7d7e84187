"""A flight of which nobody said what aircraft flew it."""

from pathlib import Path

import pytest

from gsapp.cli import maneuvers as maneuvers_command
from gsapp.flight.info import FlightInfo
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.flight.read_settings import assumed_aircraft_text
from gsapp.identification.maneuver import open_flights_with_maneuvers

CSV = "time [s],q [deg/s],de [deg]\n" + "".join(
    f"{0.01 * k:.2f},{0.1 * (k % 7):.1f},{2.0 if 200 < k < 240 else 0.0}\n" for k in range(600)
)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "glider.csv"
    path.write_text(CSV, encoding="utf-8")
    return path


def words_of(flight: Path, aircraft: str = "") -> list[str]:
    (flown,) = open_flights_with_maneuvers(
        [flight], ManeuverSettings(aircraft=aircraft, maneuver_windows=("1:5",))
    )
    return [one for one in flown.remarks if "no aircraft file" in one]


def test_what_is_taken_for_an_unnamed_aircraft_is_said(table: Path) -> None:
    (said,) = words_of(table)
    assert "'glider'" in said
    assert "B777" in said
    assert "--aircraft FILE" in said
    assert words_of(table, "b777") == []


def test_a_flight_card_that_names_the_shipped_aircraft_is_enough() -> None:
    assert assumed_aircraft_text("flight", FlightInfo(aircraft="B777")) == ""
    assert assumed_aircraft_text("flight", FlightInfo()) != ""


def test_maneuvers_are_found_with_the_same_words(
    table: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    maneuvers_command.run(flight=table)
    assert "no aircraft file" in capsys.readouterr().out
    maneuvers_command.run(flight=table, aircraft="b777")
    assert "no aircraft file" not in capsys.readouterr().out
