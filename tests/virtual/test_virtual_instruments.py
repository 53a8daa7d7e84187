"""The instruments: vibration that folds, gyros that clip, hidden effects, faults asked for."""

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from calibration.adc import ADC_RESOLUTION
from calibration.certificate_toml import load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.cli.fly import fly as fly_command
from gsapp.dynamics.model import load_model
from gsapp.dynamics.terms import effect_ids
from gsapp.flight.flight_loader import load_flight
from gsapp.foundation import FileProblemsError, FlightError, UnknownNameError, read_toml
from gsapp.quantities.constants import DEGREE
from gsapp.virtual import airframe
from gsapp.virtual.airframe import INSTRUMENT_INPUT_CHANNELS, TRUTH_CHANNELS, Airframe
from gsapp.virtual.flight_plan import FlightPlan, load_flight_plan
from gsapp.virtual.instruments import (
    DAQ_CHANNELS,
    AnalogDigitalConverter,
    EngineVibration,
    Instruments,
    SensorFault,
    SensorFaultInjector,
    parse_sensor_fault,
)
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.sticks import StickPositions
from gsapp.virtual.virtual_flight import (
    FlightSegment,
    FlightSimulation,
    VirtualFlight,
    add_hidden_effects,
)

DEG = math.pi / 180.0
DT = 0.01
FULL = 19000 * math.pi / 30


def _peak_frequency(samples: np.ndarray) -> float:
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(samples.size)))
    return float(np.argmax(spectrum) / (samples.size * DT))


@settings(max_examples=30, deadline=None)
@given(rpm=st.floats(7000, 25000))
def test_vibration_folds_to_the_nearest_multiple_of_the_sampling_rate(rpm: float) -> None:
    vibration = EngineVibration(1.4 * DEG, FULL, 1, np.random.default_rng(0))
    shaken = vibration.vibration_rates(np.full((2000, 1), rpm * math.pi / 30), DT)
    frequency = rpm / 60.0
    folded = abs(frequency - 100.0 * round(frequency / 100.0))
    assert _peak_frequency(shaken[:, 1]) == pytest.approx(folded, abs=0.1)


@pytest.mark.parametrize("rpm", [12000, 18000])
def test_the_two_speeds_that_fold_to_zero_frequency(rpm: float) -> None:
    vibration = EngineVibration(1.4 * DEG, FULL, 1, np.random.default_rng(1))
    shaken = vibration.vibration_rates(np.full((500, 1), rpm * math.pi / 30), DT)
    assert np.ptp(shaken[:, 0]) < 1e-6


def test_two_engines_beat() -> None:
    vibration = EngineVibration(1.4 * DEG, FULL, 2, np.random.default_rng(2))
    speeds = np.array([18180.0, 17820.0]) * math.pi / 30
    shaken = vibration.vibration_rates(np.tile(speeds, (2000, 1)), DT)
    assert _peak_frequency(shaken[:, 1]) == pytest.approx(3.0, abs=0.1)


def test_gyros_of_a_flight_show_the_folded_vibration(short_flight: VirtualFlight) -> None:
    truth, measured = short_flight.truth, short_flight.measured
    engines = short_flight.phase("engines running")[0]
    full = measured.between(engines + 3.8, engines + 4.9)
    assert 0.4 * DEG < np.std(full["q"]) < 1.6 * DEG
    speed = truth.between(engines + 3.8, engines + 4.9)
    frequencies = [np.mean(speed[name]) / (2 * math.pi) for name in ("rpm_left", "rpm_right")]
    folded = [abs(f - 100.0 * round(f / 100.0)) for f in frequencies]
    f, power = signal.periodogram(full["q"], 1.0 / DT, window="hann")
    near = np.min([np.abs(f - one) for one in folded], axis=0) < 2.5
    assert power[near].sum() > 0.7 * power.sum()


def test_the_noise_before_the_engines_start_is_small(short_flight: VirtualFlight) -> None:
    before = short_flight.measured.between(0.0, short_flight.phase("engines running")[0])
    assert np.std(before["q"]) < 0.2 * DEG


