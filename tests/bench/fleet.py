"""A catalog of a thousand small flights: every search below 100 ms; fleet questions over them.

Arguments: COUNT of flights (1000), FILE of a catalog that is kept from run to run. Each flight has
six short maneuvers of the virtual aircraft, flown and estimated by equation error; five airframes
differ in their derivatives, one loses elevator over time. What is printed: the time of each kind of
search, the slowest of several; groups, trends and changes over all flights.
"""

import gc
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import Model, load_model
from gsapp.flight.catalog import (
    Catalog,
    FlightEntry,
    ManeuverFilter,
    find_maneuvers,
    load_maneuvers,
    search_runs,
    store_entry,
    store_run,
)
from gsapp.flight.catalog.derived_conditions import derived_conditions
from gsapp.flight.catalog.records import FlightCondition
from gsapp.flight.info import FlightInfo
from gsapp.flight.maneuvers import DetectedManeuver
from gsapp.foundation.executors import WorkerPool
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.estimate_json import CatalogManeuver, catalog_runs
from gsapp.identification.fleet.fleet_analysis import date_text, find_changes, fit_trend
from gsapp.identification.fleet.fleet_values import (
    group_means,
    list_fleet_names,
    select_fleet_values,
)
from tests.identification.virtual_maneuvers import fly

B777 = load_aircraft("b777")
MANEUVERS = 6
AIRFRAMES = 5
WORN = "SN 3"
WEAR_BEGAN = datetime(2025, 1, 1, tzinfo=UTC)
WEAR = 0.2  # of the elevator's effectiveness, a year
FIRST_DAY = datetime(2023, 1, 1, tzinfo=UTC)
DAYS = 1400
REPEATS = 7


def airframe_model(number: int, date: datetime) -> Model:
    """Return the truth of an airframe on a day."""
    random = np.random.default_rng(number)
    base = load_model("b777")
    values = {
        name: value * (1.0 + 0.05 * float(random.standard_normal()))
        for name, value in base.derivatives.items()
    }
    if f"SN {number}" == WORN:
        years = max((date - WEAR_BEGAN) / timedelta(days=365.25), 0.0)
        for name in ("CN_de", "CA_de", "Cm_de"):
            values[name] *= 1.0 - WEAR * years
    return base.with_derivatives(values)


def small_flight_date(random: np.random.Generator) -> datetime:
    return FIRST_DAY + timedelta(days=float(random.uniform(0.0, DAYS)))


def small_flight_name(seed: int) -> str:
    return f"{small_flight_date(np.random.default_rng([7, seed])):%Y-%m-%d}-{seed}"


def small_flight(seed: int) -> tuple[FlightEntry, tuple]:
    """Return a flight as a catalog holds it, and its fits."""
    random = np.random.default_rng([7, seed])
    date = small_flight_date(random)
    number = seed % AIRFRAMES + 1
    model = airframe_model(number, date)
    name = small_flight_name(seed)
    mass = B777.mass.model_copy(update={"mass": B777.mass.mass * random.uniform(0.9, 1.1)})
    plane = B777.model_copy(update={"mass": mass})
    info = FlightInfo(date=date, aircraft="B777", airframe=f"SN {number}")
    cut, found, conditions = [], [], []
    for place in range(MANEUVERS):
        kind = "lon" if place % 2 == 0 else "lat"
        flown = fly(
            MANEUVERS * seed + place, kind, dt=0.02, duration=8.0, model=model, aircraft=plane
        ).maneuver
        block = flown.block
        means = {one: float(block[one][:30].mean()) for one in ("V", "alpha", "density")}
        means["temperature"] = float(block["temperature"][:30].mean())
        means |= derived_conditions({**means, "mass": flown.mass}, plane, info)
        start = 20.0 * place
        cut.append(replace(flown, id=str(place + 1), flight=name))
        found.append(
            DetectedManeuver(
                id=str(place + 1), t_start=start, t_end=start + 8.0, inputs=flown.inputs,
                kind="doublet", amplitude=float(np.ptp(block[flown.inputs[0]]) / 2.0),
                grade="A", V=means["V"], alpha=means["alpha"], t_input=start + 0.8,
            )
        )  # fmt: skip
        conditions.append(
            {key: FlightCondition(mean=one, minimum=one, maximum=one) for key, one in means.items()}
        )
    result = run_campaign(cut, CampaignSettings(method="ee", single_method=True))
    places = {
        one.id: CatalogManeuver(flight=name, name=one.id, edges=(one.t_start, one.t_end))
        for one in found
    }
    entry = FlightEntry(
        name=name, path=Path(name), duration=20.0 * MANEUVERS, info=info, aircraft="B777",
        maneuvers=tuple(found), conditions=tuple(conditions),
    )  # fmt: skip
    return entry, catalog_runs(result, places)


