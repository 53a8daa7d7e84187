"""What one maneuver after the other teaches: bounds, values, noise, habits of the pilot."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.information.information_matrix import CombinedInformation
from gsapp.excitation.information.planned_maneuver import USABLE_RESULTS, PilotErrorModel
from gsapp.excitation.information.predicted_bounds import (
    ResponseNoise,
    assumed_noise,
    compute_sensitivities,
    fit_filter_error,
    fit_maximum_likelihood,
    information_from_fit,
    noise_from_quiet_segment,
    noise_from_residuals,
    pool_noise,
    predict_in_gusts,
)
from gsapp.excitation.settings import INFORMATION
from gsapp.excitation.test_points.perturbation_models import update_model
from gsapp.flight import Flight
from gsapp.flight.cards import TestCard
from gsapp.flight.maneuvers.signals import RESPONSE_SIGNALS, SURFACES
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_RESPONSES, Axis
from gsapp.identification.filter_error.estimator import FilterErrorSolution
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.identification.ftr.estimates import LiveEstimate
from gsapp.identification.maneuver import Maneuver, cut_maneuver
from gsapp.identification.maximum_likelihood import MLSolution
from gsapp.quantities import Block

ESTIMATION_CHANNELS: Final = (
    *SURFACES, *RESPONSE_SIGNALS, "V", "phi", "theta", "psi", "qbar", "dynamic_pressure", "density",
    "static_pressure", "temperature", "throttle", "throttle_left", "throttle_right", "flap",
)  # fmt: skip
"""What estimates are made from, as far as a flight has it."""


def block_from_rows(rows: FlightRows) -> Block:
    """Return the channels of rows that hold anything and that estimates are made from."""
    there = [name for name in ESTIMATION_CHANNELS if np.isfinite(rows[name]).any()]
    values = np.column_stack([rows[name] for name in there]) if there else None
    return Block(
        channels=tuple(there),
        times=rows.times,
        values=np.empty((len(rows), 0)) if values is None else values,
    )


def maneuver_from_rows(
    rows: FlightRows,
    aircraft: Aircraft,
    t_start: float,
    t_end: float,
    *,
    id: str,  # noqa: A002 - as everywhere
    inputs: Sequence[str],
    mass: float,
) -> Maneuver:
    """Return a maneuver cut from rows as it will be cut from the record after the flight.

    Some more rows on both sides help: channels are brought to their right time.
    """
    flight = Flight(name="this flight", path=Path(), block=block_from_rows(rows), sources={})
    return cut_maneuver(
        flight,
        aircraft,
        t_start,
        t_end,
        id=id,
        inputs=inputs,
        mass=np.full(len(rows), mass),
    )


ESTIMATION_AXES: Final[tuple[Axis, ...]] = ("lon", "lat")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightKnowledge:
    """What a flight has taught so far."""

    initial_model: Model
    """The model that the flight began with."""
    rate: float
    """Of the rows, Hz."""
    mass: float
    totals: Mapping[Axis, CombinedInformation] = field(
        default_factory=lambda: {axis: CombinedInformation.empty(axis) for axis in ESTIMATION_AXES}
    )
    measured_noise: Mapping[Axis, tuple[ResponseNoise, ...]] = field(default_factory=dict)
    """By axis."""
    gusts: Mapping[Axis, NoiseModel] = field(default_factory=dict)
    """Of the latest maneuver of an axis, if it was flown in gusts: filter error takes the place of
    maximum likelihood there."""
    pilot_errors: PilotErrorModel = field(default_factory=PilotErrorModel)
    ftr_estimates: Mapping[str, LiveEstimate] = field(default_factory=dict)
    """The flight's own FTR estimates."""
    channels: frozenset[str] = frozenset(AXIS_RESPONSES["both"])
    """Measured in the latest maneuver."""
    density: float = SEA_LEVEL_DENSITY
    """At the latest maneuver, kg, kg/m^3."""
    maneuvers: int = 0
    """That brought something."""
    predicted_bounds: Mapping[str, float] = field(default_factory=dict)
    """Bounds expected for the latest one's input as it was flown and the noise there was, at the
    values known before: what its fit should report."""
    remarks: tuple[str, ...] = ()
    """Why others brought nothing."""

    def estimates(self) -> dict[str, tuple[float, float]]:
        """Return value and bound of every derivative that some maneuver saw."""
        return {
            name: one for total in self.totals.values() for name, one in total.estimates().items()
        }

    def updated_model(self, aircraft: Aircraft) -> Model:
        """Return the model with what this flight has earned."""
        own = {
            name: LiveEstimate(name=name, value=value, std=std)
            for name, (value, std) in self.estimates().items()
        }
        return update_model(self.initial_model, {**self.ftr_estimates, **own}, aircraft=aircraft)

    def noise(self, axis: Axis, aircraft: Aircraft) -> ResponseNoise:
        """Return the noise to be expected, as heard so far; else that of the instruments."""
        heard = self.measured_noise.get(axis, ())
        if not heard:
            return assumed_noise(aircraft, AXIS_RESPONSES[axis], self.rate)
        return pool_noise([one for one in heard if one.responses == heard[-1].responses])

    def with_noise(self, axis: Axis, noise: ResponseNoise) -> FlightKnowledge:
        heard = (*self.measured_noise.get(axis, ()), noise)[-INFORMATION.max_noise_stretches :]
        return replace(self, measured_noise={**self.measured_noise, axis: heard})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverData:
    """A maneuver to learn from."""

    verdict: InputVerdict
    rows: FlightRows
    """From `INFORMATION.noise_time` seconds before it to its end."""
    card: TestCard | None
    """That it was flown for."""
    mass: float
    """kg."""
    ftr_estimates: Mapping[str, LiveEstimate]
    """By FTR until then."""


