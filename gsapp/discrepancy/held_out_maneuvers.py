"""Before and after: maneuvers kept out of naming and fitting, under every model on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gsapp.discrepancy.effect_selection import CandidateScreening, candidate_columns
from gsapp.discrepancy.results import ChannelGap, Gap, ManeuverHistories
from gsapp.discrepancy.settings import SEARCH
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
from gsapp.identification.filter_error.equation_jacobian import CONTROLS
from gsapp.identification.filter_error.filter_error_fit import (
    FilterErrorFit,
    InformationMatrix,
    bias_name,
)
from gsapp.identification.filter_error.maneuver_state import ManeuverState
from gsapp.identification.filter_error.motion_linearization import (
    ManeuverRecord,
    bias_sensitivity,
    outputs_along,
)
from gsapp.identification.filter_error.noise_model import (
    MIN_NOISE_STD,
    NoiseModel,
    sample_variance,
)
from gsapp.identification.statistics import response_fit
from gsapp.quantities import FloatArray


def is_held_out(number: int) -> bool:
    """Return whether a maneuver is kept out unless told otherwise.

    `number`: how many with the same inputs come before it.
    """
    return number % 4 == 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissingCoefficients:
    """Missing parts of coefficients in one maneuver."""

    histories: tuple[FloatArray, ...]
    """Shape (n, n_coefficients). One for each model; NaN where a coefficient cannot be had."""
    floors: Mapping[str, float]  # Standard deviation that noise alone gives.


def compute_missing_coefficients(
    record: ManeuverRecord,
    models: Sequence[Model],
    noise: NoiseModel,
    coefficients: Sequence[str],
    zeros: FloatArray,
) -> MissingCoefficients:
    """Return measured minus modeled coefficients under each model, smoothed alike.

    `zeros`, shape (n_channels,): zero errors that the models found; they are no missing part.
    """
    record = _calibrated(record, zeros)
    found = reconstruct_coefficients(record.maneuver, motion=record.motion, cutoff=SEARCH.cutoff)
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


def _calibrated(record: ManeuverRecord, zeros: FloatArray) -> ManeuverRecord:
    """Return a record without these zero errors of its channels."""
    off = zeros * bias_sensitivity(record, record.motion.state("V"))
    block, states = record.maneuver.block, record.motion.states.copy()
    values = block.values.copy()
    for column, name in enumerate(record.channels):
        if name in POLAR_STATES:
            states[:, POLAR_STATES.index(name)] -= off[:, column]
        elif name in block.channels:
            values[:, block.channels.index(name)] -= off[:, column]
    maneuver = replace(record.maneuver, block=replace(block, values=values))
    return replace(record, maneuver=maneuver, motion=replace(record.motion, states=states))


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
    random = np.random.default_rng(0).standard_normal((SEARCH.noise_samples, 1))
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


_NO_CONTROL_NOISE = (0.0,) * len(CONTROLS)
"""Noise of measured controls with which it does so too."""
_CONDITIONS = ("alpha", "beta", "V", "throttle", "de", "da", "dr", "flap")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Simulated:
    """One maneuver under all models: simulated channels, biases included."""

    record: ManeuverRecord
    computed: tuple[FloatArray, ...]


SettledFits = MutableMapping[FilterErrorFit, FilterErrorFit]
"""By fit, the maneuvers kept out under its model and noise."""


class HeldOutManeuvers:
    """The maneuvers kept out, seen through every model on the way.

    The records are of all maneuvers, the ids those kept out; the fits, baseline first, were made
    without them. All are judged with the noise of the last. `settled` keeps, for the next time,
    what took long.
    """

    def __init__(
        self,
        records: Sequence[ManeuverRecord],
        ids: Sequence[str],
        fits: Sequence[FilterErrorFit],
        settled: SettledFits | None = None,
    ) -> None:
        self.ids = tuple(ids)
        self.fits = tuple(fits)
        self.warnings: tuple[str, ...] = ()
        noise = fits[-1].noise
        own = [one for one in records if one.id in self.ids]
        known = {one.record.flight for one in fits[-1].maneuvers}
        strange = [one for one in own if one.flight not in known]
        if strange:
            few = len(strange) == 1
            self.warnings = (
                f"{'maneuver' if few else 'maneuvers'} {', '.join(one.id for one in strange)} "
                f"{'is' if few else 'are'} of a flight from which nothing was learned: zero errors "
                "are estimated there, and the noise is that of the first flight",
            )
        self._unknown_biases = tuple(
            dict.fromkeys(name for one in strange for name in fits[-1].bias_names_of(one))
        )
        self._kept = [
            _with_noise(_settled(own, fit, {} if settled is None else settled), noise)
            for fit in fits
        ]
        self._information = [
            self._with_known_biases(one.information(), one.priors()) for one in self._kept
        ]
        self._records = tuple(records)
        self.noise = noise
        self._floors: dict[tuple[str, str], float] = {}

    def _with_known_biases(
        self, information: InformationMatrix, priors: Mapping[str, tuple[float, float]]
    ) -> InformationMatrix:
        """Return without the zero errors of flights that were not learned from.

        No model can foretell them.
        """
        unknown = self._unknown_biases
        if not unknown:
            return information
        return information.with_priors({name: priors[name] for name in unknown}).projected(unknown)

    @cached_property
    def simulated(self) -> tuple[_Simulated, ...]:
        """All maneuvers under all models, in still air."""
        still = {
            flight: replace(
                one,
                gust_intensities=(SEARCH.still_air_intensity,) * 3,
                rotation_intensities=None,
                gradient_gains=(0.0, 0.0),
                moment_intensity=SEARCH.still_air_intensity,
                control_intensities=_NO_CONTROL_NOISE,
            )
            for flight, one in self.noise.items()
        }
        by_fit = []
        for fit, kept in zip(self.fits, self._kept, strict=True):
            # One fit at a time: its filters of all maneuvers take hundreds of megabytes.
            flown = _refit_motion(self._records, fit, still, kept.biases)
            by_fit.append([_computed(flown, one) for one in flown.maneuvers])
        return tuple(
            _Simulated(record=record, computed=computed)
            for record, computed in zip(self._records, zip(*by_fit, strict=True), strict=True)
        )

    def zeros_of(self, record: ManeuverRecord) -> FloatArray:
        """Return the zero error of each channel of a maneuver under the last model."""
        known = {**self._kept[-1].biases, **self.fits[-1].biases}
        return np.array([known[bias_name(record.flight, name)] for name in record.channels])

    def noise_floor(self, record: ManeuverRecord, name: str) -> float:
        """Return the noise of a channel, standard deviation of a sample.

        Tones that mean out over the filter's blocks (the engines shake the gyros) are in it.
        """
        key = record.id, name
        if key not in self._floors:
            self._floors[key] = self._floor(record, name)
        return self._floors[key]

    def _floor(self, record: ManeuverRecord, name: str) -> float:
        noise = self.noise.get(record.flight, next(iter(self.noise.values())))
        correlation = noise.correlations.get(name, 0.0)
        single = sample_variance(record, name, correlation)
        believed = 0.0 if correlation else noise.variances[name]
        return float(np.sqrt(max(single, believed)))

    # --- in innovations -------------------------------------------------------------------------

    def _squares(self, number: int) -> float:
        return float(self._information[number].matrix[-1, -1])

    @property
    def samples(self) -> float:
        """Return the number of innovations of the maneuvers kept out."""
        return self._information[-1].samples

    def squares_above_noise(self, number: int, scatter: float) -> tuple[float, float]:
        """Return the sum of squares above what noise leaves, and its standard deviation.

        `scatter`: of the mean square from maneuver to maneuver.
        """
        above = self._squares(number) - self.samples
        return above, self.samples * scatter / float(np.sqrt(max(len(self.ids), 1)))

    def misfits(self) -> list[float]:
        """Return the mean square of the whitened innovations under each model; 1 at the floor."""
        return [
            float(np.sqrt(self._squares(index) / max(information.samples, 1.0)))
            for index, information in enumerate(self._information)
        ]

    def contradict(self, before: int, found: float, samples: float, least: float) -> bool:
        """Return whether these maneuvers speak against what the model after `before` has more.

        Parameters
        ----------
        before : int
            Number of a model.
        found, least : float
            Gain in the sum of squares on the maneuvers that named it, and below which nothing is
            named.
        samples : float
            Innovations of those maneuvers.
        """
        after = before + 1
        # As there, all counts less where the innovations are larger than believed.
        temper = 1.0 / max(1.0, self._squares(after) / max(self.samples, 1.0))
        return is_contradicted(
            temper * self.gain(before, after),
            found,
            self.samples / samples,
            least,
            temper * self.prediction_distance(before, after),
        )

    def gain(self, before: int, after: int) -> float:
        """Return the gain in log-likelihood from one model to another."""
        return 0.5 * (self._squares(before) - self._squares(after))

    def prediction_distance(self, before: int, after: int) -> float:
        """Return the sum of squares between the innovations that two models expect.

        Where it is small these maneuvers cannot say which of the two is right: a zero error of a
        flight, say, is told by its size alone.
        """
        fit = self._kept[after]
        total = InformationMatrix(names=(), matrix=np.zeros((1, 1)), samples=0.0)
        for old, new in zip(self._kept[before].maneuvers, fit.maneuvers, strict=True):
            if (
                old.filtered_columns is None
                or new.filtered_columns is None
                or len(old.filtered_columns.rows) != len(new.filtered_columns.rows)
            ):
                continue
            rows, n_states = new.filtered_columns.rows, new.filtered_columns.n_initial_states
            basis, _ = np.linalg.qr(rows[:, -1 - n_states : -1])
            biases = fit.bias_names_of(new.record)
            columns = rows[:, -1 - n_states - len(biases) : -1 - n_states]
            between = rows[:, -1] - old.filtered_columns.rows[:, -1]
            rest = np.column_stack((columns, between))
            rest -= basis @ (basis.T @ rest)
            total += InformationMatrix(names=biases, matrix=rest.T @ rest, samples=0.0)
        priors = {name: (0.0, std) for name, (_, std) in fit.priors().items()}
        return float(self._with_known_biases(total, priors).matrix[-1, -1])

    def candidate_gains(
        self, number: int, screening: CandidateScreening, places: Sequence[int]
    ) -> tuple[float, ...]:
        """Return the gains that candidates, sized on the naming maneuvers, have here."""
        fit, kept = self.fits[number], self._kept[number]
        chosen = [screening.candidates[place] for place in places]
        names = tuple(one.id for one in chosen)
        total = self._with_known_biases(
            kept.information(
                (names, lambda linearization: candidate_columns(chosen, linearization))
            ),
            kept.priors(),
        )
        shared = (*fit.free, *fit.bias_names())
        gains = []
        for name in names:
            own = (*shared, name)
            values, _ = screening.full_information.solution(own)
            moves = {
                one: float(value)
                for one, value in zip(own, values, strict=True)
                if one in total.names
            }
            gains.append(0.5 * float(total.matrix[-1, -1] - total.misfit(moves)))
        return tuple(gains)

    # --- in simulated channels ------------------------------------------------------------------

    def residuals(self, number: int, name: str) -> FloatArray:
        """Return measured minus simulated over all maneuvers kept out, in noise floors."""
        parts = []
        for one in self.simulated:
            record = one.record
            if record.id in self.ids and name in record.channels:
                column = record.channels.index(name)
                left = record.measured[:, column] - one.computed[number][:, column]
                parts.append(left[record.valid[:, column]] / self.noise_floor(record, name))
        return np.concatenate(parts) if parts else np.empty(0)

    @property
    def channels(self) -> tuple[str, ...]:
        own = [one.record for one in self.simulated if one.record.id in self.ids]
        return tuple(dict.fromkeys(name for record in own for name in record.channels))

    def relative_rms(self, number: int) -> dict[str, float]:
        return {
            name: float(np.sqrt(np.mean(self.residuals(number, name) ** 2)))
            for name in self.channels
        }


def is_contradicted(gain: float, found: float, share: float, least: float, apart: float) -> bool:
    """Return whether maneuvers kept out speak against an effect.

    Parameters
    ----------
    gain : float
        Of the log-likelihood on the maneuvers kept out.
    found, least : float
        Gain in the sum of squares on the maneuvers that named it, and below which nothing is named.
    share : float
        Samples kept out, for each of those that named it.
    apart : float
        Sum of squares between what the models with and without it expect there.
    """
    if gain > 0.0:
        return False
    # As many maneuvers of this kind as named it would leave too little,
    undone = found + 2.0 * gain / share < least
    # or an effect of its size would have shown: its gain there has this mean and this deviation.
    return undone or gain < 0.5 * apart - SEARCH.contradiction_sigmas * math.sqrt(apart)


def _settled(
    records: Sequence[ManeuverRecord], fit: FilterErrorFit, settled: SettledFits
) -> FilterErrorFit:
    """Return maneuvers kept out under the model and noise of a fit, linearized."""
    if fit not in settled:
        new = _refit_motion(records, fit, fit.noise)
        new.linearize()
        settled[fit] = new
    return settled[fit]


def _with_noise(fit: FilterErrorFit, noise: Mapping[str, NoiseModel]) -> FilterErrorFit:
    """Return a fit with other noise and the same motion."""
    new = fit.branch(_noise_of([one.record for one in fit.maneuvers], noise))
    if all(new.noise[name].gust_shape == one.gust_shape for name, one in fit.noise.items()):
        new.refilter()
    else:
        new.linearize()
    return new


def _noise_of(
    records: Sequence[ManeuverRecord], noise: Mapping[str, NoiseModel]
) -> dict[str, NoiseModel]:
    """Return the noise of each record's flight; that of the first where nothing was learned."""
    first = next(iter(noise.values()))
    return {record.flight: noise.get(record.flight, first) for record in records}


