"""A model fitted to many maneuvers by filter error, with its noise.

Parameters are those of the equations (derivatives, effects), of control paths and instruments, and
one bias for each channel of each flight; initial states of each maneuver are projected out. Each
`FilterErrorFit.pass_` linearizes anew along the filter's own prediction, which depends on earlier
samples only: sensitivities are so independent of the noise that they are compared with.

`InformationMatrix` holds the normal equations of whitened innovations: all that comparing models
needs. Matrices of several maneuvers add up. What belongs to one maneuver only (its initial state)
was projected out before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gsapp.dynamics.buildup import derivative_names, linear_variables
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.filter_error.kalman import DIVERGED_TEXT, create_filter
from gsapp.identification.filter_error.maneuver_state import (
    FilteredColumns,
    ManeuverState,
    SensitivityColumn,
    SensitivityEntry,
    filter_columns,
    path_columns,
    predicted_motion,
)
from gsapp.identification.filter_error.motion_linearization import (
    Linearization,
    ManeuverRecord,
    NominalMotion,
    initial_motion,
    linearize_along,
)
from gsapp.identification.filter_error.noise_model import NoiseModel, initial_noise
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE, GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InformationMatrix:
    """Normal equations in named parameters."""

    names: tuple[str, ...]
    matrix: FloatArray  # Shape (m + 1, m + 1). Products of the columns, the residual last.
    samples: float  # Number of innovations behind it, less the degrees of freedom already spent.

    def __add__(self, other: InformationMatrix) -> InformationMatrix:
        """Return the sum; parameters that one lacks count as unseen by it."""
        samples = self.samples + other.samples
        if self.names == other.names:
            return InformationMatrix(
                names=self.names, matrix=self.matrix + other.matrix, samples=samples
            )
        names = tuple(dict.fromkeys((*self.names, *other.names)))
        table = {name: index for index, name in enumerate(names)}
        total = np.zeros((len(names) + 1, len(names) + 1))
        for one in (self, other):
            places = [*(table[name] for name in one.names), len(names)]
            total[np.ix_(places, places)] += one.matrix
        return InformationMatrix(names=names, matrix=total, samples=samples)

    def indices(self, names: Iterable[str]) -> list[int]:
        """Return where names stand."""
        table = {name: index for index, name in enumerate(self.names)}
        return [table[name] for name in names]

    def renamed(self, among: Iterable[str], names: Mapping[str, str]) -> InformationMatrix:
        """Return with those of some names that are given new ones, and without the rest of them."""
        gone = set(among) - names.keys()
        kept = [index for index, name in enumerate(self.names) if name not in gone]
        places = [*kept, len(self.names)]
        return InformationMatrix(
            names=tuple(names.get(self.names[index], self.names[index]) for index in kept),
            matrix=self.matrix[np.ix_(places, places)],
            samples=self.samples,
        )

    def with_priors(self, priors: Mapping[str, tuple[float, float]]) -> InformationMatrix:
        """Return with a-priori knowledge: by name, value still missing and its deviation."""
        matrix = self.matrix.copy()
        for name, (value, std) in priors.items():
            if name in self.names:
                index = self.names.index(name)
                weight = 1.0 / std**2
                matrix[index, index] += weight
                matrix[index, -1] += weight * value
                matrix[-1, index] += weight * value
                matrix[-1, -1] += weight * value * value
        return InformationMatrix(names=self.names, matrix=matrix, samples=self.samples)

    def projected(self, nuisance: Sequence[str]) -> InformationMatrix:
        """Return what is left of all columns when the nuisance parameters have taken their part."""
        out = self.indices(nuisance)
        kept = [index for index in range(len(self.names)) if index not in set(out)]
        places = [*kept, len(self.names)]
        block = self.matrix[np.ix_(out, out)]
        cross = self.matrix[np.ix_(out, places)]
        scale = np.sqrt(np.maximum(block.diagonal(), 1e-300))
        normal = block / scale[:, None] / scale + FILTER_ERROR.ridge * np.eye(len(out))
        taken = np.linalg.solve(normal, cross / scale[:, None])
        left = self.matrix[np.ix_(places, places)] - (cross / scale[:, None]).T @ taken
        return InformationMatrix(
            names=tuple(self.names[index] for index in kept),
            matrix=0.5 * (left + left.T),
            samples=self.samples - len(out),
        )

    def solution(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Return values and covariance of these parameters, all others zero.

        One that nothing is known of is zero, with a bound beyond any other.
        """
        places = self.indices(names)
        block = self.matrix[np.ix_(places, places)]
        known = block.diagonal()
        scale = np.sqrt(np.where(known > 0.0, known, 1.0))
        normal = block / scale[:, None] / scale + FILTER_ERROR.ridge * np.eye(len(places))
        covariance = np.linalg.inv(normal) / scale[:, None] / scale
        return covariance @ self.matrix[places, -1], covariance

    def misfit(self, values: Mapping[str, float]) -> float:
        """Return the sum of squares that is left with these values, all others zero."""
        places = self.indices(values)
        x = np.array([*values.values()])
        block = self.matrix[np.ix_(places, places)]
        return float(self.matrix[-1, -1] - 2.0 * x @ self.matrix[places, -1] + x @ block @ x)

    def gains(self, of: InformationMatrix) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return, for every single parameter, gain in the sum of squares, value, and std.

        `of`: the same before projection: a column of which next to nothing is left gains nothing.
        """
        raw = of.matrix.diagonal()[of.indices(self.names)]
        own = self.matrix.diagonal()[:-1]
        seen = own > FILTER_ERROR.min_information_share * np.maximum(raw, 1e-300)
        safe = np.where(seen, own, 1.0)
        score = self.matrix[:-1, -1]
        return (
            np.where(seen, score**2 / safe, 0.0),
            np.where(seen, score / safe, 0.0),
            np.where(seen, safe**-0.5, np.inf),
        )

    def cosines(self, name: str) -> FloatArray:
        """Return how alike each parameter's column is to that of one, -1 to 1."""
        index = self.names.index(name)
        own = np.sqrt(np.maximum(self.matrix.diagonal()[:-1], 1e-300))
        return np.asarray(self.matrix[:-1, index] / own / own[index])


