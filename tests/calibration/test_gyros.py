"""Rate gyros on the virtual bench: zeros, turns, verdicts, certificates."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibration import CalibrationError, load_certificate, write_certificate
from calibration.inertial.gyros import (
    GYROS,
    create_inertial_rest_monitor,
    evaluate_turn,
    gyro_certificate,
    gyro_scale,
    gyro_zero,
)
from calibration.inertial.straight_line import factory_calibrations
from calibration.inertial.turn_detection import TurnMonitor
from gsapp.virtual.bench import VirtualBench, parse_bench_fault
from tests.calibration.ground_crew import STAMP, gyro_work, rest, turned


@pytest.mark.parametrize("seed", range(3))
def test_zero_and_scale_come_out_within_twice_their_uncertainty(seed: int, tmp_path: Path) -> None:
    bench = VirtualBench(seed)
    channel, axis = GYROS[seed % 3], seed % 3
    work = gyro_work(bench, channel)
    truth = bench.gyros.zero[axis] + work.zero_time * bench.gyros.drift[axis]
    assert abs(work.zero.volts - truth) < 2.0 * work.zero.uncertainty
    assert work.zero.noise == pytest.approx(0.1, rel=0.2)
    scale = gyro_scale(work.turns)
    true_scale = bench.gyros.matrix[axis, axis]
    assert abs(scale.sensitivity - true_scale) < 2.0 * scale.uncertainty
    assert scale.uncertainty < 0.003 * abs(true_scale)
    certificate = gyro_certificate(work.zero, work.turns, who="crew", stamp=STAMP)
    read = load_certificate(write_certificate(certificate, tmp_path / f"{channel}.toml"))
    rates = np.array([-60.0, 0.0, 60.0])
    found = np.degrees(read.evaluate(truth + true_scale * rates))
    np.testing.assert_allclose(found, rates, atol=0.3)
    bounds = np.degrees(read.uncertainty(truth + true_scale * rates))
    assert np.all(np.abs(found - rates) < bounds)
    assert np.all(bounds < 0.4), "0.1 deg/s of noise, 0.15 % of scale"
    assert read.points[0].value == 0.0
    assert len(read.points) == 3


def test_without_a_turn_the_scale_is_the_factorys_and_says_so() -> None:
    bench = VirtualBench(2)
    zero = gyro_zero("q", rest(bench, create_inertial_rest_monitor()))
    certificate = gyro_certificate(zero, who="crew", stamp=STAMP)
    assert certificate.coefficients[1] == pytest.approx(45.0)
    assert "not checked" in certificate.notes
    far, near = certificate.uncertainty([4.0, zero.volts])
    assert far > 5.0 * near, "a scale on trust is worth less far from zero"


@pytest.mark.parametrize(
    ("fault", "kind"),
    [("r:dead", "dead"), ("r:reversed", "reversed"), ("r:swapped:with=p", "swapped")],
)
def test_what_is_wrong_is_named(fault: str, kind: str) -> None:
    bench = VirtualBench(4, faults=[parse_bench_fault(fault)])
    bench.step(2.0)
    start, stop = bench.time + 2.0, bench.time + bench.rotate("r", 360.0)
    block = bench.step(stop + 3.0 - bench.time)
    volts = {name: block[f"{name}_volts"] for name in GYROS}
    turn = evaluate_turn("r", block.times, volts, angle=360.0, turning=(start, stop))
    assert turn.verdict.kind == kind
    if kind == "reversed":
        assert gyro_scale([turn]).sensitivity < 0.0
    else:
        with pytest.raises(CalibrationError):
            gyro_scale([turn])


def test_a_turn_that_is_too_fast_is_clipped() -> None:
    bench = VirtualBench(1)
    bench.step(2.0)
    watch = TurnMonitor(GYROS)
    block = bench.step(bench.rotate("r", 360.0, seconds=3.0) + 3.0)
    watch.feed(block.times, {name: block[f"{name}_volts"] for name in GYROS})
    turn = watch.detected_turn("r", 360.0)
    assert turn.verdict.kind == "clipped"
    assert "more slowly" in turn.verdict.sentence


def test_laying_the_aircraft_on_the_table_is_no_turn() -> None:
    """A quarter turn by hand, then the turn: the turn is what is seen, however it is cut."""
    results = []
    for length in (0.23, 3.0):
        bench = VirtualBench(3)
        watch = TurnMonitor(GYROS)
        bench.step(2.0)
        seen = set()
        for angle in (0.0, 360.0):
            seconds = bench.rotate("p", angle) + 3.0
            until = bench.time + seconds
            while bench.time < until - 0.005:
                block = bench.step(min(length, until - bench.time))
                watch.feed(block.times, {name: block[f"{name}_volts"] for name in GYROS})
                seen.add(watch.status.state)
        results.append(watch.detected_turn("p", 360.0))
        if length < 1.0:
            assert seen == {"unsettled", "ready", "turning", "stopping", "turned"}
    assert results[0] == results[1]
    assert results[0].verdict.usable


def test_turns_that_disagree_widen_the_uncertainty() -> None:
    bench = VirtualBench(7)
    good = [turned(bench, "q", 360.0), turned(bench, "q", -360.0)]
    bad = turned(bench, "q", 355.0)
    wrong = replace(bad, angle=360.0, sensitivity=bad.sensitivity * 355.0 / 360.0)
    assert gyro_scale([*good, wrong]).uncertainty > 2.0 * gyro_scale(good).uncertainty
    with pytest.raises(CalibrationError, match="different gyros"):
        gyro_scale([good[0], turned(bench, "r", 360.0)])


def test_a_thin_radio_that_loses_samples_is_enough() -> None:
    bench = VirtualBench(40)
    block = bench.step(bench.rotate("r", 360.0) + 9.0)
    random = np.random.default_rng(1)
    kept = np.flatnonzero(np.arange(len(block)) % 5 == 0)
    kept = kept[random.random(kept.size) > 0.1]
    volts = {name: block[f"{name}_volts"][kept] for name in GYROS}
    watch = TurnMonitor(GYROS)
    watch.feed(block.times[kept], volts)
    turn = watch.detected_turn("r", 360.0)
    assert abs(turn.sensitivity - bench.gyros.matrix[2, 2]) < 2.0 * turn.uncertainty
    after = block.times[kept] > turn.end + 0.5
    still = create_inertial_rest_monitor()
    still.feed(block.times[kept][after], {name: v[after] for name, v in volts.items()})
    assert still.status.state == "rested"


def test_a_rest_is_needed_at_both_ends() -> None:
    figures = factory_calibrations()["r"]
    times = np.arange(0.0, 10.0, 0.01)
    volts = {"r": figures.zero + figures.sensitivity * np.full(times.size, 36.0)}
    with pytest.raises(CalibrationError, match="no rest"):
        evaluate_turn("r", times, volts, angle=360.0, turning=(0.0, 10.0))