def _refit_motion(
    records: Sequence[ManeuverRecord],
    fit: FilterErrorFit,
    noise: Mapping[str, NoiseModel],
    biases: Mapping[str, float] | None = None,
) -> FilterErrorFit:
    """Return a fit of other maneuvers with the model, values and biases of one, settled.

    The biases of flights that it does not know are estimated, unless they are given.
    """
    if not records:
        return fit.subset(())
    new = FilterErrorFit.create(records, fit.revised_model(), fit.free, _noise_of(records, noise))
    new.values = dict(fit.values)
    known = {**(biases or {}), **fit.biases}
    new.biases = {name: known.get(name, 0.0) for name in new.biases}
    unknown = [name for name in new.bias_names() if name not in known]
    states = {one.record.id: one for one in fit.maneuvers}
    for one in new.maneuvers:
        old = states.get(one.record.id)
        if old is not None:
            one.motion = old.motion
    for _ in range(SEARCH.linearization_passes):
        new.linearize()
        if unknown:
            new.move_biases(unknown, new.information())
        else:
            new.update_motion()
    return new


def _computed(fit: FilterErrorFit, one: ManeuverState) -> FloatArray:
    computed: FloatArray = outputs_along(one.record, one.flight_model, one.motion)
    return computed + fit.bias_of(one.record) * bias_sensitivity(one.record, one.motion.states[0])


