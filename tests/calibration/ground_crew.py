"""A crew that calibrates gyros, accelerometers and pressures of the virtual bench, in samples."""

import datetime as dt
from collections.abc import Sequence
from dataclasses import dataclass

from calibration.inertial.accelerometers import (
    ACCELEROMETERS,
    POSITIONS,
    PositionReading,
    SixPositionResult,
    calibrate_accelerometers,
)
from calibration.inertial.gyros import (
    GYROS,
    GyroZero,
    Turn,
    create_inertial_rest_monitor,
    gyro_zero,
)
from calibration.inertial.turn_detection import TurnMonitor
from calibration.rest_detection import RestMonitor, RestPeriod
from gsapp.virtual.bench import VirtualBench

STAMP = dt.datetime(2026, 5, 12, 9, 30)  # noqa: DTZ001 - a field's local time


def rest(bench: VirtualBench, watch: RestMonitor, *, patience: float = 20.0) -> RestPeriod:
    watch.restart()
    until = bench.time + patience
    while bench.time < until:
        block = bench.step(0.5)
        watch.feed(block.times, {name: block[f"{name}_volts"] for name in watch.channels})
        reading = watch.status
        if reading.state == "rested" and reading.rest is not None:
            return reading.rest
    raise AssertionError(f"no rest: {watch.status}")


def turned(bench: VirtualBench, channel: str, angle: float) -> Turn:
    seconds = bench.rotate(channel, 0.0, seconds=0.01)  # only brought upright
    bench.step(seconds + 0.5)
    watch = TurnMonitor(GYROS, least=0.5 * abs(angle))
    seconds = bench.rotate(channel, angle)
    block = bench.step(seconds + 3.0)
    watch.feed(block.times, {name: block[f"{name}_volts"] for name in GYROS})
    return watch.detected_turn(channel, angle)


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroWork:
    zero: GyroZero
    zero_time: float
    turns: tuple[Turn, ...]


def gyro_work(bench: VirtualBench, channel: str) -> GyroWork:
    still = rest(bench, create_inertial_rest_monitor((*GYROS, *ACCELEROMETERS)))
    zero = gyro_zero(channel, still)
    turns = tuple(turned(bench, channel, angle) for angle in (360.0, -360.0))
    return GyroWork(zero=zero, zero_time=0.5 * (still.start + still.end), turns=turns)


def six_work(bench: VirtualBench, positions: Sequence[str] = POSITIONS) -> SixPositionResult:
    readings = []
    for position in POSITIONS:
        if position in positions:
            bench.step(bench.move_to_position(position))
            found = rest(bench, create_inertial_rest_monitor(ACCELEROMETERS, seconds=3.0))
            readings.append(PositionReading(position=position, rest=found))
    return calibrate_accelerometers(readings)
