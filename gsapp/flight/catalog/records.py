"""What goes into a catalog and comes out of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.catalog.derived_conditions import derived_conditions
from gsapp.flight.flight import Flight
from gsapp.flight.info import FlightInfo
from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.flight.provenance import InputFile

CONDITION_CHANNELS = (
    "V",
    "qbar",
    "alpha",
    "beta",
    "altitude",
    "density",
    "temperature",
    "throttle",
    "flap",
    "phi",
    "theta",
    "fuel",
    "mass",
)
"""Channels whose values at the start of a maneuver are its conditions, beside the
`DERIVED_CONDITIONS`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightCondition:
    """A channel in the second before the input, SI."""

    mean: float
    minimum: float
    maximum: float


def compute_conditions(
    flight: Flight, maneuver: DetectedManeuver, aircraft: Aircraft | None = None
) -> dict[str, FlightCondition]:
    """Return the conditions at which a maneuver was flown, by channel.

    Taken between its start and its input; over the whole of it where the input is not known. With
    the aircraft that flew it also the `DERIVED_CONDITIONS`.
    """
    stop = maneuver.t_input if maneuver.t_input > maneuver.t_start else maneuver.t_end
    part = flight.block.between(maneuver.t_start, stop)
    found = {}
    for name in (*CONDITION_CHANNELS, "static_pressure"):
        if name not in part:
            continue
        samples = part[name]
        samples = samples[np.isfinite(samples)]
        if samples.size:
            found[name] = FlightCondition(
                mean=float(samples.mean()),
                minimum=float(samples.min()),
                maximum=float(samples.max()),
            )
    # Speed may follow from pressures, which the maneuver's own figure knows.
    for name, value in (("V", maneuver.V), ("alpha", maneuver.alpha)):
        if name not in found and value is not None:
            found[name] = FlightCondition(mean=value, minimum=value, maximum=value)
    if aircraft is not None:
        means = {name: one.mean for name, one in found.items()}
        for name, value in derived_conditions(means, aircraft, flight.info).items():
            found[name] = FlightCondition(mean=value, minimum=value, maximum=value)
    found.pop("static_pressure", None)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightEntry:
    """A flight with its maneuvers, as it goes into a catalog."""

    name: str
    path: Path
    duration: float
    """s."""
    info: FlightInfo | None = None
    aircraft: str = ""
    """Name of the aircraft."""
    maneuvers: tuple[DetectedManeuver, ...] = ()
    conditions: tuple[Mapping[str, FlightCondition], ...] = ()
    complete: bool = True
    """Whether these are all maneuvers that stand in the flight."""

    @staticmethod
    def from_flight(
        flight: Flight,
        maneuvers: Sequence[DetectedManeuver] = (),
        *,
        aircraft: Aircraft | str = "",
        complete: bool = True,
    ) -> FlightEntry:
        """Return the entry of a flight, its maneuvers with the conditions they were flown at.

        `aircraft`: that flew it; with its name alone, Mach and Reynolds number and wing loading
        stay unknown.
        """
        info = flight.info
        plane = aircraft if isinstance(aircraft, Aircraft) else None
        name = aircraft if isinstance(aircraft, str) else aircraft.name
        return FlightEntry(
            name=flight.name,
            path=flight.path,
            duration=flight.duration,
            info=info,
            aircraft=name or (info.aircraft if info else ""),
            maneuvers=tuple(maneuvers),
            conditions=tuple(compute_conditions(flight, one, plane) for one in maneuvers),
            complete=complete,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredEstimate:
    """One derivative of a run."""

    value: float | None
    std: float | None = None
    cramer_rao: float | None = None
    """Per radian; None where not earned."""
    status: str = "estimated"
    confounded_with: tuple[str, ...] = ()
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimationRun:
    """One estimation: from which maneuvers, with which settings, what came out."""

    method: str
    axis: str
    maneuvers: tuple[tuple[str, str], ...]
    """Flight and id of each."""
    estimates: Mapping[str, StoredEstimate]
    settings: Mapping[str, Any] = field(default_factory=dict)
    fit: Mapping[str, Any] = field(default_factory=dict)
    """What JSON can hold."""
    model: str | None = None
    """Name of a stored model."""
    converged: bool = True
    iterations: int = 0
    warnings: tuple[str, ...] = ()
    message: str = ""
    made_at: str = ""
    """When, ISO 8601; empty for now."""
    id: int | None = None
    """In the catalog; None before it was stored."""
    edges: tuple[tuple[float, float], ...] = ()
    """First and last sample of each maneuver, s; empty for those that it has in the catalog."""
    campaign_run_id: int | None = None
    """Number of the kept run that it is part of; see `CampaignRun`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignRun:
    """A run over a whole campaign: what was asked for, from what, and what came of it.

    Its fits are `EstimationRun` entries of their own, which name its number.
    """

    label: str
    """What the user calls it."""
    method: str
    axis: str
    aircraft: str
    """Name of the one that flew."""
    flights: tuple[str, ...]
    request: Mapping[str, Any]
    """All that it takes to do it again; what JSON can hold."""
    settings: Mapping[str, str]
    inputs: tuple[InputFile, ...]
    versions: Mapping[str, str]
    result: Mapping[str, Any]
    """What a list shows of it; what JSON can hold."""
    made_at: str = ""
    """When, ISO 8601; empty for now."""
    number: int | None = None
    """In the catalog; None before it was stored."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredManeuver:
    """A maneuver as a search gives it."""

    flight: str
    maneuver: DetectedManeuver
    """Grade and reasons are the latest ones."""
    conditions: Mapping[str, FlightCondition]
    graded_by: str
    runs: tuple[int, ...] = ()
    """Estimations that used it."""
    verdict: str = ""
    """What was said of it in flight: ``good``, ``too-small`` ...; empty for nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredVerdict:
    """What was said of an input in flight."""

    name: str
    """``M7``, counted through the flight."""
    t_input: float
    t_end: float
    """When the input began and its answer ended, s."""
    surfaces: tuple[str, ...]
    """In the order in which they were moved."""
    kind: str
    """``doublet`` ..."""
    V: float | None
    """Airspeed before it, m/s."""
    result: str
    """``good``, ``too-small``, ``invalid`` ..."""
    advice: str
    """What the pilot was told."""
    card: str = ""
    """Id of the test card; empty for none."""
    is_counted: bool = False
    """Whether it is one of the repeats that the card asks for."""
    record: Mapping[str, Any] = field(default_factory=dict)
    """All of it, what JSON can hold."""
    flight: str = ""
    """That it belongs to; a search fills it in."""
    maneuver: str = ""
    grade: str = ""
    graded_by: str = ""
    """The maneuver found there, with its latest grade; empty where none was found."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CardScore:
    """How a test card was flown in a flight."""

    card: str
    title: str
    """What it asks for, in words."""
    good: int
    flown: int
    requested: int
    """Repeats that count, attempts, repeats asked for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredModel:
    """A model file with where it came from."""

    name: str
    content: str
    parent: str | None = None
    evidence: str = ""
    made_at: str = ""