def compute_gap(held: HeldOutManeuvers, left: float | None, scatter: float) -> Gap:
    """Return the gap before and after on the maneuvers kept out.

    Parameters
    ----------
    left : float or None
        Gain in log-likelihood there of what would be added next; None where nothing was added.
    scatter : float
        Standard deviation of the mean square of the innovations from maneuver to maneuver.
    """
    last = len(held.fits) - 1
    channels = {
        name: _channel_gap(held, name, last)
        for name in held.channels
        if held.residuals(0, name).size
    }
    closed, std = (None, None) if left is None else _closed_share(held, last, left, scatter)
    return Gap(channels=channels, closed=closed, closed_std=std, on=held.ids)


def _channel_gap(held: HeldOutManeuvers, name: str, last: int) -> ChannelGap:
    measured, computed, floors = [], ([], []), []  # type: ignore[var-annotated]
    for one in held.simulated:
        record = one.record
        if record.id not in held.ids or name not in record.channels:
            continue
        column = record.channels.index(name)
        counted = record.valid[:, column]
        measured.append(record.measured[counted, column])
        floors.append(held.noise_floor(record, name))
        for index, number in enumerate((0, last)):
            computed[index].append(one.computed[number][counted, column])
    shown = np.concatenate(measured)
    floor = float(np.sqrt(np.mean(np.square(floors))))
    fits = [response_fit(shown, np.concatenate(one)) for one in computed]
    within = [
        float(np.mean(np.abs(shown - np.concatenate(one)) < SEARCH.floor_ratio * floor))
        for one in computed
    ]
    return ChannelGap(
        before=fits[0].rms,
        after=fits[1].rms,
        floor=floor,
        before_pct=fits[0].rms_over_range_pct,
        after_pct=fits[1].rms_over_range_pct,
        theil_before=fits[0].theil,
        theil_after=fits[1].theil,
        within_before=within[0],
        within_after=within[1],
        floor_is_bound=floor <= 1.001 * MIN_NOISE_STD[name],
    )


