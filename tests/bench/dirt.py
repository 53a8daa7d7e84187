"""Errors over bounds in dirty flights, by every method, with the program's defaults.

Flights of the virtual aircraft and of JSBSim carry the dirt of ``gsapp fly --dirt``, drawn by seed
(`gsapp.virtual.dirt`): JSBSim flies one maneuver of varied derivatives, its record goes through the
virtual aircraft's box into a Flight CSV; every fifth flight is one of the virtual aircraft as
``gsapp fly --out`` writes it. They are estimated as a stranger would, by default. Asked for: rms of
error over bound 0.8 to 1.5 for every derivative given, at most 0.5 % of the numbers off by more
than five bounds.

The aircraft file states how well it is known (``[accuracy]``), as far as the dirt concerns it; with
``--plain`` it does not, and typical values count.

bench dirt [COUNT] [KINDS|each] [FIRST]: 200 flights with all kinds by default; ``each`` switches on
none, one kind after the other, and all, in flights of JSBSim; FIRST is the first seed.
"""

from __future__ import annotations

import contextlib
import logging
import re
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from calibration.certificate_toml import load_certificates
from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT, with_accuracy
from gsapp.cli._console import PlainConsole
from gsapp.cli.fly import write_folder
from gsapp.dynamics.model import load_model
from gsapp.dynamics.signal_terms import apply_lag
from gsapp.foundation import GroundStationError
from gsapp.identification.axes import Axis, axis_derivatives
from gsapp.identification.methods import DEFAULT_METHOD, estimation_methods
from gsapp.identification.runs.inputs import FlightCache
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_execution import execute_run
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import DEGREE, FOOT
from gsapp.virtual.dirt import DIRT_KINDS, Dirt, draw_dirt
from gsapp.virtual.downlink.flight_settings import FlightSettings
from gsapp.virtual.instruments import AnalogDigitalConverter, Instruments
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.virtual_flight import combine_surfaces
from tests.identification.jsbsim_kit import RATE, Engine, exposures
from tests.identification.virtual_maneuvers import NOISE, commands_for, varied_model

