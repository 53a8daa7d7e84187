"""Grades say what is wrong with a maneuver; the noise floor is that of the instruments."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.flight import Flight
from gsapp.flight.maneuvers import DetectedManeuver, detect_maneuvers, run_detector
from gsapp.flight.maneuvers.input_measures import GradingContext, ManeuverSamples
from gsapp.flight.maneuvers.maneuver_grade import grade_maneuver
from gsapp.flight.maneuvers.noise_floor import window_noise
from gsapp.flight.maneuvers.signals import SIGNALS
from gsapp.quantities.constants import DEGREE, GRAVITY
from tests.flight.maneuver_kit import NOISE, Input, changed, flight_of, make_flight

AIRCRAFT = load_aircraft("b777")
AT = 60.0


def made(size: float = 5.0, **options: object) -> Flight:
    return make_flight([Input(at=AT, surface="de", size=size)], seed=2, **options)  # type: ignore[arg-type]


def graded(flight: Flight) -> DetectedManeuver:
    (found,) = detect_maneuvers(flight, AIRCRAFT)
    return found


def during(flight: Flight, start: float, stop: float) -> np.ndarray:
    times = flight.block.times
    return (times >= start) & (times < stop)


def test_a_clean_doublet_is_an_a_without_reasons():
    found = graded(made())
    assert (found.grade, found.reasons) == ("A", ())


def test_a_start_out_of_trim_is_told_by_its_rate():
    flight = made()
    rolling = flight.block["p"] + 9.0 * DEGREE * during(flight, AT - 3.0, AT + 6.0)
    found = graded(changed(flight, p=rolling))
    assert found.grade == "B"
    assert "rolling" in found.reasons[0]
    tumbling = flight.block["p"] + 20.0 * DEGREE * during(flight, AT - 3.0, AT + 6.0)
    assert graded(changed(flight, p=tumbling)).grade == "C"


def test_defects_add_up_to_a_grade():
    flight = made()
    late = during(flight, AT - 3.0, AT + 6.0)
    rolling = {rate: flight.block["p"] + rate * DEGREE * late for rate in (9.0, 20.0)}
    throttle = {share: 0.5 + share * during(flight, AT, AT + 9.0) for share in (0.14, 0.3)}
    q = {seconds: np.array(flight.block["q"]) for seconds in (0.2, 0.6)}
    for seconds, samples in q.items():
        samples[during(flight, AT + 0.5, AT + 0.5 + seconds)] = 90.0 * DEGREE
    for grade, channels in (
        ("A", {"throttle": throttle[0.14]}),
        ("B", {"throttle": throttle[0.3]}),
        ("B", {"q": q[0.2]}),
        ("C", {"throttle": throttle[0.3], "p": rolling[9.0]}),
        ("C", {"q": q[0.6]}),
        ("C", {"p": rolling[20.0]}),
        ("D", {"q": q[0.6], "p": rolling[20.0]}),
    ):
        found = graded(changed(flight, **channels))
        assert found.grade == grade, (list(channels), found.reasons)
        assert len(found.reasons) == len(channels) - (grade == "A")
    # The worst is said first.
    both = graded(changed(flight, throttle=throttle[0.3], p=rolling[20.0]))
    assert ["rolling" in reason for reason in both.reasons] == [True, False]


def test_where_nothing_moved_there_is_nothing_to_learn():
    passage = ManeuverSamples(
        times=np.zeros(0), rows=np.zeros((0, len(SIGNALS))), t_input=0.0, t_input_end=1.0, t_end=3.0
    )
    setting = GradingContext(aircraft=AIRCRAFT, noise=run_detector(made(), AIRCRAFT).noise)
    grade, reasons = grade_maneuver(passage, setting, ())
    assert (grade, len(reasons)) == ("D", 1)


@pytest.mark.parametrize(("size", "grade"), [(1.2, "A"), (3.0, "B"), (7.0, "C")])
def test_another_stick_counts_by_its_share_of_the_travel(size: float, grade: str):
    flight = made(size=5.0)
    ramp = np.clip(flight.block.times - AT, 0.0, 1.0)
    found = graded(changed(flight, da=flight.block["da"] + size * DEGREE * ramp))
    assert (found.inputs, found.grade) == (("de",), grade), found.reasons


def test_too_small_an_input_is_told_by_its_answer():
    flight = made(size=3.0)
    random = np.random.default_rng(8)
    loud = {
        name: flight.block[name] + 10.0 * NOISE[name] * random.standard_normal(len(flight.block))
        for name in ("q", "an", "alpha")
    }
    (found,) = detect_maneuvers(changed(flight, **loud), AIRCRAFT) or (None,)
    # Buried in the noise it is no maneuver at all, or one that says so.
    assert found is None or any("too small" in reason for reason in found.reasons)
    modest = {
        name: flight.block[name] + 2.5 * NOISE[name] * random.standard_normal(len(flight.block))
        for name in ("q", "an", "alpha")
    }
    found = graded(changed(flight, **modest))
    assert any("too small" in reason and "times its noise" in reason for reason in found.reasons)


@pytest.mark.parametrize("side", [12.0, -20.0])
def test_an_excursion_beyond_the_linear_range_is_too_large(side: float):
    flight = made()
    alpha = flight.block["alpha"] + side * DEGREE * during(flight, AT + 0.5, AT + 2.0)
    (told,) = (each for each in graded(changed(flight, alpha=alpha)).reasons if "alpha" in each)
    reached = float(told.removeprefix("too large: alpha reached ").split()[0])
    end = (np.max if side > 0.0 else np.min)(alpha[during(flight, AT, AT + 2.0)]) / DEGREE
    assert reached == pytest.approx(end, abs=1.5)


def test_clipped_samples_are_counted():
    flight = made()
    q = np.array(flight.block["q"])
    q[during(flight, AT + 0.5, AT + 0.7)] = 90.0 * DEGREE
    found = graded(changed(flight, q=q))
    assert any("q clipped in 20 samples" in reason for reason in found.reasons)


def test_another_stick_is_named_with_its_size():
    flight = made()
    da = flight.block["da"] + 2.0 * DEGREE * np.clip(flight.block.times - AT, 0.0, 1.5) / 1.5
    found = graded(changed(flight, da=da))
    assert found.inputs == ("de",)
    assert any("da moved" in reason for reason in found.reasons)


def test_gusts_are_told_from_what_happens_before_the_input():
    calm, rough = graded(made(gusts=0.0)), graded(made(gusts=6.0))
    assert not any("turbulence" in reason for reason in calm.reasons)
    assert any("turbulence" in reason for reason in rough.reasons)
    assert rough.grade > calm.grade


def test_throttle_and_load_count_as_trim():
    flight = made()
    moved = 0.5 + 0.3 * during(flight, AT, AT + 9.0)
    assert any("throttle moved by 30" in r for r in graded(changed(flight, throttle=moved)).reasons)
    pulling = flight.block["an"] + 0.5 * GRAVITY * during(flight, AT - 3.0, AT + 6.0)
    assert any("a_n is 1." in r for r in graded(changed(flight, an=pulling)).reasons)


def test_a_short_free_answer_is_told():
    flight = made()
    taken = flight.block["de"] - 4.0 * DEGREE * np.clip(flight.block.times - (AT + 1.9), 0.0, 1.0)
    taken = np.where(flight.block.times > AT + 8.0, flight.block["de"], taken)
    found = graded(changed(flight, de=taken))
    assert found.t_end == pytest.approx(AT + 1.95, abs=0.15)
    assert any("hands off for" in reason for reason in found.reasons)


def test_a_stuck_sensor_and_a_missing_one_are_named():
    flight = made()
    held = changed(flight, q=0.01, alpha=np.nan)
    found = graded(held)
    assert any("q is constant" in reason for reason in found.reasons)
    assert any("not measured: alpha" in reason for reason in found.reasons)
    assert found.alpha is None


def test_a_rudder_lost_in_flight_makes_an_aileron_maneuver_unfit():
    flight = make_flight([Input(at=AT, surface="da", size=5.0)], seed=2)
    lost = np.where(flight.block.times > AT - 10.0, np.nan, flight.block["dr"])
    assert "was lost" not in str(graded(flight).reasons)
    # A broken wire reads nothing, or what no rudder can.
    for broken in (lost, np.where(np.isnan(lost), 68.0 * DEGREE, lost)):
        found = graded(changed(flight, dr=broken))
        assert found.grade == "D"
        assert found.reasons[0].startswith("dr was lost")
    never = graded(changed(flight, dr=np.nan))
    assert "was lost" not in str(never.reasons)


def test_missing_samples_are_told_as_a_share():
    flight = made()
    q = np.array(flight.block["q"])
    q[during(flight, AT + 1.0, AT + 2.5)] = np.nan
    found = graded(changed(flight, q=q))
    assert any("% of q is missing" in reason for reason in found.reasons)


def test_no_answer_at_all_is_no_maneuver():
    flight = made()
    random = np.random.default_rng(3)
    dead = {
        name: NOISE[name] * random.standard_normal(len(flight.block))
        for name in ("p", "q", "r", "ay", "an", "alpha", "beta")
    }
    assert detect_maneuvers(changed(flight, **dead), AIRCRAFT) == ()


# Noise floor ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["q", "an", "alpha", "de"])
def test_the_noise_floor_is_measured_before_take_off(name):
    flight = make_flight(ground=60.0, seconds=100.0, range_check=[(20.0, "de"), (30.0, "de")])
    detector = run_detector(flight, AIRCRAFT)
    assert detector.noise.std_of(name) == pytest.approx(NOISE[name], rel=0.1)
    assert "before take-off" in detector.noise.source
    assert 50.0 < detector.noise.duration < 70.0


def test_the_engines_make_the_noise_floor_not_the_silence_before_them():
    """Engines start after 40 of 80 s on the ground: only what they shake counts."""
    flight = make_flight(ground=80.0, seconds=110.0)
    times = flight.block.times
    random = np.random.default_rng(1)
    quiet = {
        name: np.where(times < 40.0, 0.05 * DEGREE * random.standard_normal(times.size), samples)
        for name, samples in ((name, flight.block[name]) for name in ("p", "q", "r"))
    }
    detector = run_detector(changed(flight, **quiet), AIRCRAFT)
    assert detector.noise.std_of("q") == pytest.approx(NOISE["q"], rel=0.1)
    assert "gyros" in detector.noise.source
    turning = np.where(times < 40.0, 0.0, 800.0)
    with_rpm = {**{n: flight.block[n] for n in flight.block.channels}, "rpm_left": turning}
    detector = run_detector(flight_of(with_rpm, times), AIRCRAFT)
    assert "engines running" in detector.noise.source
    assert 35.0 < detector.noise.duration < 45.0


@pytest.mark.parametrize("rate", [10.0, 25.0, 100.0])
def test_a_record_that_is_all_input_shows_its_noise_and_not_the_input(rate):
    """Elevator and rates move throughout; noise is what changes faster than they can."""
    inputs = [Input(at=0.2, surface="de", kind="3-2-1-1", size=13.0, step=0.8)]
    flight = make_flight(inputs, ground=0.0, seconds=6.0, steering=0.0, rate=rate)
    noise = run_detector(flight, AIRCRAFT).noise
    assert noise.duration == pytest.approx(6.0)
    for name in ("de", "q", "an"):
        assert noise.std_of(name) == pytest.approx(NOISE[name], rel=0.8)


def test_quantized_and_repeated_values_are_no_noise():
    flight = make_flight([Input(at=2.0, surface="de")], ground=0.0, seconds=8.0, steering=0.0)
    step = 0.5 * DEGREE
    held = np.repeat(flight.block["q"][::5], 5)[: len(flight.block)]
    coarse = changed(flight, de=np.round(flight.block["de"] / step) * step, q=held)
    noise = run_detector(coarse, AIRCRAFT).noise
    assert noise.std_of("de") < 1.5 * NOISE["de"]
    assert noise.std_of("q") < 1.5 * NOISE["q"]


def test_windows_are_freed_of_their_line_and_stand_missing_samples():
    random = np.random.default_rng(0)
    rows = np.column_stack(
        [random.standard_normal(200) + 0.3 * np.arange(200), np.full(200, np.nan), np.arange(200)]
    )
    rows[::7, 0] = np.nan
    found = window_noise(rows.astype(float))
    assert found[0] == pytest.approx(1.0, rel=0.15)
    assert np.isnan(found[1])
    assert found[2] == pytest.approx(0.0, abs=1e-9)


def test_ten_samples_are_too_few():
    flight = made()
    block = flight.block
    part = replace(block, times=block.times[6010:6020], values=block.values[6010:6020])
    assert detect_maneuvers(replace(flight, block=part), AIRCRAFT) == ()
