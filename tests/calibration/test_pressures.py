"""Pressures: zero with the pitot covered, the breath that shows itself, the air on the ground."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibration import (
    CalibrationError,
    Certificate,
    load_certificate,
    load_certificates,
    write_certificate,
)
from calibration.pressures import (
    GroundAir,
    PitotBlowDetector,
    create_covered_pitot_monitor,
    dynamic_pressure_zero,
    static_pressure_check,
)
from gsapp.foundation import UnitError
from gsapp.virtual.bench import VirtualBench, parse_bench_fault
from tests.calibration.ground_crew import STAMP, rest

SHIPPED = load_certificates("b777")
DYNAMIC, STATIC = SHIPPED["dynamic_pressure"], SHIPPED["static_pressure"]
BOTH = ("dynamic_pressure", "static_pressure")


def zeroed(bench: VirtualBench) -> Certificate:
    bench.cover()
    found = rest(bench, create_covered_pitot_monitor(DYNAMIC, STATIC))
    return dynamic_pressure_zero(found, DYNAMIC, who="crew", stamp=STAMP).certificate


def watch_on(
    bench: VirtualBench, detector: PitotBlowDetector, seconds: float, cut: float
) -> list[str]:
    states = []
    until = bench.time + seconds
    while bench.time < until - 0.005:
        block = bench.step(min(cut, until - bench.time))
        detector.feed(block.times, {name: block[f"{name}_volts"] for name in BOTH})
        if not states or states[-1] != detector.status.state:
            states.append(detector.status.state)
    return states


@pytest.mark.parametrize("seed", range(2))
def test_a_covered_pitot_gives_the_zero(seed: int, tmp_path: Path) -> None:
    """To 1 Pa, with the slope kept; the file is read back the same."""
    bench = VirtualBench(seed)
    bench.cover()
    found = dynamic_pressure_zero(
        rest(bench, create_covered_pitot_monitor(DYNAMIC, STATIC)), DYNAMIC, who="crew", stamp=STAMP
    )
    truth = bench.pressures["dynamic_pressure"]
    assert float(found.certificate.evaluate(truth.zero)) == pytest.approx(0.0, abs=1.0)
    assert found.passed
    assert float(DYNAMIC.evaluate(truth.zero)) == pytest.approx(found.shift, abs=1.0)
    path = write_certificate(found.certificate, tmp_path / "dynamic_pressure.toml")
    volts = np.linspace(0.3, 4.7, 5)
    again, before = load_certificate(path).evaluate(volts), DYNAMIC.evaluate(volts)
    np.testing.assert_allclose(again, found.certificate.evaluate(volts), atol=1e-9)
    np.testing.assert_allclose(np.diff(again), np.diff(before), rtol=1e-9)
    pressures = np.array([0.0, 600.0, 2000.0])
    true_volts = truth.zero + truth.slope * pressures
    errors = np.abs(found.certificate.evaluate(true_volts) - pressures)
    assert np.all(errors < found.certificate.uncertainty(true_volts))
    assert np.all(found.certificate.uncertainty(true_volts) < 25.0)


@pytest.mark.parametrize("seed", range(3, 6))
def test_wind_is_no_zero(seed: int) -> None:
    bench = VirtualBench(seed)
    watch = create_covered_pitot_monitor(DYNAMIC)
    states = []
    for _ in range(40):
        block = bench.step(0.5)
        watch.feed(block.times, {"dynamic_pressure": block["dynamic_pressure_volts"]})
        states.append(watch.status.state)
    assert "rested" not in states
    bench.cover()
    assert rest(bench, watch, patience=8.0).uncertainty["dynamic_pressure"] < 2e-3


def test_a_zero_taken_in_a_lull_says_so_by_its_bound() -> None:
    for seed in range(3, 6):
        bench = VirtualBench(seed)
        found = rest(bench, create_covered_pitot_monitor(DYNAMIC, lull=True), patience=60.0)
        truth = bench.pressures["dynamic_pressure"]
        plain = dynamic_pressure_zero(found, DYNAMIC, who="crew", stamp=STAMP)
        windy = dynamic_pressure_zero(found, DYNAMIC, who="crew", stamp=STAMP, lull=True)
        off = abs(found.volts["dynamic_pressure"] - truth.zero)
        assert off < windy.uncertainty
        assert windy.uncertainty > 3.0 * plain.uncertainty
        stated = windy.certificate.uncertainty(truth.zero)
        assert float(windy.certificate.evaluate(truth.zero)) == pytest.approx(0.0, abs=stated)


def test_the_static_pressure_follows_the_barometer() -> None:
    bench = VirtualBench(5)
    bench.cover()
    found = static_pressure_check(
        rest(bench, create_covered_pitot_monitor(DYNAMIC, STATIC)), STATIC, bench.weather.pressure,
        who="crew", stamp=STAMP, temperature=bench.weather.temperature,
    )  # fmt: skip
    transducer = bench.pressures["static_pressure"]
    volts = transducer.zero + transducer.slope * bench.weather.pressure
    assert float(found.certificate.evaluate(volts)) == pytest.approx(bench.weather.pressure, abs=25)
    assert found.certificate.temperature == bench.weather.temperature
    far = static_pressure_check(
        rest(bench, create_covered_pitot_monitor(DYNAMIC, STATIC)), STATIC,
        bench.weather.pressure - 3000.0,
        who="crew", stamp=STAMP,
    )  # fmt: skip
    assert not far.passed


def test_a_breath_turns_green_by_itself() -> None:
    seen = []
    for cut in (0.13, 5.0):
        bench = VirtualBench(20)
        detector = PitotBlowDetector(zeroed(bench), STATIC)
        bench.uncover()
        assert watch_on(bench, detector, 5.0, cut) == ["waiting"], "wind is no breath"
        states = watch_on(bench, detector, bench.blow() + 1.0, cut)
        assert states[-1] == "green"
        if cut < 1.0:
            assert states == ["waiting", "blowing", "green"]
        assert detector.status.peak > 400.0
        seen.append(detector.status)
    assert seen[0] == seen[1]


def test_swapped_hoses_are_named() -> None:
    bench = VirtualBench(21, faults=[parse_bench_fault("dynamic_pressure:reversed")])
    detector = PitotBlowDetector(zeroed(bench), STATIC)
    watch_on(bench, detector, bench.blow() - 0.6, 0.05)
    assert detector.status.state == "reversed"
    assert "swapped" in detector.status.sentence


def made(pressure: np.ndarray, static: np.ndarray) -> dict[str, np.ndarray]:
    return {
        "dynamic_pressure": np.asarray(DYNAMIC.volts(pressure)),
        "static_pressure": np.asarray(STATIC.volts(static)),
    }


def test_a_breath_that_stays_or_leaks_is_named() -> None:
    times = np.arange(0.0, 20.0, 0.01)
    steady = np.full(times.size, 100e3)
    blown = np.where(times > 2.0, 900.0, 0.0)
    blocked = PitotBlowDetector(DYNAMIC, STATIC)
    blocked.feed(times, made(blown, steady))
    assert blocked.status.state == "blocked"
    short = np.where((times > 2.0) & (times < 3.5), 900.0, 0.0)
    leaking = PitotBlowDetector(DYNAMIC, STATIC)
    leaking.feed(times, made(short, steady + short))
    assert leaking.status.state == "leaking"
    knock = np.where((times > 2.0) & (times < 2.1), 900.0, 0.0)
    detector = PitotBlowDetector(DYNAMIC, STATIC)
    detector.feed(times, made(knock, steady))
    assert detector.status.state == "waiting", "a knock is no breath"


def test_an_open_input_gives_no_zero() -> None:
    bench = VirtualBench(0)
    bench.cover()
    found = rest(bench, create_covered_pitot_monitor(DYNAMIC))
    dead = dict.fromkeys(found.volts, 0.0)
    with pytest.raises(CalibrationError, match="ADC"):
        dynamic_pressure_zero(replace(found, volts=dead), DYNAMIC, who="crew", stamp=STAMP)


@pytest.mark.parametrize(
    ("entered", "words"),
    [
        ((30.1, "inHg", 72.0, "degF"), ""),
        ((1013.0, "hPa", 20.0, "degC"), ""),
        ((30.1, "hPa", 20.0, "degC"), "not plausible; enter the barometer"),
        ((1013.0, "hPa", 72.0, "degC"), "not plausible; enter the air temperature"),
    ],
)
def test_the_air_on_the_ground_is_checked(
    entered: tuple[float, str, float, str], words: str
) -> None:
    if words:
        with pytest.raises(CalibrationError, match=words):
            GroundAir.from_input(*entered)
    else:
        air = GroundAir.from_input(*entered)
        assert 101e3 < air.pressure < 102.5e3
        assert 292.0 < air.temperature < 296.0
    with pytest.raises(UnitError):
        GroundAir.from_input(1013.0, "kg", 20.0, "degC")
