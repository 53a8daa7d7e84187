"""A person with a protractor at the virtual aircraft, and what the instruments then tell.

Each setting is passed and come back to, so that the play is taken up; a point is taken once the
volts are at rest. What the surface was really set to is known, so that the protractor may be as
good or as bad as a proof asks for.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration.adc import ADC_RESOLUTION
from calibration.instrument_faults import InstrumentFault, find_faults
from calibration.points import CalibrationPoint, Direction
from calibration.quality import Calibration
from calibration.voltage_monitor import VoltageMonitor, VoltageReading
from gsapp.quantities import FloatArray
from gsapp.virtual.bench import POTENTIOMETERS, BenchFault, Potentiometer, VirtualBench
from gsapp.virtual.bench.bench_instruments import Linkage

SETTINGS = (-20.0, -10.0, 0.0, 10.0, 20.0)
PASSED = 3.0
"""How far a setting is passed before it is come back to, deg."""
SUPPLY = 5.0
"""To which volts are referred, V."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """What was taken on the way up and down.

    Attributes
    ----------
    potentiometer : Potentiometer
        As it really is.
    volts : ndarray, shape (n,)
        Means at rest, referred to `SUPPLY`, V.
    noise : ndarray, shape (n,)
        Standard deviation of single samples, V.
    nominal, true : ndarray, shape (n,)
        What was asked of the person, and what the surface was really set to, deg.
    directions : tuple of str
    """

    potentiometer: Potentiometer
    volts: FloatArray
    noise: FloatArray
    nominal: FloatArray
    true: FloatArray
    directions: tuple[Direction, ...]

    def points(self, error: float | None = None, seed: int = 0) -> list[CalibrationPoint]:
        """Return the points as noted with a protractor.

        Parameters
        ----------
        error : float, optional
            Standard deviation of reading it, deg; without it the bench's own, by which the
            settings miss what was asked.
        seed : int
            Of the error.
        """
        values = self.nominal
        if error is not None:
            values = self.true + np.random.default_rng([seed, 77]).normal(0.0, error, len(values))
        return [
            CalibrationPoint(
                volts=float(volts), value=float(value), direction=direction, noise=float(noise)
            )
            for volts, noise, value, direction in zip(
                self.volts, self.noise, values, self.directions, strict=True
            )
        ]


def rest(
    bench: VirtualBench, channel: str, watch: VoltageMonitor, *, patience: float = 12.0
) -> VoltageReading:
    end = bench.time + patience
    while bench.time < end:
        block = bench.step(0.2)
        watch.feed(block.times, block[f"{channel}_volts"], block["excitation"])
        reading = watch.reading
        if reading.state == "steady" and reading.moved and reading.steady_for >= 1.0:
            return reading
    raise AssertionError(f"{channel} never came to rest: {watch.reading}")


def sweep(seed: int, channel: str = "elevator_left", settings: Sequence[float] = SETTINGS) -> Sweep:
    """Take every setting upward, then downward, as a person does it."""
    bench = VirtualBench(seed)
    watch = VoltageMonitor()
    rows: list[tuple[float, float, float, float, Direction]] = []
    ways: tuple[tuple[Direction, Sequence[float], float], ...] = (
        ("up", settings, -PASSED),
        ("down", settings[::-1], PASSED),
    )
    for direction, values, passed in ways:
        bench.step(bench.set_angle(channel, values[0] + passed))
        for value in values:
            watch.restart()
            bench.set_angle(channel, value)
            reading = rest(bench, channel, watch)
            volts = reading.volts * SUPPLY / reading.excitation
            rows.append((volts, reading.std, value, bench.target_angle(channel), direction))
    return _sweep(bench.potentiometers[channel], rows)


def _sweep(
    potentiometer: Potentiometer, rows: Sequence[tuple[float, float, float, float, Direction]]
) -> Sweep:
    volts, noise, nominal, true, directions = zip(*rows, strict=True)
    return Sweep(
        potentiometer=potentiometer,
        volts=np.array(volts),
        noise=np.array(noise),
        nominal=np.array(nominal),
        true=np.array(true),
        directions=directions,
    )


def quick_sweep(
    seed: int,
    channel: str = "elevator_left",
    settings: Sequence[float] = SETTINGS,
    *,
    passed: float = PASSED,
    miss: float = 0.1,
) -> Sweep:
    """Take every setting upward, then downward, without a person's time.

    Parameters
    ----------
    seed : int
        Of the potentiometer, its noise and the settings.
    channel : str
        One of the bench's potentiometers.
    settings : sequence of float
        deg, ascending.
    passed : float
        How far the settings at the turns are passed before they are come back to, deg.
    miss : float
        Standard deviation by which a setting misses what was asked, deg.
    """
    random = np.random.default_rng([seed, 55])
    potentiometer = Potentiometer.sample(channel, random)
    linkage = Linkage(potentiometer.play, 0.0)
    legs: tuple[tuple[Direction, Sequence[float], float], ...] = (
        ("up", settings, settings[0] - passed),
        ("down", settings[::-1], settings[-1] + passed),
    )
    rows: list[tuple[float, float, float, float, Direction]] = []
    for direction, values, beyond in legs:
        linkage.follow(np.array([beyond]))
        for value in values:
            true = value + float(random.normal(0.0, miss))
            shaft = linkage.follow(np.array([true]))[0]
            samples = potentiometer.volts(shaft) + random.normal(0.0, potentiometer.noise, 70)
            samples = np.round(samples / ADC_RESOLUTION) * ADC_RESOLUTION
            rows.append((samples.mean(), samples.std(ddof=1), value, true, direction))
    return _sweep(potentiometer, rows)


def recovered(
    calibration: Calibration, potentiometer: Potentiometer, seed: int, count: int = 100
) -> tuple[FloatArray, FloatArray]:
    """Return errors of angles told by single samples, and the stated half widths, deg.

    The surface goes anywhere within the settings, the shaft follows with its play; samples outside
    the curve, where it promises nothing, are left out.
    """
    random = np.random.default_rng([seed, 99])
    low, high = calibration.quality.covered
    angles = random.uniform(low, high, count)
    shaft = Linkage(potentiometer.play, float(angles[0])).follow(angles)
    volts = potentiometer.volts(shaft, SUPPLY) + random.normal(0.0, potentiometer.noise, count)
    volts = np.round(volts / ADC_RESOLUTION) * ADC_RESOLUTION
    errors = calibration.value(volts) - angles
    inside = np.isfinite(errors)
    return errors[inside], calibration.uncertainty(volts)[inside]


def moved_once(seed: int, channel: str, faults: Sequence[BenchFault] = ()) -> dict[str, FloatArray]:
    bench = VirtualBench(seed, faults=faults)
    blocks = [
        bench.step(1.0),
        *(bench.step(bench.set_angle(channel, angle) + 0.8) for angle in (-22.0, 22.0)),
    ]
    return {
        name: np.concatenate([block[f"{name}_volts"] for block in blocks])
        for name in bench.potentiometers
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultTrial:
    kind: str
    moved: str
    other: str
    faults: tuple[InstrumentFault, ...]


def fault_trial(seed: int, kind: str) -> FaultTrial:
    random = np.random.default_rng([seed, 33])
    moved, other = (str(name) for name in random.choice(POTENTIOMETERS, 2, replace=False))
    faults = ()
    if kind:
        faults = (BenchFault(channel=moved, kind=kind, other=other if kind == "swapped" else ""),)
    volts = moved_once(seed, moved, faults)
    # As the certificate before has it: from the time when nothing was wrong.
    slope = VirtualBench(seed).potentiometers[moved].slope
    found = find_faults(moved, volts, sense=1, slope_sign=int(np.sign(slope)))
    return FaultTrial(kind=kind, moved=moved, other=other, faults=found)


def named_right(trial: FaultTrial) -> bool:
    if tuple(fault.kind for fault in trial.faults) != ((trial.kind,) if trial.kind else ()):
        return False
    return trial.kind != "swapped" or trial.faults[0].swapped_with == trial.other