ASKED = (0.8, 1.5)
FAR = 5.0
"""Bounds; beyond them a number is false."""
FIRST_SEED = 25_000
COUNT = 200
VIRTUAL_EVERY = 5
"""Every so many-th flight is one of the virtual aircraft."""
QUIET, FLOWN = 3.0, 10.0
"""Seconds before the input of a record that is not cut, and from the input to its end."""
# Those columns of the box that are told by a CSV; they say the rest.
COLUMNS: Mapping[str, str] = {
    **dict.fromkeys(("alpha", "beta", "phi", "theta", "de", "da", "dr"), "rad"),
    **dict.fromkeys(("p", "q", "r"), "rad/s"),
    **dict.fromkeys(("ax", "ay", "an"), "m/s^2"),
    **dict.fromkeys(("static_pressure", "dynamic_pressure"), "Pa"),
    "temperature": "K",
    "throttle": "",
}
AIR_DATA = ("static_pressure", "dynamic_pressure")
BURST_SAMPLES = 5
"""Air data come at 20 Hz, so many in each burst."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DirtyFlight:
    """A record as a stranger brings it, and what is true of it."""

    path: Path
    aircraft: str
    truth: Mapping[str, float]
    dirt: Dirt
    window: str


@dataclass(slots=True, kw_only=True)
class Tally:
    """Errors over bounds by derivative, with the flights that they are from."""

    ratios: dict[str, list[tuple[float, int]]] = field(default_factory=dict)
    cpu: float = 0.0
    flights: int = 0
    failures: dict[str, int] = field(default_factory=dict)

    @property
    def every(self) -> FloatArray:
        return np.array([one for rows in self.ratios.values() for one, _ in rows])

    def rms(self, name: str) -> float:
        return float(np.sqrt(np.mean([ratio**2 for ratio, _ in self.ratios[name]])))


def fly_jsbsim(
    folder: Path, seed: int, kinds: Sequence[str], *, plain: bool = False
) -> DirtyFlight:
    """Fly one maneuver with JSBSim and write what the box recorded of it."""
    engine = Engine()
    axis: Axis = "lon" if seed % 2 == 0 else "lat"
    dirt = draw_dirt(kinds, seed, engine.aircraft)
    random = np.random.default_rng((seed, 0xB1))
    model = varied_model(random)
    found = engine.start(model, V=float(random.uniform(95.0, 105.0)) * FOOT)
    if dirt.turbulence:
        engine.start_turbulence(dirt.turbulence, seed)
    times = np.arange(round((QUIET + FLOWN) * RATE)) / RATE
    wait = round(QUIET * RATE)
    commands = {
        name: np.concatenate((np.zeros(wait), moves[: times.size - wait]))
        for name, moves in commands_for(axis, times, random).items()
    }
    moves = np.array([dirt.throttle_offset(float(one)) for one in times])
    motion = engine.fly(found, commands, moves)
    block = record(engine.aircraft, dirt, motion, random)
    moved = np.flatnonzero(np.max(np.abs([*commands.values()]), axis=0) > 1.5 * DEGREE) / RATE
    if dirt.tail:
        inside = (times >= moved[0] - dirt.lead) & (times <= moved[-1] + 2.0 + dirt.tail)
        block = Block(
            channels=block.channels,
            times=block.times[inside] - block.times[inside][0],
            values=block.values[inside],
        )
    path = write_csv(folder / f"jsbsim-{seed}.csv", block, dirt, random)
    window = f"0:{float(block.times[-1]) - 0.05:.2f}"
    return DirtyFlight(
        path=path,
        # JSBSim flies with the mass of the shipped file.
        aircraft=write_aircraft(folder, dirt, dirt.mass_factor, plain=plain),
        truth={name: model.derivative(name) for name in axis_derivatives(axis)},
        dirt=dirt,
        window=window,
    )


def record(
    aircraft: Aircraft, dirt: Dirt, motion: Mapping[str, FloatArray], random: np.random.Generator
) -> Block:
    """Return what the virtual aircraft's box makes of a motion that JSBSim flew."""
    actual, dt = dirt.apply_to(aircraft), 1.0 / RATE
    exposed = exposures(actual, motion)
    for name, tau in dirt.lags.items():
        if name == "V":
            root = np.sqrt(exposed["dynamic_pressure"] / motion["density"])
            exposed["dynamic_pressure"] = motion["density"] * apply_lag(root, tau, dt) ** 2
        else:
            exposed[name] = apply_lag(exposed[name], tau, dt)
    count = len(motion["time"])
    exposed |= {
        **dict.fromkeys(("elevator_left", "elevator_right"), exposed["de"]),
        **dict.fromkeys(("aileron_left", "aileron_right"), exposed["da"]),
        "rudder": exposed["dr"],
        # One thermometer at the field: the mean of what JSBSim's air had.
        "temperature": np.full(count, float(motion["temperature"].mean())),
        "throttle": motion["throttle"],
        "flap": np.zeros(count),
        "excitation": np.full(count, VIRTUAL.pot_supply),
        "battery": np.full(count, 12.5),
    }
    speeds = aircraft.propulsion.rpm_full * np.outer(0.6 + 0.4 * motion["throttle"], (1.01, 0.99))
    converter = _converter()
    shown = Instruments(actual, random, dt, dirt=dirt).read(exposed, speeds)
    block = combine_surfaces(converter.convert_to_block(motion["time"], converter.volts(shown)))
    late = motion["time"] - dirt.attitude_delay
    attitude = [
        np.interp(late, motion["time"], motion[name]) + NOISE[name] * random.standard_normal(count)
        for name in ("phi", "theta")
    ]
    return Block(
        channels=(*block.channels, "phi", "theta"),
        times=block.times,
        values=np.column_stack((block.values, *attitude)),
    )


@lru_cache(maxsize=1)
def _converter() -> AnalogDigitalConverter:
    return AnalogDigitalConverter(load_certificates("b777"))


