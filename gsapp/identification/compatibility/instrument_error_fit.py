"""Errors common to all stretches, with a start for each, by Gauss-Newton."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.identification.compatibility.instrument_prediction import (
    INITIAL_STATE_NAMES,
    InitialState,
    Prediction,
    channel_sensitivities,
    estimate_accelerometer_bias,
    estimate_initial_state,
    predict_channels,
)
from gsapp.identification.compatibility.kalman_predictor import (
    ErrorStateModel,
    NoiseLevels,
    SteadyKalmanGain,
    block_average,
    build_error_state_model,
    estimate_noise_levels,
    kalman_gain_pair,
    neg2_log_likelihood,
    samples_per_average,
    whiten_residuals,
)
from gsapp.identification.compatibility.segments import CompatibilitySegment
from gsapp.identification.compatibility.settings import (
    ACCELERATION_CHANNELS,
    COMPATIBILITY,
    CompatibilitySettings,
)
from gsapp.identification.statistics import ManeuverFitData, joint_covariance
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SegmentFit:
    """One stretch of a fit."""

    segment: CompatibilitySegment
    initial_state: InitialState
    prediction: Prediction
    error_model: ErrorStateModel
    noise: NoiseLevels
    gain: SteadyKalmanGain
    innovations: FloatArray
    """Shape (m, n_channels). What the predictor leaves of the averaged residuals."""
    observable: frozenset[str]
    clearly_observable: frozenset[str]
    """Scales and delays of vanes that the stretch has a say in; those seen through all noise."""
    S: FloatArray  # Shape (m, n_channels, n_free + 5). The same of the sensitivities.

    def residuals(self) -> FloatArray:
        """Return measured minus computed, shape (n, n_channels)."""
        shown = np.column_stack([self.segment.outputs[name] for name in self.prediction.channels])
        return np.asarray(shown - self.prediction.computed, dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InstrumentErrorFit:
    """A fit to all stretches."""

    free: tuple[str, ...]  # Errors estimated.
    errors: Mapping[str, float]  # Values, scales as factors.
    covariance: FloatArray  # Shape (n_free, n_free).
    segments: tuple[SegmentFit, ...]
    origin: FloatArray  # Shape (n_free + 5 n_stretches,). How far errors and starts have moved.
    neg2_log_likelihood: float
    """Twice the negative log-likelihood, errors weighed by what is plausible."""
    iterations: int
    converged: bool
    step: float
    """The largest that errors and starts were about to move, in their bounds, when it ended."""

    def std(self, name: str) -> float:
        """Return the bound of a free error."""
        index = self.free.index(name)
        return float(np.sqrt(max(self.covariance[index, index], 0.0)))

    def rms(self, channel: str) -> float:
        """Return the residual of one channel, rms over all stretches; SI."""
        parts = [
            one.residuals()[:, one.prediction.channels.index(channel)]
            for one in self.segments
            if channel in one.prediction.channels
        ]
        return float(np.sqrt(np.nanmean(np.concatenate(parts) ** 2))) if parts else np.nan


def free_errors(settings: CompatibilitySettings, channels: Sequence[str]) -> tuple[str, ...]:
    """Return those of the errors to be estimated whose instrument is there."""
    return tuple(name for name in settings.free if name.partition(".")[0] in channels)


def nominal_value(name: str) -> float:
    """Return what an error is for a faultless instrument."""
    return 1.0 if name.endswith(".scale") else 0.0


def fit_instrument_errors(
    stretches: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    free: Sequence[str],
    *,
    noises: Sequence[NoiseLevels] | None = None,
    iterations: int | None = None,
    bounds: bool = True,
    begin: InstrumentErrorFit | None = None,
) -> InstrumentErrorFit:
    """Fit errors and starts.

    Parameters
    ----------
    noises : sequence of NoiseLevels, optional
        Of the stretches, held; by default the likeliest are looked for.
    iterations : int, optional
        In place of the settings'.
    bounds : bool
        Whether the covariance is corrected for what color is left; it takes as long as a step.
    begin : InstrumentErrorFit, optional
        Of the same stretches; errors free in both begin at its values.
    """
    most = settings.iterations if iterations is None else iterations
    free = tuple(free)
    plausible = np.array([settings.plausible_size(name) for name in free])
    known = {} if begin is None else begin.errors
    errors = {name: known.get(name, nominal_value(name)) for name in free}
    starts = (
        [estimate_initial_state(stretch, errors) for stretch in stretches]
        if begin is None
        else [part.initial_state for part in begin.segments]
    )
    chosen, phase = _first_noises(stretches, noises, begin)
    size = len(free) + len(INITIAL_STATE_NAMES) * len(stretches)
    prior = np.zeros(size)
    prior[: len(free)] = 1.0 / plausible**2
    prior[len(free) :] = np.tile(
        [1.0 / COMPATIBILITY.initial_speed_std**2] * 3
        + [1.0 / COMPATIBILITY.initial_rotation_std**2] * 2,
        len(stretches),
    )
    origin = _continued_origin(begin, free, size)
    if begin is None:
        guess = np.mean(
            [
                estimate_accelerometer_bias(one, start)
                for one, start in zip(stretches, starts, strict=True)
            ],
            axis=0,
        )
        for axis, name in enumerate(ACCELERATION_CHANNELS):
            if (label := f"{name}.bias") in free:
                largest = settings.plausible_size(label)
                errors[label] = float(np.clip(guess[axis], -largest, largest))
                origin[free.index(label)] = errors[label]
        starts = [estimate_initial_state(stretch, errors) for stretch in stretches]
    number, calm, converged = 0, 0, False
    parts: list[SegmentFit] = []
    seen: list[frozenset[str] | None] = [None] * len(stretches)
    least, halved = np.inf, 0
    full, share = np.zeros(size), 1.0
    look, step, before = False, np.zeros(size), (errors, starts, origin)
    while True:
        latest = [
            _linearize_segment(stretch, settings, errors, start, free, noise, look=look, seen=known)
            for stretch, start, noise, known in zip(stretches, starts, chosen, seen, strict=True)
        ]
        sound = [one for one in latest if one is not None]
        cost = _cost(sound, prior, origin) if len(sound) == len(latest) else np.inf
        if (
            not cost <= COMPATIBILITY.max_cost_growth * least
            and (np.isinf(cost) or not look)
            and halved < COMPATIBILITY.max_halvings
        ):
            # The step led too far: a part of it may not.
            if not parts:
                return _diverged_fit(free, before, parts, number)
            number, halved, step = number + 1, halved + 1, 0.25 * step
            errors, starts, origin = _apply_step(free, before, step)
            continue
        if np.isinf(cost):
            return _diverged_fit(free, before, parts, number)
        parts, least, halved = sound, cost, 0
        chosen = [part.noise for part in parts]
        if phase >= COMPATIBILITY.max_noise_updates:
            seen = [part.observable for part in parts]
        H, g = _normal_equations(parts, len(free), prior, origin)
        covariance = _inverse(H)
        step = covariance @ g
        size_of_step = float((np.abs(step) / np.sqrt(covariance.diagonal())).max())
        if converged or number >= most:
            break
        number += 1
        calm += 1
        look = phase < COMPATIBILITY.max_noise_updates and (
            size_of_step < COMPATIBILITY.noise_update_step
            or calm >= COMPATIBILITY.noise_update_interval
        )
        if look:
            phase, calm = phase + 1, 0
        converged = (
            phase >= COMPATIBILITY.max_noise_updates
            and not look
            and size_of_step < COMPATIBILITY.step_tolerance
        )
        # Where delays change which noise counts, full steps may go to and fro for ever.
        full, last = step, full
        share = (
            0.5 * share
            if phase >= COMPATIBILITY.max_noise_updates
            and _reverses_last_step(full, last, covariance)
            else share
        )
        step = _limit_step(share * full, free, errors)
        before = (errors, starts, origin)
        errors, starts, origin = _apply_step(free, before, step)
    likely = sum(
        float(neg2_log_likelihood(part.innovations[None], part.gain.covariance[None])[0])
        for part in parts
    )
    if bounds:
        covariance = joint_covariance(
            [
                ManeuverFitData(
                    S=part.S,
                    v=part.innovations,
                    W=part.gain.weight,
                    columns=_columns(index, len(free)),
                )
                for index, part in enumerate(parts)
            ],
            size,
            prior=np.diag(prior),
        )
    return InstrumentErrorFit(
        free=free,
        errors=errors,
        covariance=covariance[: len(free), : len(free)],
        segments=tuple(parts),
        origin=origin,
        neg2_log_likelihood=likely + float(prior @ origin**2),
        iterations=number,
        converged=converged,
        step=size_of_step,
    )


def _first_noises(
    stretches: Sequence[CompatibilitySegment],
    noises: Sequence[NoiseLevels] | None,
    begin: InstrumentErrorFit | None,
) -> tuple[list[NoiseLevels], int]:
    """Return the noise to begin with, and how many of its updates are over."""
    if noises is not None:
        return list(noises), COMPATIBILITY.max_noise_updates
    if begin is not None:
        # Noise that was found once needs one look more.
        return [part.noise for part in begin.segments], COMPATIBILITY.max_noise_updates - 1
    return [NoiseLevels.white(len(one.outputs)) for one in stretches], 0


def _continued_origin(
    begin: InstrumentErrorFit | None, free: Sequence[str], size: int
) -> FloatArray:
    """Return how far errors and starts have moved already."""
    origin = np.zeros(size)
    if begin is not None:
        moved = dict(zip(begin.free, begin.origin, strict=False))
        origin[: len(free)] = [moved.get(name, 0.0) for name in free]
        origin[len(free) :] = begin.origin[len(begin.free) :]
    return origin


def _reverses_last_step(step: FloatArray, last: FloatArray, covariance: FloatArray) -> bool:
    variance = covariance.diagonal()
    return bool((step * last / variance).sum() < -0.5 * (last**2 / variance).sum())


_FitState = tuple[dict[str, float], list[InitialState], FloatArray]


def _apply_step(free: Sequence[str], before: _FitState, step: FloatArray) -> _FitState:
    """Return errors, starts and how far they have moved in all after a step."""
    errors, starts, origin = before
    return (
        {name: errors[name] + float(change) for name, change in zip(free, step, strict=False)},
        [
            start.perturbed(step[_columns(index, len(free))[len(free) :]])
            for index, start in enumerate(starts)
        ],
        origin + step,
    )


def _cost(parts: Sequence[SegmentFit], prior: FloatArray, origin: FloatArray) -> float:
    """Return the sum of squares that a step makes smaller."""
    total = float(prior @ origin**2)
    for part in parts:
        left = np.nan_to_num(part.innovations)
        total += float(np.sum((left @ part.gain.weight) * left))
    return total


def _normal_equations(
    parts: Sequence[SegmentFit], shared: int, prior: FloatArray, origin: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the information matrix and the gradient."""
    H: FloatArray = np.diag(prior)
    g: FloatArray = -prior * origin
    for index, part in enumerate(parts):
        columns = _columns(index, shared)
        S, left = _mask_sensitivities(part.S, part.innovations), np.nan_to_num(part.innovations)
        flat = S.reshape(-1, S.shape[2])
        weighted: FloatArray = (part.gain.weight @ S).reshape(flat.shape)
        H[np.ix_(columns, columns)] += flat.T @ weighted
        g[columns] += weighted.T @ left.ravel()
    return H, g