def test_rate_gyros_clip_at_90_degrees_a_second() -> None:
    """What turns faster is shown as 90 deg/s; accelerometers stop at 4 g."""
    aircraft = load_aircraft("b777")
    instruments = Instruments(aircraft, np.random.default_rng(0), DT)
    exposed = {name: np.zeros(50) for name in DAQ_CHANNELS}
    exposed["p"] = np.full(50, 130 * DEG)
    exposed["r"] = np.full(50, -130 * DEG)
    exposed["an"] = np.full(50, 6 * 9.80665)
    exposed["excitation"], exposed["battery"] = np.full(50, 4.96), np.full(50, 12.0)
    exposed["static_pressure"], exposed["temperature"] = np.full(50, 97e3), np.full(50, 288.0)
    shown = instruments.read(exposed, np.zeros((50, 2)))
    assert shown["p"] == pytest.approx(90 * DEG)
    assert shown["r"] == pytest.approx(-90 * DEG)
    assert shown["an"] == pytest.approx(4 * 9.80665)
    converter = AnalogDigitalConverter(load_certificates("b777"))
    measured = converter.convert_volts(converter.volts(shown))
    assert measured["p"] == pytest.approx(90 * DEG, abs=0.06 * DEG)


def test_all_but_the_rates_pass_a_50_hz_filter() -> None:
    aircraft = load_aircraft("b777")
    instruments = Instruments(aircraft, np.random.default_rng(0), DT)
    times = np.arange(400) * DT
    tone = np.sin(2 * math.pi * 40.0 * times)
    exposed = {name: np.zeros(400) for name in DAQ_CHANNELS}
    exposed["ay"], exposed["q"] = 10.0 * tone, tone
    shown = instruments.read(exposed, np.zeros((400, 2)))
    assert np.std(shown["ay"][100:]) < 0.85 * np.std(exposed["ay"])
    assert np.std(shown["q"][100:]) == pytest.approx(np.std(tone), rel=0.02)


def test_volts_come_back_as_the_values_within_one_count() -> None:
    """Through certificate, 12 bits and back: no error beyond the width of one count."""
    certificates = load_certificates("b777")
    converter = AnalogDigitalConverter(certificates)
    random = np.random.default_rng(5)
    count = 500
    values = {}
    for name in DAQ_CHANNELS:
        if name in certificates:
            ends = np.sort(certificates[name].evaluate(np.array(certificates[name].range)))
            middle, width = ends.mean(), 0.45 * np.ptp(ends)
            values[name] = random.uniform(middle - width, middle + width, count)
    values["excitation"] = np.full(count, 4.96)
    values["battery"] = random.uniform(9.0, 13.0, count)
    volts = converter.volts(values)
    assert np.all(volts / ADC_RESOLUTION == np.round(volts / ADC_RESOLUTION))
    assert volts.min() >= 0.0
    assert volts.max() < 5.0
    measured = converter.convert_volts(volts)
    for column, name in enumerate(DAQ_CHANNELS):
        if name not in certificates:
            continue
        one_count = np.abs(
            certificates[name].evaluate(volts[:, column] + ADC_RESOLUTION, values["excitation"])
            - certificates[name].evaluate(volts[:, column], values["excitation"])
        )
        error = np.abs(measured[name] - values[name])
        # The supply is read in whole counts as well.
        assert np.all(error <= 1.2 * one_count + 2e-4 * np.abs(values[name])), name
    assert measured["battery"] == pytest.approx(values["battery"], abs=2.5 * ADC_RESOLUTION + 1e-9)


def test_an_instrument_without_certificate_is_named() -> None:
    certificates = load_certificates("b777")
    del certificates["rudder"]
    with pytest.raises(UnknownNameError, match="rudder"):
        AnalogDigitalConverter(certificates)


