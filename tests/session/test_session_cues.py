"""Cues of a session: live, in two windows and in the replay the same; kept once; as alarms."""

import contextlib
import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft import Aircraft
from gsapp.cli.replay import replay
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.trim.trim_monitor import TrimMonitor
from gsapp.flight.cards import CardSet
from gsapp.flight.certificates import AppliedCertificates
from gsapp.flight.events import read_events
from gsapp.flight.folder import FlightFolder
from gsapp.quantities import Block
from gsapp.session import UNLIMITED_SPEED, Session, Severity
from gsapp.session.cue_monitor import VERDICT_EVENT
from gsapp.session.flight_metadata import FlightMetadata
from gsapp.session.replay_runner import run_replay
from tests.excitation.cue_kit import AIRCRAFT, CARDS, Record, card, flown

_UNMODELED = AIRCRAFT.model_copy(update={"name": "its sister"})
"""No model is shipped for it: nothing is looked ahead, which takes most of the time."""
_TWO = CardSet(cards=(card("E1"), card("E2", speed=85.0)))


def folder_with(tmp_path: Path, cards: CardSet | None = CARDS) -> FlightFolder:
    folder = FlightFolder.create(tmp_path / "flight")
    if cards is not None:
        folder.store_cards(cards)
    return folder


@contextlib.contextmanager
def opened(session: Session) -> Iterator[Session]:
    try:
        yield session
    finally:
        session.close()


def follow(folder: FlightFolder, aircraft: Aircraft = AIRCRAFT) -> Session:
    return Session.follow(folder.path, channel_map="b777", aircraft=aircraft)


def replayed(folder: FlightFolder, aircraft: Aircraft = AIRCRAFT, **options: object) -> Session:
    session = Session.replay(
        folder.path, channel_map="b777", aircraft=aircraft, speed=UNLIMITED_SPEED, **options
    )
    run_replay(session)
    return session


def told(session: Session) -> tuple[object, ...]:
    debrief = session.crew_cues.debrief()
    return json.dumps([debrief.to_json(), debrief.cues_json()]), debrief.cards


def verdicts_kept(folder: FlightFolder) -> list[tuple[str, object]]:
    events = read_events(folder.path / "events.jsonl").events
    return [(event.text, event.data["id"]) for event in events if event.kind == VERDICT_EVENT]


def test_two_live_windows_and_the_replay_tell_the_same_and_keep_it_once(tmp_path: Path) -> None:
    """One window looks all the time, one now and then; the verdict is in the record once."""
    folder = folder_with(tmp_path)
    record = Record(folder.path, flown())
    with opened(follow(folder)) as steady, opened(follow(folder)) as seldom:
        looks = 0
        while record.write(33):
            steady.update(0.5)
            looks += 1
            if looks % 10 == 0:
                seldom.update(0.5)
        record.close()
        for session in (steady, seldom):
            session.update(5.0)
            session.finish()
        assert told(steady) == told(seldom)
        assert verdicts_kept(folder) == [("good", "M1")]
        cues = steady.cues
        assert (cues.verdict.card, cues.good_repeats, cues.requested_repeats) == ("E1", 1, 2)
        assert [one.text for one in steady.crew_cues.spoken] == [
            one.text for one in seldom.crew_cues.spoken
        ]
        with opened(replayed(folder)) as again:
            assert told(again) == told(steady)
            assert again.crew_cues.spoken == steady.crew_cues.spoken
            assert again.alarm_registry.onsets == steady.alarm_registry.onsets
            assert again.alarm_registry.onsets == seldom.alarm_registry.onsets
    assert verdicts_kept(folder) == [("good", "M1")]


def test_a_card_chosen_in_flight_is_kept_and_counts_in_the_replay(tmp_path: Path) -> None:
    folder = folder_with(tmp_path, _TWO)
    record = Record(folder.path, flown())
    with opened(follow(folder, _UNMODELED)) as live:
        record.write(700)
        live.update(5.0)
        live.crew_cues.select_card("E2")
        record.write()
        record.close()
        live.update(5.0)
        live.finish()
        cues = live.cues
        assert (cues.card.card.id, cues.card.reason) == ("E2", "chosen")
        with opened(replayed(folder, _UNMODELED)) as again:
            assert told(again) == told(live)
    kept = read_events(folder.path / "events.jsonl").events
    assert [event.data["card"] for event in kept if event.kind == "card-choice"] == ["E2"]


def test_a_danger_is_an_alarm_and_said_until_it_is_over(tmp_path: Path) -> None:
    block = flown()
    values = block.values.copy()
    values[600:, block.channels.index("alpha")] = values[600, block.channels.index("alpha")]
    folder = folder_with(tmp_path)
    record = Record(folder.path, Block(channels=block.channels, times=block.times, values=values))
    record.write()
    record.close()
    with opened(replayed(folder, _UNMODELED)) as session:
        cues = session.cues
        stuck = [danger for danger in cues.alerts if "alpha" in danger.channels]
        assert stuck
        assert any(text.startswith("ignored: ") for text in cues.limitations)
        alarm = session.alarm_registry.get(f"danger:{stuck[0].key}")
        assert alarm.active
        assert alarm.message == stuck[0].text
        assert stuck[0].spoken_text.split(" ")[0] in " ".join(
            one.text for one in session.crew_cues.spoken
        )


def test_bad_cards_do_not_keep_a_flight_from_being_watched(tmp_path: Path) -> None:
    folder = folder_with(tmp_path, None)
    folder.cards_file.write_text('[[cards]]\nid = "E1"\nspeed = "100 fps"\n')
    record = Record(folder.path, flown())
    record.write(300)
    record.close()
    with opened(replayed(folder)) as session:
        assert session.crew_cues.cards is None
        (said,) = (text for text in session.remarks if "test cards are not used" in text)
        assert "cards.toml" in said
        assert session.cues.trim is not None


