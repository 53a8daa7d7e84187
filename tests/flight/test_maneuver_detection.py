"""Maneuvers of a flight: each is found, nothing else is, however the samples come in."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.flight import Flight, load_flight
from gsapp.flight.maneuvers import ManeuverDetector, detect_maneuvers, run_detector
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector, flying_speed
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS
from gsapp.foundation import FlightError
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.flight.maneuver_kit import (
    COMBINED,
    EVERYTHING,
    Input,
    changed,
    flight_of,
    lagged,
    make_flight,
)

AIRCRAFT = load_aircraft("b777")
AIR_DATA = ("V", "alpha", "beta")


@pytest.fixture(scope="module")
def flown(flown_short: Callable[[int], VirtualFlight]) -> VirtualFlight:
    return flown_short(6)


def test_it_flies_from_a_little_above_the_stall_until_a_little_below():
    watch, stall = AirborneDetector(AIRCRAFT), flying_speed(AIRCRAFT)
    means = np.full(len(SIGNALS), np.nan)
    told = []
    shares = (0.0, 0.9, 1.0, 1.0, 1.2, 1.0, 1.1, 1.1, 0.95, 0.95, 0.8, 0.95, 0.85, 0.85, 1.0, 1.0)
    for number, share in enumerate(shares):
        means[SIGNAL_COLUMNS["V"]] = share * stall
        watch.add(number * DETECTION.frame_duration, means)
        told.append(watch.airborne)
    assert told == [7 <= number < 13 for number in range(len(shares))]
    assert watch.criterion == "airspeed"


@pytest.mark.parametrize("surface", ["de", "da", "dr"])
@pytest.mark.parametrize(
    ("kind", "size", "step"),
    [("doublet", 5.0, 0.45), ("doublet", -4.0, 0.8), ("3-2-1-1", 4.0, 0.35), ("pulse", 6.0, 0.6)],
)
def test_an_input_on_each_surface_is_found_with_its_shape(surface, kind, size, step):
    made = Input(at=70.0, surface=surface, kind=kind, size=size, step=step)
    (found,) = detect_maneuvers(make_flight([made], seed=3), AIRCRAFT)
    assert (found.inputs, found.kind) == ((surface,), kind)
    assert found.amplitude == pytest.approx(abs(size) * DEGREE, rel=0.15)
    assert found.t_input == pytest.approx(made.at, abs=0.1)
    assert found.t_input_end == pytest.approx(made.end, abs=0.4)
    assert found.t_start == pytest.approx(found.t_input - 1.0, abs=1e-9)
    # Hands are back on the sticks three seconds after the input.
    assert made.end + 2.0 < found.t_end < made.end + 4.5
    assert pytest.approx(30.0, abs=0.3) == found.V


def test_staggered_inputs_on_two_surfaces_are_one_maneuver():
    (found,) = detect_maneuvers(make_flight(COMBINED, seed=4), AIRCRAFT)
    assert found.inputs == ("da", "dr")
    assert found.amplitudes["da"] == pytest.approx(5.0 * DEGREE, rel=0.15)
    assert found.amplitudes["dr"] == pytest.approx(9.0 * DEGREE, rel=0.15)
    # The amplitude of the whole is that of the larger share of travel.
    assert found.amplitude == found.amplitudes["dr"]


def test_steering_alone_is_no_maneuver():
    for seed in range(10):
        flight = make_flight(seed=seed, steering=1.0 + 0.2 * seed, gusts=0.3 * (seed % 3))
        assert detect_maneuvers(flight, AIRCRAFT) == ()


def test_pulses_on_the_ground_are_the_range_check():
    checks = [(12.0, "de"), (15.0, "dr"), (112.0, "da")]
    made = Input(at=60.0, surface="de")
    flight = make_flight([made], range_check=checks, landing=95.0, seconds=125.0)
    (found,) = detect_maneuvers(flight, AIRCRAFT)
    assert found.t_start < made.at < found.t_end


@pytest.mark.parametrize(
    ("without", "words"),
    [
        (AIR_DATA, "rates and altitude"),
        ((*AIR_DATA, "altitude"), "rates"),
        (("V", "p", "q", "r"), "altitude"),
    ],
)
def test_maneuvers_are_found_without_air_data(without, words):
    checks = [(12.0, "de"), (15.0, "dr")]
    flight = make_flight(EVERYTHING, range_check=checks, seconds=130.0, without=without)
    detector = run_detector(flight, AIRCRAFT)
    assert [one.inputs for one in detector.finish()] == [
        ("de",), ("da",), ("dr",), ("da", "dr"), ("de",)
    ]  # fmt: skip
    assert detector.airborne_criterion == words


def test_an_airspeed_that_stays_low_in_flight_is_not_believed():
    flight = changed(make_flight(EVERYTHING, seconds=130.0), V=0.0)
    detector = run_detector(flight, AIRCRAFT)
    assert len(detector.finish()) == 5
    assert "below flying speed" in detector.airborne_criterion


def test_nothing_but_surfaces_still_gives_maneuvers():
    flight = make_flight([Input(at=60.0, surface="de")], ground=0.0, steering=0.5)
    bare = flight_of({name: flight.block[name] for name in ("de", "da", "dr")}, flight.block.times)
    detector = run_detector(bare, AIRCRAFT)
    (found,) = detector.finish()
    assert found.grade == "D"
    assert "no response to de" in found.reasons[0]
    assert detector.airborne_criterion == "nothing"


def test_single_wild_samples_are_no_input():
    flight = make_flight(seed=5)
    surface = np.array(flight.block["de"])
    surface[5000:11000:700] += 15.0 * DEGREE
    assert detect_maneuvers(changed(flight, de=surface), AIRCRAFT) == ()


def cut(block: Block, places: list[int]) -> list[Block]:
    bounds = [0, *sorted(places), len(block)]
    return [
        replace(block, times=block.times[low:high], values=block.values[low:high])
        for low, high in itertools.pairwise(bounds)
    ]


def results(blocks: list[Block]) -> list[object]:
    detector = ManeuverDetector(AIRCRAFT, 100.0)
    for block in blocks:
        detector.feed(block)
        detector.process_step()
    found = [one.to_record() for one in detector.finish()]
    return [found, dict(detector.noise.std), detector.airborne_criterion, detector.airborne]


CHUNKED = make_flight(EVERYTHING, seconds=125.0, range_check=[(12.0, "de")], gusts=0.3).block
WHOLE = results([CHUNKED])


@settings(max_examples=25, deadline=None)
@given(places=st.lists(st.integers(0, len(CHUNKED)), max_size=40))
def test_results_do_not_depend_on_chunks(places):
    assert results(cut(CHUNKED, places)) == WHOLE


def test_results_do_not_depend_on_chunks_of_a_few_samples():
    assert results(cut(CHUNKED, list(range(0, len(CHUNKED), 7)))) == WHOLE
    assert len(WHOLE[0]) == 5


def test_a_gap_ends_what_was_under_way_and_nothing_else():
    times = CHUNKED.times
    kept = (times < 72.3) | (times > 75.0)
    gappy = replace(CHUNKED, times=times[kept], values=CHUNKED.values[kept])
    found = results([gappy])[0]
    assert len(found) == 4
    assert all(not one["t_start"] < 73.0 < one["t_end"] for one in found)
    places = [int(np.searchsorted(gappy.times, 75.0)) - 3, 9000]
    assert results(cut(gappy, places)) == results([gappy])


def test_rows_without_a_sample_are_no_input():
    values = np.array(CHUNKED.values)
    values[(CHUNKED.times > 72.3) & (CHUNKED.times < 75.0)] = np.nan
    found = results([replace(CHUNKED, values=values)])[0]
    assert [one["inputs"] for one in found] == [["de"], ["dr"], ["da", "dr"], ["de"]]


def test_a_cue_can_be_given_seconds_after_the_input():
    """Fed as it would arrive, each maneuver is there at most six seconds after its input."""
    detector = ManeuverDetector(AIRCRAFT, 100.0)
    seen: dict[str, float] = {}
    for block in cut(CHUNKED, list(range(0, len(CHUNKED), 10))):
        detector.feed(block)
        for one in detector.maneuvers:
            seen.setdefault(one.id, float(block.times[-1]) - one.t_input_end)
    assert len(seen) >= 4
    assert max(seen.values()) < 6.0


def test_a_reset_forgets_everything():
    detector = ManeuverDetector(AIRCRAFT, 100.0)
    detector.feed(CHUNKED)
    detector.reset()
    detector.feed(CHUNKED)
    assert [one.to_record() for one in detector.finish()] == WHOLE[0]


@pytest.mark.parametrize("without_air_data", [False, True])
def test_a_flight_of_the_virtual_pilot(flown, without_air_data):
    lost = {"dynamic_pressure", "alpha", "beta"} if without_air_data else set()
    measured = flown.measured
    block = measured.select([name for name in measured.channels if name not in lost])
    flight = Flight(name="virtual", path=Path("virtual"), block=block, sources={})
    found = detect_maneuvers(flight, AIRCRAFT)
    assert [set(one.inputs) for one in found] == [set(one.inputs) for one in flown.maneuvers]
    for one, truth in zip(found, flown.maneuvers, strict=True):
        assert one.kind == truth.kind
        assert one.t_start == pytest.approx(truth.t_start - 1.0, abs=0.15)
        assert one.t_end == pytest.approx(truth.t_end, abs=0.4)


def test_a_log_of_another_aircraft_gives_no_maneuver(shared_data):
    flight = load_flight(shared_data / "alfa_carbonz_engine_failure.tlog")
    assert detect_maneuvers(flight, AIRCRAFT) == ()


def test_slower_records_show_their_inputs():
    for rate in (50.0, 25.0):
        flight = make_flight(EVERYTHING, seconds=125.0, rate=rate)
        found = detect_maneuvers(flight, AIRCRAFT)
        assert [one.inputs for one in found] == [
            ("de",), ("da",), ("dr",), ("da", "dr"), ("de",)
        ]  # fmt: skip


# Bad input ------------------------------------------------------------------------------


def test_a_flight_without_surfaces_says_so():
    flight = make_flight(without=("de", "da", "dr"), seconds=70.0)
    with pytest.raises(FlightError, match="it has p, q, r"):
        detect_maneuvers(flight, AIRCRAFT)


def test_a_flight_of_nothing_but_nan_says_so():
    flight = make_flight(seconds=70.0)
    empty = flight_of(
        {name: np.full(len(flight.block), np.nan) for name in flight.block.channels},
        flight.block.times,
    )
    with pytest.raises(FlightError, match="no sample"):
        detect_maneuvers(empty, AIRCRAFT)


def test_an_empty_flight_says_so():
    flight = flight_of({"de": np.empty(0)}, np.empty(0))
    with pytest.raises(FlightError, match="contains no samples"):
        detect_maneuvers(flight, AIRCRAFT)


def test_too_slow_a_record_says_so():
    with pytest.raises(FlightError, match="2 samples per second"):
        ManeuverDetector(AIRCRAFT, 2.0)


def test_infinite_samples_do_no_harm():
    flight = make_flight([Input(at=60.0, surface="de")])
    broken = np.array(flight.block["q"])
    broken[::50] = np.inf
    (found,) = detect_maneuvers(changed(flight, q=broken), AIRCRAFT)
    assert found.inputs == ("de",)


# Throttle and flap -------------------------------------------------------------------------


def with_levers(**moves: tuple[tuple[float, float, float], ...]) -> Flight:
    """Return a flight with held sticks whose levers go by steps (s, s to take, share or rad)."""
    flight = make_flight(seconds=110.0, steering=0.0)
    times, random = flight.block.times, np.random.default_rng(7)
    columns = {}
    for name, steps in moves.items():
        ramps = [size * np.clip((times - at) / wait, 0.0, 1.0) for at, wait, size in steps]
        columns[name] = 0.4 + np.sum(ramps, axis=0) + 0.001 * random.standard_normal(times.size)
    felt = sum(lagged(samples - 0.4, 0.3, 0.01) for samples in columns.values())
    return changed(flight, **columns, ax=flight.block["ax"] + 9.0 * felt)


def test_a_step_of_the_throttle_is_a_maneuver():
    (found,) = detect_maneuvers(with_levers(throttle=((60.0, 0.6, 0.3),)), AIRCRAFT)
    assert (found.inputs, found.kind) == (("throttle",), "step")
    assert found.amplitude == pytest.approx(0.3, abs=0.01)
    assert found.t_input == pytest.approx(60.0, abs=0.15)
    assert found.t_input_end == pytest.approx(60.6, abs=0.15)
    assert found.grade in "AB"


def test_doublets_of_the_throttle_and_flap_steps_are_named():
    doublet = ((60.0, 0.2, 0.3), (61.5, 0.2, -0.6), (63.0, 0.2, 0.3))
    (found,) = detect_maneuvers(with_levers(throttle=doublet), AIRCRAFT)
    assert (found.inputs, found.kind) == (("throttle",), "doublet")
    down, up = detect_maneuvers(with_levers(flap=((60.0, 3.0, 0.3), (80.0, 3.0, -0.3))), AIRCRAFT)
    assert down.inputs == up.inputs == ("flap",)
    assert down.kind == up.kind == "step"


def test_a_throttle_moved_with_the_sticks_or_on_the_ground_is_no_input():
    moved = with_levers(throttle=((10.0, 0.5, 0.3), (60.0, 0.5, 0.3)))
    (only,) = detect_maneuvers(moved, AIRCRAFT)
    assert only.t_input > 59.0
    times = moved.block.times
    stick = 5.0 * DEGREE * np.clip(times - 60.0, 0.0, 2.0)
    assert not detect_maneuvers(changed(moved, de=moved.block["de"] + stick), AIRCRAFT)
