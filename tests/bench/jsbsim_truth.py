"""Truth from an independent engine: derivatives that JSBSim flew, found by every method.

For equation error, maximum likelihood, Fourier transform regression and filter error, derivative by
derivative:
rms of error over bound (1 where bounds are honest; 0.7 to 1.3 is asked for), mean of it (0 without
bias), rms error in percent of one maneuver. (The rms of 20 numbers scatters by 0.16, of 120 by
0.065: `--quick` shows a few outside by chance.) Besides: what is left without noise, on an Earth
that stands still, on one that turns, and where surfaces move without corners; what zero offsets of
the accelerometers do; and the means over a campaign with the shipped model.
"""

import sys
import time
from collections.abc import Mapping, Sequence

import numpy as np

from gsapp.dynamics.model import load_model
from gsapp.identification.axes import Axis
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.maximum_likelihood import MLSettings, estimate
from gsapp.quantities.constants import GRAVITY
from tests.identification.jsbsim_kit import (
    METHODS,
    STRONG,
    Engine,
    Errors,
    errors_of,
    estimates_of,
    fly,
)
from tests.identification.virtual_maneuvers import Virtual

ASKED = (0.7, 1.3)
FIRST_SEED = 7000
OFFSET = 0.02 * GRAVITY
AXES: tuple[Axis, ...] = ("lon", "lat")
# Zero offsets of the accelerometers are theirs; FTR widens their bounds for offsets not flown here.
LEVELS = ("CN_0", "CA_0", "CY_0")


def tally(
    engine: Engine, axis: Axis, seeds: Sequence[int], *, offset: float = 0.0, gust: float = 0.0
) -> dict[str, Errors]:
    started = time.process_time()
    flown = [fly(engine, seed, axis, offset=offset, gust=gust) for seed in seeds]
    spent = {"JSBSim": time.process_time() - started}
    found = {}
    for method in METHODS:
        started = time.process_time()
        found[method] = errors_of(estimates_of(method, flown, axis), flown)
        spent[method] = time.process_time() - started
    text = ", ".join(f"{name} {1e3 * one / len(seeds):.0f}" for name, one in spent.items())
    print(f"{axis}: {len(seeds)} maneuvers; ms of CPU each: {text}")
    return found


def outside(found: Mapping[str, Errors]) -> dict[str, float]:
    return {
        f"{method} {name}": one.rms(name)
        for method, one in found.items()
        for name in one.over_bounds
        if name not in LEVELS and not ASKED[0] <= one.rms(name) <= ASKED[1]
    }