def _closed_share(
    held: HeldOutManeuvers, last: int, left: float, scatter: float
) -> tuple[float | None, float | None]:
    """Return the share of the gap that was closed, and its standard deviation.

    In sums of squares of whitened innovations: T, what the last model took off, over T + L. L is
    what stands above the noise, where that is more than maneuvers differ anyway. Else it is what
    the best effect still to add would take off, sized on the maneuvers of the fit: models share
    noise and gusts, which cancel, so that it is known far better. Gains T and L scatter by 2 root T
    and 2 root L. Where T + L is within `min_gap_sigmas` of noise nothing can be said: None.
    """
    least = SEARCH.min_gap_sigmas
    taken, left = 2.0 * held.gain(0, last), max(2.0 * left, 0.0)
    left_std = 2.0 * float(np.sqrt(max(left, 1.0)))
    above, above_std = held.squares_above_noise(last, scatter)
    if above > max(least * above_std, left):
        left, left_std = above, above_std
    whole = taken + left
    if not held.samples or whole < least**2:
        return None, None
    taken_std = 2.0 * float(np.sqrt(max(held.prediction_distance(0, last), abs(taken), 1.0)))
    std = float(np.hypot(left * taken_std, taken * left_std)) / whole**2
    return float(np.clip(taken / whole, -1.0, 1.0)), min(1.0, std)


