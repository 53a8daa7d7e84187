"""Truth recovery: errors of maximum likelihood and filter error over the bounds they report.

Virtual maneuvers with known derivatives (varied, as are speed, inputs and seeds), 12-bit converter,
white and colored noise (first-order recursion, 0.9 from sample to sample). A bound is honest where
the rms of error over bound is 1; 0.8 to 1.3 is asked for, derivative by derivative. Besides:
what single rudder doublets give by each method, both methods in gusts of 0.3 and 1 m/s, with air
that turns (MIL-F-8785C) and air that does not, and how far the fast engine and the plain one are
apart on whole maneuvers.
"""

import sys
import time
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.identification import equation_error, ftr
from gsapp.identification.axes import AXIS_RESPONSES, AXIS_STATES, axis_derivatives
from gsapp.identification.filter_error import estimator as filter_error
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood import DEFAULT_BIASES, MLSettings, fit
from gsapp.identification.results import Estimate
from gsapp.quantities import FloatArray
from tests.identification.reference_ml import Reference
from tests.identification.virtual_maneuvers import AXES, fly

ASKED = (0.8, 1.3)
COLORS = {"white": 0.0, "colored": 0.9}
FIRST_SEED = 1000
GUST_SEED = 4000


class Tally:
    """Errors over bounds by derivative, honest and Cramer-Rao."""

    def __init__(self) -> None:
        self.honest: dict[str, list[float]] = {}
        self.plain: dict[str, list[float]] = {}
        self.missing: dict[str, int] = {}
        self.unconverged = self.alarms = self.count = 0
        self.cpu = 0.0

    def rms(self, name: str) -> float:
        return _rms(self.honest[name])

    @property
    def outside(self) -> list[str]:
        return [name for name in self.honest if not ASKED[0] <= self.rms(name) <= ASKED[1]]


def _rms(values: Iterable[float]) -> float:
    return float(np.sqrt(np.mean(np.square(list(values)))))


METHODS: dict[str, Callable[[Sequence[Maneuver], MLSettings], Estimate]] = {
    "ML": lambda maneuvers, settings: fit(maneuvers, settings).estimate,
    "filter error": filter_error.estimate,
}


def tally(
    kind: str,
    color: float,
    seeds: Iterable[int],
    *,
    gust: float = 0.0,
    rotating: bool = False,
    method: str = "ML",
) -> Tally:
    """Fly, fit and compare with the truth."""
    found = Tally()
    aircraft = load_aircraft("b777")
    for seed in seeds:
        virtual = fly(seed, kind, color=color, gust=gust, aircraft=aircraft, rotating=rotating)
        start = time.process_time()
        estimate = METHODS[method]([virtual.maneuver], MLSettings(axis=AXES[kind]))
        found.cpu += time.process_time() - start
        found.count += 1
        found.unconverged += not estimate.converged
        found.alarms += bool(estimate.gusty_maneuvers)
        for name, true in virtual.truth.items():
            one = estimate.derivatives[name]
            if one.value is None or one.std is None or one.cramer_rao is None:
                found.missing[name] = found.missing.get(name, 0) + 1
                continue
            found.honest.setdefault(name, []).append((one.value - true) / one.std)
            found.plain.setdefault(name, []).append((one.value - true) / one.cramer_rao)
    return found


def print_tallies(tallies: dict[str, Tally]) -> None:
    """Print one table for an axis: a row for each derivative."""
    print(f"{'':10}" + "".join(f"{name:^34}" for name in tallies))
    print(
        f"{'error over':10}" + f"{'bound':>8}{'mean':>8}{'worst':>8}{'plain':>8}  " * len(tallies)
    )
    names = next(iter(tallies.values())).honest
    for name in names:
        row = f"{name:10}"
        for one in tallies.values():
            errors = one.honest[name]
            mark = " " if ASKED[0] <= one.rms(name) <= ASKED[1] else "!"
            row += f"{one.rms(name):7.2f}{mark}{np.mean(errors):+8.2f}"
            row += f"{np.abs(errors).max():8.1f}{_rms(one.plain[name]):8.2f}  "
        print(row)
    for title, one in tallies.items():
        print(
            f"{title}: {one.count} maneuvers, {1e3 * one.cpu / one.count:.0f} ms of CPU each, "
            f"{one.unconverged} not converged, {sum(one.missing.values())} values withheld, "
            f"{one.alarms} alarms of turbulence; outside {ASKED[0]} to {ASKED[1]}: "
            f"{', '.join(one.outside) or 'none'}"
        )


