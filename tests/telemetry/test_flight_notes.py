"""Notes of a second laptop, on their way back into the flight of the first."""

import json
import os
import signal
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from gsapp.flight.events import AUTHOR_KEY, Event, EventLog, events_path, read_events
from gsapp.session.marks import FlightMark, MarkStore
from gsapp.telemetry.flight_notes import NoteReceiver, encode_note
from gsapp.telemetry.flight_stream import NOTES_PURPOSE, FlightSender, StreamSeal
from gsapp.telemetry.recorder_control import restart_recorder
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.stream_server import ShareRequest, request_shares
from tests.telemetry.conftest import make_frames, wait_until
from tests.telemetry.test_flight_copy import Crew, key_file

AUTHOR = "192.0.2.7"


@pytest.fixture
def crew(tmp_path: Path, own_runtime: Path) -> Iterator[Crew]:
    key = key_file(tmp_path, "crew")
    made = Crew(tmp_path, key=key, other_key=key)
    made.first.send(make_frames(10))
    yield made
    made.close()


def share(crew: Crew, *, takes_notes: bool) -> None:
    link = f"tcpin:0.0.0.0:{crew.port}"
    request_shares(
        crew.first.folder, ShareRequest(links=(link,), key_file=crew.key, takes_notes=takes_notes)
    )
    wait_until(lambda: crew.first.shares() and not crew.first.shares()[0].error)
    wait_until(lambda: crew.first.recorder.status().share_notes is takes_notes)


def join(crew: Crew, *, sends_notes: bool) -> MarkStore:
    if crew.second is None:
        crew.join()
    wait_until(lambda: crew.second.status().sends_notes is sends_notes)
    wait_until(crew.second_folder.is_dir)
    return MarkStore(EventLog(events_path(crew.second_folder)))


def marks(folder: Path) -> dict[str, FlightMark]:
    store = MarkStore(EventLog(events_path(folder)))
    store.poll()
    return {mark.text: mark for mark in store.marks}


def test_notes_go_into_the_flight_with_the_name_of_who_made_them(crew: Crew) -> None:
    """Made, written as a window does it, changed, taken away: both laptops show the same."""
    own = MarkStore(EventLog(events_path(crew.first.folder)))
    own.add(1.0, "own mark")
    share(crew, takes_notes=True)
    store = join(crew, sends_notes=True)
    empty = store.add(12.5, kind="note")
    store.edit(empty.id, text="gusty in the turn")
    span = store.add(3.0, "climb", end=9.0)
    gone = store.add(4.0, "by mistake")
    store.delete(gone.id)
    wait_until(lambda: set(marks(crew.first.folder)) == {"own mark", "gusty in the turn", "climb"})
    note = marks(crew.first.folder)["gusty in the turn"]
    assert (note.id, note.kind, note.time) == (empty.id, "note", 12.5)
    assert "127.0.0.1" in note.author
    assert note.author.startswith(socket.gethostname()[:40])
    assert marks(crew.first.folder)["own mark"].author == ""
    assert marks(crew.first.folder)["climb"].end == span.end == 9.0
    # Nothing came back twice, and what was edited meanwhile stays as it is.
    time.sleep(2.5)
    second = read_events(events_path(crew.second_folder)).events
    assert len([event for event in second if event.data.get("id") == empty.id]) == 1
    assert not any(AUTHOR_KEY in event.data for event in second)
    assert set(marks(crew.second_folder)) == set(marks(crew.first.folder))


def test_notes_stay_where_they_are_made_unless_the_crew_takes_them(crew: Crew) -> None:
    share(crew, takes_notes=False)
    store = join(crew, sends_notes=False)
    assert "notes stay" in crew.second.status().source_state
    store.add(1.0, "kept for later")
    time.sleep(2.5)
    assert marks(crew.first.folder) == {}
    # The chief allows it meanwhile: what was made before goes, too, and the flight goes on.
    crew.first.send(make_frames(20))
    share(crew, takes_notes=True)
    join(crew, sends_notes=True)
    wait_until(lambda: set(marks(crew.first.folder)) == {"kept for later"})
    crew.wait_until_copied()
    share(crew, takes_notes=False)
    join(crew, sends_notes=False)
    store.add(2.0, "too late")
    time.sleep(2.5)
    assert set(marks(crew.first.folder)) == {"kept for later"}


def test_nothing_but_notes_goes_back(crew: Crew) -> None:
    share(crew, takes_notes=True)
    join(crew, sends_notes=True)
    log = EventLog(events_path(crew.second_folder))
    for kind in ("alarm", "vehicle", "card-choice", "verdict", "maneuver-edit", "status"):
        log.append(Event(kind=kind, text=kind, data={"id": "a1", "system": 7}))
    MarkStore(log).add(1.0, "note")
    wait_until(lambda: set(marks(crew.first.folder)) == {"note"})
    assert len(read_events(events_path(crew.first.folder)).events) == 1