def _words(ratios: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {ratio:.2f}" for name, ratio in ratios.items()) or "none"


def print_tally(found: Mapping[str, Errors]) -> None:
    """Print a row for each derivative, three columns for each method."""
    print(f"{'':10}" + "".join(f"{method:^25}" for method in found))
    print(f"{'':10}" + f"{'bound':>8}{'mean':>7}{'error %':>9} " * len(found))
    names = list(dict.fromkeys(name for one in found.values() for name in one.over_bounds))
    for name in names:
        row = f"{name:10}"
        for one in found.values():
            if name not in one.over_bounds:
                row += f"{'withheld':>24} "
                continue
            mark = " " if name in LEVELS or ASKED[0] <= one.rms(name) <= ASKED[1] else "!"
            row += f"{one.rms(name):7.2f}{mark}{np.mean(one.over_bounds[name]):+7.2f}"
            row += f"{one.percent(name):9.2f} "
        print(row)
    for method, one in found.items():
        counted = [name for name in one.over_bounds if name not in LEVELS]
        together = np.concatenate([one.over_bounds[name] for name in counted])
        print(
            f"{method}: rms of error over bound, all but {', '.join(LEVELS)} together: "
            f"{np.sqrt(np.mean(together**2)):.2f}; beyond two bounds "
            f"{100.0 * np.mean(np.abs(together) > 2.0):.1f} %, beyond three "
            f"{100.0 * np.mean(np.abs(together) > 3.0):.2f} % (normal: 4.6, 0.27); "
            f"{one.withheld} numbers withheld"
        )
    print(f"outside {ASKED[0]} to {ASKED[1]}: {_words(outside(found))}")


def print_free_offset(engine: Engine, seeds: Sequence[int]) -> None:
    for offset in (0.0, OFFSET):
        flown = [fly(engine, seed, "lon", offset=offset) for seed in seeds]
        for biases in (("an",), ("an", "ax")):
            settings = MLSettings(axis="lon", biases=biases)
            found = errors_of([estimate([one.maneuver], settings) for one in flown], flown)
            text = ", ".join(
                f"{name} {found.rms(name):.2f} ({np.sqrt(np.mean(found.errors[name] ** 2)):.4f})"
                for name in ("CA_0", "CA_alpha", "CA_q", "CA_de", "CN_alpha", "Cm_alpha")
            )
            print(
                f"ml, offsets of {offset / GRAVITY:4.2f} g, free biases {'+'.join(biases):5}: "
                f"error over bound (rms error) {text}"
            )


def print_systematic(engines: Mapping[str, Engine], seeds: Sequence[int]) -> dict[str, float]:
    worst = {}
    for axis in AXES:
        for title, engine in engines.items():
            flown = [fly(engine, seed, axis, noise=0.0) for seed in seeds]
            for method in METHODS:
                found = errors_of(estimates_of(method, flown, axis), flown)
                percent = {
                    name: 100.0 * float(np.mean(found.errors[name] / found.truths[name]))
                    for name in STRONG[axis]
                }
                worst[f"{axis} {title} {method}"] = max(abs(one) for one in percent.values())
                text = " ".join(f"{name} {one:+.3f}" for name, one in percent.items())
                print(f"{axis} {title:15} {method:3} {text}")
    return worst


def print_campaign(flown: Sequence[Virtual]) -> dict[str, float]:
    """Print the means over a campaign; return the largest error of a strong derivative, %."""
    truth: dict[str, float] = {}
    for one in flown:
        truth.update(one.truth)
    maneuvers = [one.maneuver for one in flown]
    methods: tuple[str, ...] = ("ee", "ml", "ftr")
    columns: dict[str, dict[str, tuple[float, float]]] = {}
    for method in methods:
        result = run_campaign(maneuvers, CampaignSettings(method=method, joint=method == "ml"))
        columns[method] = {name: (one.mean, one.std) for name, one in result.values.items()}
        for joint in result.joint:
            columns.setdefault("ml joint", {}).update(
                (name, (one.value, one.std))
                for name, one in joint.derivatives.items()
                if one.value is not None and one.std is not None
            )
    print(f"{'':10}{'true':>9}" + "".join(f"{title:^26}" for title in columns))
    print(f"{'':10}{'':>9}" + f"{'value':>10}{'error %':>9}{'/std':>6} " * len(columns))
    for name, true in truth.items():
        row = f"{name:10}{true:9.4f}"
        for values in columns.values():
            if name not in values:
                row += f"{'withheld':>25} "
                continue
            value, std = values[name]
            percent = f"{100.0 * (value / true - 1.0):9.2f}" if true else f"{'':9}"
            row += f"{value:10.4f}{percent}{(value - true) / std:+6.1f} "
        print(row)
    return {
        title: max(
            abs(100.0 * (values[name][0] / truth[name] - 1.0))
            for axis in AXES
            for name in STRONG[axis]
        )
        for title, values in columns.items()
    }


def main(*options: str) -> dict[str, float]:
    """Measure and print; return the extremes."""
    quick = "--quick" in options
    count = 20 if quick else 120
    engine = Engine()
    worst: dict[str, float] = {}
    for axis in AXES:
        found = tally(engine, axis, range(FIRST_SEED, FIRST_SEED + count))
        print_tally(found)
        for method, one in found.items():
            ratios = [one.rms(name) for name in one.over_bounds if name not in LEVELS]
            worst[f"{axis} {method} least"] = min(ratios)
            worst[f"{axis} {method} most"] = max(ratios)
    for gust in (0.3, 1.0):
        print(f"\ngusts of {gust:g} m/s along and about all axes (MIL-F-8785C)")
        for axis in AXES:
            rough = tally(engine, axis, range(FIRST_SEED, FIRST_SEED + count // 2), gust=gust)
            print_tally(rough)
    print(f"\nzero offsets of {OFFSET / GRAVITY:g} g on all three accelerometers")
    for axis in AXES:
        wrong = outside(tally(engine, axis, range(FIRST_SEED, FIRST_SEED + count), offset=OFFSET))
        print(f"outside: {_words(wrong)}")
    print_free_offset(engine, range(FIRST_SEED, FIRST_SEED + count // 2))
    print("\nwithout noise, mean error in percent")
    engines = {
        "still Earth": engine,
        "rotating Earth": Engine(earth="rotating"),
        "smooth surfaces": Engine(order=2),
    }
    worst |= print_systematic(engines, range(FIRST_SEED, FIRST_SEED + (3 if quick else 10)))
    size = 10 if quick else 40
    print(f"\ncampaign of {size} longitudinal and {size} lateral maneuvers, shipped model")
    model = load_model("b777")
    flown = [
        fly(engine, seed, axis, model=model)
        for axis in AXES
        for seed in range(FIRST_SEED, FIRST_SEED + size)
    ]
    worst |= {f"campaign {title}": one for title, one in print_campaign(flown).items()}
    for name, value in worst.items():
        print(f"{name:28} {value:.3f}")
    return worst


if __name__ == "__main__":
    main(*sys.argv[1:])
