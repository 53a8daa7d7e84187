"""Maneuvers named by hand, and short records taken whole."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.flight import Flight
from gsapp.flight.events import Event, EventLog, events_path
from gsapp.flight.maneuvers import (
    GRADED_BY_CREW,
    DetectedManeuver,
    collect_maneuvers,
    detect_maneuvers,
    explain_no_maneuvers,
    parse_maneuver_windows,
)
from gsapp.foundation import FlightError
from gsapp.quantities.constants import DEGREE
from tests.flight.maneuver_kit import EVERYTHING, Input, changed, flight_of, make_flight

AIRCRAFT = load_aircraft("b777")
FLIGHT = make_flight(EVERYTHING, seconds=125.0)


def short(*inputs: Input, **options: object) -> Flight:
    return make_flight(inputs, ground=0.0, seconds=12.0, steering=0.0, **options)  # type: ignore[arg-type]


def _listed(flight: Flight, given: Sequence[str] = (), **of: int) -> tuple[DetectedManeuver, ...]:
    return collect_maneuvers(flight, AIRCRAFT, given=given, **of).maneuvers


def test_windows_are_read():
    one, two = parse_maneuver_windows(["2:139.5:146", "1: 10 :20.25"], flights=2)
    assert (one.flight, one.start, one.stop) == (2, 139.5, 146.0)
    assert (two.flight, two.start, two.stop) == (1, 10.0, 20.25)
    (alone,) = parse_maneuver_windows(["139.5:146"])
    assert (alone.flight, alone.start) == (1, 139.5)


@pytest.mark.parametrize(
    ("text", "flights", "words"),
    [
        ("139.5", 1, "write START:STOP"),
        ("a:b", 1, "cannot be read"),
        ("1:2:3:4", 1, "cannot be read"),
        ("nan:3", 1, "cannot be read"),
        ("20:10", 1, "ends before it begins"),
        ("20:20", 1, "is empty"),
        ("10:20", 2, "one of the 2 flights"),
        ("3:10:20", 2, "names flight 3, but there are 2"),
        ("0:10:20", 2, "names flight 0"),
        ("1.5:10:20", 2, "names flight 1.5"),
    ],
)
def test_a_window_that_cannot_be_gets_one_sentence(text, flights, words):
    with pytest.raises(FlightError, match=words):
        parse_maneuver_windows([text], flights)


def test_a_named_maneuver_takes_the_place_of_found_ones():
    (found,) = _listed(FLIGHT, ["94.5:101"])
    assert (found.t_start, found.t_end) == (94.5, 101.0)
    assert found.inputs == ("da", "dr")
    assert found.kind == "doublet"
    searched = detect_maneuvers(FLIGHT, AIRCRAFT)[3]
    assert found.amplitudes == pytest.approx(dict(searched.amplitudes), rel=0.1)


def test_windows_go_to_their_flights():
    given = ["2:58:65", "2:70:77"]
    assert [one.inputs for one in _listed(FLIGHT, given, number=2, flights=2)] == [
        ("de",),
        ("da",),
    ]
    # The other flight, which nobody named, is searched.
    assert len(_listed(FLIGHT, given, number=1, flights=2)) == 5


def test_a_window_without_an_input_is_graded_for_it():
    flight = make_flight([Input(at=60.0, surface="de")], steering=0.0)
    (found,) = _listed(flight, ["80:90"])
    assert (found.inputs, found.kind, found.grade, found.amplitude) == ((), "none", "D", None)
    assert "no excitation" in found.reasons[0]
    assert found.to_json()["amplitude"] is None


def test_a_window_outside_the_flight_names_its_ends():
    with pytest.raises(FlightError, match=r"runs from 0.00 to 124.99 s"):
        _listed(FLIGHT, ["500:510"])


@pytest.mark.parametrize(
    ("inputs", "moved"),
    [
        ([Input(at=3.0, surface="de")], ("de",)),
        ([Input(at=3.0, surface="dr", size=9.0)], ("dr",)),
        ([Input(at=3.0, surface="da"), Input(at=3.3, surface="dr", size=-9.0)], ("da", "dr")),
        # Too early for a second of trim, too slow to be a quick move: still the record is whole.
        ([Input(at=0.3, surface="de")], ("de",)),
    ],
)
def test_a_short_record_is_one_maneuver_whole(inputs, moved):
    found = collect_maneuvers(short(*inputs), AIRCRAFT)
    (one,) = found.maneuvers
    assert (one.t_start, one.t_end) == (0.0, pytest.approx(11.99))
    assert one.inputs == moved
    assert any("one maneuver" in remark for remark in found.remarks)


def held_off(flight: Flight, pause: float) -> Flight:
    """Return a record whose second half comes `pause` s later, as joined records do."""
    times = flight.block.times
    later = np.where(times < 0.5 * times[-1], times, times + pause)
    return flight_of({name: flight.block[name] for name in flight.block.channels}, later)


JOINED = held_off(
    make_flight(
        [Input(at=8.0, surface="da"), Input(at=28.0, surface="dr", size=9.0)],
        ground=0.0,
        seconds=40.0,
        steering=0.0,
    ),
    pause=30.0,
)
"""An aileron and a rudder doublet, each in a record of its own; joined."""


def test_joined_records_are_one_maneuver_each():
    found = collect_maneuvers(JOINED, AIRCRAFT)
    assert [one.inputs for one in found.maneuvers] == [("da",), ("dr",)]
    assert [one.t_start for one in found.maneuvers] == pytest.approx([0.0, 50.0], abs=0.02)
    assert [one.t_end for one in found.maneuvers] == pytest.approx([19.99, 69.99], abs=0.02)


def test_a_window_over_a_gap_is_parted_there():
    found = collect_maneuvers(JOINED, AIRCRAFT, given=["2:65"])
    assert [one.inputs for one in found.maneuvers] == [("da",), ("dr",)]
    assert [one.id for one in found.maneuvers] == ["1", "2"]
    assert found.maneuvers[1].t_end == pytest.approx(65.0, abs=0.02)


def test_surfaces_moved_in_turn_are_both_inputs_of_a_window():
    """A rudder input a quarter as quick as the aileron's before it is no steering."""
    inputs = [Input(at=4.0, surface="da", size=15.0), Input(at=9.0, surface="dr", size=9.0)]
    slow = make_flight(inputs, ground=0.0, seconds=14.0, steering=0.0)
    rudder = np.convolve(slow.block["dr"], np.ones(40) / 40.0, "same")
    (found,) = _listed(changed(slow, dr=rudder), ["0:13"])
    assert found.inputs == ("da", "dr")


