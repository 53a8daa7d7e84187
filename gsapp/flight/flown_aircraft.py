r"""The aircraft as a flight flew it: mass, center of gravity and inertia by the flight card.

What the card loads (:math:`m_k` at :math:`r_k`, negative where taken out, and fuel beyond that of
the aircraft file) moves the CG and changes the inertia by the parallel-axis theorem,

.. math::
    m = m_0 + \sum m_k, \quad c = \sum m_k r_k / m, \quad
    I = I_0 + \sum m_k (r_k^2 E - r_k r_k^T) - m (c^2 E - c c^T).

A weighing then says where the CG really is, and the weight how heavy the aircraft really was; what
neither card nor file explains is taken to sit at the CG, where it does not change the inertia.
Products Ixy and Iyz, which a load off the plane of symmetry would bring, are left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final, TypeVar

import numpy as np

from gsapp.aircraft import Aircraft, MassProperties
from gsapp.aircraft.weighing import WeighingRecord, evaluate_weighing
from gsapp.flight.info import FlightInfo
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.foundation import FlightError, StrictModel
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY
from gsapp.quantities.fields import Position

Part = TypeVar("Part", bound=StrictModel)

_ORIGIN: Final[Position] = (0.0, 0.0, 0.0)
_NAMES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2)}


@dataclass(frozen=True, slots=True, kw_only=True)
class FlownAircraft:
    """What a flight card makes of an aircraft file."""

    aircraft: Aircraft
    """With mass, fuel and inertia at take-off; its positions are from the CG as flown."""
    cg_shift: Position = _ORIGIN
    """From the CG of the aircraft file to that of the flight, body axes, m."""
    remarks: tuple[str, ...] = ()
    """What was changed and why, in words; empty where the card says nothing new."""

    def after_fuel_burn(self, burned: float) -> FlownAircraft:
        """Return the aircraft with so much fuel gone, kg: what tanks off the CG do in flight.

        Mass and fuel stay those of the take-off, since a maneuver has a mass of its own; the same
        object comes back where nothing else would change.
        """
        properties = self.aircraft.mass
        rest = properties.mass - burned
        loaded = _add_loads(properties, ((-burned, properties.fuel_position),), rest)
        changed = any(
            abs(getattr(loaded.properties, name) / getattr(properties, name) - 1.0)
            > FLIGHT_DATA.mass_tolerance
            for name in _NAMES
        )
        if not changed and math.hypot(*loaded.center) < FLIGHT_DATA.cg_shift_tolerance:
            return self
        moved = _move_reference_point(self.aircraft, loaded.center)
        kept = {"mass": properties.mass, "fuel_position": moved.mass.fuel_position}
        x, y, z = (a + b for a, b in zip(self.cg_shift, loaded.center, strict=True))
        return replace(
            self,
            aircraft=moved.model_copy(update={"mass": loaded.properties.model_copy(update=kept)}),
            cg_shift=(x, y, z),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class _LoadedMass:
    """Mass properties about their own CG, and where that lies from the former one, m."""

    properties: MassProperties
    center: Position


def apply_flight_info(aircraft: Aircraft, info: FlightInfo | None) -> FlownAircraft:
    """Return the aircraft with the mass, center of gravity and inertia of one flight.

    `FlightError` if the card makes none: scales that do not carry it, or less mass than fuel.
    """
    if info is None:
        return FlownAircraft(aircraft=aircraft)
    file = aircraft.mass
    fuel = file.fuel if info.fuel is None else info.fuel
    parts = [(item.mass, item.position) for item in info.loading]
    parts.append((fuel - file.fuel, file.fuel_position))
    loaded = _add_loads(file, tuple(parts), file.mass + sum(part[0] for part in parts))
    mass, center = loaded.properties.mass, loaded.center
    remarks: list[str] = []
    by = "the loading and fuel on the card"
    if info.weighing is not None:
        mass, center, sentence = _weighed_mass_and_cg(aircraft, info.weighing, fuel, center)
        remarks.append(sentence)
        by = "the scales"
    if info.takeoff_weight is not None:
        mass, by = info.takeoff_weight / GRAVITY, "the take-off weight on the card"
    _check_mass(mass, fuel, by)
    if abs(mass / file.mass - 1.0) > FLIGHT_DATA.mass_tolerance:
        remarks.insert(0, f"mass at take-off {mass:.2f} kg by {by}, not the aircraft file's "
                       f"{file.mass:.2f} kg")  # fmt: skip
    if info.weighing is None and math.hypot(*center) >= FLIGHT_DATA.cg_tolerance:
        remarks.append(f"loading moves the CG {_offset_text(center)} of the aircraft file's")
    remarks.extend(_inertia_text(file, loaded.properties))
    if math.hypot(*center) < FLIGHT_DATA.cg_tolerance:
        center = _ORIGIN
    else:
        remarks.append(_reference_point_text(center, aircraft))
    if not remarks:
        return FlownAircraft(aircraft=aircraft)
    moved = _move_reference_point(aircraft, center)
    kept = {"mass": mass, "fuel": fuel, "fuel_position": moved.mass.fuel_position}
    return FlownAircraft(
        aircraft=moved.model_copy(update={"mass": loaded.properties.model_copy(update=kept)}),
        cg_shift=center,
        remarks=tuple(remarks),
    )


def _weighed_mass_and_cg(
    aircraft: Aircraft, record: WeighingRecord, fuel: float, usual: Position
) -> tuple[float, Position, str]:
    """Return mass and CG at take-off by the scales, and how to say it."""
    found = evaluate_weighing(record, aircraft.axles)
    added = 0.0 if record.fuel is None else fuel - record.fuel
    mass = found.mass.value + added
    _check_mass(mass, fuel, "the scales")
    tank = aircraft.mass.fuel_position
    center = tuple(
        (found.mass.value * at + added * there) / mass if measured else known
        for at, there, measured, known in zip(found.cg, tank, found.measured, usual, strict=True)
    )
    x, y, z = center
    std = found.cg_std[0]
    sure = (
        f"x within {1e3 * std:.0f} mm, {100.0 * std / aircraft.geometry.chord:.1f} % of the chord"
    )
    where = f"{_offset_text((x, y, z))} of the aircraft file's"
    if math.hypot(x, y, z) < FLIGHT_DATA.cg_tolerance:
        where = "as in the aircraft file"
    return mass, (x, y, z), f"CG by weighing {where} ({sure})"


def _check_mass(mass: float, fuel: float, by: str) -> None:
    if not mass > fuel >= 0.0:
        raise FlightError(
            f"by {by} the aircraft has {mass:.2f} kg at take-off with {fuel:.2f} kg of fuel, "
            "which is impossible; correct weights, fuel and loading in flight.toml"
        )


def _add_loads(
    properties: MassProperties, parts: tuple[tuple[float, Position], ...], mass: float
) -> _LoadedMass:
    """Return mass properties with parts added, about their CG; see the module's text."""
    if not mass > 0.0:
        raise FlightError(
            f"the loading on the card removes more than the aircraft has and leaves {mass:.2f} "
            "kg; correct it in flight.toml"
        )
    about = np.diag([properties.ixx, properties.iyy, properties.izz])
    about[0, 2] = about[2, 0] = -properties.ixz
    center = sum((part * np.asarray(place) for part, place in parts), np.zeros(3)) / mass
    for part, place in parts:
        about += _point_mass_inertia(part, np.asarray(place))
    about -= _point_mass_inertia(mass, center)
    moments = {name: float(about[row, column]) for name, (row, column) in _NAMES.items()}
    if min(moments.values()) <= 0.0:
        raise FlightError(
            "the loading on the card removes more inertia than the aircraft file has; correct "
            "masses and positions in flight.toml"
        )
    x, y, z = center.tolist()
    return _LoadedMass(
        properties=properties.model_copy(
            update={**moments, "ixz": float(-about[0, 2]), "mass": mass}
        ),
        center=(x, y, z),
    )


