"""Events: appended by several processes at once, read past every kind of damage."""

import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.flight.events import Event, EventLog, read_events, sort_events
from gsapp.foundation import FlightError

WRITER = """
import sys
from gsapp.flight.events import Event, EventLog
log = EventLog(sys.argv[1])
for k in range(60):
    log.append(Event(kind="mark", text=f"{sys.argv[2]}-{k} " + "x" * 200, time=k * 0.5))
"""


def test_what_is_appended_comes_back(tmp_path):
    log = EventLog(tmp_path / "events.jsonl")
    written = log.append(
        Event(
            kind="alarm", text="alpha > 14°", time=12.5, data={"channel": "alpha", "v": [1, None]}
        )
    )
    assert written.host_time_us > 1_700_000_000_000_000
    assert log.poll() == [written]
    assert log.poll() == []
    assert read_events(log.path).events == (written,)


def test_several_processes_append_at_once(tmp_path):
    """Four processes write 240 events into one file; each is there once, whole, in its order."""
    path = tmp_path / "events.jsonl"
    writers = [
        subprocess.Popen([sys.executable, "-c", WRITER, str(path), str(name)]) for name in range(4)
    ]
    assert [writer.wait(timeout=240) for writer in writers] == [0] * 4
    record = read_events(path)
    assert record.damaged == 0
    texts = [event.text.split()[0] for event in record.events]
    assert len(texts) == 240
    for name in range(4):
        mine = [text for text in texts if text.startswith(f"{name}-")]
        assert mine == [f"{name}-{k}" for k in range(60)]


def test_torn_tail_is_closed_by_the_next_writer(tmp_path):
    log = EventLog(tmp_path / "events.jsonl")
    log.append(Event(kind="mark", text="one"))
    with log.path.open("ab") as stream:
        stream.write(b'{"kind": "note", "te')
    assert [event.text for event in log.poll()] == ["one"]
    log.append(Event(kind="mark", text="two"))
    assert [event.text for event in log.poll()] == ["two"]
    assert log.damaged == 1


@settings(max_examples=40, deadline=None)
@given(data=st.binary(max_size=200), place=st.integers(0, 10**6))
def test_damage_costs_only_the_lines_it_hits(tmp_path_factory, data, place):
    log = EventLog(tmp_path_factory.mktemp("events") / "events.jsonl")
    for k in range(4):
        log.append(Event(kind="mark", text=str(k)))
    lines = log.path.read_bytes().splitlines(keepends=True)
    cut = place % 5
    log.path.write_bytes(b"".join(lines[:cut]) + data + b"\n" + b"".join(lines[cut:]))
    texts = [event.text for event in log.poll()]
    assert [text for text in texts if text in "0123"] == ["0", "1", "2", "3"] or not data.strip()


def test_a_missing_file_holds_no_events(tmp_path):
    assert read_events(tmp_path / "none.jsonl").events == ()
    assert EventLog(tmp_path / "none.jsonl").poll() == []


def test_a_folder_that_was_renamed_is_looked_for_by_its_path(tmp_path):
    log = EventLog(tmp_path / "gone" / "events.jsonl")
    with pytest.raises(FlightError, match="cannot be written"):
        log.append(Event(kind="mark", text="turbulence", time=1.0))


def test_what_json_cannot_hold_is_refused(tmp_path):
    log = EventLog(tmp_path / "events.jsonl")
    with pytest.raises(FlightError, match="null for NaN"):
        log.append(Event(kind="mark", data={"v": float("nan")}))
    log.append(Event(kind="mark", time=float("nan")))
    assert log.poll()[0].time is None


def test_what_came_before_the_first_flight_time_stands_first() -> None:
    timed = [Event(kind="mark", time=t, host_time_us=10 + int(t)) for t in (0.0, 2.0)]
    early, late, unknown = (Event(kind="status", host_time_us=host) for host in (5, 11, 0))
    assert sort_events([*timed, unknown, late, early]) == (early, *timed, unknown, late)
    assert sort_events([late, early]) == (early, late)