def test_cards_of_a_live_flight_are_kept_if_it_had_none(tmp_path: Path) -> None:
    folder = folder_with(tmp_path, None)
    Record(folder.path, flown()).close()
    with opened(replayed(folder)) as session:
        session.crew_cues.set_cards(CARDS)
        assert session.crew_cues.cards == CARDS
        assert not folder.cards_file.exists()
    with opened(follow(folder)) as session:
        session.crew_cues.set_cards(CARDS)
        session.crew_cues.set_cards(_TWO)
        assert session.crew_cues.cards == _TWO
    assert folder.cards() == CARDS


def test_cues_can_be_switched_off(tmp_path: Path) -> None:
    folder = folder_with(tmp_path)
    record = Record(folder.path, flown())
    record.write(300)
    record.close()
    with opened(replayed(folder, cues=False)) as session:
        assert session.cues is None
        assert session.crew_cues.debrief() is None
        assert session.crew_cues.spoken == ()
        assert session.crew_cues.cards is None
        session.crew_cues.select_card("E1")
        session.crew_cues.set_cards(CARDS)


def test_trouble_with_the_equipment_is_said_once_and_stands_among_the_dangers(
    tmp_path: Path,
) -> None:
    """The link falls silent in flight: heard once, shown until it is back; a milder one is last."""
    folder = folder_with(tmp_path)
    record = Record(folder.path, flown())
    record.write(300)
    record.close()
    with opened(follow(folder)) as session:
        session.update(5.0)
        watch = session.cue_monitor
        session.alarm_registry.raise_("link", Severity.WARNING, 2.5, "the aircraft is silent")
        session.alarm_registry.raise_("disk", Severity.CAUTION, 2.0, "the disk has 300 MB left")
        for _ in range(3):
            watch.check_equipment()
        assert [danger.key for danger in session.cues.alerts] == ["link", "disk"]
        said = [one for one in session.crew_cues.spoken if one.tone in ("warning", "caution")]
        assert [(one.text, one.priority) for one in said] == [
            ("telemetry lost", "warning"), ("disk nearly full", "prompt"),
        ]  # fmt: skip
        session.alarm_registry.clear("link")
        watch.check_equipment()
        assert [danger.key for danger in session.cues.alerts] == ["disk"]
        session.alarm_registry.raise_("link", Severity.WARNING, 9.0, "the aircraft is silent")
        watch.check_equipment()
        assert session.crew_cues.spoken[-1].text == "telemetry lost"


def test_what_the_page_asks_for_costs_no_work_on_files(tmp_path: Path) -> None:
    folder = folder_with(tmp_path)
    record = Record(folder.path, flown())
    record.write(300)
    record.close()
    with opened(replayed(folder)) as session:
        shutil.rmtree(folder.path)
        for _ in range(5):
            assert session.cues is not None
            assert session.crew_cues.cards == CARDS
            assert session.crew_cues.debrief() is not None


def test_a_fault_in_a_cue_stops_neither_charts_nor_alarms(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = folder_with(tmp_path)
    record = Record(folder.path, flown())
    record.write(600)
    record.close()

    def fail(self: TrimMonitor, rows: FlightRows) -> None:
        if rows.times[-1] > 3.0:
            raise ZeroDivisionError("a fault of the program")

    monkeypatch.setattr(TrimMonitor, "process_rows", fail)
    with opened(replayed(folder)) as session:
        assert session.history.last("q")[0] == pytest.approx(6.99, abs=0.02)
        assert session.feed.caught_up
        alarm = session.alarm_registry.get("cues")
        assert "of the program" in alarm.message
        cues = session.cues
        assert cues.trim is None
        assert cues.limitations[0] == alarm.message


def test_the_replay_command_lists_cues_and_verdicts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = folder_with(tmp_path)
    record = Record(folder.path, flown())
    record.write()
    record.close()
    target = tmp_path / "out.json"
    folder.store_aircraft(Path("gsapp/aircraft/files/b777.toml"))
    replay(flight=folder.path, json=target, channel_map="b777")
    result = json.loads(target.read_text())
    (verdict,) = result["verdicts"]
    assert (verdict["result"], verdict["card"], verdict["surfaces"]) == ("good", "E1", ["de"])
    assert verdict["amplitudes"]["de"] == pytest.approx(np.radians(4.5), rel=0.15)
    assert verdict["wanted"]["amplitudes"]["de"]["best"] == pytest.approx(np.radians(4.5))
    times = [cue["time"] for cue in result["cues"]]
    assert times == sorted(times)
    assert {"trim", "input", "hands-off", "verdict", "card", "spoken"} <= {
        cue["kind"] for cue in result["cues"]
    }
    shown = capsys.readouterr().out
    assert "1 verdict\n" in shown
    assert "M1" in shown


def test_what_reads_beyond_its_calibration_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = folder_with(tmp_path)
    record = Record(folder.path, flown())
    record.write(300)
    record.close()
    with opened(replayed(folder, _UNMODELED)) as session:
        cues = session.cues
        assert not [text for text in cues.limitations if "outside calibration" in text]
        used = dict(session.metadata.certificates)
        # Of the whole range only the two degrees next to its lower end were calibrated.
        low, _ = used["alpha"].range
        used["alpha"] = replace(used["alpha"], range=(low, low + 0.1))
        monkeypatch.setattr(FlightMetadata, "calibration", AppliedCertificates(applied=used))
        assert session.metadata.out_of_calibrated_range == ("alpha",)
        cues = session.cues
        assert "Angle of attack" in cues.limitations[0]