def test_measured_follows_truth(short_flight: VirtualFlight) -> None:
    truth, measured = short_flight.truth, short_flight.measured
    start, stop = short_flight.phase("climb")[0], short_flight.phase("final")[0]
    flown, recorded = truth.between(start, stop), measured.between(start, stop)
    for name, tolerance in (("q", 1.5 * DEG), ("r", 1.5 * DEG), ("de", 0.3 * DEG)):
        assert np.std(recorded[name] - flown[name]) < tolerance, name
    # The vane sits ahead of the CG and sees the pitch rate, alpha - q x/V + p y/V.
    x, y, _ = load_aircraft("b777").sensors.alpha_vane.position
    expected = flown["alpha"] - flown["q"] * x / flown["V"] + flown["p"] * y / flown["V"]
    assert np.std(recorded["alpha"] - expected) < 0.25 * DEG
    assert np.std(recorded["alpha"] - flown["alpha"]) > np.std(recorded["alpha"] - expected)


ROWS = 250
SURFACES = ("elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder")


def ride(*hide: str) -> tuple[np.ndarray, np.ndarray]:
    """Return truth and exposures of a take-off run with the sticks moved, one row a step."""
    aircraft = load_aircraft("b777")
    frame = Airframe(
        load_flight_plan("short"),
        aircraft,
        add_hidden_effects(aircraft, load_model("b777"), hide),
        turbulence=0.0,
        random=np.random.default_rng(5),
        dt=DT,
    )
    truth, exposed = [], []
    for step in range(ROWS):
        time = step * DT
        frame.advance(
            StickPositions(
                throttle=1.0,
                pitch=0.3 * float(np.sin(9.0 * time)),
                roll=0.2 * float(np.sin(7.0 * time)),
                yaw=0.1 * float(np.sin(5.0 * time)),
                flap=0.5,
                engines=True,
                high_rate=True,
            )
        )
        truth.append(frame.truth())
        exposed.append(frame.instrument_inputs())
        frame.onboard_values()
    return np.array(truth), np.array(exposed)


@pytest.fixture(scope="module")
def plain() -> tuple[np.ndarray, np.ndarray]:
    return ride()


def shown(exposed: np.ndarray, name: str) -> np.ndarray:
    return np.asarray(exposed[:, INSTRUMENT_INPUT_CHANNELS.index(name)])


def late(signal: np.ndarray, by: float) -> np.ndarray:
    times = DT * np.arange(signal.size)
    return np.interp(times - by, times, signal)


def changed(one: np.ndarray, other: np.ndarray) -> set[str]:
    return {
        name
        for k, name in enumerate(INSTRUMENT_INPUT_CHANNELS)
        if not np.array_equal(one[:, k], other[:, k])
    }


def test_a_late_potentiometer_leaves_the_surface_alone(plain) -> None:
    truth, exposed = ride("sensor.de.delay:delay=0.02")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {"elevator_left", "elevator_right"}
    # Left and right differ by the rigging, which is not late.
    mean = 0.5 * (shown(exposed, "elevator_left") + shown(exposed, "elevator_right"))
    true = plain[0][:, TRUTH_CHANNELS.index("de")]
    assert np.allclose(mean[5:], late(true, 0.02)[5:], atol=1e-12)


def test_a_box_of_surfaces_is_late_as_a_whole(plain) -> None:
    truth, exposed = ride("sensor.surfaces.delay:delay=0.03")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {*SURFACES, "flap"}
    for name in ("rudder", "flap"):
        assert np.allclose(
            shown(exposed, name)[5:], late(shown(plain[1], name), 0.03)[5:], atol=1e-12
        )


def test_late_air_data_makes_the_pressure_late_once(plain) -> None:
    truth, exposed = ride("sensor.airdata.delay:delay=0.1")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {"alpha", "beta", "dynamic_pressure"}
    pressure = shown(plain[1], "dynamic_pressure")
    assert pressure.max() > 20.0
    found = shown(exposed, "dynamic_pressure")
    # The speed is late, the density from which the pressure follows is not.
    assert np.allclose(found[15:], late(pressure, 0.1)[15:], rtol=1e-6)


def test_swapped_accelerometers(plain) -> None:
    truth, exposed = ride("sensor.ax_an.swapped")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {"ax", "an"}
    assert np.array_equal(shown(exposed, "ax"), shown(plain[1], "an"))
    assert np.array_equal(shown(exposed, "an"), shown(plain[1], "ax"))


