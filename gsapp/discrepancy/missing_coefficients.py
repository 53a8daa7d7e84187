"""The part of each coefficient that a model lacks: reconstructed from measured motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import COEFFICIENTS
from gsapp.identification.coefficients import (
    NEGATED_COEFFICIENTS,
    Coefficients,
    flight_model_without_aero,
    reconstruct_coefficients,
)
from gsapp.identification.filter_error.maneuver_record import ManeuverRecord
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.quantities import FloatArray

_CUTOFF = 3.0
"""Of the smoothing, Hz: above the modes of the aircraft."""
_PROBE = 4000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissingCoefficients:
    """Missing parts of coefficients in one maneuver.

    Attributes
    ----------
    histories : tuple of ndarray, shape (n, n_coefficients)
        One for each model; NaN where a coefficient cannot be had.
    floors : mapping of str to float
        Standard deviation that noise alone gives.
    """

    histories: tuple[FloatArray, ...]
    floors: Mapping[str, float]


def compute_missing_coefficients(
    record: ManeuverRecord, models: Sequence[Model], noise: NoiseModel, coefficients: Sequence[str]
) -> MissingCoefficients:
    """Return measured minus modeled coefficients under each model, smoothed alike."""
    found = reconstruct_coefficients(record.maneuver, motion=record.motion, cutoff=_CUTOFF)
    aircraft = record.maneuver.aircraft
    bare = flight_model_without_aero(aircraft)
    histories = []
    for model in models:
        given = _modeled(FlightModel(aircraft, model), bare, record)
        modeled = found.smooth(given)
        left = np.where(found.valid, found.values - modeled, np.nan)
        histories.append(np.column_stack([_body_axis_column(left, name) for name in coefficients]))
    floors = _noise_floors(record, found, models[-1], noise)
    return MissingCoefficients(
        histories=tuple(histories),
        floors={name: floors[NEGATED_COEFFICIENTS.get(name, name)] for name in coefficients},
    )


def _body_axis_column(left: FloatArray, name: str) -> FloatArray:
    column: FloatArray = left[:, COEFFICIENTS.index(NEGATED_COEFFICIENTS.get(name, name))]
    return -column if name in NEGATED_COEFFICIENTS else column


def _modeled(model: FlightModel, bare: FlightModel, record: ManeuverRecord) -> FloatArray:
    """Return CN, CA, CY, Cl, Cm, Cn that derivatives and effects give along the measured motion."""
    state = tuple(record.motion.states.T[: len(POLAR_STATES)])
    inputs = tuple(record.motion.inputs.T)
    own = model.steady_states(state, inputs)
    loads = model.evaluate((*state, *own), inputs).loads
    without = bare.evaluate(state, inputs).loads
    geometry = record.maneuver.aircraft.geometry
    area = record.motion.qbar * geometry.wing_area
    X, Y, Z, L, M, N = (one - other for one, other in zip(loads, without, strict=True))
    span, chord = area * geometry.span, area * geometry.chord
    columns = (-Z / area, -X / area, Y / area, L / span, M / chord, N / span)
    return np.column_stack([np.broadcast_to(one, area.shape) for one in columns])


def _noise_floors(
    record: ManeuverRecord, found: Coefficients, model: Model, noise: NoiseModel
) -> dict[str, float]:
    """Return what the noise of instruments alone makes of each missing coefficient."""
    random = np.random.default_rng(0).standard_normal((_PROBE, 1))
    smooth = float(np.std(found.smoother.smooth(random)))
    slope = float(np.std(found.smoother.smooth(found.smoother.differentiate(random))))
    maneuver = record.maneuver
    geometry, mass = maneuver.aircraft.geometry, maneuver.aircraft.mass
    area = float(np.mean(record.motion.qbar)) * geometry.wing_area
    V = float(np.mean(record.motion.state("V")))
    span, chord = area * geometry.span, area * geometry.chord

    def std(name: str) -> float:
        return float(np.sqrt(noise.variances.get(name, 0.0)))

    def through(coefficient: str, reads: Mapping[str, float]) -> float:
        parts = [model.derivative(f"{coefficient}_{name}") * size for name, size in reads.items()]
        return smooth * float(np.sqrt(np.sum(np.square(parts))))

    half = 0.5 / V
    lon = {"alpha": std("alpha"), "q": std("q") * half * geometry.chord}
    lat = {
        "beta": std("beta"),
        "p": std("p") * half * geometry.span,
        "r": std("r") * half * geometry.span,
    }
    direct = {
        "CN": smooth * std("an") * maneuver.mass / area,
        "CA": smooth * std("ax") * maneuver.mass / area,
        "CY": smooth * std("ay") * maneuver.mass / area,
        "Cl": slope * std("p") * mass.ixx / span,
        "Cm": slope * std("q") * mass.iyy / chord,
        "Cn": slope * std("r") * mass.izz / span,
    }
    return {
        name: float(np.hypot(size, through(name, lat if name in ("CY", "Cl", "Cn") else lon)))
        for name, size in direct.items()
    }
