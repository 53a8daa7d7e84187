"""Dangers: false ones over whole flights with nothing wrong, and instruments that fail.

Flights are whole: engines, take-off, eleven maneuvers, landing; from calm air to gusts of 1 m/s.
What the board adds (attitude, position) is there in one half of the cases and not in the other.
What is true is told from the simulator's states: a stall margin, a fence, a clipped gyro may well
be reported where the truth bears it out; anything said of an instrument that is sound is false.
"""

import math
import sys
import time
from collections import defaultdict
from collections.abc import Mapping

import numpy as np

from gsapp.aircraft import load_aircraft
from gsapp.excitation.alerts.alert import Alert
from gsapp.quantities import Block
from tests.excitation.danger_kit import (
    BARE,
    Flown,
    Harm,
    blocked_pitot,
    dead_gyro,
    fly_whole,
    record,
    several,
    stuck_with_noise,
    watched,
)

GUSTS = (0.0, 0.3, 0.6, 1.0)
FLIGHTS, FAILING = 40, 10
FAULT_AT = 170.0
"""s; in the pattern by then."""
FROM, PATIENCE = 60.0, 120.0
"""s; a record of a failure begins with engines running, and ends so long after the failure."""
KEYS = {
    "alpha": "alpha", "beta": "beta", "dynamic_pressure": "airspeed",
    "p": "gyro.p", "q": "gyro.q", "r": "gyro.r",
}  # fmt: skip
INSTRUMENTS = ("nose", "alpha", "beta", "airspeed", "gyro", "motion")
NOISE = {"alpha": math.radians(0.1), "beta": math.radians(0.1), "dynamic_pressure": 1.0}
FREEDOM = 3.0
"""s; what the truth bears out, it bears out within so long before or after."""


def cases() -> dict[str, tuple[str, tuple[str, ...], Harm | None]]:
    """Return each kind of failure: the key that should be said, faults, other harm."""
    at = f"start={FAULT_AT:.0f} s"
    found: dict[str, tuple[str, tuple[str, ...], Harm | None]] = {}
    for name, key in KEYS.items():
        found[f"{name} repeats itself"] = (key, (f"{name}:stuck:{at}",), None)
        found[f"{name} wire broken"] = (key, (f"{name}:dropout:{at}",), None)
        found[f"{name} wire loose"] = (key, (f"{name}:dropout:{at},every=12 s,length=0.2 s",), None)
    for name, noise in NOISE.items():
        found[f"{name} jammed, with noise"] = (
            KEYS[name],
            (),
            stuck_with_noise(name, FAULT_AT, noise),
        )
    for name in "pqr":
        found[f"{name} dead, with noise"] = (KEYS[name], (), dead_gyro(name, FAULT_AT))
    found["pitot holds its pressure"] = ("airspeed", (), blocked_pitot(FAULT_AT))
    nose = tuple(f"{name}:dropout:{at}" for name in NOISE)
    found["nose plug out"] = ("nose", nose, None)
    jams = [stuck_with_noise(name, FAULT_AT, noise) for name, noise in NOISE.items()]
    found["nose jammed, with noise"] = ("nose", (), several(*jams))
    return found


def borne_out(danger: Alert, flown: Flown) -> bool:
    """Return whether the truth bears out what was said of a sound record."""
    kind = danger.key.partition(".")[0]
    if kind in INSTRUMENTS:
        return False
    about = np.abs(flown.times - danger.since) <= FREEDOM
    aircraft = load_aircraft("b777")
    if kind == "stall":
        load = np.sqrt(np.maximum(flown.true("an")[about] / 9.80665, 0.25))
        near = np.min(flown.true("Vc")[about] / load) < 1.12 * aircraft.limits.stall_speed
        return bool(near or np.max(flown.true("alpha")[about]) > 0.85 * aircraft.limits.alpha_stall)
    if kind == "clip":
        name = danger.key.partition(".")[2]
        low, high = {
            "alpha": aircraft.sensors.alpha_vane.range,
            "beta": aircraft.sensors.beta_vane.range,
        }.get(name, aircraft.sensors.gyro.range)
        # The engines shake a gyro by up to 3 deg/s.
        swing = flown.true(name)[about]
        return bool(swing.min() < 0.95 * low or swing.max() > 0.95 * high)
    if kind == "fence":
        north, east = flown.true("north"), flown.true("east")
        away = np.hypot(north - north[0], east - east[0])[about]
        return bool(away.max() > 650.0 or flown.true("height")[about].max() > 100.0)
    if kind == "time":
        flying = flown.true("V") > aircraft.limits.stall_speed
        return float(np.sum(flying & (flown.times < danger.since))) / 100.0 > 340.0
    return False