def maneuver_histories(
    held: HeldOutManeuvers, coefficients: Sequence[str]
) -> tuple[ManeuverHistories, ...]:
    """Return the histories of all maneuvers under every model."""
    models = [fit.revised_model() for fit in held.fits]
    found = []
    for one in held.simulated:
        record = one.record
        noise = held.noise.get(record.flight, next(iter(held.noise.values())))
        part = compute_missing_coefficients(
            record, models, noise, coefficients, held.zeros_of(record)
        )
        found.append(
            ManeuverHistories(
                id=record.id,
                flight=record.flight,
                kind=record.maneuver.kind,
                held_out=record.id in held.ids,
                times=record.motion.times,
                channels=record.channels,
                measured=np.where(record.valid, record.measured, np.nan),
                computed=one.computed,
                coefficients=tuple(coefficients),
                missing=part.histories,
                noise_floor={name: held.noise_floor(record, name) for name in record.channels},
                coefficient_noise_floor=part.floors,
                conditions=_conditions(record),
            )
        )
    return tuple(found)


def _conditions(record: ManeuverRecord) -> dict[str, FloatArray]:
    motion = record.motion
    found = {}
    for name in _CONDITIONS:
        if name in motion.measured:
            if name in ("V", "alpha", "beta"):
                found[name] = motion.state(name)
            else:
                found[name] = motion.input(name)
    return found