def _inverse(H: FloatArray) -> FloatArray:
    scale = 1.0 / np.sqrt(H.diagonal())
    inverted = np.linalg.inv(H * scale * scale[:, None] + COMPATIBILITY.ridge * np.eye(len(H)))
    return np.asarray(inverted * scale * scale[:, None], dtype=np.float64)


def likelihood_gains(
    found: InstrumentErrorFit, settings: CompatibilitySettings, candidates: Sequence[str]
) -> dict[str, float]:
    """Return by how much twice the log-likelihood would rise, were each error free beside others.

    The score test: one linear step from the fit that is there, the noise held.
    """
    free = (*found.free, *candidates)
    held, starts = len(found.free), len(free)
    size = starts + len(INITIAL_STATE_NAMES) * len(found.segments)
    prior, origin = np.zeros(size), np.zeros(size)
    prior[:starts] = [1.0 / settings.plausible_size(name) ** 2 for name in free]
    prior[starts:] = 1e-6
    origin[:held] = found.origin[:held]
    parts = [
        _linearize_segment(
            one.segment, settings, found.errors, one.initial_state, free, one.noise, look=False
        )
        for one in found.segments
    ]
    sound = [one for one in parts if one is not None]
    if len(sound) < len(parts):
        return dict.fromkeys(candidates, 0.0)
    H, g = _normal_equations(sound, starts, prior, origin)
    base = [*range(held), *range(starts, size)]
    C = _inverse(H[np.ix_(base, base)])
    gains = {}
    for own, name in enumerate(candidates, start=held):
        shared = H[base, own]
        information = H[own, own] - shared @ C @ shared
        score = g[own] - shared @ C @ g[base]
        gains[name] = float(score**2 / information) if information > 0.0 else 0.0
    return gains