def main(*options: str) -> dict[str, float]:
    """Measure, print and return."""
    quick = "--quick" in options
    flights = FLIGHTS // 10 if quick else FLIGHTS
    failing = max(FAILING // 5, 2) if quick else FAILING
    said: list[str] = []
    false: list[str] = []
    seconds = cpu = 0.0
    outcomes: dict[str, list[tuple[bool, float, int]]] = defaultdict(list)
    for seed in range(flights):
        gusts = GUSTS[seed % len(GUSTS)]
        flown = fly_whole(seed, gusts)
        for without in (frozenset[str](), BARE):
            block = record(flown, without=without)
            began = time.process_time()
            watch = watched(block)
            cpu += time.process_time() - began
            seconds += float(flown.times[-1])
            said += [danger.key for danger in watch.log]
            false += [
                f"flight {seed}, {danger.since:.1f} s: {danger.text}"
                for danger in watch.log
                if not borne_out(danger, flown)
            ]
        if seed < failing:
            for index, (case, (key, faults, harm)) in enumerate(cases().items()):
                without = BARE if (seed + index) % 2 else frozenset()
                block = record(flown, faults=faults, harm=harm, without=without)
                rows = (block.times > FROM) & (block.times < FAULT_AT + PATIENCE)
                part = Block(
                    channels=block.channels, times=block.times[rows], values=block.values[rows]
                )
                outcomes[case].append(outcome(watched(part).log, key))
    report(flights, seconds, cpu, said, false, outcomes)
    named = [one for each in outcomes.values() for one in each]
    return {
        "flights": 2.0 * flights,
        "false dangers": float(len(false)),
        "share of a core": cpu / seconds,
        "failures": float(len(named)),
        "named right": float(sum(right for right, _, _ in named)),
        "others named beside": float(sum(beside for _, _, beside in named)),
    }


def outcome(log: tuple[Alert, ...], key: str) -> tuple[bool, float, int]:
    after = [danger for danger in log if danger.since >= FAULT_AT]
    times = [danger.since for danger in after if danger.key == key]
    allowed = {key, "alpha", "beta", "airspeed"} if key == "nose" else {key}
    beside = [
        danger
        for danger in after
        if danger.key not in allowed and danger.key.partition(".")[0] in INSTRUMENTS
    ]
    return bool(times), min(times, default=math.nan) - FAULT_AT, len(beside)


def report(
    flights: int,
    seconds: float,
    cpu: float,
    said: list[str],
    false: list[str],
    outcomes: Mapping[str, list[tuple[bool, float, int]]],
) -> None:
    counts = {key: said.count(key) for key in sorted(set(said))}
    print(f"{2 * flights} records of {flights} whole flights, {seconds / 3600.0:.1f} h")
    print(f"said: {', '.join(f'{key} {count}' for key, count in counts.items()) or 'nothing'}")
    print(f"not borne out by the truth: {len(false)}")
    for line in false:
        print(f"    {line}")
    print(f"CPU: {100.0 * cpu / seconds:.2f} % of a core")
    print(f"{'failure':38} {'named':>7} {'median':>8} {'latest':>8} {'wrong beside':>13}")
    for case, results in outcomes.items():
        right = [delay for named, delay, _ in results if named]
        middle = f"{np.median(right):6.1f} s" if right else "     -"
        latest = f"{max(right):6.1f} s" if right else "     -"
        beside = sum(number for _, _, number in results)
        print(f"{case:38} {len(right):3}/{len(results):<3} {middle:>8} {latest:>8} {beside:13}")


if __name__ == "__main__":
    main(*sys.argv[1:])
