"""A campaign like the source's, flown by the virtual aircraft and estimated untouched by hand.

Fourteen flights of six or seven maneuvers: six with the elevator (13 to 18), eight with aileron
and rudder (A to H), each with a weight of its own as in table 6.2.3, told by its flight card.
In flights 14 to 18 all three gyros measure pitch and none roll or yaw; flight 13 has a pitch gyro
that failed, flight B no alpha, beta or airspeed, flight C loses its rudder potentiometer halfway.
Once in calm air, once in a light breeze. Printed: which entries of the tables hold the truth
within their bounds, by maneuver and for the means, and how long opening and estimating take beside
what was asked, opening also as a ratio to `numpy.loadtxt` on the same samples as a table.
``--quick`` takes four flights and the breeze only.
"""

import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.flight import load_flight
from gsapp.flight.flight_import import import_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.writers import write_block
from gsapp.identification.campaign import CampaignResult, CampaignSettings, run_campaign
from gsapp.identification.maneuver import (
    FlightWithManeuvers,
    open_flights_with_maneuvers,
)
from gsapp.identification.summary import summarize_campaign
from gsapp.quantities import Block
from gsapp.virtual.flight_plan import FlightPlan, Pattern, PlannedManeuver, load_flight_plan
from gsapp.virtual.virtual_flight import simulate_flight

POUND = 0.45359237
CALM, BREEZE = 0.0, 0.15
"""Standard deviation of the gusts, m/s."""
FIRST_SEED = 400
WEIGHTS = (
    46.5, 46.2, 46.9, 45.92, 46.7, 47.12, 46.0, 46.4, 46.8, 46.3, 46.6, 47.0, 46.1, 46.5,
)  # fmt: skip
"""Pounds, within the range of table 6.2.3."""
LONGITUDINAL = ("13", "14", "15", "16", "17", "18")
LATERAL = ("A", "B", "C", "D", "E", "F", "G", "H")
TRUTH = load_model("b777")


def main(*arguments: str) -> None:
    quick = "--quick" in arguments
    names = ("13", "15", "B", "D") if quick else (*LONGITUDINAL, *LATERAL)
    for gusts in (BREEZE,) if quick else (CALM, BREEZE):
        print(f"gusts of {gusts:g} m/s")
        with tempfile.TemporaryDirectory() as folder:
            paths = [record(name, Path(folder), gusts) for name in names]
            estimate(paths, Path(folder))


def estimate(paths: Sequence[Path], folder: Path) -> None:
    """Open the flights and estimate from them, untouched by hand."""
    opened, again, read = 0.0, 0.0, 0.0
    for path in paths:
        started = time.perf_counter()
        flight = load_flight(path)
        opened += time.perf_counter() - started
        started = time.perf_counter()
        load_flight(path)
        again += time.perf_counter() - started
        table = folder / "plain.txt"
        np.savetxt(table, flight.block.values)
        started = time.perf_counter()
        np.loadtxt(table)
        read += time.perf_counter() - started
    started = time.perf_counter()
    flown = open_flights_with_maneuvers(paths)
    found = time.perf_counter() - started
    maneuvers = [one for flight in flown for one in flight.maneuvers]
    started, spent = time.perf_counter(), time.process_time()
    result = run_campaign(maneuvers, CampaignSettings())
    wall, cpu = time.perf_counter() - started, time.process_time() - spent
    minutes = sum(one.flight.duration for one in flown) / 60.0
    print(f"{len(paths)} flights, {minutes:.0f} minutes, {len(maneuvers)} maneuvers found and kept")
    print(
        f"opening: {10.0 * opened / minutes:.2f} s for ten minutes of flight (asked: 1 s), "
        f"{opened / read:.2f} of what numpy.loadtxt takes; {10.0 * again / minutes:.2f} s again"
    )
    print(f"opening again and finding the maneuvers of all: {found:.1f} s")
    print(f"ML of all: {wall:.1f} s, {cpu:.1f} s of CPU (asked: 5 s for 90 maneuvers)")
    report(result, flown)