def _diverged_fit(
    free: tuple[str, ...], before: _FitState, parts: Sequence[SegmentFit], number: int
) -> InstrumentErrorFit:
    """Return the last state of a fit before it left all bounds; no stretches if it had none."""
    errors, _, origin = before
    return InstrumentErrorFit(
        free=free,
        errors=errors,
        covariance=np.full((len(free), len(free)), np.inf),
        segments=tuple(parts),
        origin=origin,
        neg2_log_likelihood=np.inf,
        iterations=number,
        converged=False,
        step=np.inf,
    )


def _columns(place: int, shared: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    first = shared + len(INITIAL_STATE_NAMES) * place
    return np.concatenate((np.arange(shared), np.arange(first, first + len(INITIAL_STATE_NAMES))))


def _mask_sensitivities(S: FloatArray, left: FloatArray) -> FloatArray:
    return np.asarray(np.where(np.isfinite(left)[:, :, None], S, 0.0), dtype=np.float64)


def at_limit(name: str, value: float) -> bool:
    """Return whether the fit stopped a delay where it may go no further: then it is no estimate."""
    return name.endswith(".delay") and abs(value) > 0.999 * COMPATIBILITY.max_delay


def _limit_step(step: FloatArray, free: Sequence[str], errors: Mapping[str, float]) -> FloatArray:
    """Return the step with scales kept away from zero and delays within reason."""
    turns = np.abs(step[len(free) :].reshape(-1, len(INITIAL_STATE_NAMES))[:, 3:]).max()
    found: FloatArray = step * min(1.0, COMPATIBILITY.max_rotation_step / max(turns, 1e-300))
    for index, name in enumerate(free):
        value = errors[name] + found[index]
        if name.endswith(".scale"):
            value = min(max(value, 0.1), 10.0)
        elif name.endswith(".delay"):
            value = min(max(value, -COMPATIBILITY.max_delay), COMPATIBILITY.max_delay)
        found[index] = value - errors[name]
    return found


def _linearize_segment(
    stretch: CompatibilitySegment,
    settings: CompatibilitySettings,
    errors: Mapping[str, float],
    start: InitialState,
    free: Sequence[str],
    noise: NoiseLevels,
    *,
    look: bool,
    seen: frozenset[str] | None = None,
) -> SegmentFit | None:
    """Return a stretch with all that a step needs; None where the motion left all bounds."""
    with np.errstate(all="ignore"):
        found = predict_channels(stretch, errors, start)
    if not np.abs(found.path.velocity).max() < COMPATIBILITY.max_speed:
        return None
    shown = np.column_stack([stretch.outputs[name] for name in found.channels])
    counted = np.isfinite(shown)
    predictor = build_error_state_model(stretch, found, errors, settings.rate)
    v = block_average(shown - found.computed, counted, predictor.width)
    if look:
        noise = estimate_noise_levels(predictor, v, noise)
    S = block_average(
        channel_sensitivities(stretch, errors, start, found, free), counted, predictor.width
    )
    white = NoiseLevels.white(len(found.channels))
    chosen, calm = kalman_gain_pair(predictor, noise, white)
    with np.errstate(all="ignore"):
        left = whiten_residuals(predictor, chosen.K, v[:, :, None])[:, :, 0]
    if not np.nanmax(np.abs(left)) < COMPATIBILITY.max_speed:
        return None
    shift = v - left
    expected = block_average(shown, counted, predictor.width) - left
    levels = [
        _motion_and_noise_variances(predictor, white, calm.covariance),
        _motion_and_noise_variances(predictor, noise, chosen.covariance),
    ]
    seen, clear = _use_predicted_motion(
        S, expected, shift, found.channels, free, errors, predictor.step, levels, seen
    )
    return SegmentFit(
        segment=stretch,
        initial_state=start,
        prediction=found,
        error_model=predictor,
        noise=noise,
        gain=chosen,
        innovations=left,
        observable=seen,
        clearly_observable=clear,
        S=np.nan_to_num(whiten_residuals(predictor, chosen.K, S)),
    )


def _use_predicted_motion(
    S: FloatArray,
    expected: FloatArray,
    shift: FloatArray,
    channels: Sequence[str],
    free: Sequence[str],
    errors: Mapping[str, float],
    step: float,
    levels: Sequence[tuple[FloatArray, FloatArray]],
    frozen: frozenset[str] | None,
) -> tuple[frozenset[str], frozenset[str]]:
    """Let scale and delay of vanes see the motion as predicted, not as integrated.

    Where an aircraft hardly moves, integrated noise is all the motion there seems to be; a vane
    that does not follow it would be given a scale of zero. The prediction has had most of that
    noise taken out. Where the noise left is still not small beside the motion, the stretch has
    no say.

    Parameters
    ----------
    S : ndarray, shape (m, n_channels, n_free + 5)
        Of averages; changed.
    expected, shift : ndarray, shape (m, n_channels)
        Averages that the predictor expects, and by how much they differ from the integrated ones.
    step : float
        Between averages, s.
    levels : sequence of two pairs of ndarray, shape (n_channels,)
        Variance of what the predictor expects, and of what noise adds over one step: for white
        noise and for the noise that was found.
    frozen : frozenset of str or None
        Errors that the stretch has a say in, once that was decided.

    Returns
    -------
    seen, clear : frozenset of str
        The same by white noise, and those seen through the noise that was found, too.
    """
    moving: list[set[str]] = [set(), set()]
    seen: set[str] | frozenset[str] = moving[0] if frozen is None else frozen
    for row, name in enumerate(channels):
        scale = errors.get(f"{name}.scale", 1.0)
        ideal = (expected[:, row] - errors.get(f"{name}.bias", 0.0)) / scale
        if (label := f"{name}.scale") in free:
            motion = np.nanvar(expected[:, row]) * scale**2
            for found, (late, _), ratio in zip(
                moving, levels, COMPATIBILITY.scale_signal_to_noise, strict=True
            ):
                if motion > ratio * late[row]:
                    found.add(label)
            # Of a scale that is not seen, what it does to the mean is left.
            known = ideal if label in seen else np.full_like(ideal, np.nanmean(ideal))
            S[:, row, free.index(label)] = known
        if (label := f"{name}.delay") in free:
            column = free.index(label)
            # The integrated motion, put right backwards in time: what is shown now must not be in
            # the expectation that it is compared with.
            change = np.diff(shift[:, row], prepend=shift[:1, row])
            S[:, row, column] -= np.nan_to_num(change) / step
            motion = np.nanmean(S[:, row, column] ** 2) * step**2
            for found, (_, walked), ratio in zip(
                moving, levels, COMPATIBILITY.delay_signal_to_noise, strict=True
            ):
                if motion > ratio * walked[row]:
                    found.add(label)
            if label not in seen:
                S[:, row, column] = 0.0
    return frozenset(seen), frozenset(seen) & moving[1]


def _motion_and_noise_variances(
    predictor: ErrorStateModel, noise: NoiseLevels, covariance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return variances of what the predictor expects and of what noise adds in a step."""
    H = predictor.H.mean(axis=0)
    Q = np.einsum("d,dij->ij", noise.input_factors * predictor.input_density, predictor.process)
    late = np.maximum(covariance.diagonal() - noise.output_factors * predictor.output_variance, 0.0)
    return late, np.asarray(np.einsum("ri,ij,rj->r", H, Q, H), dtype=np.float64)


def is_motion_significant(stretch: CompatibilitySegment, channel: str, rate: float) -> bool:
    """Return whether what a gyro or accelerometer shows is motion rather than noise.

    `rate`: averages per second that are compared.
    """
    samples = stretch.inputs.get(channel)
    if samples is None or channel in stretch.absent:
        return samples is None
    width = samples_per_average(stretch, rate)
    means = block_average(samples[:, None], np.ones((samples.size, 1), dtype=bool), width)
    noise = stretch.noise[channel] ** 2 / width
    return float(np.var(means)) > COMPATIBILITY.scale_signal_to_noise[1] * noise


def scale_bounds(
    found: InstrumentErrorFit, settings: CompatibilitySettings, channels: Sequence[str]
) -> dict[str, float]:
    """Return how well the scale of each channel would be known were it free beside the others.

    Infinite where the data do not see it.
    """
    names = [f"{name}.scale" for name in channels]
    free = (*found.free, *(name for name in names if name not in found.free))
    size = len(free) + len(INITIAL_STATE_NAMES) * len(found.segments)
    H = np.zeros((size, size))
    places = np.arange(len(found.free))
    H[places, places] = 1.0 / np.array([settings.plausible_size(n) for n in found.free]) ** 2
    H[range(len(free), size), range(len(free), size)] = 1e-6
    for index, one in enumerate(found.segments):
        part = _linearize_segment(
            one.segment, settings, found.errors, one.initial_state, free, one.noise, look=False
        )
        if part is None:
            continue
        columns = _columns(index, len(free))
        S = _mask_sensitivities(part.S, part.innovations)
        for name, label in zip(channels, names, strict=True):
            if not is_motion_significant(one.segment, name, settings.rate):
                S[:, :, free.index(label)] = 0.0
        flat = S.reshape(-1, S.shape[2])
        H[np.ix_(columns, columns)] += flat.T @ (part.gain.weight @ S).reshape(flat.shape)
    bounds = {}
    for name, label in zip(channels, names, strict=True):
        own = free.index(label)
        others = [k for k in range(size) if k != own and not len(found.free) <= k < len(free)]
        information = H[own, own]
        if own < len(found.free):
            information -= 1.0 / settings.plausible_size(label) ** 2
        rest = H[np.ix_(others, others)]
        scale = 1.0 / np.sqrt(rest.diagonal())
        shared = H[others, own] * scale
        information -= shared @ np.linalg.solve(rest * scale * scale[:, None], shared)
        bounds[name] = float(information**-0.5) if information > 1e-9 else np.inf
    return bounds