KnowledgeUpdate = Generator[None, None, FlightKnowledge]


def learn_from_maneuver(
    before: FlightKnowledge, lesson: ManeuverData, aircraft: Aircraft
) -> KnowledgeUpdate:
    """Learn from a maneuver in steps of some ten milliseconds; give what is known then."""
    verdict = lesson.verdict
    habits = before.pilot_errors.updated_by_verdict(verdict, lesson.card)
    now = replace(
        before,
        pilot_errors=habits,
        mass=lesson.mass,
        ftr_estimates=lesson.ftr_estimates,
        predicted_bounds={},
    )
    if verdict.result not in USABLE_RESULTS:
        return now
    model = now.updated_model(aircraft)
    try:
        maneuver = maneuver_from_rows(
            lesson.rows,
            aircraft,
            verdict.t_start,
            verdict.t_end,
            id=verdict.id,
            inputs=verdict.surfaces,
            mass=lesson.mass,
        )
    except FlightError as error:
        return _with_remark(now, verdict, error)
    now = _with_flight_condition(now, maneuver)
    yield
    stop = verdict.t_start
    start = max(stop - INFORMATION.noise_time, float(lesson.rows.times[0]))
    for axis in ESTIMATION_AXES:
        now = _with_measured_noise(now, lesson.rows, (start, stop), aircraft, axis)
        yield
    useful = False
    for axis in axes_of(verdict.surfaces):
        usual = now.noise(axis, aircraft)
        try:
            sensed = compute_sensitivities(maneuver, axis, model, usual.responses)
            planned_for = sensed.information(usual).stds
            yield
            if axis in now.gusts:
                steps = predict_in_gusts(maneuver, axis, model, now.gusts[axis])
                planned_for = (yield from steps).stds
            foreseen = sensed.information(sensed.estimate_noise()).stds
            before_fit = now
            now = _with_bound_ratios(now, foreseen, planned_for)
            yield
            solution = fit_maximum_likelihood(maneuver, axis, model)
        except FlightError as error:
            now = _with_remark(now, verdict, error)
            continue
        if not solution.estimate.converged:
            now = _with_remark(now, verdict, solution.estimate.message)
            continue
        yield
        in_gusts = None
        if solution.estimate.gusty_maneuvers:
            in_gusts = yield from _fit_in_gusts(maneuver, axis, model)
        if in_gusts is not None:
            (noise,) = in_gusts.noise.values()
            foreseen = (yield from predict_in_gusts(maneuver, axis, model, noise)).stds
            now = _with_bound_ratios(before_fit, foreseen, planned_for)
        now, useful = _with_fit(now, solution, in_gusts, axis), True
        yield
    return replace(now, maneuvers=now.maneuvers + useful)