def print_gusts(count: int) -> dict[str, float]:
    """Print both methods in gusts; return the extremes of filter error."""
    worst = {}
    for kind in ("lon", "lat"):
        for gust in (0.3, 1.0):
            print(f"\n{kind}, gusts of {gust:g} m/s")
            seeds = range(GUST_SEED, GUST_SEED + count)
            tallies = {
                f"{method}{', air turning' if rotating else ''}": tally(
                    kind, 0.0, seeds, gust=gust, rotating=rotating, method=method
                )
                for method, rotating in (
                    ("ML", False), ("filter error", False), ("filter error", True),
                )
            }  # fmt: skip
            print_tallies(tallies)
            for title in list(tallies)[1:]:
                ratios = [tallies[title].rms(name) for name in tallies[title].honest]
                worst[f"{kind} {gust:g} m/s {title} least"] = min(ratios)
                worst[f"{kind} {gust:g} m/s {title} most"] = max(ratios)
    return worst


def print_rudder_doublets(count: int) -> None:
    """Print errors over bounds of what single rudder doublets give, by each method.

    Sideslip and roll rate move nearly as one in them, so that derivatives are withheld.
    """
    methods: dict[str, Callable[[Maneuver], Estimate]] = {
        "ml": lambda one: fit([one], MLSettings(axis="lat")).estimate,
        "ee": lambda one: equation_error.estimate([one], "lat"),
        "ftr": lambda one: ftr.estimate([one], "lat"),
    }
    flown = [fly(7000 + seed, "lat", dt=0.02, still=("da",)) for seed in range(count)]
    print(f"{count} rudder doublets, error over bound (worst; given of {count})")
    print(f"{'':10}" + "".join(f"{name:>20}" for name in methods))
    found: dict[str, dict[str, list[float]]] = {name: {} for name in methods}
    for method, estimate in methods.items():
        for virtual in flown:
            for name, one in estimate(virtual.maneuver).derivatives.items():
                if one.status == "estimated" and one.value is not None and one.std:
                    error = (one.value - virtual.truth[name]) / one.std
                    found[method].setdefault(name, []).append(error)
    for name in axis_derivatives("lat"):
        cells = [found[method].get(name, []) for method in methods]
        if any(cells):
            print(
                f"{name:10}"
                + "".join(
                    f"{_rms(own):8.2f} ({max(map(abs, own)):4.1f}; {len(own):3d})"
                    if own
                    else f"{'withheld':>20}"
                    for own in cells
                )
            )


def agreement(kind: str, seed: int) -> tuple[float, float, float]:
    """Fit a whole maneuver both ways; return the largest differences.

    Of values over bounds, of bounds over themselves, of corrected bounds over themselves.
    """
    maneuver = fly(seed, kind).maneuver
    axis, model = AXES[kind], load_model("b777")
    fast = fit([maneuver], MLSettings(axis=axis, model=model, tolerance=1e-20, lags=50))
    reference = Reference(
        maneuvers=[maneuver],
        model=model,
        states=AXIS_STATES[axis],
        responses=AXIS_RESPONSES[axis],
        free=axis_derivatives(axis),
        biases=DEFAULT_BIASES[axis],
        lags=50,
    )
    # Both name derivatives first, then initial states, then biases.
    start = dict(zip(reference.names, fast.values.tolist(), strict=True))
    bounds: FloatArray = np.sqrt(fast.cramer_rao.diagonal())
    slow = reference.fit(start, bounds=dict(zip(reference.names, bounds.tolist(), strict=True)))
    plain, honest, values = (
        np.array([table[name] for name in reference.names])
        for table in (slow.cramer_rao, slow.std, slow.theta)
    )
    return (
        float(np.abs((fast.values - values) / plain).max()),
        float(np.abs(bounds / plain - 1.0).max()),
        float(np.abs(np.sqrt(fast.covariance.diagonal()) / honest - 1.0).max()),
    )


def main(*options: str) -> dict[str, float]:
    """Measure and print; return the extremes of the rms of error over bound."""
    quick = "--quick" in options
    count = 20 if quick else 220
    worst: dict[str, float] = {}
    for kind in ("lon", "lat"):
        tallies = {
            f"{method}, {title} noise": tally(
                kind, color, range(FIRST_SEED, FIRST_SEED + count), method=method
            )
            for title, color in COLORS.items()
            for method in METHODS
        }
        print_tallies(tallies)
        for title, one in tallies.items():
            ratios = [one.rms(name) for name in one.honest]
            worst[f"{kind} {title} least"] = min(ratios)
            worst[f"{kind} {title} most"] = max(ratios)
    worst |= print_gusts(5 if quick else 40)
    print_rudder_doublets(6 if quick else 40)
    if not quick:
        for kind in ("lon", "lat"):
            values, bounds, honest = agreement(kind, 1)
            print(
                f"{kind}, fast against plain: values within {values:.1e} of a bound, bounds within "
                f"{bounds:.1e}, corrected bounds within {honest:.1e} of themselves"
            )
    return worst


if __name__ == "__main__":
    main(*sys.argv[1:])
