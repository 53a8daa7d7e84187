"""A second laptop that is given the address alone: aircraft, map and certificates come along."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from gsapp.flight.file_names import CARDS_FILE
from gsapp.flight.folder import FlightFolder
from gsapp.session import Session
from gsapp.telemetry.flight_files import decode_files, encode_files
from gsapp.telemetry.recording_settings import RecordingSettings
from gsapp.telemetry.stream_server import ShareRequest, request_shares
from tests.telemetry.conftest import make_frames, wait_until
from tests.telemetry.test_flight_copy import Crew, key_file

NAMES = ("aircraft.toml", "channel_map.toml", CARDS_FILE)


@pytest.fixture
def crew(tmp_path: Path, own_runtime: Path) -> Iterator[Crew]:
    key = key_file(tmp_path, "crew")
    made = Crew(tmp_path, key=key, other_key=key)
    settings = RecordingSettings(aircraft="b777", channel_map="b777-thin", calibration="b777")
    folder = settings.prepare_folder(made.first.folder, "virtual")
    (folder.path / CARDS_FILE).write_text("# of the first laptop\n", encoding="utf-8")
    request_shares(
        folder.path,
        ShareRequest(links=(f"tcpin:0.0.0.0:{made.port}",), key_file=key),
    )
    wait_until(lambda: made.first.shares() and not made.first.shares()[0].error)
    yield made
    made.close()


def prepare(crew: Crew, *, prefers_shared: bool = False, **own: str) -> tuple[Path, list[str]]:
    told: list[str] = []
    RecordingSettings(**{"share_key": crew.other_key, **own}).prepare_folder(
        crew.second_folder, f"gsapp:127.0.0.1:{crew.port}", tell=told.append,
        prefers_shared=prefers_shared,
    )  # fmt: skip
    return crew.second_folder, told


def same(crew: Crew, name: str) -> bool:
    first, second = crew.first.folder / name, crew.second_folder / name
    return second.is_file() and first.read_bytes() == second.read_bytes()


def test_the_files_of_the_flight_come_along(crew: Crew) -> None:
    folder, told = prepare(crew)
    assert told == []
    assert [name for name in NAMES if not same(crew, name)] == []
    certificates = [one.name for one in FlightFolder(path=crew.first.folder).certificate_files()]
    assert certificates
    assert all(same(crew, f"calibration/{name}") for name in certificates)
    info = FlightFolder(path=folder).info()
    assert (info.aircraft, info.channel_map) == ("b777", "b777-thin")
    # A copy that goes on keeps its own.
    (folder / "aircraft.toml").write_bytes(b"")
    assert prepare(crew) == (folder, [])
    assert not same(crew, "aircraft.toml")


@pytest.mark.parametrize("prefers_shared", [False, True])
def test_a_named_file_counts_on_the_command_line_and_the_shared_one_in_the_window(
    crew: Crew, prefers_shared: bool
) -> None:
    prepare(crew, prefers_shared=prefers_shared, channel_map="b777")
    assert same(crew, "channel_map.toml") is prefers_shared
    assert same(crew, "aircraft.toml")


@pytest.mark.parametrize("wrong", ["key", "port"])
def test_without_them_the_copy_is_prepared_all_the_same(
    crew: Crew, tmp_path: Path, wrong: str
) -> None:
    if wrong == "key":
        crew.other_key = key_file(tmp_path, "others")
    else:
        crew.first.recorder.stop()
    folder, told = prepare(crew, channel_map="b777")
    assert len(told) == 1
    assert (folder / "channel_map.toml").is_file()
    assert not (folder / "aircraft.toml").exists()


def test_damaged_files_do_not_keep_from_copying(crew: Crew) -> None:
    (crew.first.folder / "aircraft.toml").write_text("[geometry\n")
    folder, told = prepare(crew)
    assert len(told) == 1
    assert folder.is_dir()


def test_a_recording_that_names_the_address_alone_is_decoded(crew: Crew) -> None:
    crew.first.send(make_frames(50))
    wait_until(lambda: len(crew.first.recorded()) == 50)
    command = [
        sys.executable, "-m", "gsapp", "record", f"gsapp:127.0.0.1:{crew.port}",
        "--out", str(crew.second_folder), "--share-key", crew.other_key,
    ]  # fmt: skip
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as second:
        try:
            wait_until(lambda: len(crew.copied()) == 50)
        finally:
            second.terminate()
    sessions = [Session.replay(one) for one in (crew.first.folder, crew.second_folder)]
    found = [one.snapshot() for one in sessions]
    assert found[1].aircraft == found[0].aircraft != ""
    assert found[1].channel_map == found[0].channel_map != ""
    assert found[1].calibration == found[0].calibration != ()
    for session in sessions:
        session.close()


@pytest.mark.parametrize(
    "name",
    ["../aircraft.toml", "aircraft/../../x.toml", "/etc/x.toml", "aircraft/.x.toml", "raw.tlog",
     "events.jsonl", "aircraft/x.py", "calibration/a/b.toml", "recorder.share", ""],
)  # fmt: skip
def test_a_file_that_belongs_to_no_flight_is_not_written(name: str) -> None:
    content = json.dumps({name: "x = 1", CARDS_FILE: "y", "fence.toml": 7}).encode()
    assert decode_files(content) == {CARDS_FILE: "y"}


def test_files_beyond_the_limit_and_odd_names_are_not_sent(tmp_path: Path) -> None:
    folder = RecordingSettings(aircraft="b777").prepare_folder(tmp_path / "flight", "virtual")
    folder.update_info(aircraft="../my aircraft: 7")
    (name,) = decode_files(encode_files(folder.path))
    assert name == "aircraft/_._my aircraft_ 7.toml"
    (folder.path / CARDS_FILE).write_text("#" * (1 << 21))
    assert encode_files(folder.path) == b"{}"
