"""Fleets made of numbers: values with bounds, of airframes that differ, and a catalog of them."""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from gsapp.flight.catalog import (
    Catalog,
    EstimationRun,
    FlightEntry,
    StoredEstimate,
    store_entry,
    store_run,
)
from gsapp.flight.catalog.records import FlightCondition
from gsapp.flight.info import FlightInfo
from gsapp.flight.maneuvers import DetectedManeuver

VALUE, SLOPE, CENTER = -0.4, 0.8, 0.15  # At the center, per unit of Mach number.


@dataclass(frozen=True, kw_only=True)
class Fleet:
    values: np.ndarray
    stds: np.ndarray
    mach: np.ndarray
    airframes: list[str]
    flights: list[str]
    own: dict[str, tuple[float, float]]  # Intercept and slope of each airframe, less the fleet's.


def make_fleet(
    seed: int,
    *,
    airframes: int = 6,
    flights: int = 8,
    maneuvers: int = 3,
    bound: float = 0.02,
    of_airframes: tuple[float, float] = (0.05, 0.4),
    of_flights: float = 0.02,
    of_maneuvers: float = 0.01,
) -> Fleet:
    random = np.random.default_rng(seed)
    rows, names, flown, own = [], [], [], {}
    for number in range(airframes):
        airframe = f"SN {number}"
        a, b = np.array(of_airframes) * random.standard_normal(2)
        own[airframe] = (a, b)
        for flight in range(flights):
            shared = of_flights * random.standard_normal()
            for _ in range(maneuvers):
                mach = random.uniform(0.05, 0.25)
                std = bound * random.uniform(0.5, 2.0)
                noise = np.hypot(std, of_maneuvers) * random.standard_normal()
                value = VALUE + a + (SLOPE + b) * (mach - CENTER) + shared + noise
                rows.append((value, std, mach))
                names.append(airframe)
                flown.append(f"{airframe}-{flight}")
    values, stds, mach = np.array(rows).T
    return Fleet(values=values, stds=stds, mach=mach, airframes=names, flights=flown, own=own)


FIRST_DAY = datetime(2024, 1, 1, tzinfo=UTC)


def store_fleet(
    path: Path,
    fleet: Fleet,
    *,
    name: str = "Cm_alpha",
    step: tuple[str, float, float] | None = None,
) -> dict[str, datetime]:
    """Store a fleet, ten days from flight to flight of an airframe; return the dates by flight.

    `step`: airframe, day of the fleet's time and size of a step in its values.
    """
    places: dict[str, list[int]] = {}
    for place, flight in enumerate(fleet.flights):
        places.setdefault(flight, []).append(place)
    dates = {}
    with Catalog(path) as store, store.transaction():
        for flight, own in places.items():
            airframe, _, number = flight.rpartition("-")
            date = dates[flight] = FIRST_DAY + timedelta(days=10 * int(number))
            found = tuple(
                DetectedManeuver(
                    id=f"M{k}", t_start=20.0 * k, t_end=20.0 * k + 9.0, inputs=("de",),
                    kind="doublet", amplitude=0.1, grade="A", t_input=20.0 * k + 1.0,
                )
                for k in range(len(own))
            )  # fmt: skip
            conditions = []
            for place in own:
                mach = float(fleet.mach[place])
                conditions.append(
                    {
                        "mach": FlightCondition(mean=mach, minimum=mach, maximum=mach),
                        "V": FlightCondition(mean=340 * mach, minimum=0.0, maximum=340 * mach),
                    }
                )
            info = FlightInfo(date=date, aircraft="B777", airframe=airframe)
            store_entry(
                store,
                FlightEntry(
                    name=flight, path=Path(flight), duration=100.0, info=info, aircraft="B777",
                    maneuvers=found, conditions=tuple(conditions),
                ),
            )  # fmt: skip
            for k, place in enumerate(own):
                value = float(fleet.values[place])
                if step is not None and airframe == step[0] and 10 * int(number) >= step[1]:
                    value += step[2]
                estimate = StoredEstimate(
                    value=value, std=float(fleet.stds[place]), cramer_rao=0.5 * fleet.stds[place]
                )
                store_run(
                    store,
                    EstimationRun(
                        method="ml", axis="lon", maneuvers=((flight, f"M{k}"),),
                        estimates={name: estimate},
                    ),
                )  # fmt: skip
    return dates
