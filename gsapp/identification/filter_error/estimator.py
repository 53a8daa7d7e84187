"""The filter-error method: derivatives and process noise together, by maximum likelihood.

The problem is laid out as for output error: the same states, responses, free parameters and
biases. In place of a trajectory that runs free, a steady-state Kalman filter predicts; its
innovations weigh turbulence and instruments as the data ask for (R. E. Maine and K. W. Iliff,
AGARD-AG-300-3 and NASA RP-1077; R. V. Jategaonkar, Flight Vehicle System Identification,
chapter 5). Gusts are translational and rotational (MIL-F-8785C).
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.channel_faults import suspicious_signs
from gsapp.identification.estimate_corrections import AssumedConstant, estimate_with_constants
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit, InformationMatrix
from gsapp.identification.filter_error.maneuver_state import ManeuverState, turbulent_motion
from gsapp.identification.filter_error.motion_linearization import ManeuverRecord
from gsapp.identification.filter_error.noise_model import (
    GUSTS,
    ROTATIONS,
    NoiseModel,
    initial_noise,
)
from gsapp.identification.filter_error.noise_tuning import common_correlation, tune_noise
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.output_error_fit import (
    equation_error_values,
    initial_unknowns,
)
from gsapp.identification.maximum_likelihood.problem import EstimationProblem, ManeuverProblem
from gsapp.identification.maximum_likelihood.problem_builder import build_problem
from gsapp.identification.maximum_likelihood.settings import MLSettings
from gsapp.identification.memory_allocator import retain_freed_memory
from gsapp.identification.motion import MeasuredMotion
from gsapp.identification.results import DerivativeEstimate, Estimate, ResponseHistory
from gsapp.identification.statistics import (
    ManeuverFitData,
    assess_identifiability,
    correlation_warning,
    joint_covariance,
    response_fit,
)
from gsapp.identification.statistics.bounds import invert_information
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import DEGREE


def estimate(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    *,
    assumed: Mapping[str, AssumedConstant] = MappingProxyType({}),
) -> Estimate:
    """Estimate derivatives from one maneuver, or from several in one joint fit.

    `settings`: as of maximum likelihood; scale factors, time shifts and weights do not apply.
    `assumed`: constants for channels that were not measured; their error goes into the bounds.

    Raises `FlightError` if the maneuvers hold too little to fit anything.
    """
    return estimate_with_constants(
        lambda values: _fit(maneuvers, settings.with_stand_ins(values)), assumed
    )


def _fit(maneuvers: Sequence[Maneuver], settings: MLSettings) -> Estimate:
    steps = solve_stepwise(maneuvers, settings)
    while True:
        try:
            next(steps)
        except StopIteration as done:
            solution: FilterErrorSolution = done.value
            return solution.estimate


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FilterErrorSolution:
    """A finished fit with all that predictions of bounds need."""

    names: tuple[str, ...]
    """All unknowns: derivatives, parameters of effects, then biases and initial states."""
    values: Mapping[str, float]
    """Of derivatives and parameters of effects."""
    information: FloatArray
    covariance: FloatArray
    """Shape (n_names, n_names). Infinite variances where the data do not see a parameter."""
    noise: Mapping[str, NoiseModel]
    """Of each flight."""
    estimate: Estimate

    def value(self, name: str) -> float:
        """Return a derivative, or a parameter of an effect."""
        return self.values[name]


def solve_stepwise(
    maneuvers: Sequence[Maneuver], settings: MLSettings
) -> Generator[None, None, FilterErrorSolution]:
    """Fit in steps of some ten milliseconds.

    Raises `FlightError` if the maneuvers hold too little to fit anything.
    """
    retain_freed_memory()
    problem = build_problem(maneuvers, settings)
    fit = create_fit(problem, settings)
    yield
    fit, passes, settled = yield from _converge(fit)
    return _solution(problem, fit, settings, passes, settled=settled)


def predict_stepwise(
    maneuver: Maneuver,
    settings: MLSettings,
    noise: NoiseModel,
    random: np.random.Generator | None = None,
) -> Generator[None, None, FilterErrorSolution]:
    """Find what a fit would report with values as they start and noise as known, in steps.

    `random`: for a planned maneuver, to whose motion turbulence of this noise is added.

    Raises `FlightError` as `solve_stepwise` does.
    """
    problem = build_problem([maneuver], settings)
    fit = create_fit(problem, settings)
    for flight, own in fit.noise.items():
        fit.noise[flight] = replace(noise, variances={**own.variances, **noise.variances})
    yield
    fit.linearize()
    if random is not None:
        for one in fit.maneuvers:
            one.motion = turbulent_motion(one, fit.noise[one.record.flight], random)
        fit.linearize()
    for _ in range(FILTER_ERROR.prediction_rounds if random is None else 0):
        fit.update_motion()
        fit.linearize()
        yield
    return _solution(problem, fit, settings, 0, settled=True)


def _solution(
    problem: EstimationProblem,
    fit: FilterErrorFit,
    settings: MLSettings,
    passes: int,
    *,
    settled: bool,
) -> FilterErrorSolution:
    result = _Result(problem, fit, settings)
    if not passes:
        result.take_step()
    return FilterErrorSolution(
        names=tuple(result.names),
        values=dict(fit.values),
        information=result.information,
        covariance=result.covariance,
        noise=dict(fit.noise),
        estimate=result.estimate(passes, settled),
    )


def create_fit(problem: EstimationProblem, settings: MLSettings) -> FilterErrorFit:
    """Return a fit of a problem that starts from equation error."""
    names = problem.names.all
    quick: Mapping[str, float] = {}
    if not settings.start.keys() >= {*names}:
        quick = equation_error_values([one.maneuver for one in problem.parts], settings, problem)
    start = dict(zip(names, initial_unknowns(problem, settings, quick).tolist(), strict=False))
    records = [_records(one) for one in problem.parts]
    every = [record for own in records for record in own]
    guessed = {
        flight: initial_noise([one for one in every if one.flight == flight])
        for flight in dict.fromkeys(one.flight for one in every)
    }
    # What gusts do to vanes and accelerometers looks like colored noise; gyros tell what is.
    noise = {
        flight: replace(
            one,
            correlations=common_correlation(one),
            gust_intensities=(FILTER_ERROR.start_gust_intensity,) * 3,
            moment_intensity=FILTER_ERROR.start_moment_intensity,
            rotation_intensities=(
                FILTER_ERROR.initial_rotation_intensity,
                *(FILTER_ERROR.start_gradient_intensity,) * 2,
            ),
            gradient_gains=(1.0, 1.0),
        )
        for flight, one in guessed.items()
    }
    model = _started_model(settings.model or Model(), {**settings.held, **start})
    fit = FilterErrorFit.create(every, model, names, noise)
    free_biases = {one.responses[row] for one in problem.parts for row in one.biases}
    fit.bias_stds = dict.fromkeys(free_biases, np.inf)
    fit.value_priors = settings.priors
    own = [_own_derivatives(one, model) for one in problem.parts for _ in one.segments]
    for state, fixed in zip(fit.maneuvers, own, strict=True):
        state.own_derivatives = fixed
    fit.take_model(fit.model)
    return fit


def _started_model(model: Model, values: Mapping[str, float]) -> Model:
    """Return a model with start values and held ones, those of effects included."""
    derivatives = {name: value for name, value in values.items() if "." not in name}
    model = model.with_derivatives(derivatives)
    for effect in model.effects:
        prefix = f"{effect.id}."
        own = {
            name.removeprefix(prefix): value
            for name, value in values.items()
            if name.startswith(prefix)
        }
        if own:
            model = model.with_effect(effect.id, {**effect.parameters, **own})
    return model


def _own_derivatives(one: ManeuverProblem, model: Model) -> dict[str, float]:
    """Return the derivatives that this maneuver alone has: forces as measured."""
    base = dict(zip(one.model.parameter_names, one.base.tolist(), strict=True))
    return {
        name: base[name]
        for name in axis_derivatives("both")
        if name not in one.names.all and base[name] != model.derivative(name)
    }


def _records(one: ManeuverProblem) -> list[ManeuverRecord]:
    """Return the segments of a maneuver."""
    count = len(one.fixed_initial[0])
    found = []
    for segment in one.segments:
        part, motion = segment.sample_slice, one.motion
        cut = MeasuredMotion(
            times=motion.times[part],
            states=motion.states[part],
            inputs=motion.inputs[part],
            measured=motion.measured,
            interpolated={name: flags[part] for name, flags in motion.interpolated.items()},
            remarks=motion.remarks,
        )
        block = one.maneuver.block
        found.append(
            ManeuverRecord(
                maneuver=replace(
                    one.maneuver,
                    block=Block(
                        channels=block.channels,
                        times=block.times[part],
                        values=block.values[part],
                    ),
                ),
                motion=cut,
                dt=one.dt,
                channels=one.responses,
                measured=np.ascontiguousarray(segment.measured.T),
                valid=np.ascontiguousarray(segment.valid.T),
                states=one.trajectory_solver.kernel.state_names[:count],
            )
        )
    return found


def _converge(
    fit: FilterErrorFit,
) -> Generator[None, None, tuple[FilterErrorFit, int, bool]]:
    """Fit values and noise in turn; return the likeliest fit, its passes and whether it settled.

    Gusts that differ along the aircraft rotate the air: in nature (gain 1) and by the standard. In
    many a simulation they do not (0), or with the sign that some editions of the standard give
    (-1); what vanes ahead of the CG show of it shows in all derivatives. All are compared where
    values and noise have settled: before, one that is far off can be the likeliest. So are the
    two lengths over which editions of the standard let the air roll.
    """
    start = fit.noise
    best = fit.branch(start)
    try:
        passes, settled = yield from _settle(best)
    except FlightError:  # It diverged: begin with air that does not turn.
        best = fit.branch(
            {flight: replace(one, gradient_gains=(0.0, 0.0)) for flight, one in start.items()}
        )
        passes, settled = yield from _settle(best)
    found = _Settled(best, passes, settled, best.deviance())
    for axis, gust in enumerate("wv"):
        settled_gain = next(iter(found.fit.noise.values())).gradient_gains[axis]
        for gain in (1.0, 0.0, -1.0) if _meets(found.fit, gust) else ():
            if gain != settled_gain:
                gains = {
                    flight: _replaced(one.gradient_gains, axis, gain)
                    for flight, one in found.fit.noise.items()
                }
                found = yield from _likelier(
                    found,
                    {
                        flight: replace(one, gradient_gains=gains[flight])
                        for flight, one in start.items()
                    },
                )
    if _meets(found.fit, "p"):
        long = {
            flight: replace(one, roll_length=FILTER_ERROR.long_roll)
            for flight, one in found.fit.noise.items()
        }
        found = yield from _likelier(found, long)
    return found.fit, found.passes, found.is_settled


class _Settled(NamedTuple):
    fit: FilterErrorFit
    passes: int
    is_settled: bool
    deviance: float


def _likelier(best: _Settled, noise: Mapping[str, NoiseModel]) -> Generator[None, None, _Settled]:
    """Return the fit that goes on from the best one with other noise, if it is likelier."""
    trial = best.fit.branch(noise)
    try:
        passes, settled = yield from _settle(trial, beat=best.deviance)
        found = _Settled(trial, passes, settled, trial.deviance())
    except FlightError:  # It diverged: air does not turn like that.
        return best
    return found if found.deviance < best.deviance else best


def _meets(fit: FilterErrorFit, gust: str) -> bool:
    """Return whether any maneuver meets gusts along an axis."""
    return any(
        gust in one.current_filter.blocks.gusts.names
        and fit.noise[one.record.flight].value(f"gust.{gust}") > FILTER_ERROR.negligible_gust
        for one in fit.maneuvers
    )


def _replaced(gains: tuple[float, float], axis: int, gain: float) -> tuple[float, float]:
    return (gain, gains[1]) if axis == 0 else (gains[0], gain)


def _settle(fit: FilterErrorFit, beat: float = np.inf) -> Generator[None, None, tuple[int, bool]]:
    """Fit values and noise in turn, in place; return the number of passes and whether it settled.

    It ends early where the deviance will not fall below `beat`. Ends filtered with the noise and
    values that it found.
    """
    settled = False
    number, before = 0, np.inf
    fit.linearize()
    for number in range(1, FILTER_ERROR.max_passes + 1):
        last = fit.noise
        if number > 1:
            fit.noise = dict(last)
            tune_noise(fit, rounds=FILTER_ERROR.noise_rounds)
        information = fit.information()
        deviance = fit.deviance(information)
        if number >= FILTER_ERROR.min_passes:
            still = FILTER_ERROR.remaining_falls * max(before - deviance, 0.0)
            if deviance - still > beat:
                break
        before = deviance
        move = _descend(fit, information)
        settled = (
            number > FILTER_ERROR.min_passes
            and move < FILTER_ERROR.settled_step
            and _noise_change(last, fit.noise) < FILTER_ERROR.settled_noise
        )
        yield
        if settled:
            break
    return number, settled


def _descend(fit: FilterErrorFit, information: InformationMatrix) -> float:
    """Take a step, in place, that does not raise the deviance; return its whole length.

    The filter's gain moves with the values, which a Gauss-Newton step does not see: far from the
    solution, and in strong gusts, whole steps can lead ever farther away. Length: the largest move
    over its deviation.
    """
    least = fit.current_deviance()
    here = fit.branch(fit.noise)
    share, move = 1.0, 0.0
    for _ in range(FILTER_ERROR.max_halvings):
        try:
            move = fit.apply_step(information, share)
            fit.linearize()
            if fit.current_deviance() <= least + FILTER_ERROR.allowed_rise:
                break
        except FlightError:
            pass
        fit.go_back(here)
        share *= 0.5
    return move


def _noise_change(before: Mapping[str, NoiseModel], after: Mapping[str, NoiseModel]) -> float:
    """Return the largest logarithm of the ratio by which gusts in the filter changed."""
    return max(
        abs(float(np.log(one.value(f"gust.{name}") / before[flight].value(f"gust.{name}"))))
        if one.value(f"gust.{name}") > FILTER_ERROR.negligible_gust
        else 0.0
        for flight, one in after.items()
        for name in (*GUSTS, *ROTATIONS)
    )


class _Result:
    """The estimate that a settled fit gives."""

    def __init__(
        self, problem: EstimationProblem, fit: FilterErrorFit, settings: MLSettings
    ) -> None:
        self.problem, self.fit, self.settings = problem, fit, settings
        self.shared = problem.names.all
        self.names = [*self.shared, *fit.bias_names()]
        self.parts: list[ManeuverFitData] = []
        self.information = np.zeros((0, 0))
        for one in fit.maneuvers:
            self._add(one)
        self.information = self.information + self._prior()

    def _add(self, one: ManeuverState) -> None:
        """Add a segment: whitened innovations, and what each parameter changes in them."""
        seen = self.fit.whitened_columns(one)
        own = self.fit.bias_names_of(one.record)
        columns = [*range(len(self.shared)), *(self.names.index(name) for name in own)]
        first = len(self.names)
        self.names += [f"{one.record.id}.initial.{k}" for k in range(seen.n_initial_states)]
        columns += range(first, len(self.names))
        self.information = np.pad(self.information, (0, len(self.names) - len(self.information)))
        rows = seen.rows[:, :-1]
        self.information[np.ix_(columns, columns)] += rows.T @ rows
        valid = one.current_filter.valid
        self.parts.append(
            ManeuverFitData(
                S=seen.innovations[:, :, :-1],
                v=np.where(valid, seen.innovations[:, :, -1], np.nan),
                W=np.eye(valid.shape[1]),
                columns=np.array(columns, dtype=np.intp),
            )
        )

    def take_step(self) -> None:
        """Leave in the innovations what the best straight step leaves over, as a fit does."""
        side = np.zeros(len(self.names))
        every = np.arange(len(self.names))
        for part in self.parts:
            columns = every if part.columns is None else part.columns
            side[columns] += np.einsum("krm,kr->m", part.S, np.nan_to_num(part.v))
        scale = np.sqrt(np.maximum(self.information.diagonal(), np.finfo(float).tiny))
        moves = np.linalg.lstsq(self.information / scale[:, None] / scale, side / scale)[0] / scale
        self.parts = [
            replace(
                part, v=part.v - part.S @ moves[every if part.columns is None else part.columns]
            )
            for part in self.parts
        ]

    def _prior(self) -> FloatArray:
        prior = np.zeros(len(self.names))
        for name, (_, std) in self.fit.priors().items():
            prior[self.names.index(name)] = std**-2
        return np.diag(prior)

    @cached_property
    def covariance(self) -> FloatArray:
        """Return the honest covariance; infinite variances for what is not seen."""
        prior = self._prior()
        plain = invert_information(self.information)
        honest = joint_covariance(
            self.parts, len(self.names), lags=self.settings.lags,
            prior=prior if prior.any() else None,
        )  # fmt: skip
        # Innovations of a few seconds tell little of their own color: no bound below Cramer-Rao.
        low, high = honest.diagonal(), plain.diagonal()
        known = np.isfinite(low) & np.isfinite(high) & (low > 0.0)
        growth = np.ones(len(low))
        growth[known] = np.sqrt(np.maximum(high[known] / low[known], 1.0))
        return np.asarray(honest * growth[:, None] * growth)

    def estimate(self, passes: int, settled: bool) -> Estimate:
        plain, honest = invert_information(self.information), self.covariance
        verdicts = assess_identifiability(
            self.information, self.names, covariance=honest, inverted=plain
        )
        first = self.problem.parts[0]
        held = dict(zip(first.model.parameter_names, first.base, strict=True))
        derivatives: dict[str, DerivativeEstimate] = {}
        for name in dict.fromkeys((*axis_derivatives(self.settings.axis), *self.shared)):
            if name in self.problem.unexcited:
                derivatives[name] = DerivativeEstimate(
                    value=None, status="unknown", why=self.problem.unexcited[name]
                )
            elif name not in self.shared:
                derivatives[name] = DerivativeEstimate(value=float(held[name]), status="held")
            elif verdicts[name].status != "estimated":
                derivatives[name] = DerivativeEstimate(
                    value=None,
                    status=verdicts[name].status,
                    confounded_with=verdicts[name].confounded_with,
                    why=verdicts[name].why,
                )
            else:
                row = self.names.index(name)
                derivatives[name] = DerivativeEstimate(
                    value=self.fit.values[name],
                    std=float(np.sqrt(honest[row, row])),
                    cramer_rao=float(np.sqrt(plain[row, row])),
                )
        free = tuple(name for name in self.shared if derivatives[name].status == "estimated")
        rows = [self.names.index(name) for name in free]
        histories = self._histories()
        found = Estimate(
            method="fem",
            axis=self.settings.axis,
            maneuvers=tuple(one.id for one in self.problem.parts),
            derivatives=derivatives,
            free=free,
            covariance=honest[np.ix_(rows, rows)],
            fit={
                name: response_fit(
                    *(
                        np.concatenate([getattr(one, what)[:, one.channels.index(name)]
                                        for one in histories if name in one.channels])
                        for what in ("measured", "computed")
                    )
                )
                for name in dict.fromkeys(name for one in histories for name in one.channels)
            },
            histories=histories,
            iterations=passes,
            converged=settled,
            message="" if settled else f"values or noise still moved after {passes} passes",
        )  # fmt: skip
        pairs = [
            pair for pair in verdicts.correlated
            if pair[0] in self.shared and pair[1] in self.shared and "_0" not in pair[0] + pair[1]
        ]  # fmt: skip
        warnings = [*suspicious_signs(found), *self.problem.remarks, *self._turbulence_texts()]
        warnings += [correlation_warning(pairs)] if pairs else []
        return replace(found, warnings=tuple(dict.fromkeys(warnings)))

    def _histories(self) -> tuple[ResponseHistory, ...]:
        """Return measured responses and those that the filter predicts."""
        found = []
        for one in self.problem.parts:
            own = [state for state in self.fit.maneuvers if state.record.id == one.id]
            found.append(
                ResponseHistory(
                    maneuver=one.id,
                    times=np.concatenate([state.record.motion.times for state in own]),
                    channels=one.responses,
                    measured=np.concatenate(
                        [np.where(s.record.valid, s.record.measured, np.nan) for s in own]
                    ),
                    computed=np.concatenate(
                        [
                            s.current_filter.blocks.computed
                            + self.fit.bias_of(s.record)
                            * s.current_filter.linearization.bias_sensitivity
                            for s in own
                        ]
                    ),
                )
            )
        return tuple(found)

    def _turbulence_texts(self) -> list[str]:
        """Return how strong the gusts are that each flight met."""
        found = []
        for flight, noise in self.fit.noise.items():
            own = [one for one in self.fit.maneuvers if one.record.flight == flight]
            gusts = own[0].current_filter.blocks.gusts.names
            V = float(np.mean([one.current_filter.blocks.V for one in own]))
            span = own[0].record.maneuver.aircraft.geometry.span
            sizes = noise.gust_rms(V)
            parts = [
                f"{sizes[name]:.2g} m/s along {axis}"
                for name, axis in zip("uvw", "xyz", strict=True)
                if name in gusts and sizes[name] > FILTER_ERROR.min_reported_gust
            ]
            turning = noise.rotation_rms(V, span)
            parts += [
                f"{turning[name] / DEGREE:.2g} deg/s about {axis}"
                for name, axis in zip("pqr", "xyz", strict=True)
                if name in gusts and turning[name] > FILTER_ERROR.min_reported_rotation
            ]
            if parts:
                found.append(f"turbulence: {', '.join(parts)}")
        return found