def test_a_record_cut_while_its_surface_was_displaced_shows_its_amplitude():
    whole = make_flight(
        [Input(at=2.0, surface="da", kind="3-2-1-1", size=8.0, step=0.7)],
        ground=0.0,
        seconds=12.0,
        steering=0.0,
    )
    columns = {name: whole.block[name][230:900] for name in whole.block.channels}
    (found,) = _listed(flight_of(columns, whole.block.times[230:900]))
    assert (found.inputs, found.kind) == (("da",), "3-2-1-1")
    assert found.amplitude == pytest.approx(8.0 * DEGREE, rel=0.05)


def test_a_short_record_without_input_earns_nothing():
    (one,) = _listed(short())
    assert (one.inputs, one.grade) == ((), "D")


def test_a_short_record_of_two_maneuvers_is_not_whole():
    flight = make_flight(
        [Input(at=10.0, surface="de"), Input(at=25.0, surface="da")],
        ground=0.0,
        seconds=40.0,
        steering=0.5,
    )
    assert [one.inputs for one in _listed(flight)] == [("de",), ("da",)]


def test_ten_samples_are_a_maneuver_that_earns_nothing():
    whole = short(Input(at=3.0, surface="de"))
    columns = {name: whole.block[name][300:310] for name in whole.block.channels}
    flight = flight_of(columns, whole.block.times[300:310])
    (one,) = _listed(flight)
    assert one.grade == "D"
    assert any("10 samples" in reason for reason in one.reasons) or not one.inputs


