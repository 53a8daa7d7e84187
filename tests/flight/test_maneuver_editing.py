"""Editing the list of maneuvers: nothing is lost, everything can be taken back."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.flight.events import Event, EventLog, events_path
from gsapp.flight.maneuvers import (
    GRADED_BY_CREW,
    GRADED_BY_PROGRAM,
    DetectedManeuver,
    EditableManeuverList,
    ManeuverAssessor,
    ManeuverEditLog,
    collect_maneuvers,
    run_detector,
)
from gsapp.foundation import FlightError, UnknownNameError
from tests.flight.maneuver_kit import EVERYTHING, make_flight

AIRCRAFT = load_aircraft("b777")
FLIGHT = make_flight(EVERYTHING, seconds=125.0)
DETECTOR = run_detector(FLIGHT, AIRCRAFT)
FOUND = DETECTOR.finish()
ASSESS = ManeuverAssessor(FLIGHT, AIRCRAFT, DETECTOR.noise).assess
BOOK = EditableManeuverList(detected=FOUND)


def plain(name: str, start: float, stop: float) -> DetectedManeuver:
    return DetectedManeuver(
        id=name, t_start=start, t_end=stop, inputs=("de",), kind="doublet", amplitude=0.1, grade="B"
    )


def test_a_moved_edge_is_judged_anew():
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
    # What was estimated from one that is gone keeps its name.
    assert BOOK.remove("5").add(plain, 50.0, 55.0).maneuvers[0].id == "6"


def test_names_and_notes():
    book = BOOK.rename("4", "combined").annotate("combined", "the good one")
    assert book["combined"].note == "the good one"
    assert book["combined"].inputs == ("da", "dr")
    with pytest.raises(UnknownNameError, match="'4'"):
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
        (lambda: BOOK.merge(["1"], ASSESS), "two or more maneuvers"),
        (lambda: BOOK.remove("9"), "no maneuver '9'; there are 1, 2, 3, 4, 5"),
    ],
)
def test_what_cannot_be_is_said_in_a_sentence(wrong, words):
    with pytest.raises((FlightError, UnknownNameError), match=words):
        wrong()


DEEDS = st.lists(
    st.tuples(
        st.sampled_from(
            ["move", "add", "remove", "merge", "rename", "note", "use", "undo", "redo"]
        ),
        st.integers(0, 7),
        st.floats(0.1, 3.0),
    ),
    max_size=12,
)


def done(book: EditableManeuverList, action: str, place: int, size: float) -> EditableManeuverList:
    """Do something to a book; what does not fit leaves it as it is."""
    names = [one.id for one in book.maneuvers]
    if action == "undo":
        return book.undo()
    if action == "redo":
        return book.redo()
    if action == "add":
        return book.add(plain, 10.0 * place, 10.0 * place + size)
    if not names:
        return book
    name = names[place % len(names)]
    if action == "move":
        return book.move(name, plain, t_end=book[name].t_start + size)
    if action == "remove":
        return book.remove(name)
    if action == "merge":
        return book.merge(names[:2], plain) if len(names) > 1 else book
    if action == "use":
        return book.set_use(name, size > 1.5)
    if action == "rename":
        new = f"{name}'"
        return book if new in names else book.rename(name, new)
    return book.annotate(name, f"{size:.2f}")


@settings(max_examples=50, deadline=None)
@given(actions=DEEDS)
def test_every_history_can_be_taken_back_and_brought_again(actions):
    book = BOOK
    for action in actions:
        book = done(book, *action)
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
@given(actions=DEEDS)
def test_the_events_file_holds_every_history(tmp_path_factory, actions):
    path = tmp_path_factory.mktemp("edits") / "events.jsonl"
    log = ManeuverEditLog(EventLog(path), FOUND)
    for action in actions:
        book = done(log.maneuver_list, *action)
        if book != log.maneuver_list:
            log.record(book)
    again = ManeuverEditLog(EventLog(path), FOUND)
    assert records(again.maneuver_list) == records(log.maneuver_list)
    assert len(again.maneuver_list.undone) == len(log.maneuver_list.undone)
    assert again.skipped_count == 0


def records(book: EditableManeuverList) -> list[dict[str, object]]:
    return [one.to_record() for one in book.maneuvers]


def test_two_windows_share_one_list(tmp_path):
    path = tmp_path / "events.jsonl"
    one, two = (ManeuverEditLog(EventLog(path), FOUND) for _ in range(2))
    one.record(one.maneuver_list.remove("1"))
    # The other has not looked yet, and changes what is gone.
    two.record(two.maneuver_list.annotate("1", "mine"))
    assert two.skipped_count == 1
    assert records(two.maneuver_list) == records(one.maneuver_list)
    two.record(two.maneuver_list.undo())
    one.poll()
    assert records(one.maneuver_list) == records(two.maneuver_list) == records(BOOK)
    with pytest.raises(FlightError, match="review and try again"):
        one.record(one.maneuver_list.remove("2").remove("3"))
    with pytest.raises(FlightError, match="review and try again"):
        ManeuverEditLog(EventLog(tmp_path / "none.jsonl"), FOUND).record(BOOK)


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
    edits = ManeuverEditLog(EventLog(path), FOUND)
    assert edits.skipped_count == 2
    assert edits.maneuver_list.maneuvers == FOUND


def test_a_record_comes_back_whole():
    for one in FOUND:
        assert DetectedManeuver.from_record(json.loads(json.dumps(one.to_record()))) == one
    # What `gsapp maneuvers --json` writes is enough.
    short = DetectedManeuver.from_record(FOUND[0].to_json())
    assert (short.id, short.inputs, short.grade) == ("1", ("de",), FOUND[0].grade)
    for wrong in (3, {}, {**FOUND[0].to_json(), "grade": "Z"}, {**FOUND[0].to_json(), "t_end": 0}):
        with pytest.raises(FlightError, match="detect the maneuvers"):
            DetectedManeuver.from_record(wrong)


# A list that is found otherwise than when it was changed --------------------------------


def edited(
    path: Path, found: tuple[DetectedManeuver, ...], *actions: tuple[str, int, float]
) -> None:
    log = ManeuverEditLog(EventLog(path), found)
    for action in actions:
        log.record(done(log.maneuver_list, *action))


def test_maneuvers_that_know_as_little_are_equal():
    one, again = (replace(FOUND[0], t_input=float("nan")) for _ in range(2))
    assert one == again
    assert one != replace(again, t_input=FOUND[0].t_start)
    assert one != "M1"


def test_a_change_finds_its_maneuver_where_it_lay_not_by_its_number(tmp_path):
    path = tmp_path / "events.jsonl"
    edited(path, FOUND, ("move", 1, 2.5), ("note", 1, 7.0), ("remove", 3, 1.0))
    before = ManeuverEditLog(EventLog(path), FOUND).maneuver_list
    more = (
        plain("1", 40.0, 44.0),
        *(replace(one, id=str(number)) for number, one in enumerate(FOUND, start=2)),
    )
    log = ManeuverEditLog(EventLog(path), more)
    assert log.skipped_count == 0
    shifted = [replace(one, id=str(int(one.id) + 1)) for one in before.maneuvers]
    assert list(log.maneuver_list.maneuvers) == [more[0], *shifted]
    assert log.maneuver_list["3"].note == "7.00"
    # All the way back stands what is found now.
    assert log.maneuver_list.undo().undo().undo().maneuvers == more


def test_what_is_not_found_any_more_stands_as_it_was_changed_and_is_said(tmp_path):
    path = tmp_path / "events.jsonl"
    edited(path, FOUND, ("note", 1, 7.0), ("move", 1, 2.5), ("remove", 2, 1.0))
    fewer = tuple(
        replace(one, id=str(number)) for number, one in enumerate((FOUND[0], *FOUND[3:]), start=1)
    )
    log = ManeuverEditLog(EventLog(path), fewer)
    (there,) = (one for one in log.maneuver_list.maneuvers if one.note == "7.00")
    assert (there.t_start, there.t_end) == (FOUND[1].t_start, FOUND[1].t_start + 2.5)
    assert [one for one in log.maneuver_list.maneuvers if one is not there] == list(fewer)
    text = " ".join(log.remarks)
    assert "3 changes (manual)" in text
    assert f"maneuver 2 at {FOUND[1].t_start:.1f} s" in text
    assert f"maneuver 3 at {FOUND[2].t_start:.1f} s" in text
    # Its number is another's now.
    assert f"is now called {there.id}" in text


def test_undo_takes_back_its_own_change_whichever_are_left_out(tmp_path):
    path = tmp_path / "events.jsonl"
    one, two = (ManeuverEditLog(EventLog(path), FOUND) for _ in range(2))
    one.record(one.maneuver_list.remove("1"))
    two.record(two.maneuver_list.annotate("1", "mine"))
    EventLog(path).append(Event(kind="maneuver-undo", text="", data={"change": 2}))
    again = ManeuverEditLog(EventLog(path), FOUND)
    assert [edit.text for edit in again.maneuver_list.edits] == ["remove 1"]
    again.record(again.maneuver_list.undo())
    assert records(ManeuverEditLog(EventLog(path), FOUND).maneuver_list) == records(BOOK)


def test_a_grade_by_a_person_survives_and_can_be_taken_back(tmp_path):
    path = tmp_path / "events.jsonl"
    log = ManeuverEditLog(EventLog(path), FOUND)
    log.record(log.maneuver_list.regrade("2", "C", ASSESS, "wind"))
    log.record(log.maneuver_list.move("2", ASSESS, t_end=FOUND[1].t_end - 0.5))
    kept = ManeuverEditLog(EventLog(path), FOUND).maneuver_list["2"]
    assert (kept.grade, kept.reasons, kept.graded_by) == ("C", ("wind",), GRADED_BY_CREW)
    log.record(log.maneuver_list.regrade("2", None, ASSESS))
    assert log.maneuver_list["2"].graded_by == GRADED_BY_PROGRAM
    assert log.maneuver_list["2"].grade == ASSESS("2", FOUND[1].t_start, FOUND[1].t_end - 0.5).grade
    assert records(log.maneuver_list.undo().undo().undo()) == records(BOOK)
    with pytest.raises(FlightError, match="no grade 'E'"):
        log.maneuver_list.regrade("2", "E", ASSESS)


def test_a_survey_takes_what_was_changed_as_the_samples_show_it_now(tmp_path):
    flight = replace(FLIGHT, path=tmp_path / "made.csv")
    found = collect_maneuvers(flight, AIRCRAFT).maneuvers
    log = ManeuverEditLog(EventLog(events_path(flight.path)), found)
    log.record(log.maneuver_list.add(plain, 64.0, 66.0, name="rest"))
    log.record(log.maneuver_list.annotate("rest", "nothing here"))
    assert (tmp_path / "made.csv.events.jsonl").is_file()
    edited_list = collect_maneuvers(flight, AIRCRAFT)
    (rest,) = (one for one in edited_list.maneuvers if one.id == "rest")
    assert rest.note == "nothing here"
    assert rest == replace(ASSESS("rest", 64.0, 66.0), note="nothing here")
    assert any("2 changes (manual)" in remark for remark in edited_list.remarks)
    assert collect_maneuvers(flight, AIRCRAFT, as_found=True).maneuvers == found
    (given,) = collect_maneuvers(flight, AIRCRAFT, given=["64:66"]).maneuvers
    assert given.note == ""
    shorter = replace(flight, block=flight.block.between(0.0, 62.0))
    assert any("by hand" in one for one in collect_maneuvers(shorter, AIRCRAFT).remarks)
