"""Editing the list of maneuvers: nothing is lost, everything can be taken back."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.flight.events import Event, EventLog
from gsapp.flight.maneuvers import (
    Assessor,
    FoundManeuver,
    ManeuverBook,
    ManeuverLog,
    detect,
)
from gsapp.foundation import FlightError, UnknownNameError

sys.path.insert(0, str(Path(__file__).parent))
from maneuver_kit import EVERYTHING, make_flight

AIRCRAFT = load_aircraft("b777")
FLIGHT = make_flight(EVERYTHING, seconds=125.0)
DETECTOR = detect(FLIGHT, AIRCRAFT)
FOUND = DETECTOR.finish()
ASSESS = Assessor(FLIGHT, AIRCRAFT, DETECTOR.noise).assess
BOOK = ManeuverBook(found=FOUND)


def plain(name: str, start: float, stop: float) -> FoundManeuver:
    """Stands for the look at the samples, which is proven elsewhere."""
    return FoundManeuver(
        id=name, t_start=start, t_end=stop, inputs=("de",), kind="doublet", amplitude=0.1, grade="B"
    )


def test_a_moved_edge_is_judged_anew():
    """Cut before its free answer, the doublet is poor; the old one comes back with undo."""
    book = BOOK.move("1", ASSESS, t_end=61.3)
    moved = book["1"]
    assert moved.t_end == pytest.approx(61.3)
    assert moved.t_start == FOUND[0].t_start
    assert moved.grade > FOUND[0].grade
    assert any("hands off" in reason for reason in moved.reasons)
    assert book.undo().maneuvers == FOUND
    assert book.undo().redo().maneuvers == book.maneuvers


def test_a_merged_maneuver_reaches_over_its_parts():
    book = BOOK.annotate("2", "calm").annotate("3", "strong").merge(["3", "2"], ASSESS)
    merged = book["2"]
    assert (merged.t_start, merged.t_end) == (FOUND[1].t_start, FOUND[2].t_end)
    assert merged.inputs == ("da", "dr")
    assert merged.note == "calm; strong"
    assert [one.id for one in book.maneuvers] == ["1", "2", "4", "5"]


def test_an_added_one_gets_a_free_name_and_its_place_in_time():
    book = BOOK.remove("2").add(ASSESS, 66.0, 69.0)
    assert [one.id for one in book.maneuvers] == ["1", "6", "3", "4", "5"]
    assert book.add(plain, 50.0, 55.0, name="first look").maneuvers[0].id == "first look"


def test_names_and_notes():
    book = BOOK.rename("4", "combined").annotate("combined", "the good one")
    assert book["combined"].note == "the good one"
    assert book["combined"].inputs == ("da", "dr")
    with pytest.raises(UnknownNameError, match="there is no maneuver '4'"):
        book["4"]
    # Moving an edge keeps what a person wrote.
    assert book.move("combined", ASSESS, t_end=100.0)["combined"].note == "the good one"


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: BOOK.move("1", ASSESS, t_start=70.0), "ends before it begins"),
        (lambda: BOOK.add(ASSESS, 400.0, 410.0), "runs from"),
        (lambda: BOOK.rename("1", "2"), "is taken"),
        (lambda: BOOK.rename("1", " "), "empty"),
        (lambda: BOOK.merge(["1"], ASSESS), "two maneuvers or more"),
        (lambda: BOOK.remove("9"), "no maneuver '9'; there are 1, 2, 3, 4, 5"),
    ],
)
def test_what_cannot_be_is_said_in_a_sentence(wrong, words):
    with pytest.raises((FlightError, UnknownNameError), match=words):
        wrong()


DEEDS = st.lists(
    st.tuples(
        st.sampled_from(["move", "add", "remove", "merge", "rename", "note", "undo", "redo"]),
        st.integers(0, 7),
        st.floats(0.1, 3.0),
    ),
    max_size=12,
)


def done(book: ManeuverBook, deed: str, place: int, size: float) -> ManeuverBook:
    """Do something to a book; what does not fit leaves it as it is."""
    names = [one.id for one in book.maneuvers]
    if deed == "undo":
        return book.undo()
    if deed == "redo":
        return book.redo()
    if deed == "add":
        return book.add(plain, 10.0 * place, 10.0 * place + size)
    if not names:
        return book
    name = names[place % len(names)]
    if deed == "move":
        return book.move(name, plain, t_end=book[name].t_start + size)
    if deed == "remove":
        return book.remove(name)
    if deed == "merge":
        return book.merge(names[:2], plain) if len(names) > 1 else book
    if deed == "rename":
        new = f"{name}'"
        return book if new in names else book.rename(name, new)
    return book.annotate(name, f"{size:.2f}")


@settings(max_examples=50, deadline=None)
@given(deeds=DEEDS)
def test_every_history_can_be_taken_back_and_brought_again(deeds):
    """All the way back stands what was found; all the way forth what was there before."""
    book = BOOK
    for deed in deeds:
        book = done(book, *deed)
    back = book
    for _ in book.edits:
        back = back.undo()
    assert back.maneuvers == FOUND
    forth = back
    for _ in book.edits:
        forth = forth.redo()
    assert forth.maneuvers == book.maneuvers
    assert len({one.id for one in book.maneuvers}) == len(book.maneuvers)


@settings(max_examples=25, deadline=None)
@given(deeds=DEEDS)
def test_the_events_file_holds_every_history(tmp_path_factory, deeds):
    """A window that opens the file afterwards shows the same list, undo and redo included."""
    path = tmp_path_factory.mktemp("edits") / "events.jsonl"
    log = ManeuverLog(EventLog(path), FOUND)
    for deed in deeds:
        book = done(log.book, *deed)
        if book != log.book:
            log.record(book)
    again = ManeuverLog(EventLog(path), FOUND)
    assert records(again.book) == records(log.book)
    assert len(again.book.undone) == len(log.book.undone)
    assert again.left_out == 0


def records(book: ManeuverBook) -> list[dict[str, object]]:
    return [one.to_record() for one in book.maneuvers]


def test_two_windows_share_one_list(tmp_path):
    path = tmp_path / "events.jsonl"
    one, two = (ManeuverLog(EventLog(path), FOUND) for _ in range(2))
    one.record(one.book.remove("1"))
    # The other has not looked yet, and changes what is gone.
    two.record(two.book.annotate("1", "mine"))
    assert two.left_out == 1
    assert records(two.book) == records(one.book)
    two.record(two.book.undo())
    one.poll()
    assert records(one.book) == records(two.book) == records(BOOK)
    with pytest.raises(FlightError, match="changed the maneuvers meanwhile"):
        one.record(one.book.remove("2").remove("3"))


def test_other_and_damaged_events_are_passed_over(tmp_path):
    path = tmp_path / "events.jsonl"
    log = EventLog(path)
    log.append(Event(kind="mark", text="here", time=3.0))
    log.append(Event(kind="maneuver-edit", text="broken", data={"removed": 3}))
    log.append(
        Event(
            kind="maneuver-edit",
            text="worse",
            data={"removed": [], "added": [{"id": "x", "t_start": 5.0, "t_end": 1.0}]},
        )
    )
    edits = ManeuverLog(EventLog(path), FOUND)
    assert edits.left_out == 2
    assert edits.book.maneuvers == FOUND


def test_a_record_comes_back_whole():
    for one in FOUND:
        assert FoundManeuver.from_record(json.loads(json.dumps(one.to_record()))) == one
    # What `gsapp maneuvers --json` writes is enough.
    short = FoundManeuver.from_record(FOUND[0].to_json())
    assert (short.id, short.inputs, short.grade) == ("1", ("de",), FOUND[0].grade)
    for wrong in (3, {}, {**FOUND[0].to_json(), "grade": "Z"}, {**FOUND[0].to_json(), "t_end": 0}):
        with pytest.raises(FlightError, match="find the maneuvers anew"):
            FoundManeuver.from_record(wrong)