def test_a_stuck_surface_is_told():
    stuck = changed(FLIGHT, dr=0.02, da=np.nan)
    found = collect_maneuvers(stuck, AIRCRAFT)
    assert any(f"{0.02 / DEGREE:.2f} deg" in remark for remark in found.remarks)
    assert any("da was not" in remark for remark in found.remarks)
    assert [one.inputs for one in found.maneuvers] == [("de",), ("de",)]


def recorded(folder: Path, **data: object) -> Flight:
    path = folder / "flight.csv"
    flight = replace(FLIGHT, path=path)
    EventLog(events_path(path)).append(Event(kind="verdict", text="too fast: slower", data=data))
    return flight


def test_a_verdict_given_in_flight_excludes_the_best_grade(tmp_path: Path):
    usual = collect_maneuvers(FLIGHT, AIRCRAFT).maneuvers
    first = next(one for one in usual if one.grade == "A")
    second = next(one for one in usual if one.id != first.id)
    flown = recorded(tmp_path, t_input=first.t_input, result="too-fast")
    graded = {one.id: one for one in collect_maneuvers(flown, AIRCRAFT).maneuvers}
    assert graded[first.id].grade == "B"
    assert graded[first.id].reasons == ("too fast: slower",)
    assert graded[second.id] == second
    (named,) = _listed(flown, [f"{first.t_start}:{first.t_end}"])
    assert named.grade == "B"
    regraded = replace(first, graded_by=GRADED_BY_CREW)
    assert regraded.with_verdict("too-fast", "slower") == regraded
    assert first.with_verdict("good", "good", "A") == first


def test_a_verdict_that_cannot_be_read_changes_nothing(tmp_path: Path):
    flown = recorded(tmp_path, t_input="soon", result=3, grade="Z")
    assert (
        collect_maneuvers(flown, AIRCRAFT).maneuvers
        == collect_maneuvers(FLIGHT, AIRCRAFT).maneuvers
    )


def test_a_command_that_stands_still_is_told_as_one():
    columns = {name: FLIGHT.block[name] for name in FLIGHT.block.channels if name != "da"}
    commanded = flight_of(
        {**columns, "da_command": np.zeros(len(FLIGHT.block))}, FLIGHT.block.times
    )
    (remark,) = collect_maneuvers(commanded, AIRCRAFT).remarks
    assert "da_command is constant" in remark
    assert "sensor" not in remark


def test_why_there_is_no_maneuver_to_use():
    still = changed(FLIGHT, dr=0.02, da=np.nan)
    assert all(
        text in explain_no_maneuvers(still) for text in ("dr is constant", "da was not measured")
    )
    found = tuple(replace(one, use=False) for one in collect_maneuvers(FLIGHT, AIRCRAFT).maneuvers)
    assert explain_no_maneuvers(FLIGHT, found).count("excluded manually") == len(found)
    assert "no fast input" in explain_no_maneuvers(FLIGHT)


def test_a_window_on_the_ground_is_told_and_one_that_only_seems_so_is_obeyed():
    given = ["5:12", "59:65"]
    surveyed = collect_maneuvers(FLIGHT, AIRCRAFT, given=given)
    told = [one for one in surveyed.remarks if "not flown" in one]
    assert len(told) == 1
    assert told[0].startswith("maneuver 1 ")
    assert surveyed.on_ground == ("1",)
    slow = changed(FLIGHT, V=0.5 * FLIGHT.block["V"])
    doubted = collect_maneuvers(slow, AIRCRAFT, given=given[1:])
    assert not doubted.on_ground
    unknown = collect_maneuvers(changed(FLIGHT, V=np.nan), AIRCRAFT, given=given)
    assert not [one for one in unknown.remarks if "not flown" in one]
    assert not unknown.on_ground