def test_a_misplaced_accelerometer(plain) -> None:
    truth, exposed = ride("sensor.accelerometer.x:x=0.5")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {"ax", "ay", "an"}
    q = plain[0][:, TRUTH_CHANNELS.index("q")]
    p, r = plain[0][:, TRUTH_CHANNELS.index("p")], plain[0][:, TRUTH_CHANNELS.index("r")]
    extra = shown(exposed, "an") - shown(plain[1], "an")
    expected = 0.5 * (np.gradient(q, DT) - p * r)
    assert np.corrcoef(extra[5:], expected[5:])[0, 1] > 0.95


def test_a_clipped_gyro(plain) -> None:
    limit = 0.5 * float(np.abs(shown(plain[1], "q")).max())
    truth, exposed = ride(f"sensor.q.clipping:limit={limit!r}")
    assert np.array_equal(truth, plain[0])
    assert np.array_equal(shown(exposed, "q"), np.clip(shown(plain[1], "q"), -limit, limit))


def test_what_comes_early_cannot_be_flown() -> None:
    with pytest.raises(FlightError, match="must not be negative"):
        ride("sensor.airdata.delay:delay=-0.1")


def test_every_effect_can_be_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(airframe, "VIRTUAL", replace(VIRTUAL, settling_time=0.03))
    aircraft, model, plan = load_aircraft("b777"), load_model("b777"), load_flight_plan("short")
    sticks = StickPositions(throttle=1.0, pitch=0.2, roll=0.1, yaw=0.1, flap=0.5, engines=True)
    for name in effect_ids():
        frame = Airframe(
            plan,
            aircraft,
            add_hidden_effects(aircraft, model, (name,)),
            turbulence=0.0,
            random=np.random.default_rng(1),
            dt=DT,
        )
        for _ in range(5):
            frame.advance(sticks)
            seen = (*frame.instrument_inputs(), *frame.truth(), *frame.onboard_values())
            assert np.isfinite(seen).all(), name


ALPHA, BETA, Q = (DAQ_CHANNELS.index(name) for name in ("alpha", "beta", "q"))
COUNT = 2200
FAULTS = (
    "alpha:dropout:every=0.9 s,length=0.1 s",
    "beta:stuck:start=5 s,end=12 s",
    "q:clip:low=-0.5 deg/s,high=0.5 deg/s",
)


def _flight(*faults: str) -> FlightSimulation:
    return FlightSimulation(
        load_flight_plan("short"), aircraft=load_aircraft("b777"), seed=3, faults=faults
    )


@pytest.fixture(scope="module")
def whole() -> FlightSegment:
    return _flight().advance(COUNT)


@pytest.fixture(scope="module")
def broken() -> FlightSegment:
    return _flight(*FAULTS).advance(COUNT)


def test_a_fault_breaks_its_own_channel_only(whole: FlightSegment, broken: FlightSegment) -> None:
    assert np.array_equal(broken.truth, whole.truth)
    others = [column for column in range(len(DAQ_CHANNELS)) if column not in (ALPHA, BETA, Q)]
    assert np.array_equal(broken.volts[:, others], whole.volts[:, others])


def test_dropouts_are_open_inputs_of_the_length_and_number_asked_for(
    whole: FlightSegment, broken: FlightSegment
) -> None:
    volts = broken.volts[:, ALPHA]
    gone = volts == 0.0
    assert np.array_equal(volts[~gone], whole.volts[~gone, ALPHA])
    # 22 are to be expected in 22 s; a tenth of the time is gone.
    assert 10 <= np.count_nonzero(np.diff(gone.astype(int)) == 1) <= 40
    assert 0.04 < gone.mean() < 0.2


def test_a_stuck_vane_repeats_the_sample_at_the_beginning(
    whole: FlightSegment, broken: FlightSegment
) -> None:
    volts = broken.volts[:, BETA]
    assert np.ptp(volts[500:1200]) <= 0.002  # the supply still ripples by one count
    assert np.ptp(whole.volts[500:1200, BETA]) > 0.01
    for part in (slice(0, 501), slice(1200, None)):
        assert np.array_equal(volts[part], whole.volts[part, BETA])


