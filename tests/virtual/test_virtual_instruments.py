"""The instruments: vibration that folds, gyros that clip, volts that come back as they were."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from calibration.adc import ADC_RESOLUTION
from calibration.certificate_toml import load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.foundation import UnknownNameError
from gsapp.virtual.ad_converter import DAQ_CHANNELS, AnalogDigitalConverter
from gsapp.virtual.instruments import EngineVibration, Instruments
from gsapp.virtual.virtual_flight import VirtualFlight

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
