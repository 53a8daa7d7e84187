"""A prepared flight folder holds copies of all that its record is to be read with."""

from pathlib import Path

import pytest

from calibration import load_certificates
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.foundation import FileProblemsError, UnknownNameError
from gsapp.quantities import INSTRUMENTS


def test_copies_of_everything_in_force_are_made(tmp_path: Path) -> None:
    folder = prepare_flight_folder(
        tmp_path / "a", aircraft="b777", channel_map="b777", source="udpin:127.0.0.1:14550"
    )
    info = folder.info()
    assert (info.name, info.aircraft, info.channel_map) == ("a", "b777", "b777")
    assert info.source == "udpin:127.0.0.1:14550"
    assert set(load_certificates(folder.calibration_folder)) == set(INSTRUMENTS)
    aircraft = folder.aircraft()
    assert aircraft.name == "B777"


def test_a_flight_keeps_what_it_began_with(tmp_path: Path) -> None:
    first = prepare_flight_folder(tmp_path / "a", channel_map="b777", calibration="")
    before = first.channel_map_file.read_bytes()
    again = prepare_flight_folder(tmp_path / "a", aircraft="b777", channel_map="px4")
    assert again.channel_map_file.read_bytes() == before
    assert again.aircraft_file.exists()


def test_what_is_not_taken_is_told(tmp_path: Path) -> None:
    said: list[str] = []
    folder = tmp_path / "a"
    prepare_flight_folder(folder, aircraft="b777", channel_map="b777", tell=said.append)
    prepare_flight_folder(folder, aircraft="b777", channel_map="b777", tell=said.append)
    assert said == []
    own = tmp_path / "own.toml"
    own.write_text((folder / "aircraft.toml").read_text(encoding="utf-8") + "# mine\n")
    certificates = tmp_path / "set"
    certificates.mkdir()
    first = next(iter(sorted((folder / "calibration").iterdir())))
    (certificates / first.name).write_bytes(first.read_bytes())
    prepare_flight_folder(
        folder, aircraft=own, channel_map="px4", calibration=certificates, tell=said.append
    )
    assert len(said) == 3
    assert "'own' differs" in said[0]
    assert "'px4' differs" in said[1]
    assert "certificates" in said[2]


def test_nothing_is_made_when_a_file_holds_mistakes(tmp_path: Path) -> None:
    wrong = tmp_path / "aircraft.toml"
    wrong.write_text("[geometry]\nspan = '2 kg'\n")
    with pytest.raises(FileProblemsError, match=r"geometry\.span"):
        prepare_flight_folder(tmp_path / "a", aircraft=wrong, channel_map="b777")
    with pytest.raises(UnknownNameError, match="b777"):
        prepare_flight_folder(tmp_path / "a", channel_map="b778")
    assert not (tmp_path / "a").exists()