def write_csv(path: Path, block: Block, dirt: Dirt, random: np.random.Generator) -> Path:
    """Write a Flight CSV with the clock and the gaps of its dirt."""
    count = len(block)
    jitter = dirt.stamp_jitter * random.standard_normal(count)
    times = block.times + np.clip(jitter, -0.4 / RATE, 0.4 / RATE)
    times = np.where(random.random(count) < dirt.unstamped_share, 0.0, times)
    times[0] = max(times[0], 0.0)
    missing = np.zeros(count, dtype=bool)
    columns = {name: block[name].copy() for name in COLUMNS}
    if dirt.burst_interval:
        # Of the samples of one interval, a fifth; they arrive one after the other at its end.
        every = round(dirt.burst_interval * RATE)
        missing = np.arange(count) % every < every - BURST_SAMPLES
        step = every // BURST_SAMPLES
        for name in AIR_DATA:
            old = block[name]
            for row in np.flatnonzero(~missing).tolist():
                number = BURST_SAMPLES - 1 - (every - 1 - row % every)
                columns[name][row] = old[max(row - row % every + step * number, 0)]
    cells = [[f"{one:.4f}" for one in times]]
    for name, values in columns.items():
        gone = missing if name in AIR_DATA else np.zeros(count, dtype=bool)
        cells.append(["" if lost else f"{one:.8g}" for one, lost in zip(values, gone, strict=True)])
    header = ",".join(["time [s]", *(f"{name} [{unit}]" for name, unit in COLUMNS.items())])
    rows = [",".join(row) for row in zip(*cells, strict=True)]
    path.write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    return path


def write_aircraft(folder: Path, dirt: Dirt, mass_factor: float, *, plain: bool) -> str:
    """Write the aircraft file that the crew has, with a mass that is not true."""
    text = with_accuracy(SHIPPED_AIRCRAFT.find("b777").read_text(encoding="utf-8"), {})
    mass = load_aircraft("b777").mass.mass / mass_factor
    text, count = re.subn(r'(?m)^mass = ".*"', f'mass = "{mass:.6f} kg"', text)
    assert count == 1
    if not plain:
        text = with_accuracy(text, dirt.accuracy)
    path = folder / f"b777-{dirt.seed}.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def fly_virtual(
    folder: Path, seed: int, kinds: Sequence[str], *, plain: bool = False
) -> DirtyFlight:
    """Fly the virtual aircraft as ``gsapp fly --out`` does; two maneuvers."""
    dirt = draw_dirt(kinds, seed, load_aircraft("b777"))
    # Here the aircraft that flies has another mass than the shipped file.
    file = write_aircraft(folder, dirt, 1.0, plain=plain)
    settings = FlightSettings(plan="short", seed=seed, dirt=tuple(kinds), aircraft=file)
    path = folder / f"virtual-{seed}"
    write_folder(settings, path, truth=None, console=PlainConsole(stderr=True, quiet=True))
    model = load_model(settings.model)
    return DirtyFlight(
        path=path,
        aircraft=file,
        truth={name: model.derivative(name) for name in axis_derivatives("both")},
        dirt=dirt,
        window="",
    )


def _is_virtual(seed: int) -> bool:
    return seed % VIRTUAL_EVERY == VIRTUAL_EVERY - 1


def fly(folder: Path, seed: int, kinds: Sequence[str], *, plain: bool) -> DirtyFlight:
    one = fly_virtual if _is_virtual(seed) else fly_jsbsim
    return one(folder, seed, kinds, plain=plain)


def tally(kinds: Sequence[str], seeds: Sequence[int], *, plain: bool) -> dict[str, Tally]:
    """Fly and estimate by every method; a flight without a detected maneuver is named whole.

    Ctrl-C returns what was measured so far.
    """
    found = {method: Tally() for method in estimation_methods()}
    with contextlib.suppress(KeyboardInterrupt):
        for seed in seeds:
            with tempfile.TemporaryDirectory() as made:
                flown = fly(Path(made), seed, kinds, plain=plain)
                flights = FlightCache()
                for method, one in found.items():
                    _add(one, flown, method, flights)
    return found