@pytest.mark.parametrize("breaks", ["connection", "recorder"])
def test_notes_made_while_the_connection_is_gone_are_sent_once_it_is_back(
    crew: Crew, breaks: str
) -> None:
    share(crew, takes_notes=True)
    store = join(crew, sends_notes=True)
    store.add(1.0, "before")
    wait_until(lambda: "before" in marks(crew.first.folder))
    if breaks == "connection":
        request_shares(crew.first.folder, ShareRequest())
        wait_until(lambda: not crew.first.shares())
    else:
        os.kill(crew.second.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
        wait_until(lambda: not crew.second.is_alive())
    store.add(2.0, "meanwhile")
    if breaks == "connection":
        share(crew, takes_notes=True)
    else:
        crew.second = restart_recorder(crew.second_folder)
    wait_until(lambda: "meanwhile" in marks(crew.first.folder))
    written = read_events(events_path(crew.first.folder)).events
    assert sorted(event.text for event in written) == ["before", "meanwhile"]


def note(name: str = "a1", **content: object) -> bytes:
    event = {"kind": "note", "text": "words", "time": 1.0, "host_time_us": 0, **content}
    return json.dumps({**event, "data": {"id": name, **event.get("data", {})}}).encode()


@pytest.fixture
def receiver(tmp_path: Path) -> NoteReceiver:
    own = EventLog(events_path(tmp_path))
    own.append(Event(kind="mark", text="own", time=1.0, data={"id": "c0"}))
    return NoteReceiver(tmp_path, AUTHOR)


def written(folder: Path) -> list[Event]:
    return list(read_events(events_path(folder)).events)[1:]


def test_a_note_is_all_that_is_taken(receiver: NoteReceiver, tmp_path: Path) -> None:
    for wrong in (
        note(kind="vehicle", data={"system": 7}), note(kind="alarm"), note(""), note("a/../b"),
        note("a" * 65), b"[]", b"{", b"\xff", b"[" * 5000, note(time=1e300), note(text=["x"]),
    ):  # fmt: skip
        with pytest.raises(ValueError):  # noqa: PT011 - any of them ends the connection
            receiver.take(wrong)
    # The crew's own marks are neither changed nor taken away; nor is a note written twice.
    for kind in ("edit", "delete", "undo"):
        for target in ("c0", "none", None, ["c0"]):
            receiver.take(note("b1", kind=kind, data={"of": target}))
    receiver.take(note("c0"))
    assert written(tmp_path) == []
    receiver.take(note("a1", text="one\n\x1b[2Jtwo" + "x" * 1000, by=1, computer="l\n" * 99,
                       data={"end": "x", "system": 7, "from": "the chief"}))  # fmt: skip
    receiver.take(note("a1", text="again"))
    receiver.take(note("b2", kind="edit", data={"of": "a1", "text": "<b>", "time": True}))
    made, edit = written(tmp_path)
    assert made.text.startswith("one  [2Jtwo")
    assert len(made.text) <= TELEMETRY.max_note_length
    assert made.text.isprintable()
    assert set(made.data) == {"id", AUTHOR_KEY}
    assert made.data[AUTHOR_KEY].endswith(f"({AUTHOR})")
    assert len(made.data[AUTHOR_KEY]) < 60
    assert (edit.data["of"], edit.data["text"]) == ("a1", "<b>")


def sender_and_seal(folder: Path, notes: NoteReceiver | None) -> tuple[FlightSender, StreamSeal]:
    key = bytes(32)
    sender = FlightSender(folder, [key], notes)
    nonce = sender.answer(b"gsapp flight 1 0 0 abc").split()[-1]
    assert sender.answer(StreamSeal(key, b"abc", nonce).proof()).startswith(b"ok")
    return sender, StreamSeal(key, b"abc", nonce, NOTES_PURPOSE)


def test_a_note_that_was_altered_or_repeated_is_not_taken(tmp_path: Path) -> None:
    def send(*blocks: bytes) -> None:
        sender, seal = sender_and_seal(tmp_path, NoteReceiver(tmp_path, AUTHOR))
        made = [seal.encode_block(note(f"a{number}")) for number in range(2)]
        made += [bytes([*made[0][:-1], made[0][-1] ^ 1]), b"\xff" * 24]
        sender.take_notes(b"".join(made[int(block)] for block in blocks))

    for wrong in ((b"1",), (b"0", b"0"), (b"2",), (b"3",)):
        with pytest.raises(ValueError, match=r"altered|too long"):
            send(*wrong)
    # What the server sends is no note when it comes back.
    sender, _ = sender_and_seal(tmp_path, NoteReceiver(tmp_path, AUTHOR))
    with pytest.raises(ValueError, match="altered"):
        sender.take_notes(sender.poll(1))
    assert [event.text for event in read_events(events_path(tmp_path)).events] == []


def test_a_flood_of_notes_is_slowed_down(tmp_path: Path) -> None:
    sender, seal = sender_and_seal(tmp_path, NoteReceiver(tmp_path, AUTHOR))
    for number in range(200):
        if sender.reads_client:
            sender.take_notes(seal.encode_block(note(f"a{number}")))
    count = len(read_events(events_path(tmp_path)).events)
    assert TELEMETRY.note_burst <= count <= TELEMETRY.note_burst + 3
    assert not sender.reads_client
    before = time.monotonic()
    while len(read_events(events_path(tmp_path)).events) == count:
        sender.take_notes(b"")
        assert time.monotonic() - before < 10.0


def test_without_leave_nothing_is_read_as_a_note(tmp_path: Path) -> None:
    sender, seal = sender_and_seal(tmp_path, None)
    sender.take_notes(seal.encode_block(encode_note(Event(kind="note", data={"id": "a1"}), "x")))
    sender.take_notes(b"anything")
    assert not events_path(tmp_path).exists()


def test_a_recorder_that_is_restarted_takes_notes_as_before(crew: Crew) -> None:
    share(crew, takes_notes=True)
    os.kill(crew.first.recorder.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
    wait_until(lambda: not crew.first.recorder.is_alive())
    crew.first.recorder = restart_recorder(crew.first.folder)
    wait_until(lambda: bool(crew.first.shares()))
    assert crew.first.recorder.status().share_notes
