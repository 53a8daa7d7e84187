"""Marks and notes: made, changed, taken back, shared, and there again after a restart."""

import json
import os
from pathlib import Path

from gsapp.flight.events import Event, EventLog
from gsapp.session.marks import FlightMark, MarkStore


def book(path: Path) -> MarkStore:
    return MarkStore(EventLog(path / "events.jsonl"))


def shown(marks: tuple[FlightMark, ...]) -> list[tuple[float | None, str]]:
    return [(mark.time, mark.text) for mark in marks]


def test_marks_are_made_changed_and_taken_away(tmp_path: Path) -> None:
    marks = book(tmp_path)
    late = marks.add(20.0, "doublet")
    early = marks.add(5.0, "take-off", kind="note")
    span = marks.add(10.0, "trim", end=14.0)
    assert shown(marks.marks) == [(5.0, "take-off"), (10.0, "trim"), (20.0, "doublet")]
    marks.edit(late.id, text="rudder doublet", time=21.0)
    marks.edit(span.id, end=15.0)
    marks.delete(early.id)
    assert shown(marks.marks) == [(10.0, "trim"), (21.0, "rudder doublet")]
    assert marks.marks[0].end == 15.0


def test_every_change_can_be_taken_back_in_turn(tmp_path: Path) -> None:
    marks = book(tmp_path)
    made = marks.add(1.0, "one")
    marks.edit(made.id, text="two")
    marks.delete(made.id)
    states, sizes = [], []
    while True:
        states.append(shown(marks.marks))
        sizes.append((tmp_path / "events.jsonl").stat().st_size)
        if not marks.undo():
            break
    assert states == [[], [(1.0, "two")], [(1.0, "one")], []]
    assert sizes == sorted(set(sizes))


def test_what_was_taken_back_can_be_brought_back(tmp_path: Path) -> None:
    log = EventLog(tmp_path / "events.jsonl")
    log.append(Event(kind="mark", text="one", time=1.0, data={"id": "mark"}))
    standing = []
    for index, of in enumerate(("mark", "undo-0", "undo-1")):
        log.append(Event(kind="undo", data={"id": f"undo-{index}", "of": of}))
        marks = book(tmp_path)
        marks.poll()
        standing.append(len(marks.marks))
    assert standing == [0, 1, 0]


def test_several_windows_see_the_same_marks(tmp_path: Path) -> None:
    left, right = book(tmp_path), book(tmp_path)
    made = left.add(1.0, "left")
    right.poll()
    right.edit(made.id, text="corrected")
    right.add(2.0, "right")
    left.poll()
    assert left.marks == right.marks
    assert left.undo()
    right.poll()
    assert shown(left.marks) == shown(right.marks) == [(2.0, "right")]
    assert right.undo()
    assert right.undo()
    assert not right.undo()
    left.poll()
    assert left.marks == right.marks == ()


def test_a_restarted_window_finds_all_of_it_again(tmp_path: Path) -> None:
    before = book(tmp_path)
    before.add(1.0, "one")
    before.delete(before.add(2.0, "two").id)
    before.write(Event(kind="acknowledge", data={"alarm": "link"}))
    with (tmp_path / "events.jsonl").open("ab") as stream:
        stream.write(b'{"kind": "mark", "text": "torn')
    after = book(tmp_path)
    others = after.poll()
    assert shown(after.marks) == [(1.0, "one")]
    assert [event.kind for event in others] == ["acknowledge"]
    after.add(3.0, "three")
    assert shown(after.marks) == [(1.0, "one"), (3.0, "three")]
    assert after.damaged == 1
    before.poll()
    assert before.marks == after.marks


def test_marks_written_by_other_hands_count_and_can_be_changed(tmp_path: Path) -> None:
    lines = [
        {"kind": "mark", "time": 4.0, "text": "by hand"},
        {"kind": "edit", "data": {"of": 7, "time": "soon"}},
        {"kind": "undo", "data": {}},
        {"kind": "delete"},
        {"kind": "mark", "time": None, "text": "before the vehicle's clock", "data": {"end": "x"}},
    ]
    path = tmp_path / "events.jsonl"
    path.write_text("".join(json.dumps(line) + os.linesep for line in lines))
    marks = book(tmp_path)
    marks.poll()
    assert shown(marks.marks) == [(None, "before the vehicle's clock"), (4.0, "by hand")]
    marks.edit(marks.marks[1].id, text="by machine")
    again = book(tmp_path)
    again.poll()
    assert shown(again.marks)[1] == (4.0, "by machine")