def _add(one: Tally, flown: DirtyFlight, method: str, flights: FlightCache) -> None:
    # The others are computed beside the default anyway, and cover what they disagree.
    request = RunRequest(
        flights=(flown.path,), aircraft=flown.aircraft, method=method,
        single_method=method != DEFAULT_METHOD,
    )  # fmt: skip
    started = time.process_time()
    try:
        try:
            outcome = execute_run(request, flights=flights)
        except GroundStationError as error:
            _count(one.failures, f"by itself: {error}")
            if not flown.window:
                return
            named = request.with_changes(maneuver_windows=(flown.window,))
            outcome = execute_run(named, flights=flights)
    except GroundStationError as error:
        _count(one.failures, str(error))
        return
    finally:
        one.cpu += time.process_time() - started
    one.flights += 1
    for name, summary in outcome.summary.derivatives.items():
        value = summary.value
        if name in flown.truth:
            ratio = (value.mean - flown.truth[name]) / value.std
            one.ratios.setdefault(name, []).append((ratio, flown.dirt.seed))


def _count(failures: dict[str, int], text: str) -> None:
    short = re.sub(r"(jsbsim|virtual)-\d+|[\d.]+", "*", text)[:100]
    failures[short] = failures.get(short, 0) + 1


def print_table(found: Mapping[str, Tally]) -> None:
    """Print a row for each derivative, four columns for each method."""
    print(f"{'error over bound':17}" + "".join(f"{method:^31}" for method in found))
    print(f"{'':17}" + f"{'rms':>7}{'median':>8}{'beyond 5':>10}{'n':>5} " * len(found))
    for name in axis_derivatives("both"):
        row = f"{name:17}"
        for one in found.values():
            if name not in one.ratios:
                row += f"{'none':>30} "
                continue
            ratios = np.abs([ratio for ratio, _ in one.ratios[name]])
            mark = " " if ASKED[0] <= one.rms(name) <= ASKED[1] else "!"
            row += f"{one.rms(name):7.2f}{mark}{np.median(ratios):7.2f}"
            row += f"{100.0 * np.mean(ratios > FAR):8.1f} %{ratios.size:5} "
        print(row)
    for method, one in found.items():
        outside = [name for name in one.ratios if not ASKED[0] <= one.rms(name) <= ASKED[1]]
        far = 100.0 * float(np.mean(np.abs(one.every) > FAR)) if one.every.size else 0.0
        print(
            f"{method}: {one.flights} flights, {one.every.size} numbers, {far:.2f} % beyond "
            f"{FAR:g} bounds; {len(outside)} of {len(one.ratios)} derivatives outside "
            f"{ASKED[0]} to {ASKED[1]}; {one.cpu / max(one.flights, 1):.2f} s of CPU a flight"
        )
        for text, times in one.failures.items():
            print(f"    {times} flights: {text}")


def print_each(found: Mapping[str, Mapping[str, Tally]]) -> None:
    """Print, for each kind of dirt alone, which derivatives it makes false in which method."""
    for kind, tallies in found.items():
        for method, one in tallies.items():
            far = 100.0 * float(np.mean(np.abs(one.every) > FAR)) if one.every.size else 0.0
            worst = sorted(one.ratios, key=one.rms, reverse=True)[:6]
            text = ", ".join(f"{name} {one.rms(name):.1f}" for name in worst)
            rms = float(np.sqrt(np.mean(one.every**2))) if one.every.size else np.nan
            print(f"{kind:15} {method:4} rms {rms:5.2f}, beyond {FAR:g}: {far:4.1f} %: {text}")


def main(*arguments: str) -> dict[str, Tally]:
    """Measure and print."""
    logging.disable(logging.WARNING)
    options = [one for one in arguments if not one.startswith("-")]
    count = int(options[0]) if options else (20 if "--quick" in arguments else COUNT)
    plain = "--plain" in arguments
    kinds = options[1] if len(options) > 1 else "all"
    first = int(options[2]) if len(options) > 2 else FIRST_SEED
    seeds: Sequence[int] = range(first, first + count)
    with np.errstate(all="ignore"):
        if kinds == "each":
            found = {}
            seeds = [one for one in range(first, first + 2 * count) if not _is_virtual(one)][:count]
            for kind in ("none", *DIRT_KINDS, "all"):
                found[kind] = tally(() if kind == "none" else (kind,), seeds, plain=plain)
                print_each({kind: found[kind]})
                sys.stdout.flush()
            return found["all"]
        tallies = tally(() if kinds == "none" else kinds.split(","), seeds, plain=plain)
        print_table(tallies)
        return tallies


if __name__ == "__main__":
    main(*sys.argv[1:])