def report(result: CampaignResult, flown: Sequence[FlightWithManeuvers]) -> None:
    """Print how many entries hold the truth."""
    failed = [one for one in result.results if one.estimate is None or not one.estimate.converged]
    for one in failed:
        why = one.failure if one.estimate is None else one.estimate.message
        print(f"  no fit: maneuver {one.maneuver.id} of {one.maneuver.flight}: {why}")
    summary = summarize_campaign(result)
    entries: dict[str, list[bool]] = {}
    alone: list[bool] = []
    for name, one in summary.derivatives.items():
        true = TRUTH.derivative(name)
        for point in one.points:
            off = abs(point.value - true)
            entries.setdefault(point.flight, []).append(off <= 2.0 * one.bound(point))
            alone.append(off <= 2.0 * point.std)
    means = {
        name: abs(one.value.mean - TRUTH.derivative(name)) / one.value.std
        for name, one in summary.derivatives.items()
        if not name.endswith("_0")
    }
    every = [inside for inner in entries.values() for inside in inner]
    print(f"values within two of their bounds: {share(every)} of {len(every)} (asked: 93 %)")
    print(f"  by what each maneuver alone says of its bound: {share(alone)}")
    for flight, inside in entries.items():
        print(f"  {flight:4} {share(inside)} of {len(inside)}")
    within = [miss <= 2.0 for miss in means.values()]
    print(f"means within two of their bounds: {share(within)} of {len(within)}")
    far = {name: miss for name, miss in means.items() if miss > 2.0}
    if far:
        print("  off: " + ", ".join(f"{name} {miss:.1f}" for name, miss in far.items()))
    left_out = sum(len(one.outliers) for one in summary.derivatives.values())
    print(f"scatter over bounds {summary.bounds_ratio or np.nan:.2f}; {left_out} values left out")
    for wild in summary.outlying_maneuvers:
        print(f"  wild: {wild.maneuver}: {', '.join(wild.derivatives)}")
    graded = sum(len(one.detected_maneuvers) for one in flown) - sum(
        len(one.maneuvers) for one in flown
    )
    print(f"maneuvers left out as unfit: {graded}")


def share(inside: Sequence[bool]) -> str:
    return f"{100.0 * float(np.mean(inside)):.1f} %" if inside else "none"


def record(name: str, folder: Path, gusts: float) -> Path:
    """Fly one flight and leave its folder, with a card that tells the weight."""
    index = (*LONGITUDINAL, *LATERAL).index(name)
    kilograms = WEIGHTS[index] * POUND
    file = load_aircraft("b777")
    mass = file.mass.model_copy(update={"mass": kilograms})
    flight = simulate_flight(
        plan_of(name), aircraft=file.model_copy(update={"mass": mass}), turbulence=gusts,
        seed=FIRST_SEED + index, faults=faults_of(name),
    )  # fmt: skip
    if flight.crashed:
        print(f"  flight {name} crashed")
    csv = write_block(folder / f"{name}.csv", gyros_on_pitch(name, flight.measured), "csv")
    path = folder / f"flight {name}"
    import_flight(csv, path)
    FlightFolder.open(path).update_info(takeoff_weight=f"{WEIGHTS[index]} lb", aircraft="B777")
    return path


def plan_of(name: str) -> FlightPlan:
    """Return what is flown: elevator doublets, or ailerons and rudder together and apart."""
    if name in LONGITUDINAL:
        sizes = (0.24, 0.27, 0.22, 0.26, 0.25, 0.23)
        maneuvers = tuple(
            PlannedManeuver(inputs=("de",), stick=(size,), step="0.45 s") for size in sizes
        )
    else:
        both = PlannedManeuver(
            inputs=("da", "dr"), stick=(0.3, -0.5), step="0.5 s", stagger="0.3 s"
        )
        other = PlannedManeuver(
            inputs=("da", "dr"), stick=(-0.28, 0.5), step="0.5 s", stagger="0.3 s"
        )
        rudder = PlannedManeuver(inputs=("dr",), stick=(0.55,), step="0.5 s")
        aileron = PlannedManeuver(inputs=("da",), stick=(0.3,), step="0.4 s")
        maneuvers = (both, other, rudder, both, aileron, other, both)
    plan = load_flight_plan("short")
    return plan.model_copy(
        update={"name": name, "maneuvers": maneuvers, "pattern": Pattern(height="60 m", leg="10 s")}
    )


def faults_of(name: str) -> tuple[str, ...]:
    faults: Mapping[str, tuple[str, ...]] = {
        "13": ("q:stuck:start=0 s",),
        "B": ("alpha:dropout", "beta:dropout", "dynamic_pressure:dropout"),
        "C": ("rudder:dropout:start=140 s",),
    }
    return faults.get(name, ())


def gyros_on_pitch(name: str, block: Block) -> Block:
    if name not in LONGITUDINAL[1:]:
        return block
    random = np.random.default_rng(int(name))
    channels = [one for one in block.channels if one not in ("p", "r")]
    columns = [block[one] for one in channels]
    for number in (2, 3):
        channels.append(f"q.{number}")
        columns.append(block["q"] + np.radians(0.3) * random.standard_normal(len(block)))
    return Block(channels=tuple(channels), times=block.times, values=np.column_stack(columns))


if __name__ == "__main__":
    main(*sys.argv[1:])