def _point_mass_inertia(mass: float, place: FloatArray) -> FloatArray:
    matrix: FloatArray = mass * (place @ place * np.eye(3) - np.outer(place, place))
    return matrix


def _move_reference_point(aircraft: Aircraft, center: Position) -> Aircraft:
    """Return an aircraft whose positions count from another CG; what is not listed stays at it."""
    sensors, axles = aircraft.sensors, aircraft.axles
    return aircraft.model_copy(
        update={
            "sensors": sensors.model_copy(
                update={
                    name: _move_positions(getattr(sensors, name), "position", center)
                    for name in sensors.model_fields_set
                }
            ),
            "propulsion": _move_positions(aircraft.propulsion, "position", center),
            "mass": _move_positions(aircraft.mass, "fuel_position", center),
            "axles": axles.model_copy(
                update={
                    name: _relative_position(place, center) for name, place in {**axles}.items()
                }
            ),
        }
    )


def _move_positions(part: Part, key: str, center: Position) -> Part:
    if key not in part.model_fields_set:
        return part
    places: Any = getattr(part, key)
    several = isinstance(places[0], tuple)
    moved = (
        tuple(_relative_position(place, center) for place in places)
        if several
        else _relative_position(places, center)
    )
    return part.model_copy(update={key: moved})


def _relative_position(place: Position, center: Position) -> Position:
    x, y, z = (a - b for a, b in zip(place, center, strict=True))
    return x, y, z


def _inertia_text(file: MassProperties, found: MassProperties) -> list[str]:
    parts = [
        f"{name.capitalize()} {100.0 * (getattr(found, name) / getattr(file, name) - 1.0):+.1f} %"
        for name in _NAMES
        if abs(getattr(found, name) / getattr(file, name) - 1.0) > FLIGHT_DATA.mass_tolerance
    ]
    return [f"loading and fuel change the inertia: {', '.join(parts)}"] if parts else []


def _reference_point_text(center: Position, aircraft: Aircraft) -> str:
    x, _, _ = center
    geometry = aircraft.geometry
    return (
        "positions of sensors and engines are relative to the CG as flown; moments about the "
        f"aircraft file's CG differ by {x / geometry.chord:+.3f} C_N in pitch and "
        f"{x / geometry.span:+.4f} C_Y in yaw"
    )


def _offset_text(center: Position) -> str:
    text = (("ahead", "aft"), ("to the right", "to the left"), ("below", "above"))
    parts = [
        f"{1e3 * abs(value):.0f} mm {ahead if value > 0.0 else aft}"
        for value, (ahead, aft) in zip(center, text, strict=True)
        if abs(value) >= FLIGHT_DATA.cg_tolerance
    ]
    return ", ".join(parts)