def make_catalog(path: Path, count: int) -> None:
    """Fly and estimate what the catalog lacks; one flight is one transaction."""
    started = time.monotonic()
    with Catalog(path) as store:
        present = store.query("SELECT count(*) AS n FROM flights")[0]["n"]
        with WorkerPool("local:1") as pool:
            for entry, runs in pool.map(small_flight, range(present, count)):
                with store.transaction():
                    store_entry(store, entry)
                    for run in runs:
                        store_run(store, run)
    if present < count:
        print(f"  {count - present} flights in {time.monotonic() - started:.0f} s", flush=True)


def measured(work: Callable[[], object]) -> tuple[float, float, float]:
    """Return milliseconds of several calls: their median, the slowest, and the most CPU."""
    times, cpu = [], []
    for _ in range(REPEATS):
        started, busy = time.perf_counter(), time.process_time()
        work()
        times.append(1e3 * (time.perf_counter() - started))
        cpu.append(1e3 * (time.process_time() - busy))
    return float(np.median(times)), max(times), max(cpu)


def ask(path: Path) -> None:
    """Ask the fleet, and print the answers beside the truth."""
    for by in ("airframe", "month"):
        busy = time.process_time()
        with Catalog(path) as store:
            group_means(select_fleet_values(store, "Cm_alpha", ManeuverFilter()), by)
        print(f"  mean of Cm_alpha by {by}: {1e3 * (time.process_time() - busy):.0f} ms of CPU")
    busy = time.process_time()
    with Catalog(path) as store:
        found = select_fleet_values(store, "Cm_alpha", ManeuverFilter(), conditions=("mach",))
    fit = fit_trend(found, ["mach"], "airframe").fit
    print(f"  trend of Cm_alpha against Mach: {1e3 * (time.process_time() - busy):.0f} ms of CPU")
    errors = [
        (line.intercept - airframe_model(int(name[3:]), FIRST_DAY).derivative("Cm_alpha"))
        / line.intercept_std
        for name, line in fit.groups.items()
    ]
    slope = fit.slopes["mach"]
    shown = ", ".join(f"{one:+.1f}" for one in errors)
    print(f"    errors of the airframes over their bounds {shown}")
    print(f"    slope {slope.low:.2f} to {slope.high:.2f} (truth 0)")
    busy = time.process_time()
    with Catalog(path) as store:
        fleet = [
            select_fleet_values(store, name, ManeuverFilter()) for name in list_fleet_names(store)
        ]
    series = find_changes([one for one in fleet if one.values], "airframe")
    print(f"  changes in {len(series)} series: {time.process_time() - busy:.1f} s of CPU")
    for one in series:
        change = one.change
        if change.time is not None and change.earliest is not None and change.latest is not None:
            dates = (date_text(each) for each in (change.time, change.earliest, change.latest))
            truth = f"worn since {WEAR_BEGAN:%Y-%m-%d}" if one.name.endswith("_de") else "FALSE"
            print(f"    {one.name} {one.group}: {change.kind} {' '.join(dates)} ({truth})")


SEARCHES = {
    "all maneuvers": ManeuverFilter(),
    "one flight": ManeuverFilter(flight=small_flight_name(0)),
    "one airframe": ManeuverFilter(airframe="SN 3"),
    "a month": ManeuverFilter(since="2024-05", until="2024-05"),
    "inputs": ManeuverFilter(inputs=("da", "dr")),
    "kind and grade": ManeuverFilter(kind="doublet", worst_grade="B"),
    "speed": ManeuverFilter(conditions={"V": (29.0, 30.0)}),
    "Mach, Reynolds number, loading": ManeuverFilter(
        conditions={"mach": (0.08, 0.1), "reynolds": (1e5, None), "wing_loading": (None, 300.0)}
    ),
    "note": ManeuverFilter(text="gear"),
    "all together": ManeuverFilter(
        airframe="SN 3", since="2024", until="2025", inputs=("de",), kind="doublet",
        worst_grade="B", conditions={"V": (28.0, 33.0)}, text="",
    ),
}  # fmt: skip


def main(*arguments: str) -> dict[str, float]:
    """Measure and print; return figures by name."""
    count = int(arguments[0]) if arguments else 1000
    figures = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(arguments[1]) if len(arguments) > 1 else Path(folder) / "fleet.sqlite"
        make_catalog(path, count)
        gc.collect()
        gc.freeze()  # What was imported here is no part of a search.
        print(f"  {count} flights, {path.stat().st_size / 1e6:.1f} MB")
        for name, wanted in SEARCHES.items():

            def search(wanted: ManeuverFilter = wanted) -> int:
                with Catalog(path) as store:
                    rows = find_maneuvers(store, wanted)
                    found = load_maneuvers(store, rows[:100])
                    search_runs(store, row_ids={run for one in found for run in one.runs})
                    return len(rows)

            figures[name], worst, cpu = measured(search)
            line = f"  {name:32} {search():5} maneuvers {figures[name]:6.1f} ms"
            print(f"{line}, at worst {worst:5.1f} ms, CPU at most {cpu:5.1f} ms")
        ask(path)
    return figures


if __name__ == "__main__":
    main(*sys.argv[1:])