BIAS_PRIOR_STD: Mapping[str, float] = {
    "V": 0.3,
    **dict.fromkeys(("alpha", "beta", "phi", "theta"), 0.3 * DEGREE),
    **dict.fromkeys(("p", "q", "r"), 0.3 * DEGREE),
    **dict.fromkeys(("ax", "ay", "an"), 0.02 * GRAVITY),
}
"""Zero error that an instrument may have after its calibration (SI), standard deviation."""

_DERIVATIVES = frozenset(derivative_names())

ExtraColumns = Callable[[Linearization], Sequence[SensitivityColumn]]
"""What to add to the columns of the model: candidates, in the order of their names."""


BIAS_PREFIX = "bias."
"""Of the names of biases; no other parameter has it."""


def bias_name(flight: str, channel: str) -> str:
    """Return the name of the bias of a channel in a flight."""
    return f"{BIAS_PREFIX}{flight}.{channel}"


@dataclass(slots=True, weakref_slot=True, kw_only=True, eq=False)
class FilterErrorFit:
    """A model, its noise, and its maneuvers."""

    model: Model
    free: tuple[str, ...]  # Free parameters: derivatives, and ``<effect id>.<parameter>``.
    values: dict[str, float]  # Of the free parameters.
    biases: dict[str, float]  # By `bias_name`.
    noise: dict[str, NoiseModel]  # By flight.
    maneuvers: list[ManeuverState] = field(default_factory=list)
    bias_stds: Mapping[str, float] = field(default_factory=lambda: BIAS_PRIOR_STD)
    """Standard deviation of the zero error of each channel that has one, SI; infinite where nothing
    is known of it."""
    value_priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """A-priori value and standard deviation of free parameters."""

    # --- making ---------------------------------------------------------------------------------

    @classmethod
    def create(
        cls,
        records: Sequence[ManeuverRecord],
        model: Model,
        free: Sequence[str],
        noise: Mapping[str, NoiseModel] | None = None,
    ) -> FilterErrorFit:
        """Return a fit that has seen nothing yet; without noise given, it is guessed."""
        if noise is None:
            noise = {
                flight: initial_noise([one for one in records if one.flight == flight])
                for flight in sorted({record.flight for record in records})
            }
        fit = cls(
            model=model,
            free=tuple(free),
            values={},
            biases={
                bias_name(record.flight, name): 0.0
                for record in records
                for name in record.channels
            },
            noise=dict(noise),
        )
        made: dict[int, FlightModel] = {}
        for record in records:
            aircraft = record.maneuver.aircraft
            flight_model = made.setdefault(id(aircraft), FlightModel(aircraft, model))
            fit.maneuvers.append(
                ManeuverState(
                    record=record,
                    flight_model=flight_model,
                    motion=initial_motion(record, flight_model),
                )
            )
        fit.values = fit._model_values()
        return fit

    def with_model(self, model: Model, free: Sequence[str]) -> FilterErrorFit:
        """Return a fit of another model that starts where this one stands."""
        fit = FilterErrorFit.create([one.record for one in self.maneuvers], model, free, self.noise)
        fit.biases = dict(self.biases)
        for new, old in zip(fit.maneuvers, self.maneuvers, strict=True):
            own = new.motion.states[8:]
            new.motion = NominalMotion(
                states=np.vstack((old.motion.states[:8], own)), gust=old.motion.gust.copy()
            )
        return fit

    def subset(self, ids: Sequence[str]) -> FilterErrorFit:
        """Return a fit of some of the maneuvers, sharing their states."""
        return FilterErrorFit(
            model=self.model,
            free=self.free,
            values=dict(self.values),
            biases=dict(self.biases),
            noise=dict(self.noise),
            bias_stds=self.bias_stds,
            value_priors=self.value_priors,
            maneuvers=[one for one in self.maneuvers if one.record.id in set(ids)],
        )

    def _model_values(self) -> dict[str, float]:
        model = self.maneuvers[0].flight_model
        table = dict(zip(model.parameter_names, model.defaults, strict=True))
        for terms in (*model.control_terms.values(), *model.sensor_terms.values()):
            for term, values in terms:
                for item, value in zip(term.parameters, values, strict=True):
                    table[f"{term.id}.{item.name}"] = value
        return {name: table[name] for name in self.free}

    def _bounds(self) -> dict[str, tuple[float, float]]:
        """Return within what the parameters of effects make sense."""
        aircraft = self.maneuvers[0].record.maneuver.aircraft
        return {
            f"{effect.id}.{item.name}": item.bounds
            for effect in self.model.effects
            for item in effect.term(aircraft).parameters
        }

    def revised_model(self) -> Model:
        """Return the model with the values of the fit."""
        model = self.model
        derivatives = {name: value for name, value in self.values.items() if name in _DERIVATIVES}
        model = model.with_derivatives(derivatives)
        for effect in self.model.effects:
            prefix = f"{effect.id}."
            own = {
                name.removeprefix(prefix): value
                for name, value in self.values.items()
                if name.startswith(prefix)
            }
            if own:
                model = model.with_effect(effect.id, {**effect.parameters, **own})
        for follower, leader in self.shared_parameters().items():
            effect_id, _, parameter = follower.rpartition(".")
            effect = next(one for one in model.effects if one.id == effect_id)
            model = model.with_effect(
                effect_id, {**effect.parameters, parameter: self.values[leader]}
            )
        return model

    def shared_parameters(self) -> dict[str, str]:
        """Return held parameters of effects that follow a free one of another effect."""
        aircraft = self.maneuvers[0].record.maneuver.aircraft
        terms = [effect.term(aircraft) for effect in self.model.effects]
        return {
            f"{term.id}.{name}": f"{other.id}.{name}"
            for other in terms
            for term in terms
            if type(term) is type(other) and term is not other
            for name in term.shared_parameters
            if f"{other.id}.{name}" in self.free and f"{term.id}.{name}" not in self.free
        }

    def take_model(self, model: Model) -> None:
        """Put the values of the fit into the flight models."""
        self.model = model
        made: dict[int, FlightModel] = {}
        for one in self.maneuvers:
            aircraft = one.record.maneuver.aircraft
            if one.own_derivatives:
                own = model.with_derivatives(one.own_derivatives)
                one.flight_model = FlightModel(aircraft, own)
            else:
                one.flight_model = made.setdefault(id(aircraft), FlightModel(aircraft, model))

    def branch(self, noise: Mapping[str, NoiseModel]) -> FilterErrorFit:
        """Return a fit that goes on from here by itself, with other noise."""
        return replace(
            self,
            values=dict(self.values),
            biases=dict(self.biases),
            noise=dict(noise),
            maneuvers=[replace(one) for one in self.maneuvers],
        )

    def go_back(self, before: FilterErrorFit) -> None:
        """Return to where a branch was made, in place; the noise stays as it is."""
        self.values, self.biases = dict(before.values), dict(before.biases)
        self.take_model(before.model)
        for one, old in zip(self.maneuvers, before.maneuvers, strict=True):
            one.motion, one.filter = old.motion, old.filter
            one.filtered_columns = old.filtered_columns

    # --- one pass -------------------------------------------------------------------------------

    def bias_names(self) -> tuple[str, ...]:
        """Return the names of the free biases of the maneuvers here."""
        return tuple(
            dict.fromkeys(name for one in self.maneuvers for name in self.bias_names_of(one.record))
        )

    def bias_names_of(self, record: ManeuverRecord) -> tuple[str, ...]:
        """Return the names of the free biases of one maneuver."""
        return tuple(
            bias_name(record.flight, name) for name in record.channels if name in self.bias_stds
        )

    def priors(self) -> dict[str, tuple[float, float]]:
        """Return what is known beforehand, relative to where values and biases stand."""
        known = {
            name: (-self.biases[name], self.bias_stds[name.rpartition(".")[2]])
            for name in self.bias_names()
        }
        return known | {
            name: (value - self.values[name], std)
            for name, (value, std) in self.value_priors.items()
            if name in self.values
        }

    def linearized(self, one: ManeuverState) -> Linearization:
        """Return the model linearized along a maneuver's motion."""
        model = one.flight_model
        equations = tuple(
            name
            for name in (*self.free, *self.shared_parameters())
            if name in model.parameter_names and name not in _DERIVATIVES
        )
        return linearize_along(
            one.record,
            model,
            np.array(model.defaults),
            one.motion,
            equations,
            speed_zero=self.biases.get(bias_name(one.record.flight, "V"), 0.0),
        )

    def bias_of(self, record: ManeuverRecord) -> FloatArray:
        """Return the zero error of each channel of a maneuver; see `Linearization.zeros`."""
        return np.array([self.biases[bias_name(record.flight, name)] for name in record.channels])

    def model_columns(self, one: ManeuverState, found: Linearization) -> list[SensitivityColumn]:
        """Return the columns of the free parameters."""
        ones = np.ones(len(one.record))
        columns: list[SensitivityColumn] = []
        paths = path_columns(one.flight_model, found)
        shared = self.shared_parameters()
        for name in self.free:
            if name in paths:
                columns.append(paths[name])
            elif name in found.free:
                moved = [name, *(one for one, leader in shared.items() if leader == name)]
                columns.append(
                    tuple(SensitivityEntry(target=f"free.{one}", history=ones) for one in moved)
                )
            else:
                coefficient, _, suffix = name.partition("_")
                read = (
                    ones
                    if suffix == "0"
                    else found.variables[linear_variables(coefficient)[suffix]]
                )
                columns.append((SensitivityEntry(target=coefficient, history=read),))
        return columns

    def whitened_columns(
        self, one: ManeuverState, extra: ExtraColumns | None = None
    ) -> FilteredColumns:
        """Return free parameters, extra columns and biases, in this order, as the filter sees them.

        The maneuver's filter must be up to date.
        """
        linearization = one.current_filter.linearization
        columns = self.model_columns(one, linearization)
        if extra is not None:
            columns += extra(linearization)
        columns += [
            (
                SensitivityEntry(
                    target=f"channel.{name}", history=linearization.bias_sensitivity[:, index]
                ),
            )
            for index, name in enumerate(one.record.channels)
            if name in self.bias_stds
        ]
        return filter_columns(one.current_filter, columns, self.bias_of(one.record))

    def linearize(self) -> None:
        """Linearize along all motions as they stand, and filter with the noise as it stands."""
        for one in self.maneuvers:
            noise = self.noise[one.record.flight]
            one.filter = create_filter(self.linearized(one), noise, one.motion)

    def forget_filters(self) -> None:
        """Keep model, values and motions alone; all else takes hundreds of megabytes."""
        for one in self.maneuvers:
            one.filter = one.filtered_columns = None

    @property
    def is_linearized(self) -> bool:
        return all(one.filter is not None for one in self.maneuvers)

    def refilter(self) -> None:
        """Filter anew where only the noise changed."""
        for one in self.maneuvers:
            one.filter = one.current_filter.with_noise(self.noise[one.record.flight])

    def information(
        self, extra: tuple[tuple[str, ...], ExtraColumns] | None = None
    ) -> InformationMatrix:
        """Return the information of all maneuvers, as last filtered.

        `extra`: columns of candidates. Without them what was seen stays, for `apply_step`.
        """
        parts = (self.information_of(one, extra, keep=extra is None) for one in self.maneuvers)
        return self.sum_information(parts, () if extra is None else extra[0])

    def sum_information(
        self, parts: Iterable[InformationMatrix], extra: tuple[str, ...] = ()
    ) -> InformationMatrix:
        """Return the sum of what maneuvers say, with so many columns of candidates."""
        names = (*self.free, *extra)
        total = InformationMatrix(names=names, matrix=np.zeros((len(names) + 1,) * 2), samples=0.0)
        for one in parts:
            total = total + one
        return total

    def information_of(
        self,
        one: ManeuverState,
        extra: tuple[tuple[str, ...], ExtraColumns] | None = None,
        *,
        keep: bool = False,
    ) -> InformationMatrix:
        """Return the information of one maneuver; its filter must be up to date.

        With `keep` what was seen of it stays, for `apply_step`.
        """
        names, columns_of = ((), None) if extra is None else extra
        seen = self.whitened_columns(one, columns_of)
        if keep:
            one.filtered_columns = seen
        rows, n_local = seen.rows, seen.n_initial_states
        basis, _ = np.linalg.qr(rows[:, -1 - n_local : -1])
        rest = np.hstack((rows[:, : -1 - n_local], rows[:, -1:]))
        rest -= basis @ (basis.T @ rest)
        return InformationMatrix(
            names=(*self.free, *names, *self.bias_names_of(one.record)),
            matrix=rest.T @ rest,
            samples=float(one.current_filter.valid.sum()) - n_local,
        )

    def deviance(
        self, information: InformationMatrix | None = None, *, has_priors: bool = False
    ) -> float:
        """Return minus two log likelihoods of all innovations, as last filtered.

        `information`: that of all maneuvers, where it is known already, with the priors or without.
        """
        if information is None:
            information = self.information()
        left = information if has_priors else information.with_priors(self.priors())
        left = left.projected((*self.free, *self.bias_names()))
        sizes = sum(one.current_filter.log_determinant for one in self.maneuvers)
        return float(left.matrix[-1, -1]) + sizes

    def current_deviance(self) -> float:
        """Return the deviance of values, biases and noise as they stand, as last filtered."""
        total = sum((missing / std) ** 2 for missing, std in self.priors().values())
        for one in self.maneuvers:
            own = one.current_filter
            rows = filter_columns(own, (), self.bias_of(one.record)).rows
            basis, _ = np.linalg.qr(rows[:, :-1])
            rest = rows[:, -1] - basis @ (basis.T @ rows[:, -1])
            total += float(rest @ rest) + own.log_determinant
        return total

    # --- going on -------------------------------------------------------------------------------

    def apply_step(self, information: InformationMatrix, share: float = 1.0) -> float:
        """Move by a share to the solution of the last pass.

        Returns the largest move of the whole step over its deviation.
        """
        names = (*self.free, *self.bias_names())
        moves, covariance = information.with_priors(self.priors()).solution(names)
        by_name = dict(zip(names, share * moves, strict=True))
        for one in self.maneuvers:
            self._follow(one, by_name)
        bounds = self._bounds()
        for name in self.free:
            moved = self.values[name] + by_name[name]
            low, high = bounds.get(name, (-np.inf, np.inf))
            self.values[name] = float(min(max(moved, low), high))
        if not np.isfinite(moves).all():
            raise FlightError(DIVERGED_TEXT)
        for name in self.bias_names():
            self.biases[name] += by_name[name]
        self.take_model(self.revised_model())
        sizes = np.abs(moves) / np.sqrt(covariance.diagonal())
        return float(sizes[: len(self.free)].max()) if self.free else 0.0

    def move_biases(self, names: Sequence[str], information: InformationMatrix) -> None:
        """Move these biases alone to what the last pass says of them, and all motions with them."""
        moves, _ = information.with_priors(self.priors()).solution(names)
        by_name = dict(zip(names, moves.tolist(), strict=True))
        for one in self.maneuvers:
            self._follow(one, by_name)
        for name, move in by_name.items():
            self.biases[name] += move

    def update_motion(self) -> None:
        """Take the filter's prediction as the new motion, values as they are."""
        for one in self.maneuvers:
            self._follow(one, {})

    def _follow(self, one: ManeuverState, moves: Mapping[str, float]) -> None:
        """Move the motion of a maneuver to what the filter predicts with the moved parameters."""
        names = (*self.free, *self.bias_names_of(one.record))
        chosen = names if one.filtered_columns is not None else ()
        moved = np.array([moves.get(name, 0.0) for name in chosen])
        one.motion = predicted_motion(one, moved, self.bias_of(one.record))

    def residual_innovations(self, one: ManeuverState) -> FloatArray:
        """Return innovations (n_blocks, n_channels) as values and motion stand, not whitened."""
        z, b, _ = one.current_filter.residual(self.bias_of(one.record))
        found, _ = one.current_filter.innovations(z[:, :, None], b[:, :, None])
        return np.asarray(found[:, :, 0])