def test_clipped_samples_stop_at_the_limit_given_with_its_unit(
    whole: FlightSegment, broken: FlightSegment
) -> None:
    measured = _flight().converter.convert_volts
    assert np.abs(measured(broken.volts)["q"]).max() < 0.6 * DEGREE
    assert np.abs(measured(whole.volts)["q"]).max() > 1.0 * DEGREE


@settings(max_examples=30, deadline=None)
@given(
    cuts=st.lists(st.integers(0, 400), max_size=8),
    kind=st.sampled_from(["dropout", "stuck", "clip"]),
    every=st.sampled_from([None, 0.02, 0.3]),
    start=st.floats(0.0, 3.0),
)
def test_cutting_a_flight_into_other_pieces_breaks_the_same_samples(
    cuts: list[int], kind: str, every: float | None, start: float
) -> None:
    content = {"channel": "alpha", "kind": kind, "start": f"{start} s", "end": "3.5 s"}
    if every is not None:
        content |= {"every": f"{every} s", "length": "0.05 s"}
    if kind == "clip":
        content["low"] = "-1 deg"
    fault = SensorFault.model_validate(content)
    values = np.random.default_rng(0).normal(size=400)
    one = SensorFaultInjector(fault, 0.01, np.random.default_rng(7)).apply(values, 0)
    other = SensorFaultInjector(fault, 0.01, np.random.default_rng(7))
    edges = [0, *sorted(cuts), 400]
    pieces = [other.apply(values[a:b], a) for a, b in itertools.pairwise(edges)]
    assert np.array_equal(np.concatenate(pieces), one, equal_nan=True)


def test_a_plan_can_hold_faults_and_names_all_mistakes(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text('[[faults]]\nchannel = "alpha"\nkind = "stuck"\nstart = "10 s"\n')
    plan = read_toml(path, FlightPlan)
    assert plan.faults == (parse_sensor_fault("alpha:stuck:start=10 s"),)
    path.write_text(
        '[[faults]]\nchannel = "alfa"\nkind = "stuck"\n'
        '[[faults]]\nchannel = "alpha"\nkind = "clip"\n'
        '[[faults]]\nchannel = "q"\nkind = "clip"\nhigh = "3 ft"\n'
    )
    with pytest.raises(FileProblemsError) as caught:
        read_toml(path, FlightPlan)
    said = [str(problem) for problem in caught.value.problems]
    assert len(said) == 3
    assert "'alfa'" in said[0]
    assert "one or both" in said[1]
    assert "'ft'" in said[2]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("alpha", "kind"),
        ("alpha:jam", "kind"),
        ("alpha:stuck:from=3", "from: is not a known key"),
        ("alpha:stuck:start", "is not PARAM=VALUE"),
        ("alpha:stuck:start=soon", "does not begin with a number"),
        ("alpha:stuck:start=9 s,end=3 s", "ends before it begins"),
        ("alpha:dropout:every=3 s", "belong together"),
        ("alpha:dropout:every=0 s,length=1 s", "every"),
        ("alpha:stuck:low=3 deg", "belong to clip"),
        ("alpha:clip:low=3 deg,high=-3 deg", "swap 'low' and 'high'"),
    ],
)
def test_what_is_no_fault_gets_one_sentence(text: str, words: str) -> None:
    with pytest.raises(FlightError, match=words) as caught:
        parse_sensor_fault(text)
    assert "\n" not in str(caught.value)


@pytest.mark.long
def test_a_broken_vane_goes_all_the_way_into_the_flight(tmp_path: Path) -> None:
    fly_command(out=tmp_path / "flight", plan="short", seed=3, faults=("alpha:stuck",))
    block = load_flight(tmp_path / "flight").block
    spread = {name: np.ptp(block[name][np.isfinite(block[name])]) for name in ("alpha", "beta")}
    assert spread["alpha"] < 1.0 * DEGREE
    assert spread["beta"] > 10.0 * DEGREE
