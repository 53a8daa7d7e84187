"""Card and test cards while they are filled in, and the folders that are prepared with them."""

from pathlib import Path

import pytest

from calibration import load_certificates
from gsapp.flight.cards import load_cards
from gsapp.flight.events import Event, read_events
from gsapp.flight.folder import FlightFolder
from gsapp.flight.folder_setup import apply_draft, prepare_flight_folder
from gsapp.flight.info import FlightInfo
from gsapp.flight.toml_document import CardSetFile, FlightInfoFile
from gsapp.foundation import FileProblemsError, FlightError, UnknownNameError
from gsapp.quantities import INSTRUMENTS

PILOT, WEIGHT = ("crew", "pilot"), ("takeoff_weight",)


def card(folder: Path) -> FlightInfoFile:
    return FlightInfoFile(FlightFolder(path=folder))


def test_a_card_is_changed_saved_and_read_by_others(tmp_path: Path) -> None:
    """Values stand as typed; tables that become empty go; what another program wrote is seen."""
    file = card(tmp_path / "next")
    file.change({PILOT: "Ann", WEIGHT: "46.5 lb", ("weather", "temperature"): "20 degC"})
    assert not file.is_saved
    assert file.model.takeoff_weight == pytest.approx(46.5 * 4.4482216152605)
    file.save()
    assert file.is_saved
    assert 'takeoff_weight = "46.5 lb"' in file.path.read_text(encoding="utf-8")
    other = card(tmp_path / "next")
    assert other.value(PILOT) == "Ann"
    other.change({("weather", "temperature"): None})
    other.save()
    assert "weather" not in other.path.read_text(encoding="utf-8")
    assert file.reload_if_changed()
    assert file.model.weather.temperature is None
    assert not file.reload_if_changed()


def test_a_mistake_leaves_the_card_as_it_was(tmp_path: Path) -> None:
    file = card(tmp_path)
    file.change({WEIGHT: "46.5 lb"})
    before = file.content
    with pytest.raises(FileProblemsError, match="takeoff_weight"):
        file.change({WEIGHT: "46.5 ft"})
    assert file.content is before


def test_comments_of_people_stay_when_a_value_changes(tmp_path: Path) -> None:
    path = tmp_path / "flight.toml"
    path.write_text('# weighed twice\ntakeoff_weight = "46.5 lb"\n', encoding="utf-8")
    file = card(tmp_path)
    file.change({("fuel",): "2.7 lb"})
    file.save()
    assert path.read_text(encoding="utf-8").startswith("# weighed twice")
    assert FlightFolder(path=tmp_path).info().fuel == pytest.approx(2.7 * 0.45359237)


def test_a_disk_that_refuses_keeps_the_change_in_memory(tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.write_text("a file where the folder should be", encoding="utf-8")
    file = card(taken)
    file.change({PILOT: "Ann"})
    with pytest.raises(FlightError):
        file.save()
    assert not file.is_saved
    taken.unlink()
    file.save()
    assert card(taken).value(PILOT) == "Ann"


def test_cards_begin_as_shipped_and_keep_the_units_they_were_typed_in(tmp_path: Path) -> None:
    path = tmp_path / "cards.toml"
    file = CardSetFile(path, "b777")
    assert not path.exists()
    first = str(file.value(("cards", "0", "id")))
    file.change({("cards", "0", "speed"): "62 kt"})
    file.change({("cards",): file.with_duplicated_row(0)})
    file.save()
    assert path.read_text(encoding="utf-8").count('speed = "62 kt"') == 2
    read = load_cards(path)
    assert read.cards[0].id == first
    # The copy has an id that no other has.
    assert len({one.id for one in read.cards}) == len(read.cards)
    with pytest.raises(FileProblemsError, match="two cards"):
        file.change({("cards", "1", "id"): first})
    with pytest.raises(FileProblemsError, match="speed"):
        file.change({("cards", "0", "speed"): None})


def waiting_flight(folder: Path) -> None:
    file = card(folder)
    file.change({("name",): "Flight 7", PILOT: "Ann", WEIGHT: "46.5 lb", ("notes",): "windy"})
    file.change({("airframe",): "SN 3"})
    file.save()
    FlightFolder(path=folder).events.append(Event(kind="checklist-tick", text="fuel"))
    plan = CardSetFile(folder / "cards.toml", "b777")
    plan.change({("name",): "Monday"})
    plan.save()


def test_what_waits_goes_into_the_flight_and_the_next_begins(tmp_path: Path) -> None:
    waiting = tmp_path / "next"
    waiting_flight(waiting)
    folder = FlightFolder.create(tmp_path / "2026-05-12 flight 1", FlightInfo(source="udpin:x:1"))
    assert apply_draft(waiting, folder)
    info = folder.info()
    assert (info.name, info.crew, info.source) == ("Flight 7", {"pilot": "Ann"}, "udpin:x:1")
    assert info.notes == "windy"
    assert info.date is not None
    assert [event.text for event in read_events(folder.events.path).events] == ["fuel"]
    assert load_cards(folder.cards_file).name == "Monday"
    left = card(waiting)
    assert dict(left.content) == {"airframe": "SN 3", "crew": {"pilot": "Ann"}}
    assert info.airframe == "SN 3"
    assert not read_events(waiting / "events.jsonl").events
    assert load_cards(waiting / "cards.toml").name == "Monday"


def test_a_trial_gets_a_copy_and_a_flight_under_way_gets_nothing(tmp_path: Path) -> None:
    waiting = tmp_path / "next"
    waiting_flight(waiting)
    trial = FlightFolder.create(tmp_path / "trial")
    assert apply_draft(waiting, trial, keep=True)
    assert trial.info().notes == card(waiting).model.notes == "windy"
    begun = FlightFolder.create(tmp_path / "begun")
    begun.tlog_file.write_bytes(b"frame")
    assert not apply_draft(waiting, begun)
    assert begun.info().notes == ""
    assert not apply_draft(tmp_path / "nothing", trial)


def test_what_the_folder_knows_already_stays(tmp_path: Path) -> None:
    waiting = tmp_path / "next"
    waiting_flight(waiting)
    folder = FlightFolder.create(tmp_path / "flight", FlightInfo(name="Named", notes="calm"))
    apply_draft(waiting, folder)
    assert (folder.info().name, folder.info().notes) == ("Named", "calm")


def test_a_damaged_card_is_told_and_nothing_is_lost(tmp_path: Path) -> None:
    waiting = tmp_path / "next"
    waiting_flight(waiting)
    (waiting / "flight.toml").write_text("notes = ", encoding="utf-8")
    folder = FlightFolder.create(tmp_path / "flight")
    with pytest.raises(FileProblemsError, match="not valid TOML"):
        apply_draft(waiting, folder)
    assert read_events(waiting / "events.jsonl").events


def test_a_flight_for_trial_takes_the_card_but_not_the_name(tmp_path: Path) -> None:
    waiting = card(tmp_path / "next")
    waiting.change({("name",): "Maiden flight", PILOT: "Ann"})
    waiting.save()
    trial = FlightFolder.create(tmp_path / "trial A", FlightInfo(source="udpin:x:1"))
    assert apply_draft(tmp_path / "next", trial, keep=True, named=False)
    assert trial.name == "trial A"
    assert trial.info().crew == {"pilot": "Ann"}
    flight = FlightFolder.create(tmp_path / "flight A", FlightInfo(source="udpin:x:1"))
    apply_draft(tmp_path / "next", flight)
    assert flight.name == "Maiden flight"


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