def _fit_in_gusts(
    maneuver: Maneuver, axis: Axis, model: Model
) -> Generator[None, None, FilterErrorSolution | None]:
    """Fit by filter error, in steps; None where maximum likelihood has to do."""
    try:
        found = yield from fit_filter_error(maneuver, axis, model)
    except FlightError:
        return None
    return found if found.estimate.converged else None


def learn_noise(before: FlightKnowledge, rows: FlightRows, aircraft: Aircraft) -> KnowledgeUpdate:
    """Hear the noise in the quietest part of a stretch of flight; give what is known then."""
    now = before
    between = _find_quietest_segment(rows)
    for axis in ESTIMATION_AXES:
        now = _with_measured_noise(now, rows, between, aircraft, axis)
        yield
    return now


def _find_quietest_segment(rows: FlightRows) -> tuple[float, float]:
    """Return the `INFORMATION.noise_time` of least rotation: its start and end, s."""
    dt = float(np.median(np.diff(rows.times)))
    length = min(round(INFORMATION.noise_time / dt), len(rows) - 1)
    rates = np.nan_to_num(np.stack([rows[name] for name in ("p", "q", "r")]))
    sums = np.cumsum(np.pad((rates * rates).sum(axis=0), (1, 0)))
    first = int(np.argmin(sums[length:] - sums[:-length]))
    return float(rows.times[first]), float(rows.times[min(first + length, len(rows) - 1)])


def axes_of(surfaces: tuple[str, ...]) -> tuple[Axis, ...]:
    """Return the axes that a maneuver is fitted in: longitudinal and lateral each by itself."""
    found: list[Axis] = []
    if "de" in surfaces:
        found.append("lon")
    if not {"da", "dr"}.isdisjoint(surfaces):
        found.append("lat")
    return tuple(found)


def _with_flight_condition(now: FlightKnowledge, maneuver: Maneuver) -> FlightKnowledge:
    """Return the knowledge with what is measured, how often and in what air."""
    density = maneuver.samples("density")
    there = density[np.isfinite(density)]
    return replace(
        now,
        rate=1.0 / maneuver.dt,
        channels=frozenset(name for name in maneuver.block.channels if maneuver.has(name)),
        density=float(there.mean()) if there.size else now.density,
    )


def _with_measured_noise(
    now: FlightKnowledge,
    rows: FlightRows,
    between: tuple[float, float],
    aircraft: Aircraft,
    axis: Axis,
) -> FlightKnowledge:
    """Return the knowledge with the noise heard in a stretch of flight; as it was if it cannot."""
    start, stop = between
    if stop - start < INFORMATION.min_noise_time:
        return now
    try:
        stretch = maneuver_from_rows(
            rows, aircraft, start, stop, id="no input", inputs=(), mass=now.mass
        )
        return now.with_noise(
            axis, noise_from_quiet_segment(stretch, axis, now.updated_model(aircraft))
        )
    except FlightError:
        return now


def _with_bound_ratios(
    now: FlightKnowledge, foreseen: Mapping[str, float], planned_for: Mapping[str, float]
) -> FlightKnowledge:
    ratios = [std / planned_for[name] for name, std in foreseen.items() if name in planned_for]
    habits = now.pilot_errors.updated_by_bounds(ratios) if ratios else now.pilot_errors
    return replace(now, pilot_errors=habits, predicted_bounds={**now.predicted_bounds, **foreseen})


def _with_fit(
    now: FlightKnowledge, solution: MLSolution, in_gusts: FilterErrorSolution | None, axis: Axis
) -> FlightKnowledge:
    """Return the knowledge with a fit by maximum likelihood; filter error counts if it is there."""
    found = in_gusts or solution
    information = information_from_fit(found)
    values = {name: found.value(name) for name in information.names}
    gusts = {name: one for name, one in now.gusts.items() if name != axis}
    if in_gusts is not None:
        (gusts[axis],) = in_gusts.noise.values()
    return replace(
        now.with_noise(axis, noise_from_residuals(solution, now.rate)),
        totals={**now.totals, axis: now.totals[axis].with_maneuver(information, values)},
        gusts=gusts,
    )


def _with_remark(
    now: FlightKnowledge, verdict: InputVerdict, why: FlightError | str
) -> FlightKnowledge:
    return replace(now, remarks=(*now.remarks, f"{verdict.id} gave no information: {why}"))
